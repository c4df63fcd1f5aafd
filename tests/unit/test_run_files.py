# SPDX-License-Identifier: BSD-3-Clause
"""History, log, checkpoint, folder and progress bar of a run."""

from __future__ import annotations

import io
import math
import os
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from result_snapshots import UNITS, make_snapshot
from rich.console import Console

from tilth.errors import BadInput
from tilth.output import (
    HistoryWriter,
    Progress,
    ResultsWriter,
    RunLog,
    prepare_output_folder,
    read_checkpoint,
    read_history,
    read_log,
    write_checkpoint,
    write_surfaces,
)
from tilth.output.history import Mark, checked_history

COLUMNS = [("tip", "m"), ("reaction, base", "N"), ("ratio", "")]


def write_history(path: Path, steps: int) -> None:
    history = HistoryWriter(path, COLUMNS)
    for step in range(steps):
        history.append(step, step / 3, step + 2, [math.pi * step, -1e-300, 1 / 7])
    history.close()


def test_history_keeps_every_bit(tmp_path: Path) -> None:
    path = tmp_path / "history.csv"
    write_history(path, 5)
    first = path.read_text().splitlines()[0]
    assert first == 'step,time,iterations,tip [m],"reaction, base [N]",ratio'
    table = read_history(path)
    assert list(table) == ["step", "time", "iterations", "tip [m]", "reaction, base [N]", "ratio"]
    assert table["time"].tolist() == [step / 3 for step in range(5)]
    assert table["tip [m]"].tolist() == [math.pi * step for step in range(5)]
    assert table["iterations"].tolist() == [2, 3, 4, 5, 6]


def test_history_row_is_readable_at_once(tmp_path: Path) -> None:
    history = HistoryWriter(tmp_path / "history.csv", COLUMNS)
    for step in range(3):
        history.append(step, 0.5 * step, 1, [1.0, 2.0, float("nan")])
        assert len(read_history(tmp_path / "history.csv")["step"]) == step + 1
    with pytest.raises(ValueError, match="2 values for 3 columns"):
        history.append(3, 1.5, 1, [1.0, 2.0])
    history.close()


def mark_of(path: Path, last_step: int) -> Mark:
    """That of a checkpoint after this step."""
    content = b"".join(path.read_bytes().splitlines(keepends=True)[: last_step + 2])
    return Mark(len(content), zlib.crc32(content))


@pytest.mark.parametrize("last_step", [0, 2, 4])
def test_history_resumed_equals_uninterrupted(tmp_path: Path, last_step: int) -> None:
    whole, part = tmp_path / "whole.csv", tmp_path / "part.csv"
    write_history(whole, 8)
    write_history(part, 5)
    with part.open("a") as file:
        file.write("5,1.66")  # a kill in the middle of a line
    mark = mark_of(part, last_step)
    history = HistoryWriter(part, COLUMNS, checked_history(part, COLUMNS, last_step, mark))
    for step in range(last_step + 1, 8):
        history.append(step, step / 3, step + 2, [math.pi * step, -1e-300, 1 / 7])
    history.close()
    assert part.read_bytes() == whole.read_bytes()


def test_history_of_another_case_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "history.csv"
    write_history(path, 2)
    with pytest.raises(BadInput, match="columns"):
        checked_history(path, COLUMNS[:2], 1, mark_of(path, 1))
    with pytest.raises(BadInput, match="cannot be read"):
        read_history(tmp_path / "absent.csv")
    (tmp_path / "text.csv").write_text("step,time\n1,many\n")
    with pytest.raises(BadInput, match="not a table of numbers"):
        read_history(tmp_path / "text.csv")


