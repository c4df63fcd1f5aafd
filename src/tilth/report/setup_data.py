# SPDX-License-Identifier: BSD-3-Clause
"""Contents of the figure of a set-up, as plain data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tilth import grid_lines
from tilth.arrays import Flags, Floats, Integers, distinct_rows
from tilth.output.snapshot import SurfaceShape
from tilth.report.surface_lines import clip_segments, clip_triangles, moved_corners
from tilth.report.water_line import nearby

_MARGIN_RATIO = 0.08
"""Width of the region around the soil where surfaces are shown, over its longest side."""

FLOW_KINDS = {
    "drained": "drained",
    "pressure": "excess pore pressure given",
    "flux": "flux of water given",
}
"""Conditions of flow boundaries, and what they are in the legend."""


@dataclass(frozen=True, eq=False)
class Condition:
    """An essential condition on k nodes, or a flow boundary; ``dim`` is 2 or 3."""

    name: str
    kind: str
    """roller, fixed, prescribed or affine; of a flow boundary one of `FLOW_KINDS`"""
    position: Floats
    """Positions of the nodes, or of places on a flow boundary [length], shape (k, dim)."""
    constrained: NDArray[np.bool_]
    """Which components are prescribed, shape (k, dim)."""
    displacement: Floats | None = None
    """Prescribed displacement at the end [length], shape (k, dim); None for zero."""

    @property
    def is_of_flow(self) -> bool:
        """Whether it is a flow boundary."""
        return self.kind in FLOW_KINDS


@dataclass(frozen=True, eq=False)
class Load:
    """Forces [force] at k positions [length], shape (k, dim) each."""

    name: str
    position: Floats
    force: Floats


@dataclass(frozen=True, eq=False)
class Surface:
    """An implicit boundary or rigid body of n facets at the start; ``dim`` is 2 or 3."""

    name: str
    kind: str
    """roller, fixed, tangential, direction, contact or "rigid body"."""
    corner: Floats
    """Segments in 2D, triangles in 3D [length], shape (n, dim, dim): facet, corner, coordinate."""
    normal: Floats
    """Unit normals into the soil, shape (n, dim)."""
    displacement: Floats | None = None
    """Displacement of the facets' centres at the end [length], (n, dim); None for zero."""
    bounded: bool = False
    """Whether it is of finite size; then all of it is shown if it is not larger than the soil."""
    words: str = ""
    """Its motion and law of contact in words, for the legend."""

    def visible_vertices(self, lower: Floats, upper: Floats) -> Floats:
        """Returns vertices of the parts in a box at start and end [length], shape (k, dim)."""
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
class Soil:
    """Undeformed points, ``dim`` is 2 or 3."""

    position: Floats
    """[length], shape (n, dim)."""
    half_lengths: Floats
    """Half lengths of the points' domains [length], shape (n, dim)."""
    corners: Floats | None
    """Corners of the domains, as those of :class:`Setup`."""
    body_id: Integers
    """Body of each point, shape (n,)."""

    def selected(self, chosen: Flags) -> Soil:
        """Returns the points with a flag, shape (n,)."""
        corners = None if self.corners is None else self.corners[chosen]
        position, half_lengths = self.position[chosen], self.half_lengths[chosen]
        return Soil(position, half_lengths, corners, self.body_id[chosen])


