# SPDX-License-Identifier: BSD-3-Clause
"""Smooth square footing on clay, in 3D: limit load, locking without F-bar, stress under it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.analysis.march import initial_position, march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import Model
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, relative, vanishing
from tilth_verification.reference import square_footing
from tilth_verification.strip_footing import PLATEAU, SETTLEMENT, relative_slope

PROBLEM, GRADED = "square_footing", "graded.toml"
SIDE = 5.0
"""Of the block of soil [m]."""
REFERENCE_STEPS: Mapping[str, Any] = MappingProxyType(
    {"boundaries.5.factor": [[0.0, 0.0], [20.0, 0.2], [30.0, 1.0]], "schedule.end": 30.0}
    | {"schedule.steps": 30, "schedule.outputs": 1}
)
"""The reference's own load steps."""
FEW_STEPS: Mapping[str, Any] = MappingProxyType(
    {"boundaries.5.factor": [[0.0, 0.0], [2.0, 0.08], [5.0, 0.4], [8.0, 1.0]]}
    | {"schedule.end": 8.0, "schedule.steps": 8, "schedule.outputs": 1}
)
"""Where no curve is compared."""
LIMIT = 5.25
"""P / c that graded B-bar elements tend to [-]."""
ELEMENTS = "B-bar elements of the same size"


@dataclass(frozen=True)
class Press:
    """One run.

    Attributes:
        settlement: after each step [m], shape (steps,).
        pressure: load over nominal area and shear strength [-], shape (steps,).
        iterations: Newton iterations of each step, shape (steps,).
        column: minor principal stress over the shear strength [-] of the points initially nearest
            to the axis, from the footing down, shape (points,).
    """

    settlement: Floats
    pressure: Floats
    iterations: npt.NDArray[np.int64]
    column: Floats


def comparisons(long: bool) -> Iterator[Comparison]:
    """Coarse cells with and without F-bar, graded ones; long: elements' curves, as published."""
    coarse = footing(0.5, 0.5, FEW_STEPS)
    yield from a_limit_load(coarse, "h 0.5 m")
    locked = footing(0.5, 0.5, FEW_STEPS, anti_locking="none")
    yield from no_limit_load(locked, coarse, "h 0.5 m", 1.1)
    yield from graded()
    if long:
        yield from against_elements()
        yield from as_published()
        yield from edge_in_cell()


def graded() -> Iterator[Comparison]:
    """Small cells at the edges, in the middle of which these are."""
    run = press(example(PROBLEM, GRADED), 0.5)
    yield from a_limit_load(run, "graded")
    pressure = float(run.pressure[-1])
    yield relative("P / c at 2 mm, graded", pressure, LIMIT, 0.03, "graded elements")


def against_elements() -> Iterator[Comparison]:
    """Curves on grids that fit the footing, against elements of the same size.

    As there, it holds the nodes at its edges. An implicit one does not (decision 47).
    """
    for half_width, h in ((0.6, 0.2), (0.4, 0.2), (0.5, 0.25), (0.5, 0.125)):
        run = footing(half_width, h, {**REFERENCE_STEPS, **on_nodes(half_width)})
        reference = square_footing(half_width, h)
        exact = np.interp(run.settlement, reference.settlement, reference.pressure)
        worst = int(np.abs(run.pressure / exact - 1.0).argmax())
        where = f"half-width {half_width:g} m, h {h:g} m"
        quantity = f"P / c at {run.settlement[worst]:.3g} m, the worst of the curve, {where}"
        yield relative(quantity, run.pressure[worst], exact[worst], 0.03, ELEMENTS)


def as_published() -> Iterator[Comparison]:
    """125,000 points, cells of 0.2 m that do not fit the footing, 200 steps.

    Once with a grid that follows the footing's edge and once with the fixed one of Augarde et al.
    (2018), whose lines are half a cell from the footing's edges.
    """
    for name, fixed in (("edge followed", {}), ("fixed grid", {"grid.follow": None})):
        f_bar, standard = (footing(0.5, 0.2, fixed, anti_locking=way) for way in ("f_bar", "none"))
        yield from a_limit_load(f_bar, name)
        if fixed:
            quantity = f"P / c at 2 mm, {name}, half a cell from the edge to a line"
            yield relative(quantity, float(f_bar.pressure[-1]), LIMIT, 0.1, "graded elements")
        yield from no_limit_load(standard, f_bar, name, 1.5)
        yield from stress_under_the_footing(f_bar, standard, name)
        quantity = f"Newton iterations a step, 200 steps, {name}"
        yield vanishing(quantity, float(f_bar.iterations.mean()), 5.0, "with the predictor")


def on_nodes(half_width: float) -> dict[str, Any]:
    """Returns the changes with which the footing is a condition at nodes."""
    declared = {"name": "footing", "type": "plane", "axis": "z", "at": SIDE}
    declared |= {"range": {"x": [0.0, half_width], "y": [0.0, half_width]}}
    declared |= {"condition": "prescribed", "displacement": {"z": -SETTLEMENT}}
    return {"grid.follow": None, "boundaries.5": declared}


def a_limit_load(run: Press, name: str) -> Iterator[Comparison]:
    """Compares the final slope of the load with 0: the load is a limit load."""
    slope = relative_slope(run.settlement, run.pressure)
    quantity = f"slope at 2 mm over that at the start, P / c = {run.pressure[-1]:.3f}, {name}"
    yield vanishing(quantity, slope, PLATEAU, "a limit load")


