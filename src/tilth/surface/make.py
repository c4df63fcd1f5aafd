# SPDX-License-Identifier: BSD-3-Clause
"""Creates the tracked surfaces that a model declares."""

from __future__ import annotations

import numpy as np

from tilth.curves.chain import BadSurface
from tilth.errors import BadInput
from tilth.model import Model
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import near_soil
from tilth.surface.protocol import BodySurface


def make_surfaces(model: Model, points: MaterialPoints) -> dict[str, BodySurface]:
    """Returns the surface of each body that declares one, by the body's name.

    `points` are the material points at time 0.

    Raises:
        BadInput: a surface cannot be created, or a load is on no part of it.
    """
    surfaces: dict[str, BodySurface] = {}
    for number, body in enumerate(model.bodies):
        if body.surface is None or not model.present(body.name):
            continue
        # imported only where needed: they import much of the package
        from tilth.surface.tracked import TrackedSurface
        from tilth.surface.tracked_triangles import TrackedSolidSurface

        surfaces[body.name] = (
            TrackedSurface(model, number, points)
            if model.dimension == 2
            else TrackedSolidSurface(model, number)
        )
    for number, track in enumerate(model.track):
        if track.quantity == "enclosed" and track.body in surfaces:
            try:
                surfaces[track.body or ""].enclosed()
            except BadSurface as error:
                raise BadInput(
                    error.problem, error.remedy, key=f"track[{number}].body", value=track.body
                ) from error
    return surfaces


def require_near_soil(model: Model, surfaces: dict[str, BodySurface], active: ActiveGrid) -> None:
    """Checks that all boundary points of tracked surfaces are near the soil at the start.

    Raises:
        BadInput: a boundary point is more than a cell away from any cell with soil.
    """
    for number, body in enumerate(model.bodies):
        if body.name not in surfaces:
            continue
        position = surfaces[body.name].shape().position
        overlay = active.points.overlay_of_body(body.name)
        far = np.flatnonzero(~near_soil(active, position, overlay))
        if len(far):
            where = ", ".join(f"{x:.4g}" for x in position[far[0]])
            raise BadInput(
                f"the boundary point at ({where}) is more than a cell away from the soil",
                "give boundary points on the edge of the body",
                key=f"bodies[{number}].surface",
            )
