# SPDX-License-Identifier: BSD-3-Clause
"""Dirichlet conditions: on grid planes, at nodes, on implicit boundaries, or an affine motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from tilth.errors import Problem
from tilth.model.affine import affine_problem
from tilth.model.base import Declared, chosen_by
from tilth.model.fields import (
    AXES,
    Axis,
    CellName,
    Components,
    Displacement,
    Matrix,
    Real,
    Table,
    Vector,
    some,
    starts_from_zero,
)
from tilth.model.ground_motion import Ground, GroundAcceleration
from tilth.model.implicit import ImplicitBoundary, ground_problems
from tilth.model.problems import reject, rejection


def _interval(value: Sequence[float]) -> Sequence[float]:
    if len(value) != 2 or value[0] > value[1]:
        raise reject("must be two increasing coordinates", "such as [0, 1]")
    return value


Interval = Annotated[Vector, AfterValidator(_interval)]
Ranges = Annotated[Mapping[Axis, Interval], AfterValidator(some)]


class _NodalBoundary(Declared):
    name: CellName
    """Name of the boundary, unique."""
    components: Components | None = None
    """With condition "fixed": displacement components that are zero; all if not given."""
    displacement: Displacement | None = None
    """With condition "prescribed": displacement at factor 1 [length]; other components are free."""
    factor: Table | None = None
    """With condition "prescribed": rows (time, factor); 0 to 1 over the schedule if not given."""

    @model_validator(mode="after")
    def _entries_fit_the_condition(self) -> Any:
        problems = []
        condition = getattr(self, "condition")  # noqa: B009
        if condition == "prescribed" and self.displacement is None:
            remedy = "give the components at factor 1, such as displacement = { y = -0.1 }"
            problems.append(Problem("displacement", "missing", remedy))
        for key in ("displacement", "factor"):
            value = getattr(self, key)
            if condition != "prescribed" and value is not None:
                what = f'has no meaning with condition = "{condition}"'
                problems.append(Problem(key, what, 'choose condition = "prescribed"', value))
        if condition != "fixed" and self.components is not None:
            what = f'has no meaning with condition = "{condition}"'
            problems.append(Problem("components", what, "leave it out", self.components))
        problems += starts_from_zero(self.factor)
        if problems:
            raise rejection(problems)
        return self


def _held(
    displacement: Mapping[Axis, float] | None, components: Sequence[Axis] | None, dimension: int
) -> dict[int, float]:
    if displacement is not None:
        return {AXES.index(axis): value for axis, value in displacement.items()}
    return {AXES.index(axis): 0.0 for axis in components or AXES[:dimension]}


class PlaneBoundary(_NodalBoundary):
    """Condition on the nodes of a grid line (2D) or grid plane (3D).

    The line or plane does not move. Material that a prescribed displacement moves away from it by
    more than about half a cell is no longer constrained, and reactions are wrong before: by 3.5 %
    on an elastic block after 0.1 of a cell. An implicit boundary moves with the soil.
    """

    type: Literal["plane"] = "plane"
    axis: Axis
    """Axis normal to the line or plane."""
    at: Real
    """Coordinate of the line or plane along `axis` [length]; must be that of a grid line."""
    range: Ranges | None = None
    """Part with the condition, axis -> [least, greatest] coordinate [length]; all if not given."""
    condition: Literal["roller", "fixed", "prescribed", "base_motion", "absorbing"]
    """One of "roller" (normal component zero), "fixed" (all, or `components`, are zero),
    "prescribed", and with inertia "base_motion" (a rigid base, moved by `acceleration`) and
    "absorbing" (waves leave through it, at the outer face of the soil).
    """
    acceleration: GroundAcceleration | None = None
    """With "base_motion": acceleration of the base; components without a column do not move. With
    "absorbing": that of the outcrop of the ground beyond, whose waves come in through it.
    """
    ground: Ground | None = None
    """With "absorbing": the ground beyond; the soil at the boundary goes on if not given."""
    solid_side: Literal["lower", "upper"] | None = None
    """Side of the line or plane, that of lower or upper coordinates, on which the condition holds
    at all nodes, so that soil that is thrown against it cannot get through. If not given, it does
    so only next to the plane and where no material point is beyond it.
    """

    @model_validator(mode="after")
    def _ground_fits_the_condition(self) -> Any:
        if problems := [*ground_problems(self)]:
            raise rejection(problems)
        return self

    def prescribed(self, dimension: int) -> dict[int, float]:
        """Returns constrained directions (0 is x) with their displacement at factor 1 [length]."""
        if self.condition == "absorbing":
            return {}
        if self.condition == "roller":
            return {AXES.index(self.axis): 0.0}
        return _held(self.displacement, self.components, dimension)


class NodeBoundary(_NodalBoundary):
    """Condition on a single grid node."""

    type: Literal["node"] = "node"
    at: Vector
    """Coordinates of the node [length], shape (dimension,); must be those of a grid node."""
    condition: Literal["fixed", "prescribed"]
    """One of "fixed" (all, or `components`, are zero) and "prescribed"."""

    def prescribed(self, dimension: int) -> dict[int, float]:
        """Returns constrained directions (0 is x) with their displacement at factor 1 [length]."""
        return _held(self.displacement, self.components, dimension)


class AffineBoundary(Declared):
    """Motion x = F(t) X of all active nodes or of the outer ones; the only boundary of its model.

    With the factor f(t): F(t) = I + f (F - I) on the linear path, exp(f ln F) on the exponential.
    """

    type: Literal["affine"] = "affine"
    name: CellName
    """Name of the boundary, unique."""
    deformation_gradient: Matrix
    """F at factor 1 [-], shape (dimension, dimension); in axisymmetry [[F_rr, 0], [0, F_zz]]."""
    path: Literal["linear", "exponential"]
    """Path from the identity to F: "linear" or "exponential"."""
    nodes: Literal["all", "outer"] = "all"
    """Nodes with prescribed motion: "all", or "outer": those not surrounded by two cells of soil on
    each side. The other nodes are free.
    """
    factor: Table | None = None
    """Rows (time, factor), shape (n, 2); 0 to 1 over the schedule if not given."""

    @model_validator(mode="after")
    def _motion_is_possible(self) -> Any:
        problems = starts_from_zero(self.factor)
        factors = [0.0, 1.0] if self.factor is None else [row[1] for row in self.factor]
        what = affine_problem(self.deformation_gradient, self.path, min(factors), max(factors))
        if what:
            remedy = (
                "give a motion of stretches that soil can have, with det F > 0 on its whole path"
            )
            problems.append(
                Problem("deformation_gradient", what, remedy, self.deformation_gradient)
            )
        if problems:
            raise rejection(problems)
        return self


Boundary = Annotated[
    PlaneBoundary | NodeBoundary | ImplicitBoundary | AffineBoundary,
    Field(discriminator="type"),
    chosen_by("type", PlaneBoundary, NodeBoundary, ImplicitBoundary, AffineBoundary),
]
