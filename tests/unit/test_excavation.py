# SPDX-License-Identifier: BSD-3-Clause
"""Excavation: the forces that are released are those that the removed soil or wall carried."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from balances import residual_at
from staged_ground import (
    UNIT_WEIGHT,
    at_rest,
    at_start_of,
    box,
    by_number,
    elastic,
    entries,
    gravity,
    march,
    plane,
    stage,
    wall,
)

from tilth.arrays import Floats
from tilth.model.load_curve import LoadCurve
from tilth.mpm.active_grid import Buffers, locate
from tilth.terms.balance import Balance
from tilth_verification.carried import carried
from tilth_verification.closed_forms import Heave

WIDTH, LEVEL, BOTTOM, K0 = 2.0, 3.0, 1.5, 0.6
"""Width of the pit, ground level and bottom of the pit [m]; earth pressure at rest."""
STIFF = 1e9
"""Young's modulus for which no motion can be seen [kPa]."""

GRAVITY = np.array([0.0, -10.0])

every_basis = pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi1", "cpdi2"])
on_and_off_lines = pytest.mark.parametrize("shift", [0.0, 1.0 / 3.0])
at_three_places = pytest.mark.parametrize("shift", [0.0, 1.0 / 3.0, 0.5])


def pit(shift: float = 0.0, region: bool = False, **body: Any) -> dict[str, Any]:
    """Level ground at rest, 6 m wide and 3 m deep, in which a pit is dug at the left wall.

    shift: of the grid against the soil, in cells. region: whether the pit is no body of its own.
    """
    parts = [
        box("ground", [0.0, 0.0], [6.0, BOTTOM], **body),
        box("pit", [0.0, BOTTOM], [WIDTH, LEVEL], **body),
        box("bank", [WIDTH, BOTTOM], [6.0, LEVEL], **body),
    ]
    dig: dict[str, Any] = {"deactivate": ["pit"]}
    if region:
        parts = [box("ground", [0.0, 0.0], [6.0, LEVEL], **body)]
        shape = {"type": "box", "lower": [-1.0, BOTTOM], "upper": [WIDTH, LEVEL + 1.0]}
        dig = {"excavate": [{"body": "ground", "shape": shape}]}
    base, left, right = plane("base", "y", 0.0), plane("left", "x", 0.0), plane("right", "x", 6.0)
    if shift:
        base = wall("base", [0.0, 0.0], [0.0, 1.0])
        left = wall("left", [0.0, 0.0], [1.0, 0.0])
        right = wall("right", [6.0, 0.0], [-1.0, 0.0])
        parts = [{**part, "points_per_cell": None, "spacing": 0.25} for part in parts]
        parts = [{k: v for k, v in part.items() if v is not None} for part in parts]
    return entries(
        grid={"cell_size": 0.5, "origin": [-0.5 * shift, -0.5 * shift]},
        bodies=parts,
        boundaries=[base, left, right],
        initial={"stress": [at_rest(part["name"], LEVEL, K0) for part in parts]},
        stages=[stage("rest"), stage("dig", 2, **dig)],
    )


def part_left(basis: str, shift: float) -> float:
    """The part of a rebound that may be left when its forces act again.

    Domains whose faces move across a grid line, or along the edge of an implicit boundary, reach
    other nodes than before, and their stabilisation is not undone.
    """
    return 1e-4 if basis == "linear" or shift == 0.5 else 5e-3


