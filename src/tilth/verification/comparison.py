# SPDX-License-Identifier: BSD-3-Clause
"""`Comparison`: a computed number beside its reference, and how far apart they may be."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Comparison:
    """A computed number beside its reference.

    Attributes:
        quantity: what was computed, and on which grid.
        unit: of `computed` and `reference`; "" if they have none.
        computed, reference: the two numbers.
        error: how far apart they are, by the way of comparing that made it: see the functions
            below. Never negative.
        tolerance: the largest error that passes.
        source: where the reference comes from.
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
        """Whether the error is within its tolerance; not a number never is."""
        return bool(self.error <= self.tolerance)


def relative(
    quantity: str, computed: float, reference: float, tolerance: float, source: str, unit: str = ""
) -> Comparison:
    """Compares by |computed - reference| / |reference|."""
    error = abs(computed - reference) / abs(reference)
    return Comparison(quantity, unit, computed, reference, error, tolerance, source)


def absolute(
    quantity: str, computed: float, reference: float, tolerance: float, source: str, unit: str = ""
) -> Comparison:
    """Compares by |computed - reference|; error and tolerance have the unit of the quantity."""
    error = abs(computed - reference)
    return Comparison(quantity, unit, computed, reference, error, tolerance, source)


def vanishing(
    quantity: str, computed: float, tolerance: float, source: str, unit: str = ""
) -> Comparison:
    """Compares a number that should be zero, such as a distance: the error is its magnitude."""
    return absolute(quantity, computed, 0.0, tolerance, source, unit)


def within_factor(
    quantity: str, computed: float, reference: float, factor: float, source: str, unit: str = ""
) -> Comparison:
    """Compares positive numbers by the larger over the smaller, less 1."""
    error = max(computed / reference, reference / computed) - 1.0
    return Comparison(quantity, unit, computed, reference, error, factor - 1.0, source)


def at_least(
    quantity: str, computed: float, reference: float, tolerance: float, source: str, unit: str = ""
) -> Comparison:
    """Compares by what `computed` falls short of the reference; more than it is no error."""
    error = max(0.0, reference - computed) if computed == computed else computed
    return Comparison(quantity, unit, computed, reference, error, tolerance, source)
