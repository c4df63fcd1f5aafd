# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies that come in later stages, to soil that has moved by then."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clay_boxes import clay_box
from readings import long

from tilth import BadInput, Model, check, resume, run
from tilth.analysis.staged import StagedAnalysis
from tilth.output import read_history

DOWN = -0.2
"""How far the first ball is pressed in: 0.8 of a cell."""


def ball(kind: str, name: str, radius: float, lowest: float, **entries: Any) -> dict[str, Any]:
    """A smooth ball above the middle; lowest: height of its lowest point."""
    across = ["x", "y"] if kind == "3d" else ["x"]
    centre = [0.0] * len(across) + [lowest + radius]
    turns = 0.0 if kind != "3d" else {"x": 0.0, "y": 0.0, "z": 0.0}
    shape = "sphere" if kind == "3d" else "circle"
    return {
        "name": name, "centre": centre, "rotation": turns,
        "geometry": {"type": shape, "centre": centre, "radius": radius, "soil": "outside"},
        "contact": {"normal": "unilateral", "tangential": "smooth"},
        **entries,
    }  # fmt: skip


def hollow(kind: str, second: float = DOWN, **entries: Any) -> dict[str, Any]:
    """A ball makes a hollow in clay, is removed, and a smaller one comes.

    second: height of its lowest point. entries: of it; it is pressed down if none is given.
    """
    across = ["x", "y"] if kind == "3d" else ["x"]
    up = "xyz"[len(across)]
    still = dict.fromkeys(across, 0.0)
    given = entries or {"displacement": {**still, up: -0.1}}
    first = ball(kind, "first", 0.5, 0.0, displacement={**still, up: DOWN})
    return {
        **clay_box(kind, 0.49),
        "analysis": {"kind": kind},
        "grid": {"cell_size": 0.25},
        "rigid_bodies": [first, ball(kind, "second", 0.4, second, **given)],
        "output": {"report": False},
        "stages": [
            {"name": "press", "schedule": {"steps": 4}},
            {"name": "remove", "deactivate": ["first"], "schedule": {"steps": 1}},
            {"name": "again", "activate": ["second"], "schedule": {"steps": 2}},
        ],
    }  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["plane_strain", long("3d")])
def test_a_body_comes_into_the_hollow_of_a_removed_one(kind: str, tmp_path: Path) -> None:
    """It meets the soil only where the first one left it, 0.8 of a cell below the level ground."""
    model = Model.from_dict(hollow(kind, DOWN + 0.02))
    assert not any("'second' at the start" in text for text in check(model).warnings)
    run(model, tmp_path, quiet=True)
    rows = read_history(tmp_path / "boundaries.csv")
    up, unit = ("z", "N") if kind == "3d" else ("y", "N/m")
    force = {name: -np.array(rows[f"{name} force_{up} [{unit}]"]) for name in ("first", "second")}
    largest = force["first"].max()  # the width in contact is the same but for a tenth
    assert force["second"][-1] == pytest.approx(largest, rel=0.3)


def test_a_loaded_body_is_not_missed_by_soil_that_has_not_come_yet() -> None:
    """What would hold it in the third stage is not known before: `check` does not ask for it."""
    model = Model.from_dict(hollow("plane_strain", 1.2, force={"y": -1.0}, displacement={"x": 0.0}))
    check(model)
    analysis = StagedAnalysis(model)
    with pytest.raises(BadInput, match="no soil is within 1 cell of the rigid body 'second'") as at:
        list(analysis.steps())
    assert at.value.key == "rigid_bodies[1]"
    assert analysis.number == 1


@pytest.mark.slow
def test_a_body_in_soil_that_has_moved_is_refused_when_the_stage_begins(tmp_path: Path) -> None:
    """The stages before are kept, and with another place the run goes on from them."""
    folder, other = tmp_path / "run", tmp_path / "other"
    wrong = Model.from_dict(hollow("plane_strain", DOWN - 0.1))
    check(wrong)
    for begin in (partial(run, wrong, folder, quiet=True), partial(resume, folder, quiet=True)):
        with pytest.raises(BadInput) as caught:
            begin()
        assert caught.value.key == "rigid_bodies[1]"
        told = str(caught.value)
        assert "begin inside the rigid body 'second'" in told
        assert "at the start of the stage 'again'" in told
        assert "`excavate` its shape" in told
        assert "wished_in_place" not in told
    before = read_history(folder / "history.csv")
    assert before["time"][-1] == 2.0
    right = Model.from_dict(hollow("plane_strain", DOWN + 0.02))
    run(right, other, from_stage=(folder, "remove"), quiet=True)
    after = read_history(other / "history.csv")
    np.testing.assert_array_equal(after["time"][: len(before["time"])], before["time"])
    assert after["time"][-1] == 3.0


def test_a_body_that_stays_is_not_asked_again() -> None:
    """Soil may be as deep in a body as a step allows; that is no fault of the next stage."""
    entries = hollow("plane_strain", DOWN + 0.02)
    entries["rigid_bodies"] = entries["rigid_bodies"][:1]
    entries["stages"] = [*entries["stages"][:1], {"name": "rest", "schedule": {"steps": 1}}]
    analysis = StagedAnalysis(Model.from_dict(entries))

    def put_soil_inside() -> None:
        points = analysis.simulation.state.points
        lowest = np.abs(points.position - [0.0, DOWN]).sum(axis=1).argmin()
        points.position[lowest] = [0.0, DOWN + 0.04]

    for _ in analysis.steps(on_stage_end=put_soil_inside, on_stage_start=analysis.stop):
        pass
    assert analysis.number == 1