@pytest.mark.parametrize("region", [False, True], ids=["body", "region"])
@pytest.mark.parametrize("basis", ["linear", "gimp"])
@on_and_off_lines
def test_released_forces_are_those_of_the_removed_soil_by_node(
    basis: str, shift: float, region: bool
) -> None:
    """With basis functions evaluated here. Nodes that conditions constrain are left out.

    The soil hardly moves, so nothing else is out of balance where it rests on grid lines; elsewhere
    the stress at rest is not in equilibrium at the edges of the soil.
    """
    case = pit(shift, region, basis=basis)
    case["materials"]["soil"] = elastic(STIFF)
    case["analysis"]["ghost_stabilisation"] = 0.0
    analysis, before = at_start_of(case, "dig")
    simulation = analysis.simulation
    step = simulation.prepare(0.0, 0.0)
    released = np.zeros((step.active.nodes, 2))
    place, force = simulation.state.released.position, simulation.state.released.force
    near = np.abs(step.active.position[None] - place[:, None]).max(axis=2)
    assert near.min(axis=1).max() < 1e-12
    released[near.argmin(axis=1)] = force
    whole = locate(before, simulation.state.grid, Buffers())
    number = np.flatnonzero(np.isin(whole.key, step.active.key))
    kept = np.isin(before.point_id, simulation.state.points.point_id)
    assert 0 < kept.sum() < len(kept)
    removed = carried(before.selected(~kept), whole, GRAVITY)[number]
    all_soil = carried(before, whole, GRAVITY)[number]
    free = ~step.conditions.constrained
    if shift:  # an implicit boundary acts on the nodes of its cells and supports those behind it
        x, y = step.active.position.T
        inside = (x > 1.0) & (x < 5.0) & (y > 1.0)
        free &= inside[:, None]
    scale = np.abs(removed[free]).max()
    assert np.abs(released - all_soil + removed)[free].max() < 1e-8 * scale
    if not shift:
        assert np.abs(all_soil[free]).max() < 1e-8 * scale


@every_basis
@pytest.mark.parametrize("anti_locking", ["none", "f_bar"])
@pytest.mark.parametrize("region", [False, True], ids=["body", "region"])
def test_resultant_is_weight_and_thrust_of_the_removed_soil(
    basis: str, anti_locking: str, region: bool
) -> None:
    """gamma B H upwards and K0 gamma H^2 / 2 towards the bank, which is no longer pushed."""
    case = pit(0.0, region, basis=basis, anti_locking=anti_locking)
    case["materials"]["soil"] = elastic(STIFF)
    analysis, _ = at_start_of(case, "dig")
    height = LEVEL - BOTTOM
    thrust = 0.5 * K0 * UNIT_WEIGHT * height**2
    weight = UNIT_WEIGHT * WIDTH * height
    assert analysis.out_of_balance == pytest.approx([thrust, -weight], rel=1e-8)


@pytest.mark.parametrize("implicit", [False, True])
def test_a_wall_that_is_removed_releases_its_force(implicit: bool) -> None:
    """Its thrust K0 gamma H^2 / 2; the soil moves there, and its reaction is 0 afterwards."""
    case = pit()
    case["stages"] = [stage("rest"), stage("no wall", 2, deactivate=["right"])]
    if implicit:
        case["boundaries"][2] = wall("right", [6.0, 0.0], [-1.0, 0.0])
    thrust = 0.5 * K0 * UNIT_WEIGHT * LEVEL**2
    _, starts, results = march(case)
    tolerance = 1e-4 if implicit else 1e-6  # of the quadrature on the edge of the wall
    force = results[0].resultant("right")[0]
    released = starts["no wall"].state.released.force.sum(axis=0)[0]
    assert force == pytest.approx(-thrust, rel=tolerance)
    assert released == pytest.approx(-thrust, rel=tolerance)
    assert [("right" in result.forces) for result in results] == [True, False, False]
    side = by_number(starts["no wall"], "position")[:, 0] > 5.8
    assert (by_number(starts["no wall"], "displacement")[side, 0] > 1e-3).all()
    assert results[-1].resultant("left")[0] == pytest.approx(0.0, abs=1e-6 * thrust)


