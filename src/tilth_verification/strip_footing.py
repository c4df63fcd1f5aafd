# SPDX-License-Identifier: BSD-3-Clause
"""A smooth strip footing on nearly incompressible clay: its limit load, 2 + pi times c."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth_verification.cases import BASES, example, varied
from tilth_verification.comparison import Comparison, at_least, relative, vanishing
from tilth_verification.reference import strip_footing
from tilth_verification.turned import (
    ALIGNED,
    ANGLE,
    ANGLES,
    aligned,
    reaction_difference,
    reactions,
    turned,
)

PROBLEM = "strip_footing"
LIMIT = 2.0 + np.pi
"""Pressure of a rigid strip footing on weightless clay over its shear strength (Prandtl) [-]."""
HALF_WIDTH = 0.5
"""Half-width of the footing [m]."""
SETTLEMENT = 0.002
"""Final settlement of the footing [m]."""
PLATEAU = 0.01
"""Largest slope at the end that is a limit load, over the slope at the start [-]."""
TOLERANCE = 0.07
"""Of the limit load on cells of 0.1 m; the footing's edge makes the error first order in them."""
FOLLOWED = {"boundary": "footing", "place": [HALF_WIDTH, 5.0], "axes": ["x"]}
"""A line of the grid goes through the footing's edge in every step."""
FEW_STEPS: Mapping[str, Any] = MappingProxyType(
    {
        "boundaries.3.factor": [[0.0, 0.0], [2.0, 0.1], [6.0, 0.3], [8.0, 0.5], [10.0, 1.0]],
        "schedule.end": 10.0,
        "schedule.steps": 10,
        "schedule.outputs": 1,
    }
)
"""For the finer grids, whose curves are not compared: they lift the limit by 0.2 %."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """The limit load, the curve up to it, its plateau, and the same without F-bar and off lines."""
    settlement, pressure = press("case.toml")
    yield from against_elements(settlement, pressure)
    yield from limit_load("h 0.1 m", settlement, pressure, TOLERANCE)
    yield from standard_formulation(pressure[-1])
    _, implicit = press("implicit.toml")
    quantity = "P / c at 2 mm, implicit boundaries off the grid lines, h 0.1 m"
    yield relative(quantity, implicit[-1], LIMIT, TOLERANCE, "2 + pi")
    for basis in BASES:
        yield from coarse_with(basis)
    yield from graded()
    if long:
        for basis in BASES[1:]:  # the first one is that of the case
            yield from fine_with(basis)
        yield from surface_in_cell(pressure[-1])
        yield from towards_the_limit()
    yield from edge_in_cell(long)
    yield from turned_copies(long)


def turned_copies(long: bool) -> Iterator[Comparison]:
    """Turned, on a grid that follows the footing's edge: the final reaction of each boundary."""
    for size, tolerance in ((0.1, 0.15), (0.05, 0.08)) if long else ((0.1, 0.15),):
        model = varied(aligned(PROBLEM, size), FEW_STEPS)
        reference = reactions(model)
        quantity = f"greatest change of a reaction's component over the footing's, h {size:g} m"
        for angle in ANGLES if long else (ANGLE,):
            change = reaction_difference(reactions(turned(model, angle), angle), reference)
            at = f"turned by {angle:g} degrees"
            yield vanishing(f"{quantity}, {at}", change, tolerance, ALIGNED)


def graded() -> Iterator[Comparison]:
    """The limit load on cells of 12.5 mm at the footing's edge that grow away from it."""
    curve = press("graded.toml", FEW_STEPS)
    yield from limit_load("graded, h 0.0125 m at the edge", *curve, 0.01)


def coarse_with(basis: str) -> Iterator[Comparison]:
    """The limit load with a basis on cells of 0.25 m, in a few steps."""
    h = 0.25
    curve = press("case.toml", {"bodies.0.basis": basis, "grid.cell_size": h, **FEW_STEPS})
    yield from limit_load(f"{basis}, h {h:g} m", *curve, TOLERANCE * h / 0.1)


