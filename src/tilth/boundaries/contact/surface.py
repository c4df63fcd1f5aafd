# SPDX-License-Identifier: BSD-3-Clause
"""The surface of a boundary or rigid body that soil can separate from and slide on.

Its quadrature points are those of an implicit boundary. Each stores its traction for the next step,
whether it is in contact, its gap at the end of the step, the gap that was measured there when it
last was in contact (where the soil's surface is known only to a part of the points' spacing, this
is the zero of later gaps), and the excess pore pressure beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.law import ContactLaw
from tilth.boundaries.contact.rigid_body import RigidBody
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.boundaries.surfaces.grid_properties import GridProperties
from tilth.boundaries.surfaces.motion import Motion, rotation_part
from tilth.boundaries.surfaces.points import Pose
from tilth.geometry.both_sides import BothSides
from tilth.geometry.protocol import Geometry, QuadraturePoints
from tilth.geometry.several import outside_of_others
from tilth.model import Contact, ImplicitBoundary
from tilth.model.load_curve import LoadCurve
from tilth.mpm.points import MaterialPoints

ROUND_OFF = 1e-9
"""Gap in cells that is round-off: soil touches the surface."""

LARGEST_OFFSET = 0.3
"""Greatest gap in cells, measured in contact, that counts as inexact knowledge of the surface."""

BEHIND, BEHIND_PLATE = 1.0, 0.1
"""Depth behind a surface, in cells, up to which soil belongs to it: of a body, of a thin plate."""

LARGEST_CARRIED_GAP = 0.1
"""Greatest gap in cells that a point in contact carries to the next step."""

PARALLEL = 0.02
"""Greatest scatter of measured gaps, in cells, at which a point out of contact carries its gap: the
domains' faces are parallel to the surface but for this. On steeper ones the soil would overlap."""

LARGEST_OVERLAP = 3e-3
"""Greatest overlap, in cells, with which a point begins to be in contact. A patch can be open
with some of its points as deep as `OVERLAP` in `forces.py`; what is deeper is not known so well."""

NEVER, OPEN, AWAY = 0.0, -1.0, -2.0
"""Stored states besides 1, in contact: never near soil; near it without contact at the end of the
last step; near it earlier."""

NUMBERS = 5
"""What each point carries besides its traction."""

PORE_PRESSURE = 4
"""Place of the excess pore pressure among them."""

LOST = 0.25
"""Measured gap in cells beyond which a point that was in contact has lost it: twice the scatter of
the measured gaps with two material points per cell and direction."""


@dataclass(frozen=True)
class Touch:
    """Which of n points are in contact at the start of a step.

    Attributes:
        closed: whether there is contact, shape (n,).
        gap: distance to the soil's surface [length], shape (n,); in contact that of the last step,
            which is zero in the mean over a patch; out of contact that of the last step as far as
            the measured one confirms it, or the measured one.
        offset: zero of the measured gaps [length], shape (n,).
        moved: what is measured less what was measured when contact closed [length], shape (n,).
        scatter: how inexact measured gaps are [length], shape (n,).
    """

    closed: Flags
    gap: Floats
    offset: Floats
    moved: Floats
    scatter: Floats

    def of(self, chosen: Integers) -> Touch:
        """Returns that of the chosen points."""
        return Touch(
            self.closed[chosen],
            self.gap[chosen],
            self.offset[chosen],
            self.moved[chosen],
            self.scatter[chosen],
        )