@every_basis
@on_and_off_lines
def test_a_stage_begins_in_equilibrium(basis: str, shift: float) -> None:
    """As long as nothing is released there is no residual, and a small step hardly moves."""
    analysis, _ = at_start_of(pit(shift, basis=basis), "dig")
    simulation = analysis.simulation
    step = simulation.prepare(0.0, 0.0)
    balance = Balance(step.active, simulation.terms(step, simulation.soil_on(step.active)))
    residual = residual_at(balance, np.zeros(step.active.position.shape)).u
    free = np.where(step.conditions.constrained, 0.0, residual)
    assert np.abs(free).max() < 1e-10 * np.abs(simulation.state.released.force).max()
    short = simulation.advance(0.0, 1e-6).equilibrium.displacement
    rest = simulation.advance(1e-6, 1.0).equilibrium.displacement
    assert 0.0 < np.abs(short).max() < 2e-6 * np.abs(rest).max()


@pytest.mark.slow
@every_basis
@at_three_places
def test_rebound_goes_back_with_the_forces(basis: str, shift: float) -> None:
    """Released and applied again in four steps each, in small elastic strain."""
    case = pit(shift, basis=basis, anti_locking="f_bar")
    case["materials"]["soil"] = elastic(1e7)
    analysis, _ = at_start_of(case, "dig")
    simulation = analysis.simulation
    released = simulation.state.released
    released._share = LoadCurve(((0.0, 0.0), (0.5, 1.0), (1.0, 0.0)))
    start = by_number(simulation, "position").copy()
    times = np.linspace(0.0, 1.0, 9)
    for step in range(4):
        simulation.advance(times[step], times[step + 1])
    out = np.abs(by_number(simulation, "position") - start).max()
    for step in range(4, 8):
        simulation.advance(times[step], times[step + 1])
    assert out > 1e-6
    assert np.abs(by_number(simulation, "position") - start).max() < part_left(basis, shift) * out


@pytest.mark.slow
@every_basis
@pytest.mark.parametrize("anti_locking", ["none", "f_bar"])
def test_heave_of_a_wide_pit_is_that_of_one_dimension(basis: str, anti_locking: str) -> None:
    """5 m of soil under an excavation of 5 m, on cells of 0.25 and 0.125 m.

    The soil is soft, and heaves by 0.4 m; with the linear basis it is stiff, because points that
    pass from cell to cell have an error of their own. Second order, or 1e-4 of the heave.
    """
    error = []
    young, poisson = (1e5 if basis == "linear" else 1e3), 0.25
    modulus = young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    exact = Heave(5.0, 5.0, UNIT_WEIGHT, modulus).total()
    for size in (0.25, 0.125):
        body = {"basis": basis, "anti_locking": anti_locking}
        parts = [
            box("rest", [0.0, 0.0], [size, 5.0], **body),
            box("cover", [0.0, 5.0], [size, 10.0], **body),
        ]
        rollers = [plane("base", "y", 0.0), plane("left", "x", 0.0), plane("right", "x", size)]
        case = entries(
            grid={"cell_size": size},
            bodies=parts,
            boundaries=rollers,
            materials={"soil": elastic(young, poisson)},
            initial={"stress": [at_rest(part["name"], 10.0) for part in parts]},
            stages=[stage("rest"), stage("dig", 10, deactivate=["cover"])],
        )
        analysis, _, results = march(case)
        points = analysis.simulation.state.points
        top = points.position[:, 1].argmax()
        # of the surface, a quarter of a cell above the point; it is not stressed
        stretch = points.deformation_gradient[top, 1, 1]
        surface = points.position[top, 1] + 0.25 * size * stretch
        error.append(abs(surface - 5.0 - exact) / exact)
        weight = 5.0 * UNIT_WEIGHT * size
        assert results[-1].resultant("base")[1] == pytest.approx(weight, rel=1e-8)
    assert error[0] < 1e-3
    assert error[1] < max(0.3 * error[0], 1e-4)


