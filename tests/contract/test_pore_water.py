# SPDX-License-Identifier: BSD-3-Clause
"""Terms of flowing water: tangents, balance of water, consolidation in closed form."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from consolidating import Pores, with_pores
from small_problems import (
    BASES,
    CORNER_BASES,
    ELASTIC,
    KINDS,
    block_entries,
    dimension,
    rollers,
    spaced,
)

from tilth import Model
from tilth.algebra.unknowns import Unknowns
from tilth.mpm.pore_water import CONSTANT, STORED, Permeability, PoreWater
from tilth.terms.balance import Balance
from tilth.terms.pore_water import PORE_PRESSURE

PERMEABILITIES = (
    CONSTANT, Permeability("kozeny_carman"), Permeability("taylor", 0.3),
    Permeability("power", 4.0),
)  # fmt: skip
E, NU = ELASTIC["young_modulus"], ELASTIC["poisson_ratio"]
CONSTRAINED = E * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))


def balance_in(simulation: Any, before: float, after: float) -> Balance:
    step = simulation.prepare(before, after)
    found: Balance = simulation.balance(step, simulation.soil_on(step.active), holds_others=False)
    return found


RATIOS = {2: ((3.0, 1.0), (1.0, 2.0)), 3: ((3.0, 1.0, 0.5), (1.0, 2.0, 0.0), (0.5, 0.0, 1.5))}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", ["linear", "gimp"])
def test_the_matrix_is_the_derivative_with_ratios(kind: str, basis: str) -> None:
    """Conductivities of all directions, in soil that turned in the step before."""
    directed = Permeability("kozeny_carman", 0.0, RATIOS[dimension(kind)])
    simulation = with_pores(
        Model.from_dict(block_entries(kind, basis, "hencky_elastic")), Pores(0.4, 0.3, directed)
    )
    points, dim = simulation.state.points, dimension(kind)
    points.deformation_gradient[:, :2, :2] = np.array([[0.8, -0.6], [0.6, 0.8]])
    assert not np.allclose(
        simulation.state.points.deformation_gradient[:, :dim, :dim], np.eye(dim), atol=0.1
    )
    compare_with_differences(simulation)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", [*BASES, *CORNER_BASES])
@pytest.mark.parametrize("change", PERMEABILITIES, ids=lambda each: each.law)
@pytest.mark.parametrize("bulk_modulus", [np.inf, 4e3])
def test_the_matrix_is_the_derivative_of_all_residuals(
    kind: str, basis: str, change: Permeability, bulk_modulus: float
) -> None:
    """At large strain, after a step, with pressures that change from node to node."""
    entries = spaced(block_entries(kind, basis, "hencky_elastic"), "graded")
    pores = Pores(0.4, 0.3, change, bulk_modulus)
    compare_with_differences(with_pores(Model.from_dict(entries), pores))


def compare_with_differences(simulation: Any) -> None:
    balance = balance_in(simulation, 0.0, 1.0)
    random = np.random.default_rng(5)
    size = {"u": 3e-2, PORE_PRESSURE: 60.0}
    x, way = (
        Unknowns({n: size[n] * random.normal(size=f.shape) for n, f in balance.fields.items()})
        for _ in range(2)
    )
    matrix, step = balance.space.matrix(), 1e-6
    balance.evaluate(x)
    balance.linearise(x, matrix)
    found = matrix.times(way)
    ahead, behind = (balance.evaluate(x.plus(way, share)) for share in (step, -step))
    for name, values in found.of.items():
        difference = (ahead.of[name] - behind.of[name]) / (2.0 * step)
        scale = np.abs(difference).max()
        np.testing.assert_allclose(values, difference, rtol=0, atol=1e-6 * scale)


def test_the_coupling_is_symmetric_without_time() -> None:
    """Saturated soil, water that cannot be compressed, a step that takes no time."""
    simulation = with_pores(Model.from_dict(block_entries("plane_strain", "gimp")), Pores())
    balance = balance_in(simulation, 0.0, 0.0)
    random = np.random.default_rng(5)
    x = Unknowns({n: 1e-2 * random.normal(size=f.shape) for n, f in balance.fields.items()})
    one, other = (
        Unknowns({n: random.normal(size=f.shape) for n, f in balance.fields.items()})
        for _ in range(2)
    )
    matrix = balance.space.matrix()
    balance.evaluate(x)
    balance.linearise(x, matrix)
    of_one, of_other = matrix.times(one), matrix.times(other)
    ahead = sum(float((other.of[n] * of_one.of[n]).sum()) for n in one.of)
    behind = sum(float((one.of[n] * of_other.of[n]).sum()) for n in one.of)
    assert ahead == pytest.approx(behind, rel=1e-12)


@pytest.mark.parametrize("change", PERMEABILITIES, ids=lambda each: each.law)
def test_derivatives_of_the_water(change: Permeability) -> None:
    random = np.random.default_rng(2)
    water = PoreWater(np.full(9, 0.4), 1.0 + random.random(9), [(slice(None), change)], 50.0)
    jacobian, pressure, step = 0.8 + 0.4 * random.random(9), random.normal(size=9), 1e-6
    by_jacobian, by_pressure = water.stored_derivatives(jacobian, pressure)
    ahead, behind = (water.stored(jacobian + s, pressure) for s in (step, -step))
    np.testing.assert_allclose(by_jacobian, (ahead - behind) / (2.0 * step), rtol=1e-8)
    ahead, behind = (water.stored(jacobian, pressure + s) for s in (step, -step))
    np.testing.assert_allclose(by_pressure, (ahead - behind) / (2.0 * step), rtol=1e-7)
    conductivity, changes = water.conductivities(jacobian)
    ahead, behind = (water.conductivities(jacobian * (1.0 + s))[0] for s in (step, -step))
    np.testing.assert_allclose(changes, (ahead - behind) / (2.0 * step), rtol=0, atol=1e-7)
    np.testing.assert_allclose(water.conductivities(np.ones(9))[0], water.conductivity)
    assert (conductivity > 0.0).all()


@pytest.mark.parametrize(
    ("law", "ratio", "change"),
    [
        (CONSTANT, 1.0, 0.0),
        (Permeability("kozeny_carman"), 0.27, 1.89),
        (Permeability("taylor", 0.5), 10.0**-0.8, 10.0**-0.8 * 3.2 * np.log(10.0)),
        (Permeability("power", 3.0), 0.216, 1.728),
    ],
    ids=lambda each: each.law if isinstance(each, Permeability) else "",
)
def test_the_permeability_of_pores_that_close(
    law: Permeability, ratio: float, change: float
) -> None:
    """From the void ratio 1 to 0.6 (porosity 3/8), computed by hand; other soil keeps its own."""
    water = PoreWater(np.full(3, 0.5), np.array([2.0, 4.0, 8.0]), [(slice(1, 3), law)])
    found, by_jacobian = water.conductivities(np.full(3, 0.8))
    np.testing.assert_allclose(found, [2.0, 4.0 * ratio, 8.0 * ratio], rtol=1e-12)
    np.testing.assert_allclose(by_jacobian, [0.0, 4.0 * change, 8.0 * change], rtol=1e-12)


def test_conductivities_turn_with_the_soil() -> None:
    """A quarter turn exchanges them; stretching along the axes leaves them."""
    law = Permeability("constant", 0.0, ((4.0, 0.0), (0.0, 1.0)))
    water = PoreWater(np.full(3, 0.5), np.ones(3), [(slice(0, 2), law)])
    turn, stretch = np.array([[0.0, -1.0], [1.0, 0.0]]), np.diag([1.5, 0.7])
    found = water.ratios(np.stack([turn @ stretch, stretch, turn]))
    expected = np.stack([np.diag([1.0, 4.0]), np.diag([4.0, 1.0]), np.eye(2)])
    np.testing.assert_allclose(found, expected, atol=1e-14)


CELLS = 12


def column(kind: str, basis: str, load: float, solver: str = "superlu") -> dict[str, Any]:
    """A column of cells of size 1 that cannot widen, loaded on its top at once."""
    dim = dimension(kind)
    entries = block_entries(kind, basis, "hencky_elastic")
    entries["bodies"][0]["shape"]["upper"] = [1.0] * (dim - 1) + [float(CELLS)]
    entries["bodies"][0]["surface"] = {}
    entries["boundaries"] = rollers(kind, 1.0)
    entries["analysis"] |= {"solver": solver, "tolerance": 1e-9}
    top = {"start": [1.0, CELLS], "end": [0.0, CELLS]}
    entries["loads"] = [
        {"type": "surface", "body": "block", "pressure": load, "factor": [[0, 1], [1e9, 1]]} | top
    ]
    entries["schedule"] = {"steps": 1, "end": 1e9}
    return entries


def degree(factor: float) -> float:
    """Terzaghi's degree of consolidation at a time factor."""
    m = 0.5 * np.pi * (2.0 * np.arange(200) + 1.0)
    return float(1.0 - (2.0 / m**2 * np.exp(-(m**2) * factor)).sum())


