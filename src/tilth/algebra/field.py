# SPDX-License-Identifier: BSD-3-Clause
"""Unknown functions at nodes."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from tilth.algebra.nodes import Nodes
from tilth.arrays import Flags, Floats, Integers

DISPLACEMENT = "u"
"""Name of the field that each step has: the displacement of the soil in it."""

MOMENTUM = "momentum"
"""Equation of the displacement and of members; its residual is a force."""


@dataclass(frozen=True, eq=False)
class Field:
    """An unknown function at nodes.

    Attributes:
        name: under which unknowns, residuals and conditions are found; "u" is the displacement.
        nodes: where it has values.
        components: number of unknowns of a node.
        equation: of which balance its residual is a part, such as "momentum"; residuals of one
            equation have one unit, and one norm.
        scale: of each component: unknown times scale is comparable with the other unknowns of the
            equation, residual over scale with their residuals; shape (components,). Ones if None.
        active: which nodes have it, shape (nodes,); all if None. Elsewhere it keeps its start.
        start: its value at the start of the step, shape (nodes, components); 0 if None.
        prescribed: what conditions prescribe of it in the step; nothing if None.
    """

    name: str
    nodes: Nodes
    components: int
    equation: str
    scale: Floats | None = field(default=None, repr=False)
    active: Flags | None = field(default=None, repr=False)
    start: Floats | None = field(default=None, repr=False)
    prescribed: Prescribed | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Checks the shapes; raises `ValueError`."""
        arrays = {"start": (self.start, self.shape), "active": (self.active, self.shape[:1])}
        arrays["scale"] = self.scale, self.shape[1:]
        if self.prescribed is not None:
            arrays["prescribed.constrained"] = self.prescribed.constrained, self.shape
            arrays["prescribed.increment"] = self.prescribed.increment, self.shape
        for name, (array, shape) in arrays.items():
            if array is not None and array.shape != shape:
                what = f"the field {self.name!r}: {name} has the shape {array.shape}"
                raise ValueError(f"{what} instead of {shape}")

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of its values."""
        return self.nodes.count, self.components

    def zero(self) -> Floats:
        """Returns zeros of its shape."""
        return np.zeros(self.shape)

    def first(self) -> Floats:
        """Returns its value at the start of the step, a new array."""
        return self.zero() if self.start is None else self.start.copy()

    @property
    def owned(self) -> slice | Integers:
        """The nodes that this process owns."""
        return self.nodes.owned

    def over_scale(self, residual: Floats) -> Floats:
        """Returns a residual over the scale of its components, (nodes, components)."""
        return residual if self.scale is None else residual / self.scale

    @cached_property
    def constrained(self) -> Flags:
        """Which unknowns are none: prescribed, or where the field is not active, as `shape`."""
        held = np.zeros(self.shape, dtype=bool)
        if self.prescribed is not None:
            held = held | self.prescribed.constrained
        return held if self.active is None else held | ~self.active[:, None]

    @cached_property
    def increment(self) -> Floats:
        """Prescribed change of the unknowns in the step, 0 where none is, as `shape`."""
        return self.zero() if self.prescribed is None else self.prescribed.increment


class Prescribed(Protocol):
    """What is prescribed of a field in a step."""

    @property
    def constrained(self) -> Flags:
        """Which unknowns, shape (nodes, components)."""
        ...

    @property
    def increment(self) -> Floats:
        """Their change in the step, shape (nodes, components); 0 elsewhere."""
        ...


@dataclass(frozen=True, eq=False)
class GivenChange:
    """Prescribed change of a field, see `Prescribed`."""

    constrained: Flags
    increment: Floats