def dug(case: dict[str, Any], *stages: list[str]) -> Floats:
    """Positions of the points that are left after stages that remove these bodies."""
    case["stages"] = [stage("rest")]
    case["stages"] += [stage(f"dig {i}", deactivate=names) for i, names in enumerate(stages)]
    analysis, _, _ = march(case)
    return by_number(analysis.simulation, "position")


@pytest.mark.slow
@pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi2"])
@at_three_places
def test_small_elastic_rebound_does_not_depend_on_the_order(basis: str, shift: float) -> None:
    """Two pits one after the other, in the other order, and both at once."""
    case = pit(shift, basis=basis)
    case["materials"]["soil"] = elastic(1e7)
    first, second, both = ["pit"], ["bank"], ["pit", "bank"]
    start = dug(case)[: len(dug(case, both))]
    one, other, at_once = (
        dug(case, *order) - start for order in ((first, second), (second, first), (both,))
    )
    size = np.abs(at_once).max()
    assert size > 1e-6
    for order in (one, other):
        assert np.abs(order - at_once).max() < part_left(basis, shift) * size


def test_three_dimensions() -> None:
    """A corner of a block is dug: weight and thrusts, equilibrium and the base's reaction."""
    ground = [
        box("ground", [0.0, 0.0, 0.0], [2.0, 2.0, 1.0]),
        box("bank", [1.0, 0.0, 1.0], [2.0, 2.0, 2.0]),
        box("side", [0.0, 1.0, 1.0], [1.0, 2.0, 2.0]),
        box("pit", [0.0, 0.0, 1.0], [1.0, 1.0, 2.0]),
    ]
    sides = [(f"{axis}{at:g}", axis, at) for axis in "xy" for at in (0.0, 2.0)]
    case = entries(
        analysis={"kind": "3d", "tolerance": 1e-10},
        bodies=ground,
        boundaries=[plane("base", "z", 0.0), *(plane(*side) for side in sides)],
        loads=[gravity(3)],
        materials={"soil": elastic(1e6)},
        initial={"stress": [at_rest(part["name"], 2.0, K0) for part in ground]},
        stages=[stage("rest"), stage("dig", deactivate=["pit"])],
    )
    _, starts, results = march(case)
    thrust = 0.5 * K0 * UNIT_WEIGHT
    released = starts["dig"].state.released.force.sum(axis=0)
    assert released == pytest.approx([thrust, thrust, -UNIT_WEIGHT], rel=1e-5)
    total = [float(result.resultant("base")[2]) for result in results]
    assert total == pytest.approx([8.0 * UNIT_WEIGHT, 7.0 * UNIT_WEIGHT], rel=1e-8)


def test_axisymmetric_shaft() -> None:
    """A shaft of 1 m radius: its weight is released, and the lining's thrust is not needed."""
    ground = [
        box("ground", [0.0, 0.0], [3.0, 1.0]),
        box("shaft", [0.0, 1.0], [1.0, 2.0]),
        box("bank", [1.0, 1.0], [3.0, 2.0]),
    ]
    case = entries(
        analysis={"kind": "axisymmetric", "tolerance": 1e-10},
        bodies=ground,
        boundaries=[plane("base", "y", 0.0), plane("outside", "x", 3.0)],
        materials={"soil": elastic(1e6)},
        initial={"stress": [at_rest(part["name"], 2.0, K0) for part in ground]},
        stages=[stage("rest"), stage("dig", 2, deactivate=["shaft"])],
    )
    _, starts, results = march(case)
    released = starts["dig"].state.released.force.sum(axis=0)
    assert released[1] == pytest.approx(-np.pi * UNIT_WEIGHT, rel=1e-4)
    base = float(results[-1].resultant("base")[1])
    assert base == pytest.approx(17.0 * np.pi * UNIT_WEIGHT, rel=1e-8)
    points = starts["dig"].state.points
    wall_of_shaft = (points.position[:, 0] < 1.2) & (points.position[:, 1] > 1.05)
    assert (points.displacement[wall_of_shaft, 0] < 0.0).all()
