# SPDX-License-Identifier: BSD-3-Clause
"""What the picture of a set-up shows, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..output.snapshot import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Condition:
    """An essential condition on k nodes; ``dim`` is 2 or 3."""

    name: str
    kind: str
    """roller, fixed, prescribed or affine"""
    position: FloatArray
    """Places of the nodes [length], shape (k, dim)."""
    constrained: NDArray[np.bool_]
    """Which components are prescribed, shape (k, dim)."""
    displacement: FloatArray | None = None
    """Prescribed displacement at the end [length], shape (k, dim); None for zero."""


@dataclass(frozen=True, eq=False)
class Load:
    """Forces on k places, shapes (k, dim)."""

    name: str
    position: FloatArray
    force: FloatArray


@dataclass(frozen=True, eq=False)
class Setup:
    """Everything :func:`draw_setup` shows; n points, ``dim`` 2 or 3."""

    title: str
    dim: int
    length_unit: str
    position: FloatArray
    """Points [length], shape (n, dim)."""
    half_lengths: FloatArray | None
    """Half lengths of the points' domains [length], shape (n, dim), or None."""
    body_id: IntArray
    """Body of each point, shape (n,)."""
    body_names: Sequence[str]
    cell_size: FloatArray
    """Shape (dim,)."""
    origin: FloatArray
    """A node of the grid, shape (dim,)."""
    conditions: Sequence[Condition] = field(default_factory=tuple)
    loads: Sequence[Load] = field(default_factory=tuple)
    body_force: FloatArray | None = None
    """Acceleration at factor 1, shape (dim,), or None."""
    force_unit: str = ""
    kind: str = ""
    """Kind of analysis: plane_strain, axisymmetric or 3d; names the axes."""

    @property
    def axis_names(self) -> tuple[str, str, str]:
        """Names of the axes; r instead of x in axisymmetry."""
        return ("r" if self.kind == "axisymmetric" else "x", "y", "z")

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Corners of what must be seen: soil, conditions and about one cell around them."""
        places = [self.position]
        if self.half_lengths is not None:
            places += [self.position - self.half_lengths, self.position + self.half_lengths]
        places += [condition.position for condition in self.conditions if len(condition.position)]
        places += [load.position for load in self.loads if len(load.position)]
        everything = np.concatenate(places)
        lower, upper = everything.min(axis=0), everything.max(axis=0)
        size = upper - lower
        margin = np.maximum(0.75 * self.cell_size, 0.04 * float(size.max()))
        margin = np.minimum(margin, 0.35 * float(np.maximum(size, self.cell_size).min()))
        return lower - margin, upper + margin
