# SPDX-License-Identifier: BSD-3-Clause
"""Contact at one displacement: what `AssembledContact.forces` finds, and later calls use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.contact.law import ContactResponse
from tilth.boundaries.contact.patches import Patches
from tilth.mpm.pattern import Elements


@dataclass(frozen=True)
class Evaluated:
    """The response of a surface at one displacement.

    Attributes:
        slip: mean gaps and slips of its multipliers [length], shape (m, dim).
        pore_pressure: mean excess pore pressures beside them [stress], shape (m,).
        response: to all of them.
        moved: displacement of its points in the step [length], shape (n, dim).
    """

    slip: Floats
    pore_pressure: Floats
    response: ContactResponse
    moved: Floats


Part = tuple[Patches, Elements, Evaluated]
"""A surface, the positions of its blocks in the matrix, and its response."""


@dataclass(frozen=True)
class Evaluation:
    """All surfaces of a term at one displacement.

    Attributes:
        surfaces: the response of each.
        unknowns: free components of the rigid body's motion in the step, shape (m,).
        holds_one: whether all multipliers have opened, but for one that is kept closed.
    """

    surfaces: Sequence[Evaluated]
    unknowns: Floats
    holds_one: bool = False

    def holding(self, patches: Sequence[Patches]) -> Evaluation:
        """Returns the same with the multiplier of the least tension closed if all have opened.

        Without contact nothing but springs would hold a free body: it would be lost in one
        iteration, or jump from side to side.

        patches: those of the surfaces.
        """
        best, least = None, np.inf
        for i, (patch, each) in enumerate(zip(patches, self.surfaces, strict=True)):
            present = patch.area > 0.0
            if (each.response.closed & present).any():
                return self
            tension = np.where(present, patch.trial(each.slip)[:, 0], np.inf)
            if tension.min(initial=np.inf) < least:
                best, least = (i, int(tension.argmin())), float(tension.min())
        if best is None:
            return self
        number, multiplier = best
        patch, surfaces = patches[number], list(self.surfaces)
        held = np.arange(patch.count) == multiplier
        response = patch.respond(surfaces[number].slip, surfaces[number].pore_pressure, held)
        surfaces[number] = replace(surfaces[number], response=response)
        return Evaluation(surfaces, self.unknowns, holds_one=True)
