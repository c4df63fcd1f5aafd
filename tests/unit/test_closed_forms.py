# SPDX-License-Identifier: BSD-3-Clause
"""The closed forms against independent numerics: quadrature, root finding, finite differences."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.linalg import logm
from scipy.optimize import brentq

from tilth.model import HenckyElastic, VonMises
from tilth_verification.closed_forms import (
    ConstrainedBall,
    Moduli,
    PlasticRing,
    PressurisedShell,
    SelfWeightColumn,
    ThickCylinder,
    WidenedCylinder,
    components,
    full_deformation_gradient,
    hencky_cauchy_stress,
    hencky_strain,
    proportional_von_mises,
)


def elastic(young_modulus, poisson_ratio=0.0, density=80.0):
    return HenckyElastic(young_modulus=young_modulus, poisson_ratio=poisson_ratio, density=density)


def von_mises(poisson_ratio=0.3, yield_stress=12.0, hardening_modulus=0.0, young_modulus=100.0):
    return VonMises(
        young_modulus=young_modulus,
        poisson_ratio=poisson_ratio,
        yield_stress=yield_stress,
        hardening_modulus=hardening_modulus,
        density=2.0,
    )


def uniaxial(stretch):
    return np.diag([1.0, stretch, 1.0])


def kirchhoff(stretch, material):
    """Kirchhoff stress under uniaxial strain, from the laws tested further down."""
    if isinstance(material, HenckyElastic):
        return stretch * hencky_cauchy_stress(uniaxial(stretch), material)
    return proportional_von_mises(hencky_strain(uniaxial(stretch)), material)[0]


@pytest.mark.parametrize(
    ("height", "gravity", "density", "young_modulus", "final", "rounding"),
    [
        (50.0, 10.0, 80.0, 1e4, 24.0596, 5e-5),
        (50.0, 10.0, 80.0, 1e6, 49.0380, 5e-5),
        (0.8, 9.81, 50.0, 283.0, 0.5386, 5e-5),
        (0.8, 9.81, 50.0, 1e3, 0.68433, 5e-6),
    ],
)
def test_column_has_the_known_heights(height, gravity, density, young_modulus, final, rounding):
    column = SelfWeightColumn(height, gravity, elastic(young_modulus, density=density))
    assert column.final_height == pytest.approx(final, abs=rounding)
    assert column.stretch(height) == 1.0
    assert column.base_stress == pytest.approx(density * gravity * height)


def test_column_stretch_at_the_base():
    assert SelfWeightColumn(50.0, 10.0, elastic(1e4)).stretch(0.0) == pytest.approx(
        0.30054, abs=5e-6
    )
    halved = SelfWeightColumn(0.8, 9.81, elastic(283.0, density=50.0))
    assert halved.stretch(0.0) == pytest.approx(0.5, abs=1e-4)


COLUMNS = [
    SelfWeightColumn(20.0, 2.0, elastic(100.0, density=2.0)),
    SelfWeightColumn(20.0, 2.0, elastic(100.0, 0.3, density=2.0)),
    SelfWeightColumn(20.0, 2.0, von_mises()),
    SelfWeightColumn(20.0, 2.0, von_mises(poisson_ratio=0.0)),
    SelfWeightColumn(20.0, 2.0, von_mises(hardening_modulus=30.0)),
    SelfWeightColumn(20.0, 2.0, von_mises(yield_stress=1e5)),
]


@pytest.mark.slow
@pytest.mark.parametrize("column", COLUMNS)
def test_column_against_root_finding_and_quadrature(column):
    density, gravity, material = column.material.density, column.gravity, column.material

    def stretch(level):
        """Stretch at which the material carries the weight above, sigma = tau / stretch."""
        load = density * gravity * (column.height - level)
        return brentq(lambda x: kirchhoff(x, material)[1, 1] / x + load, 0.05, 1.5, xtol=1e-14)

    levels = np.linspace(0.0, 20.0, 9)
    expected = np.array([stretch(level) for level in levels])
    np.testing.assert_allclose(column.stretch(levels), expected, rtol=1e-10)
    stress = np.array([kirchhoff(x, material) / x for x in expected])
    np.testing.assert_allclose(column.vertical_stress(levels), stress[:, 1, 1], atol=1e-9)
    np.testing.assert_allclose(column.lateral_stress(levels), stress[:, 0, 0], atol=1e-9)
    if isinstance(material, VonMises):
        plastic = [
            proportional_von_mises(hencky_strain(uniaxial(x)), material)[1] for x in expected
        ]
        np.testing.assert_allclose(column.plastic_strain(levels), plastic, atol=1e-12)
        assert (max(plastic) > 0.0) == (material.initial_yield_stress < 1e4)
    else:
        assert (column.plastic_strain(levels) == 0.0).all()
    for level in (5.0, 20.0):
        length = quad(stretch, 0.0, level, epsabs=1e-11, epsrel=1e-11, limit=400)[0]
        assert column.position(level) == pytest.approx(length, rel=1e-9)


@pytest.mark.parametrize("column", COLUMNS)
def test_column_is_in_equilibrium_in_its_compressed_place(column):
    """d sigma / dy = current density times gravity, by central differences."""
    levels, step = np.linspace(1.0, 19.0, 11), 1e-4
    rise = column.position(levels + step) - column.position(levels - step)
    slope = (column.vertical_stress(levels + step) - column.vertical_stress(levels - step)) / rise
    weight = column.material.density * column.gravity / column.stretch(levels)
    np.testing.assert_allclose(slope, weight, rtol=1e-5)


def test_column_error_is_the_mean_over_the_base_stress_weighted_by_volume():
    column = COLUMNS[0]
    level, volume = np.array([5.0, 15.0]), np.array([3.0, 1.0])
    wrong = column.vertical_stress(level) + np.array([4.0, -8.0])
    assert column.stress_error(wrong, level, volume) == pytest.approx((3 * 4 + 8) / 4 / 80.0)


def hencky_energy(gradient, moduli):
    strain = np.real(logm(gradient @ gradient.T)) / 2.0
    deviator = strain - np.trace(strain) / 3.0 * np.eye(3)
    return moduli.bulk / 2.0 * np.trace(strain) ** 2 + moduli.shear * np.sum(deviator**2)


@pytest.mark.parametrize("seed", range(4))
def test_hencky_stress_is_the_derivative_of_the_stored_energy(seed):
    material = elastic(100.0, 0.3)
    gradient = np.eye(3) + np.random.default_rng(seed).uniform(-0.35, 0.35, (3, 3))
    moduli, step = Moduli.of(material), 1e-5
    nominal = np.empty((3, 3))
    for i, j in np.ndindex(3, 3):
        change = np.zeros((3, 3))
        change[i, j] = step
        nominal[i, j] = (
            hencky_energy(gradient + change, moduli) - hencky_energy(gradient - change, moduli)
        ) / (2.0 * step)
    stress = nominal @ gradient.T / np.linalg.det(gradient)
    np.testing.assert_allclose(hencky_cauchy_stress(gradient, material), stress, atol=1e-6)


def test_moduli():
    moduli = Moduli.of(elastic(100.0, 0.25))
    assert (moduli.bulk, moduli.shear) == pytest.approx((100.0 / 1.5, 40.0))
    assert (moduli.lame, moduli.constrained) == pytest.approx((40.0, 120.0))
    # uniaxial stress: strains in the ratio -nu have no lateral stress, and stress E times strain
    strain = np.diag([1.0, -0.25, -0.25]) * 1e-3
    stress = moduli.lame * np.trace(strain) * np.eye(3) + 2 * moduli.shear * strain
    np.testing.assert_allclose(stress, np.diag([0.1, 0.0, 0.0]), atol=1e-16)


def test_stress_of_many_states_at_once():
    gradients = np.eye(3) + np.random.default_rng(1).uniform(-0.2, 0.2, (4, 5, 3, 3))
    together = hencky_cauchy_stress(gradients, elastic(10.0, 0.2))
    alone = hencky_cauchy_stress(gradients[2, 3], elastic(10.0, 0.2))
    np.testing.assert_allclose(together[2, 3], alone, atol=1e-14)
    assert together.shape == (4, 5, 3, 3)


def test_full_deformation_gradient_of_each_kind():
    given = np.array([[1.2, 0.1], [0.0, 0.9]])
    plane = full_deformation_gradient(given, "plane_strain")
    np.testing.assert_array_equal(plane, [[1.2, 0.1, 0], [0, 0.9, 0], [0, 0, 1]])
    round_ = full_deformation_gradient(np.diag([1.2, 0.9]), "axisymmetric")
    np.testing.assert_array_equal(round_, np.diag([1.2, 0.9, 1.2]))
    np.testing.assert_array_equal(full_deformation_gradient(plane, "3d"), plane)


def test_components_in_the_order_of_the_results():
    tensor = np.array([[1.0, 4.0, 6.0], [4.0, 2.0, 5.0], [6.0, 5.0, 3.0]])
    np.testing.assert_array_equal(components([tensor, 2 * tensor])[1], [2, 4, 6, 8, 10, 12])


@pytest.mark.parametrize("hardening_modulus", [0.0, 25.0])
@pytest.mark.parametrize("size", [0.05, -0.2, 0.6])
def test_proportional_von_mises_against_the_rate_equations_in_log_strain(size, hardening_modulus):
    material = von_mises(hardening_modulus=hardening_modulus)
    direction = np.array([[1.0, 0.3, 0.0], [0.3, -0.2, 0.1], [0.0, 0.1, 0.4]])
    moduli, end = Moduli.of(material), size * direction

    def rate(_, state):
        stress = state[:9].reshape(3, 3)
        deviator = stress - np.trace(stress) / 3.0 * np.eye(3)
        mises = math.sqrt(1.5 * np.sum(deviator**2))
        elastic_rate = moduli.lame * np.trace(end) * np.eye(3) + 2.0 * moduli.shear * end
        if mises < material.initial_yield_stress * (1.0 - 1e-12):
            return np.append(elastic_rate.ravel(), 0.0)
        normal = 1.5 * deviator / mises
        multiplier = 2.0 * moduli.shear * np.sum(normal * end)
        multiplier /= 3.0 * moduli.shear + material.hardening_modulus
        stress_rate = elastic_rate - 2.0 * moduli.shear * multiplier * normal
        return np.append(stress_rate.ravel(), multiplier)

    deviator = end - np.trace(end) / 3.0 * np.eye(3)
    onset = material.initial_yield_stress / (
        2 * moduli.shear * math.sqrt(1.5 * np.sum(deviator**2))
    )
    state, time = np.zeros(10), 0.0
    for target in (min(onset, 1.0), 1.0):
        if target > time:
            solution = solve_ivp(rate, (time, target), state, rtol=1e-10, atol=1e-12)
            state, time = solution.y[:, -1], target
    stress, plastic_strain = proportional_von_mises(end, material)
    np.testing.assert_allclose(stress.ravel(), state[:9], atol=1e-7)
    assert plastic_strain == pytest.approx(state[9], abs=1e-9)
    assert (plastic_strain > 0.0) == (abs(size) > 0.1)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.49])
def test_thick_cylinder_against_the_integrated_equilibrium_of_rings(poisson_ratio):
    cylinder = ThickCylinder(1.0, 2.5, 0.01, elastic(100.0, poisson_ratio))
    moduli = Moduli.of(cylinder.material)

    def rate(radius, state):
        displacement, radial = state
        slope = (radial - moduli.lame * displacement / radius) / moduli.constrained
        hoop = moduli.lame * slope + moduli.constrained * displacement / radius
        return [slope, (hoop - radial) / radius]

    radii = np.linspace(2.5, 1.0, 7)
    inward = solve_ivp(rate, (2.5, 1.0), [1.0, 0.0], t_eval=radii, rtol=1e-12, atol=1e-14)
    displacement, radial = inward.y * (0.01 / inward.y[0, -1])
    np.testing.assert_allclose(cylinder.radial_displacement(radii), displacement, rtol=1e-9)
    stress = cylinder.stress(radii)
    np.testing.assert_allclose(stress[:, 0], radial, atol=1e-9)
    slope, hoop = np.empty((2, 7))
    for i, state in enumerate(zip(displacement, radial, strict=True)):
        slope[i] = rate(radii[i], state)[0]
        hoop[i] = rate(radii[i], state)[1] * radii[i] + radial[i]
    np.testing.assert_allclose(stress[:, 2], hoop, atol=1e-9)
    axial = moduli.lame * (slope + displacement / radii)
    np.testing.assert_allclose(stress[:, 1], axial, atol=1e-9)
    assert cylinder.pressure == pytest.approx(-radial[-1], rel=1e-9)


@pytest.mark.parametrize(
    ("poisson_ratio", "displacement", "pressure", "outer_displacement"),
    [
        (0.3, 0.1, 0.04500, 0.06571),
        (0.3, 0.25, 0.09064, 0.17105),
        (0.3, 0.5, 0.13056, 0.36044),
        (0.3, 1.0, 0.14887, 0.77280),
        (0.0, 0.1, 0.05046, None),
        (0.0, 0.25, 0.09901, None),
        (0.0, 0.5, 0.13766, None),
        (0.0, 1.0, 0.14970, None),
        (0.49, 0.1, 0.04376, None),
        (0.49, 0.25, 0.09045, None),
        (0.49, 0.5, 0.13525, None),
    ],
)
def test_widened_cylinder_has_the_known_numbers(
    poisson_ratio, displacement, pressure, outer_displacement
):
    cylinder = WidenedCylinder(1.0, 2.0, displacement, elastic(1e6, poisson_ratio))
    assert cylinder.pressure / 1e6 == pytest.approx(pressure, abs=6e-6)
    if outer_displacement is not None:
        assert cylinder.outer_displacement == pytest.approx(outer_displacement, abs=6e-6)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.49])
def test_widened_cylinder_begins_as_lame_says(poisson_ratio):
    """The difference is of second order in the displacement: a tenth of it, a tenth as much."""
    material = elastic(100.0, poisson_ratio)
    radii = np.linspace(1.0, 2.5, 7)
    shares = []
    for displacement in (1e-3, 1e-4):
        wide = WidenedCylinder(1.0, 2.5, displacement, material)
        lame = ThickCylinder(1.0, 2.5, displacement, material)
        moved, expected = wide.radial_displacement(radii), lame.radial_displacement(radii)
        np.testing.assert_allclose(moved, expected, rtol=2.0 * displacement)
        assert wide.outer_displacement == pytest.approx(moved[-1], rel=1e-12)
        shares.append(wide.pressure / lame.pressure - 1.0)
    assert abs(shares[0]) < 5e-3
    assert shares[1] == pytest.approx(0.1 * shares[0], rel=0.02)


def test_widened_cylinder_is_in_equilibrium_in_its_widened_place():
    """d sigma_rr / dr = (sigma_hoop - sigma_rr) / r, by central differences of the mapping."""
    cylinder = WidenedCylinder(1.0, 2.0, 0.5, elastic(100.0, 0.3))
    radii, step = np.linspace(1.1, 1.9, 9), 1e-3

    def place(at):
        return at + cylinder.radial_displacement(at)

    def stress(at):
        stretch = (place(at + step) - place(at - step)) / (2.0 * step)
        gradient = np.zeros((len(at), 3, 3))
        gradient[:, 0, 0], gradient[:, 1, 1], gradient[:, 2, 2] = stretch, 1.0, place(at) / at
        return hencky_cauchy_stress(gradient, cylinder.material)

    radial = [stress(radii + side * step)[:, 0, 0] for side in (-1.0, 1.0)]
    slope = (radial[1] - radial[0]) / (place(radii + step) - place(radii - step))
    now = stress(radii)
    np.testing.assert_allclose(slope, (now[:, 2, 2] - now[:, 0, 0]) / place(radii), rtol=1e-4)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3])
def test_held_ball_is_in_equilibrium_and_does_not_move_at_its_surface(poisson_ratio):
    """The stress of its strain is in balance with the body force, by central differences."""
    centre, force = np.array([0.3, -0.2, 0.1]), np.array([1.0, 2.0, -3.0])
    ball = ConstrainedBall(centre, 2.0, force, elastic(100.0, poisson_ratio))
    moduli, step = Moduli.of(ball.material), 1e-2

    def stress(place):
        ends = [
            ball.displacement(place + sign * step * np.eye(3)) / (2.0 * step) for sign in (1, -1)
        ]
        strain = 0.5 * ((ends[0] - ends[1]) + (ends[0] - ends[1]).T)
        return moduli.lame * np.trace(strain) * np.eye(3) + 2.0 * moduli.shear * strain

    place = centre + np.array([0.5, 0.4, -0.7])
    divergence = sum(
        (stress(place + step * unit) - stress(place - step * unit))[i] / (2.0 * step)
        for i, unit in enumerate(np.eye(3))
    )
    np.testing.assert_allclose(divergence, -force, rtol=1e-9)
    surface = centre + 2.0 * np.array([[0.6, 0.0, 0.8], [0.0, -1.0, 0.0]])
    np.testing.assert_allclose(ball.displacement(surface), 0.0, atol=1e-15)


def test_pressurised_shell_balances_the_pressure():
    """Stresses from differences: -p inside, none outside, equilibrium between."""
    material = elastic(100.0, 0.3)
    shell = PressurisedShell(1.0, 2.5, 3.0, material)
    moduli = Moduli.of(material)
    step = 1e-4

    def stress(r):
        u = shell.displacement
        slope = (u(r + step) - u(r - step)) / (2.0 * step)
        volume = slope + 2.0 * u(r) / r
        radial = moduli.lame * volume + 2.0 * moduli.shear * slope
        return radial, moduli.lame * volume + 2.0 * moduli.shear * u(r) / r

    assert stress(1.0)[0] == pytest.approx(-3.0, rel=1e-6)
    assert stress(2.5)[0] == pytest.approx(0.0, abs=1e-6)
    radial, hoop = stress(1.7)
    slope = (stress(1.7 + 1e-3)[0] - stress(1.7 - 1e-3)[0]) / 2e-3
    assert slope == pytest.approx(-2.0 * (radial - hoop) / 1.7, rel=1e-4)


@pytest.mark.parametrize("front", [100.0, 130.0, 180.0])
def test_plastic_ring_in_equilibrium_with_its_elastic_part(front):
    """d sigma_rr / dr = (hoop - rr) / r; the difference falls with 1 / r^2 where elastic."""
    ring = PlasticRing(100.0, 200.0, von_mises(yield_stress=0.24, young_modulus=210.0))
    strength = 2.0 * 0.24 / math.sqrt(3.0)
    inside = quad(lambda r: strength / r, 100.0, front)[0]
    outside = quad(lambda r: strength * front**2 / r**3, front, 200.0)[0]
    part = ThickCylinder(front, 200.0, 1.0, elastic(210.0, 0.3))
    expected = outside / part.pressure * float(part.radial_displacement(200.0))
    pressure = (inside + outside) * (1.0 + 1e-12)
    assert ring.outer_displacement(pressure) == pytest.approx(expected, rel=1e-8)


def test_plastic_ring_has_the_published_limit():
    ring = PlasticRing(100.0, 200.0, von_mises(yield_stress=0.24, young_modulus=210.0))
    assert ring.limit_pressure == pytest.approx(0.19209, abs=5e-6)
    assert PlasticRing(1.0, 2.0, ring.material).limit_pressure == ring.limit_pressure


def test_plastic_ring_is_elastic_up_to_its_first_yield():
    ring = PlasticRing(100.0, 200.0, von_mises(yield_stress=0.24, young_modulus=210.0))
    first = 0.5 * 2.0 * 0.24 / math.sqrt(3.0) * (1.0 - 0.25)
    after = ring.outer_displacement(first * (1.0 + 1e-9))
    assert ring.outer_displacement(first) == pytest.approx(after, rel=1e-7)
    assert ring.outer_displacement(0.5 * first) == pytest.approx(0.5 * after, rel=1e-7)
