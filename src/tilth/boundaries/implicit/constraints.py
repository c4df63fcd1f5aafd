# SPDX-License-Identifier: BSD-3-Clause
"""All implicit boundaries of a step: their contact with soil, forces, reactions and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.between_bodies import gather_between_bodies
from tilth.boundaries.contact.body_surface import BodyContactSurface
from tilth.boundaries.contact.constraint import ContactConstraint
from tilth.boundaries.contact.gather import TouchingSoil, gather_contacts
from tilth.boundaries.contact.surface import ContactSurface
from tilth.boundaries.implicit.band import BandConstraint
from tilth.boundaries.implicit.constraint import ImplicitConstraint, SurfaceConstraint
from tilth.boundaries.implicit.multipliers import (
    choose_multipliers,
    concatenated_cells,
    multiplier_coupling,
)
from tilth.geometry.flat import box_corners
from tilth.mpm.domains import half_edges
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.points import ElasticModuli, MaterialPoints
from tilth.mpm.quadrature import locate_in_cells
from tilth.terms.linear import LinearElements

if TYPE_CHECKING:
    from tilth.boundaries.implicit.boundary import Implicit

LARGEST_CONSTRAINED_MODULUS = 3.0
"""Cap on the constrained modulus that scales the penalty, in units of Young's modulus.

