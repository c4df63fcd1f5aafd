# SPDX-License-Identifier: BSD-3-Clause
"""The surfaces that soil can touch in a step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.constraint import ContactConstraint
from tilth.boundaries.contact.law import ContactLaw
from tilth.boundaries.contact.smoothness import Smoothness, smoothness
from tilth.boundaries.contact.soil_ends import at_soil_end
from tilth.boundaries.contact.surface import LOST, CarriedContact, ContactSurface, Touch
from tilth.boundaries.surfaces.gap import measure_gap
from tilth.boundaries.surfaces.measure import (
    DENSE,
    EVEN,
    ROUND_OFF,
    Measure,
    Measured,
    SurfaceParts,
    measure,
    sampled,
)
from tilth.boundaries.surfaces.points import Pose
from tilth.boundaries.surfaces.trace import Trace, trace_in_cells, trace_of_domains, with_corners
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.domains import half_edges
from tilth.mpm.owned_places import OwnedPlaces
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import PointsInCells, find_cells, near_soil, points_in_cells
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


@dataclass(frozen=True)
class CellsNearSoil:
    """The cells of n points of a surface near soil, ordered by cell; the same in all processes.

    Attributes:
        key: of the cell of each point, shape (n,).
        local: coordinates in the cell, in cells, shape (n, dim).
    """

    key: Integers
    local: Floats

    def at(self, active: ActiveGrid, chosen: Integers | None = None) -> PointsInCells:
        """Returns the points, or chosen ones in this order, on a grid with all their nodes."""
        if chosen is None:
            return points_in_cells(active, self.key, self.local)
        return points_in_cells(active, self.key[chosen], self.local[chosen])


@dataclass(frozen=True)
class NearContact:
    """The n points of a surface that soil can touch in a step, and this soil; in all processes.

    Each process finds what is in its own cells.

    Attributes:
        boundary: the surface.
        chosen: their numbers among all points of the surface, shape (n,).
        cells: that the points are in, or would be at the end of their gap.
        touch: their contact at the start of the step.
        trace: of the soil, with keys of nodes; None if it is that in the cells.
        gap: as measured [length], shape (n,).
        share: of the points' parts that is opposite soil [-], 0 to 1, shape (n,).
        moduli: constrained modulus (capped) and shear modulus of the soil [stress], shape (n, 2).
        elastic_share: elastic part of the soil's last strain increment [-], shape (n,).
        law: of each point.
        smooth: the soil's surface opposite to them where it is known.
        at_end: which are in the strip along an end of the soil's face, shape (n,).
    """

    boundary: ContactSurface
    chosen: Integers
    cells: CellsNearSoil
    touch: Touch
    trace: Trace | None
    gap: Floats
    share: Floats
    moduli: Floats
    elastic_share: Floats
    law: ContactLaw
    smooth: Smoothness | None
    at_end: Flags

    def keys(self) -> tuple[Integers, Integers]:
        """Returns the keys of the cells and of the other nodes on which the contact acts."""
        return self.cells.key, np.zeros(
            0, dtype=np.int64
        ) if self.trace is None else self.trace.node

    def constraint(
        self, active: ActiveGrid, kind: str, before: float, after: float
    ) -> ContactConstraint:
        """Returns the contact in the step from `before` to `after`, without multipliers.

        active: the grid of the step, with all nodes of `keys`. kind: of the analysis.
        """
        surface, chosen, smooth = self.boundary, self.chosen, self.smooth
        pose = _pose(surface, before, after, chosen)
        if smooth is not None:
            pose = replace(pose, normal=smooth.of(chosen).normals(pose.normal, surface.cell))
        at = self.cells.at(active)
        if self.trace is None:
            trace = trace_in_cells(at)
        else:
            trace = self.trace.on(active)
            pose = _where_taken(pose, trace.interpolate(active.position))
        return ContactConstraint(
            boundary=surface,
            chosen=chosen,
            at=at,
            trace=trace,
            pose=replace(pose, weight=pose.weight * self.share),
            moduli=self.moduli,
            axisymmetric=kind == "axisymmetric",
            elastic_share=self.elastic_share,
            touch=self.touch,
            measured=self.gap,
            law=self.law,
            square=surface.square(chosen),
            turn=surface.turn(before, pose, chosen),
            at_end=self.at_end,
        )


def find_contacts(
    surfaces: Sequence[ContactSurface],
    soil: TouchingSoil,
    points: MaterialPoints,
    active: ActiveGrid,
    moduli: Floats,
    before: float,
) -> list[NearContact]:
    """Returns the surfaces near soil at the time `before`, the start of a step.

    moduli: constrained and shear modulus of the material points [stress], shape (points, 2).
    """
    if not surfaces:
        return []
    found = []
    cohesion, slope = soil.strength(points)
    for surface in surfaces:
        parts = SurfaceParts(*surface.surface_points(before))
        places = OwnedPlaces.at(active, parts.position)
        measure_gap_at = _measure_of(surface, soil, points, active)
        measured = measure(parts, measure_gap_at, places)
        smooth = None
        if surface.has_inertia:
            smooth = smoothness(parts.position, parts.normal, measured.gap, active.grid)
        cells, chosen, touch = near_cells(surface, parts, measured, points, active, places, smooth)
        if len(chosen) == 0:
            continue
        here = places.of(chosen)
        point = measured.point[chosen[here.own]]
        law = surface.law(points, point, cohesion, slope)
        of_soil = here.of_all(moduli[point], points.elastic_share[point], *law.columns())
        trace = trace_of_soil(
            surface.cell, points, active, cells, parts.of(chosen), measured.of(chosen),
            measure_gap_at, here,
        )  # fmt: skip
        found.append(
            NearContact(
                boundary=surface,
                chosen=chosen,
                cells=cells,
                touch=touch,
                trace=trace,
                gap=measured.gap[chosen],
                share=measured.share[chosen],
                moduli=of_soil[0],
                elastic_share=of_soil[1],
                law=ContactLaw(*of_soil[2:]),
                smooth=smooth,
                at_end=at_soil_end(parts, measured, chosen, surface.cell),
            )
        )
    return found


Keeps = Callable[[Integers, Integers, Floats], Flags]
"""Returns which points of a surface are kept, (k,): by their numbers (k,), the keys of their
cells (k,) and their coordinates in these (k, dim)."""


def near_cells(
    surface: CarriedContact,
    parts: SurfaceParts,
    measured: Measured,
    points: MaterialPoints,
    active: ActiveGrid,
    places: OwnedPlaces,
    smooth: Smoothness | None = None,
    keeps: Keeps = lambda number, key, local: np.ones(len(number), dtype=bool),
) -> tuple[CellsNearSoil, Integers, Touch]:
    """Returns the n points of a surface near soil in its cells, their numbers, how they touch it.

    Points are where they touch the soil, or would at the end of their gap.

    places: the owners of the surface's points. smooth: the soil's surface opposite to the points
    where it is known. keeps: of the points in the cells of this process.
    """
    near = np.flatnonzero(measured.point >= 0)
    here = places.of(near)
    gap, position, normal = measured.gap[near], parts.position[near], parts.normal[near]
    own = here.own
    point = measured.point[near[own]]
    (scatter,) = here.of_all(scatter_of(points, point, normal[own]))
    if smooth is not None:
        scatter = np.minimum(scatter, smooth.inexact[near])
    touch = surface.touch(near, gap, scatter)
    apart = np.where(touch.closed, 0.0, np.maximum(touch.gap, 0.0))
    foot = (position + apart[:, None] * normal)[own]
    overlay = np.broadcast_to(points.overlays_of(point), len(own))
    takes = near_soil(active, foot, overlay)
    inside = np.flatnonzero(takes)
    key, local = np.zeros(len(own), dtype=np.int64), np.zeros_like(foot)
    key[inside], local[inside] = find_cells(active, foot[inside], overlay[inside])
    takes[inside] = keeps(near[own[inside]], key[inside], local[inside])
    takes, key, local = here.of_all(takes, key, local)
    kept = np.flatnonzero(takes)
    order = kept[np.argsort(key[kept], kind="stable")]
    return CellsNearSoil(key[order], local[order]), near[order], touch.of(order)


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
    cells: CellsNearSoil,
    parts: SurfaceParts,
    measured: Measured,
    measure_gap_at: Measure,
    places: OwnedPlaces,
) -> Trace | None:
    """Returns the soil's displacement at n points, with their parts and what was measured.

    On domains with corners it is the mean over samples of the points' parts, of many where only a
    share of a part is opposite soil; the nodes have their keys for numbers. None without such
    domains: it is then that in the points' cells.

    cell: the smallest edge of a cell [length]. cells: of the points. places: their owners.
    """
    own = places.own
    cornered = with_corners(points)
    (on_corners,) = places.of_all(cornered[measured.point[own]])
    if not on_corners.any():
        return None
    partly = on_corners & (measured.share < 1.0)
    of_dense = (np.cumsum(partly) - 1)[own]  # numbers among the points with many samples
    here, has, whole = parts.of(own), on_corners[own], measured.share[own] == 1.0
    place, point = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    foot = [np.zeros((0, active.grid.dim))]
    for chosen, coordinates in (
        (np.flatnonzero(has & whole), EVEN),
        (np.flatnonzero(partly[own]), DENSE),
    ):
        samples = sampled(here.of(chosen), coordinates, measure_gap_at, of_dense[chosen])
        of = chosen[samples.part]
        near = np.abs(samples.gap - measured.gap[own[of]]) < LOST * cell
        near &= cornered[samples.point]
        of, gap = of[near], samples.gap[near]
        place.append(of)
        foot.append(samples.position[near] + gap[:, None] * here.normal[of])
        point.append(samples.point[near])
    at = cells.at(active, own)
    trace = trace_of_domains(
        active, points, at, np.concatenate(place), np.concatenate(foot), np.concatenate(point)
    )
    return trace.at_keys(active, places)


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


def _where_taken(pose: Pose, position: Floats) -> Pose:
    """Returns the pose moved along the surface to where the soil's displacement is taken.

    position: mean of the soil's positions with the weights of the displacement [length], (n, dim).
    """
    away, normal = position - pose.position, pose.normal
    if pose.rotation is not None:  # at the start of the step, as the positions are
        normal = np.einsum("nji,nj->ni", pose.rotation[0], normal)
    along = away - np.einsum("ni,ni->n", away, normal)[:, None] * normal
    return replace(pose, position=pose.position + along, increment=pose.increment_at(along))