def test_history_with_a_row_missing_or_changed_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "history.csv"
    write_history(path, 6)
    mark, good = mark_of(path, 4), path.read_bytes()
    rows = good.splitlines(keepends=True)
    for content, message in (
        (b"".join(rows[:5]), "row of step 4 is missing"),
        (b"".join(rows[:5]) + rows[5][:-4], "row of step 4 is damaged"),
        (b"".join([*rows[:3], *rows[4:]]), "row of step 2 is damaged"),
        (b"".join([*rows[:2], rows[3], rows[2], *rows[4:]]), "row of step 1 is damaged"),
        (good.replace(b"-1e-300", b"-one"), "row of step 0 is damaged"),
        (good.replace(b"-1e-300", b"-1e-200", 1), "was changed after the run wrote it"),
        (good.replace(b"\n", b"\r\n"), "columns"),
        (b"", "columns"),
    ):
        path.write_bytes(content)
        with pytest.raises(BadInput, match=message) as caught:
            checked_history(path, COLUMNS, 4, mark)
        assert str(path) in str(caught.value)
        assert "copy" in caught.value.remedy
        assert path.read_bytes() == content
    path.unlink()
    with pytest.raises(BadInput, match="cannot be read"):
        checked_history(path, COLUMNS, 4, mark)


@pytest.mark.parametrize(
    "text",
    [
        "", "\n", "step,time\n", "step,time,iterations\n1,0,0\n",
        "step,time,iterations\n0,0,0\n2,1,1\n", "step,time,iterations\n0,nan,0\n",
        "step,time,iterations\n0,0,0,1\n", "step,time,iterations\n0,0\n", "\0\0\n\xff\n",
    ],
)  # fmt: skip
def test_a_file_that_is_no_history_is_bad_input(text: str, tmp_path: Path) -> None:
    path = tmp_path / "history.csv"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(BadInput, match=r"history\.csv"):
        read_history(path)


def start_log(path: Path, last_step: int = 0) -> RunLog:
    log = RunLog(path, resume=last_step > 0, seconds=100.0 * last_step)
    log.header(
        version="0.1.0", title="Beam", threads=2, points=5760, cells=160, last_step=last_step
    )
    return log


RESIDUALS = [1.0, 2.5e-2, 3.0e-4, 4.0e-8, 1.0e-9, 1e-10, 2e-11, 1e-12]


def test_log_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    log = start_log(path)
    log.step(1, 0.02, 0.02, [1.0, 1e-5])
    log.warning("node 12 is\npoorly supported")
    log.cut(2, 0.04, 0.01, "point 7 inverted")
    log.step(2, 0.03, 0.01, RESIDUALS)
    contents = read_log(path)  # while the run goes on
    assert contents.warnings == log.warnings == ["node 12 is poorly supported"]
    assert contents.cuts == [
        "step 2 to time 0.04 undone (point 7 inverted); new step size 1.000e-02"
    ]
    assert (contents.last_step, contents.last_residuals) == (2, RESIDUALS)
    assert not contents.finished
    assert contents.failure is None
    assert contents.seconds is None
    log.finish(None, {"solve": 1.5}, "7 by superlu")
    log.close()
    contents = read_log(path)
    assert contents.finished
    assert contents.seconds is not None
    assert contents.facts["points"] == "5,760"
    assert contents.facts["threads"] == "2"
    assert contents.facts["systems"] == "7 by superlu"
    assert max(map(len, path.read_text().splitlines())) <= 100


@pytest.mark.parametrize(
    "title",
    ["finished: x", "tilth 1", "time taken: 99 s", "warning: y", "a\nstopped: z\n", "\x1b[2J"],
)
def test_a_title_is_no_line_of_the_log(tmp_path: Path, title: str) -> None:
    log = RunLog(tmp_path / "log.txt")
    log.header(version="0.1.0", title=title, threads=2, points=5760, cells=160)
    log.warning(f"the body {title}")
    log.close()
    contents = read_log(tmp_path / "log.txt")
    assert contents.facts["tilth"] == "0.1.0"
    assert contents.facts["case"].isprintable()
    assert (contents.finished, contents.failure, contents.seconds) == (False, None, None)
    assert len(contents.warnings) == 1


