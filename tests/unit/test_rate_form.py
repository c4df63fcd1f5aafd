# SPDX-License-Identifier: BSD-3-Clause
"""The integrated rate equations of von Mises plasticity, and the reference data."""

import math

import numpy as np
import pytest

from tilth.errors import AnalysisFailed
from tilth.model import VonMises
from tilth_verification.closed_forms import (
    Moduli,
    hencky_cauchy_stress,
    hencky_strain,
    proportional_von_mises,
)
from tilth_verification.rate_form import exponential_path, linear_path, von_mises_response
from tilth_verification.reference import (
    AMPLE_COLUMN_ERROR,
    collapse_by_ample,
    end_loaded_cantilever,
)

TIMES = [0.2, 0.45, 0.7, 1.0]
SHEAR = np.array([[1.1, 0.5, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.0]])


def material(hardening_modulus=0.0, yield_stress=12.0):
    return VonMises(
        young_modulus=100.0,
        poisson_ratio=0.3,
        yield_stress=yield_stress,
        hardening_modulus=hardening_modulus,
    )


def stepped(path, steps, soil):
    """Kirchhoff stress and plastic strain at time 1 by return mapping in `steps` steps."""
    moduli = Moduli.of(soil)
    cauchy_green, plastic_strain = np.eye(3), 0.0
    for i in range(steps):
        before, after = path(i / steps)[0], path((i + 1) / steps)[0]
        increment = after @ np.linalg.inv(before)
        value, vector = np.linalg.eigh(increment @ cauchy_green @ increment.T)
        strain = 0.5 * np.log(value)
        deviator = strain - strain.mean()
        mises = 2.0 * moduli.shear * math.sqrt(1.5 * deviator @ deviator)
        limit = soil.initial_yield_stress + soil.hardening_modulus * plastic_strain
        flow = max(mises - limit, 0.0) / (3.0 * moduli.shear + soil.hardening_modulus)
        plastic_strain += flow
        deviator = deviator * (1.0 - 3.0 * moduli.shear * flow / mises)
        elastic = deviator + strain.mean()
        cauchy_green = (vector * np.exp(2.0 * elastic)) @ vector.T
        stress = 3.0 * moduli.bulk * strain.mean() + 2.0 * moduli.shear * deviator
    return np.append(((vector * stress) @ vector.T).ravel(), plastic_strain)


def cycle(time):
    """Simple shear there, back and beyond."""
    gradient, rate = np.eye(3), np.zeros((3, 3))
    gradient[0, 1] = 0.3 * math.sin(1.5 * math.pi * time)
    rate[0, 1] = 0.45 * math.pi * math.cos(1.5 * math.pi * time)
    return gradient, rate


@pytest.mark.parametrize("hardening_modulus", [0.0, 40.0])
@pytest.mark.parametrize(
    "path",
    [linear_path(SHEAR), exponential_path(SHEAR), cycle],
    ids=["linear", "exponential", "cycle"],
)
def test_return_mapping_converges_to_it_at_first_order(path, hardening_modulus):
    soil = material(hardening_modulus)
    response = von_mises_response(path, [1.0], soil)
    exact = np.append(response.kirchhoff_stress[0].ravel(), response.plastic_strain)
    coarse, middle, fine = (stepped(path, n, soil) for n in (160, 320, 640))
    errors = [np.linalg.norm(result - exact) for result in (coarse, middle, fine)]
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.05)
    assert errors[1] / errors[2] == pytest.approx(2.0, abs=0.05)
    assert np.linalg.norm(2.0 * fine - middle - exact) < 0.02 * errors[2]
    assert response.plastic_strain[0] > 0.05


@pytest.mark.parametrize("end", [np.diag([1.0, 0.6, 1.0]), np.diag([1.3, 0.9, 1.3])])
def test_pure_stretch_agrees_with_the_proportional_closed_form(end):
    soil = material(15.0)
    response = von_mises_response(exponential_path(end), TIMES, soil)
    strain = np.array([t * hencky_strain(end) for t in TIMES])
    stress, plastic_strain = proportional_von_mises(strain, soil)
    np.testing.assert_allclose(response.kirchhoff_stress, stress, atol=1e-9)
    np.testing.assert_allclose(response.plastic_strain, plastic_strain, atol=1e-11)
    volume = np.exp(np.trace(strain, axis1=1, axis2=2))[:, None, None]
    np.testing.assert_allclose(response.cauchy_stress, stress / volume, atol=1e-9)
    assert plastic_strain[-1] > 0.0


