# SPDX-License-Identifier: BSD-3-Clause
"""Slender blocks of elastic soil that stand on a plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from implicit_blocks import flat

from tilth import Model

WIDTH, SLENDERNESS, DENSITY, GRAVITY, CELL = 0.5, 3.0, 2000.0, 10.0, 0.25


def standing_block(
    modulus: float = 1e8,
    basis: str = "gimp",
    tangential: str = "friction",
    corner: tuple[float, float] = (0.07, 0.05),
    turn: float = 0.0,
    width: float = WIDTH,
    cell: float = CELL,
    **plane: Any,
) -> Model:
    """A block that its weight presses on a plane, in 14 of 30 steps: of two cells by six."""
    angle = np.radians(turn)
    down = [GRAVITY * np.sin(angle), -GRAVITY * np.cos(angle)]
    shape = {
        "type": "box",
        "lower": list(corner),
        "upper": [corner[0] + width, corner[1] + SLENDERNESS * width],
    } | ({"angle": turn} if turn else {})
    contact = {"normal": "unilateral", "tangential": tangential}
    if tangential == "friction":
        contact["friction"] = 1.0
    surface = plane or {"contact": contact, "wished_in_place": True}
    normal = [-np.sin(angle), np.cos(angle)]
    boundary = {
        "name": "plane", "type": "implicit", "geometry": flat(corner, normal), **surface,
    }  # fmt: skip
    return Model.from_dict(
        {
            "analysis": {"kind": "plane_strain"},
            "grid": {"cell_size": cell},
            "materials": {
                "soil": {
                    "model": "hencky_elastic", "young_modulus": modulus, "poisson_ratio": 0.2,
                    "density": DENSITY,
                }
            },
            "bodies": [
                {
                    "name": "block", "material": "soil", "basis": basis, "points_per_cell": 2,
                    "shape": shape, "surface": {},
                }
            ],
            "boundaries": [boundary],
            "loads": [
                {"type": "body_force", "acceleration": down, "factor": [[0, 0], [14, 14 / 30]]}
            ],
            "schedule": {"end": 14.0, "steps": 14},
        }
    )  # fmt: skip