def settlement(simulation: Any) -> float:
    points = simulation.state.points
    top = points.position[:, 1] > points.position[:, 1].max() - 0.4
    place = points.position[top, 1] - points.displacement[top, 1]
    return -float(np.mean(points.displacement[top, 1] * CELLS / place))


@pytest.mark.parametrize("basis", ["linear", "gimp"])
def test_a_column_consolidates_as_by_terzaghi(basis: str) -> None:
    """The excess pressure begins as the load everywhere, without a chequerboard."""
    load = 1e-4 * CONSTRAINED
    pores = Pores(drained=lambda x: x[:, 1] > CELLS - 1e-9)
    simulation = with_pores(Model.from_dict(column("plane_strain", basis, load)), pores)
    unit = CELLS**2 / CONSTRAINED
    times = [0.0, *(unit * np.array([1e-4, *np.linspace(0.01, 0.5, 50)]))]
    for number, (before, after) in enumerate(pairwise(times)):
        result = simulation.advance(before, after)
        if number == 0:
            low = result.active.position[:, 1] < CELLS - 2.5
            over_load = pores.value[low & (result.active.position[:, 1] > -1e-9), 0] / load
            assert over_load.min() > 0.98
            assert over_load.max() < 1.02
    found = settlement(simulation) / (load * CELLS / CONSTRAINED)
    assert found == pytest.approx(degree(0.5), rel=0.012)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("solver", ["superlu", "multigrid"])
