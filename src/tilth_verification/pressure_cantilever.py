# SPDX-License-Identifier: BSD-3-Clause
"""A cantilever under a pressure that stays normal to its top, against finite elements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.curves import Chain, LocalCubicSpline
from tilth.curves.nearest import NearestPoints
from tilth.curves.spline import left
from tilth.model import Model, SurfaceLoad
from tilth.surface.tracked import TrackedSurface
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.comparison import Comparison, absolute, at_least, vanishing
from tilth_verification.reference import pressure_cantilever

PROBLEM = "pressure_cantilever"
LENGTH = 10.0
END_FACE = np.array([[10.0, 1.0], [10.0, 2.0]])
"""Middle and top corner of the end face [m]: the points of the reference."""
ROOT_TOP = np.array([0.0, 2.0])
"""Upper corner of the root [m], where the pressure ends."""
MODULI = (1e6, 5e5, 2.5e5)
"""Young's moduli [Pa]."""
COARSE_TOLERANCE = {1e6: 0.02, 5e5: 0.06, 2.5e5: 0.06}
"""Largest distances to the reference over the length on cells of 0.5 m, by Young's modulus."""
TOLERANCE = 0.02
"""The same on cells of 0.25 m."""
PAPER_GRID_TOLERANCE = 0.06
"""The same on the paper's cells of 1.5 m, of which 1.3 span the depth: a regression bound only."""
LINEAR_POINTS = 6
"""Points per cell and direction of the linear basis; four are too few for cell crossing."""
TIME_TOLERANCE = 1e-9
"""Load fractions that differ by less are equal."""
BALANCE_TOLERANCE = 1e-4
"""Round-off while the surface is in cells with soil; in an empty cell the displacement is that of
the nearest one, extrapolated, and jumps between two of them."""
LEAST_ORDER = 1.5
"""Least order between two grids of a second-order method."""
SOURCE = "FE, nine-node"


@dataclass(frozen=True)
class Bending:
    """Differences of a bent beam from the reference.

    Attributes:
        distance: largest distance of the end face's two points at all loads of the reference, over
            the length [-]; NaN if one of these loads was not computed.
        end: displacement of the middle of the end face under full load [m], shape (2,).
        reference_end: the same of the reference.
        balance: largest sum of root reaction and pressure on the top's chord, over the latter [-].
        gap: load fraction -> area between the surface and the reference's outline, over the
            length of the outline and that of the beam [-].
    """

    distance: float
    end: Floats
    reference_end: Floats
    balance: float
    gap: dict[float, float]


def comparisons(long: bool) -> Iterator[Comparison]:
    """The paper's grid, cells of 0.5 m with all moduli, cells of 0.25 m with the softest beam."""
    yield from compare("E 1000 kPa, h 1.5 m", bend(example(PROBLEM)), PAPER_GRID_TOLERANCE)
    coarse = {}
    for modulus in MODULI:
        coarse[modulus] = bend(finer(modulus, 0.5))
        at = f"E {modulus / 1e3:g} kPa, h 0.5 m"
        yield from compare(at, coarse[modulus], COARSE_TOLERANCE[modulus])
    for modulus in MODULI if long else MODULI[-1:]:
        fine = bend(finer(modulus, 0.25))
        at = f"E {modulus / 1e3:g} kPa, h 0.25 m"
        yield from compare(at, fine, TOLERANCE)
        yield from orders(f"E {modulus / 1e3:g} kPa, h 0.5 and 0.25 m", coarse[modulus], fine)
        if long and modulus != MODULI[1]:
            finest = bend(finer(modulus, 0.125))
            yield from compare(f"E {modulus / 1e3:g} kPa, h 0.125 m", finest, 0.25 * TOLERANCE)
            yield from orders(f"E {modulus / 1e3:g} kPa, h 0.25 and 0.125 m", fine, finest)
    for basis in BASES:
        if basis != "gimp":  # the one of all rows above
            yield from with_other(basis, long)


def with_other(basis: str, long: bool) -> Iterator[Comparison]:
    """The softest beam with another basis: cells of 0.5 m, long of 0.25 m, and the order.

    Standard points leave cells at the surface empty, where the displacement is extrapolated: so
    there is no row on their balance and none on the order.
    """
    modulus, other = MODULI[-1], basis != "linear"
    changes = {} if other else {"bodies.0.points_per_cell": LINEAR_POINTS}
    at = f"E {modulus / 1e3:g} kPa, {basis}, h"
    rows = compare if other else shape
    coarse = bend(varied(with_basis(finer(modulus, 0.5), basis), changes))
    yield from rows(f"{at} 0.5 m", coarse, COARSE_TOLERANCE[modulus])
    if long:
        fine = bend(varied(with_basis(finer(modulus, 0.25), basis), changes))
        yield from rows(f"{at} 0.25 m", fine, TOLERANCE)
        if other:
            yield from orders(f"{at} 0.5 and 0.25 m", coarse, fine)


