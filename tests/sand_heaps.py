# SPDX-License-Identifier: BSD-3-Clause
"""Heaps of sand without cohesion, in plane strain and round, and the bounds of their factors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from scipy.optimize import brentq
from spencer import SpencerSlope

from tilth import Model

HEIGHT, BASE, BESIDE, WEIGHT = 5.0, -1.0, 1.0, 20.0
"""Of the heap, of the base, of the ground beside the heap [m]; unit weight [kN/m3]."""
RESOLVED = 2.0
"""Thickness of the thinnest mechanism that a grid resolves [cells]: one of one cell has a band of
shear as wide as itself."""


@dataclass(frozen=True)
class SandHeap:
    """A heap; angles in degrees.

    Attributes:
        friction_angle, dilation_angle: of the sand.
        slope: of the heap.
        angle: by which heap, gravity and boundaries are turned against the grid.
        kind: "plane_strain" or "axisymmetric".
    """

    friction_angle: float
    dilation_angle: float
    slope: float
    angle: float = 0.0
    kind: str = "plane_strain"

    @property
    def run(self) -> float:
        """Half the width of the heap [m]."""
        return HEIGHT / math.tan(math.radians(self.slope))

    def tangent(self, factor: float = 1.0) -> float:
        """Returns Davis' tan(phi*) of the angles reduced by a factor, form B [-]."""
        phi = math.atan(math.tan(math.radians(self.friction_angle)) / factor)
        psi = min(math.radians(self.dilation_angle), phi)
        share = math.cos(psi) * math.cos(phi) / (1.0 - math.sin(psi) * math.sin(phi))
        return share * math.tan(math.radians(self.friction_angle))

    def bounds(self) -> tuple[float, float]:
        """Returns Davis' factor and that of the infinite slope, tan(phi) / tan(slope)."""
        slope = math.tan(math.radians(self.slope))
        upper = math.tan(math.radians(self.friction_angle)) / slope
        if self.dilation_angle >= self.friction_angle:
            return upper, upper
        return brentq(lambda f: self.tangent(f) / slope - f, 0.5 * upper, upper), upper

    def resolved(self, cell_size: float) -> float:
        """Returns the least factor of a slip circle that the grid resolves, by Spencer's method."""
        run = self.run
        ground = [(-run, 0.0), (0.0, HEIGHT), (run, 0.0), (run + BESIDE, 0.0)]
        slope = SpencerSlope(ground, WEIGHT, 0.0, self.friction_angle, BASE)
        thickness = RESOLVED * cell_size / math.cos(math.radians(self.slope))
        return slope.least_factor((-2.0, 1.0), (run - 2.0, run + 0.9 * BESIDE), thickness)

    def model(self, cell_size: float) -> Model:
        """Returns the heap in a grid."""
        angle = math.radians(self.angle)
        cosine, sine = math.cos(angle), math.sin(angle)

        def turned(x: float, y: float) -> list[float]:
            return [cosine * x - sine * y, sine * x + cosine * y]

        run, edge = self.run, self.run + BESIDE
        corners = [(-edge, BASE), (edge, BASE), (edge, 0.0), (run, 0.0), (0.0, HEIGHT)]
        corners += [(-run, 0.0), (-edge, 0.0)]
        planes = [
            ("base", (0.0, BASE), (0.0, 1.0), "fixed"),
            ("left", (-edge, 0.0), (1.0, 0.0), "roller"),
            ("right", (edge, 0.0), (-1.0, 0.0), "roller"),
        ]  # fmt: skip
        if self.kind == "axisymmetric":
            corners = [(max(x, 0.0), y) for x, y in corners[:5]]
            del planes[1]
        boundaries: list[dict[str, Any]] = [
            {
                "name": name, "type": "implicit", "condition": condition,
                "geometry": {"type": "plane", "point": turned(*point), "normal": turned(*normal)},
            }
            for name, point, normal, condition in planes
        ]  # fmt: skip
        if self.kind == "axisymmetric":
            axis = {"name": "axis", "type": "plane", "axis": "x", "at": 0.0, "condition": "roller"}
            boundaries.append(axis)
        return Model.from_dict(
            {
                "analysis": {"kind": self.kind},
                "grid": {"cell_size": cell_size},
                "materials": {
                    "sand": {
                        "model": "mohr_coulomb", "young_modulus": 2e4, "poisson_ratio": 0.3,
                        "density": WEIGHT / 10.0, "cohesion": 0.0,
                        "friction_angle": self.friction_angle,
                        "dilation_angle": self.dilation_angle,
                    }
                },
                "bodies": [
                    {
                        "name": "heap", "material": "sand", "basis": "gimp", "points_per_cell": 2,
                        "anti_locking": "f_bar",
                        "shape": {
                            "type": "polygon", "vertices": [turned(*each) for each in corners]
                        },
                    }
                ],
                "boundaries": boundaries,
                "loads": [{"type": "body_force", "acceleration": turned(0.0, -10.0)}],
                "schedule": {"steps": 5},
            }
        )  # fmt: skip
