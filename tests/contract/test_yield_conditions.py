# SPDX-License-Identifier: BSD-3-Clause
"""The yield conditions and flow rules of the laws, at thousands of random states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from law_updates import BULK, SHEAR, deviator, update, updates
from scipy.optimize import brentq, nnls
from small_problems import VARIANTS, declared, initial_state, parameters, start_strain

from tilth import _core
from tilth.arrays import Floats
from tilth.model.laws import laws

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


# --- Tresca, Mohr-Coulomb, Drucker-Prager: the yield conditions themselves ---------------------

STATES = 10_000


def random_trials(random: np.random.Generator, n: int) -> Floats:
    """Trial strains of all sizes; some on the hydrostatic axis, some with two equal values."""
    trials = random.normal(size=(n, 3)) * 10.0 ** random.uniform(-4, 0.5, (n, 1))
    trials[: n // 10] = trials[: n // 10, :1]
    trials[n // 10 : n // 5, 1] = trials[n // 10 : n // 5, 0]
    trials[n // 5 : n // 4] *= 1e-4
    trials[n // 5 : n // 4] += random.normal(size=(n // 4 - n // 5, 1))  # nearly equal
    return np.asarray(random.permuted(trials, axis=1))


def mohr_coulomb_planes(
    stress: Floats, material: Any, plastic_strain: Floats
) -> tuple[Floats, Floats, Floats]:
    """Yield functions of shear and of the cut-off, and their size, of principal stresses (n, 3)."""
    part = np.zeros(len(stress))
    c0, phi0 = material.cohesion, material.friction_angle
    c1, phi1 = c0, phi0
    if material.softens:
        part = np.minimum(plastic_strain / material.softening_strain, 1.0)
        c1 = c0 if material.residual_cohesion is None else material.residual_cohesion
        phi1 = (
            phi0 if material.residual_friction_angle is None else material.residual_friction_angle
        )
    c, phi = c0 + part * (c1 - c0), np.radians(phi0 + part * (phi1 - phi0))
    high, low = stress.max(axis=1), stress.min(axis=1)
    shear = (high - low) + np.sin(phi) * (high + low) - 2.0 * c * np.cos(phi)
    cut = np.inf if material.tension_cut_off is None else material.tension_cut_off
    tension = high - cut if np.isfinite(cut) else np.full(len(stress), -np.inf)
    return shear, tension, np.maximum(np.abs(stress).max(axis=1), c)


@pytest.mark.parametrize(
    "changed", [changed for law, changed in VARIANTS if law == "mohr_coulomb"], ids=str
)
def test_mohr_coulomb_keeps_its_yield_condition_and_flows_outwards(changed: dict[str, Any]) -> None:
    """On or inside the surface to 1e-10 of the stress; the flow is a sum of the planes' directions.

    The sum's coefficients, the plastic multipliers, are not negative (least squares over all planes
    that are active at the stress).
    """
    random = np.random.default_rng(11)
    material = declared("mohr_coulomb", **changed)
    trials, plastic = random_trials(random, STATES), random.uniform(0, 0.5, STATES)
    found, good = updates("mohr_coulomb", trials, plastic, np.zeros(0), **changed)
    assert good.all()
    assert np.isfinite(found.stress).all()
    assert np.isfinite(found.tangent).all()
    flow = trials - found.elastic
    equivalent = np.sqrt(2 / 3) * np.linalg.norm(flow - flow.mean(axis=1)[:, None], axis=1)
    shear, tension, size = mohr_coulomb_planes(found.stress, material, plastic + equivalent)
    trial_size = np.maximum(size, 3 * BULK * np.abs(trials).max(axis=1))
    assert (shear <= 1e-10 * trial_size).all()
    assert (tension <= 1e-10 * trial_size).all()
    psi = np.sin(np.radians(material.dilation_angle))
    yielding = np.flatnonzero(equivalent > 0)
    assert len(yielding) > STATES // 4
    for n in yielding[:: len(yielding) // 300]:
        tau, scale = found.stress[n], trial_size[n]
        directions = [
            (1 + psi) * np.eye(3)[i] - (1 - psi) * np.eye(3)[j]
            for i in range(3)
            for j in range(3)
            if i != j and tau[i] >= tau.max() - 1e-8 * scale and tau[j] <= tau.min() + 1e-8 * scale
        ]
        apex = shear[n] > -1e-8 * scale and np.ptp(tau) < 1e-8 * scale
        if tension[n] > -1e-8 * scale or apex:
            directions += [np.eye(3)[i] for i in range(3) if tau[i] >= tau.max() - 1e-8 * scale]
        assert nnls(np.array(directions).T, flow[n])[1] < 1e-8 * np.abs(trials[n]).max()


@pytest.mark.parametrize("strength", [30.0, 1e-3])
def test_tresca_keeps_its_yield_condition(strength: float) -> None:
    random = np.random.default_rng(12)
    trials = random_trials(random, STATES)
    entries = {"undrained_shear_strength": strength}
    found, good = updates("tresca", trials, np.zeros(STATES), np.zeros(0), **entries)
    assert good.all()
    flow = trials - found.elastic
    size = np.maximum(strength, 3 * BULK * np.abs(trials).max(axis=1))
    assert (np.ptp(found.stress, axis=1) <= 2 * strength + 1e-10 * size).all()
    assert (np.abs(flow.sum(axis=1)) <= 1e-12 * np.abs(trials).max(axis=1)).all()
    assert (np.einsum("ni,ni->n", found.stress, flow) >= -1e-12 * size).all()


@pytest.mark.parametrize(
    "changed", [changed for law, changed in VARIANTS if law == "drucker_prager"], ids=str
)
def test_drucker_prager_keeps_its_yield_condition(changed: dict[str, Any]) -> None:
    random = np.random.default_rng(13)
    trials = random_trials(random, STATES)
    found, good = updates("drucker_prager", trials, np.zeros(STATES), np.zeros(0), **changed)
    assert good.all()
    assert np.isfinite(found.tangent).all()
    _, _, slope, dilation, strength, cut = parameters("drucker_prager", **changed)
    mean = found.stress.mean(axis=1)
    root = np.sqrt(0.5 * ((found.stress - mean[:, None]) ** 2).sum(axis=1))
    size = np.maximum(strength, 3 * BULK * np.abs(trials).max(axis=1))
    assert (root + slope * mean - strength <= 1e-10 * size).all()
    assert (mean - cut <= 1e-10 * size).all()
    flow = trials - found.elastic
    on_cone = (root > 1e-6 * size) & (mean < cut - 1e-6 * size) & (np.abs(flow).max(axis=1) > 0)
    assert on_cone.any()
    shearing = np.linalg.norm(flow - flow.mean(axis=1)[:, None], axis=1) / np.sqrt(0.5)
    assert flow.sum(axis=1)[on_cone] == pytest.approx(dilation * shearing[on_cone], abs=1e-9)


@pytest.mark.parametrize("phi", [10.0, 20.0, 30.0, 45.0])
@pytest.mark.parametrize("psi", [0.0, 1.0])
def test_drucker_prager_fits(phi: float, psi: float) -> None:
    """Strengths of the fits are those of Mohr-Coulomb in the stress states that they name.

    `psi` is the part of the friction angle that is the dilation angle.
    """
    c = 25.0
    s, cos = np.sin(np.radians(phi)), np.cos(np.radians(phi))
    angles = {"friction_angle": phi, "dilation_angle": psi * phi}
    for fit, stress in {
        "compression": np.array([-10.0, -10.0, -(10.0 * (1 + s) + 2 * c * cos) / (1 - s)]),
        "extension": np.array([-10.0, *[-(10.0 * (1 + s) + 2 * c * cos) / (1 - s)] * 2]),
    }.items():
        _, _, slope, _, strength, _ = parameters("drucker_prager", fit=fit, cohesion=c, **angles)
        mean = stress.mean()
        root = np.sqrt(0.5 * ((stress - mean) ** 2).sum())
        assert root + slope * mean == pytest.approx(strength, rel=1e-13)
    # plane strain: no plastic strain out of plane at collapse
    _, _, slope, dilation, strength, _ = parameters(
        "drucker_prager", fit="plane_strain", cohesion=c, **angles
    )
    centre = -40.0
    radius = c * cos - centre * s
    out = brentq(lambda x: _flow_out_of_plane(centre, radius, x, dilation), -500.0, 100.0)
    stress = np.array([centre + radius, out, centre - radius])
    mean = stress.mean()
    root = np.sqrt(0.5 * ((stress - mean) ** 2).sum())
    assert root + slope * mean == pytest.approx(strength, rel=1e-9)


def _flow_out_of_plane(centre: float, radius: float, out: float, dilation: float) -> float:
    stress = np.array([centre + radius, out, centre - radius])
    mean = stress.mean()
    root = np.sqrt(0.5 * ((stress - mean) ** 2).sum())
    return float((out - mean) / (2 * root) + dilation / 3)


CAM_CLAY = [changed for law, changed in VARIANTS if law == "modified_cam_clay"]


@pytest.mark.parametrize("changed", CAM_CLAY, ids=str)
def test_cam_clay_keeps_its_yield_condition_and_flow_rule(changed: dict[str, Any]) -> None:
    """Also of strains of several units in one step: the return mapping refuses none."""
    random = np.random.default_rng(15)
    largest = -1.0 if "poisson_ratio" in changed else 0.3
    strain = random_trials(random, STATES) * 10.0 ** (largest - 0.5)
    trials = start_strain("modified_cam_clay", **changed) + strain
    before = initial_state("modified_cam_clay", **changed)
    found, good = updates("modified_cam_clay", trials, np.zeros(STATES), before, **changed)
    stable = "poisson_ratio" not in changed
    assert good.all() if stable else good.mean() > 0.9
    assert np.isfinite(found.stress[good]).all()
    assert np.isfinite(found.tangent[good]).all()
    stress, flow, consolidation = (
        found.stress[good],
        (trials - found.elastic)[good],
        found.state[good, 0],
    )
    hardening, swelling, slope, *_ = parameters("modified_cam_clay", **changed)
    p = -stress.mean(axis=1)
    q = np.sqrt(1.5) * np.linalg.norm(stress + p[:, None], axis=1)
    surface = q**2 / slope**2 + p * (p - consolidation)
    largest = np.abs(stress).max(axis=1)
    size = np.maximum(largest, consolidation) ** 2
    assert (surface <= 1e-10 * size).all()
    flows = np.abs(flow).max(axis=1) > 0
    assert flows.mean() > 0.1
    assert (np.abs(surface[flows]) <= 1e-10 * size[flows]).all()
    volume = -flow.sum(axis=1)
    np.testing.assert_allclose(
        np.log(consolidation / before[0]), volume / (hardening - swelling), rtol=1e-9, atol=1e-11
    )
    shear = np.sqrt(2 / 3) * np.linalg.norm(flow + volume[:, None] / 3, axis=1)
    residual = shear * (2 * p - consolidation) - volume * 2 * q / slope**2
    scale = (shear + np.abs(volume)) * np.sqrt(size)
    assert (np.abs(residual[flows]) <= 1e-10 * scale[flows]).all()
    work = np.einsum("ni,ni->n", stress, flow)
    round_off = 1e-12 * np.sqrt(size) + 4e-12  # of shear strains times 400, the shear modulus
    assert (work >= -round_off * np.abs(trials[good]).max(axis=1)).all()


@pytest.mark.parametrize("ratio", [1.0, 2.0, 5.0])
def test_cam_clay_overconsolidation_ratio_is_that_of_the_initial_surface(ratio: float) -> None:
    entries = {"overconsolidation_ratio": ratio, "preconsolidation_pressure": None}
    state = initial_state("modified_cam_clay", **entries)
    assert state[0] == pytest.approx(100.0 * ratio, rel=1e-14)
    anisotropic = np.array([[-50.0, -100.0, -50.0, 0.0, 0.0, 0.0]])
    state = np.zeros((1, 1))
    given = parameters("modified_cam_clay", **entries)
    assert _core.initial_state("3d", "modified_cam_clay", given, anisotropic, state) == -1
    p, q = 200.0 / 3.0, 50.0
    assert state[0, 0] == pytest.approx(ratio * (p + q**2 / (1.2**2 * p)), rel=1e-14)


def test_cam_clay_cannot_be_in_tension() -> None:
    given, state = parameters("modified_cam_clay"), np.ones((1, 1))
    for stress in (0.0, 10.0):
        tension = np.array([[stress] * 3 + [0.0] * 3])
        assert _core.initial_state("3d", "modified_cam_clay", given, tension, state) == 0
        found = np.zeros((1, 6))
        assert (
            _core.elastic_deformation_of("3d", "modified_cam_clay", given, tension, state, found)
            == 0
        )


def test_undrained_pressure_follows_the_volume_and_nothing_else() -> None:
    """du = -K_f d(volumetric strain), whatever part of it is plastic."""
    random = np.random.default_rng(14)
    strain, state, elastic = np.zeros(3), initial_state("undrained_mohr_coulomb"), np.zeros(3)
    names = list(laws()["undrained_mohr_coulomb"].state_variables)
    plastic = 0.0
    for _ in range(20):
        increment = 0.02 * random.normal(size=3)
        strain += increment
        found = update("undrained_mohr_coulomb", elastic + increment, plastic, state)
        flow = elastic + increment - found.elastic
        plastic += float(np.sqrt(2 / 3) * np.linalg.norm(deviator(flow)))
        elastic, state = found.elastic, found.state
        pressure = state[names.index("excess_pore_pressure")]
        assert pressure == pytest.approx(-5000.0 * strain.sum(), rel=1e-11, abs=1e-9)
    assert plastic > 0.1