class CarriedContact:
    """Points of a surface that carry contact from step to step.

    Attributes:
        name: given by the user.
        body: the rigid body whose surface it is, or None.
        cell: the smallest edge of a cell [length].
        full: whether the soil touches all of the surface at the start.
        carried: of each point the traction [stress], its state (1 in contact, or `NEVER`, `OPEN`,
            `AWAY`), the zero of its measured gaps, its gap, the measured gap at which contact
            closed [length], and the excess pore pressure that friction had [stress], shape
            (n, dim + NUMBERS).
    """

    name: str
    body: RigidBody | None
    full: bool
    carried: Floats

    @property
    def cell(self) -> float:
        """The smallest edge of a cell [length]."""
        raise NotImplementedError

    @property
    def is_flat(self) -> bool:
        """Whether it consists of flat faces."""
        raise NotImplementedError

    @property
    def has_inertia(self) -> bool:
        """Whether it belongs to a rigid body that moves freely with inertia."""
        return self.body is not None and self.body.moves_with_inertia

    @property
    def touches_nearly(self) -> bool:
        """Whether soil that never was in contact is if its gap is not more than inexact."""
        raise NotImplementedError

    def touch(self, chosen: Integers, measured: Floats, scatter: Floats) -> Touch:
        """Returns the contact of chosen points at the start of a step.

        measured: gaps [length], shape (n,), finite.
        scatter: how inexact they are [length], shape (n,). With `touches_nearly` soil that never
            was in contact counts as touching up to this gap. It is the height of the stair-case
            of domains: the surface is within half of it.
        """
        dim = self.carried.shape[1] - NUMBERS
        stored = self.carried[chosen]
        was_closed, offset = stored[:, dim] == 1.0, stored[:, dim + 1].copy()
        never = stored[:, dim] == NEVER
        tolerance = LOST * self.cell if self.full else scatter * self.touches_nearly
        near = never & (np.abs(measured) <= tolerance)
        offset[near] = measured[near]
        limit = LARGEST_OFFSET * self.cell
        gap = measured - np.clip(offset, -limit, limit)
        carried, part = stored[:, dim + 2], 0.5 * scatter
        if self.has_inertia:  # along the body's way
            carried = np.clip(carried, gap - part, gap + part)
        known = (was_closed | (stored[:, dim] == OPEN)) & (scatter <= PARALLEL * self.cell)
        gap = np.where(known, np.clip(carried, gap - part, gap + part), gap)
        closed = np.where(was_closed, measured < LOST * self.cell, gap <= ROUND_OFF * self.cell)
        closed |= near
        begins = np.where(known, np.clip(gap, -LARGEST_OVERLAP * self.cell, 0.0), 0.0)
        in_contact = np.where(was_closed, carried, begins)
        moved = np.where(was_closed, measured - stored[:, dim + 3], in_contact)
        return Touch(closed, np.where(closed, in_contact, gap), offset, moved, scatter)

    def close_gaps(self) -> None:
        """Forgets the gaps of points in contact, which are zero in the mean over a patch.

        On another grid the patches are others: the mean over one of them would open it, or push
        the soil away with many times the pressure.
        """
        dim = self.carried.shape[1] - NUMBERS
        self.carried[self.carried[:, dim] == 1.0, dim + 2] = 0.0

    def store(
        self,
        chosen: Integers,
        traction: Floats,
        closed: Flags,
        measured: Floats,
        touch: Touch,
        gap: Floats,
        pore_pressure: Floats,
    ) -> None:
        """Stores tractions (n, dim) of points in contact, in the reference configuration's frame.

        closed: whether in contact at the end of the step, shape (n,). measured: gaps at its start
        [length], shape (n,). touch: contact at its start. gap: at its end [length], shape (n,).
        pore_pressure: excess at its end [stress], shape (n,).
        """
        dim = self.carried.shape[1] - NUMBERS
        stored = np.zeros_like(self.carried)
        stored[:, dim] = np.where(self.carried[:, dim] == NEVER, NEVER, AWAY)
        limit = LARGEST_OFFSET * self.cell
        now = np.zeros_like(measured) if self.has_inertia else np.clip(measured, -limit, limit)
        kept = np.where(measured < 2.0 * limit, touch.offset, 0.0)
        stored[chosen, :dim] = np.where(closed[:, None], traction, 0.0)
        stored[chosen, dim] = np.where(closed, 1.0, OPEN)
        stored[chosen, dim + 1] = np.where(closed & touch.closed, now, kept)
        largest = LARGEST_CARRIED_GAP * self.cell
        stored[chosen, dim + 2] = np.where(closed, np.clip(gap, -largest, largest), gap)
        closing = np.where(touch.closed, measured - touch.moved, measured - touch.gap)
        stored[chosen, dim + 3] = np.where(closed, closing, 0.0)
        stored[chosen, dim + PORE_PRESSURE] = np.where(closed, pore_pressure, 0.0)
        self.carried = stored


