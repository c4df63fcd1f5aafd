# SPDX-License-Identifier: BSD-3-Clause
"""What contact on one boundary, rigid body or pair of bodies tells of a converged step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.boundaries.contact.evaluation import Part
from tilth.boundaries.contact.slip_work import slip_work
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.outcome import ContactOutcome, ContactState, Outcome, Work


def contact_outcome(
    name: str,
    parts: Sequence[Part],
    active: ActiveGrid,
    displacement: Floats,
    normal_before: float | None,
    is_between_bodies: bool,
) -> Outcome:
    """Returns the outcome of a term of contact.

    Args:
        name: of the boundary, rigid body or pair of bodies.
        parts: its surfaces at the displacement.
        active: the grid of the step.
        displacement: of the nodes in the step [length], shape (nodes, dim).
        normal_before: see `slip_work`.
        is_between_bodies: whether both sides are soil.
    """
    slips = slip_work([(part, each.slip, each.response) for part, _, each in parts], normal_before)
    state = _state(parts, displacement)
    return Outcome(
        {name: _nodal_force(parts, active, is_between_bodies)},
        Work(surface=slips.total, friction=slips.friction, gaps=slips.gaps),
        contact=ContactOutcome(name, state, slips.normal, is_between_bodies),
    )


def _nodal_force(parts: Sequence[Part], active: ActiveGrid, is_between_bodies: bool) -> Floats:
    """Returns the force of the surfaces on the soil [force], shape (nodes, dim).

    Between bodies that on the second one.
    """
    nodal = np.zeros((active.nodes, active.grid.dim))
    for patch, elements, each in parts:
        _core.add_element_forces(elements, -patch.entry_force(each.response.traction), nodal)
        if is_between_bodies:
            second = active.overlay[patch.part.at.node[0, 0]]
            nodal[active.overlay != second] = 0.0
    return nodal


def _state(parts: Sequence[Part], displacement: Floats) -> ContactState:
    """Returns pressures, shear tractions and gaps at the end of the step."""
    states = []
    for patch, _, each in parts:
        part = patch.part
        multiplier = part.multiplier
        traction = patch.distribute(each.response.traction)
        normal = part.pose.normal
        along = np.einsum("ni,ni->n", traction, normal)
        closed = each.response.closed[multiplier] & patch.active
        gap = np.where(closed, 0.0, patch.gaps(displacement, each.moved))
        states.append(
            ContactState(
                position=part.pose.position + each.moved + part.surface_motion(displacement),
                normal=normal,
                weight=part.pose.weight,
                normal_stress=along,
                shear_stress=along[:, None] * normal - traction,
                gap=gap,
                sliding=each.response.sliding[multiplier] & closed,
                in_contact=closed,
            )
        )
    return ContactState.joined(states, displacement.shape[1])
