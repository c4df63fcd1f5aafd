# SPDX-License-Identifier: BSD-3-Clause
"""A strip anchor deep in clay: its limit load with suction, and under an overburden without it."""

from __future__ import annotations

from collections.abc import Iterator

from tilth_verification.cases import example
from tilth_verification.closed_forms.limit_loads import DEEP_STRIP_ANCHOR, strip_anchor_bound
from tilth_verification.comparison import Comparison, relative
from tilth_verification.contact_runs import run_contact

PROBLEM = "plate_anchor"
WIDTH, THICKNESS, STRENGTH = 1.0, 0.1, 10e3
"""Of the plate [m]; s_u [Pa]."""
FILES = {"suction": "case.toml", "free to separate": "overburden.toml"}


def comparisons(long: bool) -> Iterator[Comparison]:
    """Greatest force with suction; long: without it, closed by the overburden."""
    for name in FILES if long else ("suction",):
        yield from limit_load(name)


def limit_load(name: str) -> Iterator[Comparison]:
    """Rows: the greatest force against that of a thin plate, and a bound for this thickness."""
    curve = run_contact(example(PROBLEM, FILES[name])).curve("plate", 1, 2.0 / (WIDTH * STRENGTH))
    factor = float(curve.force.max())
    quantity = f"greatest F / (B s_u), {name}, h B/20"
    yield relative(quantity, factor, DEEP_STRIP_ANCHOR, 0.05, "3 pi + 2, thin plate")
    ratio = THICKNESS / WIDTH
    source = f"upper bound of a plate {ratio:g} B thick"
    yield relative(f"the same, {name}", factor, strip_anchor_bound(ratio), 0.02, source)
