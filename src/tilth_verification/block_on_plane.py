# SPDX-License-Identifier: BSD-3-Clause
"""A block on a floor with friction: the force that moves it, and the slope on which it slides."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.model import Model
from tilth_verification import sliding
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, relative, vanishing
from tilth_verification.contact_runs import ContactRun, run_contact

PROBLEM = "block_on_plane"
FRICTION = 0.3
WEIGHT = 10e3
"""Of the block [N/m]: 1 x 0.5 m, 2000 kg/m^3, 10 m/s^2."""
LIMIT = 1000.0
"""Adhesion [Pa], less than friction times the pressure anywhere, of 10 kPa on average."""
ALONG = 1.1
"""Gravity along the incline at the end over that at which the block slides."""
SETTLED = 0.2
"""Time at which the whole weight acts."""
BALANCE = "equilibrium"


def comparisons(long: bool) -> Iterator[Comparison]:
    """The push at which the block slides under three laws; the incline; balance; inertia."""
    del long
    model = example(PROBLEM)
    pushed = run_contact(model)
    yield relative(
        "push, friction", float(pushed.force["plate"][-1, 0]), FRICTION * WEIGHT, 1e-3, "mu N", "N"
    )
    yield from balanced(pushed, "pushed")
    for law, quantity in (
        ({"tangential": "adhesion", "shear_limit": LIMIT}, "adhesion"),
        (
            {"tangential": "friction", "friction": FRICTION, "shear_limit": LIMIT},
            "min(mu p, limit)",
        ),
    ):
        run = run_contact(with_law(model, law))
        push = float(run.force["plate"][-1, 0])
        held = LIMIT * run.contacts["floor"].area
        yield relative(f"push, {quantity}", push, held, 1e-3, "limit times area in contact", "N")
    incline = run_contact(example(PROBLEM, "incline.toml"), may_fail=True)
    share = ALONG * (incline.time[-1] - SETTLED) / (1.0 - SETTLED)
    quantity = "tan(theta) / mu of the last equilibrium on the incline"
    yield relative(quantity, float(share), 1.0, 1e-3, "slides at tan(theta) = mu")
    yield from sliding.comparisons(PROBLEM)


def balanced(run: ContactRun, label: str) -> Iterator[Comparison]:
    """Rows: the sums of horizontal and of vertical forces on the block, over its weight."""
    full = run.time >= SETTLED * (1.0 - 1e-9)
    across = np.abs(run.force["floor"][full, 0] + run.force["plate"][full, 0]).max() / WEIGHT
    along = np.abs(run.force["floor"][full, 1] + run.force["plate"][full, 1] - WEIGHT).max()
    yield vanishing(f"sum of horizontal forces over the weight, {label}", across, 1e-8, BALANCE)
    quantity = f"sum of vertical forces over the weight, {label}"
    yield vanishing(quantity, along / WEIGHT, 1e-8, BALANCE)


def with_law(model: Model, law: dict[str, object]) -> Model:
    """Returns the model with another law along the floor."""
    return varied(model, {"boundaries.0.contact": {"normal": "unilateral", **law}})
