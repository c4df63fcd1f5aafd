# SPDX-License-Identifier: BSD-3-Clause
"""Numbers, vectors and what varies from place to place, in words."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from tilth.model.shape_base import DeclaredShape
from tilth.model.variation import (
    AlongAxis,
    ByDepth,
    ByStress,
    GridFile,
    Level,
    OfPosition,
    Random,
    Variation,
)


def amount(value: float | Variation) -> str:
    """Returns a parameter's value, or what it depends on and its declared range."""
    if isinstance(value, ByDepth | AlongAxis):
        table = value.depth if isinstance(value, ByDepth) else value.values
        along = "depth" if isinstance(value, ByDepth) else value.axis
        values = [number for _, number in table]
        return f"by {along} {min(values):g} to {max(values):g}"
    if isinstance(value, GridFile):
        return f"by {Path(value.file).name}"
    if isinstance(value, OfPosition):
        file, _, function = value.function.rpartition(":")
        return f"by {function} in {Path(file).name}"
    if isinstance(value, Random):
        field = value.random
        return (
            f"random, {field.distribution}, coefficient of variation "
            f"{field.coefficient_of_variation:g}, mean {field.mean:g}"
        )
    if isinstance(value, ByStress):
        return f"by the initial stress, at {value.reference_pressure:g} {value.reference:g}"
    return f"{value:g}"


def elevation(level: Level, unit: str) -> str:
    """Returns a declared elevation; ``unit``: label of lengths."""
    if isinstance(level, GridFile):
        return f"that of {Path(level.file).name}"
    if isinstance(level, tuple):
        heights = [height for _, height in level]
        return f"a polyline between {min(heights):g} and {max(heights):g} {unit}".rstrip()
    return f"{level:g} {unit}".rstrip()


def shape_text(shape: DeclaredShape) -> str:
    """Returns the type of a shape, and how many holes it has."""
    holes = len(shape.cavities())
    return shape.type + (f" with {holes} hole{'s' if holes > 1 else ''}" if holes else "")


def vector(components: Iterable[float]) -> str:
    """Returns the components in brackets."""
    return "[" + ", ".join(f"{c:g}" for c in components) + "]"


def cells_text(sizes: Iterable[tuple[float, float]], unit: str) -> str:
    """Returns the sizes of cells along each axis, from the smallest to the largest [length]."""
    texts = [
        f"{low:g}" if f"{low:g}" == f"{high:g}" else f"{low:.3g} to {high:.3g}"
        for low, high in sizes
    ]
    return f"cells of {' x '.join(texts)} {unit}".rstrip()