def fine_with(basis: str) -> Iterator[Comparison]:
    """The curve and the limit load with a basis on cells of 0.1 m."""
    curve = press("case.toml", {"bodies.0.basis": basis})
    yield from against_elements(*curve, f"{basis}, ")
    yield from limit_load(f"{basis}, h 0.1 m", *curve, TOLERANCE)


def limit_load(
    at: str, settlement: Floats, pressure: Floats, tolerance: float
) -> Iterator[Comparison]:
    """The load at the end against the limit load, and its plateau."""
    yield relative(f"P / c at 2 mm, {at}", pressure[-1], LIMIT, tolerance, "2 + pi")
    slope = relative_slope(settlement, pressure)
    yield vanishing(f"slope at 2 mm over that at the start, {at}", slope, PLATEAU, "a limit load")


def against_elements(settlement: Floats, pressure: Floats, of: str = "") -> Iterator[Comparison]:
    """The curve on cells of 0.1 m against elements of the same size, at its largest error."""
    reference = strip_footing(0.1)
    exact = np.interp(settlement, reference.settlement, reference.pressure)
    worst = int(np.abs(pressure / exact - 1.0).argmax())
    quantity = f"P / c at {settlement[worst]:.3g} m, the worst of the curve, {of}h 0.1 m"
    source = "B-bar elements of the same size"
    yield relative(quantity, pressure[worst], exact[worst], 0.02, source)


def standard_formulation(limit: float) -> Iterator[Comparison]:
    """Without F-bar: above the load with it, and still rising."""
    settlement, pressure = press("standard.toml")
    quantity = "P / c at 2 mm without F-bar over that with it, h 0.1 m"
    yield at_least(quantity, pressure[-1] / limit, 1.2, 0.0, "no limit load")
    slope = relative_slope(settlement, pressure)
    quantity = "slope at 2 mm over that at the start without F-bar, h 0.1 m"
    yield at_least(quantity, slope, 2.0 * PLATEAU, 0.0, "keeps rising")


def surface_in_cell(flush: float) -> Iterator[Comparison]:
    """The surface slightly above a grid line.

    Stabilisation of partly filled cells must not carry load where the soil yields: `flush` is P / c
    with the surface on a grid line.
    """
    height = example(PROBLEM, "implicit.toml").cell_size[1]
    for share in (0.1, 0.4):
        origin = 5.0 - (50.0 + share) * height
        _, pressure = press("implicit.toml", {"grid.origin": [HALF_WIDTH, origin]})
        quantity = f"P / c at 2 mm, surface {share:g} of a cell above a grid line, h 0.1 m"
        yield relative(quantity, pressure[-1], flush, 0.03, "surface on a grid line")


def edge_in_cell(long: bool) -> Iterator[Comparison]:
    """The footing's edge at positions across a cell, on fixed grids and one that follows it.

    The last vertex that holds soil is before the edge, which its load follows (decision 47).
    """
    h, count = 0.1, 10 if long else 4
    loads = yield from of_positions(h, count, 0.06, 0.03)
    if not long:
        return
    coarse = yield from of_positions(2.0 * h, count, 0.11, 0.06)
    order = float(np.log2(spread_of(coarse) / spread_of(loads)))
    yield at_least("order of the spread, h 0.2 and 0.1 m", order, 0.8, 0.0, "first order")
    rough = {"boundaries.3.condition": "fixed"}
    yield from of_positions(h, count, 0.06, 0.06, rough)
    yield from of_positions(2.0 * h, count, 0.11, 0.12, rough)
    quantity = "spread of P / c on a grid that follows the edge, h 0.1 m"
    followed = over_a_cell(h, count, {"grid.follow": FOLLOWED})
    yield vanishing(quantity, spread_of(followed), 1e-6, "no edge inside a cell")


