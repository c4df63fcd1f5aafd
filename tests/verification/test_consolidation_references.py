# SPDX-License-Identifier: BSD-3-Clause
"""The references of consolidation against other computations of the same numbers.

Finite volumes and eigenfunctions written apart from `tilth_verification` gave the tables.
"""

import numpy as np
import pytest

from tilth_verification.closed_forms.cam_clay_oedometer import CamClayOedometer
from tilth_verification.closed_forms.consolidation import Layer, LayerOnDrain, Mandel, TwoLayers
from tilth_verification.closed_forms.material_column import (
    MaterialColumn,
    constant,
    hencky,
    kozeny_carman,
)
from tilth_verification.closed_forms.radial_consolidation import PressedBall
from tilth_verification.closed_forms.radial_drain import RadialDrain

UNIT = Layer(1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("time", "degree", "base", "middle"),
    [(0.05, 0.25231, 0.99687, 0.88615), (0.2, 0.50409, 0.77231, 0.55318)],
)
def test_one_layer(time: float, degree: float, base: float, middle: float) -> None:
    layer = LayerOnDrain(UNIT)
    found = [layer.settlement(time), layer.pressure(1.0, time), layer.pressure(0.5, time)]
    assert found == pytest.approx([degree, base, middle], abs=1e-5)


@pytest.mark.parametrize(("steps", "base"), [(10, 0.77585), (20, 0.77431), (80, 0.77286)])
def test_steps_of_backward_euler(steps: int, base: float) -> None:
    found = LayerOnDrain(UNIT).pressure(1.0, 0.2, [0.2 / steps] * steps)
    assert found == pytest.approx(base, abs=1e-5)


def test_compressible_water() -> None:
    modulus = 1e4 * 0.7 / (1.3 * 0.4)
    layer = LayerOnDrain(Layer(1.0, 1.0, modulus), 0.4 / 2e4)
    assert 10.0 * layer.start == pytest.approx(7.8788, abs=1e-4)
    assert 10.0 * layer.pressure(1.0, 0.1 * layer.unit) == pytest.approx(7.4794, abs=1e-4)


@pytest.mark.parametrize(
    ("time", "interface", "base", "degree"),
    [
        (0.05, 0.81392, 1.0, 0.33619),
        (0.2, 0.31678, 0.96569, 0.62113),
        (2.0, 0.01013, 0.06293, 0.98182),
    ],
)
def test_two_layers(time: float, interface: float, base: float, degree: float) -> None:
    layers = TwoLayers(Layer(0.5, 1.0, 1.0), Layer(0.5, 0.1, 2.0))
    found = [layers.pressure(0.5, time), layers.pressure(1.0, time), layers.settlement(time)]
    assert found == pytest.approx([interface, base, degree], abs=1e-5)


@pytest.mark.parametrize(
    ("ratio", "time", "middle", "half", "strain"),
    [(0.0, 0.1, 1.15179, 0.90956, 0.30168), (0.2, 0.01, 1.04376, 1.04335, 0.26094)],
)
def test_mandel(ratio: float, time: float, middle: float, half: float, strain: float) -> None:
    slab = Mandel(ratio)
    found = [slab.pressure(0.0, time), slab.pressure(0.5, time), slab.strain(time)]
    assert found == pytest.approx([middle, half, strain], abs=1e-5)


@pytest.mark.parametrize(
    ("load", "conductivity", "pressure", "settlement"),
    [
        (0.1, constant(1.0), 0.07317, 0.04932),
        (0.5, constant(1.0), 0.25553, 0.22932),
        (0.5, kozeny_carman(1.0, 0.6), 0.43341, 0.13970),
        (0.5, lambda stretch: stretch**2, 0.37148, 0.18363),
    ],
)
def test_large_strain(load, conductivity, pressure, settlement) -> None:
    (found,) = MaterialColumn(1.0, hencky(1.0), conductivity, load).at([0.2], 25, 30)
    assert found.pressure == pytest.approx(pressure, abs=2e-4 * load)
    assert found.settlement == pytest.approx(settlement, abs=1e-4)


