# SPDX-License-Identifier: BSD-3-Clause
"""Contact between two soil bodies in one step.

Each body has nodes of its own. The quadrature points lie on the tracked surface of the first body;
the gap is measured along its normals to the second one. Means, supports, law and forces are those
of a rigid surface (`constraint.py`), with the displacement of the first body in place of the
surface's:

    m = (1/A) sum_q a_q [f_q . (u_2(y_q) - u_1(x_q)) + g_q (normal only)].

The supports are selected in the cells of the second body.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.body_surface import BodyContactSurface, frames_of, tributary_parts
from tilth.boundaries.contact.constraint import ContactConstraint
from tilth.boundaries.contact.gap import measure_gap, nearest_points
from tilth.boundaries.contact.gather import REACH, TouchingSoil, near_cells, trace_of_soil
from tilth.boundaries.contact.measure import (
    EVEN,
    SurfaceParts,
    measure,
    part_samples,
)
from tilth.boundaries.contact.surface import BEHIND
from tilth.boundaries.contact.trace import Trace, trace_in_cells, trace_of_domains
from tilth.boundaries.implicit.boundary import Pose
from tilth.errors import StepFailed
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import PointsInCells, locate_in_cells, near_soil
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
        )
        return [self, opposite]


def gather_between_bodies(
    surfaces: Sequence[BodyContactSurface],
    soil: TouchingSoil,
    points: MaterialPoints,
    active: ActiveGrid,
    moduli: Floats,
    kind: str,
) -> list[BodyContact]:
    """Returns the contacts of bodies that are near each other, without multipliers.

    The arguments are those of `gather_contacts`.
    """
    if not surfaces:
        return []
    strength = np.stack(soil.strength(points))
    found = [_contact(each, soil, points, active, moduli, strength, kind) for each in surfaces]
    return [each for each in found if each is not None]


def _contact(
    surface: BodyContactSurface,
    soil: TouchingSoil,
    points: MaterialPoints,
    active: ActiveGrid,
    moduli: Floats,
    strength: Floats,
    kind: str,
) -> BodyContact | None:
    """Returns the contact of one pair; None if the bodies are nowhere near each other."""
    first, second = points.of_body(surface.first), points.of_body(surface.second)
    if first.start == first.stop or second.start == second.stop:
        return None
    quadrature = surface.quadrature()
    frame = frames_of(quadrature.edges)
    position, normal = quadrature.position, frame[:, :, 0]
    parts = SurfaceParts(position, normal, tributary_parts(quadrature.edges), whole=True)
    reach, behind = REACH * surface.cell, BEHIND * surface.cell

    def measure_gap_at(
        position: Floats, normal: Floats, widening: float
    ) -> tuple[Floats, Integers]:
        return measure_gap(
            points, active.grid, soil.tracked, position, normal, reach, behind, widening,
            surface.second,
        )  # fmt: skip

    measured = measure(parts, measure_gap_at)
    at, chosen, touch = near_cells(surface, parts, measured, points, active)
    own_field = points.field_of_body(surface.first)
    kept = near_soil(active, position[chosen], own_field)
    kept &= _faces(points, active, surface.second, at, normal[chosen])
    at, chosen, touch = at.of(kept), chosen[kept], touch.of(np.flatnonzero(kept))
    if len(chosen) == 0:
        return None
    own_order, own = locate_in_cells(active, position[chosen], own_field)
    here = nearest_points(points, first, position[chosen], np.ones(len(chosen), dtype=bool))
    other = trace_of_soil(
        surface.cell, points, active, at, parts.of(chosen), measured.of(chosen), measure_gap_at
    )
    trace = other.less(_own_trace(points, active, own, own_order, surface.first, parts.of(chosen)))
    there = measured.point[chosen]
    area = np.linalg.norm(area_vector(quadrature.edges[chosen]), axis=1) * measured.share[chosen]
    if kind == "axisymmetric":
        area = area * 2.0 * np.pi * np.abs(position[chosen, 0])
    weaker = np.minimum(strength[:, here], strength[:, there])
    return BodyContact(
        boundary=surface,
        chosen=chosen,
        at=at,
        pose=_pose(position[chosen], normal[chosen], area, surface.contact.tangential != "smooth"),
        moduli=moduli[here] * moduli[there] / (moduli[here] + moduli[there]),
        axisymmetric=kind == "axisymmetric",
        elastic_share=np.minimum(points.elastic_share[here], points.elastic_share[there]),
        square=np.full(len(chosen), surface.square),
        touch=touch,
        trace=trace,
        measured=measured.gap[chosen],
        law=surface.law(*weaker),
        turn=frame[chosen],
        own=own,
        own_order=own_order,
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
    if any(body.has_corners for body in points.bodies if body.name == name):
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

    They do where their normal and the gradient of this body's volume on the grid, which points into
    the body, are at an angle of at most 78 degrees; at the edges of that body it may be large.
    Without this a side of the first body, at an edge that has sunk in by a trifle, would touch the
    steps between the second body's domains.
    """
    volume = np.zeros((active.nodes, 1))
    for body, stencil in zip(points.bodies, active.stencils, strict=True):
        if body.name == name:
            part = points.part(body)
            _core.scatter(stencil, part.volume[:, None], volume)
    gradient = np.einsum("nki,nk->ni", at.gradient, volume[at.node[at.cell], 0])
    length = np.linalg.norm(gradient, axis=1)
    return np.asarray(np.einsum("ni,ni->n", normal, gradient) >= LEAST_COSINE * length)


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


def require_short_motion(
    surfaces: Sequence[BodyContactSurface], points: MaterialPoints, moved: Floats
) -> None:
    """Checks that no two bodies near each other move by more than contact can see in a step.

    moved: displacements of the material points in the step [length], shape (n, dim).

    Raises:
        StepFailed: their greatest relative displacement along an axis exceeds a cell.
    """
    for surface in surfaces:
        both = [points.of_body(name) for name in (surface.first, surface.second)]
        if any(own.start == own.stop for own in both):
            continue
        boxes = [_box(points, moved, own) for own in both]
        reach = REACH * surface.cell
        if (boxes[0][0] > boxes[1][1] + reach).any() or (boxes[1][0] > boxes[0][1] + reach).any():
            continue
        (low, high), (other_low, other_high) = (
            (moved[own].min(axis=0), moved[own].max(axis=0)) for own in both
        )
        relative = float(np.maximum(high - other_low, other_high - low).max())
        if relative > reach:
            raise StepFailed(
                f"the bodies of {surface.name!r} move by {relative / surface.cell:.3g} cells "
                "relative to each other in one step",
                point=int(points.point_id[both[0].start]),
                share=0.9 * reach / relative,
            )


def _box(points: MaterialPoints, moved: Floats, own: slice) -> tuple[Floats, Floats]:
    """Returns the corners of the box of a body before and after a step, shape (dim,) each."""
    position, half = points.position[own], points.half_length[own]
    low = np.minimum(position, position + moved[own]) - half
    high = np.maximum(position, position + moved[own]) + half
    return low.min(axis=0), high.max(axis=0)
