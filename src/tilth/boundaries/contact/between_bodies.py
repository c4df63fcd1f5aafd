# SPDX-License-Identifier: BSD-3-Clause
"""Contact between two soil bodies in one step.

Each body has nodes of its own. The quadrature points lie on the tracked surface of the first body;
the gap is measured along its normals to the second one. Means, patches, law and forces are those
of a rigid surface (`constraint.py`), with the displacement of the first body in place of the
surface's:

    m = (1/A) sum_q a_q [f_q . (u_2(y_q) - u_1(x_q)) + g_q (normal only)].

The patches are selected in the cells of the second body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.body_surface import BodyContactSurface, frames_of, tributary_parts
from tilth.boundaries.contact.constraint import ContactConstraint
from tilth.boundaries.contact.gather import (
    REACH,
    CellsNearSoil,
    TouchingSoil,
    near_cells,
    trace_of_soil,
)
from tilth.boundaries.contact.law import ContactLaw
from tilth.boundaries.contact.surface import BEHIND, Touch
from tilth.boundaries.surfaces.gap import measure_gap, nearest_points
from tilth.boundaries.surfaces.measure import EVEN, SurfaceParts, measure, part_samples
from tilth.boundaries.surfaces.points import Pose
from tilth.boundaries.surfaces.trace import Trace, trace_in_cells, trace_of_domains
from tilth.comm import Communicator
from tilth.errors import StepFailed
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.owned_places import OwnedPlaces
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import (
    PointsInCells,
    find_cells,
    near_soil,
    points_in_cells,
)
from tilth.surface.quadrature import area_vector

LEAST_COSINE = 0.2
"""Least cosine between the normal of the first body and the direction into the second one."""


@dataclass(frozen=True, kw_only=True)
class BodyContact(ContactConstraint):
    """The points of the first body's surface that the second body can touch in a step.

    Attributes:
        own: the points in the cells of the first body.
        own_order: number of each point of `own` among all, shape (n,).
    """

    own: PointsInCells
    own_order: Integers

    def surface_motion(self, displacement: Floats) -> Floats:
        """As `ContactConstraint.surface_motion`: that of the first body."""
        moved = np.empty_like(self.pose.position)
        moved[self.own_order] = self.own.interpolate(displacement)
        return moved

    def in_cells(self) -> list[ContactConstraint]:
        """As `ContactConstraint.in_cells`: in those of the second and of the first body."""
        order = self.own_order
        turned = replace(self.pose.of(order), normal=-self.pose.normal[order])
        opposite = ContactConstraint(
            chosen=self.chosen[order],
            at=self.own,
            pose=turned,
            moduli=self.moduli[order],
            axisymmetric=self.axisymmetric,
            elastic_share=self.elastic_share[order],
            square=self.square[order],
            boundary=self.boundary,
            touch=self.touch.of(order),
            trace=trace_in_cells(self.own),
            measured=self.measured[order],
            law=self.law.of(order),
            turn=self.turn[order],
            at_end=self.at_end[order],
        )
        return [self, opposite]


@dataclass(frozen=True)
class NearBodies:
    """The n points of the first body's surface that the second body can touch; in all processes.

    Each process finds what is in its own cells.

    Attributes:
        boundary, chosen, cells, touch, gap, moduli, elastic_share, law: see `NearContact`.
        trace: displacement of the second body less that of the first one, with keys of nodes.
        own_cells: the points in the cells of the first body, in the order of its cells.
        own_order: number of each of them among all, shape (n,).
        position: [length], shape (n, dim).
        frame: normal and tangents as columns, shape (n, dim, dim).
        area: of the points' parts opposite soil [length^(dim - 1)], shape (n,).
    """

    boundary: BodyContactSurface
    chosen: Integers
    cells: CellsNearSoil
    touch: Touch
    trace: Trace
    own_cells: CellsNearSoil
    own_order: Integers
    position: Floats
    frame: Floats
    area: Floats
    gap: Floats
    moduli: Floats
    elastic_share: Floats
    law: ContactLaw

    def keys(self) -> tuple[Integers, Integers]:
        """As `NearContact.keys`."""
        return np.concatenate([self.cells.key, self.own_cells.key]), self.trace.node

    def constraint(self, active: ActiveGrid, kind: str) -> BodyContact:
        """As `NearContact.constraint`."""
        surface, position, normal, area = (
            self.boundary,
            self.position,
            self.frame[:, :, 0],
            self.area,
        )
        if kind == "axisymmetric":
            area = area * 2.0 * np.pi * np.abs(position[:, 0])
        return BodyContact(
            boundary=surface,
            chosen=self.chosen,
            at=self.cells.at(active),
            pose=_pose(position, normal, area, surface.contact.tangential != "smooth"),
            moduli=self.moduli,
            axisymmetric=kind == "axisymmetric",
            elastic_share=self.elastic_share,
            square=np.full(len(position), surface.square),
            touch=self.touch,
            trace=self.trace.on(active),
            measured=self.gap,
            law=self.law,
            turn=self.frame,
            at_end=np.zeros(len(position), dtype=bool),
            own=self.own_cells.at(active),
            own_order=self.own_order,
        )


def find_between_bodies(
    surfaces: Sequence[BodyContactSurface],
    soil: TouchingSoil,
    points: MaterialPoints,
    active: ActiveGrid,
    moduli: Floats,
) -> list[NearBodies]:
    """Returns the contacts of bodies that are near each other.

    The arguments are those of `find_contacts`.
    """
    if not surfaces:
        return []
    strength = np.stack(soil.strength(points))
    found = [_contact(each, soil, points, active, moduli, strength) for each in surfaces]
    return [each for each in found if each is not None]


def _contact(
    surface: BodyContactSurface,
    soil: TouchingSoil,
    points: MaterialPoints,
    active: ActiveGrid,
    moduli: Floats,
    strength: Floats,
) -> NearBodies | None:
    """Returns the contact of one pair; None if the bodies are nowhere near each other."""
    first = points.of_body(surface.first)
    there = [points.of_body(name).stop > 0 for name in (surface.first, surface.second)]
    if not all(active.comm.max(float(each)) for each in there):
        return None
    quadrature = surface.quadrature()
    frame = frames_of(quadrature.edges)
    position, normal = quadrature.position, frame[:, :, 0]
    parts = SurfaceParts(position, normal, tributary_parts(quadrature.edges), whole=True)
    places = OwnedPlaces.at(active, position)
    reach, behind = REACH * surface.cell, BEHIND * surface.cell
    own_overlay = points.overlay_of_body(surface.first)

    def measure_gap_at(
        position: Floats, normal: Floats, widening: float
    ) -> tuple[Floats, Integers]:
        return measure_gap(
            points, active.grid, soil.tracked, position, normal, reach, behind, widening,
            surface.second,
        )  # fmt: skip

    def keeps(number: Integers, key: Integers, local: Floats) -> Flags:
        order = np.argsort(key, kind="stable")
        at = points_in_cells(active, key[order], local[order])
        kept = near_soil(active, position[number], own_overlay)
        kept[order] &= _faces(points, active, surface.second, at, normal[number[order]])
        return kept

    measured = measure(parts, measure_gap_at, places)
    cells, chosen, touch = near_cells(surface, parts, measured, points, active, places, keeps=keeps)
    if len(chosen) == 0:
        return None
    among = places.of(chosen)
    own = chosen[among.own]
    key, local = among.of_all(*find_cells(active, position[own], own_overlay))
    own_order = np.argsort(key, kind="stable")
    here = nearest_points(points, first, position[own], np.ones(len(own), dtype=bool))
    opposite = measured.point[own]
    weaker = np.minimum(strength[:, here], strength[:, opposite])
    of_soil = among.of_all(
        moduli[here] * moduli[opposite] / (moduli[here] + moduli[opposite]),
        np.minimum(points.elastic_share[here], points.elastic_share[opposite]),
        *surface.law(*weaker).columns(),
    )
    trace = trace_of_soil(
        surface.cell, points, active, cells, parts.of(chosen), measured.of(chosen),
        measure_gap_at, among,
    )  # fmt: skip
    if trace is None:
        trace = trace_in_cells(cells.at(active, among.own)).at_keys(active, among)
    order = np.argsort(key[among.own], kind="stable")
    of_first = points_in_cells(active, key[among.own][order], local[among.own][order])
    own_trace = _own_trace(points, active, of_first, order, surface.first, parts.of(own))
    area = np.linalg.norm(area_vector(quadrature.edges[chosen]), axis=1) * measured.share[chosen]
    return NearBodies(
        boundary=surface,
        chosen=chosen,
        cells=cells,
        touch=touch,
        trace=trace.less(own_trace.at_keys(active, among)),
        own_cells=CellsNearSoil(key[own_order], local[own_order]),
        own_order=own_order,
        position=position[chosen],
        frame=frame[chosen],
        area=area,
        gap=measured.gap[chosen],
        moduli=of_soil[0],
        elastic_share=of_soil[1],
        law=ContactLaw(*of_soil[2:]),
    )


def _own_trace(
    points: MaterialPoints,
    active: ActiveGrid,
    own: PointsInCells,
    order: Integers,
    name: str,
    parts: SurfaceParts,
) -> Trace:
    """Returns the displacement of the body `name` at its n surface points, in their order.

    own, order: the points in its cells and the number of each.
    """
    trace = trace_in_cells(own)
    if any(range_.has_corners for range_ in points.ranges if range_.name == name):
        places = part_samples(parts, EVEN)
        place = np.repeat(np.arange(len(places)), places.shape[1])
        sample = places.reshape(len(place), -1)
        nearest = nearest_points(
            points, points.of_body(name), sample, np.ones(len(sample), dtype=bool)
        )
        in_own = np.empty(len(order), dtype=np.int64)
        in_own[order] = np.arange(len(order))
        trace = trace_of_domains(active, points, own, in_own[place], sample, nearest)
    return trace.renumbered(order)


def _faces(
    points: MaterialPoints, active: ActiveGrid, name: str, at: PointsInCells, normal: Floats
) -> Flags:
    """Returns which surface points face the surface of the body `name`, shape (n,).

    They do where their normal and the direction into this body are at an angle of at most 78
    degrees; at the edges of that body it may be large. The direction at x is

        sum_n N_n(x) sum_p S_n(x_p) V_p (x_p - x),

    which vanishes within the body, and along its surface, however thin it is. Without this a side
    of the first body, at an edge that has sunk in by a trifle, would touch the steps between the
    second body's domains.
    """
    moment = np.zeros((active.nodes, 1 + normal.shape[1]))
    for range_, stencil in zip(points.ranges, active.stencils, strict=True):
        if range_.name == name:
            part = points.part(range_)
            volume = part.volume[:, None]
            _core.scatter(stencil, np.hstack([volume, volume * part.position]), moment)
    nodes = at.node[at.cell]
    volume, first = moment[nodes, 0, None], moment[nodes, 1:]
    place = at.interpolate(active.position)
    into = np.einsum("nk,nki->ni", at.value, first - volume * place[:, None])
    length = np.linalg.norm(into, axis=1)
    return np.asarray(np.einsum("ni,ni->n", normal, into) >= LEAST_COSINE * length)


def _pose(position: Floats, normal: Floats, weight: Floats, holds_along: bool) -> Pose:
    """Returns points whose motion is that of nodes.

    holds_along: whether contact can hold soil along the surface as well.
    """
    dim = position.shape[1]
    across = normal[:, :, None] * normal[:, None, :]
    return Pose(
        position=position,
        increment=np.zeros_like(position),
        gradient=np.zeros((*position.shape, dim)),
        normal=normal,
        weight=weight,
        direction=None,
        projector=np.broadcast_to(np.eye(dim), across.shape) if holds_along else across,
        rotation=None,
    )


@dataclass(frozen=True)
class MotionOfBody:
    """Where a body is in a step and how it moves, of all processes.

    Attributes:
        low, high: corners of its box before and after the step [length], shape (dim,).
        least, most: displacements along the axes in the step [length], shape (dim,).
        point: permanent number of one of its points.
    """

    low: Floats
    high: Floats
    least: Floats
    most: Floats
    point: int


Motions = Mapping[str, MotionOfBody]
"""Of those bodies that are there, by name."""


def motions_of_bodies(
    surfaces: Sequence[BodyContactSurface],
    points: MaterialPoints,
    moved: Floats,
    comm: Communicator,
) -> Motions:
    """Returns the motions of bodies with contact; all processes call it.

    moved: displacements of the material points in the step [length], shape (n, dim).
    """
    found = {}
    for name in dict.fromkeys(name for each in surfaces for name in (each.first, each.second)):
        own = points.of_body(name)
        here = _motion(points, moved, own) if own.stop > own.start else None
        parts = [each for each in comm.gathered(here) if each is not None]
        if parts:
            found[name] = MotionOfBody(
                np.min([each.low for each in parts], axis=0),
                np.max([each.high for each in parts], axis=0),
                np.min([each.least for each in parts], axis=0),
                np.max([each.most for each in parts], axis=0),
                parts[0].point,
            )
    return found


def _motion(points: MaterialPoints, moved: Floats, own: slice) -> MotionOfBody:
    """Returns the motion of the points `own` of a body."""
    position, half = points.position[own], points.half_length[own]
    low = np.minimum(position, position + moved[own]) - half
    high = np.maximum(position, position + moved[own]) + half
    return MotionOfBody(
        low.min(axis=0),
        high.max(axis=0),
        moved[own].min(axis=0),
        moved[own].max(axis=0),
        int(points.point_id[own.start]),
    )


def require_short_motion(surfaces: Sequence[BodyContactSurface], motions: Motions) -> None:
    """Checks that no two bodies near each other move by more than contact can see in a step.

    Raises:
        StepFailed: their greatest relative displacement along an axis exceeds a cell.
    """
    for surface in surfaces:
        if surface.first not in motions or surface.second not in motions:
            continue
        one, other = motions[surface.first], motions[surface.second]
        reach = REACH * surface.cell
        if (one.low > other.high + reach).any() or (other.low > one.high + reach).any():
            continue
        relative = float(np.maximum(one.most - other.least, other.most - one.least).max())
        if relative > reach:
            raise StepFailed(
                f"the bodies of {surface.name!r} move by {relative / surface.cell:.3g} cells "
                "relative to each other in one step",
                point=one.point,
                share=0.9 * reach / relative,
            )
