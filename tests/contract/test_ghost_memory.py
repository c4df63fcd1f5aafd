# SPDX-License-Identifier: BSD-3-Clause
"""What ghost stabilisation remembers from step to step, and the elastic share that it follows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from balances import residual_at
from ghost_blocks import block
from small_problems import (
    KINDS,
    SPACINGS,
    affine,
    block_entries,
    material_entries,
)

from tilth import Model, _core
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.grid.keys import find_keys
from tilth.model.laws import laws
from tilth.terms.balance import Balance
from tilth.terms.ghost import Ghost
from tilth.terms.linear import LinearForces

every_kind = pytest.mark.parametrize("kind", KINDS)
every_spacing = pytest.mark.parametrize("spacing", SPACINGS)
GAMMA = 0.005
FORGOTTEN_STRAIN = 1e-6
"""Strain after which the elastic share is that of the last step (`PointRange.forgotten_strain`)."""


@every_kind
@every_spacing
def test_the_stored_force_decays_by_the_motion_in_cells(kind: str, spacing: str) -> None:
    """By exp(-|u| / 0.1 h) with h the mean size of the two cells along each component of u."""
    simulation, active = block(kind, "gimp", 0.3, spacing=spacing)
    soil, free = simulation.soil_on(active), np.zeros((active.nodes, active.grid.dim), dtype=bool)
    grid, dim = active.grid, active.grid.dim
    for component in range(dim):
        ghost = Ghost(GAMMA, dim)
        ghost.couplings(soil, free)
        u = np.zeros(free.shape)
        u[:, component] = np.random.default_rng(6).uniform(-0.05, 0.05, active.nodes)
        ghost.commit(active, u)
        number = 0
        for faces in ghost.faces:
            low = np.asarray(_core.lattice(active.key[faces.node[:, 0]]))[:, :dim]
            high = low + np.eye(dim, dtype=np.int64)[faces.axis]
            size = np.stack([grid.sizes(low), grid.sizes(high)]).mean(axis=0)
            np.testing.assert_allclose(faces.size, size, rtol=1e-12)
            step = u[faces.node]
            most = np.abs(step[..., component]).max(axis=1) / size[:, component]
            stored = faces.modulus[:, None, None] * (step - step[:, :1])
            stored *= np.exp(-most / 0.1)[:, None, None]
            face = 8 * active.key[faces.node[:, 0]] + faces.axis
            kept = ghost.moved[find_keys(ghost.face, face)]
            np.testing.assert_allclose(kept, stored, rtol=1e-12, atol=0)
            number += len(face)
        assert number == len(ghost.face) > 0


@every_kind
def test_what_is_not_held_in_a_step_is_not_held_later_for_it(kind: str) -> None:
    """A layer of nodes is prescribed in a step and free in the next: its motion left no force."""
    simulation, active = block(kind, "gimp", 0.3)
    soil, free = simulation.soil_on(active), np.zeros((active.nodes, active.grid.dim), dtype=bool)
    layer = active.lattice[:, 0].max() - active.lattice[:, 0]
    held, u = free.copy(), np.zeros(free.shape)
    held[layer == 0] = True
    u[layer == 0] = np.random.default_rng(7).normal(size=u[layer == 0].shape)
    for constrained, has_force in ((held, False), (free, True)):
        ghost = Ghost(GAMMA, active.grid.dim)
        ghost.couplings(soil, constrained)
        ghost.commit(active, u)
        kept = LinearForces(ghost.couplings(soil, free))
        force = residual_at(Balance(active, [kept]), np.zeros(u.shape)).u
        assert force[layer == 2].any() == has_force


@every_kind
def test_the_stored_force_falls_as_soil_softens(kind: str) -> None:
    """With the modulus, to a quarter; not where materials are exchanged."""
    simulation, active = block(kind, "gimp", 0.3)
    free = np.zeros((active.nodes, active.grid.dim), dtype=bool)

    def force(ghost: Ghost, share: float) -> np.ndarray:
        simulation.state.points.elastic_share[:] = share
        term = LinearForces(ghost.couplings(simulation.soil_on(active), free))
        return residual_at(Balance(active, [term]), np.zeros(free.shape)).u

    ghost = Ghost(GAMMA, active.grid.dim)
    force(ghost, 1.0)
    ghost.commit(active, np.random.default_rng(8).uniform(-0.01, 0.01, free.shape))
    before = force(ghost, 1.0)
    assert before.any()
    np.testing.assert_allclose(force(ghost, 0.25), 0.25 * before, rtol=1e-12, atol=1e-17)
    ghost.keep_forces()
    np.testing.assert_array_equal(force(ghost, 0.25), before)


def test_elastic_share_of_a_strain() -> None:
    """Simple shear: all of it before yield, none in steady flow, the right share between.

    What it was before a step is forgotten over a strain; steps in which nothing moves do not count.
    """
    material = material_entries("von_mises", yield_stress=0.06, hardening_modulus=0.0)
    modulus, ratio = material["young_modulus"], material["poisson_ratio"]
    at_yield = material["yield_stress"] / np.sqrt(3.0) * 2.0 * (1.0 + ratio) / modulus
    steps = 8
    entries = block_entries("plane_strain", "linear")
    entries["materials"]["soil"] = material
    # half of the fourth step is elastic
    shear = steps * at_yield / 3.5
    still = [[0.0, 0.0], [1.0, 1.0], [1.25, 1.0]]  # two further steps in which nothing moves
    entries["boundaries"] = [affine(np.array([[1.0, shear], [0.0, 1.0]])) | {"factor": still}]
    entries["schedule"] = {"steps": steps + 2, "end": 1.25}
    shares = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        shares.append(simulation.state.points.elastic_share.copy())

    march(Model.from_dict(entries), after_step)
    kept = np.exp(-shear / steps / np.sqrt(2.0) / FORGOTTEN_STRAIN)
    expected = [1.0]
    for share in [1.0, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0]:
        expected.append(share + (expected[-1] - share) * kept)
    for found, each in zip(shares, expected[1:] + 2 * expected[-1:], strict=True):
        np.testing.assert_allclose(found, each, atol=1e-3)


def test_soil_with_friction_remembers_its_elastic_share_longer() -> None:
    """Soil at rest yields by friction in one step of next to no strain and not in the next one."""
    range_ = block("plane_strain", "linear", 0.0)[0].state.points.ranges[0]
    for name, law in laws().items():
        frictional = name.endswith(("mohr_coulomb", "drucker_prager"))
        expected = 300.0 * FORGOTTEN_STRAIN if frictional else FORGOTTEN_STRAIN
        assert replace(range_, law=law).forgotten_strain == pytest.approx(expected, rel=1e-12), name