def test_water_is_neither_made_nor_lost(kind: str, solver: str) -> None:
    """What sealed soil stores does not change where it is squeezed and sheared, however much."""
    dim = dimension(kind)
    entries = block_entries(kind, "gimp", "mohr_coulomb", cells=3)
    entries["boundaries"] = rollers(kind, 3.0, sides=False)
    entries["analysis"] |= {"solver": solver, "tolerance": 1e-10}
    entries["loads"] = [{"type": "body_force", "acceleration": [0.0] * (dim - 1) + [-8.0]}]
    pores = Pores(0.4, 1e-2, Permeability("kozeny_carman"))
    simulation = with_pores(Model.from_dict(entries), pores)
    points = simulation.state.points
    before = float((points.initial_volume * points.water[:, STORED]).sum())
    for step in range(4):
        simulation.advance(step / 4, (step + 1) / 4)
    points = simulation.state.points
    after = float((points.initial_volume * points.water[:, STORED]).sum())
    volume = float(points.initial_volume.sum())
    assert abs(after - before) < 1e-9 * volume
    assert np.abs(points.displacement).max() > 0.02
    assert np.abs(pores.value).max() > 5.0
    assert np.ptp(points.water[:, STORED]) > 1e-4  # it flowed


def test_without_drainage_the_volume_stays() -> None:
    """In a step of no time each node keeps the volume of its soil."""
    entries = block_entries("plane_strain", "gimp", cells=4)
    entries["boundaries"] = rollers("plane_strain", 4.0, sides=False)
    entries["loads"] = [{"type": "body_force", "acceleration": [0.0, -6.0]}]
    entries["analysis"]["tolerance"] = 1e-10
    pores = Pores(conductivity=0.0)
    simulation = with_pores(Model.from_dict(entries), pores)
    simulation.advance(0.0, 1.0)
    points = simulation.state.points
    assert points.volume.sum() == pytest.approx(points.initial_volume.sum(), rel=1e-9)
    assert np.abs(points.displacement).max() > 1e-2