def test_cam_clay() -> None:
    law = CamClayOedometer(100.0, 1.0, 0.15, 0.03, 1500.0).curve()
    found = law(np.exp(-np.array([0.05, 0.1, 0.15, 0.2]))) + 100.0
    np.testing.assert_allclose(found, [164.79, 241.73, 354.34, 519.13], atol=0.01)
    column = MaterialColumn(1.0, law, constant(1e-3), 100.0)
    assert column.final == pytest.approx(0.07249, abs=1e-5)
    (now,) = column.at([0.5], 25, 30)
    assert now.pressure == pytest.approx(22.30, abs=0.03)
    assert now.settlement == pytest.approx(0.06350, abs=2e-5)


@pytest.mark.parametrize(
    ("dim", "time", "centre"),
    [
        (2, 0.05, 1.18226), (2, 0.1, 1.10732), (2, 0.2, 0.77614),
        (3, 0.05, 1.36372), (3, 0.1, 1.19410), (3, 0.2, 0.68173),
    ],
)  # fmt: skip
def test_cylinder_and_sphere(dim: int, time: float, centre: float) -> None:
    """The numbers are those of another computation, for the sphere by the Laplace transform."""
    assert PressedBall(dim, 0.2).pressure(0.0, time) == pytest.approx(centre, abs=1e-5)
    assert PressedBall(dim, 0.2).pressure(1.0, time) == pytest.approx(0.0, abs=1e-12)


DRAIN_TIMES = (0.05, 0.1, 0.2, 0.5)


@pytest.mark.parametrize(
    ("ratio", "free", "equal"),
    [
        (5.0, [0.37517, 0.58062, 0.81105, 0.98272], [0.34762, 0.57440, 0.81886, 0.98604]),
        (10.0, [0.24839, 0.41077, 0.63771, 0.91579], [0.22387, 0.39762, 0.63713, 0.92068]),
    ],
)
def test_ring_around_a_drain(ratio: float, free: list[float], equal: list[float]) -> None:
    drain = RadialDrain(ratio)
    assert [drain.degree(time) for time in DRAIN_TIMES] == pytest.approx(free, abs=1e-5)
    assert [drain.equal_strain(time) for time in DRAIN_TIMES] == pytest.approx(equal, abs=1e-5)
    radius = np.linspace(1.0, ratio, 2001)
    pressure = np.array([drain.pressure(r, 0.1) for r in radius])
    assert pressure[0] == pytest.approx(0.0, abs=1e-12)
    mean = 2.0 * np.trapezoid(pressure * radius, radius) / (ratio**2 - 1.0)
    assert mean == pytest.approx(1.0 - drain.degree(0.1), abs=1e-6)


def test_thin_ring_around_a_drain_is_a_layer() -> None:
    """A ring ever thinner than its radius, where the water has the same way, knows no curvature."""
    time, layer = 0.2, LayerOnDrain(UNIT)
    differences = []
    for thickness in (1e-2, 1e-3):
        drain, scaled = (
            RadialDrain(1.0 + thickness),
            time * (thickness / (1.0 + thickness)) ** 2 / 4,
        )
        differences.append(drain.degree(scaled) - layer.settlement(time))
        steps = [scaled / 10] * 10
        of_steps = layer.settlement(time, [time / 10] * 10)
        assert drain.degree(scaled, steps) == pytest.approx(of_steps, abs=0.2 * thickness)
    assert abs(differences[0]) < 0.2 * 1e-2
    assert differences[0] == pytest.approx(10.0 * differences[1], rel=0.05)


def test_steps_around_a_drain_leave_an_error_of_first_order() -> None:
    drain = RadialDrain(5.0)
    errors = [drain.degree(0.1, [0.1 / n] * n) - drain.degree(0.1) for n in (100, 200)]
    assert errors[0] == pytest.approx(2.0 * errors[1], rel=0.02)
