# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies in the same place, rotations that no step can follow, steps beyond their limits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from small_problems import block_entries, rollers, weight

import tilth
from tilth import AnalysisFailed, BadInput, Model, run
from tilth.output import read_history, read_log

INERTIA = {"scheme": "generalised_alpha", "spectral_radius": 0.8}


def raft(name: str, left: float, dim: int = 2, **more: Any) -> dict[str, Any]:
    """A box one wide that rests above the soil from `left` on."""
    across, up = [0.0] * (dim - 2), "xyz"[dim - 1]
    return {
        "name": name, "centre": [left + 0.5, *across, 2.5],
        "geometry": {
            "type": "box", "lower": [left, *across, 2.0], "upper": [left + 1.0, *across, 3.0],
            "soil": "outside",
        },
        "contact": {"normal": "unilateral", "tangential": "smooth"},
        "displacement": dict.fromkeys("xyz"[:dim], 0.0) | {up: -0.01}, "rotation": 0.0, **more,
    }  # fmt: skip


def with_rafts(*rafts: dict[str, Any], **changed: Any) -> dict[str, Any]:
    boundaries = rollers("plane_strain")
    given = {"boundaries": boundaries, "loads": [weight("plane_strain", 0.1)], **changed}
    return block_entries("plane_strain", "gimp", **given) | {"rigid_bodies": list(rafts)}


@pytest.mark.parametrize(
    ("left", "overlap"), [(0.0, True), (0.5, True), (1.0, False), (2.0, False)]
)
def test_rigid_bodies_in_one_place_are_warned_of(left: float, overlap: bool) -> None:
    """In the same place, and in a part of it; not side by side."""
    given = with_rafts(raft("one", 0.0), raft("other", left))
    found = [text for text in tilth.check(Model.from_dict(given)).warnings if "in common" in text]
    assert len(found) == overlap
    for text in found:
        assert text.startswith("rigid_bodies[1]: the rigid bodies 'one' and 'other' have a place")
        assert "`geometries`" in text


def test_a_rigid_body_inside_another_one_is_warned_of() -> None:
    inner = {"type": "circle", "centre": [0.5, 2.5], "radius": 0.2, "soil": "outside"}
    for order in (1, -1):
        rafts = [raft("one", 0.0), raft("inner", 0.0, geometry=inner)][::order]
        texts = tilth.check(Model.from_dict(with_rafts(*rafts))).warnings
        assert sum("in common" in text for text in texts) == 1


def test_rigid_bodies_of_different_stages_are_not_compared() -> None:
    """The first one may have moved away, or is removed."""
    given = with_rafts(raft("one", 0.0), raft("other", 0.0))
    del given["schedule"]
    given["stages"] = [
        {"name": "first", "schedule": {"steps": 1}},
        {
            "name": "second", "schedule": {"steps": 1}, "activate": ["other"],
            "deactivate": ["one"],
        },
    ]  # fmt: skip
    assert not any("in common" in text for text in tilth.check(Model.from_dict(given)).warnings)


@pytest.mark.parametrize(
    ("angle", "steps", "refused"),
    [(1e6, 10, "1e+05 degrees"), (-1000.0, 10, "100 degrees"), (900.0, 10, ""), (90.0, 1, "")],
)
def test_rotations_that_no_step_follows_are_refused(angle: float, steps: int, refused: str) -> None:
    implicit = {
        "name": "vane", "type": "implicit", "condition": "fixed",
        "geometry": {"type": "circle", "centre": [1.0, 1.0], "radius": 0.5, "soil": "outside"},
        "rotation": {"angle": angle, "centre": [1.0, 1.0]},
    }  # fmt: skip
    rows = [[0.0, 0.0], [1.0, angle]]
    by_number, by_rows = raft("one", 0.0, rotation=angle), raft("one", 0.0, rotation=rows)
    cases = {
        "boundaries[3].rotation.angle": with_rafts(),
        "rigid_bodies[0].rotation": with_rafts(by_number),
        "rigid_bodies[0].rotation ": with_rafts(by_rows),
    }
    cases["boundaries[3].rotation.angle"]["boundaries"].append(implicit)
    for key, given in cases.items():
        given["schedule"] = {"steps": steps}
        if not refused:
            Model.from_dict(given)
            continue
        with pytest.raises(BadInput) as caught:
            Model.from_dict(given)
        assert caught.value.key == key.strip()
        assert f"turns by {refused} in a step of the schedule" in str(caught.value)


