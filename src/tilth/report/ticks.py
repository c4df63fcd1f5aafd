# SPDX-License-Identifier: BSD-3-Clause
"""Places and labels of the ticks of an axis."""

from __future__ import annotations

import math

import numpy as np

from tilth.arrays import Floats

STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Steps between ticks are these times a power of ten."""
POWERS = (-3, 5)
"""Powers of ten up to which, and from which, labels have it as a common factor."""
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def linear_ticks(low: float, high: float, most: int, whole: bool = False) -> Floats:
    """Returns round numbers in [low, high], at most so many intervals; whole ones if asked."""
    rough = (high - low) / most
    if not rough > 0.0 or not math.isfinite(rough):
        return np.array([low])
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * each for each in STEPS if power * each >= rough * (1.0 - 1e-9))
    if whole:
        step = max(1.0, float(math.ceil(step - 1e-9)))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return np.asarray(step * np.arange(first, last + 1))


def linear_labels(ticks: Floats) -> tuple[list[str], str]:
    """Returns the labels of equidistant ticks, and their common factor ("" without one)."""
    largest = float(np.abs(ticks).max(initial=0.0))
    power = math.floor(math.log10(largest) + 1e-9) if largest > 0.0 else 0
    factor = POWERS[0] < power < POWERS[1]
    scale = 1.0 if factor else 10.0**power
    step = float(ticks[1] - ticks[0]) / scale if len(ticks) > 1 else largest / scale or 1.0
    digits = next((n for n in range(16) if abs(round(step, n) - step) <= 1e-6 * step), 16)
    texts = [f"{tick / scale:.{digits}f}".replace("-", "\N{MINUS SIGN}") for tick in ticks]
    zero = f"\N{MINUS SIGN}{0:.{digits}f}"
    return [t.lstrip("\N{MINUS SIGN}") if t == zero else t for t in texts], (
        "" if factor else f"× {power_of_ten(power)}"
    )


def decades(low: float, high: float, most: int) -> tuple[Floats, list[str]]:
    """Returns powers of ten in [low, high] and their labels, at most so many and one more."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    every = max(1, math.ceil((last - first) / most))
    powers = [p for p in range(first, last + 1) if p % every == 0]
    return 10.0 ** np.array(powers, dtype=float), [power_of_ten(p) for p in powers]


def power_of_ten(power: int) -> str:
    """Returns 10 with a superscript."""
    return f"10{str(power).translate(_SUPERSCRIPTS)}"
