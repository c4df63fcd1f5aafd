# SPDX-License-Identifier: BSD-3-Clause
"""Loads: on mass, points, lines and surfaces, each scaled by a table of load factors over time."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared, chosen_by
from tilth.model.fields import Name, Table, Vector
from tilth.model.problems import rejection
from tilth.model.surface import SurfaceLoad


class BodyForce(Declared):
    """Force on all mass, such as gravity."""

    type: Literal["body_force"] = "body_force"
    name: Name | None = None
    """Name by which stages and messages refer to the load; different from those of other loads."""
    acceleration: Vector
    """Force per mass at factor 1 [length / time^2], shape (dimension,)."""
    factor: Table | None = None
    """Rows (time, factor), shape (n, 2); 0 to 1 over the schedule if not given."""


class SeismicLoad(Declared):
    """Pseudo-static force of an earthquake on all mass: parts of gravity, at least one body force.

    At each time the force per mass is the factor times `coefficient` times the magnitude of the sum
    of all body forces.
    """

    type: Literal["seismic"] = "seismic"
    name: Name | None = None
    """Name by which stages and messages refer to the load; different from those of other loads."""
    coefficient: Vector
    """Seismic coefficients at factor 1 [-], shape (dimension,), (kh, kv) in 2D: force over weight
    along the axes, in the direction in which the soil is pushed; kv > 0 reduces the weight.
    """
    factor: Table | None = None
    """Rows (time, factor), shape (n, 2); 0 to 1 over the schedule if not given."""


class PointForce(Declared):
    """Dead force at a place of a body, which moves with the soil there.

    Material points nearby carry it, so that its resultant and its moment are those of the place. In
    plane strain it is a line load: the force per length of the line. In axisymmetry it is a ring
    load: the force of the full circle; at r = 0 it acts along the axis.
    """

    type: Literal["point_force"] = "point_force"
    name: Name | None = None
    """Name by which stages and messages refer to the load; different from those of other loads."""
    body: Name
    """Name of the body on which the force acts."""
    at: Vector
    """Position in the undeformed body [length], shape (dimension,), within a cell of soil."""
    force: Vector
    """Force at factor 1 [force], shape (dimension,), of constant direction."""
    factor: Table | None = None
    """Rows (time, factor), shape (n, 2); 0 to 1 over the schedule if not given."""


class LineForce(Declared):
    """Dead force on a straight line of a body in 3D, which moves with the soil there."""

    type: Literal["line_force"] = "line_force"
    name: Name | None = None
    """Name by which stages and messages refer to the load; different from those of other loads."""
    body: Name
    """Name of the body on which the force acts."""
    start: Vector
    """Start of the line in the undeformed body [length], shape (3,), within a cell of soil."""
    end: Vector
    """End of the line [length], shape (3,)."""
    force: Vector
    """Force per initial length at factor 1 [force / length], shape (3,), of constant direction."""
    factor: Table | None = None
    """Rows (time, factor), shape (n, 2); 0 to 1 over the schedule if not given."""

    @model_validator(mode="after")
    def _has_length(self) -> Any:
        if self.start == self.end:
            remedy = "give the other end of the line, or choose a point_force"
            raise rejection([Problem("end", "is equal to `start`", remedy, self.end)])
        return self


Load = Annotated[
    BodyForce | SeismicLoad | PointForce | LineForce | SurfaceLoad,
    Field(discriminator="type"),
    chosen_by("type", BodyForce, SeismicLoad, PointForce, LineForce, SurfaceLoad),
]
