# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies: shapes with one motion, each component prescribed or free, and a law of contact."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.contact import Contact
from tilth.model.fields import (
    AXES,
    AngularVelocity,
    AsTuple,
    Axis,
    CellName,
    NumberOrTable,
    NumberOrTablePerAxis,
    Positive,
    PositivePerDirection,
    Table,
    Vector,
    some,
    starts_from_zero,
)
from tilth.model.geometry import Geometry
from tilth.model.implicit import Contacts
from tilth.model.load_curve import LoadCurve
from tilth.model.problems import rejection

Component = Literal["x", "y", "z", "rotation", "rotation_x", "rotation_y", "rotation_z"]
"""A component of a rigid body's motion: a displacement or a rotation."""

TablesByAxis = Annotated[Mapping[Axis, NumberOrTable], AfterValidator(some)]
Springs = Annotated[Mapping[Component, Positive], AfterValidator(some)]
GeometryList = Annotated[Sequence[Geometry], AsTuple, AfterValidator(some)]

_ROTATION = "rotation"


class RigidBody(Declared):
    """A rigid body in contact with soil: its components of motion are prescribed or free.

    A component that `displacement` or `rotation` names is prescribed; the others are free, and the
    force of the soil is in equilibrium there with `force`, `moment`, the weight and `springs`.
    Forces are per unit length in plane strain, per full circle in axisymmetry, where y is the only
    component.
    """

    name: CellName
    """Name of the body, unique, also among boundaries."""
    geometry: Geometry | None = None
    """Its shape at time 0, and the side of the soil."""
    geometries: GeometryList | None = None
    """Instead of `geometry`: several shapes that are one body; what of one lies inside another has
    no contact.
    """
    contact: Contact
    """Law of its contact with soil."""
    contact_with: Contacts | None = None
    """Another law for soil bodies, by their names."""
    wished_in_place: bool = False
    """Whether the body is in the soil from the start, as if it had always been there: soil within
    a quarter of a cell touches it then, however its material points lie beside the surface.
    """
    centre: Vector
    """Reference point of rotation, moment and weight at time 0 [length], shape (dimension,): for a
    body with a mass the centre of mass.
    """
    displacement: TablesByAxis | None = None
    """Prescribed components of the displacement of the centre [length]: numbers, which `factor`
    multiplies, or rows (time, value). What is not named is free.
    """
    rotation: NumberOrTablePerAxis | None = None
    """Prescribed rotation about the centre [degrees], anticlockwise: a number, which `factor`
    multiplies, or rows (time, value). In 3D components x, y, z of the rotation vector; what is not
    named is free. At most 90 degrees in a step of the schedule.
    """
    factor: Table | None = None
    """Rows (time, factor) of all numbers in `displacement` and `rotation`, first factor 0; 0 to 1
    over the schedule if not given.
    """
    force: TablesByAxis | None = None
    """Force on the body at its centre [force], on free components: numbers, which `force_factor`
    multiplies, or rows (time, value).
    """
    moment: NumberOrTablePerAxis | None = None
    """Moment on the body about its centre [force length], on a free rotation: as `force`; in 3D
    components x, y, z.
    """
    force_factor: Table | None = None
    """Rows (time, factor) of all numbers in `force` and `moment`; 0 to 1 over the schedule if not
    given.
    """
    mass: Positive | None = None
    """Mass [mass], > 0: its weight is the mass times the acceleration of the body forces."""
    moments_of_inertia: PositivePerDirection | None = None
    """Moment of inertia about the centre [mass length^2], > 0, in 3D three principal ones about the
    axes at time 0; needed by a free rotation with `analysis.inertia`, without effect otherwise.
    """
    velocity: Vector | None = None
    """Velocity of the centre at the start [length/time], shape (dimension,), of free components;
    with `analysis.inertia` only."""
    angular_velocity: AngularVelocity | None = None
    """Angular velocity at the start [radians/time], of a free rotation: a number in 2D, positive
    anticlockwise; a vector in 3D. With `analysis.inertia` only."""
    springs: Springs | None = None
    """Springs between the body and the ground on free components [force/length; moment/rad], > 0,
    by component: x, y, z, rotation, in 3D rotation_x, rotation_y, rotation_z.
    """

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        problems = [*self._shape_problems(), *self._motion_problems(), *self._force_problems()]
        if problems:
            raise rejection(problems)
        return self

    @property
    def shapes(self) -> tuple[Geometry, ...]:
        """Its shapes at time 0."""
        return (self.geometry,) if self.geometry is not None else tuple(self.geometries or ())

    @property
    def has_motion_numbers(self) -> bool:
        """Whether `factor` has something to multiply."""
        given = [*_entries("", self.displacement), *_entries("", self.rotation)]
        return any(isinstance(entry, float) for _, entry in given)

    @property
    def has_force_numbers(self) -> bool:
        """Whether `force_factor` has something to multiply."""
        given = [*_entries("", self.force), *_entries("", self.moment)]
        return any(isinstance(entry, float) for _, entry in given)

    @staticmethod
    def components(dimension: int, kind: str) -> tuple[Component, ...]:
        """Returns the components of motion that exist in an analysis of this dimension and kind."""
        if kind == "axisymmetric":
            return ("y",)
        if dimension == 2:
            return ("x", "y", "rotation")
        return ("x", "y", "z", "rotation_x", "rotation_y", "rotation_z")

    def is_prescribed(self, component: Component) -> bool:
        """Whether a component of the motion is prescribed."""
        return _entry(component, self.displacement, self.rotation) is not None

    def prescribed(self, component: Component, time: float, end: float) -> float | None:
        """Returns a component of the motion [length or rad] if it is prescribed, None if free.

        Args:
            component: one of `components`.
            time: of the schedule, in a stage that of the stage.
            end: of the same schedule; the default factor is 1 there.
        """
        entry = _entry(component, self.displacement, self.rotation)
        if entry is None:
            return None
        value = _value(entry, self.factor, time, end)
        return math.radians(value) if component.startswith(_ROTATION) else value

    def applied(self, component: Component, time: float, end: float) -> float:
        """Returns the force or moment on a free component, without weight; 0 if none is declared.

        Args: as `prescribed`.
        """
        entry = _entry(component, self.force, self.moment)
        return 0.0 if entry is None else _value(entry, self.force_factor, time, end)

    def is_loaded(self, component: Component) -> bool:
        """Whether a force or moment on a component is declared, which may be 0."""
        return self._applied_entry(component) is not None

    def spring(self, component: Component) -> float:
        """Returns the stiffness to ground [force/length or moment/rad]; 0 if there is none."""
        return (self.springs or {}).get(component, 0.0)

    def _shape_problems(self) -> Iterator[Problem]:
        if self.geometry is None and self.geometries is None:
            remedy = "give the shape, or several in `geometries`"
            yield Problem("geometry", "missing", remedy)
        elif self.geometry is not None and self.geometries is not None:
            yield Problem("geometries", "given together with `geometry`", "leave one of them out")

    def _motion_problems(self) -> Iterator[Problem]:
        yield from starts_from_zero(self.factor)
        given = [*_entries("displacement", self.displacement), *_entries("rotation", self.rotation)]
        for key, entry in given:
            if isinstance(entry, Sequence) and entry[0][1] != 0.0:
                what = "a motion starts from the position at time 0, so its first value must be 0"
                yield Problem(key, what, "start the table with [0, 0]", entry)
        if self.factor is not None and not self.has_motion_numbers:
            yield _nothing_to_multiply("factor", self.factor, "`displacement` or `rotation`")

    def _force_problems(self) -> Iterator[Problem]:
        if self.force_factor is not None and not self.has_force_numbers:
            yield _nothing_to_multiply("force_factor", self.force_factor, "`force` or `moment`")
        for component in _ALL_COMPONENTS:
            motion = _key(component, "displacement", "rotation", self.rotation)
            for key, value in (
                (_key(component, "force", "moment", self.moment), self._applied_entry(component)),
                (f"springs.{component}", (self.springs or {}).get(component)),
            ):
                if value is not None and self.is_prescribed(component):
                    what = f"acts on a component that `{motion}` prescribes"
                    remedy = f"leave out one of `{key}` and `{motion}`: a motion or a force"
                    yield Problem(key, what, remedy, value)

    def _applied_entry(self, component: Component) -> Any:
        return _entry(component, self.force, self.moment)


