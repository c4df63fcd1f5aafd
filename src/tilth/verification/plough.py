# SPDX-License-Identifier: BSD-3-Clause
"""A blade drawn through clay in 3D: a steady force, and no soil lost."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from tilth.verification.cases import example
from tilth.verification.comparison import Comparison, vanishing
from tilth.verification.contact_runs import run_contact

PROBLEM = "plough"
WIDTH = 1.0
"""Of the blade [m]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Long only: the force over the last width, the soil's volume, and the time that it takes."""
    if not long:
        return
    start = time.perf_counter()
    model = example(PROBLEM)
    run = run_contact(model)
    hours = (time.perf_counter() - start) / 3600.0
    curve = run.curve("blade", 0, 2.0)
    last = curve.after(curve.displacement[-1] - WIDTH).force
    steady = (last.max() - last.min()) / last.mean()
    yield vanishing("spread of the force over the last width", float(steady), 0.03, "steady")
    points = run.end.points
    missing = 1.0 - points.volume.sum() / points.initial_volume.sum()
    yield vanishing("change of the soil's volume, relative", float(missing), 0.01, "nu 0.49")
    inside = np.abs(points.position[:, 1]) < 0.5 * WIDTH
    blade = run.displacement[-1, 0] + np.array([-0.3, 0.0])
    within = (points.position[:, 0] > blade[0]) & (points.position[:, 0] < blade[1])
    above = points.position[:, 2] > 1.5
    depth = np.minimum(points.position[:, 0] - blade[0], blade[1] - points.position[:, 0])
    deepest = float(np.max(depth[inside & within & above], initial=0.0)) / model.cell_size[0]
    yield vanishing("deepest point in the blade, in cells", deepest, 0.1, "none")
    yield vanishing("time on this machine", hours, 2.0, "two hours", "h")
