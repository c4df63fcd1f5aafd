# SPDX-License-Identifier: BSD-3-Clause
"""What every law must satisfy: tangent, energy, dissipation, moduli, and what it declares.

Everything follows from what a law declares of itself (`tilth.model.laws`), not from its name.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from small_problems import EXTREME, MATERIALS, parameters, tensor

from tilth import _core
from tilth.arrays import Floats
from tilth.model.laws import laws

every_material = pytest.mark.parametrize("material", MATERIALS)

VARIANTS = [
    (material, changed)
    for material in MATERIALS
    for changed in [
        {},
        *({name: value} for name in laws()[material].parameters for value in EXTREME.get(name, ())),
    ]
]
every_variant = pytest.mark.parametrize(("material", "changed"), VARIANTS)

BULK = 1000.0 / (3 * (1 - 2 * 0.3))
SHEAR = 1000.0 / (2 * 1.3)


@dataclass
class Update:
    """Result of a return mapping in principal axes."""

    stress: Floats
    elastic: Floats
    tangent: Floats
    state: Floats


def initial_state(material: str, **changed: float) -> Floats:
    """State variables of an undeformed point."""
    state = np.full(len(laws()[material].state_variables), np.nan)
    _core.initial_state(material, parameters(material, **changed), state)
    return state


def update(
    material: str,
    trial: Floats,
    plastic_strain: float = 0.0,
    state: Floats | None = None,
    **changed: float,
) -> Update:
    before = initial_state(material, **changed) if state is None else state
    after = np.full_like(before, np.nan)
    stress, elastic, tangent = np.full(3, np.nan), np.full(3, np.nan), np.full((3, 3), np.nan)
    good = _core.principal_update(
        material, parameters(material, **changed), np.asarray(trial, dtype=float),
        plastic_strain, before, after, stress, elastic, tangent,
    )  # fmt: skip
    assert good
    assert np.isfinite(after).all(), "a law fills all its state variables"
    return Update(stress, elastic, tangent, after)


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


def deviator(a: Floats) -> Floats:
    return np.asarray(a - np.mean(a))


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


@every_variant
@every_trial
@pytest.mark.parametrize("plastic_strain", [0.0, 0.3])
def test_tangent_is_the_derivative_of_the_stress(
    material: str, changed: dict[str, float], trial: list[float], plastic_strain: float
) -> None:
    centre = np.array(trial)
    tangent = update(material, centre, plastic_strain, **changed).tangent
    errors = []
    for step in (1e-4, 1e-5, 1e-6):
        slope = np.empty((3, 3))
        for b in range(3):
            shift = np.zeros(3)
            shift[b] = step
            above = update(material, centre + shift, plastic_strain, **changed)
            below = update(material, centre - shift, plastic_strain, **changed)
            slope[:, b] = (above.stress - below.stress) / (2 * step)
        errors.append(np.abs(slope - tangent).max() / np.abs(tangent).max())
    assert min(errors) < 1e-8


@every_material
def test_tangent_of_every_random_state(material: str) -> None:
    random = np.random.default_rng(1)
    step = 1e-6
    for _ in range(300):
        centre = random.normal(size=3) * 10.0 ** random.uniform(-3, 0)
        plastic_strain = random.uniform(0, 0.2)
        here = update(material, centre, plastic_strain)
        direction = random.normal(size=3)
        above = update(material, centre + step * direction, plastic_strain)
        below = update(material, centre - step * direction, plastic_strain)
        if any(
            (np.abs(side.elastic - c) > 0).any() != (np.abs(here.elastic - centre) > 0).any()
            for side, c in ((above, centre + step * direction), (below, centre - step * direction))
        ):
            continue  # the yield surface lies between: no derivative there
        slope = (above.stress - below.stress) / (2 * step)
        scale = np.abs(here.tangent).max()
        np.testing.assert_allclose(here.tangent @ direction, slope, rtol=0, atol=1e-7 * scale)


@pytest.mark.parametrize("material", [m for m in MATERIALS if laws()[m].symmetric_tangent])
@every_trial
def test_tangent_is_symmetric_where_the_law_says_so(material: str, trial: list[float]) -> None:
    """Hyperelasticity and associated flow: stress has a potential in each step."""
    tangent = update(material, np.array(trial)).tangent
    np.testing.assert_allclose(tangent, tangent.T, rtol=0, atol=1e-13 * np.abs(tangent).max())


@every_material
@every_trial
def test_order_of_the_axes_does_not_matter(material: str, trial: list[float]) -> None:
    one = update(material, np.array(trial), 0.1)
    for order in ([1, 2, 0], [2, 1, 0]):
        other = update(material, np.array(trial)[order], 0.1)
        np.testing.assert_allclose(other.stress, one.stress[order], rtol=1e-13, atol=1e-12)
        np.testing.assert_allclose(
            other.tangent, one.tangent[np.ix_(order, order)], rtol=1e-12, atol=1e-10
        )


@every_material
def test_stress_is_the_derivative_of_the_stored_energy(material: str) -> None:
    """Also of states that have flown: stress and energy belong to the elastic strain alone."""
    random = np.random.default_rng(2)
    for _ in range(100):
        found = update(material, random.normal(size=3) * 10.0 ** random.uniform(-3, 0), 0.05)
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
        trial = 0.01 * random.normal(size=3)
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
        found = update(material, random.normal(size=3) * 10.0 ** random.uniform(-3, 0))
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
    trials = random.normal(size=(19, 3)) * 10.0 ** random.uniform(-3, 0, (19, 1))
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
        grown = np.sqrt(2 / 3) * np.linalg.norm(deviator(flow)), single.stress @ flow
        np.testing.assert_allclose(plastic[n] - before[n], grown, rtol=0, atol=1e-11 * SHEAR)


@every_material
def test_state_variables_have_names_units_and_initial_values(material: str) -> None:
    law = laws()[material]
    assert set(law.state_variables.values()) <= {"stress", "-"}
    assert all(name.isidentifier() for name in law.state_variables)
    assert np.isfinite(initial_state(material)).all()


@every_material
def test_dissipation_is_not_negative(material: str) -> None:
    random = np.random.default_rng(3)
    for _ in range(300):
        trial = random.normal(size=3) * 10.0 ** random.uniform(-3, 0.5)
        found = update(material, trial, random.uniform(0, 0.3))
        plastic = trial - found.elastic
        assert found.stress @ plastic >= -1e-13 * np.abs(found.stress).max() * np.abs(trial).max()


@every_material
def test_second_return_mapping_changes_nothing(material: str) -> None:
    """A state on the yield surface is admissible: loading stops, nothing flows."""
    random = np.random.default_rng(4)
    for _ in range(100):
        trial = random.normal(size=3) * 10.0 ** random.uniform(-3, 0.5)
        first = update(material, trial, 0.0)
        flow = trial - first.elastic
        plastic_strain = float(np.sqrt(2 / 3) * np.linalg.norm(deviator(flow)))
        again = update(material, first.elastic, plastic_strain, first.state)
        np.testing.assert_allclose(again.stress, first.stress, rtol=1e-12, atol=1e-9)


@every_material
def test_work_along_a_closed_elastic_path_is_zero(material: str) -> None:
    """Inside the elastic range no strain cycle produces or swallows energy."""
    angle = np.linspace(0.0, 2 * np.pi, 4001)
    path = 0.01 * np.stack([np.cos(angle), np.sin(2 * angle), np.sin(angle + 1)], axis=1)
    stress = np.array([update(material, strain).stress for strain in path])
    assert all(np.array_equal(update(material, e).elastic, e) for e in path[::100])
    parts = (0.5 * (stress[1:] + stress[:-1]) * np.diff(path, axis=0)).sum(axis=1)
    assert abs(parts.sum()) < 1e-12 * np.abs(parts).sum()


@every_material
def test_small_strain_is_linear_elastic(material: str) -> None:
    strain = np.array([1e-9, -3e-9, 5e-10])
    found = update(material, strain)
    bulk, shear = moduli(material, strain, found.state)
    expected = bulk * strain.sum() + 2 * shear * deviator(strain)
    np.testing.assert_allclose(found.stress, expected, rtol=1e-13)


# --- von Mises: the yield condition itself ----------------------------------------------------


def yield_function(stress: Floats, plastic_strain: float, hardening: float) -> float:
    """||s|| - sqrt(2/3) (yield stress + H plastic strain)."""
    size = np.linalg.norm(deviator(stress))
    return float(size - np.sqrt(2 / 3) * (60.0 + hardening * plastic_strain))


@pytest.mark.parametrize("hardening", [0.0, 40.0, 5000.0])
def test_von_mises_keeps_yield_condition_and_kuhn_tucker(hardening: float) -> None:
    random = np.random.default_rng(5)
    yielding = 0
    for _ in range(500):
        trial = random.normal(size=3) * 10.0 ** random.uniform(-3, 0.5)
        before = random.uniform(0, 0.3)
        found = update("von_mises", trial, before, hardening_modulus=hardening)
        flow = trial - found.elastic
        multiplier = np.linalg.norm(flow)
        after = before + np.sqrt(2 / 3) * multiplier
        f = yield_function(found.stress, after, hardening)
        assert f <= 1e-10 * 60.0
        if multiplier > 0:  # Kuhn-Tucker: flow only on the surface, along its normal
            yielding += 1
            assert abs(f) <= 1e-10 * max(60.0, 2 * SHEAR * np.abs(trial).max())
            normal = deviator(found.stress) / np.linalg.norm(deviator(found.stress))
            np.testing.assert_allclose(flow / multiplier, normal, rtol=0, atol=1e-9)
            assert abs(flow.sum()) < 1e-13 * max(1.0, np.abs(trial).max())
    assert 50 < yielding < 480


def test_von_mises_uniaxial_hardening_line() -> None:
    """Uniaxial stress: tau = sigma_y + H ep, with ep = strain - tau / E, step by step."""
    young, hardening = 1000.0, 40.0
    elastic, plastic = np.zeros(3), 0.0
    total = 0.0
    for _ in range(40):
        total += 0.01
        lateral = 0.0
        for _ in range(50):  # lateral strain increment that leaves the lateral stress zero
            trial = elastic + np.array([0.01, lateral, lateral])
            found = update("von_mises", trial, plastic, hardening_modulus=hardening)
            slope = found.tangent[1, 1] + found.tangent[1, 2]
            lateral -= found.stress[1] / slope
            if abs(found.stress[1]) < 1e-12:
                break
        plastic += np.sqrt(2 / 3) * np.linalg.norm(trial - found.elastic)
        elastic = found.elastic
        strength = 60.0 + hardening * plastic
        expected = min(young * total, strength)
        assert found.stress[0] == pytest.approx(expected, rel=1e-9)
    assert plastic == pytest.approx(total - found.stress[0] / young, rel=1e-9)
    assert plastic > 0.3


def test_von_mises_pure_shear_strength_is_the_yield_stress_over_root_three() -> None:
    found = update("von_mises", np.array([0.3, 0.0, -0.3]), hardening_modulus=0.0)
    assert found.stress[0] == pytest.approx(60.0 / np.sqrt(3), rel=1e-12)
    assert found.stress[1] == pytest.approx(0.0, abs=1e-12)


def test_von_mises_pressure_never_yields() -> None:
    found = update("von_mises", np.full(3, -5.0))
    np.testing.assert_array_equal(found.elastic, np.full(3, -5.0))
    np.testing.assert_allclose(found.stress, np.full(3, -15.0 * BULK), rtol=1e-14)


def test_names_of_unknown_materials_are_refused() -> None:
    with pytest.raises(ValueError, match="unknown material 'jelly'"):
        _core.principal_update(
            "jelly", np.ones(2), np.zeros(3), 0.0, np.zeros(1), np.zeros(1), np.zeros(3),
            np.zeros(3), np.zeros((3, 3)),
        )  # fmt: skip
