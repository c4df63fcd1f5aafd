# SPDX-License-Identifier: BSD-3-Clause
"""Domains of the material points: their update in a step, and the limits of their size.

Rules: docs/theory/domains.md; the arithmetic is in `cpp/tilth/kernel/advance.hpp`, `corners.hpp`.
"""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.bodies.corners import mean_half_edges
from tilth.errors import StepFailed
from tilth.grid.background import Grid
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints

LEAST_HALF_LENGTH = 1e-3
"""Lower bound of half lengths, in sizes of the cell that contains the point; only a degenerate
update reaches it."""

LARGEST_HALF_LENGTH = 0.5
"""Upper bound of half lengths, likewise, so that a domain intersects at most two cells per axis."""


_FOLDED = "the domain of a material point folded or inverted"
_UNFOLDED = 'the domains of basis = "cpdi1" and "gimp" cannot fold: choose one of them for {!r}'

MovedDomains = dict[int, tuple[Floats, Floats]]
"""Number of a body whose corners move with the grid -> corners relative to the point, shape
(n, 2^dim, dim), and displacement of the points, the domains' centroids, (n, dim) [length]."""


def moved_domains(
    points: MaterialPoints, active: ActiveGrid, kind: str, displacement: Floats
) -> MovedDomains:
    """Returns the domains of CPDI2 at the end of a step; the points keep theirs.

    displacement: of the nodes in the step [length], shape (nodes, dim).

    Raises:
        StepFailed: a domain folds or inverts.
    """
    moved_by_body = {}
    for number, range_ in enumerate(points.ranges):
        if range_.basis != "cpdi2":
            continue
        part, own = points.part(range_), active.of_overlay(range_.overlay)
        moved, shift = np.empty_like(part.corner), np.empty_like(part.position)
        folded = _core.move_corners(
            part.position, part.corner, own.key, displacement[own.nodes], active.grid,
            kind == "axisymmetric", moved, shift,
        )  # fmt: skip
        if folded >= 0:
            remedy = _UNFOLDED.format(range_.name)
            raise StepFailed(_FOLDED, remedy, point=int(part.point_id[folded]))
        moved_by_body[number] = (moved, shift)
    return moved_by_body


def move_domain_faces(points: MaterialPoints, active: ActiveGrid, displacement: Floats) -> None:
    """Moves the faces of GIMP domains with the grid (rule "corners"), before the points move."""
    for range_ in points.ranges:
        if range_.domain_update == "corners":
            part, own = points.part(range_), active.of_overlay(range_.overlay)
            _core.move_domain_faces(
                part.position, own.key, displacement[own.nodes], active.grid,
                part.half_length,
            )  # fmt: skip


def update_domains(points: MaterialPoints, kind: str) -> None:
    """Updates the domains that follow the deformation gradient, at the end of a step."""
    for range_ in points.ranges:
        part = points.part(range_)
        if range_.has_corners:
            if range_.convected_by_gradient:
                part.corner[:] = part.convected_corners()
                if kind == "axisymmetric":
                    keep_off_axis(part)
            continue
        # the linear basis has no domains: the box serves for pictures and for the detection of
        # contact with boundaries
        rule = range_.domain_update or "right_stretch"
        if rule not in ("fixed", "corners"):
            _core.stretch_domains(
                kind, rule, part.deformation_gradient, part.initial_half_length, part.half_length
            )
    points.update_bounding_boxes()


def bound_domains(points: MaterialPoints, grid: Grid) -> dict[str, int]:
    """Clips half lengths to [1e-3, 0.5] cells; returns how many points each bound applies to.

    A cell is the one that contains the point: soil that comes into smaller cells has smaller
    domains. Keys: "floor" and "cap". Bodies whose basis has no domain are left out.
    """
    counts = {"floor": 0, "cap": 0}
    round_off = 1e-12
    for range_ in points.ranges:
        if range_.domain_update is None:
            continue
        half, size = points.half_length[range_.points], grid.cell_size
        if grid.graded:
            size = grid.sizes_at(points.position[range_.points])
        low, high = LEAST_HALF_LENGTH * size, LARGEST_HALF_LENGTH * size
        counts["floor"] += int((half < low).any(axis=1).sum())
        counts["cap"] += int((half > high * (1.0 + round_off)).any(axis=1).sum())
        half.clip(low, high, out=half)
    return counts


def keep_off_axis(part: MaterialPoints) -> None:
    """Shrinks the domains of one body that extend across the axis of symmetry.

    The radial distances of their corners from the point are scaled by one factor, so that the
    domain ends at the axis and remains a parallelogram centred at the point.
    """
    radius, inwards = part.position[:, 0], -part.corner[:, :, 0].min(axis=1)
    across = inwards > radius
    part.corner[across, :, 0] *= (np.maximum(radius, 0.0) / inwards)[across, None]


def half_edges(points: MaterialPoints, chosen: Integers | None = None) -> Floats | None:
    """Returns half the edges of parallelepipeds that represent the domains, shape (n, dim, dim).

    Row k of a matrix is an edge, the one along x first [length]. For CPDI1 they are the edges of
    the domain; for CPDI2 they have its mean directions and are long enough that the ellipsoid
    through the corners of the parallelepiped contains those of the domain. None if no body's
    basis has corners.

    chosen: indices of the points, all if not given.
    """
    corners = points.all_corners()
    if corners is None:
        return None
    if chosen is not None:
        corners = corners[chosen]
    dim = corners.shape[2]
    edges = mean_half_edges(corners)
    local = np.einsum("nci,nik->nck", corners, np.linalg.inv(edges))
    farthest = np.sqrt((local**2).sum(axis=2).max(axis=1) / dim)
    return np.asarray(edges * np.maximum(farthest, 1.0)[:, None, None])


def upper_edges(points: MaterialPoints) -> Floats:
    """Returns the greatest coordinates of the points' domains [length], shape (n, dim)."""
    corners = points.all_corners()
    extent = points.half_length if corners is None else corners.max(axis=1)
    return np.asarray(points.position + extent)