The exact modulus is unbounded for nu -> 1/2 and would impair the matrix's condition. Because the
traction is carried from step to step, the value does not change the converged reaction.
"""

STIFFNESS_RATIO_OF_BAND = 2.0
"""Stiffness of exterior nodes with the band form relative to that with the surface form."""


@dataclass(frozen=True)
class ImplicitConstraints:
    """The constraints of all implicit boundaries in one step.

    Attributes:
        active: the grid of the step.
        parts: one for each boundary in contact with soil.
        without_contact: the other boundaries.
        contacts: surfaces that soil can separate from and slide on, where they are near soil.
        areas: area of each boundary that touches soil, at the end of the step, by name
            [length^(dim - 1), in axisymmetry length^2].
    """

    active: ActiveGrid
    parts: list[ImplicitConstraint]
    without_contact: list[Implicit]
    contacts: tuple[ContactConstraint, ...] = ()
    areas: dict[str, float] = field(default_factory=dict)

    @classmethod
    def gather(
        cls,
        boundaries: list[Implicit],
        points: MaterialPoints,
        active: ActiveGrid,
        kind: str,
        before: float,
        after: float,
        constrained: Flags | None = None,
        soil: TouchingSoil | None = None,
        pairs: Sequence[BodyContactSurface] = (),
    ) -> ImplicitConstraints:
        """Returns the constraints in the step from time `before` to `after`.

        kind: of the analysis. constrained: components that other conditions prescribe at nodes,
        shape (nodes, dim); none if not given. soil: for contact; required with it. pairs: surfaces
        of bodies in contact with each other.
        """
        if not boundaries and not pairs:
            return cls(active, [], [])
        moduli = _moduli(points.elastic_moduli())
        touching = [each for each in boundaries if isinstance(each, ContactSurface)]
        boundaries = [each for each in boundaries if not isinstance(each, ContactSurface)]
        for surface in touching:
            _extend_quadrature(surface, _box(points), before)
        contacts: list[ContactConstraint] = []
        if soil is not None:
            contacts = gather_contacts(touching, soil, points, active, moduli, kind, before, after)
            contacts += gather_between_bodies(pairs, soil, points, active, moduli, kind)
        without_contact: list[Implicit] = [
            each for each in touching if each not in [part.boundary for part in contacts]
        ]
        areas = {boundary.name: 0.0 for boundary in boundaries}
        parts = cls._held(
            boundaries, points, active, moduli, kind, before, after, without_contact, areas
        )
        if constrained is None:
            constrained = np.zeros((active.nodes, active.grid.dim), dtype=bool)
        of_surfaces = [part for part in parts if isinstance(part, SurfaceConstraint)]
        multipliers = choose_multipliers(active, [*of_surfaces, *contacts], constrained)
        chosen = iter(multipliers)
        parts = [
            replace(part, multipliers=next(chosen)) if isinstance(part, SurfaceConstraint) else part
            for part in parts
        ]
        owned = [
            part.with_owner(each.owner[0], active.field)
            for part, each in zip(contacts, chosen, strict=True)
        ]
        return cls(active, parts, without_contact, tuple(owned), areas)

    @classmethod
    def near_soil(
        cls,
        boundaries: list[Implicit],
        points: MaterialPoints,
        active: ActiveGrid,
        kind: str,
        before: float,
        after: float,
    ) -> list[ImplicitConstraint]:
        """Returns the points near soil of boundaries that touch it, without multipliers.

        The arguments are those of `gather`.
        """
        areas = {boundary.name: 0.0 for boundary in boundaries}
        moduli = _moduli(points.elastic_moduli())
        return cls._held(boundaries, points, active, moduli, kind, before, after, [], areas)

    @staticmethod
    def _held(
        boundaries: list[Implicit],
        points: MaterialPoints,
        active: ActiveGrid,
        moduli: Floats,
        kind: str,
        before: float,
        after: float,
        without_contact: list[Implicit],
        areas: dict[str, float],
    ) -> list[ImplicitConstraint]:
        """Returns the boundaries that hold soil; adds the others to `without_contact`.

        areas: by name, to which it adds those of the parts that touch soil.
        """
        if not boundaries:
            return []
        surfaces, normals, tributary, box = [], [], [], _box(points)
        for boundary in boundaries:
            _extend_quadrature(boundary, box, before)
            surface, normal, part = boundary.surface_points(before)
            surfaces.append(surface)
            normals.append(normal)
            tributary.append(part)
        ends = np.cumsum([len(surface) for surface in surfaces])
        nearest, fraction = _find_contact(
            points,
            active,
            ends,
            np.concatenate(surfaces),
            np.concatenate(normals),
            np.concatenate(tributary),
            box,
        )
        parts: list[ImplicitConstraint] = []
        for boundary, end, surface in zip(boundaries, ends, surfaces, strict=True):
            assert boundary.quadrature is not None
            own = slice(end - len(surface), end)
            point = nearest[own][boundary.quadrature.on_surface]
            chosen = np.flatnonzero(point >= 0)
            if len(chosen) == 0:
                without_contact.append(boundary)
                continue
            field = points.fields_of(point[chosen])
            order, at = locate_in_cells(active, boundary.positions(before, chosen), field)
            chosen = chosen[order]
            pose = boundary.pose(before, after, chosen)
            touched = point[chosen]
            moved = points.last_displacement[touched]
            moved = np.abs(moved / active.grid.sizes_at(points.position[touched])).max(axis=1)
            in_contact = fraction[own][boundary.quadrature.on_surface[chosen]]
            areas[boundary.name] = float((boundary.weights(after, chosen) * in_contact).sum())
            make = SurfaceConstraint if boundary.declared.form == "surface" else BandConstraint
            parts.append(
                make(
                    boundary=boundary,
                    chosen=chosen,
                    at=at,
                    pose=replace(pose, weight=pose.weight * in_contact),
                    moduli=moduli[touched],
                    axisymmetric=kind == "axisymmetric",
                    elastic_share=points.elastic_share[touched],
                    moved=moved,
                    square=boundary.quadrature.square[chosen],
                )
            )
        return parts

    def exterior_nodes(self) -> tuple[Integers, Floats]:
        """Returns the nodes near boundaries on their far side: sorted keys and relative stiffness.

        The stiffness [-] of the ghost penalty, shape (nodes, dim), increases from 0 on the boundary
        to 1 a cell behind it (to `STIFFNESS_RATIO_OF_BAND` with the band form), times the square of
        the normal's component along each axis.
        """
        keys, depths = [np.zeros(0, dtype=np.int64)], [np.zeros((0, self.active.grid.dim))]
        bands = [part for part in self.parts if isinstance(part, BandConstraint)]
        others = [part for part in self.parts if isinstance(part, SurfaceConstraint)]
        touching = [
            each.of(each.touch.closed)
            for part in self.contacts
            if part.touch.closed.any()
            for each in part.in_cells()
        ]
        lattice = np.asarray(_core.lattice(self.active.key))  # shifted by the nodes' fields
        for parts, factor in (([*others, *touching], 1.0), (bands, STIFFNESS_RATIO_OF_BAND)):
            if not parts:
                continue
            key, depth = _core.exterior_nodes(*concatenated_cells(parts), lattice, self.active.grid)
            keys.append(np.asarray(key))
            depths.append(factor * np.asarray(depth))
        key, number = np.unique(np.concatenate(keys), return_inverse=True)
        stiffness = np.zeros((len(key), self.active.grid.dim))
        np.maximum.at(stiffness, number, np.concatenate(depths))
        return key, stiffness

    def warnings(self) -> list[tuple[str, str]]:
        """Returns warnings of probable mistakes: a key for each, and its text."""
        found = []
        for part in self.parts:
            if isinstance(part, BandConstraint) and part.may_lock():
                name = part.boundary.name
                text = (
                    f'the boundary {name!r} with form = "band" constrains each of its quadrature '
                    "points: where it moves or is not parallel to the grid, the soil next to it is "
                    'too stiff (locking); form = "surface" does not lock'
                )
                found.append((f"band of {name}", text))
        return found

    def couplings(self) -> list[LinearElements]:
        """Returns the forces of the slip, linear in the displacement of the step."""
        couplings: list[LinearElements] = []
        surfaces = [part for part in self.parts if isinstance(part, SurfaceConstraint)]
        if surfaces:
            multipliers = [part.multipliers for part in surfaces if part.multipliers is not None]
            slips = [part.initial_slip() for part in surfaces]
            couplings.append(multiplier_coupling(multipliers, slips))
        return couplings + [p.coupling() for p in self.parts if isinstance(p, BandConstraint)]

    def coupled_nodes(self) -> Flags:
        """Returns which nodes belong to cells that the boundaries act on, shape (nodes,)."""
        found = np.zeros(self.active.nodes, dtype=bool)
        for part in self.parts:
            found[part.at.node] = True
        return found

    def largest_increment(self) -> float:
        """Returns the largest prescribed displacement at points in contact with soil [length]."""
        return max(
            (
                float(np.linalg.norm(part.pose.increment, axis=1).max())
                for part in (*self.parts, *self.contacts)
            ),
            default=0.0,
        )

    @cached_property
    def carried_force(self) -> Floats:
        """Internal force of the stresses carried from the last step [force], shape (nodes, dim)."""
        force = np.zeros((self.active.nodes, self.active.grid.dim))
        for part in self.parts:
            force += part.nodal_force(part.before, self.active.nodes)
        return force

    def reaction_before(
        self,
        initial: Floats,
        constrained: Flags,
        constant: Floats,
        touching: Floats,
        between_bodies: Floats,
    ) -> Floats:
        """Returns all boundaries' nodal forces at the start of the step [force], (nodes, dim).

        initial: reaction of the constrained nodes at zero displacement, shape (nodes, dim). It
        contains `constant`, the implicit boundaries' force at zero displacement, same shape, which
        includes that of their motion in the step. Before the step they exert the carried force, and
        those in contact `touching`, the internal force of their tractions, same shape. That of
        contact `between_bodies` is no force of a boundary.
        """
        carried = self.carried_force + touching
        in_step = constant - carried - between_bodies
        return np.asarray(initial - np.where(constrained, in_step, 0.0) - carried)

    def forces(self, carried: list[Floats]) -> dict[str, Floats]:
        """Returns each boundary's nodal forces on the soil [force], shape (nodes, dim), by name.

        carried: the points' stresses of each part, see `after`.
        """
        zero = np.zeros((self.active.nodes, self.active.grid.dim))
        forces = dict.fromkeys([boundary.name for boundary in self.without_contact], zero)
        for part, each in zip(self.parts, carried, strict=True):
            forces[part.boundary.name] = -part.nodal_force(each, self.active.nodes)
        return forces

    def after(self, displacement: Floats) -> list[Floats]:
        """Returns each part's stresses at the end of a step, see `ImplicitConstraint.after`."""
        return [part.after(displacement) for part in self.parts]

    def commit(self, carried: list[Floats]) -> None:
        """Stores the stresses for the next step; boundaries without contact get zero."""
        for part, each in zip(self.parts, carried, strict=True):
            part.commit(each)
        for boundary in self.without_contact:
            boundary.leave()


