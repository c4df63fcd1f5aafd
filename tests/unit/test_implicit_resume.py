# SPDX-License-Identifier: BSD-3-Clause
"""A resumed run with implicit boundaries that move and grow ends in the same bits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from implicit_blocks import flat, gravity, implicit, model_of
from resumed_runs import run_in_pieces, run_until
from small_problems import BASES, material_entries

from tilth import Model, resume, run
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.output import read_checkpoint
from tilth.output.folder import CHECKPOINT

STEPS = 8
FORMS = ("surface", "band")

pytestmark = pytest.mark.usefixtures("every_loop_in_parallel")


def spreading(form: str, basis: str = "gimp") -> Model:
    """A soft block between a base without end and a platen that turns and squeezes it.

    It spreads far beyond the part of the base that was needed at first. A circle far away touches
    no soil until the block reaches it.
    """
    block = {"type": "box", "lower": [0.1, 0.13], "upper": [1.1, 1.13]}
    pillar = {"type": "circle", "centre": [2.1, 0.4], "radius": 0.4, "soil": "outside"}
    press = {"rotation": {"angle": 2.0, "centre": [0.6, 1.13]}, "displacement": {"y": -0.6}}
    walls = [
        implicit("base", flat([0.0, 0.13], [0.0, 1.0]), form=form),
        implicit("platen", flat([0.6, 1.13], [0.0, -1.0]), form=form, **press),
        implicit("pillar", pillar, form=form, displacement={"x": -0.1}),
        implicit("guide", flat([0.1, 0.0], [1.0, 0.0]), form=form),
    ]
    entries = model_of("plane_strain", basis, block, walls, STEPS, loads=[gravity(2)]).to_dict()
    entries["materials"]["soil"] = material_entries("von_mises", yield_stress=25.0)
    entries["analysis"]["tolerance"] = 1e-9
    entries["output"] = {"report": False}
    entries["track"] = [
        {"name": name, "quantity": "reaction", "boundary": name, "component": "y"}
        for name in ("base", "platen", "pillar")
    ]
    return Model.from_dict(entries)


def contents(folder: Path) -> dict[str, bytes]:
    """All results: history, every data set of the results, every array of the checkpoint."""
    found = {"history": (folder / "history.csv").read_bytes()}

    def take(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            found[name] = np.asarray(item[()]).tobytes()

    with h5py.File(folder / "results.vtkhdf") as results:
        results.visititems(take)
    arrays, _ = read_checkpoint(folder / CHECKPOINT)
    return found | {f"checkpoint {name}": array.tobytes() for name, array in arrays.items()}


def assert_same(one: dict[str, bytes], other: dict[str, bytes]) -> None:
    assert one.keys() == other.keys()
    assert [name for name in one if one[name] != other[name]] == []


@pytest.fixture(scope="module", params=FORMS)
def model(request: pytest.FixtureRequest) -> Model:
    return spreading(request.param)


@pytest.fixture(scope="module")
def whole(model: Model, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("whole") / "out"
    run(model, folder, threads=1, quiet=True)
    return contents(folder)


def test_the_case_is_worth_resuming(model: Model) -> None:
    """The base grows on the way, the pillar is touched late, and tractions turn."""
    sizes: dict[str, list[int]] = {name: [] for name in ("base", "platen", "pillar")}
    touched: list[bool] = []

    def look(simulation: Simulation, result: StepResult, time: float) -> None:
        for boundary in simulation.state.implicit:
            if boundary.name in sizes:
                sizes[boundary.name].append(len(boundary.carried))
            if boundary.name == "pillar":
                touched.append(bool(boundary.carried.any()))

    simulation = march(model, look)
    assert simulation.state.points.plastic[:, 0].max() > 0.1
    base = sizes["base"]
    if model.boundaries[0].form == "surface":  # the band holds the soil's foot back
        assert base[0] < base[-1]
        assert base[STEPS // 2 - 1] < base[-1], "grows after the runs below are stopped"
    assert len(set(sizes["pillar"])) == 1
    assert touched[-1]
    assert not touched[0]


def test_checkpoint_holds_the_tractions(
    model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_until(model, tmp_path / "out", 3, monkeypatch)
    arrays, _ = read_checkpoint(tmp_path / "out" / CHECKPOINT)
    for number, wall in enumerate(model.boundaries):
        carried = arrays[f"boundary {number}.carried"]
        assert carried.shape[1] == (2 if wall.form == "surface" else 11)
        assert carried[:, :2].any() == (wall.name != "pillar")
    simulation = Simulation.restored(model, arrays)
    for number, boundary in enumerate(simulation.state.implicit):
        assert boundary.carried.tobytes() == arrays[f"boundary {number}.carried"].tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("threads", [(1, 2), (2, 1)])
def test_resumed_after_a_step(
    threads: tuple[int, int],
    model: Model,
    whole: dict[str, bytes],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With either number of threads before, with the other one after."""
    run_in_pieces(model, tmp_path / "out", [1, 4, 7], monkeypatch, threads)
    assert_same(whole, contents(tmp_path / "out"))


@pytest.mark.slow
@pytest.mark.parametrize("basis", [basis for basis in BASES if basis != "gimp"])
def test_resumed_with_other_bases(
    basis: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = spreading("surface", basis)
    run(model, tmp_path / "whole", threads=1, quiet=True)
    run_in_pieces(model, tmp_path / "out", [4], monkeypatch, (1, 2))
    assert_same(contents(tmp_path / "whole"), contents(tmp_path / "out"))


def test_without_the_tractions_it_would_not_be_the_same(
    model: Model, whole: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So the comparison sees them."""
    run_until(model, tmp_path / "out", 4, monkeypatch)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "tilth.boundaries.surfaces.boundary.Implicit.restore", lambda self, state: None
        )
        resume(tmp_path / "out", threads=1, quiet=True)
    assert contents(tmp_path / "out")["history"] != whole["history"]
