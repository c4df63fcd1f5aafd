# SPDX-License-Identifier: BSD-3-Clause
"""A strip anchor deep in clay: its limit load with suction, and under an overburden without it."""

from __future__ import annotations

from collections.abc import Iterator

from tilth.verification.cases import example
from tilth.verification.closed_forms.limit_loads import DEEP_STRIP_ANCHOR
from tilth.verification.comparison import Comparison, relative
from tilth.verification.contact_runs import run_contact

PROBLEM = "plate_anchor"
WIDTH, STRENGTH = 1.0, 10e3
"""Of the plate [m]; s_u [Pa]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Greatest force with suction; long: without it, closed by the overburden."""
    files = {"suction": "case.toml", "free to separate": "overburden.toml"}
    for name, file in files.items():
        if name == "suction" or long:
            curve = run_contact(example(PROBLEM, file)).curve("plate", 1, 2.0 / (WIDTH * STRENGTH))
            quantity = f"greatest F / (B s_u), {name}, h B/20"
            yield relative(quantity, curve.force.max(), DEEP_STRIP_ANCHOR, 0.05, "3 pi + 2")
