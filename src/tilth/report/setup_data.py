# SPDX-License-Identifier: BSD-3-Clause
"""What the picture of a set-up shows, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats, Integers
from tilth.output.snapshot import SurfaceShape
from tilth.report.surface_lines import clip_segments, clip_triangles, moved_corners

_NEAR = 0.08
"""How far around the soil surfaces are seen, as a part of its longest side."""


@dataclass(frozen=True, eq=False)
class Condition:
    """An essential condition on k nodes; ``dim`` is 2 or 3."""

    name: str
    kind: str
    """roller, fixed, prescribed or affine"""
    position: Floats
    """Places of the nodes [length], shape (k, dim)."""
    constrained: NDArray[np.bool_]
    """Which components are prescribed, shape (k, dim)."""
    displacement: Floats | None = None
    """Prescribed displacement at the end [length], shape (k, dim); None for zero."""


@dataclass(frozen=True, eq=False)
class Load:
    """Forces on k places, shapes (k, dim)."""

    name: str
    position: Floats
    force: Floats


@dataclass(frozen=True, eq=False)
class Surface:
    """An implicit boundary of n facets at the start; ``dim`` is 2 or 3."""

    name: str
    kind: str
    """roller, fixed, tangential or direction"""
    corner: Floats
    """Segments in 2D, triangles in 3D [length], shape (n, dim, dim): facet, corner, coordinate."""
    normal: Floats
    """Unit normals into the soil, shape (n, dim)."""
    displacement: Floats | None = None
    """Displacement of the facets' centres at the end [length], (n, dim); None for zero."""
    bounded: bool = False
    """Of finite size, so that it is seen whole where it is not larger than the soil."""

    def places(self, lower: Floats, upper: Floats) -> Floats:
        """Corners of what lies between two corners of the space at start and end; (k, dim)."""
        corners = [self.corner]
        if self.displacement is not None:
            corners.append(moved_corners(self.corner, self.displacement))
        dim = len(lower)
        parts = [np.empty((0, dim))]
        for corner in corners:
            if dim == 2:
                parts.append(clip_segments(corner, lower, upper)[0].reshape(-1, 2))
            else:
                parts += clip_triangles(corner, lower, upper)[0]
        return np.concatenate(parts)


@dataclass(frozen=True, eq=False)
class Setup:
    """Everything :func:`draw_setup` shows; n points, ``dim`` 2 or 3."""

    title: str
    dim: int
    length_unit: str
    position: Floats
    """Points [length], shape (n, dim)."""
    half_lengths: Floats | None
    """Half lengths of the points' domains [length], shape (n, dim), or None."""
    body_id: Integers
    """Body of each point, shape (n,)."""
    body_names: Sequence[str]
    cell_size: Floats
    """Shape (dim,)."""
    origin: Floats
    """A node of the grid, shape (dim,)."""
    conditions: Sequence[Condition] = field(default_factory=tuple)
    loads: Sequence[Load] = field(default_factory=tuple)
    surfaces: Sequence[Surface] = ()
    tracked: Sequence[SurfaceShape] = ()
    """Surfaces of bodies that are tracked."""
    body_force: Floats | None = None
    """Acceleration at factor 1, shape (dim,), or None."""
    force_unit: str = ""
    kind: str = ""
    """Kind of analysis: plane_strain, axisymmetric or 3d; names the axes."""
    corners: Floats | None = None
    """Corners of the domains [length], seen from the points, x fastest, shape (n, 2**dim, dim);
    None where domains are boxes with the half lengths."""
    warnings: Sequence[str] = ()
    """What is probably not meant."""

    @property
    def axis_names(self) -> tuple[str, str, str]:
        """Names of the axes; r instead of x in axisymmetry."""
        return ("r" if self.kind == "axisymmetric" else "x", "y", "z")

    def bounds(self) -> tuple[Floats, Floats]:
        """Corners of what must be seen: soil, conditions and about one cell around them.

        Of surfaces, which may reach far away, what is near everything else is seen.
        """
        places = [self.position]
        if self.half_lengths is not None:
            places += [self.position - self.half_lengths, self.position + self.half_lengths]
        places += [condition.position for condition in self.conditions if len(condition.position)]
        places += [load.position for load in self.loads if len(load.position)]
        places += [shape.position for shape in self.tracked if len(shape.position)]
        everything = np.concatenate(places)
        lower, upper = everything.min(axis=0), everything.max(axis=0)
        longest = float((upper - lower).max())
        near = np.maximum(0.5 * self.cell_size, _NEAR * longest)
        around: list[Floats] = []
        for surface in self.surfaces:
            seen = surface.places(lower - longest, upper + longest)
            small = len(seen) > 0 and float(np.ptp(seen, axis=0).max()) <= longest
            if not (surface.bounded and small):
                seen = surface.places(lower - near, upper + near)
            around.append(seen)
        everything = np.concatenate([everything, *around])
        lower, upper = everything.min(axis=0), everything.max(axis=0)
        size = upper - lower
        margin = np.maximum(0.75 * self.cell_size, 0.04 * float(size.max()))
        margin = np.minimum(margin, 0.35 * float(np.maximum(size, self.cell_size).min()))
        return lower - margin, upper + margin
