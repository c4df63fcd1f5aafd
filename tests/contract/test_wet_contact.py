# SPDX-License-Identifier: BSD-3-Clause
"""Friction on soil in which water flows: that of the pressure which the soil's skeleton bears."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from clay_columns import ENTRIES, LOAD, column, computed
from contact_terms import STRENGTH, YOUNG, next_balance, pressed, states
from small_problems import KINDS

from tilth import Model
from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.boundaries.contact.forces import AssembledContact
from tilth.grid.keys import places_of_keys
from tilth.terms.pore_water import PORE_PRESSURE

FRICTION = 0.4
DRAWN = {"displacement": {"x": 0.05, "y": 0.0}, "rotation": 0.0}
PULLED = {
    "displacement": {"y": 0.0}, "rotation": 0.0, "force": {"x": 3.0}, "springs": {"x": 50.0},
}  # fmt: skip
DRAINED = {"name": "top", "type": "plane", "axis": "y", "at": 1.0, "condition": "drained"}
STEP = 0.01
"""Of pressures in differences: the residual is linear in them on each branch."""
CONTACT = {"normal": "unilateral", "tangential": "friction", "friction": FRICTION}


def box(changes: dict[str, Any] | None = None, motion: Any = None, **law: Any) -> dict[str, Any]:
    """Clay of 1 by 1 between smooth walls, loaded, on a plate that is drawn along its base."""
    plate = {
        "name": "plate", "centre": [0.5, -0.3], "contact": CONTACT | law,
        "geometry": {"type": "box", "lower": [-1.0, -0.6], "upper": [2.0, 0.0], "soil": "outside"},
        **(DRAWN if motion is None else motion),
    }  # fmt: skip
    walls = [ENTRIES["boundaries"][0], {**ENTRIES["boundaries"][1], "at": 1.0}]
    ends = {"start": [1.0, 1.0], "end": [0.0, 1.0]}
    return column(
        {
            "grid.cell_size": 0.25, "bodies.0.shape.upper": [1.0, 1.0], "boundaries": walls,
            "rigid_bodies": [plate], "flow.boundaries": [DRAINED],
            "loads.0": {**ENTRIES["loads"][0], **ends}, "schedule": {"end": 4.0, "steps": 8},
            **(changes or {}),
        }
    )  # fmt: skip


def on_base(analysis: StagedAnalysis) -> float:
    """Integral of the nodal excess pore pressures over the base [kN/m]."""
    (owner,) = [each for each in analysis.state.fields if each.name == PORE_PRESSURE]
    position = analysis.state.grid.position(places_of_keys(owner.key, 1)[0][:, :2])
    base = np.flatnonzero(np.abs(position[:, 1]) < 1e-9)
    base = base[(position[base, 0] > -1e-9) & (position[base, 0] < 1.0 + 1e-9)]
    order = base[np.argsort(position[base, 0])]
    return float(np.trapezoid(owner.value[order, 0], position[order, 0]))


def test_friction_is_that_of_the_effective_pressure() -> None:
    """At all times, from next to none to that of dry soil under the same load."""
    analysis = StagedAnalysis(Model.from_dict(box()))
    drag = []
    for _ in analysis.steps():
        force = analysis.state.bodies[0].force
        borne = -force[1] - on_base(analysis)
        assert -force[1] == pytest.approx(LOAD, rel=1e-6)
        assert -force[0] == pytest.approx(FRICTION * borne, rel=1e-6)
        drag.append(-force[0])
    assert drag[0] < 0.35 * FRICTION * LOAD
    assert (np.diff(drag) > 0.0).all()
    later = computed(box({"schedule": {"end": 40.0, "steps": 8}}))
    assert -later.state.bodies[0].force[0] == pytest.approx(FRICTION * LOAD, rel=1e-4)


def wet(kind: str, law: str) -> Simulation:
    """The block of `pressed`, of soil with friction in whose pores water flows."""
    entries = pressed(kind, law).setup.model.to_dict()
    entries["units"] = dict(ENTRIES["units"])
    up = "xyz"[(3 if kind == "3d" else 2) - 1]
    base = {"name": "below", "type": "plane", "axis": up, "at": 0.0, "condition": "drained"}
    entries["flow"] = {"unit_weight": 10.0, "boundaries": [base]}
    entries["materials"]["soil"] = {
        "model": "mohr_coulomb", "young_modulus": YOUNG, "poisson_ratio": 0.3, "cohesion": STRENGTH,
        "friction_angle": 20.0, "dilation_angle": 0.0, "porosity": 0.4,
        "hydraulic_conductivity": 0.01,
    }  # fmt: skip
    entries |= {"loads": [], "schedule": {"end": 1.0, "steps": 4}}
    return Simulation(Model.from_dict(entries))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", ["friction", "limited", "rough", "held friction"])
def test_derivatives_by_the_pore_pressure(
    kind: str, law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of all residuals, those of a free body included, while patches slide."""
    simulation = wet(kind, law)
    simulation.advance(0.0, 0.25)
    balance = next_balance(simulation, 0.25, 0.5, monkeypatch)
    (term,) = [each for each in balance.terms if isinstance(each, AssembledContact)]
    first, sliding = balance.first(), 0
    for seed in range(24):
        random = np.random.default_rng([5, seed])
        size = 10.0 ** -(3 + seed % 6)
        u = size * random.normal(size=first.u.shape)
        u += 4.0 * size * random.normal(size=u.shape[1])  # also towards the body, or away from it
        p = first[PORE_PRESSURE] + 0.1 * random.normal(size=first[PORE_PRESSURE].shape)
        at = Unknowns({DISPLACEMENT: u, PORE_PRESSURE: p}, first.globals)
        way_of_p = {DISPLACEMENT: 0.0 * u, PORE_PRESSURE: random.normal(size=p.shape)}
        direction = Unknowns(way_of_p, 0.0 * first.globals)
        term._linearisations = 0
        matrix = balance.space.matrix()
        for _ in range(2):  # what turned round has its direction
            balance.evaluate(at)
            balance.linearise(at, matrix)
            balance.linearised()
        balance.evaluate(at)
        balance.linearise(at, matrix)
        branches = states(term)
        slides = sum(closed and slides for closed, slides, _ in branches)
        found, ends = matrix.times(direction), []
        for sign in (STEP, -STEP):
            ends.append(balance.evaluate(at.plus(direction, sign)))
            if states(term) != branches:
                break
        else:
            for name in (DISPLACEMENT, PORE_PRESSURE):
                expected = (ends[0].of[name] - ends[1].of[name]) / (2.0 * STEP)
                atol = 1e-7 * np.abs(expected).max() + 1e-9
                np.testing.assert_allclose(found.of[name], expected, rtol=0, atol=atol)
            sliding += slides
            by_globals = (ends[0].globals - ends[1].globals) / (2.0 * STEP)
            np.testing.assert_allclose(found.globals, by_globals, rtol=1e-6, atol=1e-8)
    assert sliding, "nothing slides"