def test_uniaxial_strain_loaded_and_reversed():
    soil, peak = material(15.0), 0.5
    shear, hardening = Moduli.of(soil).shear, soil.hardening_modulus
    bulk, both = Moduli.of(soil).bulk, 3.0 * shear + hardening

    def path(time):
        strain = peak * math.sin(math.pi * time)
        rate = peak * math.pi * math.cos(math.pi * time)
        stretch = math.exp(strain)
        return np.diag([stretch, 1.0, 1.0]), np.diag([rate * stretch, 0.0, 0.0])

    times = [0.5, 0.55, 1.0]
    response = von_mises_response(path, times, soil)
    first = (2.0 * shear * peak - 12.0) / both
    limit = 12.0 + hardening * first
    elastic = 2.0 * shear * peak * (1.0 - math.sin(0.55 * math.pi))
    second = (2.0 * shear * peak - 2.0 * limit) / both
    mises = [limit, limit - elastic, -(limit + hardening * second)]
    axial = [
        bulk * peak * math.sin(math.pi * t) + 2.0 / 3.0 * q
        for t, q in zip(times, mises, strict=True)
    ]
    assert elastic > 0.0
    assert second > 0.0
    np.testing.assert_allclose(response.kirchhoff_stress[:, 0, 0], axial, atol=1e-8)
    np.testing.assert_allclose(response.plastic_strain, [first, first, first + second], atol=1e-10)


def test_below_yield_it_is_the_elastic_law():
    soil = material(yield_stress=1e6)
    response = von_mises_response(linear_path(SHEAR), TIMES, soil)
    gradients = np.array([linear_path(SHEAR)(t)[0] for t in TIMES])
    expected = hencky_cauchy_stress(gradients, soil)
    np.testing.assert_allclose(response.cauchy_stress, expected, atol=1e-12)
    assert (response.plastic_strain == 0.0).all()


def test_the_stress_stays_on_the_yield_surface():
    soil = material(40.0)
    response = von_mises_response(linear_path(SHEAR), np.linspace(0.5, 1.0, 6), soil)
    stress = response.kirchhoff_stress
    deviator = stress - np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    mises = np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2)))
    np.testing.assert_allclose(mises, 12.0 + 40.0 * response.plastic_strain, atol=1e-9)


@pytest.mark.parametrize("path", [linear_path(SHEAR), exponential_path(SHEAR)])
def test_paths_give_their_own_rate(path):
    np.testing.assert_allclose(path(0.0)[0], np.eye(3), atol=1e-15)
    np.testing.assert_allclose(path(1.0)[0], SHEAR, atol=1e-14)
    difference = (path(0.6 + 1e-6)[0] - path(0.6 - 1e-6)[0]) / 2e-6
    np.testing.assert_allclose(path(0.6)[1], difference, atol=1e-9)


def test_a_motion_that_flutters_is_refused():
    def flutter(time):
        gradient, rate = np.eye(3), np.zeros((3, 3))
        gradient[0, 1] = 0.3 * math.sin(400.0 * time)
        rate[0, 1] = 120.0 * math.cos(400.0 * time)
        return gradient, rate

    with pytest.raises(AnalysisFailed, match="too quickly"):
        von_mises_response(flutter, [1.0], material())


def test_cantilever_reference():
    curve = end_loaded_cantilever()
    assert curve.load_fraction.shape == (50,)
    np.testing.assert_allclose(np.diff(curve.load_fraction), 0.02, atol=1e-12)
    np.testing.assert_allclose(curve.displacement[-1], [-5.552, -8.281], atol=5e-4)


def test_collapse_reference_pairs_each_point_with_its_own_start():
    points = collapse_by_ample()
    initial, final = points.initial_position, points.final_position
    assert initial.shape == final.shape == (2304, 2)
    order = np.lexsort(initial.T)
    square = final[order].reshape(48, 48, 2)  # rows in y, x along each
    # neighbours at the start are neighbours at the end, and keep their sense along the rollers
    assert np.linalg.norm(np.diff(square, axis=0), axis=2).max() < 0.6
    assert np.linalg.norm(np.diff(square, axis=1), axis=2).max() < 0.6
    assert (np.diff(square[0, :, 0]) > 0.0).all()
    assert (np.diff(square[:, 0, 1]) > 0.0).all()


def test_published_column_errors_fall_with_the_number_of_cells():
    cells, errors = zip(*sorted(AMPLE_COLUMN_ERROR.items()), strict=True)
    assert cells == (4, 8, 16, 32, 64, 128, 256, 8192)
    rates = -np.diff(np.log(errors)) / np.diff(np.log(cells))
    assert ((rates > 0.9) & (rates < 2.1)).all()
