# SPDX-License-Identifier: BSD-3-Clause
"""Columns of dry sand and of aluminium bars that collapse: how far they run out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.model import Model
from tilth.mpm.points import MaterialPoints
from tilth.verification.cases import example, varied
from tilth.verification.comparison import Comparison, absolute, relative, vanishing
from tilth.verification.march import initial_position, march

PROBLEM = "column_collapse"
PLANE, ROUND, BARS = "case.toml", "axisymmetric.toml", "bars.toml"
LUBE = "fit of Lube et al."
SHARE = 0.99
"""Share of the mass within the run-out [-]; a few points may lie ahead of the front."""
GRAVITY = 9.81
"""[m/s^2]"""
DURATION = 5.0
"""Of the analyses, over the time sqrt(H / g) [-]."""
STEPS = 80
"""Of the schedules in this time; they are shortened where the sand moves fast."""
TALL = (3.0, 4.0, 5.0)
"""Ratios of height and width above the change of the fits at 2.8 [-]."""


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
    """A low plane column; long: low and tall, plane and round ones, two grids and steps, bars."""
    yield from low(PLANE, (0.5, 1.0, 1.5) if long else (0.5,), "plane", 1.2)
    if not long:
        return
    yield from low(ROUND, (0.5, 1.0, 1.5), "round", 1.24)
    yield from tall(PLANE, "plane", 2.0 / 3.0)
    yield from tall(ROUND, "round", 0.5)
    yield from resolved(column(PLANE, 1.0), "a 1", 1.0)
    yield from resolved(example(PROBLEM, BARS), "bars", 0.2)


def low(file: str, ratios: tuple[float, ...], shape: str, slope: float) -> Iterator[Comparison]:
    """Run-out of low columns, in proportion to the ratio; no sand is in the base, and all rests."""
    for ratio in ratios:
        found = collapse(column(file, ratio), 1.0)
        quantity = f"run-out, {shape}, a {ratio:g}"
        yield relative(quantity, found.run_out, slope * ratio, 0.25, LUBE)
        yield from rests(found, f"{shape}, a {ratio:g}")


def tall(file: str, shape: str, exponent: float) -> Iterator[Comparison]:
    """How the run-out of tall columns grows with the ratio."""
    found = [collapse(column(file, ratio), 1.0).run_out for ratio in TALL]
    slope = float(np.polyfit(np.log(TALL), np.log(found), 1)[0])
    quantity = f"exponent of the run-out, {shape}, a {TALL[0]:g} to {TALL[-1]:g}"
    yield absolute(quantity, slope, exponent, 0.15, LUBE)


def resolved(model: Model, name: str, width: float) -> Iterator[Comparison]:
    """Run-out with half the cells' size, and with half the steps' size and motion."""
    here = collapse(model, width)
    yield from rests(here, name)
    halved = {
        "half the cell": {"grid.cell_size": 0.5 * float(model.cell_size[0])},
        "half the step": {
            "schedule.step_size": 0.5 * (model.schedule.step_size or 0.0),
            "analysis.inertia.largest_motion": 0.25,
        },
    }
    for change, entries in halved.items():
        found = collapse(varied(model, entries), width)
        quantity = f"run-out, {name}, {change}"
        yield relative(quantity, found.run_out, here.run_out, 0.05, "that of the case file")


def rests(found: Deposit, name: str) -> Iterator[Comparison]:
    """No point is deeper in the base than its domain reaches, and nothing moves at the end."""
    yield vanishing(
        f"depth of the lowest point in the base, {name}", found.depth, 0.25, "none", "h"
    )
    quantity = f"kinetic energy at the end over the potential energy, {name}"
    yield vanishing(quantity, found.motion, 1e-3, "at rest")


def column(file: str, ratio: float) -> Model:
    """Returns a column of the width 1 m with this ratio of height and width."""
    duration = DURATION * math.sqrt(ratio / GRAVITY)
    changes = {
        "bodies.0.shape.upper": [1.0, ratio],
        "schedule.end": duration,
        "schedule.step_size": duration / STEPS,
    }
    return varied(example(PROBLEM, file), changes)


def collapse(model: Model, width: float) -> Deposit:
    """Lets a column of this width [m] collapse."""
    points = march(model).points
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