def compare(at: str, bending: Bending, tolerance: float) -> Iterator[Comparison]:
    """The beam's shape, and the balance of its forces."""
    yield from shape(at, bending, tolerance)
    quantity = f"root reaction less the pressure on the top's chord, over it, {at}"
    yield vanishing(quantity, bending.balance, BALANCE_TOLERANCE, "equilibrium")


def shape(at: str, bending: Bending, tolerance: float) -> Iterator[Comparison]:
    """The end face in every step, its middle at the end, and the whole surface at two times."""
    quantity = f"largest distance of the end face over the length, {at}"
    yield vanishing(quantity, bending.distance, tolerance, SOURCE)
    ends = zip("xy", bending.end, bending.reference_end, strict=True)
    for axis, computed, expected in ends:
        quantity = f"displacement {axis} of the end face's middle, {at}"
        yield absolute(quantity, float(computed), float(expected), tolerance * LENGTH, SOURCE, "m")
    for fraction, gap in bending.gap.items():
        quantity = f"mean distance of the surface over the length, load {fraction:g}, {at}"
        yield vanishing(quantity, gap, tolerance, SOURCE)


def orders(at: str, coarse: Bending, fine: Bending) -> Iterator[Comparison]:
    """Order of the differences from the reference, with cells half as large."""
    order = float(np.log2(coarse.distance / fine.distance))
    yield at_least(
        f"order of the end face's distance, {at}", order, LEAST_ORDER, 0.0, "second order"
    )
    for fraction, gap in fine.gap.items():
        order = float(np.log2(coarse.gap[fraction] / gap))
        quantity = f"order of the surface's distance, load {fraction:g}, {at}"
        yield at_least(quantity, order, LEAST_ORDER, 0.0, "second order")


def finer(young_modulus: float, cell_size: float) -> Model:
    """Returns the model with GIMP points on another grid."""
    changes = {"materials.rubber.young_modulus": young_modulus, "grid.cell_size": cell_size}
    return varied(example(PROBLEM, "fine.toml"), changes)


def bend(model: Model) -> Bending:
    """Bends a beam; returns its differences from the reference of its Young's modulus."""
    reference = pressure_cantilever(model.materials["rubber"].parameter("young_modulus"))
    load = model.loads[0]
    assert isinstance(load, SurfaceLoad)
    pressure = load.pressure
    end = np.full((len(reference.load_fraction), 2, 2), np.nan)
    gap: dict[float, float] = {}
    balance = 0.0

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        nonlocal balance
        surface = simulation.state.surfaces["beam"]
        assert isinstance(surface, TrackedSurface)
        (beam,) = surface.chains
        points = moved_points(beam.initial, beam.current)
        # a step that was halved adds times that the reference does not have
        end[np.isclose(reference.load_fraction, time, rtol=0.0, atol=TIME_TOLERANCE)] = (
            points - END_FACE
        )
        force = model.load_curve(load).factor(time) * pressure * left(ROOT_TOP - points[1])
        residual = np.linalg.norm(result.resultant("root") + force)
        balance = max(balance, float(residual / np.linalg.norm(force)))
        for fraction, outline in reference.outlines.items():
            if abs(time - fraction) < TIME_TOLERANCE:
                gap[fraction] = mean_distance(beam.current, outline) / LENGTH

    march(model, after_step)
    distance = np.linalg.norm(end - reference.displacement, axis=2).max() / LENGTH
    return Bending(float(distance), end[-1, 0], reference.displacement[-1, 0], balance, gap)


def moved_points(initial: Chain, now: Chain) -> Floats:
    """Returns the current positions of the end face's two points [m], shape (2, 2)."""
    at = NearestPoints(LocalCubicSpline(initial)).find(END_FACE)
    return LocalCubicSpline(now).position(at.segment, at.parameter)


def mean_distance(surface: Chain, outline: Floats) -> float:
    """Returns the area between a spline and an outline over the outline's length [length].

    The distances of the outline's points, shape (n, 2), are integrated along it by the trapezoidal
    rule; for curves that are close to each other this is the area between them.
    """
    arm = NearestPoints(LocalCubicSpline(surface)).find(outline).offset
    distance = np.linalg.norm(arm, axis=1)
    chord = np.linalg.norm(np.diff(outline, axis=0), axis=1)
    return float(0.5 * (distance[1:] + distance[:-1]) @ chord / chord.sum())
