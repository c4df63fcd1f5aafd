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
