# SPDX-License-Identifier: BSD-3-Clause
"""The terms of contact in the balance of a step: one for each rigid body, boundary and pair."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tilth.boundaries.contact.constraint import ContactConstraint, Patches
from tilth.boundaries.contact.forces import AssembledContact
from tilth.boundaries.contact.rigid_body import RigidBody
from tilth.errors import StepFailed
from tilth.mpm.pattern import Elements
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
    ) -> None:
        self._name, self._body, self._after = name, body, after
        self._force, self._normal_before = force, normal_before.get(name)
        self._patches = [Patches(part, nodes, still) for part in parts]

    @property
    def coupled(self) -> list[Coupled]:
        """As `Term.coupled`."""
        return [Coupled(each.node_start, each.node) for each in self._patches]

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledContact:
        """As `Term.assembled`."""
        return AssembledContact(
            self._name, self._patches, elements, self._body, self._after, self._force, space.active,
            self._normal_before,
        )  # fmt: skip


def contact_terms(
    contacts: Sequence[ContactConstraint],
    bodies: Sequence[RigidBody],
    after: float,
    force: float,
    nodes: int,
    normal_before: Mapping[str, float],
    still: bool = False,
) -> list[ContactForces]:
    """Returns the terms of all rigid bodies, and of the boundaries with contact near soil.

    Args: see `ContactForces`.

    Raises:
        StepFailed: no soil is near a free body that nothing else holds against the force on it.
    """
    terms = []
    more = (normal_before, still)
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
