# SPDX-License-Identifier: BSD-3-Clause
"""Footing on the crest of a slope: boundaries off the grid lines against boundaries on them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, relative

PROBLEM = "slope"
SOURCE = "aligned with the grid"
SETTLEMENT = 0.3
"""Of the footing at the end [m]."""
LOAD_TOLERANCE = 0.03
"""Greatest difference of the loads at equal settlement [-]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """The load at equal settlement: the worst of the curve, the end, and the mean falling."""
    sizes = (0.25, 0.125, 0.0625) if long else (0.5, 0.25)
    mean = []
    for h in sizes:
        settlement, aligned = press("aligned.toml", h)
        settlement_unaligned, unaligned = press("case.toml", h)
        unaligned = np.interp(settlement, settlement_unaligned, unaligned)
        difference = np.abs(unaligned / aligned - 1.0)
        mean.append(float(difference.mean()))
        worst = int(difference.argmax())
        quantity = f"load at {settlement[worst]:.3g} m, the worst of the curve, h {h:g} m"
        yield relative(quantity, unaligned[worst], aligned[worst], LOAD_TOLERANCE, SOURCE, "N")
        quantity = f"load at {SETTLEMENT:g} m, h {h:g} m"
        yield relative(quantity, unaligned[-1], aligned[-1], LOAD_TOLERANCE, SOURCE, "N")
    quantity = f"mean difference over the curve at h {sizes[0]:g} m over that at {sizes[-1]:g} m"
    yield at_least(quantity, mean[0] / mean[-1], 1.0, 0.0, "falls with the grid")


def press(file: str, h: float) -> tuple[Floats, Floats]:
    """Presses the footing into the crest on cells of about `h` [m], four points a cell.

    Returns the settlements [m] and the loads of the half model [N/m].
    """
    changes: dict[str, object] = {"bodies.0.spacing": 0.5 * h, "grid.cell_size": h}
    if file == "case.toml":  # a line through the edge, none on sides, base and crest
        changes["grid.cell_size"] = [1.024 * h, 0.96 * h]
        changes["grid.origin"] = [1.0, -0.5 * h]
    model = varied(example(PROBLEM, file), changes)
    rows: list[tuple[float, float]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        rows.append((time * SETTLEMENT, -result.resultant("footing")[1]))

    march(model, after_step)
    settlement, load = np.array(rows).T
    return settlement, load
