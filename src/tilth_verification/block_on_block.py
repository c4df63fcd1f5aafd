# SPDX-License-Identifier: BSD-3-Clause
"""A block on deformable ground with friction: the force that moves it, and the slope on which it
slides.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth_verification.block_on_plane import ALONG, FRICTION, SETTLED, WEIGHT
from tilth_verification.cases import example
from tilth_verification.comparison import Comparison, relative, vanishing
from tilth_verification.contact_runs import ContactRun, run_contact

PROBLEM = "block_on_block"
PAIR = "block on ground"


def comparisons(long: bool) -> Iterator[Comparison]:
    """The push at which the block slides; the incline; balance of forces."""
    del long
    pushed = run_contact(example(PROBLEM))
    push = float(pushed.force["plate"][-1, 0])
    yield relative("push", push, FRICTION * WEIGHT, 1e-3, "mu N", "N")
    yield from balanced(pushed)
    incline = run_contact(example(PROBLEM, "incline.toml"), may_fail=True)
    share = ALONG * (incline.time[-1] - SETTLED) / (1.0 - SETTLED)
    quantity = "tan(theta) / mu of the last equilibrium on the incline"
    yield relative(quantity, float(share), 1.0, 1e-3, "slides at tan(theta) = mu")


def balanced(run: ContactRun) -> Iterator[Comparison]:
    """Rows: the forces on the block between its plate, the ground and its weight, over the weight.

    The pair's force is that on the ground.
    """
    full = run.time >= SETTLED * (1.0 - 1e-9)
    on_ground, of_plate = run.force[PAIR][full], run.force["plate"][full]
    across = np.abs(of_plate[:, 0] - on_ground[:, 0]).max() / WEIGHT
    along = np.abs(of_plate[:, 1] - on_ground[:, 1] - WEIGHT).max() / WEIGHT
    balance = "equilibrium"
    yield vanishing("sum of horizontal forces over the weight", float(across), 1e-8, balance)
    yield vanishing("sum of vertical forces over the weight", float(along), 1e-8, balance)
