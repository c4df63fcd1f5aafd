# SPDX-License-Identifier: BSD-3-Clause
"""The points of a surface that soil can touch in a step."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.law import ContactLaw
from tilth.boundaries.contact.surface import PORE_PRESSURE, CarriedContact, Touch
from tilth.boundaries.surfaces.patches import is_sliver, surrounded, without_small
from tilth.boundaries.surfaces.points import ConstrainedPoints
from tilth.boundaries.surfaces.trace import Trace

SURROUNDING = 0.75
"""Distance in cells within which points in contact decide whether they surround another one."""

NEAR = 0.01
"""Gap in cells beyond the smallest one up to which points are active from the start of a step."""


@dataclass(frozen=True)
class ContactConstraint(ConstrainedPoints):
    """The n points of a surface that soil can touch in a step, ordered by cell.

    Attributes:
        boundary: the surface.
        touch: their contact at the start of the step.
        measured: gaps as measured [length], shape (n,).
        law: of each point.
        turn: rotations of what is carried to the middle of the step, shape (n, dim, dim).
        at_end: which are in the strip along an end of the soil's face, shape (n,).
        multiplier: of each point, shape (n,); empty before they are selected.
    """

    boundary: CarriedContact
    touch: Touch
    trace: Trace
    measured: Floats
    law: ContactLaw
    turn: Floats
    at_end: Flags
    multiplier: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    @property
    def constrained_directions(self) -> Floats:
        """The direction for which the patches are selected, the normal, shape (1, n, dim)."""
        return self.pose.normal[None]

    @property
    def touches(self) -> bool:
        """Whether soil touches it at the start of the step."""
        near = self.touch.gap <= NEAR * self.boundary.cell
        return bool((self.touch.closed | near).any())

    @cached_property
    def before(self) -> Floats:
        """Tractions from the last step, turned to this step's middle [stress], shape (n, dim)."""
        dim = self.pose.position.shape[1]
        carried = self.boundary.carried[self.chosen, :dim]
        return np.asarray(np.einsum("nij,nj->ni", self.turn, carried))

    @property
    def pore_pressure(self) -> Floats:
        """Excess pore pressure at the end of the last step [stress], shape (n,)."""
        dim = self.pose.position.shape[1]
        return np.asarray(self.boundary.carried[self.chosen, dim + PORE_PRESSURE])

    @cached_property
    def stiffness(self) -> Floats:
        """e_n and e_t of the points [stress/length], shape (n, 2)."""
        return self.square[:, None] * self.moduli

    def surface_motion(self, displacement: Floats) -> Floats:
        """Returns what of the surface's motion is a displacement of nodes [length], (n, dim).

        None here: the surface is rigid.
        """
        return np.zeros_like(self.pose.position)

    def in_cells(self) -> list[ContactConstraint]:
        """Returns its points in the cells of the soil that they act on."""
        return [self]

    def with_multiplier(self, multiplier: Integers, overlay: Integers) -> ContactConstraint:
        """Returns the same with the multiplier of each point, shape (n,).

        Small patches join their neighbours on soil of the same overlay; slivers without
        neighbours have no weight.

        overlay: of the nodes, shape (nodes,).
        """
        pose, size = self.pose, self.at.size[self.at.cell]
        own = overlay[self.at.node[:, 0]][self.at.cell]
        multiplier = np.unique(2 * multiplier + self.at_end, return_inverse=True)[1]
        joined = multiplier.copy()
        for number in np.unique(own):
            of = own == number
            first = int(multiplier[of].min())
            joined[of] = first + without_small(
                multiplier[of] - first, pose.position[of], pose.normal[of], self.area[of], size[of],
                self.at_end[of],
            )  # fmt: skip
        joined = np.unique(joined, return_inverse=True)[1]
        sliver = is_sliver(joined, self.area, size)
        pose = replace(pose, weight=np.where(sliver, 0.0, pose.weight))
        return replace(self, multiplier=joined, pose=pose)

    @property
    def area(self) -> Floats:
        """Area of each point's part that can touch soil [length^(dim - 1)], shape (n,)."""
        if not self.axisymmetric:
            return self.pose.weight
        return self.pose.weight / (2.0 * np.pi * np.abs(self.pose.position[:, 0]))

    def at_hole(self, holes: Flags, touching: Flags) -> Integers:
        """Returns those of the points `holes`, (n,), that points `touching`, (n,), surround."""
        found = np.flatnonzero(holes)
        if len(found) == 0 or not touching.any():
            return found[:0]
        reach = SURROUNDING * self.boundary.cell
        return found[surrounded(self.pose.position[found], self.pose.position[touching], reach)]

    def of(self, kept: Flags) -> ContactConstraint:
        """Returns the same with only the points `kept`, (n,), before multipliers are chosen."""
        return replace(
            self,
            chosen=self.chosen[kept],
            at=self.at.of(kept),
            pose=self.pose.of(kept),
            moduli=self.moduli[kept],
            elastic_share=self.elastic_share[kept],
            touch=self.touch.of(np.flatnonzero(kept)),
            trace=self.trace.of(kept),
            measured=self.measured[kept],
            law=self.law.of(kept),
            square=self.square[kept],
            turn=self.turn[kept],
            at_end=self.at_end[kept],
        )

    def store(self, traction: Floats, closed: Flags, gap: Floats, pore_pressure: Floats) -> None:
        """Stores the state of points at the end of a step, see `CarriedContact.store`."""
        reference = np.einsum("nji,nj->ni", self.turn, traction)
        self.boundary.store(
            self.chosen, reference, closed, self.measured, self.touch, gap, pore_pressure
        )