def test_log_goes_on_after_a_kill(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    log = start_log(path)
    log.warning("the material is nearly incompressible")
    log.step(1, 0.5, 0.5, [1.0, 1e-3])
    log.finish("the step size fell below its least value", {}, "none")
    log.close()
    assert read_log(path).failure == "the step size fell below its least value"
    with path.open("a") as file:
        file.write("     2           0.7")
    log = start_log(path, last_step=1)
    assert log.warnings == ["the material is nearly incompressible"]
    log.step(2, 1.0, 0.5, [1.0, 1e-4])
    log.finish(None, {"solve": 1.5}, "7 by superlu")
    log.close()
    contents = read_log(path)
    assert contents.finished
    assert contents.failure is None
    assert contents.facts["resumed"] == "after step 1"
    assert contents.seconds is not None
    assert 100.0 <= contents.seconds < 160.0  # the part before is included, and counted once
    assert contents.last_residuals == [1.0, 1e-4]
    assert "0.7" not in path.read_text()


def test_a_damaged_log_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    log = start_log(path)
    log.step(1, 0.02, 0.02, [1.0, 1e-5])
    log.warning("poorly supported")
    log.finish(None, {}, "")
    log.close()
    good, random = path.read_bytes(), np.random.default_rng(3)
    for place in random.integers(len(good), size=300):
        bit = 1 << int(random.integers(8))
        path.write_bytes(good[:place] + bytes([good[place] ^ bit]) + good[place + 1 :])
        read_log(path)


def arrays() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(0)
    special = np.array([0.0, -0.0, np.nan, np.inf, 5e-324])
    return {
        "position": rng.random((50, 2)),
        "body_id": np.arange(50, dtype=np.int32),
        "special": special,
        "fortran": np.asfortranarray(rng.random((3, 4))),
        "empty": np.zeros((0, 3)),
        "flags": np.array([True, False]),
        "number": np.array(3.5),
    }


def test_checkpoint_is_bit_exact(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.npz"
    meta = {"step": 3, "time": 1 / 3, "names": ["a", None], "nested": {"x": 1e-300}}
    write_checkpoint(path, {"old": np.zeros(3)}, {})
    write_checkpoint(path, arrays(), meta)
    read, read_meta = read_checkpoint(path)
    assert read_meta == meta
    assert list(read) == list(arrays())
    for name, values in arrays().items():
        assert read[name].dtype == values.dtype
        assert read[name].shape == values.shape
        assert read[name].tobytes() == values.tobytes()
    assert [file.name for file in tmp_path.iterdir()] == ["checkpoint.npz"]


def test_checkpoint_damage_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.npz"
    write_checkpoint(path, {"values": np.zeros(5000)}, {"step": 1})
    good = path.read_bytes()
    for place in (2000, 30000, len(good) - 10):
        path.write_bytes(good[:place] + bytes([good[place] ^ 1]) + good[place + 1 :])
        with pytest.raises(BadInput, match="damaged"):
            read_checkpoint(path)
    path.write_bytes(good[: len(good) // 2])
    with pytest.raises(BadInput, match="damaged"):
        read_checkpoint(path)
    with pytest.raises(BadInput, match="does not exist"):
        read_checkpoint(tmp_path / "absent.npz")


def test_checkpoint_that_fails_leaves_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "checkpoint.npz"
    write_checkpoint(path, {"values": np.ones(3)}, {"step": 1})
    with pytest.raises(ValueError, match="Object arrays"):
        write_checkpoint(path, {"values": np.array([object()])}, {"step": 2})

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", stop)
    with pytest.raises(KeyboardInterrupt):
        write_checkpoint(path, {"values": np.zeros(3)}, {"step": 2})
    read, meta = read_checkpoint(path)
    assert meta == {"step": 1}
    assert read["values"].tolist() == [1.0, 1.0, 1.0]


def test_folder_is_made_and_refused(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    assert prepare_output_folder(folder, overwrite=False) == folder
    assert folder.is_dir()
    prepare_output_folder(folder, overwrite=False)  # empty: fine
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(BadInput, match=r"(?s)b is not empty.*--overwrite.*overwrite=True.*--out"):
        prepare_output_folder(folder, overwrite=False)
    with pytest.raises(BadInput, match="is a file"):
        prepare_output_folder(folder / "notes.txt", overwrite=True)


def test_overwrite_removes_only_own_files(tmp_path: Path) -> None:
    own = ["results.vtkhdf", ".results.vtkhdf.shadow", ".results.vtkhdf.old", "history.csv"]
    own += ["report.html", ".report.html.new.4711", "log.txt", "setup.npz", ".model.json.new"]
    own += ["checkpoint.npz", ".checkpoint.npz.new", "surface.csv", ".surface.csv.new"]
    mine = ["case.toml", "notes.txt", "results.csv", "my_history.csv", "checkpoint_of_mine.txt"]
    mine += ["checkpoint.npz.bak", ".history.csv.newer", ".report.html.new.x", "history.csv.new"]
    for name in [*own, *mine, "model.json"]:
        (tmp_path / name).write_text("x")
    (tmp_path / "checkpoint_folder").mkdir()
    prepare_output_folder(tmp_path, overwrite=True, protect=[tmp_path / "model.json"])
    left = {file.name for file in tmp_path.iterdir()}
    assert left == {*mine, "checkpoint_folder", "model.json"}
    (tmp_path / "model.json").write_text('{"format": 1, "bodies": []}')
    prepare_output_folder(tmp_path, overwrite=True)
    assert not (tmp_path / "model.json").exists()


@pytest.mark.parametrize("name", ["log.txt", "report.html", "history.csv", "model.json"])
def test_overwrite_removes_nothing_from_a_folder_that_is_no_run(tmp_path: Path, name: str) -> None:
    """Other programs give their files such names, too."""
    for content in ("mine", "[1]", '{"format": "mine"}'):
        (tmp_path / name).write_text(content)
        with pytest.raises(BadInput, match=f"has a file {name}, but is not that of a run"):
            prepare_output_folder(tmp_path, overwrite=True)
        assert (tmp_path / name).read_text() == content


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a process that can be ended at will")
def test_temporary_files_are_hidden_and_removed_by_overwrite(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever a kill leaves behind: each process ends before its file gets its name."""
    monkeypatch.setattr(os, "replace", lambda *_: os._exit(9))
    results = ResultsWriter(tmp_path / "results.vtkhdf", units=UNITS)
    for write in (
        lambda: write_checkpoint(tmp_path / "checkpoint.npz", {}, {}),
        lambda: HistoryWriter(tmp_path / "history.csv", COLUMNS),
        lambda: write_surfaces(tmp_path / "surface.csv", make_snapshot(0), "m"),
        lambda: results.append(make_snapshot(0)),
    ):
        if (child := os.fork()) == 0:
            try:
                write()
            finally:
                os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    assert len(list(tmp_path.iterdir())) == 4
    assert all(file.name.startswith(".") for file in tmp_path.iterdir())
    prepare_output_folder(tmp_path, overwrite=True)
    assert list(tmp_path.iterdir()) == []


def drive(progress: Progress) -> None:
    with progress:
        for step in range(1, 4):
            progress.iteration(step, 1, 1e-3)
            progress.step_done(step, step / 3, 4)
        progress.message("warning: [x] something")


def test_progress_is_quiet_when_told() -> None:
    text = io.StringIO()
    drive(Progress(1.0, 100, quiet=True, console=Console(file=text, force_terminal=True)))
    assert text.getvalue() == ""


def test_progress_on_a_file_is_plain_and_rare() -> None:
    text = io.StringIO()
    drive(Progress(1.0, 1234, console=Console(file=text), seconds_between_lines=1e9))
    lines = text.getvalue().splitlines()
    assert len(lines) == 2
    assert "\x1b" not in text.getvalue()
    assert lines[0].startswith("step 3, time 1/1, 4 Newton iterations, 1,234 points, 0:00:0")
    assert lines[1] == "warning: [x] something"


def test_progress_on_a_terminal_is_live() -> None:
    text = io.StringIO()
    console = Console(file=text, force_terminal=True, width=100, legacy_windows=False)
    drive(Progress(1.0, 125000, console=console))
    assert "Newton  1 1.0e-03" in text.getvalue()
    assert "125,000 points" in text.getvalue()
    assert "1/1" in text.getvalue()


def test_import_is_light() -> None:
    code = "import sys, tilth.output; print('matplotlib' in sys.modules, 'h5py' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.split() == ["False", "False"], result.stderr
