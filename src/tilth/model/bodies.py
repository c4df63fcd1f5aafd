# SPDX-License-Identifier: BSD-3-Clause
"""A body: shape, material, basis and subdivision into material points."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import CellName, CountPerDirection, CountVector, Name, PositivePerDirection
from tilth.model.problems import rejection
from tilth.model.shapes import Shape
from tilth.model.surface import Surface

DomainUpdate = Literal[
    "fixed", "determinant", "deformation_gradient", "right_stretch", "left_stretch", "corners"
]


_NO_RULE_TO_CHOOSE = {
    "linear": "points of the linear basis have no domains",
    "cpdi1": "the domains of cpdi1 always follow the deformation gradient",
    "cpdi2": "the corners of cpdi2's domains always move with the grid",
}


class Body(Declared):
    """A body of one material; exactly one of points_per_cell, points and spacing subdivides it."""

    name: CellName
    """Name of the body, unique."""
    material: Name
    """Name of its material, as declared in `materials`."""
    shape: Shape
    """Shape in the undeformed state."""
    basis: Literal["linear", "gimp", "cpdi1", "cpdi2"]
    """Basis functions of its points: "linear" (standard MPM), "gimp", "cpdi1" or "cpdi2".

    The domains of "cpdi1" are parallelograms that deform with F, those of "cpdi2" quadrilaterals
    whose corners move with the grid; in 3D parallelepipeds and hexahedra.
    """
    domain_update: DomainUpdate | None = None
    """Rule for updating the domains of "gimp" points; "right_stretch" if not given.

    Not for the other bases: linear points have no domain, and cpdi has its own rule.
    """
    anti_locking: Literal["none", "f_bar"] = "none"
    """Remedy against volumetric locking: "none" or "f_bar" (the volumetric part of the deformation
    of all points in a cell is that at the centre of their material).
    """
    points_per_cell: CountPerDirection | None = None
    """Material points per grid cell and direction: one number, or one per direction."""
    points: CountVector | None = None
    """Material points of a box along each of its own (rotated) axes, shape (dimension,)."""
    spacing: PositivePerDirection | None = None
    """Distance between material points [length] along the body's own axes, > 0."""
    surface: Surface | None = None
    """Tracked boundary points on its surface; none if not given."""

    @model_validator(mode="before")
    @classmethod
    def _gimp_follows_the_right_stretch(cls, entries: Any) -> Any:
        if isinstance(entries, dict) and entries.get("basis") == "gimp":
            return {"domain_update": "right_stretch", **entries}
        return entries

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        problems = []
        ways = ("points_per_cell", "points", "spacing")
        given = [way for way in ways if getattr(self, way) is not None]
        if len(given) != 1:
            what = f"{' and '.join(given)} given together" if given else "missing"
            remedy = "give exactly one of `points_per_cell`, `points` and `spacing`"
            problems.append(Problem(given[-1] if given else ways[0], what, remedy))
        elif self.points is not None and not self.shape.has_own_axes:
            remedy = "give `points_per_cell` or `spacing` instead"
            problems.append(Problem("points", "is for a box only", remedy, self.points))
        if self.basis != "gimp" and self.domain_update is not None:
            remedy = 'leave it out, or choose basis = "gimp"'
            what = _NO_RULE_TO_CHOOSE[self.basis]
            problems.append(Problem("domain_update", what, remedy, self.domain_update))
        if self.basis == "gimp" and self.domain_update is None:
            remedy = "leave the key out for right_stretch"
            problems.append(Problem("domain_update", "gimp needs a rule", remedy, None))
        if problems:
            raise rejection(problems)
        return self
