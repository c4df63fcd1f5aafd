# SPDX-License-Identifier: BSD-3-Clause
"""Loads: on mass, points and surfaces, each scaled by a table of load factors over time."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from tilth.model.base import Declared, chosen_by
from tilth.model.fields import Name, Table, Vector
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


class PointForce(Declared):
    """Dead force on the material points nearest to a given position at the start."""

    type: Literal["point_force"] = "point_force"
    name: Name | None = None
    """Name by which stages and messages refer to the load; different from those of other loads."""
    body: Name
    """Name of the body on which the force acts."""
    at: Vector
    """Position [length], shape (dimension,); nearest points, within 1e-6 cell, share the force."""
    force: Vector
    """Force at factor 1 [force], shape (dimension,), of constant direction."""
    factor: Table | None = None
    """Rows (time, factor), shape (n, 2); 0 to 1 over the schedule if not given."""


Load = Annotated[
    BodyForce | PointForce | SurfaceLoad,
    Field(discriminator="type"),
    chosen_by("type", BodyForce, PointForce, SurfaceLoad),
]
