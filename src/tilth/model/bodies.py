# SPDX-License-Identifier: BSD-3-Clause
"""A body: shape, material, basis and subdivision into material points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal

from pydantic import model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import (
    AsTuple,
    CellName,
    CountPerDirection,
    CountVector,
    Entries,
    Name,
    PositivePerDirection,
)
from tilth.model.problems import rejection
from tilth.model.shapes import Shape
from tilth.model.surface import Surface
from tilth.model.variation import Level

DomainUpdate = Literal[
    "fixed", "determinant", "deformation_gradient", "right_stretch", "left_stretch", "corners"
]


_NO_RULE_TO_CHOOSE = {
    "linear": "points of the linear basis have no domains",
    "cpdi1": "the domains of cpdi1 always follow the deformation gradient",
    "cpdi2": "the corners of cpdi2's domains always move with the grid",
}


class Layer(Declared):
    """A layer of a body: the material above a horizon, or in a physical group of its mesh."""

    material: Name
    """Name of its material, as declared in `materials`."""
    bottom: Level | None = None
    """Elevation of its lower horizon [length]: a number, in 2D also a polyline of rows
    (x, elevation), or { file = "horizon.csv" } with a grid over the horizontal axes. Not for the
    lowest layer.
    """
    group: Name | None = None
    """Name of the physical group of a Gmsh mesh that it consists of, instead of `bottom`."""


Layers = Annotated[Sequence[Layer], Entries, AsTuple]


class Body(Declared):
    """A body of one material or of layers; one of points_per_cell, points and spacing divides it.

    Layers are either listed from the top down, each but the last with its `bottom`, or each names
    a physical `group` of a mesh. Every layer must have material points.
    """

    name: CellName
    """Name of the body, unique."""
    material: Name | None = None
    """Name of its material, as declared in `materials`; not for a body with layers."""
    layers: Layers = ()
    """Its layers, in sections [[bodies.layers]] below the body; none if it has one material."""
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
    """Material points per grid cell and direction: one number, or one per direction. On a graded
    grid their distances follow the cells."""
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
        problems += _layer_problems(self)
        if problems:
            raise rejection(problems)
        return self

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of its materials: that of each layer, or the only one."""
        return tuple(layer.material for layer in self.layers) or (self.material or "",)

    def material_keys(self) -> tuple[str, ...]:
        """Returns the keys of these names, relative to the body."""
        found = tuple(f"layers[{i}].material" for i in range(len(self.layers)))
        return found or ("material",)


def _layer_problems(body: Body) -> Iterator[Problem]:
    """What is wrong with the material or the layers of a body."""
    if (body.material is None) != bool(body.layers):
        given = body.material is not None
        what = "given together with `layers`" if given else "missing"
        remedy = "give a body either one `material`, or `layers` with a material each"
        yield Problem("material", what, remedy, *([body.material] if given else []))
    grouped = [layer.group is not None for layer in body.layers]
    last = len(body.layers) - 1
    if any(grouped) and not body.shape.has_groups:
        key, remedy = f"layers[{grouped.index(True)}].group", "give a `bottom` instead"
        yield Problem(key, "is for a body whose shape is a mesh", remedy)
        return
    for i, layer in enumerate(body.layers):
        key = f"layers[{i}]"
        if any(grouped):
            if layer.group is None:
                remedy = "give each layer of the body a `group`, or each but the last a `bottom`"
                yield Problem(f"{key}.group", "missing, but another layer has one", remedy)
            elif layer.group in (other.group for other in body.layers[:i]):
                yield Problem(f"{key}.group", "is already that of a layer", "", layer.group)
            if layer.bottom is not None:
                what = "has no meaning in a body whose layers are groups of a mesh"
                yield Problem(f"{key}.bottom", what, "leave it out")
        elif layer.bottom is None and i < last:
            remedy = "give the elevation of its lower horizon; layers are listed from the top down"
            yield Problem(f"{key}.bottom", "missing", remedy)
        elif layer.bottom is not None and i == last:
            remedy = "leave it out: the lowest layer ends with the body"
            yield Problem(f"{key}.bottom", "the lowest layer has no horizon below it", remedy)
