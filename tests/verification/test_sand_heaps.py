# SPDX-License-Identifier: BSD-3-Clause
"""Heaps of sand without cohesion: those below the angle of repose stand, on any grid.

Their factors of safety lie between Davis' (form B) and 1.05 times that of the infinite slope; with
dilation 1.05 times that of the thinnest slip circle that the grid resolves.
"""

from __future__ import annotations

import math

import pytest
from readings import long
from safety_slopes import HIGH, LOW
from sand_heaps import SandHeap

from tilth import AnalysisFailed, StrengthReduction
from tilth.analysis.march import march
from tilth.analysis.safety import SafetyResult, strength_reduction

COARSE, FINE = 0.5, 0.25
"""Cells of a tenth and a twentieth of the height [m]."""
PLANE, ROUND = "plane_strain", "axisymmetric"


def factor(heap: SandHeap, cell_size: float) -> SafetyResult:
    """Runs a heap and finds its factor of safety."""
    model = heap.model(cell_size)
    settings = StrengthReduction(tolerance=0.02)
    return strength_reduction(march(model), model.schedule.end, settings)


@pytest.mark.parametrize("angle", [0.0, 17.0, 45.0])
@pytest.mark.parametrize("slope", [27.0, 31.0, 35.0])
def test_heaps_stand(slope: float, angle: float) -> None:
    """Davis' angle of repose of phi 37, psi 0 is 31 degrees; up to 37 there are equilibria."""
    march(SandHeap(37.0, 0.0, slope, angle).model(COARSE))


@pytest.mark.parametrize(
    ("friction_angle", "dilation_angle", "cell_size", "kind"),
    [
        (37.0, 37.0, COARSE, PLANE), (37.0, 0.0, COARSE, ROUND), (30.0, 0.0, COARSE, PLANE),
        *(
            long(phi, psi, cell, kind)
            for phi in (30.0, 37.0, 45.0)
            for psi in (0.0, 0.5 * phi, phi)
            for cell in (COARSE, FINE)
            for kind in (PLANE, ROUND)
        ),
    ],
)  # fmt: skip
def test_heaps_below_the_angle_of_repose_stand(
    friction_angle: float, dilation_angle: float, cell_size: float, kind: str
) -> None:
    """From half the friction angle up to 0.95 of Davis' angle, turned in the plane."""
    davis = math.degrees(math.atan(SandHeap(friction_angle, dilation_angle, 1.0).tangent()))
    for slope in (0.5 * friction_angle, 0.75 * davis, 0.95 * davis):
        for angle in (0.0, 17.0, 45.0) if kind == PLANE else (0.0,):
            march(SandHeap(friction_angle, dilation_angle, slope, angle, kind).model(cell_size))


@pytest.mark.parametrize("friction_angle", [30.0, 37.0])
def test_a_heap_steeper_than_the_friction_angle_does_not_stand(friction_angle: float) -> None:
    with pytest.raises(AnalysisFailed):
        march(SandHeap(friction_angle, 0.0, friction_angle + 1.5).model(COARSE))


@pytest.mark.parametrize(
    "heap",
    [
        pytest.param(SandHeap(37.0, 0.0, 29.6), marks=pytest.mark.slow),
        *(
            long(SandHeap(phi, 0.0, 0.8 * phi, angle))
            for phi in (30.0, 37.0, 45.0)
            for angle in (0.0, 17.0, 45.0)
        ),
        long(SandHeap(37.0, 0.0, 30.0, kind=ROUND)), long(SandHeap(30.0, 0.0, 20.0, kind=ROUND)),
    ],
)  # fmt: skip
def test_factors_without_dilation(heap: SandHeap) -> None:
    davis, slope = heap.bounds()
    found = factor(heap, FINE)
    assert found.is_decided
    assert LOW * davis <= found.factor <= HIGH * slope


@pytest.mark.parametrize(
    "heap",
    [
        long(SandHeap(phi, psi, 0.8 * phi, angle))
        for phi in (30.0, 37.0, 45.0)
        for psi in (0.5 * phi, phi)
        for angle in (0.0, 17.0, 45.0)
    ],
)
def test_factors_with_dilation(heap: SandHeap) -> None:
    davis, _ = heap.bounds()
    found = factor(heap, FINE)
    assert found.is_decided
    assert LOW * davis <= found.factor <= HIGH * heap.resolved(FINE)


@pytest.mark.long
def test_the_bias_falls_with_the_cells() -> None:
    heap = SandHeap(37.0, 37.0, 29.6)
    _, exact = heap.bounds()
    coarse, fine = (factor(heap, cell).factor / exact - 1.0 for cell in (COARSE, FINE))
    assert 0.0 < fine < 0.6 * coarse
