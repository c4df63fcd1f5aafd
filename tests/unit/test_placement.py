# SPDX-License-Identifier: BSD-3-Clause
"""Several new bodies in one stage, and the warnings of stages that change nothing or a lot."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from staged_ground import at_rest, at_start_of, box, elastic, entries, gravity, plane, stage

import tilth
from tilth import BadInput, Model
from tilth.analysis import overlaps
from tilth.analysis.overlaps import overlapping_bodies
from tilth.analysis.staged import StagedAnalysis
from tilth.mpm.initial_points import initial_points


def soft_column(*lifts: dict[str, Any]) -> dict[str, Any]:
    """Soft ground of 2 m that settles under its weight, on which bodies are placed together."""
    ground = box("ground", [0.0, 0.0], [1.0, 2.0])
    return entries(
        bodies=[ground, *lifts],
        boundaries=[plane("base", "y", 0.0), plane("left", "x", 0.0), plane("right", "x", 1.0)],
        materials={"soil": elastic(200.0)},
        loads=[gravity(factor=[[0.0, 0.0], [1.0, 1.0]])],
        stages=[stage("rest", 4), stage("build", activate=[each["name"] for each in lifts])],
    )


@pytest.mark.parametrize("turned", [False, True])
def test_lifts_of_one_stage_lie_on_each_other(turned: bool) -> None:
    """However they are listed: all go down with the ground, without a gap between them."""
    lifts = [box(f"lift {i}", [0.0, 2.0 + i], [1.0, 3.0 + i]) for i in range(3)]
    case = soft_column(*(lifts[::-1] if turned else lifts))
    analysis, ground = at_start_of(case, "build")
    top = ground.position[:, 1].max()
    settled = 2.0 - 0.125 - top
    assert settled > 0.1
    points = analysis.simulation.state.points
    new = points.position[points.point_id >= len(ground), 1]
    levels = np.unique(new.round(9))
    assert levels == pytest.approx(2.125 + 0.25 * np.arange(12) - settled, abs=1e-9)


def test_two_bodies_at_the_same_place_are_refused() -> None:
    case = soft_column(*(box(name, [0.0, 2.0], [1.0, 3.0]) for name in ("one", "other")))
    with pytest.raises(BadInput, match="would be placed inside soil") as caught:
        StagedAnalysis(Model.from_dict(case)).check()
    assert caught.value.problems[0].key == "stages[1].activate"


def test_bodies_far_from_each_other_are_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many lifts: the number of comparisons grows with their number, not with its square."""
    lifts = [box(f"lift {i}", [0.0, 2.0 + i], [1.0, 3.0 + i]) for i in range(20)]
    lifts.append(box("twin", [0.0, 5.0], [1.0, 6.0]))
    model = Model.from_dict(soft_column(*lifts))
    compared = []
    original = overlaps._points_inside

    def counted(*given: Any) -> Any:
        compared.append(given[2:])
        return original(*given)

    monkeypatch.setattr(overlaps, "_points_inside", counted)
    found = [pair[:2] for pair in overlapping_bodies(model, initial_points(model))]
    assert found == [(4, 21)]
    assert compared == [(4, 21), (21, 4)]


def plastic(*stages: dict[str, Any], **sections: Any) -> list[str]:
    """The warnings of a plastic column with these stages."""
    case = soft_column()
    case["materials"] = {"soil": {**elastic(), "model": "tresca", "undrained_shear_strength": 1e3}}
    case |= {"stages": list(stages), "loads": [gravity()], **sections}
    return [text for text in tilth.check(Model.from_dict(case)).warnings if "one step" in text]


REST = {"stress": [at_rest("ground", 2.0)]}


def test_one_step_in_which_nothing_changes_is_not_named() -> None:
    stages = [stage("rest"), stage("still at rest")]
    assert plastic(*stages, initial=REST) == []
    assert len(plastic(*stages)) == 1  # the weight acts on soil without stress


@pytest.mark.parametrize(
    "change",
    [
        {"factors": {"gravity": [[0.0, 1.0], [1.0, 2.0]]}},
        {"excavate": [
            {"body": "ground", "shape": {"type": "box", "lower": [0, 1], "upper": [1, 3]}}
        ]},
        {"grid": {"cell_size": 0.25, "origin": [0.0, 0.0]}},
    ],
)  # fmt: skip
def test_one_step_in_which_something_changes_is_named(change: dict[str, Any]) -> None:
    (text,) = plastic(stage("rest"), stage("change", **change), initial=REST)
    assert text.startswith("stages[1].schedule.steps = 1: in the stage 'change'")