def _moduli(points: ElasticModuli) -> Floats:
    """Returns the capped constrained and the shear modulus of points [stress], shape (n, 2)."""
    capped = np.minimum(points.constrained, LARGEST_CONSTRAINED_MODULUS * points.young)
    return np.stack([capped, points.shear], axis=1)


def _box(points: MaterialPoints) -> Floats:
    """Returns the lower and the upper corner of the box of all points' boxes, shape (2, dim)."""
    corners = []
    for x, half in zip(points.position.T, points.half_length.T, strict=True):  # fast by columns
        corners.append((x.min() - half.max(), x.max() + half.max()))
    return np.array(corners).T


def _extend_quadrature(boundary: Implicit, box: Floats, time: float) -> None:
    """Extends the quadrature points of a boundary to the soil's box at `time`, shape (2, dim)."""
    reference = boundary.reference_position(box_corners(*box), time)
    boundary.extend_quadrature(reference.min(axis=0), reference.max(axis=0))


def _find_contact(
    points: MaterialPoints,
    active: ActiveGrid,
    ends: Integers,
    surface: Floats,
    normal: Floats,
    part: Floats,
    box: Floats,
) -> tuple[Integers, Floats]:
    """Returns the material point in contact with each surface point and the fraction in contact.

    The point's number, -1 without contact, and the fraction of the tributary part that is in
    contact with soil, 0 to 1; shape (n,) each.
    ends: end of each boundary's surface points. surface: positions [length], shape (n, dim).
    part: tributary parts, shape (n, dim, dim).
    """
    dim, grid = surface.shape[1], active.grid
    edge = half_edges(points)
    if edge is None:
        edge = inverse = np.zeros((0, dim, dim))
        reach = 2.0 * points.half_length
    else:
        inverse = np.ascontiguousarray(np.linalg.inv(edge).transpose(0, 2, 1))
        reach = 2.0 * np.abs(edge).sum(axis=1)  # see soil_contact.hpp
    around = np.ones(dim, dtype=np.int64)  # domains end at most half a cell from the point
    if grid.graded:
        farthest = reach.max(axis=0) + 2.0 * grid.largest_size
    else:
        if edge.size:
            around = np.ceil(reach.max(axis=0) / grid.cell_size).astype(np.int64)
        farthest, reach = around * grid.cell_size, np.zeros((0, dim))
    near = np.ones(len(surface), dtype=bool)
    for x, low, high, margin in zip(surface.T, *box, farthest, strict=True):
        near &= (x >= low - margin) & (x <= high + margin)
    nearest, fraction = np.full(len(surface), -1), np.zeros(len(surface))
    start = np.searchsorted(np.flatnonzero(near), np.append(0, ends))
    nearest[near], fraction[near] = _core.find_contact(
        start, surface[near], normal[near], part[near], points.position, points.half_length,
        edge, inverse, around, reach, grid,
    )  # fmt: skip
    return nearest, fraction
