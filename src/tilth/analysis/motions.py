# SPDX-License-Identifier: BSD-3-Clause
"""Motion and reaction of what moves, and force between bodies, after each step: boundaries.csv.

A motion that is a translation and a rotation has their amounts at the end of the step, whatever the
soil does. Forces and moments are those on the soil. While a boundary does not act in a stage, its
displacement is "not a number" and its force 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Protocol, cast

import numpy as np

from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.geometry.protocol import RoundGeometry
from tilth.model import (
    AffineBoundary,
    ImplicitBoundary,
    Model,
    NodeBoundary,
    PlaneBoundary,
    RigidBody,
)
from tilth.model.fields import AXES
from tilth.model.staging import moves

Column = tuple[str, str]
"""Name and unit label of a column."""


def motion_columns(model: Model) -> list[Column]:
    """Returns the names and unit labels of the columns of boundaries.csv, if it has any."""
    return [
        (f"{part.name} {quantity}", unit)
        for part in _parts(model)
        for quantity, unit in part.columns(model)
    ]


def motion_values(
    model: Model, setup: Setup, state: State, result: StepResult | None
) -> list[float]:
    """Returns the values of the columns after a step (`result` None: before the first one).

    model: the whole model. setup: of the present stage.
    """
    return [value for part in _parts(model) for value in part.values(setup, state, result)]


class _Part(Protocol):
    """The columns of one boundary, and their values."""

    name: str

    def columns(self, model: Model) -> list[Column]:
        """Returns names, without that of the boundary, and unit labels."""
        ...

    def values(self, setup: Setup, state: State, result: StepResult | None) -> list[float]:
        """Returns the values, as `motion_values`."""
        ...


def _parts(model: Model) -> Iterator[_Part]:
    """Yields what has columns; not an affine motion, which has no displacement of its own."""
    for boundary in model.boundaries:
        if not moves(boundary) or isinstance(boundary, AffineBoundary):
            continue
        if isinstance(boundary, ImplicitBoundary):
            yield _OfImplicit(boundary, model.dimension)
        else:
            yield _OfNodes(boundary, model.dimension)
    for body in model.rigid_bodies:
        yield _OfBody(body, model)
    for pair in model.contact_pairs:
        yield _OfPair(pair.name, model)


def force_unit(model: Model) -> str:
    """Returns the label of a force, per length in plane strain."""
    units = model.units
    per_length = f"/{units.length}" if model.analysis.kind == "plane_strain" else ""
    return units.force + per_length


def moment_unit(model: Model) -> str:
    """Returns the label of a moment or energy, per length in plane strain."""
    units = model.units
    per_length = f"/{units.length}" if model.analysis.kind == "plane_strain" else ""
    return f"{units.force} {units.length}{per_length}"


def _time(result: StepResult | None) -> float:
    return 0.0 if result is None else result.time


def area_unit(model: Model) -> str:
    """Returns the label of an area in contact, per length in plane strain."""
    length = model.units.length
    per_length = f"/{length}" if model.analysis.kind == "plane_strain" else ""
    return f"{length}^2{per_length}" if length else ""


class _OfNodes:
    """A prescribed grid plane or node: displacement and force along the prescribed components."""

    def __init__(self, declared: PlaneBoundary | NodeBoundary, dim: int) -> None:
        self.name = declared.name
        self._prescribed = declared.prescribed(dim)

    def columns(self, model: Model) -> list[Column]:
        """As `_Part.columns`."""
        axes = [AXES[i] for i in self._prescribed]
        return [
            *((f"displacement_{axis}", model.units.length) for axis in axes),
            *((f"force_{axis}", force_unit(model)) for axis in axes),
        ]

    def values(self, setup: Setup, state: State, result: StepResult | None) -> list[float]:
        """As `_Part.values`."""
        count = len(self._prescribed)
        acting = next((b for b in setup.model.boundaries if b.name == self.name), None)
        if acting is None:
            return [math.nan] * count + [0.0] * count
        factor = setup.model.load_curve(acting).factor(_time(result))
        force = np.zeros(3) if result is None else result.resultant(self.name)
        return [
            *(factor * value for value in self._prescribed.values()),
            *(float(force[i]) for i in self._prescribed),
        ]


class _OfBody:
    """A rigid body: displacement of its centre, rotation vector, force and moment on the soil.

    The moment is about the centre where it is. While a body is not there in a stage, its motion is
    "not a number" and its force 0.
    """

    def __init__(self, declared: RigidBody, model: Model) -> None:
        self.name = declared.name
        self._dim = model.dimension
        components = RigidBody.components(model.dimension, model.analysis.kind)
        self._axes = [AXES.index(c) for c in components if c in AXES]
        turning = [c.removeprefix("rotation_") for c in components if c not in AXES]
        self._turning = [2 if c == "rotation" else AXES.index(c) for c in turning]

    def columns(self, model: Model) -> list[Column]:
        """As `_Part.columns`."""
        length = model.units.length
        axes, turning = [AXES[i] for i in self._axes], [AXES[i] for i in self._turning]
        return [
            *((f"displacement_{axis}", length) for axis in axes),
            *((f"force_{axis}", force_unit(model)) for axis in axes),
            *((f"rotation_{axis}", "degrees") for axis in turning),
            *((f"moment_{axis}", moment_unit(model)) for axis in turning),
        ]

    def values(self, setup: Setup, state: State, result: StepResult | None) -> list[float]:
        """As `_Part.values`."""
        count, body = len(self._axes), state.rigid_bodies.get(self.name)
        if all(each.name != self.name for each in setup.model.rigid_bodies):
            turning = len(self._turning)
            return [math.nan] * count + [0.0] * count + [math.nan] * turning + [0.0] * turning
        if body is None:
            return [0.0] * (2 * count + 2 * len(self._turning))
        return [
            *(float(body.displacement[i]) for i in self._axes),
            *(0.0 - float(body.force[i]) for i in self._axes),
            *(math.degrees(body.rotation[i]) for i in self._turning),
            *(0.0 - float(body.moment[i]) for i in self._turning),
        ]


class _OfPair:
    """Contact between two soil bodies: force on the second one, and area in contact."""

    def __init__(self, name: str, model: Model) -> None:
        self.name = name
        self._axes = AXES[: model.dimension]

    def columns(self, model: Model) -> list[Column]:
        """As `_Part.columns`."""
        forces = [(f"force_{axis}", force_unit(model)) for axis in self._axes]
        return [*forces, ("contact_area", area_unit(model))]

    def values(self, setup: Setup, state: State, result: StepResult | None) -> list[float]:
        """As `_Part.values`."""
        if result is None or self.name not in result.forces:
            return [0.0] * (len(self._axes) + 1)
        area = result.areas.get(self.name, 0.0)
        return [*result.resultant(self.name).tolist(), area]


class _OfImplicit:
    """A moving implicit boundary.

    Displacement (of a motion by a function: the mean over its points) and force; with a rotation
    the angle and the moment about the centre, which moves with the translation; with a change of
    radius the change and the mean normal stress on the part of the boundary that touches soil.
    """

    def __init__(self, declared: ImplicitBoundary, dim: int) -> None:
        self.name = declared.name
        self._declared = declared
        self._dim = dim
        self._has_radius = declared.radius_change is not None or declared.volume_loss is not None

    def columns(self, model: Model) -> list[Column]:
        """As `_Part.columns`."""
        units, axes = model.units, AXES[: self._dim]
        found = [(f"displacement_{axis}", units.length) for axis in axes]
        found += [(f"force_{axis}", force_unit(model)) for axis in axes]
        if (rotation := self._declared.rotation) is not None:
            axis = rotation.axis or "z"
            found += [(f"rotation_{axis}", "degrees"), (f"moment_{axis}", moment_unit(model))]
        if self._has_radius:
            found += [("radius_change", units.length), ("pressure", units.stress)]
        return found

    def values(self, setup: Setup, state: State, result: StepResult | None) -> list[float]:
        """As `_Part.values`."""
        boundary = next((b for b in state.implicit if b.name == self.name), None)
        rotation = self._declared.rotation
        if boundary is None:
            more = int(rotation is not None) + int(self._has_radius)
            return [math.nan] * self._dim + [0.0] * self._dim + [math.nan, 0.0] * more
        factor = boundary.factor(_time(result))
        moved = self._displacement(boundary, factor)
        force = np.zeros(self._dim) if result is None else result.resultant(self.name)
        found = [*moved.tolist(), *force.tolist()]
        if rotation is not None:
            moment = np.zeros(3)
            if result is not None:
                moment = result.moment(self.name, np.array(rotation.centre) + moved)
            turned = 2 if rotation.axis is None else AXES.index(rotation.axis)
            found += [factor * rotation.angle, float(moment[turned])]
        if self._has_radius:
            change = self._declared.radius(factor) - self._declared.radius(0.0)
            found += [change, 0.0 if result is None else self._pressure(boundary, result, factor)]
        return found

    def _displacement(self, boundary: Implicit, factor: float) -> Floats:
        if self._declared.motion is None:
            declared = self._declared.displacement or {}
            return np.asarray([factor * declared.get(a, 0.0) + 0.0 for a in AXES[: self._dim]])
        if (quadrature := boundary.quadrature) is None:
            return np.zeros(self._dim)
        moved = boundary.motion.position(quadrature.reference, factor) - quadrature.reference
        weight = quadrature.weight[:, None]
        return np.asarray((weight * moved).sum(axis=0) / weight.sum())

    def _pressure(self, boundary: Implicit, result: StepResult, factor: float) -> float:
        """Returns the mean pressure on the part that touches soil [stress], > 0 against the soil.

        The forces' virtual work in a growth of the radius is the integral of the radial traction:
        the growth is linear in the position, so that the grid has it without error.
        """
        area = result.areas.get(self.name, 0.0)
        if area == 0.0:
            return 0.0
        geometry = cast(RoundGeometry, boundary.geometry)  # the schema asks for one
        place = result.active.position + result.equilibrium.displacement
        reference = boundary.motion.reference(place, factor)
        gradient = boundary.motion.gradient(reference, factor)
        radial = np.einsum("nij,nj->ni", gradient, geometry.radial(reference))
        outward = result.active.work(result.forces[self.name], radial)
        towards_soil = -1.0 if getattr(self._declared.geometry, "soil", "") == "inside" else 1.0
        return towards_soil * outward / (self._declared.radius(factor) * area)
