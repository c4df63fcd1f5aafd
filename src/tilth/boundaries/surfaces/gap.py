# SPDX-License-Identifier: BSD-3-Clause
"""Gap between a rigid surface and the soil, along the surface's normals (docs/theory/contact.md).

The soil's surface is the tracked surface of a body that has one, otherwise the outer boundary of
the union of the material points' domains.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.bodies.corners import corner_signs
from tilth.boundaries.surfaces.crossings import SoilSurface, Window, soil_surface
from tilth.grid.background import Grid
from tilth.mpm.points import MaterialPoints
from tilth.surface.protocol import BodySurface

WIDENING = 0.05
"""Share by which a domain is wider across a line than it is: no line slips between two domains."""


def measure_gap(
    points: MaterialPoints,
    grid: Grid,
    surfaces: Mapping[str, BodySurface],
    position: Floats,
    normal: Floats,
    reach: float,
    behind: Floats | float,
    widening: float = WIDENING,
    body: str | None = None,
) -> tuple[Floats, Integers]:
    """Returns the gap between points of a rigid surface and the soil, and the material points.

    The gap at x is the least distance s on the line x + s n, -behind < s < reach, at which the
    line enters soil: > 0 where the surfaces are apart, < 0 where they overlap. It is infinite where
    the line enters no soil: -inf if x lies in soil that the line does not leave behind x, so that
    the body is deeper in the soil than `behind`, otherwise +inf. Soil that the line has left before
    -behind does not count, such as that on the other side of a thin plate whose `behind` is half
    its thickness. In axisymmetry positions and normals are those in the section.

    The surface of a body with a tracked surface is this spline or these triangles. Its domains are
    used instead where the surface is not valid: in the plane if it crosses itself or leads through
    material points (`points = "outer_layer"`), in space along lines that enter it twice without
    leaving it. A line that misses an open curve is also measured with the domains.

    Args:
        points: the material points.
        grid: the background grid; its cells sort the points.
        surfaces: tracked surfaces by the name of the body.
        position: points of the rigid surface [length], shape (n, dim).
        normal: unit normals into the soil, shape (n, dim).
        reach: largest gap that is found [length].
        behind: largest overlap that is found [length], >= 0; one number, or shape (n,).
        widening: share by which domains are wider across a line than they are [-], 0 to 1.
        body: name of the only body that counts; all count without it.

    Returns:
        The gap [length], shape (n,), and the index of the material point that owns the soil's
        surface there, shape (n,): the one whose domain the line enters, with a tracked surface the
        nearest one of the body; -1 where the gap is infinite.

    Raises:
        ValueError: wrong shapes, numbers that are not finite, a negative `behind`.
    """
    if len(position) == 0:
        return np.zeros(0), np.zeros(0, dtype=np.int64)
    position, normal = np.ascontiguousarray(position), np.ascontiguousarray(normal)
    window = Window(np.full(len(position), behind, dtype=np.float64), reach, widening)
    found = {name: soil_surface(surface) for name, surface in surfaces.items()}
    tracked = {
        name: surface
        for name, surface in found.items()
        if surface is not None and points.of_body(name).stop and body in (None, name)
    }
    others = np.ones(len(points), dtype=bool)
    if body is not None:
        others[:] = False
        others[points.of_body(body)] = True
    for name in tracked:
        others[points.of_body(name)] = False
    gap, point = _gap_to_domains(points, others, grid, position, normal, window)
    for name, surface in tracked.items():
        own = points.of_body(name)
        other, of_body = _gap_to_surface(points, own, surface, grid, position, normal, window)
        nearer = other < gap
        gap[nearer], point[nearer] = other[nearer], of_body[nearer]
    return gap, point


def _gap_to_domains(
    points: MaterialPoints,
    chosen: Flags,
    grid: Grid,
    position: Floats,
    normal: Floats,
    window: Window,
) -> tuple[Floats, Integers]:
    """Returns gap and material point of the union of the `chosen` points' domains, (n,) each."""
    near = np.flatnonzero(chosen & _near_lines(points, position, normal, window))
    gap, point = _core.measure_gap(
        position, normal, window.behind, window.reach, points.position[near],
        points.half_length[near], _corners(points, near), grid,
        window.widening,
    )  # fmt: skip
    found = point >= 0
    point[found] = near[point[found]]
    return gap, point


def _near_lines(points: MaterialPoints, position: Floats, normal: Floats, window: Window) -> Flags:
    """Returns which points' domains may meet the lines, by the box around all lines, (points,)."""
    with np.errstate(invalid="ignore"):  # the core refuses numbers that are not finite
        begin = position - 2.0 * window.behind[:, None] * normal
        ends = np.concatenate([begin, position + window.reach * normal])
    near = np.ones(len(points), dtype=bool)
    largest = [half.max(initial=0.0) for half in points.half_length.T]
    margin = 1.1 * float(np.linalg.norm(largest))  # domains count as slightly wider
    for x, end in zip(points.position.T, ends.T, strict=False):
        near &= (x >= end.min(initial=np.inf) - margin) & (x <= end.max(initial=-np.inf) + margin)
    return near


def _corners(points: MaterialPoints, chosen: Integers) -> Floats:
    """Returns the corners of the chosen domains (k, 2^dim, dim) [length]; (0, ...) for boxes."""
    dim = points.position.shape[1]
    if points.corner.shape[1] == 0:
        return np.zeros((0, 2**dim, dim))
    corners = points.corner[chosen]
    for range_ in points.ranges:
        if not range_.has_corners:
            own = (chosen >= range_.start) & (chosen < range_.stop)
            corners[own] = corner_signs(dim) * points.half_length[chosen[own], None]
    return corners


def _gap_to_surface(
    points: MaterialPoints,
    own: slice,
    surface: SoilSurface,
    grid: Grid,
    position: Floats,
    normal: Floats,
    window: Window,
) -> tuple[Floats, Integers]:
    """Returns gap and material point of a body with a tracked surface, shape (n,) each.

    own: the body's points.
    """
    along = surface.cross(position, normal, window)
    gap = along.entry
    undecided = np.flatnonzero(~along.crossed & ~along.folded)
    inside = along.inside
    by_domains = along.folded
    if len(undecided):
        found = surface.contains(position[undecided])
        if found is None:
            by_domains[undecided] = True
        else:
            inside[undecided] = found
    gap[np.isinf(gap) & inside] = -np.inf
    met = np.isfinite(gap)
    place = position + np.where(met, gap, 0.0)[:, None] * normal
    point = nearest_points(points, own, place, met & ~by_domains)
    if by_domains.any():
        of_body = np.zeros(len(points), dtype=bool)
        of_body[own] = True
        gap[by_domains], point[by_domains] = _gap_to_domains(
            points, of_body, grid, position[by_domains], normal[by_domains], window.of(by_domains)
        )
    return gap, point


def nearest_points(points: MaterialPoints, own: slice, place: Floats, chosen: Flags) -> Integers:
    """Returns the body's material point nearest to each `chosen` place (n, dim), -1 for others."""
    from scipy.spatial import cKDTree

    nearest = np.full(len(place), -1)
    if chosen.any():
        here = place[chosen]
        margin = 2.0 * points.half_length[own].max(axis=0)
        x = points.position[own]
        near = ((x > here.min(axis=0) - margin) & (x < here.max(axis=0) + margin)).all(axis=1)
        number = np.flatnonzero(near) if near.any() else np.arange(len(x))
        nearest[chosen] = own.start + number[cKDTree(x[number]).query(here)[1]]
    return nearest
