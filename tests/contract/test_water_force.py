# SPDX-License-Identifier: BSD-3-Clause
"""The force of water at rest: its tangent, its totals for any level, and what does not matter."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from balances import space_of
from small_problems import BASES, KINDS, Laboratory, block_entries, dimension, weight

from tilth import Model
from tilth.errors import StepFailed
from tilth.model import Water
from tilth.mpm.initial_points import initial_points
from tilth.mpm.water import PhreaticSurface
from tilth.terms.loads import Loads
from tilth.terms.water import WaterForces

GAMMA = 10.0
LEVELS = {2: [[-5.0, 0.2], [0.7, 1.1], [9.0, 1.6]], 3: 1.1}
SOILS: dict[str, dict[str, Any]] = {
    "draining": {"saturated_density": 3.0},
    "watertight": {"watertight": True},
    "undrained": {"saturated_density": 3.0, "pore_fluid_bulk_modulus": 500.0},
}


def term_of(
    kind: str, basis: str, soil: dict[str, Any], seed: int = 1, **water: Any
) -> tuple[Laboratory, WaterForces]:
    """A deformed block of 2 cells with jittered points, and the water's term in its next step."""
    random = np.random.default_rng(seed)
    changed = {"loads": [weight(kind, 4.0) | {"factor": [[0.0, 1.0], [1.0, 1.0]]}]}
    laboratory = Laboratory.of(kind, basis, "hencky_elastic", random)
    laboratory.step(laboratory.random_displacement(random, 0.03))
    entries = block_entries(kind, basis, **changed)
    entries["materials"]["soil"] |= soil
    entries["water"] = {"level": LEVELS[dimension(kind)], "unit_weight": GAMMA, **water}
    model = Model.from_dict(entries)
    (body,), (declared,) = laboratory.points.ranges, initial_points(model).ranges
    wet = {"wet_density": declared.wet_density, "keeps_water": declared.keeps_water}
    laboratory.points.ranges[:] = [replace(body, **wet)]
    surface = PhreaticSurface.of(model)
    assert surface is not None
    loads = Loads(model, laboratory.points)
    return laboratory, WaterForces(surface, loads, laboratory.soil, 0.0, 1.0)


@pytest.mark.parametrize("soil", SOILS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("kind", KINDS)
def test_tangent_is_the_derivative_of_the_force(kind: str, basis: str, soil: str) -> None:
    laboratory, term = term_of(kind, basis, SOILS[soil])
    random = np.random.default_rng(2)
    u, way = (laboratory.random_displacement(random, size) for size in (0.02, 1.0))
    step = 1e-6
    assembled = term.assembled(space_of(laboratory.active), [])
    ahead, behind = (assembled.force(u + sign * step * way) for sign in (1.0, -1.0))
    difference = (ahead - behind) / (2.0 * step)
    blocks = np.zeros((len(laboratory.active.column), *(2 * [way.shape[1]])))
    assembled.force(u)
    assembled.add_stiffness(u, blocks)
    rows = np.repeat(np.arange(laboratory.active.nodes), np.diff(laboratory.active.row_start))
    found = np.zeros_like(u)
    np.add.at(found, rows, np.einsum("nij,nj->ni", blocks, way[laboratory.active.column]))
    size = np.abs(difference).max()
    assert size > 0.2, "some domains are cut by the level"
    np.testing.assert_allclose(found, difference, rtol=0, atol=1e-6 * size)


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("kind", KINDS)
def test_soil_under_water_is_lifted_by_what_it_displaces(kind: str, basis: str) -> None:
    """A watertight body by its current volume; draining soil by that of the grains and its pores.

    What water leaves the pores is weight that is missing: it changes nothing.
    """
    for soil in SOILS:
        laboratory, term = term_of(kind, basis, SOILS[soil], level=50.0)
        u = laboratory.random_displacement(np.random.default_rng(3), 0.02)
        initial = laboratory.points.initial_volume.sum()
        found = term.nodal(term.wetted(u)).sum(axis=0)
        laboratory.soil.update(u)
        laboratory.soil.advance(u, laboratory.soil.moved_domains(u))
        volume = initial if soil == "draining" else laboratory.points.volume.sum()
        pores = 0.0 if soil == "watertight" else 1.0 * 4.0 * initial  # added mass
        expected = np.zeros(dimension(kind))
        expected[-1] = GAMMA * volume - pores
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * GAMMA * volume)


@pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi1", "cpdi2"])
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_a_level_anywhere_wets_the_right_volume(kind: str, basis: str) -> None:
    """Undeformed points fill the block: any level cuts them at its height, to round-off."""
    dim = dimension(kind)
    for level in (0.0, 0.1, 0.25, 0.6, 0.9999, 1.0, 1.37, 2.0, 2.5):
        entries = block_entries(kind, basis)
        entries["materials"]["soil"] |= {"watertight": True}
        entries["water"] = {"level": level, "unit_weight": GAMMA}
        model = Model.from_dict(entries)
        laboratory = Laboratory.of(kind, basis, "hencky_elastic", np.random.default_rng(1))
        laboratory.points.position[:] = initial_points(model).position
        laboratory.locate()
        surface = PhreaticSurface.of(model)
        assert surface is not None
        term = WaterForces(surface, Loads(model, laboratory.points), laboratory.soil, 0.0, 1.0)
        lift = term.nodal(term.wetted(np.zeros((laboratory.active.nodes, dim)))).sum(axis=0)
        expected = GAMMA * min(level, 2.0) * 2.0 ** (dim - 1)
        np.testing.assert_allclose(lift[-1], expected, rtol=1e-13, atol=1e-12)
        assert np.abs(lift[:-1]).max() < 1e-12


def test_force_at_the_start_is_that_of_the_level_then() -> None:
    """Of a falling level, with the unit weight of that time; the force is that of its end."""
    laboratory, term = term_of(
        "plane_strain", "gimp", SOILS["watertight"], initial_level=50.0, level=-50.0,
        factor=[[0.0, 0.5], [1.0, 1.0]],
    )  # fmt: skip
    before = term.assembled(space_of(laboratory.active), []).load_before()
    assert before is not None
    expected = 0.5 * GAMMA * laboratory.points.volume.sum()
    np.testing.assert_allclose(before.sum(axis=0), [0.0, expected], rtol=0, atol=1e-11)
    assert not term.nodal(term.wetted(np.zeros_like(before))).any()


def test_soil_that_moves_into_the_water_needs_a_density_there() -> None:
    """Also in the middle of an analysis: the step fails and says why."""
    with pytest.raises(StepFailed, match="saturated_density moved below the water") as failure:
        term_of("plane_strain", "gimp", {})
    assert "watertight" in failure.value.remedy
    assert failure.value.point is not None


def test_an_inverted_point_fails_the_step() -> None:
    laboratory, term = term_of("plane_strain", "gimp", SOILS["draining"])
    inverted = laboratory.active.position @ np.diag([-2.0, 0.0])
    with pytest.raises(StepFailed, match="inverted"):
        term.wetted(inverted)


def test_water_is_declared_in_python_too() -> None:
    water = Water(level=((0.0, 1.0), (2.0, 1.5)), unit_weight=9.81, initial_level=2.0)
    assert water.level == ((0.0, 1.0), (2.0, 1.5))
