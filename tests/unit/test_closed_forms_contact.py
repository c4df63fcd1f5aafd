# SPDX-License-Identifier: BSD-3-Clause
"""The closed forms of contact against quadrature and against each other."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

from tilth.model import HenckyElastic
from tilth_verification.buried_pipe import bearing_factor
from tilth_verification.closed_forms.cavity import CavityInClay
from tilth_verification.closed_forms.elastic_contact import (
    Cattaneo,
    HertzCylinder,
    HertzSphere,
    contact_modulus,
    flat_punch_force,
    sphere_depth,
)
from tilth_verification.closed_forms.limit_loads import (
    DEEP_PIPE_BOUNDS,
    DEEP_STRIP_ANCHOR,
    LIFTED_PIPE_BOUNDS,
    SEABED_PIPE_BOUNDS,
    cone_factor,
    seabed_pipe,
    sphere_limit_pressure,
    strip_anchor_bound,
)

SOIL = HenckyElastic(young_modulus=1e7, poisson_ratio=0.3)
SPHERE = HertzSphere(2.0, contact_modulus(SOIL))
CYLINDER = HertzCylinder(2.0, contact_modulus(SOIL))


def total(contact, distribution, half_width):
    """Force of a distribution over the contact, whatever its shape."""
    if isinstance(contact, HertzSphere):
        return quad(lambda r: 2.0 * math.pi * r * distribution(r), 0.0, half_width)[0]
    return 2.0 * quad(distribution, 0.0, half_width)[0]


@pytest.mark.parametrize("contact", [SPHERE, CYLINDER])
def test_the_pressure_sums_to_the_force(contact):
    force = 4e4
    width = contact.half_width(force)
    summed = total(contact, lambda r: float(contact.pressure(r, force)), width)
    assert summed == pytest.approx(force, rel=1e-6)
    assert contact.pressure(1.001 * width, force) == 0.0


def test_the_sphere_sinks_as_far_as_its_own_pressure_says():
    """Boussinesq: u(0) = (1 - nu^2) / (pi E) times the integral of p / r over the contact."""
    force = 4e4
    width = SPHERE.half_width(force)
    sunk = dblquad(lambda r, _: SPHERE.pressure(r, force), 0.0, 2.0 * math.pi, 0.0, width)[0]
    assert sunk / (math.pi * SPHERE.modulus) == pytest.approx(SPHERE.depth(force), rel=1e-6)
    assert SPHERE.force(SPHERE.depth(force)) == pytest.approx(force, rel=1e-12)
    assert width**2 == pytest.approx(SPHERE.radius * SPHERE.depth(force), rel=1e-12)


def test_the_sphere_fits_the_surface_at_the_rim():
    """The displacement at the rim is half of that in the middle: d - a^2 / (2 R)."""
    force = 4e4
    width = SPHERE.half_width(force)

    def from_the_rim(angle, share):
        """Over the chords through a point of the rim, s = 2 a cos(angle) share."""
        chord = 2.0 * width * math.cos(angle)
        away = math.hypot(width - chord * share * math.cos(angle), chord * share * math.sin(angle))
        return float(SPHERE.pressure(away, force)) * chord

    sunk = dblquad(lambda s, t: from_the_rim(t, s), -0.5 * math.pi, 0.5 * math.pi, 0.0, 1.0)[0]
    expected = 0.5 * SPHERE.depth(force)
    assert sunk / (math.pi * SPHERE.modulus) == pytest.approx(expected, rel=1e-4)


def test_the_pressure_of_the_cylinder_makes_its_curvature():
    """du/dx = -2 / (pi E*) times the integral of p(s) / (x - s), which is -x / R in the contact."""
    force = 4e4
    width = CYLINDER.half_width(force)
    assert CYLINDER.force(width) == pytest.approx(force, rel=1e-12)
    for x in (0.2 * width, 0.7 * width):
        near = quad(
            lambda s: float(CYLINDER.pressure(s, force)), -width, width, weight="cauchy", wvar=x
        )[0]
        slope = 2.0 / (math.pi * CYLINDER.modulus) * near
        assert slope == pytest.approx(-x / CYLINDER.radius, rel=1e-5)


@pytest.mark.parametrize(("contact", "power"), [(SPHERE, 1.0 / 3.0), (CYLINDER, 0.5)])
@pytest.mark.parametrize("share", [0.0, 0.5, 0.9, 1.0])
def test_the_shear_of_cattaneo_sums_to_the_tangential_force(contact, power, share):
    force, friction = 4e4, 0.4
    law, tangential = Cattaneo(contact, friction), share * friction * force
    width = contact.half_width(force)
    summed = total(contact, lambda r: float(law.shear(r, force, tangential)), width)
    assert summed == pytest.approx(tangential, rel=1e-5, abs=1e-6)
    if share < 1.0:
        sticking = law.sticking(force, tangential)
        assert sticking / width == pytest.approx((1.0 - share) ** power, rel=1e-12)
        rim = np.linspace(sticking, width, 5)
        limit = friction * contact.pressure(rim, force)
        np.testing.assert_allclose(law.shear(rim, force, tangential), limit, atol=1e-9)


def test_soil_of_finite_extent_sinks_less():
    force = 4e4
    free = SPHERE.depth(force)
    near, far = (sphere_depth(SPHERE, force, SOIL, extent) for extent in (4.0, 8.0))
    assert near < far < free
    assert free - near == pytest.approx(2.0 * (free - far), rel=1e-9)


def test_the_flat_punch_sinks_as_its_pressure_says():
    """p = P / (2 pi a sqrt(a^2 - r^2)) gives u(0) = P / (2 a E*), by Boussinesq's integral."""
    radius, force, modulus = 0.5, 3e3, 2e6
    sunk = quad(lambda t: force / (2.0 * math.pi * radius), 0.0, 0.5 * math.pi)[0]
    depth = 2.0 * sunk / modulus
    assert flat_punch_force(radius, depth, modulus) == pytest.approx(force, rel=1e-12)


