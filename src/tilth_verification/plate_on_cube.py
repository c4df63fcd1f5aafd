# SPDX-License-Identifier: BSD-3-Clause
"""A rigid plate presses a cube of rubber to three quarters of its height."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tilth_verification.cases import example
from tilth_verification.comparison import Comparison, relative, vanishing
from tilth_verification.contact_runs import run_contact, spread

PROBLEM = "plate_on_cube"
YOUNG_MODULUS = 1e6
"""[Pa]."""
SIDE, PRESSED = 0.8, 0.2
"""Of the cube, and its change of height [m]."""
SOURCE = "E ln(l) / l"


def stress() -> float:
    """Returns the Cauchy stress of the cube [Pa], -383.6 kPa.

    With nu = 0 the stretch l = 0.6 / 0.8 leaves the sides as they are, so that J = l, and the
    Kirchhoff stress of Hencky's law is E ln(l): the Cauchy stress is E ln(l) / l, on an area that
    has not changed.
    """
    stretch = (SIDE - PRESSED) / SIDE
    return YOUNG_MODULUS * math.log(stretch) / stretch


def comparisons(long: bool) -> Iterator[Comparison]:
    """The plate's force, and how even its pressure is."""
    del long
    run = run_contact(example(PROBLEM))
    mean = run.force["plate"][-1, 2] / SIDE**2 / 1e3
    yield relative("stress under the plate", float(mean), stress() / 1e3, 0.005, SOURCE, "kPa")
    state = run.contacts["plate"]
    touching = state.in_contact
    value = spread(state.normal_stress[touching], state.weight[touching])
    yield vanishing("spread of the pressure under the plate", value, 0.01, "uniform stress")
