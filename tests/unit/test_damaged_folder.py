# SPDX-License-Identifier: BSD-3-Clause
"""Damaged and foreign folders: `resume` and `report` refuse them and change nothing.

Most of a small results file is room for later outputs, where a flipped bit changes nothing.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from resumed_runs import assert_same_results, entries_of, run_until

from tilth import BadInput, Model, resume, run
from tilth.cli import run_command
from tilth.output import read_checkpoint, read_results, write_checkpoint

pytestmark = pytest.mark.slow

STEP = 5
"""Of the checkpoint; two outputs (at the start and at 0.2) are before it, one is at it."""


@pytest.fixture(scope="module")
def model() -> Model:
    return Model.from_dict(entries_of())


@pytest.fixture(scope="module")
def stopped(model: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("stopped") / "out"
    with pytest.MonkeyPatch.context() as patch:
        run_until(model, folder, STEP, patch)
    assert len(read_results(folder / "results.vtkhdf")) >= 2
    return folder


@pytest.fixture
def folder(stopped: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(stopped, tmp_path / "out"))


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def refused(folder: Path, file: str, says: str, capfd: pytest.CaptureFixture[str]) -> None:
    """`resume` ends with exit code 2 and one message, and no byte changes."""
    before = contents(folder)
    assert run_command(["resume", str(folder), "--quiet"]) == 2
    out, error = capfd.readouterr()
    assert out == ""
    assert str(folder / file) in error
    assert says in error
    assert len(error.splitlines()) >= 2, "a remedy is on the second line"
    assert "Traceback" not in error
    assert "Warning" not in error
    assert contents(folder) == before


def test_files_that_are_missing_or_cut(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    good = contents(folder)
    for file, length, says in (
        ("history.csv", 200, "the row of step"),
        ("history.csv", 0, "columns"),
        ("results.vtkhdf", 3000, "results.vtkhdf"),
        ("results.vtkhdf", 0, "cannot be read as HDF5"),
        ("checkpoint.npz", 3000, "damaged"),
        ("model.json", 100, "cannot be read"),
    ):
        (folder / file).write_bytes(good[file][:length])
        refused(folder, file, says, capfd)
        (folder / file).unlink()
        refused(folder, file, "", capfd)
        (folder / file).write_bytes(good[file])


def test_results_without_an_output_or_of_another_run(
    model: Model, folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    from tilth.output import ResultsWriter

    results = folder / "results.vtkhdf"
    last = read_results(results).steps[-1]
    shutil.copy(results, tmp_path / "copy")
    ResultsWriter.resume(results, last - 1).close()
    refused(folder, results.name, f"the output of step {last} is missing or changed", capfd)
    entries = entries_of()
    entries["materials"]["soil"]["yield_stress"] *= 1.01
    run(Model.from_dict(entries), tmp_path / "other", quiet=True)
    shutil.copy(tmp_path / "other" / "results.vtkhdf", results)
    refused(folder, results.name, "is missing or changed", capfd)
    shutil.copy(tmp_path / "copy", results)
    shutil.copy(tmp_path / "other" / "model.json", folder / "model.json")
    refused(folder, "model.json", "was changed after the run began", capfd)


def test_what_can_be_written_again_may_be_missing(
    model: Model, folder: Path, tmp_path: Path
) -> None:
    (folder / "log.txt").unlink()
    run(model, tmp_path / "whole", quiet=True)
    result = resume(folder, quiet=True)
    assert result.finished
    assert (folder / "log.txt").exists()
    assert_same_results(tmp_path / "whole", folder)


def test_the_time_of_all_parts_is_reported(folder: Path) -> None:
    checkpoint = folder / "checkpoint.npz"
    arrays, meta = read_checkpoint(checkpoint)
    earlier = {"total": 1000.0, "wall": {"solve": 800.0}, "processor": {"solve": 700.0}}
    write_checkpoint(checkpoint, arrays, meta | {"seconds": earlier})
    result = resume(folder, quiet=True)
    assert 800.0 < result.seconds["solve"] < 900.0
    assert 700.0 < result.processor_seconds["solve"] < 800.0
    log = (folder / "log.txt").read_text()
    taken = [line for line in log.splitlines() if "time taken" in line][-1]
    assert 1000.0 < float(taken.split()[-2]) < 1100.0


@pytest.mark.parametrize("text", ["3", "[]", "null", '"x"', "[" * 3000, '{"a":' * 3000, "{}", "\0"])
def test_foreign_models(text: str, folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (folder / "model.json").write_text(text)
    refused(folder, "model.json", "", capfd)
    assert run_command(["report", str(folder)]) == 2
    assert str(folder / "model.json") in capfd.readouterr().err


def deeply(levels: int) -> Any:
    entry: Any = 1.0
    for _ in range(levels):
        entry = [entry]
    return entry


@pytest.mark.parametrize("levels", [50, 400, 900])
def test_a_nested_entry_of_a_model(
    levels: int, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    for key in ("grid", "bodies", "materials", "title"):
        entries = entries_of() | {key: deeply(levels)}
        (folder / "model.json").write_text(json.dumps(entries))
        refused(folder, "model.json", "", capfd)


Arrays = dict[str, np.ndarray]


def changed(name: str, change: Callable[[np.ndarray], Any]) -> Callable[[Arrays], None]:
    def apply(arrays: Arrays) -> None:
        arrays[name] = np.asarray(change(arrays[name]))

    return apply


def filled(value: float) -> Callable[[np.ndarray], np.ndarray]:
    def apply(array: np.ndarray) -> np.ndarray:
        array = array.copy()
        array.flat[0] = value
        return array

    return apply


WRONG_ARRAYS = {
    "fewer points": changed("position", lambda a: a[:-1]),
    "a flat array": changed("stress", np.ravel),
    "other columns": changed("stress", lambda a: a[:, :4]),
    "single precision": changed("stress", lambda a: a.astype(np.float32)),
    "text": changed("stress", lambda a: a.astype("U8")),
    "complex": changed("position", lambda a: a.astype(complex)),
    "not a number": changed("stress", filled(np.nan)),
    "infinite": changed("displacement", filled(np.inf)),
    "far away": changed("position", filled(1e200)),
    "a point twice": changed("point_id", lambda a: np.zeros_like(a)),
    "a number out of range": changed("point_id", filled(10**9)),
    "inverted": changed("deformation_gradient", lambda a: -a),
    "no volume": changed("initial_volume", filled(0.0)),
    "an additional array": lambda arrays: arrays.update(extra=np.zeros(3)),
    "ghost's rows": changed("ghost.moved", lambda a: a[:-1]),
    "ghost's order": changed("ghost.face", lambda a: a[::-1]),
    "ghost's number": changed("ghost.modulus", filled(np.nan)),
    "keys": changed("last step.key", lambda a: a[::-1]),
    "nodes": changed("last step.displacement", lambda a: a[1:]),
    "origin": changed("last step.origin", lambda a: a[:1]),
    "size": changed("last step.size", lambda a: -a),
    "size's shape": changed("last step.size", lambda a: a.reshape(1)),
}


@pytest.mark.parametrize("wrong", WRONG_ARRAYS)
def test_arrays_of_a_checkpoint_that_do_not_fit(
    wrong: str, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arrays, meta = read_checkpoint(folder / "checkpoint.npz")
    WRONG_ARRAYS[wrong](arrays)
    write_checkpoint(folder / "checkpoint.npz", arrays, meta)
    refused(folder, "checkpoint.npz", "does not fit the model", capfd)


def test_arrays_in_fortran_order_are_used(model: Model, folder: Path, tmp_path: Path) -> None:
    arrays, meta = read_checkpoint(folder / "checkpoint.npz")
    fortran = {name: np.asarray(array, order="F") for name, array in arrays.items()}
    assert not fortran["stress"].flags.c_contiguous
    write_checkpoint(folder / "checkpoint.npz", fortran, meta)
    again, _ = read_checkpoint(folder / "checkpoint.npz")
    assert all(array.flags.c_contiguous for array in again.values())
    run(model, tmp_path / "whole", quiet=True)
    resume(folder, quiet=True)
    assert_same_results(tmp_path / "whole", folder)


@pytest.mark.parametrize(
    "key", ["clock", "energies", "history", "energy_rows", "outputs", "seconds", "version", "model"]
)
@pytest.mark.parametrize("value", [None, "x", [1], {}, -1.5, float("nan"), [[1, 2, 3]]])
def test_plain_data_of_another_type(
    key: str, value: Any, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    if (key, value) == ("version", "x"):
        return
    arrays, meta = read_checkpoint(folder / "checkpoint.npz")
    for wrong in (meta | {key: value}, {k: v for k, v in meta.items() if k != key}):
        write_checkpoint(folder / "checkpoint.npz", arrays, wrong)
        refused(folder, "checkpoint.npz", key, capfd)


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("step", [0, -1, 1.5, True, "1", 10**30, STEP + 1]),
        ("time", [0.0, -0.1, float("nan"), float("inf"), 1e300, 1.0001]),
        ("size", [0.0, -0.1, float("nan"), float("inf"), 1e300, 0.2]),
        ("successes", [-1, 1.5, None]),
        ("until", [0.5]),
    ],
)
def test_clock_that_is_not_of_the_schedule(
    key: str, values: list[Any], folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arrays, meta = read_checkpoint(folder / "checkpoint.npz")
    for value in values:
        wrong = meta | {"clock": meta["clock"] | {key: value}}
        write_checkpoint(folder / "checkpoint.npz", arrays, wrong)
        refused(folder, "history.csv" if key == "step" and value in (STEP + 1, 10**30)
                else "checkpoint.npz", "", capfd)  # fmt: skip


@pytest.mark.parametrize("meta", ["[]", "3", "null", "[" * 3000, "{"])
def test_plain_data_that_are_no_table(
    meta: str, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    import zipfile

    with zipfile.ZipFile(folder / "checkpoint.npz", "w") as archive:
        archive.writestr("meta.json", meta)
    refused(folder, "checkpoint.npz", "damaged", capfd)


@pytest.mark.parametrize("file", ["results.vtkhdf", "checkpoint.npz", "history.csv", "model.json"])
def test_flipped_bits_are_refused_or_have_no_effect(
    file: str, stopped: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Whatever is accepted must have read the same values: then it is the same run."""
    from tilth.analysis.stored_run import StoredRun

    folder = Path(shutil.copytree(stopped, tmp_path / "out"))
    whole = StoredRun.read(folder)
    good, random, accepted = (folder / file).read_bytes(), np.random.default_rng(7), 0
    messages = []
    for place in random.integers(len(good), size=40):
        bit = 1 << int(random.integers(8))
        (folder / file).write_bytes(good[:place] + bytes([good[place] ^ bit]) + good[place + 1 :])
        try:
            found = StoredRun.read(folder)
            simulation = found.analysis(None).simulation
        except BadInput as error:
            messages.append(str(error))
            continue
        accepted += 1
        assert (found.progress, found.rows) == (whole.progress, whole.rows)
        assert found.model == whole.model
        for name, array in whole.analysis(None).simulation.state.arrays().items():
            assert array.tobytes() == simulation.state.arrays()[name].tobytes()
    assert all(str(folder / file) in message for message in messages)
    assert len(messages) > 2
    assert file != "model.json" or accepted == 0


def test_flipped_bits_of_results_are_not_drawn(folder: Path) -> None:
    """The reader gives what was written, or refuses."""
    path = folder / "results.vtkhdf"
    good, random, messages = path.read_bytes(), np.random.default_rng(11), []
    whole = [snapshot.point_fields["cauchy_stress"] for snapshot in read_results(path)]
    for place in random.integers(len(good), size=40):
        path.write_bytes(good[:place] + bytes([good[place] ^ 4]) + good[place + 1 :])
        try:
            results = list(read_results(path))
        except BadInput as error:
            messages.append(str(error))
            continue
        for expected, snapshot in zip(whole, results, strict=True):
            assert expected.tobytes() == snapshot.point_fields["cauchy_stress"].tobytes()
    assert all(str(path) in message for message in messages)
    assert len(messages) > 2


def test_report_says_that_results_are_damaged(
    folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with h5py.File(folder / "results.vtkhdf", "a") as file:
        file["VTKHDF/points/PointData/cauchy_stress"][3, 1] += 1e-9
    before = contents(folder)
    assert run_command(["report", str(folder)]) == 2
    assert "results.vtkhdf is damaged (output 0 is not as it was written" in capfd.readouterr().err
    assert contents(folder) == before
