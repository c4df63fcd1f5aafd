# SPDX-License-Identifier: BSD-3-Clause
"""Newton's iteration: quadratic convergence, reactions, line search, failure."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from newton_problems import leaning_block, pressed_block
from small_problems import (
    BASES,
    KINDS,
    STEP_MATERIALS,
    dimension,
)

from tilth.arrays import Floats
from tilth.errors import StepFailed

SQUEEZED: list[tuple[str, dict[str, Any]]] = [
    ("tresca", {}),
    ("mohr_coulomb", {}),
    ("mohr_coulomb", {"dilation_angle": 0.0}),
    ("mohr_coulomb", {"dilation_angle": 30.0}),
    (
        "mohr_coulomb",
        {"residual_cohesion": 20.0, "softening_strain": 0.5, "softening_length": 1.0},
    ),
    ("drucker_prager", {"fit": "extension"}),
    ("modified_cam_clay", {}),
    ("modified_cam_clay", {"overconsolidation_ratio": 3.0, "preconsolidation_pressure": None}),
    ("undrained_mohr_coulomb", {"dilation_angle": 0.0}),
]

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)


def assert_quadratic(residuals: Floats) -> None:
    """r_(k+1) <= C r_k^2 in the last iterations: a tangent that is 0.1 % wrong gains three digits.

    Where the return mapping changes its region the iteration starts anew; hence the last ones.
    """
    tail = residuals[residuals < 0.05]
    clean = tail[tail > 1e-12]  # below that stands round-off
    assert len(clean) >= 2
    assert clean[0] / tail[-1] > 1e6
    constant = tail[1 : len(clean) + 1] / clean[: len(tail) - 1] ** 2
    assert constant[tail[1 : len(clean) + 1] > 1e-12][-2:].max() < 30.0


@every_kind
@every_basis
@pytest.mark.parametrize("material", ["hencky_elastic", "von_mises"])
def test_newton_converges_quadratically(kind: str, basis: str, material: str) -> None:
    elastic = material == "hencky_elastic"
    simulation = leaning_block(kind, basis, material, 60.0 if elastic else 14.0)
    residuals = np.array(simulation.advance(0.0, 1.0).equilibrium.residuals)
    if elastic:
        assert np.abs(simulation.state.points.displacement).max() > 0.15  # of a height of 1.8
    else:
        assert (simulation.state.points.plastic[:, 0] > 1e-3).mean() > 0.5
    assert_quadratic(residuals)


@pytest.mark.slow
@every_kind
@every_basis
@pytest.mark.parametrize("anti_locking", ["none", "f_bar"])
@pytest.mark.parametrize(("law", "changed"), SQUEEZED, ids=str)
def test_newton_converges_quadratically_with_every_soil(
    kind: str, basis: str, law: str, changed: dict[str, Any], anti_locking: str
) -> None:
    """A block is pressed between rough plates far beyond yield: planes, edges and apexes."""
    simulation = pressed_block(kind, basis, law, anti_locking, **changed)
    residuals = np.array(simulation.advance(0.0, 1.0).equilibrium.residuals)
    assert (simulation.state.points.plastic[:, 0] > 1e-4).mean() >= 0.25
    assert_quadratic(residuals[1:])  # nothing loads the block before its plate moves


@every_kind
@every_basis
def test_reactions_balance_the_weight(kind: str, basis: str) -> None:
    simulation = leaning_block(kind, basis, "hencky_elastic", 20.0)
    result = simulation.advance(0.0, 1.0)
    up = dimension(kind) - 1
    weight = 20.0 * simulation.state.points.mass.sum()
    base = result.resultant("base")
    assert base[up] == pytest.approx(weight, rel=1e-6)  # the springs of support.py hold 1e-8
    if kind != "axisymmetric":
        np.testing.assert_allclose(base[:up], -0.3 * weight, rtol=1e-6)
    constrained = result.equilibrium.reaction != 0.0
    at_base = result.active.position[:, up] == 0.0
    assert not constrained[~at_base, up].any()  # free nodes have no reaction


@every_kind
def test_no_load_needs_no_iteration(kind: str) -> None:
    simulation = leaning_block(kind, "gimp", "hencky_elastic", 0.0)
    result = simulation.advance(0.0, 1.0)
    assert result.equilibrium.iterations == 0
    assert not simulation.state.points.displacement.any()


@every_kind
def test_too_few_iterations_fail_and_tell_the_residuals(kind: str) -> None:
    simulation = leaning_block(kind, "linear", "hencky_elastic", 60.0, maximum_iterations=2)
    with pytest.raises(StepFailed, match="no equilibrium after 2 Newton iterations") as failure:
        simulation.advance(0.0, 1.0)
    assert len(failure.value.residuals) == 3
    assert failure.value.residuals[0] > failure.value.residuals[2] > 1e-13


def test_an_inverted_point_is_named() -> None:
    simulation = leaning_block("plane_strain", "linear", "hencky_elastic", 2000.0)
    with pytest.raises(StepFailed, match="inverted") as failure:
        simulation.advance(0.0, 1.0)
    assert failure.value.point in range(len(simulation.state.points))


def test_line_search_takes_a_step_that_plain_newton_cannot() -> None:
    load = 300.0
    plain = leaning_block("plane_strain", "linear", "hencky_elastic", load)
    with pytest.raises(StepFailed):
        plain.advance(0.0, 1.0)
    searching = leaning_block("plane_strain", "linear", "hencky_elastic", load, line_search=True)
    residuals = searching.advance(0.0, 1.0).equilibrium.residuals
    assert residuals[-1] <= 1e-13


def test_line_search_finds_the_same_equilibrium() -> None:
    plain = leaning_block("plane_strain", "gimp", "von_mises", 14.0)
    searching = leaning_block("plane_strain", "gimp", "von_mises", 14.0, line_search=True)
    plain.advance(0.0, 1.0)
    searching.advance(0.0, 1.0)
    np.testing.assert_allclose(
        searching.state.points.position, plain.state.points.position, rtol=0, atol=1e-11
    )


@pytest.mark.slow
@every_kind
@every_basis
@pytest.mark.parametrize("material", STEP_MATERIALS)
def test_external_work_is_stored_or_dissipated(kind: str, basis: str, material: str) -> None:
    """Loads in ever smaller steps: the trapezoidal work tends to the energy that is there."""
    gaps = []
    for steps in (4, 8):
        simulation = leaning_block(kind, basis, material, 10.0)
        work = 0.0
        for k in range(steps):
            work += simulation.advance(k / steps, (k + 1) / steps).work
        points = simulation.state.points
        energy = (
            simulation.state.points.stored_energy() + points.plastic[:, 1] @ points.initial_volume
        )
        gaps.append(abs(work - energy) / work)
    assert gaps[1] < 0.03
    assert gaps[1] < 1e-3 or gaps[1] < 0.7 * gaps[0]


@every_kind
@pytest.mark.parametrize("material", ["hencky_elastic", "von_mises"])
def test_domains_do_not_slip_past_a_fixed_base(kind: str, material: str) -> None:
    """Domains that swell beyond a constrained plane must not be let go by the nodes behind it."""
    displacement = {}
    for basis in BASES:
        simulation = leaning_block(kind, basis, material, 10.0)
        for k in range(8):
            simulation.advance(k / 8, (k + 1) / 8)
        displacement[basis] = np.abs(simulation.state.points.displacement).max()
    for basis in BASES:
        assert displacement[basis] == pytest.approx(displacement["linear"], rel=0.06), basis
