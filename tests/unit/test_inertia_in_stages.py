# SPDX-License-Identifier: BSD-3-Clause
"""Stages with and without inertia: soil and free rigid bodies where one follows another."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from free_bodies import GRAVITY, falling
from resumed_runs import assert_same_results, run_in_pieces

from tilth import BadInput, Model, run
from tilth.analysis.staged import StagedAnalysis

REST: dict[str, Any] = {
    "name": "gravity", "inertia": False, "schedule": {"end": 1.0, "steps": 2},
}  # fmt: skip
DROP: dict[str, Any] = {
    "name": "drop", "activate": ["ball"], "schedule": {"end": 0.03, "steps": 6},
}  # fmt: skip
MORE: dict[str, Any] = {"name": "more", "schedule": {"end": 0.01, "steps": 2}}
LATER: dict[str, Any] = {"name": "later", "inertia": False, "schedule": {"end": 1.0, "steps": 4}}
AT_REST: dict[str, Any] = {
    "strength": 3e4, "gap": 0.0, "rotation": 0.0, "displacement": {"x": 0.0}
}  # fmt: skip
"""A ball that the soil carries without much yielding."""


def staged(*stages: dict[str, Any], **changed: Any) -> dict[str, Any]:
    """A ball on clay, or above it, in stages; its weight is there at once."""
    entries = falling("plane_strain", **changed)
    del entries["schedule"]
    entries["loads"][0] |= {"name": "gravity", "factor": [[0.0, 0.0], [1.0, 1.0]]}
    if changed.get("gap") == 0.0:
        del entries["rigid_bodies"][0]["velocity"]
    return {**entries, "stages": list(stages), "output": {"report": False}}


def ended(entries: dict[str, Any]) -> StagedAnalysis:
    """The analysis at the end of its last stage."""
    analysis = StagedAnalysis(Model.from_dict(entries))
    analysis.check()
    for _ in analysis.steps():
        pass
    return analysis


def test_a_body_at_rest_stays_at_rest_when_inertia_begins() -> None:
    """Within 0.01 of a cell of 0.1: soil and body are in balance.

    The contact of bodies with inertia has other shares (theory), which hold it 0.004 of a cell
    higher; it comes there over the stage.
    """
    still = {**REST, "schedule": {"end": 1.0, "steps": 10}}
    moving = {**DROP, "activate": [], "schedule": {"end": 0.05, "steps": 10}}
    before = ended(staged(still, **AT_REST)).simulation.state.bodies[0]
    entries = staged(still, moving, **AT_REST)
    entries["analysis"]["inertia"]["damping"] = {"mass": 20.0}
    analysis = StagedAnalysis(Model.from_dict(entries))
    analysis.check()
    for _ in analysis.steps():
        body = analysis.simulation.state.bodies[0]
        if analysis.number == 1:
            assert body.force[1] == pytest.approx(before.force[1], rel=0.2)
            assert body.displacement[1] == pytest.approx(before.displacement[1], abs=1e-3)
    assert np.abs(analysis.out_of_balance).max() < 0.01 * before.force[1]


def test_two_stages_with_inertia_are_as_one() -> None:
    """In the middle of an impact."""
    one = ended(staged(REST, {**DROP, "schedule": {"end": 0.04, "steps": 8}}))
    two = ended(staged(REST, DROP, MORE))
    body, same = one.simulation.state.bodies[0], two.simulation.state.bodies[0]
    assert np.abs(two.out_of_balance).max() < 0.02 * body.force[1]
    assert same.displacement[1] == pytest.approx(body.displacement[1], rel=2e-3)
    assert body.inertia is not None
    assert same.inertia is not None
    velocity = body.inertia.motion.velocity[1]
    assert same.inertia.motion.velocity[1] == pytest.approx(velocity, rel=0.02)


def test_motion_goes_on_on_another_grid() -> None:
    first = ended(staged(REST, DROP)).simulation.state.bodies[0]
    analysis = ended(staged(REST, DROP, {**MORE, "grid": {"cell_size": 0.1, "origin": [0.03, 0]}}))
    body = analysis.simulation.state.bodies[0]
    assert first.inertia is not None
    expected = first.inertia.motion.velocity[1] * 0.01
    assert body.displacement[1] - first.displacement[1] == pytest.approx(expected, rel=0.15)
    assert np.isfinite(analysis.simulation.state.points.motion).all()


def test_a_body_that_comes_later_falls_exactly() -> None:
    """From its first step on, in a stage that follows one with inertia."""
    entries = staged(REST, {**DROP, "activate": []}, {**MORE, "activate": ["ball"]}, gap=0.5)
    body = ended(entries).simulation.state.bodies[0]
    exact = -1.0 * 0.01 - 0.5 * GRAVITY * 0.01**2
    assert body.displacement[1] == pytest.approx(exact, rel=1e-9)


@pytest.mark.slow
def test_a_stage_without_inertia_stops_what_moves(tmp_path: Path) -> None:
    """It says so; the soil then carries the weight, and nothing moves again later."""
    held = {"displacement": {"x": 0.0}, "rotation": 0.0}
    entries = staged(REST, DROP, LATER, {**MORE, "name": "again"}, **held)
    analysis = StagedAnalysis(Model.from_dict(entries))
    analysis.check()
    weight = GRAVITY * (analysis.model.rigid_bodies[0].mass or 0.0)
    for _ in analysis.steps():
        if analysis.number == 2:
            simulation = analysis.simulation
            body = simulation.state.bodies[0]
            assert body.inertia is not None
            assert body.inertia.energy() == 0.0
            assert not simulation.state.points.motion.any()
            assert body.force[1] == pytest.approx(weight, rel=1e-6)
            rest = body.displacement[1]
    assert analysis.simulation.state.bodies[0].displacement[1] == pytest.approx(rest, rel=0.05)
    run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    log = (tmp_path / "out" / "log.txt").read_text(encoding="utf-8")
    assert log.count("the stage 'later' has no inertia: what moves is at rest from its start") == 1
    assert "the stage 'gravity' has no inertia" not in log


@pytest.mark.slow
def test_resumed_in_each_stage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In an impact, at the end of its stage, in the next one, in the stage without inertia."""
    held = {"displacement": {"x": 0.0}, "rotation": 0.0}
    entries = staged(REST, DROP, MORE, LATER, **held)
    entries["track"] = [
        {"name": kind, "quantity": "energy", "kind": kind}
        for kind in ("external_work", "kinetic", "numerical_dissipation")
    ]
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True)
    run_in_pieces(model, tmp_path / "stopped", [5, 8, 9, 11], monkeypatch)
    assert_same_results(tmp_path / "whole", tmp_path / "stopped")


@pytest.mark.parametrize("of_soil", [False, True])
def test_a_velocity_in_a_stage_without_inertia_is_refused(of_soil: bool) -> None:
    entries = staged(REST, {**DROP, "activate": []})
    key = "rigid_bodies[0].velocity"
    if of_soil:
        del entries["rigid_bodies"]
        entries["initial"] = {"velocity": [{"body": "soil", "y": 1.0}]}
        key = "initial.velocity[0]"
    with pytest.raises(BadInput, match="which has no inertia") as caught:
        Model.from_dict(entries)
    assert key in str(caught.value)
    assert len(caught.value.problems) == 1
