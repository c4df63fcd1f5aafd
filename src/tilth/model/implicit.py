# SPDX-License-Identifier: BSD-3-Clause
"""Implicit boundaries: a geometry independent of the grid, its motion and its condition."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.contact import Contact
from tilth.model.fields import (
    Angle,
    Axis,
    CellName,
    Direction,
    Displacement,
    Name,
    PythonFunction,
    Real,
    Share,
    Table,
    Vector,
    some,
    starts_from_zero,
)
from tilth.model.geometry import Geometry
from tilth.model.ground_motion import Ground, GroundAcceleration
from tilth.model.problems import rejection

Contacts = Annotated[Mapping[Name, Contact], AfterValidator(some)]
"""Laws of contact by the names of soil bodies."""

_GIVEN = ("displacement", "rotation", "radius_change", "volume_loss")


class Rotation(Declared):
    """Rotation of an implicit boundary about a point or an axis; not in axisymmetry."""

    angle: Angle
    """Angle at factor 1 [degrees], anticlockwise; in 3D by the right-hand rule about the axis. At
    most 90 degrees in a step of the schedule."""
    centre: Vector
    """Centre of the rotation [length], shape (dimension,)."""
    axis: Axis | None = None
    """Direction of the axis through `centre`; only in 3D, where it is required."""


class ImplicitBoundary(Declared):
    """Condition on a boundary at any position in the grid, by the implicit boundary method.

    The boundary may move: at the factor f its radius is increased by f `radius_change`, or its area
    reduced by the share f `volume_loss`, then it is rotated by f times the angle of `rotation`,
    then translated by f `displacement`. Alternatively a function gives its `motion`. The
    constrained components have the displacement of the boundary; without any of these keys it does
    not move.
    """

    type: Literal["implicit"] = "implicit"
    name: CellName
    """Name of the boundary, unique."""
    geometry: Geometry
    """Its position at time 0, and the side of the soil."""
    condition: Literal["roller", "fixed", "tangential", "direction", "absorbing"] | None = None
    """Constrained displacement components: "roller" the normal one, "fixed" all, "tangential" all
    but the normal one, "direction" the one along `direction`. It holds the soil both ways. With
    inertia "absorbing": waves leave through it. Required without `contact`.
    """
    acceleration: GroundAcceleration | None = None
    """With condition "absorbing": acceleration of the outcrop of the ground beyond, whose waves
    come in through it.
    """
    ground: Ground | None = None
    """With "absorbing": the ground beyond; the soil at the boundary goes on if not given."""
    contact: Contact | None = None
    """Instead of `condition`: the law by which soil separates from the boundary and slides on it.
    """
    contact_with: Contacts | None = None
    """With `contact`: another law for soil bodies, by their names."""
    wished_in_place: bool = False
    """With `contact`: whether the soil touches the boundary from the start, within a quarter of a
    cell, however its material points lie beside it.
    """
    direction: Direction | None = None
    """With condition "direction": shape (dimension,), of any length; rotates with the boundary."""
    delta: Real | None = None
    """Width of the band in which the condition acts [length], > 0 and at most half the smallest
    edge of a cell; a thousandth of that edge if not given.
    """
    form: Literal["surface", "band"] = "surface"
    """Form of the boundary terms: "surface" (the limit of a narrow band) or "band" (all three parts
    of the stiffness, integrated over the band). "band" constrains every quadrature point, which
    makes the soil too stiff beside boundaries that are oblique to the grid.
    """
    displacement: Displacement | None = None
    """Translation at factor 1 [length]; components not named are zero."""
    rotation: Rotation | None = None
    """Rotation at factor 1."""
    radius_change: Real | None = None
    """Increase of the radius of a circle, cylinder or sphere at factor 1 [length]."""
    volume_loss: Share | None = None
    """Instead of `radius_change`: share of the area of a circle, of the section of a cylinder or of
    the volume of a sphere that is lost at factor 1 [-], as at a tunnel; not in axisymmetry.
    """
    motion: PythonFunction | None = None
    """Instead of these four, a function as "file.py:name", the file relative to the case file. Its
    arguments are points at time 0, shape (n, dimension), and the factor; it returns their
    displacements [length], shape (n, dimension). The file is run: use only one that you trust.
    """
    factor: Table | None = None
    """Rows (time, factor) of the motion, first factor 0; 0 to 1 over the schedule if not given."""

    @classmethod
    def required_keys(cls, given: Mapping[str, Any]) -> set[str]:
        """As `Declared.required_keys`: a condition, unless there is a law of contact."""
        keys = super().required_keys(given)
        return keys if given.get("contact") is not None else keys | {"condition"}

    @property
    def kind(self) -> str:
        """Its condition, or "contact"."""
        return self.condition or "contact"

    @property
    def is_moving(self) -> bool:
        """Whether a motion is given."""
        return any(getattr(self, key) is not None for key in (*_GIVEN, "motion"))

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        problems = [*self._contact_problems(), *self._motion_problems()]
        if self.contact is None:
            problems += self._direction_problems()
        problems += [*starts_from_zero(self.factor), *ground_problems(self)]
        if self.condition == "absorbing" and (self.is_moving or self.form == "band"):
            key = "form" if self.form == "band" else "condition"
            what = 'an absorbing boundary does not move, and has no form = "band"'
            problems.append(Problem(key, what, "leave out its motion and `form`"))
        if problems:
            raise rejection(problems)
        return self

    def radius(self, factor: float) -> float:
        """Returns the radius at a factor of the motion [length], of a geometry that has one."""
        at_rest = self.geometry.radius_at_rest
        assert at_rest is not None
        if self.volume_loss is None:
            return at_rest + factor * (self.radius_change or 0.0)
        kept = max(1.0 - factor * self.volume_loss, 0.0)
        return at_rest * (math.cbrt(kept) if self.geometry.type == "sphere" else math.sqrt(kept))

    def _contact_problems(self) -> Iterator[Problem]:
        if self.contact is None:
            if self.wished_in_place:
                remedy = "give `contact`, or leave it out"
                yield Problem("wished_in_place", "has no meaning without `contact`", remedy)
            if self.condition is None:
                remedy = 'give the constrained components, such as condition = "roller"'
                yield Problem("condition", "missing", remedy)
            if self.contact_with is not None:
                remedy = "give `contact`, the law for the other soil bodies, or leave it out"
                yield Problem("contact_with", "has no meaning without `contact`", remedy)
            return
        if self.condition is not None:
            what = "given together with `contact`, which holds the soil otherwise"
            yield Problem("condition", what, "leave one of them out", self.condition)
        if self.direction is not None:
            what = "has no meaning with `contact`"
            yield Problem("direction", what, "leave it out", self.direction)
        if self.form == "band":
            what = "has no meaning with `contact`, which acts on the surface"
            yield Problem("form", what, "leave it out", self.form)

    def _direction_problems(self) -> Iterator[Problem]:
        if self.condition == "direction" and self.direction is None:
            remedy = "give the direction of the constrained component, such as direction = [1, 1]"
            yield Problem("direction", "missing", remedy)
        if self.condition != "direction" and self.direction is not None:
            what = f'has no meaning with condition = "{self.condition}"'
            yield Problem("direction", what, 'choose condition = "direction"', self.direction)

    def _motion_problems(self) -> Iterator[Problem]:
        given = [key for key in _GIVEN if getattr(self, key) is not None]
        if self.motion is not None and given:
            what = f"given together with {' and '.join(f'`{key}`' for key in given)}"
            yield Problem("motion", what, "leave one of them out", self.motion)
        if self.factor is not None and not self.is_moving:
            keys = ", ".join(f"`{key}`" for key in _GIVEN)
            remedy = f"give one of {keys} or `motion`, or leave it out"
            yield Problem("factor", "there is nothing to scale", remedy, self.factor)
        changes = [key for key in ("radius_change", "volume_loss") if key in given]
        if len(changes) == 2:
            what = "given together with `radius_change`, and both determine the radius"
            yield Problem("volume_loss", what, "leave one of them out", self.volume_loss)
        elif changes:
            yield from self._radius_problems(changes[0])

    def _radius_problems(self, key: str) -> Iterator[Problem]:
        """What is wrong with the radius that the entry `key` changes."""
        value = getattr(self, key)
        at_rest = self.geometry.radius_at_rest
        if at_rest is None:
            what = f'a geometry of type = "{self.geometry.type}" has no radius'
            yield Problem(key, what, "leave it out: it is for a circle, cylinder or sphere", value)
            return
        factors = [0.0, 1.0] if self.factor is None else [row[1] for row in self.factor]
        radius, factor = min((self.radius(f), f) for f in factors)
        if radius <= 0.0:
            what = f"the radius {at_rest:g} becomes {radius:g} at factor {factor:g}"
            yield Problem(key, what, "keep the radius above 0", value)


def ground_problems(boundary: Any) -> Iterator[Problem]:
    """Yields entries of the ground beyond a boundary that its condition does not use."""
    condition = boundary.condition
    for key, of in (("acceleration", ("base_motion", "absorbing")), ("ground", ("absorbing",))):
        if (value := getattr(boundary, key)) is not None and condition not in of:
            what = f'has no meaning with condition = "{condition}"'
            yield Problem(key, what, "leave it out", value)
    if condition == "base_motion" and boundary.acceleration is None:
        remedy = 'give a record, such as acceleration = { file = "record.csv" }'
        yield Problem("acceleration", "missing", remedy)