def of_positions(
    h: float,
    count: int,
    tolerance: float,
    bias: float,
    changes: Mapping[str, Any] = MappingProxyType({}),
) -> Generator[Comparison, None, Floats]:
    """Spread and mean of `over_a_cell`, which it returns; tolerance and bias: the largest ones."""
    loads = over_a_cell(h, count, changes)
    rough = ", rough" if changes else ""
    at = f"over {count} positions of the edge in its cell, h {h:g} m{rough}"
    yield vanishing(f"spread of P / c {at}", spread_of(loads), tolerance, "the same footing")
    yield relative(f"mean of P / c {at}", float(loads.mean()), LIMIT, bias, "2 + pi")
    return loads


def spread_of(loads: Floats) -> float:
    """Returns (greatest - least) / mean."""
    return float(np.ptp(loads) / loads.mean())


def over_a_cell(h: float, count: int, changes: Mapping[str, Any]) -> Floats:
    """Returns P / c at 2 mm for `count` positions of the grid along x, cells of about `h` [m].

    changes: other values at dotted keys.
    """
    limits = []
    for share in np.arange(count) / count:
        placed = {
            "grid.cell_size": [1.03 * h, 0.99 * h],
            "grid.origin": [HALF_WIDTH - 1.03 * h * share, -0.25 * h],
            "bodies.0.points": [round(10.0 / h)] * 2,
            **FEW_STEPS,
        }
        limits.append(press("implicit.toml", {**placed, **changes})[1][-1])
    return np.array(limits)


def towards_the_limit() -> Iterator[Comparison]:
    """Smaller cells, what they tend to, and how fast, all in the same few steps.

    The footing's edge makes it first order: the loaded nodes act as a wider footing.
    """
    sizes = (0.1, 0.05, 0.025)
    curves = [press("case.toml", {"grid.cell_size": h, **FEW_STEPS})[1] for h in sizes]
    yield relative("P / c at 2 mm, h 0.05 m", curves[1][-1], LIMIT, 0.04, "2 + pi")
    yield relative("P / c at 2 mm, h 0.025 m", curves[2][-1], LIMIT, 0.02, "2 + pi")
    # the closed form is for small strains: later the cells at the edge deform, and the load falls
    coarse, fine, finest = (float(curve.max()) for curve in curves)
    extrapolated = 2.0 * finest - fine
    quantity = "highest P / c, extrapolated from h 0.05 and 0.025 m at first order"
    yield relative(quantity, extrapolated, LIMIT, 0.005, "2 + pi")
    order = float(np.log2((coarse - fine) / (fine - finest)))
    yield at_least("order from h 0.1, 0.05 and 0.025 m", order, 0.8, 0.0, "first order")


def relative_slope(settlement: Floats, pressure: Floats) -> float:
    """Returns the slope over the last quarter of the settlement over that of the first step."""
    end = settlement[-1]
    last = (pressure[-1] - np.interp(0.75 * end, settlement, pressure)) / (0.25 * end)
    return float(last * settlement[0] / pressure[0])


def press(file: str, changes: Mapping[str, Any] = MappingProxyType({})) -> tuple[Floats, Floats]:
    """Presses the footing into the clay, a case file with other values at dotted keys.

    Returns the settlements [m] and the pressures over the shear strength [-].
    """
    model = varied(example(PROBLEM, file), changes)
    footing = next(b for b in model.boundaries if b.name == "footing")
    shear_strength = model.materials["clay"].parameter("yield_stress") / np.sqrt(3.0)
    rows: list[tuple[float, float]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        pressure = -result.resultant("footing")[1] / HALF_WIDTH
        settlement = model.load_curve(footing).factor(time) * SETTLEMENT
        rows.append((settlement, pressure / shear_strength))

    march(model, after_step)
    settlement, pressure = np.array(rows).T
    return settlement, pressure