_ALL_COMPONENTS: tuple[Component, ...] = (
    "x", "y", "z", "rotation", "rotation_x", "rotation_y", "rotation_z",
)  # fmt: skip


def _entry(component: str, by_axis: Mapping[Axis, Any] | None, turning: Any) -> Any:
    """Returns the number or table of a component; None where there is none."""
    if component in AXES:
        return (by_axis or {}).get(component)
    if isinstance(turning, Mapping):
        return turning.get(component.removeprefix(f"{_ROTATION}_"))
    return turning if component == _ROTATION else None


def _key(component: str, by_axis: str, turning: str, entry: Any) -> str:
    """Returns the key of a component, such as `force.y`, `rotation` or `rotation.x`."""
    if component in AXES:
        return f"{by_axis}.{component}"
    axis = component.removeprefix(f"{_ROTATION}_")
    return f"{turning}.{axis}" if isinstance(entry, Mapping) else turning


def _entries(key: str, entry: Any) -> Iterator[tuple[str, Any]]:
    """Yields the numbers and tables of an entry, with their keys."""
    if isinstance(entry, Mapping):
        for axis, value in entry.items():
            yield f"{key}.{axis}", value
    elif entry is not None:
        yield key, entry


def _value(entry: Any, factor: Any, time: float, end: float) -> float:
    """Returns the value of a number or table at a time of a schedule that ends at `end`."""
    if isinstance(entry, Sequence):
        return LoadCurve(entry).factor(time)
    return float(entry) * LoadCurve(factor or ((0.0, 0.0), (end, 1.0))).factor(time)


def _nothing_to_multiply(key: str, table: Any, keys: str) -> Problem:
    what = "there is no number to multiply; rows (time, value) are taken as they are"
    return Problem(key, what, f"give a number in {keys}, or leave it out", table)