def no_limit_load(standard: Press, f_bar: Press, name: str, least: float) -> Iterator[Comparison]:
    """Without F-bar the load is higher, and still rising."""
    ratio = standard.pressure[-1] / f_bar.pressure[-1]
    yield at_least(
        f"P / c at 2 mm without F-bar over that with, {name}", ratio, least, 0.0, "no limit load"
    )
    slope = relative_slope(standard.settlement, standard.pressure)
    quantity = f"slope at 2 mm over that at the start without F-bar, {name}"
    yield at_least(quantity, slope, 2.0 * PLATEAU, 0.0, "keeps rising")


def stress_under_the_footing(f_bar: Press, standard: Press, name: str) -> Iterator[Comparison]:
    """Compressive and smooth down the axis with F-bar."""
    quantity = f"greatest minor principal stress / c on the axis, {name}"
    yield at_least(f"{quantity}, negated", -f_bar.column.max(), 0.0, 0.0, "compression")
    with_it, without = (oscillation(run.column) for run in (f_bar, standard))
    quantity = f"oscillation of it (without F-bar {without:.2g}), {name}"
    # the pressure is constant in each cell, so that even a smooth one decreases in steps
    yield vanishing(quantity, with_it, 0.25, "steps from cell to cell")
    quantity = (
        f"changes of its slope's sign (without F-bar {sign_changes(standard.column)}), {name}"
    )
    yield vanishing(quantity, float(sign_changes(f_bar.column)), 6.0, "smooth")
    quantity = f"oscillation without F-bar over that with, {name}"
    yield at_least(quantity, without / with_it, 5.0, 0.0, "a chequerboard of pressure")


def oscillation(stress: Floats) -> float:
    """Returns the RMS deviation from the mean of the neighbours over the mean magnitude [-]."""
    deviation = stress[1:-1] - 0.5 * (stress[:-2] + stress[2:])
    return float(np.sqrt((deviation**2).mean()) / np.abs(stress).mean())


def sign_changes(stress: Floats) -> int:
    """Returns the number of sign changes of the slope of the stress from point to point."""
    sign = np.sign(np.diff(stress))
    return int((sign[1:] * sign[:-1] < 0.0).sum())


def edge_in_cell() -> Iterator[Comparison]:
    """The edges at six positions in their cells, on 2.5 m of soil; a grid that follows them."""
    small = {"bodies.0.shape.upper": [2.5] * 3, "boundaries.5.geometry.centre": [0.0, 0.0, 2.5]}
    for k in (2, 3):
        small[f"boundaries.{k}.geometry.point"] = [2.5 * (k == 2), 2.5 * (k == 3), 0.0]
    spread = {}
    for h, tolerance in ((0.25, 0.22), (0.125, 0.11)):
        spread[h] = spread_over_a_cell(h, {**small, "grid.follow": None})
        quantity = f"spread of P / c over six positions of the edge in its cell, h {h:g} m"
        yield vanishing(quantity, spread[h], tolerance, "the same footing")
    quantity = "spread at h 0.25 m over that at 0.125 m"
    yield at_least(quantity, spread[0.25] / spread[0.125], 1.5, 0.0, "it falls with the cell")
    quantity = "spread on a grid that follows the edges, h 0.25 m"
    # the declared origin also determines the walls' quadrature points
    yield vanishing(quantity, spread_over_a_cell(0.25, small), 1e-3, "no edge inside a cell")


def spread_over_a_cell(h: float, changes: Mapping[str, Any]) -> float:
    """Returns (greatest - least) / mean of P / c at 2 mm, six positions of the grid."""
    limits = []
    for share in np.arange(6) / 6.0:
        corner = [0.5 - h * share] * 2
        changed = {**changes, **FEW_STEPS, "grid.origin": [*corner, 0.0]}
        limits.append(footing(0.5, h, changed, side=2.5).pressure[-1])
    return float(np.ptp(limits) / np.mean(limits))


def footing(
    half_width: float,
    h: float,
    changes: Mapping[str, Any],
    *,
    anti_locking: str = "f_bar",
    side: float = SIDE,
) -> Press:
    """Returns the run of a footing on a block of cells of `h` [m], with other values at keys."""
    model = varied(
        example(PROBLEM),
        {
            "grid.cell_size": h,
            "grid.follow.place": [half_width, half_width, side],
            "bodies.0.points": [round(2.0 * side / h)] * 3,
            "bodies.0.anti_locking": anti_locking,
            "boundaries.5.geometry.width": [2.0 * half_width] * 2,
            **changes,
        },
    )
    return press(model, half_width)


def press(model: Model, half_width: float) -> Press:
    """Returns the run of a footing of this half width [m]."""
    plate = next(b for b in model.boundaries if b.name == "footing")
    shear_strength = model.materials["clay"].parameter("yield_stress") / np.sqrt(3.0)
    rows: list[tuple[float, float, int]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        pressure = -result.resultant("footing")[2] / half_width**2 / shear_strength
        settlement = model.load_curve(plate).factor(time) * SETTLEMENT
        rows.append((settlement, pressure, result.equilibrium.iterations))

    points = march(model, after_step).state.points
    start = initial_position(points)
    on_axis = np.flatnonzero((start[:, :2] < start[:, :2].min(axis=0) + 1e-6).all(axis=1))
    on_axis = on_axis[np.argsort(-start[on_axis, 2])]
    xx, yy, zz, xy, yz, xz = points.stress[on_axis].T
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    minor = np.linalg.eigvalsh(tensor)[:, 0] / shear_strength
    settlement, pressure, iterations = np.array(rows).T
    return Press(settlement, pressure, iterations.astype(np.int64), minor)
