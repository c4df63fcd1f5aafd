# SPDX-License-Identifier: BSD-3-Clause
"""Columns of dry sand and of aluminium bars that collapse: how far they run out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tilth.analysis.march import initial_position, march
from tilth.arrays import Floats
from tilth.model import Model
from tilth.mpm.points import MaterialPoints
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, absolute, relative, vanishing

PROBLEM = "column_collapse"
PLANE, ROUND, BARS = "case.toml", "axisymmetric.toml", "bars.toml"
SHAPES = {PLANE: "plane", ROUND: "round"}
LUBE = "fit of Lube et al."
SHARE = 0.99
"""Share of the mass within the run-out [-]; a few points may lie ahead of the front."""
GRAVITY = 9.81
"""[m/s^2]"""
DURATION = 5.0
"""Of the analyses, over the time sqrt(H / g) [-]."""
CELLS = 20
"""Across the lesser of width and height of a column."""
LOW = (0.5, 1.0, 1.5)
"""Ratios of height and width below the change of the fits [-]."""
TALL = (3.0, 5.0)
"""Ratios above it, which give the exponent [-]."""


@dataclass(frozen=True)
class Deposit:
    """What is left of a column of the width d0.

    Attributes:
        run_out: (d - d0) / d0, with `SHARE` of the mass within d [-].
        depth: of the lowest point below the base [cells].
        motion: kinetic energy over the potential energy of the start [-].
    """

    run_out: float
    depth: float
    motion: float


def comparisons(long: bool) -> Iterator[Comparison]:
    """A plane column; long: lower and higher ones, round ones, other steps and grids, bars."""
    yield from fitted(PLANE, 1.0)
    if not long:
        return
    for file, ratio in itertools.product((PLANE, ROUND), LOW):
        if (file, ratio) != (PLANE, 1.0):
            yield from fitted(file, ratio)
    yield from exponent(PLANE)
    yield from exponent(ROUND)
    yield from steps_and_grids()
    yield from rests(collapse(example(PROBLEM, BARS), 0.2), "bars")


def fitted(file: str, ratio: float) -> Iterator[Comparison]:
    """Run-out of a column against the fit of its shape; no sand is in the base, and all rests."""
    fit = plane_fit if file == PLANE else round_fit
    found, name = collapse(column(file, ratio), 1.0), f"{SHAPES[file]}, a {ratio:g}"
    yield relative(f"run-out, {name}", found.run_out, fit(ratio), 0.25, LUBE)
    yield from rests(found, name)


def exponent(file: str) -> Iterator[Comparison]:
    """The power of a with which the run-out of tall columns grows."""
    fit = plane_fit if file == PLANE else round_fit
    found = [collapse(column(file, ratio), 1.0) for ratio in TALL]
    power = growth(*(each.run_out for each in found))
    expected, name = growth(*map(fit, TALL)), SHAPES[file]
    yield absolute(f"exponent of the run-out, {name}, a 3 to 5", power, expected, 0.15, LUBE)
    for ratio, each in zip(TALL, found, strict=True):
        yield from rests(each, f"{name}, a {ratio:g}")


def growth(lower: float, higher: float) -> float:
    """Returns the power of a with which run-outs grow between the two ratios of `TALL`."""
    return math.log(higher / lower) / math.log(TALL[1] / TALL[0])


def steps_and_grids() -> Iterator[Comparison]:
    """Half the step and half the cell change the run-out of a fine grid by less than 5 %."""
    fine, finest = (collapse(column(PLANE, 1.0, n * CELLS), 1.0).run_out for n in (2, 4))
    halved = {"analysis.inertia.largest_motion": 0.0625, "schedule.step_size": 0.0025}
    small = collapse(varied(column(PLANE, 1.0, 2 * CELLS), halved), 1.0).run_out
    name = "run-out, plane, a 1, 40 cells"
    yield relative(f"{name}, half the step", small, fine, 0.05, "step of the case file")
    yield relative(f"{name}, against 80", fine, finest, 0.05, "half the cell")


def plane_fit(ratio: float) -> float:
    """Returns (d - d0) / d0 of plane columns by Lube et al. (2005); not from 1.8 to 2.8."""
    return 1.2 * ratio if ratio < 1.8 else 1.9 * ratio ** (2.0 / 3.0)


def round_fit(ratio: float) -> float:
    """Returns the same of round ones by Lube et al. (2004)."""
    return 1.24 * ratio if ratio < 1.7 else 1.6 * ratio**0.5


def rests(found: Deposit, name: str) -> Iterator[Comparison]:
    """No point is deeper in the base than its domain reaches, and nothing moves at the end."""
    yield vanishing(
        f"depth of the lowest point in the base, {name}", found.depth, 0.25, "none", "h"
    )
    quantity = f"kinetic energy at the end over the potential energy, {name}"
    yield vanishing(quantity, found.motion, 1e-3, "at rest")


def column(file: str, ratio: float, cells: int = CELLS) -> Model:
    """Returns a column of the width 1 m with this ratio of height and width.

    The cells are those across the width, or across the height if that is less.
    """
    changes = {
        "bodies.0.shape.upper": [1.0, ratio],
        "grid.cell_size": min(1.0, ratio) / cells,
        "schedule.end": round(DURATION * math.sqrt(ratio / GRAVITY), 2),
    }
    return varied(example(PROBLEM, file), changes)


def collapse(model: Model, width: float) -> Deposit:
    """Lets a column of this width [m] collapse."""
    points = march(model).state.points
    start = potential_energy(points, initial_position(points))
    lowest = max(0.0, -float(points.position[:, 1].min()))
    kinetic = 0.5 * float(points.mass @ (points.motion[:, 0] ** 2).sum(axis=1))
    return Deposit(
        run_out=front(points.position[:, 0], points.initial_volume) / width - 1.0,
        depth=lowest / float(model.cell_size[1]),
        motion=kinetic / start,
    )


def front(position: Floats, volume: Floats) -> float:
    """Returns the coordinate within which `SHARE` of the volume lies; both of shape (n,)."""
    order = np.argsort(position)
    within = np.cumsum(volume[order])
    return float(position[order][np.searchsorted(within, SHARE * within[-1])])


def potential_energy(points: MaterialPoints, position: Floats) -> float:
    """Returns the potential energy of the weight above the base [J], at positions (n, 2)."""
    return GRAVITY * float(points.mass @ position[:, 1])
