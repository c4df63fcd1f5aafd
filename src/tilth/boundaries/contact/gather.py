# SPDX-License-Identifier: BSD-3-Clause
"""The surfaces that soil can touch in a step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.boundaries.contact.constraint import ContactConstraint
from tilth.boundaries.contact.gap import measure_gap
from tilth.boundaries.contact.measure import (
    DENSE,
    EVEN,
    ROUND_OFF,
    Measure,
    Measured,
    SurfaceParts,
    measure,
    sampled,
)
from tilth.boundaries.contact.smoothness import Smoothness, smoothness
from tilth.boundaries.contact.surface import LOST, CarriedContact, ContactSurface, Touch
from tilth.boundaries.contact.trace import Trace, trace_in_cells, trace_of_domains
from tilth.boundaries.implicit.boundary import Pose
from tilth.mpm.domains import half_edges
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import PointsInCells, locate_in_cells, near_soil
from tilth.surface.protocol import BodySurface

REACH = 1.0
"""Gap, in cells, up to which soil can come into contact in a step."""

BY_WIDENING = 0.02
"""Difference of gaps in cells, at most, by the widening of domains across an oblique line. A body
that rolls would follow it."""


@dataclass(frozen=True)
class TouchingSoil:
    """What contact needs to know of the soil besides its material points.

    Attributes:
        tracked: tracked surfaces, by the bodies' names.
        strength: returns c [stress] and tan(phi) [-] of all points, shape (points,) each.
    """

    tracked: Mapping[str, BodySurface]
    strength: Callable[[MaterialPoints], tuple[Floats, Floats]]


def gather_contacts(
    surfaces: Sequence[ContactSurface],
    soil: TouchingSoil,
    points: MaterialPoints,
    active: ActiveGrid,
    moduli: Floats,
    kind: str,
    before: float,
    after: float,
) -> list[ContactConstraint]:
    """Returns the surfaces near soil in a step from time `before` to `after`, without multipliers.

    moduli: constrained and shear modulus of the material points [stress], shape (points, 2).
    kind: of the analysis.
    """
    if not surfaces:
        return []
    found = []
    cohesion, slope = soil.strength(points)
    for surface in surfaces:
        parts = SurfaceParts(*surface.surface_points(before))
        measure_gap_at = _measure_of(surface, soil, points, active)
        measured = measure(parts, measure_gap_at)
        smooth = None
        if surface.has_inertia:
            smooth = smoothness(parts.position, parts.normal, measured.gap, surface.cell)
        at, chosen, touch = near_cells(surface, parts, measured, points, active, smooth)
        if len(chosen) == 0:
            continue
        point = measured.point[chosen]
        pose = _pose(surface, before, after, chosen)
        if smooth is not None:
            pose = replace(pose, normal=smooth.of(chosen).normals(pose.normal, surface.cell))
        trace = trace_of_soil(
            surface.cell, points, active, at, parts.of(chosen), measured.of(chosen), measure_gap_at
        )
        found.append(
            ContactConstraint(
                boundary=surface,
                chosen=chosen,
                at=at,
                trace=trace,
                pose=replace(pose, weight=pose.weight * measured.share[chosen]),
                moduli=moduli[point],
                axisymmetric=kind == "axisymmetric",
                elastic_share=points.elastic_share[point],
                touch=touch,
                measured=measured.gap[chosen],
                law=surface.law(points, point, cohesion, slope),
                square=surface.square(chosen),
                turn=surface.turn(before, pose, chosen),
            )
        )
    return found


def near_cells(
    surface: CarriedContact,
    parts: SurfaceParts,
    measured: Measured,
    points: MaterialPoints,
    active: ActiveGrid,
    smooth: Smoothness | None = None,
) -> tuple[PointsInCells, Integers, Touch]:
    """Returns the n points of a surface near soil in its cells, their numbers, how they touch it.

    Points are where they touch the soil, or would at the end of their gap.

    smooth: the soil's surface opposite to the surface's points where it is known.
    """
    near = np.flatnonzero(measured.point >= 0)
    gap, point = measured.gap[near], measured.point[near]
    position, normal = parts.position[near], parts.normal[near]
    scatter = scatter_of(points, point, normal)
    if smooth is not None:
        scatter = np.minimum(scatter, smooth.inexact[near])
    touch = surface.touch(near, gap, scatter)
    apart = np.where(touch.closed, 0.0, np.maximum(touch.gap, 0.0))
    foot = position + apart[:, None] * normal
    field = np.broadcast_to(points.fields_of(point), len(near))
    inside = np.flatnonzero(near_soil(active, foot, field))
    order, at = locate_in_cells(active, foot[inside], field[inside])
    order = inside[order]
    return at, near[order], touch.of(order)


def _pose(surface: ContactSurface, before: float, after: float, chosen: Integers) -> Pose:
    """As `Implicit.pose`, with the directions in which contact can hold soil."""
    pose = surface.pose(before, after, chosen)
    if surface.contact.tangential == "smooth":
        return pose
    identity = np.eye(pose.normal.shape[1])
    return replace(pose, projector=np.broadcast_to(identity, pose.projector.shape))


def _measure_of(
    surface: ContactSurface, soil: TouchingSoil, points: MaterialPoints, active: ActiveGrid
) -> Measure:
    """Returns what measures gaps of a surface."""
    reach, behind = REACH * surface.cell, surface.behind

    def measure_gap_at(
        position: Floats, normal: Floats, widening: float
    ) -> tuple[Floats, Integers]:
        found = measure_gap(
            points, active.grid, soil.tracked, position, normal, reach, behind, widening
        )
        if surface.has_inertia and widening > ROUND_OFF:
            exact = measure_gap(
                points, active.grid, soil.tracked, position, normal, reach, behind, ROUND_OFF
            )
            with np.errstate(invalid="ignore"):
                near = np.abs(exact[0] - found[0]) < BY_WIDENING * surface.cell
            found = np.where(near, exact[0], found[0]), np.where(near, exact[1], found[1])
        return _closed_on_plate(*found, points, position) if surface.is_thin else found

    return measure_gap_at


def trace_of_soil(
    cell: float,
    points: MaterialPoints,
    active: ActiveGrid,
    at: PointsInCells,
    parts: SurfaceParts,
    measured: Measured,
    measure_gap_at: Measure,
) -> Trace:
    """Returns the soil's displacement at the n points `at`, with their parts and what was measured.

    On domains with corners it is the mean over samples of the points' parts, of many where only a
    share of a part is opposite soil. cell: the smallest edge of a cell [length].
    """
    cornered = np.zeros(len(points), dtype=bool)
    for body in points.bodies:
        cornered[body.points] = body.has_corners
    own = cornered[measured.point]
    place, foot, point = [], [], []
    for chosen, coordinates in (
        (np.flatnonzero(own & (measured.share == 1.0)), EVEN),
        (np.flatnonzero(own & (measured.share < 1.0)), DENSE),
    ):
        if len(chosen) == 0:
            continue
        samples = sampled(parts.of(chosen), coordinates, measure_gap_at)
        of = chosen[samples.part]
        near = np.abs(samples.gap - measured.gap[of]) < LOST * cell
        near &= cornered[samples.point]
        of, gap = of[near], samples.gap[near]
        place.append(of)
        foot.append(samples.position[near] + gap[:, None] * parts.normal[of])
        point.append(samples.point[near])
    if not place:
        return trace_in_cells(at)
    return trace_of_domains(
        active, points, at, np.concatenate(place), np.concatenate(foot), np.concatenate(point)
    )


def _closed_on_plate(
    gap: Floats, point: Integers, points: MaterialPoints, position: Floats
) -> tuple[Floats, Integers]:
    """Returns gaps and material points of a thin plate, those in intact soil with a gap of 0.

    The plate has cut this soil without moving it. Gaps are -inf there; the material point is the
    nearest one.
    """
    cut = np.flatnonzero(np.isneginf(gap))
    if len(cut):
        from scipy.spatial import cKDTree

        gap[cut], point[cut] = 0.0, cKDTree(points.position).query(position[cut])[1]
    return gap, point


def scatter_of(points: MaterialPoints, point: Integers, normal: Floats) -> Floats:
    """Returns how inexact the measured gaps of material points' domains are [length], shape (n,).

    The faces of a row of boxes are a stair-case along a surface that is oblique to them: its steps
    are as high as the boxes' widths along the normal, without the greatest of their components.
    """
    edge = half_edges(points, point)
    if edge is None:
        across = points.half_length[point] * np.abs(normal)
    else:
        across = np.abs(np.einsum("nki,ni->nk", edge, normal))
    return np.asarray(2.0 * (across.sum(axis=1) - across.max(axis=1)))