@pytest.mark.parametrize(("velocity", "refused"), [(1e7, True), (-100.0, True), (1.0, False)])
def test_a_free_body_that_turns_too_fast_for_a_step_is_refused(
    velocity: float, refused: bool
) -> None:
    free = {
        "mass": 1.0, "moments_of_inertia": 0.2, "angular_velocity": velocity,
        "displacement": {"x": 0.0}, "rotation": None,
    }  # fmt: skip
    given = with_rafts(raft("one", 0.0) | free, schedule={"steps": 10, "end": 1.0})
    del given["rigid_bodies"][0]["rotation"]
    given |= {"units": {"time": "s"}}
    given["analysis"]["inertia"] = INERTIA
    if not refused:
        Model.from_dict(given)
        return
    with pytest.raises(BadInput, match="degrees in a step of the schedule") as caught:
        Model.from_dict(given)
    assert caught.value.key == "rigid_bodies[0].angular_velocity"


def test_a_fast_turn_within_a_slow_table_is_refused_in_its_stage() -> None:
    """Twenty degrees in most steps, but 200 in one of them."""
    given = with_rafts(raft("one", 0.0, rotation=400.0))
    del given["schedule"]
    given["stages"] = [
        {
            "name": "turn", "schedule": {"steps": 11},
            "factors": {"one": [[0.0, 0.0], [0.45, 0.25], [0.46, 0.75], [1.0, 1.0]]},
        }
    ]  # fmt: skip
    with pytest.raises(BadInput, match=r"in a step of the schedule, more than 90 \(in rigid_bod"):
        Model.from_dict(given)


@pytest.mark.parametrize(
    ("limits", "text"),
    [
        ({"largest_motion": 1e-6}, "cells in the step, but largest_motion = 1e-06"),
        ({"largest_error": 1e-12}, "cells, but largest_error = 1e-12"),
    ],
)
def test_a_step_beyond_its_limits_that_cannot_be_shorter_ends_the_run(
    limits: dict[str, float], text: str, tmp_path: Path
) -> None:
    """Such a step was taken without a word before."""
    given = block_entries(
        "plane_strain", "gimp", boundaries=rollers("plane_strain"),
        loads=[weight("plane_strain", 10.0) | {"factor": [[0.0, 1.0], [1.0, 1.0]]}],
        schedule={"steps": 3, "end": 0.3, "minimum_step": 0.25}, units={"time": "s"},
        output={"report": False},
    )  # fmt: skip
    given["analysis"]["inertia"] = INERTIA | limits
    with pytest.raises(AnalysisFailed) as caught:
        run(Model.from_dict(given), tmp_path, quiet=True)
    assert text in str(caught.value)
    assert "a smaller schedule.minimum_step, or a larger limit in analysis.inertia" in str(
        caught.value
    )
    assert "no equilibrium" not in str(caught.value)
    assert len(read_history(tmp_path / "history.csv")["step"]) == 1
    assert read_log(tmp_path / "log.txt").failure is not None
    given["schedule"] |= {"minimum_step": 1e-4, "steps": 1, "end": 1e-3}
    given["analysis"]["inertia"] = INERTIA | {"largest_motion": 1e-6}
    steps = run(Model.from_dict(given), tmp_path / "short", quiet=True).steps
    assert steps > 1