@dataclass(frozen=True, eq=False)
class Setup:
    """Contents of the figure of :func:`draw_setup`; n points, ``dim`` 2 or 3."""

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
    """Sizes of the smallest cell along each axis, shape (dim,)."""
    origin: Floats
    """A node of the grid, shape (dim,)."""
    lines: Sequence[Sequence[float]] = ()
    """Of a graded grid the distances of each axis' lines from the origin (`tilth/grid_lines.py`),
    empty along a uniform axis."""
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
    """Corners of the domains relative to the points [length], x fastest, shape (n, 2**dim, dim);
    None if domains are boxes with the half lengths."""
    warnings: Sequence[str] = ()
    """Warnings about probable mistakes."""
    boundary_names: Sequence[str] = ()
    """Names of the boundaries and rigid bodies of all stages, whose colours are by their number."""
    is_new: Flags | None = None
    """Which points are new in this stage, shape (n,)."""
    removed: Soil | None = None
    """Soil that was removed at the start of this stage."""

    def graded(self) -> Iterator[tuple[int, Floats]]:
        """Yields the graded axes with the distances of their lines from the origin."""
        return ((k, np.array(line)) for k, line in enumerate(self.lines) if len(line) > 0)

    def in_cells(self, coordinate: Floats, axis: int) -> Floats:
        """Returns coordinates along an axis [length] in cells: line below plus a share."""
        distance = np.asarray(coordinate - self.origin[axis])
        if (line := dict(self.graded()).get(axis)) is None:
            return np.asarray(distance / self.cell_size[axis])
        return grid_lines.in_cells(distance, line)

    def coordinates(self, line: Floats, axis: int) -> Floats:
        """Returns the coordinates of grid lines along an axis by their numbers [length]."""
        if (lines := dict(self.graded()).get(axis)) is None:
            return np.asarray(self.origin[axis] + line * self.cell_size[axis])
        return np.asarray(self.origin[axis] + grid_lines.distance(line, lines))

    def occupied_cells(self) -> int:
        """Returns the number of cells with points."""
        cells = [np.floor(self.in_cells(x, k)) for k, x in enumerate(self.position.T)]
        return len(distinct_rows(np.column_stack(cells)))

    def colour_of(self, name: str, number: int) -> int:
        """Returns the number of the colour of the boundary or rigid body with a number."""
        return self.boundary_names.index(name) if name in self.boundary_names else number

    @property
    def shade(self) -> Integers:
        """Twice the number of each point's body, and one more if it is new, shape (n,)."""
        return 2 * self.body_id + (0 if self.is_new is None else self.is_new)

    water: Floats | None = None
    """Vertices of the water's surface in 2D at ``water_times``, from left to right at the same x
    [length], shape (2, k, 2); None without water, and in 3D."""
    water_times: Floats = field(default_factory=lambda: np.array([0.0, 1.0]))
    """Total times at the start and the end of the stage, shape (2,)."""

    def water_at(self, time: float) -> Floats | None:
        """Returns the vertices of the water's surface at a total time [length], shape (k, 2)."""
        if self.water is None:
            return None
        start, end = self.water_times
        share = min(max((time - start) / (end - start), 0.0), 1.0)
        return np.asarray((1.0 - share) * self.water[0] + share * self.water[1])

    @property
    def axis_names(self) -> tuple[str, str, str]:
        """Names of the axes; r instead of x in axisymmetry."""
        return ("r" if self.kind == "axisymmetric" else "x", "y", "z")

    def bounds(self) -> tuple[Floats, Floats]:
        """Returns the lower and upper corner of the figure, shape (dim,) each [length].

        It contains soil, conditions, loads and about one cell around them. Large surfaces are
        shown only near these.
        """
        positions = [self.position]
        if self.half_lengths is not None:
            positions += [self.position - self.half_lengths, self.position + self.half_lengths]
        positions += [
            condition.position for condition in self.conditions if len(condition.position)
        ]
        positions += [load.position for load in self.loads if len(load.position)]
        positions += [shape.position for shape in self.tracked if len(shape.position)]
        if self.removed is not None:
            removed = self.removed
            positions += [removed.position - removed.half_lengths]
            positions += [removed.position + removed.half_lengths]
        everything = np.concatenate(positions)
        lower, upper = everything.min(axis=0), everything.max(axis=0)
        longest = float((upper - lower).max())
        near = np.maximum(0.5 * self.cell_size, _MARGIN_RATIO * longest)
        around: list[Floats] = []
        for surface in self.surfaces:
            visible = surface.visible_vertices(lower - longest, upper + longest)
            small = len(visible) > 0 and float(np.ptp(visible, axis=0).max()) <= longest
            if not (surface.bounded and small):
                visible = surface.visible_vertices(lower - near, upper + near)
            around.append(visible)
        if self.water is not None:
            around += [nearby(line, lower, upper) for line in self.water]
        everything = np.concatenate([everything, *around])
        lower, upper = everything.min(axis=0), everything.max(axis=0)
        size = upper - lower
        margin = np.maximum(0.75 * self.cell_size, 0.04 * float(size.max()))
        margin = np.minimum(margin, 0.35 * float(np.maximum(size, self.cell_size).min()))
        return lower - margin, upper + margin
