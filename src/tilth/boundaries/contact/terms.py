# SPDX-License-Identifier: BSD-3-Clause
"""The terms of contact in the balance of a step: one for each rigid body, boundary and pair."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tilth.boundaries.contact.constraint import ContactConstraint
from tilth.boundaries.contact.forces import AssembledContact
from tilth.boundaries.contact.patches import Patches
from tilth.boundaries.contact.rigid_body import RigidBody
from tilth.errors import StepFailed
from tilth.mpm.pattern import Elements
from tilth.terms.pore_water import PORE_PRESSURE
from tilth.terms.protocol import Term
from tilth.terms.space import Coupled, Space


class ContactForces(Term):
    """Contact of soil with the surfaces of one boundary or rigid body in a step.

    Args:
        name: of the boundary or body.
        parts: its surfaces near soil, with their multipliers.
        body: the rigid body, if it is one.
        after: time at the end of the step.
        force: Young's modulus times a cell's face [force; in axisymmetry force/length], for the
            scale of the springs that hold free bodies.
        nodes: number of nodes of the grid.
        normal_before: integrals of the normal traction over each surface at the end of the last
            step [force], by its name; none of a surface that was not there.
        still: see `Patches`.
        with_water: whether water flows through the soil, whose pressure friction does not have.
    """

    def __init__(
        self,
        name: str,
        parts: Sequence[ContactConstraint],
        body: RigidBody | None,
        after: float,
        force: float,
        nodes: int,
        normal_before: Mapping[str, float],
        still: bool = False,
        with_water: bool = False,
    ) -> None:
        self._name, self._body, self._after = name, body, after
        self._force, self._normal_before = force, normal_before.get(name)
        self._patches = [Patches(part, nodes, still) for part in parts]
        self._with_water = with_water

    @property
    def coupled(self) -> list[Coupled]:
        """As `Term.coupled`."""
        alone = [Coupled(each.node_start, each.node) for each in self._patches]
        return [*alone, *filter(None, self._with_pore_pressure)]

    @property
    def _with_pore_pressure(self) -> list[Coupled | None]:
        """For each surface, its nodes with those of the pore pressure; None without friction."""
        if not self._with_water:
            return [None] * len(self._patches)
        found: list[Coupled | None] = []
        for each in self._patches:
            other = Coupled(each.node_start, each.node, PORE_PRESSURE)
            displaced = Coupled(each.node_start, each.node, other=other)
            found.append(displaced if each.has_friction else None)
        return found

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledContact:
        """As `Term.assembled`."""
        with_water = [
            None if each is None else space.blocks_of(each)[0] for each in self._with_pore_pressure
        ]
        return AssembledContact(
            self._name, self._patches, elements, self._body, self._after, self._force, space.active,
            self._normal_before, with_water,
        )  # fmt: skip


def contact_terms(
    contacts: Sequence[ContactConstraint],
    bodies: Sequence[RigidBody],
    after: float,
    force: float,
    nodes: int,
    normal_before: Mapping[str, float],
    still: bool = False,
    with_water: bool = False,
) -> list[ContactForces]:
    """Returns the terms of all rigid bodies, and of the boundaries with contact near soil.

    Args: see `ContactForces`.

    Raises:
        StepFailed: no soil is near a free body that nothing else holds against the force on it.
    """
    terms = []
    more = (normal_before, still, with_water)
    for body in bodies:
        own = [part for part in contacts if part.boundary.body is body]
        if not own and body.falls_along(after) is not None:
            raise StepFailed(f"no soil is near the rigid body {body.name!r} to hold it")
        terms.append(ContactForces(body.name, own, body, after, force, nodes, *more))
    terms += [
        ContactForces(part.boundary.name, [part], None, after, force, nodes, *more)
        for part in contacts
        if part.boundary.body is None
    ]
    return terms
