# SPDX-License-Identifier: BSD-3-Clause
"""What every law must satisfy: tangent, energy, dissipation, moduli, and what it declares.

Everything follows from what a law declares of itself (`tilth.model.laws`), not from its name.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from law_updates import BULK, SHEAR, around_start, deviator, effective, update, updates
from small_problems import (
    MATERIALS,
    VARIANTS,
    initial_state,
    parameters,
    tensor,
)

from tilth import _core
from tilth.arrays import Floats
from tilth.model.laws import laws

every_material = pytest.mark.parametrize("material", MATERIALS)

every_variant = pytest.mark.parametrize(("material", "changed"), VARIANTS)


def diagonal(principal: Floats) -> Floats:
    """Principal values as a tensor in six components, shape (1, 6)."""
    return np.concatenate([principal, np.zeros(3)])[None]


def moduli(material: str, elastic: Floats, state: Floats) -> tuple[float, float]:
    """Bulk and shear modulus at an elastic strain."""
    bulk, shear, young = (np.full(1, np.nan) for _ in range(3))
    _core.elastic_moduli(
        "3d", material, parameters(material), diagonal(np.expm1(2.0 * elastic)), state[None],
        bulk, shear, young,
    )  # fmt: skip
    assert young == pytest.approx(9 * bulk * shear / (3 * bulk + shear), rel=1e-14)
    return float(bulk[0]), float(shear[0])


def energy(material: str, elastic: Floats, state: Floats) -> float:
    """Stored energy per initial volume at an elastic strain."""
    density = np.full(1, np.nan)
    deformation = diagonal(np.expm1(2.0 * elastic))
    _core.stored_energy("3d", material, parameters(material), deformation, state[None], density)
    return float(density[0])


TRIALS = {
    "elastic": [0.01, -0.005, 0.002],
    "plastic": [0.2, -0.1, 0.03],
    "compressed": [-0.5, -0.1, -0.3],
    "far outside": [3.0, -2.0, 0.5],
    "just yielding": [0.0521, -0.0260, -0.0260],
    "equal pair": [0.1, 0.1, -0.3],
    "nearly equal pair": [0.1, 0.1 + 1e-9, -0.3],
    "equal triple": [0.2, 0.2, 0.2],
    "near the apex": [0.2, 0.2 + 1e-7, 0.2 - 2e-7],
    "zero": [0.0, 0.0, 0.0],
    "pure shear": [0.2, 0.0, -0.2],
}
every_trial = pytest.mark.parametrize("trial", list(TRIALS.values()), ids=list(TRIALS))


def along(
    material: str, centre: Floats, direction: Floats, step: float, plastic: float, **changed: Any
) -> tuple[Floats, bool]:
    """Derivative of the stress along a direction by differences, and whether there is none.

    There is none where the state is on the border of two regions of the return mapping: the
    differences to both sides are not equal then.
    """
    ahead, here, behind = (
        update(material, centre + sign * step * direction, plastic, **changed).stress
        for sign in (1.0, 0.0, -1.0)
    )
    kink = np.abs(ahead - 2 * here + behind).max() > 1e-3 * step * BULK
    return (ahead - behind) / (2 * step), bool(kink)


@every_variant
@every_trial
@pytest.mark.parametrize("plastic_strain", [0.0, 0.3])
def test_tangent_is_the_derivative_of_the_stress(
    material: str, changed: dict[str, Any], trial: list[float], plastic_strain: float
) -> None:
    centre = around_start(material, trial, **changed)
    tangent = update(material, centre, plastic_strain, **changed).tangent
    scale = max(BULK, np.abs(tangent).max())
    for axis, direction in enumerate(np.eye(3)):
        errors = []
        for step in (1e-4, 1e-5, 1e-6):
            slope, kink = along(material, centre, direction, step, plastic_strain, **changed)
            errors.append(0.0 if kink else np.abs(slope - tangent[:, axis]).max() / scale)
        assert min(errors) < 1e-8


@every_variant
def test_tangent_of_every_random_state(material: str, changed: dict[str, Any]) -> None:
    random = np.random.default_rng(1)
    kinks = 0
    for _ in range(300):
        centre = random.normal(size=3) * 10.0 ** random.uniform(-3, 0)
        centre = around_start(material, centre, **changed)
        plastic_strain = random.uniform(0, 0.2)
        here = update(material, centre, plastic_strain, **changed)
        direction = random.normal(size=3)
        scale = max(BULK, np.abs(here.tangent).max())
        errors = []
        for step in (1e-6, 1e-7):
            slope, kink = along(material, centre, direction, step, plastic_strain, **changed)
            kinks += kink
            errors.append(0.0 if kink else np.abs(here.tangent @ direction - slope).max() / scale)
        assert min(errors) < 1e-7
    assert kinks < 30


@pytest.mark.parametrize("material", [m for m in MATERIALS if laws()[m].symmetric_tangent])
@every_trial
def test_tangent_is_symmetric_where_the_law_says_so(material: str, trial: list[float]) -> None:
    """Hyperelasticity and associated flow: stress has a potential in each step."""
    tangent = update(material, around_start(material, trial)).tangent
    np.testing.assert_allclose(tangent, tangent.T, rtol=0, atol=1e-13 * np.abs(tangent).max())


@every_material
@every_trial
def test_order_of_the_axes_does_not_matter(material: str, trial: list[float]) -> None:
    one = update(material, around_start(material, trial), 0.1)
    for order in ([1, 2, 0], [2, 1, 0]):
        other = update(material, around_start(material, trial)[order], 0.1)
        np.testing.assert_allclose(other.stress, one.stress[order], rtol=1e-13, atol=1e-12)
        np.testing.assert_allclose(
            other.tangent, one.tangent[np.ix_(order, order)], rtol=1e-12, atol=1e-10
        )


@every_material
def test_stress_is_the_derivative_of_the_stored_energy(material: str) -> None:
    """Also of states that have flown: stress and energy belong to the elastic strain alone."""
    random = np.random.default_rng(2)
    for _ in range(100):
        found = update(
            material,
            around_start(material, random.normal(size=3) * 10.0 ** random.uniform(-3, 0)),
            0.05,
        )
        step = 1e-5 * max(1e-2, np.abs(found.elastic).max())
        slope = [
            (
                energy(material, found.elastic + shift, found.state)
                - energy(material, found.elastic - shift, found.state)
            )
            / (2 * step)
            for shift in step * np.eye(3)
        ]
        scale = np.abs(found.stress).max()
        np.testing.assert_allclose(found.stress, slope, rtol=0, atol=1e-7 * scale)


@every_material
def test_elastic_tangent_has_the_moduli_that_the_law_declares(material: str) -> None:
    """Bulk and shear modulus are what a volume and a shape change meet while nothing flows."""
    random = np.random.default_rng(7)
    for _ in range(50):
        trial = around_start(material, 0.01 * random.normal(size=3))
        found = update(material, trial)
        assert np.array_equal(found.elastic, trial), "these states are elastic"
        shape = deviator(random.normal(size=3))
        shape /= np.linalg.norm(shape)
        bulk, shear = moduli(material, trial, found.state)
        assert found.tangent.sum() / 9.0 == pytest.approx(bulk, rel=1e-10)
        assert shape @ found.tangent @ shape / 2.0 == pytest.approx(shear, rel=1e-10)


@every_material
def test_elastic_strain_of_a_stress_has_this_stress(material: str) -> None:
    """A starting stress becomes the elastic strain that causes it, whatever its axes."""
    random = np.random.default_rng(8)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    for _ in range(50):
        found = update(
            material, around_start(material, random.normal(size=3) * 10.0 ** random.uniform(-3, 0))
        )
        full = turn @ np.diag(found.stress) @ turn.T
        stress = full[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]][None].copy()
        deformation = np.full((1, 6), np.nan)
        failed = _core.elastic_deformation_of(
            "3d", material, parameters(material), stress, found.state[None], deformation
        )
        assert failed == -1
        expected = turn @ np.diag(np.expm1(2 * found.elastic)) @ turn.T
        np.testing.assert_allclose(
            tensor(deformation[0]), expected, rtol=0, atol=1e-12 * np.abs(expected).max()
        )


@every_material
def test_trial_states_of_points_are_returned_as_single_ones(material: str) -> None:
    """Of any number of points, in any axes; plastic strain and dissipation are added up."""
    random = np.random.default_rng(9)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    trials = around_start(
        material, random.normal(size=(19, 3)) * 10.0 ** random.uniform(-3, 0, (19, 1))
    )
    full = np.einsum("ik,nk,jk->nij", turn, np.expm1(2 * trials), turn)
    deformation = full[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]].copy()
    state = np.tile(initial_state(material), (19, 1))
    before = np.tile([0.05, 7.0], (19, 1))
    elastic, plastic, stress = np.empty((19, 6)), np.empty((19, 2)), np.empty((19, 6))
    after, good = np.empty_like(state), np.zeros(19, dtype=bool)
    _core.return_to_law(
        "3d", material, parameters(material), deformation, before, state,
        elastic, plastic, after, stress, good,
    )  # fmt: skip
    assert good.all()
    for n, trial in enumerate(trials):
        single = update(material, trial, 0.05)
        flow = trial - single.elastic
        expected = turn @ np.diag(single.stress) @ turn.T
        np.testing.assert_allclose(tensor(stress[n]), expected, rtol=0, atol=1e-10 * SHEAR)
        expected = turn @ np.diag(np.expm1(2 * single.elastic)) @ turn.T
        np.testing.assert_allclose(tensor(elastic[n]), expected, rtol=0, atol=1e-12)
        np.testing.assert_allclose(after[n], single.state, rtol=1e-10)
        grown = np.sqrt(2 / 3) * np.linalg.norm(deviator(flow)), effective(material, single) @ flow
        np.testing.assert_allclose(plastic[n] - before[n], grown, rtol=0, atol=1e-11 * SHEAR)


@every_material
def test_state_variables_have_names_units_and_initial_values(material: str) -> None:
    law = laws()[material]
    assert set(law.state_variables.values()) <= {"stress", "-"}
    assert all(name.isidentifier() for name in law.state_variables)
    assert np.isfinite(initial_state(material)).all()


@pytest.mark.slow
@every_material
def test_dissipation_is_not_negative(material: str) -> None:
    random = np.random.default_rng(3)
    for _ in range(300):
        trial = around_start(material, random.normal(size=3) * 10.0 ** random.uniform(-3, 0.5))
        found = update(material, trial, random.uniform(0, 0.3))
        plastic = trial - found.elastic
        assert (
            effective(material, found) @ plastic
            >= -1e-13 * np.abs(found.stress).max() * np.abs(trial).max()
        )


@every_material
def test_second_return_mapping_changes_nothing(material: str) -> None:
    """A state on the yield surface is admissible: loading stops, nothing flows."""
    random = np.random.default_rng(4)
    for _ in range(100):
        trial = around_start(material, random.normal(size=3) * 10.0 ** random.uniform(-3, 0.5))
        first = update(material, trial, 0.0)
        flow = trial - first.elastic
        plastic_strain = float(np.sqrt(2 / 3) * np.linalg.norm(deviator(flow)))
        again = update(material, first.elastic, plastic_strain, first.state)
        np.testing.assert_allclose(again.stress, first.stress, rtol=1e-12, atol=1e-9)


@every_material
def test_work_along_a_closed_elastic_path_is_zero(material: str) -> None:
    """Inside the elastic range no strain cycle produces or swallows energy."""
    works = []
    for parts in (2000, 4000):
        angle = np.linspace(0.0, 2 * np.pi, parts + 1)
        path = 0.01 * np.stack([np.cos(angle), np.sin(2 * angle), np.sin(angle + 1)], axis=1)
        path = around_start(material, path)
        found, good = updates(material, path, np.zeros(len(path)), initial_state(material))
        assert good.all()
        assert np.array_equal(found.elastic, path)
        each = (0.5 * (found.stress[1:] + found.stress[:-1]) * np.diff(path, axis=0)).sum(axis=1)
        works.append(each.sum())
    # the trapezoidal rule's error falls to a quarter with half the step
    assert abs((4.0 * works[1] - works[0]) / 3.0) < 1e-12 * np.abs(each).sum()


@every_material
def test_small_strain_is_linear_elastic(material: str) -> None:
    strain = np.array([1e-9, -3e-9, 5e-10])
    start = update(material, around_start(material, np.zeros(3)))
    found = update(material, start.elastic + strain)
    bulk, shear = moduli(material, start.elastic, start.state)
    expected = bulk * strain.sum() + 2 * shear * deviator(strain)
    size = np.abs(start.stress).max()
    np.testing.assert_allclose(found.stress - start.stress, expected, rtol=1e-7, atol=1e-13 * size)


def test_names_of_unknown_materials_are_refused() -> None:
    with pytest.raises(ValueError, match="unknown material 'jelly'"):
        _core.elastic_moduli(
            "3d", "jelly", np.ones(2), np.zeros((1, 6)), np.zeros((1, 0)), *np.ones((3, 1))
        )