def test_a_free_plate_slides_as_far_as_its_spring_lets_it() -> None:
    """Friction bears what there is of it by then, and the spring the rest of the force."""
    changes = {"analysis.tolerance": 1e-8, "schedule": {"end": 0.5, "steps": 10}}
    analysis = StagedAnalysis(Model.from_dict(box(changes, PULLED)))
    for step, _ in enumerate(analysis.steps(), 1):
        body = analysis.state.bodies[0]
        assert -body.force[0] == pytest.approx(FRICTION * (LOAD - on_base(analysis)), rel=1e-4)
        on_spring = PULLED["force"]["x"] * step / 10 - 50.0 * body.displacement[0]
        assert -body.force[0] == pytest.approx(on_spring, rel=1e-6)


def turned(angle: float) -> dict[str, Any]:
    """The clay turned about its lower left corner, which is off the grid's lines [degrees]."""
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    up, low = np.array([-along[1], along[0]]), np.array([0.57, 0.13])
    right, left = low + along, low + up
    vertices = [each.tolist() for each in (low, right, right + up, left)]

    def wall(name: str, point: Any, normal: Any, **more: Any) -> dict[str, Any]:
        plane = {"type": "plane", "point": point.tolist(), "normal": normal.tolist()}
        return {"name": name, "type": "implicit", "geometry": plane, **more}

    walls = [wall("left", low, along), wall("right", right, -along)]
    moved = {
        "displacement": dict(zip("xy", (0.05 * along).tolist(), strict=True)),
        "contact": CONTACT,
    }
    plate = wall("plate", low, up, **moved)
    ends = {"start": vertices[2], "end": vertices[3]}
    drain = {"name": "top", "type": "surface", "body": "soil", "condition": "drained", **ends}
    return box(
        {
            "bodies.0.shape": {"type": "polygon", "vertices": vertices}, "rigid_bodies": [],
            "boundaries": [*({**each, "condition": "roller"} for each in walls), plate],
            "flow.boundaries": [drain], "loads.0": {**ENTRIES["loads"][0], **ends},
        }
    )  # fmt: skip


@pytest.mark.parametrize("angle", [0.0, 20.0])
def test_turned_clay_on_a_boundary_has_the_same_friction(angle: float) -> None:
    """On a plane anywhere in the grid, at all times; within 3 % of that of dry soil."""
    steps = {"schedule": {"end": 2.0, "steps": 8}}
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    upright, other = (
        StagedAnalysis(Model.from_dict(each | steps)) for each in (box(), turned(angle))
    )
    expected = {result.time: -upright.state.bodies[0].force[0] for _, result in upright.steps()}
    found = {result.time: result.forces["plate"].sum(axis=0) @ along for _, result in other.steps()}
    np.testing.assert_allclose(
        [found[t] for t in expected], list(expected.values()), rtol=0, atol=0.03 * FRICTION * LOAD
    )
