# SPDX-License-Identifier: BSD-3-Clause
"""Detection of soil that passes through an implicit boundary in a step, or is behind one.

A boundary constrains the soil that is in contact with it at the start of a step. Other soil that
comes into contact during the step is not constrained. If it would end behind the boundary, the step
is undone and shortened to the fraction after which the first contact occurs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.errors import StepFailed
from tilth.geometry.open_surface import OpenSurface
from tilth.geometry.protocol import RoundGeometry
from tilth.geometry.terrain import TerrainLine
from tilth.grid.background import Grid
from tilth.mpm.domains import half_edges
from tilth.mpm.points import MaterialPoints

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

    from tilth.boundaries.surfaces.boundary import Implicit


PASSAGE_TOLERANCE = 0.02
"""Depth behind a boundary, in cells, up to which soil counts as not behind it."""

FACING_DISTANCE = {2: 0.15, 3: 0.3}
"""Greatest distance along a boundary from its nearest quadrature point, in cells, by dimension.

Soil farther away does not face the boundary. A little more than the spacing of quadrature points.
"""

HOLDING_CONDITIONS = ("roller", "fixed")
"""Conditions that hold soil and through which none can pass."""

IMPERMEABLE_CONDITIONS = (*HOLDING_CONDITIONS, "contact")
"""Conditions through which no soil can pass. Contact has a check of its own (contact/checks.py)."""

MAXIMUM_SAMPLES = 64
"""Greatest number of sampled positions on the paths of the points in a step."""

MAXIMUM_REDUCTIONS = 4
"""Number of reductions of a step after which it is accepted if they do not reduce the depth."""

STAGNATION_RATIO = 0.95
"""Ratio of depths behind a boundary above which a reduction of the step had no effect."""


@dataclass(frozen=True)
class Passage:
    """Soil that would pass through a boundary in a step.

    Attributes:
        boundary: name of the boundary.
        point: index of the point that would come into contact first.
        depth: greatest depth of the points' domains behind the boundary at the end [length].
        share: fraction of the step after which the first of them is in contact [-].
    """

    boundary: str
    point: int
    depth: float
    share: float


class PassageCheck:
    """Refuses steps in which unconstrained soil passes through an implicit boundary.

    It stores the last refused step. If `MAXIMUM_REDUCTIONS` shorter steps from the same time hardly
    reduce the depth (`STAGNATION_RATIO`), the step is accepted: no step would be short enough.
    """

    def __init__(self) -> None:
        self._start, self._depth, self._reductions = math.nan, math.inf, 0

    def require_in_front(
        self,
        boundaries: Sequence[Implicit],
        points: MaterialPoints,
        moved: Floats,
        before: float,
        after: float,
        grid: Grid,
    ) -> None:
        """Checks a step from time `before` to `after`; moved: as in `find_passage`.

        Raises:
            StepFailed: soil passes; its `share` is the possible fraction of the step.
        """
        found = [find_passage(b, points, moved, before, after, grid) for b in boundaries]
        passed = [passage for passage in found if passage is not None]
        if not passed:
            return
        passage = min(passed, key=lambda each: each.share)
        reductions = self._reductions + 1 if self._start == before else 0
        stagnant = (
            reductions >= MAXIMUM_REDUCTIONS and passage.depth > STAGNATION_RATIO * self._depth
        )
        self._start, self._depth, self._reductions = before, passage.depth, reductions
        if stagnant:
            return
        raise StepFailed(
            f"soil comes into contact with the boundary {passage.boundary!r} within the step and "
            f"would end {passage.depth:.3g} behind it",
            point=int(points.point_id[passage.point]),
            share=passage.share,
        )


def find_passage(
    boundary: Implicit,
    points: MaterialPoints,
    moved: Floats,
    before: float,
    after: float,
    grid: Grid,
) -> Passage | None:
    """Returns the soil that passes through a boundary in a step from `before` to `after`, or None.

    It checks the end of the step and, for finite or curved boundaries, positions on the straight
    paths of the points at most the smallest cell apart.

    moved: positions of the points at the end of the step [length], shape (n, dim).
    """
    if boundary.declared.kind not in HOLDING_CONDITIONS:
        return None
    samples = 1
    if not _is_infinite_plane(boundary):
        farthest = np.abs((moved - points.position) / grid.cell_size).max(initial=0.0)
        samples = min(max(math.ceil(farthest), 1), MAXIMUM_SAMPLES)
    for fraction in np.arange(1, samples + 1) / samples:
        time = before + fraction * (after - before)
        position = moved
        if fraction < 1.0:
            position = points.position + fraction * (moved - points.position)
        passage = _passage_at(boundary, points, position, before, time, grid)
        if passage is not None:
            return replace(passage, share=float(fraction) * passage.share)
    return None


def _passage_at(
    boundary: Implicit,
    points: MaterialPoints,
    position: Floats,
    before: float,
    time: float,
    grid: Grid,
) -> Passage | None:
    """Returns the soil behind a boundary with the points at `position`, (n, dim), or None."""
    tolerance = PASSAGE_TOLERANCE * float(grid.cell_size.min())
    chosen, distance, normal = _distances(
        boundary, position, points, time, grid, closer=_largest_half_width(points)
    )
    depth = _half_width(points, chosen, normal) - distance
    deep = np.flatnonzero(depth > tolerance)
    if len(deep) == 0:
        return None
    chosen, depth = chosen[deep], depth[deep]
    at_start = points.position[chosen]
    those, distance, normal = _distances(boundary, at_start, None, before, grid)
    chosen, depth = chosen[those], depth[those]
    gap = distance - _half_width(points, chosen, normal)
    free = np.flatnonzero(gap > tolerance)
    if len(free) == 0:
        return None
    share = (gap[free] + 0.5 * tolerance) / (gap[free] + depth[free])
    first = int(share.argmin())
    point = int(chosen[free[first]])
    return Passage(boundary.name, point, float(depth[free].max()), float(share[first]))


def depth_behind(boundary: Implicit, points: MaterialPoints, time: float, grid: Grid) -> float:
    """Returns the greatest distance of a point's centre behind a boundary [length]; 0 if none is.

    Also 0 if soil can pass through the boundary.
    """
    if boundary.declared.kind not in IMPERMEABLE_CONDITIONS:
        return 0.0
    _, distance, _ = _distances(boundary, points.position, points, time, grid, closer=0.0)
    return float(-distance.min(initial=0.0))


def surface_behind(boundary: Implicit, vertices: Floats, time: float, grid: Grid) -> float:
    """Returns the greatest distance of vertices of a soil's surface behind a boundary [length].

    It shows soil that turns into a boundary long before the centre of a point is behind it.
    Also 0 if soil can pass through the boundary.

    vertices: shape (n, dim).
    """
    if boundary.declared.kind not in IMPERMEABLE_CONDITIONS:
        return 0.0
    _, distance, _ = _distances(boundary, vertices, None, time, grid, all_in_front=False)
    return float(-distance.min(initial=0.0))


def border_warning(boundary: Implicit, points: MaterialPoints, time: float, grid: Grid) -> str:
    """Returns what to say of soil beside the border of an open surface or terrain; "" if none is.

    It is within a cell of the border.
    """
    if not isinstance(boundary.geometry, OpenSurface | TerrainLine):
        return ""
    position = boundary.reference_position(points.position, time)
    beyond = boundary.geometry.beyond_border(position, float(grid.largest_size.max()))
    if len(beyond) == 0:
        return ""
    place = ", ".join(f"{x:.4g}" for x in points.position[beyond[0]])
    return (
        f"soil is beyond the border of the boundary {boundary.name!r} at time {time:.6g}: "
        f"{len(beyond)} material points, the first at ({place}); nothing holds it there: let "
        f"{boundary.key}.geometry reach further"
    )


def points_behind(
    boundary: Implicit, points: MaterialPoints, time: float, grid: Grid
) -> tuple[Integers, Floats]:
    """Returns the points with centres behind a boundary, however deep: indices and depths, (k,).

    Those by more than `PASSAGE_TOLERANCE` cells, with their depths [length]; none if soil can pass
    through the boundary.
    """
    if boundary.declared.kind not in IMPERMEABLE_CONDITIONS:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    if isinstance(boundary.geometry, RoundGeometry):  # all points face it
        chosen = np.arange(len(points))
        distance = boundary.distance(points.position, time)
    else:
        chosen, distance, _ = _distances(
            boundary, points.position, None, time, grid, all_in_front=False
        )
    behind = np.flatnonzero(distance < -PASSAGE_TOLERANCE * float(grid.cell_size.min()))
    return chosen[behind], -distance[behind]


def _distances(
    boundary: Implicit,
    position: Floats,
    points: MaterialPoints | None,
    time: float,
    grid: Grid,
    all_in_front: bool = True,
    closer: float = np.inf,
) -> tuple[Integers, Floats, Floats]:
    """Returns the positions that face a boundary: numbers, distances from it, and its normals.

    Numbers (k,), signed distances [length] (k,), < 0 behind the boundary, and normals (k, dim), of
    those at distances less than `closer`. All positions face a plane. Those beside the edge of a
    finite or curved boundary do not; with `points` given, neither do those more than two cells in
    front of it, nor those behind it by more than two cells plus the points' greatest motion.
    Without `all_in_front`, those more than two cells in front do not in any case.
    """
    if _is_infinite_plane(boundary):
        reference = boundary.reference_position(position, time)
        distance = boundary.geometry.distance(reference)
        near = np.flatnonzero(distance < closer)
        return near, distance[near], boundary.geometry.gradient(reference[near])
    surface, normal, _ = boundary.surface_points(time)
    none = np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((0, position.shape[1]))
    if len(surface) == 0:
        return none
    radius, largest = np.inf, float(grid.largest_size.max())
    candidates = np.arange(len(position))
    if points is not None:
        motion = np.linalg.norm(position - points.position, axis=1).max(initial=0.0)
        radius = float(motion + 2.0 * largest)
        low, high = surface.min(axis=0) - radius, surface.max(axis=0) + radius
        candidates = np.flatnonzero(((position >= low) & (position <= high)).all(axis=1))
    from scipy.spatial import cKDTree

    tree = cKDTree(surface)
    if not all_in_front:
        candidates = _near_or_behind(tree, normal, position, 3.0 * largest)
    separation, nearest = tree.query(position[candidates], distance_upper_bound=radius)
    within = np.isfinite(separation)
    candidates, nearest = candidates[within], nearest[within]
    offset = position[candidates] - surface[nearest]
    distance = np.einsum("ni,ni->n", offset, normal[nearest])
    along = np.linalg.norm(offset - distance[:, None] * normal[nearest], axis=1)
    cell = grid.sizes_at(surface[nearest]).max(axis=1)
    facing = along <= FACING_DISTANCE[grid.dim] * cell
    if points is not None or not all_in_front:  # far in front no exact distance is necessary
        facing &= distance <= 2.0 * cell
    candidates, nearest = candidates[facing], nearest[facing]
    if len(candidates) == 0:
        return none
    distance = boundary.distance(position[candidates], time)
    near = np.flatnonzero(distance < closer)
    return candidates[near], distance[near], normal[nearest[near]]


def _near_or_behind(tree: cKDTree, normal: Floats, position: Floats, near: float) -> Integers:
    """Returns the positions nearer to a surface than `near` or behind it, (k,).

    An approximate nearest point says so: the exact one of a point that is far away takes long.
    """
    separation, nearest = tree.query(position, eps=0.5)
    in_front = np.einsum("ni,ni->n", position - tree.data[nearest], normal[nearest]) > 0.0
    return np.flatnonzero((separation <= near) | ~in_front)


def _is_infinite_plane(boundary: Implicit) -> bool:
    """Returns whether a boundary is one infinite plane."""
    return boundary.geometry.flat and not boundary.geometry.bounded


def _largest_half_width(points: MaterialPoints) -> float:
    """Returns an upper bound of half the width of the points' domains [length]."""
    if points.corner.shape[1] > 0:
        return np.inf
    square = np.einsum("ni,ni->n", points.half_length, points.half_length)
    return float(np.sqrt(square.max(initial=0.0)))


def _half_width(points: MaterialPoints, chosen: Integers, normal: Floats) -> Floats:
    """Returns half the width of chosen points' domains along normals [length], shape (n,)."""
    edge = half_edges(points, chosen)
    if edge is None:
        return np.asarray((points.half_length[chosen] * np.abs(normal)).sum(axis=1))
    return np.asarray(np.abs(np.einsum("nki,ni->nk", edge, normal)).sum(axis=1))
