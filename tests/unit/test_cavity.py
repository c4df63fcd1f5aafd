# SPDX-License-Identifier: BSD-3-Clause
"""The reference solutions of cavities: limits, equilibrium, and agreement of the two."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from tilth.model import MohrCoulomb, Tresca
from tilth_verification.closed_forms import CavityInClay, CylinderInSoil

SHEAR, STRENGTH = 2.5e6, 50e3


@pytest.mark.parametrize("is_sphere", [False, True])
def test_pressure_in_clay_is_the_integral_of_equilibrium(is_sphere):
    """dp = m (difference of hoop and radial stress) dr / r from the wall outwards."""
    power, ratio = (3, 1.7) if is_sphere else (2, 1.7)
    kept = ratio**power - 1.0

    def integrand(log_radius):
        share = kept * math.exp(-power * log_radius)
        difference = min(2.0 * STRENGTH, -2.0 * SHEAR * math.log1p(-share))
        return (power - 1) * difference

    yields = math.log(kept / -math.expm1(-STRENGTH / SHEAR)) / power
    parts = [quad(integrand, a, b)[0] for a, b in ((math.log(ratio), yields), (yields, 20.0))]
    clay = CavityInClay(is_sphere, SHEAR, STRENGTH)
    assert clay.pressure(ratio) == pytest.approx(sum(parts), rel=1e-8)


@pytest.mark.parametrize(("is_sphere", "factor"), [(False, 1.0), (True, 4.0 / 3.0)])
def test_pressure_in_stiff_clay_tends_to_the_limit_pressure(is_sphere, factor):
    clay = CavityInClay(is_sphere, 1e4 * STRENGTH, STRENGTH)
    expected = factor * STRENGTH * (1.0 + math.log(1e4))
    assert clay.limit_pressure == pytest.approx(expected, rel=1e-14)
    assert clay.pressure(1e3) == pytest.approx(expected, rel=1e-5)


def test_integration_in_nearly_incompressible_clay_agrees_with_the_closed_form():
    nu = 0.5 - 1e-6
    young = 2.0 * SHEAR * (1.0 + nu)
    material = Tresca(young_modulus=young, poisson_ratio=nu, undrained_shear_strength=STRENGTH)
    exact = CavityInClay(False, SHEAR, STRENGTH)
    for ratio in (1.3, 3.0):
        pressure = CylinderInSoil(1.0, 3000.0, 0.0, material).pressure(ratio)
        assert pressure == pytest.approx(exact.pressure(ratio), rel=3e-5)


def sand(dilation):
    return MohrCoulomb(
        young_modulus=20e6,
        poisson_ratio=0.3,
        cohesion=5e3,
        friction_angle=30.0,
        dilation_angle=dilation,
    )


def test_sand_begins_as_lame_says():
    """Pressure above that at rest: 2 G times the relative widening, before the wall yields."""
    shear, widening = 20e6 / 2.6, 1e-4
    cylinder = CylinderInSoil(1.0, 1000.0, 100e3, sand(10.0))
    pressure = cylinder.pressure(1.0 + widening)
    assert pressure - 100e3 == pytest.approx(2.0 * shear * widening, rel=1e-2)


def test_sand_expands_as_small_strain_theory_says_while_strains_are_small():
    """In the plastic part p' = p + c cot(phi) falls as r^(-(N - 1) / N), N = tan^2(45 + phi / 2).

    At its edge the radial stress is 2 N / (N + 1) (p0 + c cot(phi)), as hoop and radial stress
    deviate from p0 by the same amount. With psi = 0 the widening of the wall is that of the edge
    less the elastic compression between them.
    """
    shear, flow = 2e9 / 2.6, 3.0
    stiff = MohrCoulomb(
        young_modulus=2e9,
        poisson_ratio=0.3,
        cohesion=5e3,
        friction_angle=30.0,
        dilation_angle=0.0,
    )
    attraction = 5e3 * math.sqrt(3.0)
    at_rest = 100e3 + attraction
    edge = 2.0 * flow / (flow + 1.0) * at_rest
    widening = 5e-4
    pressure = CylinderInSoil(1.0, 2000.0, 100e3, stiff).pressure(1.0 + widening) + attraction
    plastic = (pressure / edge) ** (flow / (flow - 1.0))  # radius of the plastic part
    elastic = (edge - at_rest) / (2.0 * shear)  # displacement over radius at its edge
    lame = 2.0 * shear * 0.3 / 0.4

    def compression(radius):
        """Elastic volumetric strain times radius, where the plastic one is zero."""
        radial = -edge * (plastic / radius) ** ((flow - 1.0) / flow)
        change = radial + radial / flow + 2.0 * at_rest
        return change / (2.0 * (lame + shear)) * radius

    lost = quad(compression, 1.0, plastic)[0]
    assert widening == pytest.approx(elastic * plastic**2 - lost, rel=5e-3)


def test_the_axial_stress_of_yielding_sand_is_the_intermediate_one():
    """Only then is the direction of plastic flow constant. It has no axial part, so that the axial
    stress follows from the others by the elastic law."""
    nu, at_rest, flow, strength = 0.3, 100e3, 3.0, 2.0 * 5e3 * math.sqrt(3.0)
    radial = -np.linspace(150e3, 2e6, 50)
    hoop = (radial + strength) / flow
    axial = nu * (radial + hoop + 2.0 * at_rest) - at_rest
    assert (radial < axial).all()
    assert (axial < hoop).all()
    cylinder = CylinderInSoil(1.0, 100.0, at_rest, sand(10.0))
    tau_radial, tau_hoop, _ = cylinder._stress(-0.2, 0.2)
    assert tau_hoop == pytest.approx((tau_radial + strength) / flow, rel=1e-12)
