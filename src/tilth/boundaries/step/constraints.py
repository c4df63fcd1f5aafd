# SPDX-License-Identifier: BSD-3-Clause
"""All implicit boundaries of a step: their contact with soil, forces, reactions and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.between_bodies import NearBodies, find_between_bodies
from tilth.boundaries.contact.body_surface import BodyContactSurface
from tilth.boundaries.contact.constraint import ContactConstraint
from tilth.boundaries.contact.gather import NearContact, TouchingSoil, find_contacts
from tilth.boundaries.contact.soil_ends import at_free_end
from tilth.boundaries.contact.surface import ContactSurface
from tilth.boundaries.implicit.band import BandConstraint
from tilth.boundaries.implicit.constraint import ImplicitConstraint, SurfaceConstraint
from tilth.boundaries.surfaces.multipliers import (
    choose_multipliers,
    concatenated_cells,
    multiplier_coupling,
)
from tilth.boundaries.surfaces.near_soil import (
    NearSoil,
    capped_moduli,
    extend_quadrature,
    find_near_soil,
    nodes_of_cells,
    soil_box,
)
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.terms.linear import LinearElements

if TYPE_CHECKING:
    from tilth.boundaries.surfaces.boundary import Implicit

STIFFNESS_RATIO_OF_BAND = 2.0
"""Stiffness of exterior nodes with the band form relative to that with the surface form."""


@dataclass(frozen=True)
class FoundSoil:
    """The soil near boundaries at the start of a step, the same in all processes.

    Attributes:
        held: of each boundary from which soil cannot separate.
        contacts: surfaces with contact that are near soil.
        between: bodies that are near each other.
    """

    held: Sequence[NearSoil]
    contacts: Sequence[NearContact] = ()
    between: Sequence[NearBodies] = ()

    @classmethod
    def find(
        cls,
        boundaries: Sequence[Implicit],
        points: MaterialPoints,
        active: ActiveGrid,
        before: float,
        soil: TouchingSoil | None = None,
        pairs: Sequence[BodyContactSurface] = (),
    ) -> FoundSoil:
        """Returns the soil near boundaries at the time `before`; all processes call it.

        soil: for contact; required with it. pairs: surfaces of bodies in contact with each other.
        """
        touching = [each for each in boundaries if isinstance(each, ContactSurface)]
        held = find_near_soil(holding(boundaries), points, active, before, traced=True)
        if soil is None or not (touching or pairs):
            return cls(held)
        box = soil_box(points, active.comm)
        for surface in touching:
            extend_quadrature(surface, box, before)
        moduli = capped_moduli(points.elastic_moduli())
        contacts = find_contacts(touching, soil, points, active, moduli, before)
        return cls(held, contacts, find_between_bodies(pairs, soil, points, active, moduli))

    def nodes(self, active: ActiveGrid, others: Sequence[NearSoil] = ()) -> Integers:
        """Returns the sorted keys of all nodes on which these and other boundaries act."""
        of_contacts = [each.keys() for each in self.contacts]
        of_contacts += [each.keys() for each in self.between]
        held = [each.key for each in (*self.held, *others)]
        cells = [*held, *(cell for cell, _ in of_contacts)]
        nodes = [nodes_of_cells(cells, active), *(node for _, node in of_contacts)]
        nodes += [each.trace.node for each in self.held if each.trace is not None]
        return np.unique(np.concatenate(nodes))


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
        near: FoundSoil | None = None,
    ) -> ImplicitConstraints:
        """Returns the constraints in the step from time `before` to `after`.

        kind: of the analysis. constrained: components that other conditions prescribe at nodes,
        shape (nodes, dim); none if not given. near: the soil near the boundaries; that of those
        that hold it if not given.
        """
        if near is None:
            near = FoundSoil.find(boundaries, points, active, before)
        touching = [each for each in boundaries if isinstance(each, ContactSurface)]
        boundaries = holding(boundaries)
        contacts: list[ContactConstraint] = [
            each.constraint(active, kind, before, after) for each in near.contacts
        ]
        contacts += [each.constraint(active, kind) for each in near.between]
        without_contact: list[Implicit] = [
            each for each in touching if each not in [part.boundary for part in contacts]
        ]
        areas = {boundary.name: 0.0 for boundary in boundaries}
        parts = cls._held(
            boundaries, near.held, active, kind, before, after, without_contact, areas
        )
        if constrained is None:
            constrained = np.zeros((active.nodes, active.grid.dim), dtype=bool)
        contacts = [
            replace(each, at_end=at_free_end(each, parts, constrained)) for each in contacts
        ]
        of_surfaces = [part for part in parts if isinstance(part, SurfaceConstraint)]
        multipliers = choose_multipliers(active, [*of_surfaces, *contacts], constrained)
        chosen = iter(multipliers)
        parts = [
            replace(part, multipliers=next(chosen)) if isinstance(part, SurfaceConstraint) else part
            for part in parts
        ]
        owned = [
            part.with_multiplier(each.multiplier[0], active.overlay)
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
        near: Sequence[NearSoil] | None = None,
    ) -> list[ImplicitConstraint]:
        """Returns the points near soil of boundaries that touch it, without multipliers.

        The arguments are those of `gather`.
        """
        areas = {boundary.name: 0.0 for boundary in boundaries}
        if near is None:
            near = find_near_soil(boundaries, points, active, before)
        return cls._held(boundaries, near, active, kind, before, after, [], areas)

    @staticmethod
    def _held(
        boundaries: list[Implicit],
        near: Sequence[NearSoil],
        active: ActiveGrid,
        kind: str,
        before: float,
        after: float,
        without_contact: list[Implicit],
        areas: dict[str, float],
    ) -> list[ImplicitConstraint]:
        """Returns the boundaries that hold soil; adds the others to `without_contact`.

        areas: by name, to which it adds those of the parts that touch soil.
        """
        parts: list[ImplicitConstraint] = []
        for boundary, found in zip(boundaries, near, strict=True):
            chosen = found.chosen
            if len(chosen) == 0:
                without_contact.append(boundary)
                continue
            assert boundary.quadrature is not None
            pose = boundary.pose(before, after, chosen)
            areas[boundary.name] = float((boundary.weights(after, chosen) * found.fraction).sum())
            common = dict[str, Any](
                boundary=boundary,
                chosen=chosen,
                at=found.at(active),
                pose=replace(pose, weight=pose.weight * found.fraction),
                moduli=found.moduli,
                axisymmetric=kind == "axisymmetric",
                elastic_share=found.elastic_share,
                moved=found.moved,
                square=boundary.quadrature.square[chosen],
            )
            if boundary.declared.form == "band":
                parts.append(BandConstraint(**common))
                continue
            trace = offset = None
            if found.trace is not None:
                trace = found.trace.on(active)
                offset = trace.interpolate(active.position) - pose.position
            parts.append(
                SurfaceConstraint(**common, open_ends=found.open_ends, trace=trace, offset=offset)
            )
        return parts

    def exterior_nodes(self) -> tuple[Integers, Floats]:
        """Returns the nodes near boundaries on their far side: sorted keys and relative stiffness.

        The stiffness [-] of the ghost penalty, shape (nodes, dim, 2), increases from 0 on the
        boundary to 1 a cell behind it (to `STIFFNESS_RATIO_OF_BAND` with the band form), times the
        square of the normal's component along each axis; first of nodes with their soil above them
        on the axis, then of those with their soil below.
        """
        keys, depths = [np.zeros(0, dtype=np.int64)], [np.zeros((0, self.active.grid.dim, 2))]
        bands = [part for part in self.parts if isinstance(part, BandConstraint)]
        others = [part for part in self.parts if isinstance(part, SurfaceConstraint)]
        touching = [
            each.of(each.touch.closed)
            for part in self.contacts
            if part.touch.closed.any()
            for each in part.in_cells()
        ]
        lattice = np.asarray(_core.lattice(self.active.key))  # shifted by the nodes' overlays
        for parts, factor in (([*others, *touching], 1.0), (bands, STIFFNESS_RATIO_OF_BAND)):
            if not parts:
                continue
            key, depth = _core.exterior_nodes(*concatenated_cells(parts), lattice, self.active.grid)
            keys.append(np.asarray(key))
            depths.append(factor * np.asarray(depth))
        key, number = np.unique(np.concatenate(keys), return_inverse=True)
        stiffness = np.zeros((len(key), self.active.grid.dim, 2))
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
            if isinstance(part, SurfaceConstraint) and part.trace is not None:
                found[part.trace.node] = True
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


def holding(boundaries: Sequence[Implicit]) -> list[Implicit]:
    """Returns the boundaries from which soil cannot separate."""
    return [each for each in boundaries if not isinstance(each, ContactSurface)]