class ContactSurface(CarriedContact, Implicit):
    """An `Implicit` with contact: of a boundary, or one of the shapes of a rigid body.

    Args:
        declared, key, curve, geometry, motion, delta, grid: see `Implicit`.
        contact: the law.
        contact_with: laws with soil bodies of these names.
        body: the rigid body, if it is a shape of one.
        shapes: all shapes of this body, if there are several.
        full: whether the soil touches all of the surface at the start.
    """

    def __init__(
        self,
        declared: ImplicitBoundary,
        key: str,
        curve: LoadCurve,
        geometry: Geometry,
        motion: Motion,
        delta: float,
        grid: GridProperties,
        contact: Contact,
        contact_with: Mapping[str, Contact],
        body: RigidBody | None = None,
        shapes: Sequence[Geometry] = (),
        full: bool = False,
    ) -> None:
        super().__init__(declared, key, curve, geometry, motion, delta, grid)
        self.contact = contact
        self.contact_with = contact_with
        self.body = body
        self._shapes = shapes
        self.full = full
        self._columns = self.dim + NUMBERS
        self.carried = np.zeros((0, self._columns))

    @property
    def body_name(self) -> str | None:
        """As `Implicit.body_name`."""
        return None if self.body is None else self.body.name

    def _found_ends(self, facet: float) -> None:
        """As `Implicit._found_ends`: soil can leave it, so that its ends do not matter here."""
        del facet

    @property
    def behind(self) -> float:
        """Depth behind the surface up to which soil belongs to it [length].

        With soil on both sides little more than round-off and the scatter of gaps.
        """
        return (BEHIND_PLATE if self.is_thin else BEHIND) * self.cell

    @property
    def is_flat(self) -> bool:
        """As `CarriedContact.is_flat`."""
        return self.geometry.flat

    @property
    def is_thin(self) -> bool:
        """Whether soil is on both sides."""
        return isinstance(self.geometry, BothSides)

    @property
    def cell(self) -> float:
        """The smallest edge of a cell [length]."""
        return float(self._grid.at_start.cell_size.min())

    @property
    def touches_nearly(self) -> bool:
        """As `CarriedContact.touches_nearly`: with boundaries."""
        return self.body is None

    def factor(self, time: float) -> float:
        """As `Implicit.factor`; the motion of a rigid body has the time for its factor."""
        return time if self.body is not None else super().factor(time)

    def _kept(self, points: QuadraturePoints) -> QuadraturePoints:
        points = super()._kept(points)
        if len(self._shapes) < 2:
            return points
        number = [shape is self.geometry for shape in self._shapes].index(True)
        return points.of(outside_of_others(self._shapes, number, points.position, points.normal))

    def square(self, chosen: Integers) -> Floats:
        """Returns the factor of the penalty of chosen points, see `BoundaryQuadrature`, (n,)."""
        assert self.quadrature is not None
        return self.quadrature.square[chosen]

    def turn(self, time: float, pose: Pose, chosen: Integers) -> Floats:
        """Returns rotations from the reference configuration to the middle of a step.

        Shape (n, dim, dim), of chosen points whose `pose` is that of the step from `time`.
        """
        if pose.rotation is None:
            dim = pose.position.shape[1]
            return np.broadcast_to(np.eye(dim), (len(chosen), dim, dim))
        assert self.quadrature is not None
        gradient = self.motion.gradient(self.quadrature.reference[chosen], self.factor(time))
        return np.asarray(pose.rotation[0] @ rotation_part(gradient))

    def leave(self) -> None:
        """Stores that no soil is near: points that were in contact have lost it."""
        nowhere, none = np.zeros(0, dtype=np.int64), np.zeros(0)
        touch = Touch(none > 0.0, none, none, none, none)
        traction = np.zeros((0, self._columns - NUMBERS))
        self.store(nowhere, traction, touch.closed, none, touch, none, none)

    def law(
        self, points: MaterialPoints, point: Integers, cohesion: Floats, slope: Floats
    ) -> ContactLaw:
        """Returns the law of surface points in contact with these material points, (n,) each.

        cohesion, slope: c [stress] and tan(phi) [-] of all material points.
        """
        names = {range_.body: range_.name for range_ in points.ranges}
        number = points.body_id[point]
        parts = np.zeros((4, len(point)))
        bilateral = np.zeros(len(point), dtype=bool)
        for body in np.unique(number):
            own = number == body
            contact = self.contact_with.get(names[body], self.contact)
            values = parameters(contact, cohesion[point[own]], slope[point[own]])
            for part, value in zip(parts, values, strict=True):
                part[own] = value
            bilateral[own] = contact.normal == "bilateral"
        return ContactLaw(parts[0], parts[1], parts[2], parts[3], bilateral)


def parameters(
    contact: Contact, cohesion: Floats, slope: Floats
) -> tuple[Floats | float, Floats | float, Floats | float, Floats | float]:
    """Returns c, mu, limit and T of a declared law, see `ContactLaw`, shape (n,) or one number.

    cohesion, slope: the soil's own c [stress] and tan(phi) [-], shape (n,).
    """
    limit: Floats | float = np.inf
    if contact.shear_limit is not None:
        limit = contact.shear_limit
    elif contact.adhesion_factor is not None:
        limit = contact.adhesion_factor * cohesion
    tension = contact.tensile_strength or 0.0
    if contact.tangential == "smooth":
        return 0.0, 0.0, np.inf, tension
    if contact.tangential == "friction":
        assert contact.friction is not None
        return 0.0, contact.friction, limit, tension
    if contact.tangential == "adhesion":
        return limit, 0.0, np.inf, tension
    if contact.tangential == "rough":
        return cohesion, slope, np.inf, tension
    return np.inf, 0.0, np.inf, tension
