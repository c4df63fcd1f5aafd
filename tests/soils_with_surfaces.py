# SPDX-License-Identifier: BSD-3-Clause
"""Bodies of soil at rest, with and without tracked surfaces, for tests of the gap to them."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth import Model
from tilth.arrays import Floats
from tilth.boundaries.surfaces.gap import measure_gap
from tilth.grid.background import Grid
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.surface.make import make_surfaces
from tilth.surface.protocol import BodySurface


class SoilAtRest:
    """Material points of bodies on a grid with cells of size 1, and their tracked surfaces.

    bodies: entries of each body besides name and material, shape and basis at least.
    """

    points: MaterialPoints
    surfaces: dict[str, BodySurface]

    def __init__(self, *bodies: dict[str, Any], kind: str = "plane_strain") -> None:
        dim = 3 if kind == "3d" else 2
        model = Model.from_dict(
            {
                "analysis": {"kind": kind},
                "grid": {"cell_size": 1.0},
                "materials": {
                    "soil": {"model": "hencky_elastic", "young_modulus": 1.0, "poisson_ratio": 0.0}
                },
                "bodies": [
                    {"name": f"body {i}", "material": "soil", **body}
                    | ({} if "spacing" in body else {"points_per_cell": 2})
                    for i, body in enumerate(bodies)
                ],
                "boundaries": [
                    {
                        "type": "affine",
                        "name": "drive",
                        "path": "linear",
                        "deformation_gradient": np.eye(dim).tolist(),
                    }
                ],
                "schedule": {"steps": 1},
            }
        )
        self.points = initial_points(model)
        self.surfaces = make_surfaces(model, self.points)
        self.grid = Grid(np.zeros(dim), np.ones(dim))

    def gap(
        self, position: Any, normal: Any, reach: float = 2.0, behind: Floats | float = 1.0
    ) -> tuple[Floats, Floats]:
        """The gap at positions (n, dim) along one normal or (n, dim), and the material points."""
        x = np.asarray(position, dtype=float)
        normal = np.broadcast_to(np.asarray(normal, dtype=float), x.shape)
        return measure_gap(self.points, self.grid, self.surfaces, x, normal, reach, behind)


def box(lower: Any, upper: Any, basis: str = "gimp", angle: float = 0.0, **more: Any) -> Any:
    """A rectangle or cuboid, turned about z."""
    shape = {"type": "box", "lower": list(lower), "upper": list(upper), "angle": angle}
    if len(list(lower)) == 3 and angle:
        shape["axis"] = "z"
    return {"shape": shape, "basis": basis, **more}


def ball(centre: Any, radius: float, basis: str = "gimp", **more: Any) -> Any:
    """A circle or a sphere."""
    shape = {"type": "circle" if len(list(centre)) == 2 else "sphere"}
    return {
        "shape": {**shape, "centre": list(centre), "radius": radius}, "basis": basis, **more
    }  # fmt: skip
