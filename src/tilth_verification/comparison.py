# SPDX-License-Identifier: BSD-3-Clause
"""`Comparison`: a computed number, its reference, their error and its tolerance."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Comparison:
    """A computed number with its reference and tolerance.

    Attributes:
        quantity: name of the computed quantity, with its grid.
        unit: of `computed` and `reference`; "" if they have none.
        computed, reference: the two numbers.
        error: difference of the two numbers, >= 0, defined by the functions below.
        tolerance: the largest error that passes.
        source: source of the reference.
    """

    quantity: str
    unit: str
    computed: float
    reference: float
    error: float
    tolerance: float
    source: str

    @property
    def passed(self) -> bool:
        """Whether the error is within its tolerance; NaN never is."""
        return bool(self.error <= self.tolerance)


def relative(
    quantity: str, computed: float, reference: float, tolerance: float, source: str, unit: str = ""
) -> Comparison:
    """Returns a comparison by the error |computed - reference| / |reference|."""
    error = abs(computed - reference) / abs(reference)
    return Comparison(quantity, unit, computed, reference, error, tolerance, source)


def absolute(
    quantity: str, computed: float, reference: float, tolerance: float, source: str, unit: str = ""
) -> Comparison:
    """Returns a comparison by |computed - reference|, in the unit of the quantity."""
    error = abs(computed - reference)
    return Comparison(quantity, unit, computed, reference, error, tolerance, source)


def vanishing(
    quantity: str, computed: float, tolerance: float, source: str, unit: str = ""
) -> Comparison:
    """Returns a comparison with zero; the error is the magnitude, in the unit of the quantity."""
    return absolute(quantity, computed, 0.0, tolerance, source, unit)


def within_factor(
    quantity: str, computed: float, reference: float, factor: float, source: str, unit: str = ""
) -> Comparison:
    """Returns a comparison of positive numbers by the larger over the smaller, less 1."""
    error = max(computed / reference, reference / computed) - 1.0
    return Comparison(quantity, unit, computed, reference, error, factor - 1.0, source)


def at_least(
    quantity: str, computed: float, reference: float, tolerance: float, source: str, unit: str = ""
) -> Comparison:
    """Returns a comparison by max(0, reference - computed)."""
    error = max(0.0, reference - computed) if computed == computed else computed
    return Comparison(quantity, unit, computed, reference, error, tolerance, source)


def at_most(
    quantity: str, computed: float, reference: float, tolerance: float, source: str, unit: str = ""
) -> Comparison:
    """Returns a comparison by max(0, computed - reference)."""
    error = max(0.0, computed - reference) if computed == computed else computed
    return Comparison(quantity, unit, computed, reference, error, tolerance, source)