def test_the_cone_needs_more_than_its_cavity():
    for rigidity in (100.0, 300.0):
        cavity = CavityInClay(is_sphere=True, shear_modulus=rigidity, strength=1.0)
        assert sphere_limit_pressure(rigidity) == pytest.approx(cavity.limit_pressure, rel=1e-12)
        assert cone_factor(rigidity) > sphere_limit_pressure(rigidity)
    assert cone_factor(100.0) == pytest.approx(10.77, abs=5e-3)
    assert cone_factor(300.0) - cone_factor(100.0) == pytest.approx(1.758, abs=1e-3)


@pytest.mark.parametrize("bounds", [SEABED_PIPE_BOUNDS, LIFTED_PIPE_BOUNDS, DEEP_PIPE_BOUNDS])
def test_bounds_are_in_order_and_close(bounds):
    assert bounds
    for lower, upper in bounds.values():
        assert lower < upper < 1.04 * lower


@pytest.mark.parametrize("face", ["smooth", "rough"])
@pytest.mark.parametrize("embedment", [0.25, 0.5])
def test_the_fits_for_the_seabed_pipe_are_near_its_bounds(embedment, face):
    lower, upper = SEABED_PIPE_BOUNDS[embedment, face]
    assert 0.97 * lower < seabed_pipe(embedment, face) < 1.03 * upper


def test_the_closed_form_of_the_deep_pipe_is_a_lower_bound_near_the_exact_load():
    for adhesion, (lower, upper) in DEEP_PIPE_BOUNDS.items():
        assert 0.99 * lower < bearing_factor(adhesion) < upper


def test_the_bound_of_the_anchor_is_the_dissipation_of_its_mechanism():
    """Power over s_u, B and the plate's velocity: length of each sheared line times its slip."""
    thickness, flow, radius = 0.1, math.sqrt(0.5), math.sqrt(0.5)
    assert 2.0 * flow * radius == pytest.approx(1.0)  # what sinks beside the plate is what it moves
    wedges = 4.0 * math.sqrt(0.5) * math.sqrt(0.5)
    arcs = 2.0 * 1.5 * math.pi * radius * flow
    fans = 2.0 * quad(lambda r: 1.5 * math.pi * r * flow / r, 0.0, radius)[0]
    assert wedges + arcs + fans == pytest.approx(DEEP_STRIP_ANCHOR, rel=1e-12)
    sides = 2.0 * thickness * ((1.0 + flow) + flow)
    assert strip_anchor_bound(thickness) == pytest.approx(wedges + arcs + fans + sides, rel=1e-12)
