# SPDX-License-Identifier: BSD-3-Clause
"""A block on a rigid plane tips when the resultant on it leaves its base."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat

from tilth import Model, TilthError
from tilth.verification.march import march

SLENDERNESS, GRAVITY = 3.0, 10.0
"""Height over width 1 [-]; it tips at a third of its weight along the base."""


def block(cells: int, basis: str, turn: float, share: float) -> Model:
    """A stiff block of so many cells; its weight acts first, then a share of it along the base."""
    angle, corner = np.radians(turn), [0.07, 0.05]
    along, normal = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    contact = {"normal": "unilateral", "tangential": "friction", "friction": 1.0}
    entries: dict[str, Any] = {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 1.0 / cells},
        "materials": {
            "rock": {
                "model": "hencky_elastic", "young_modulus": 1e9, "poisson_ratio": 0.2,
                "density": 2000.0,
            }
        },
        "bodies": [
            {
                "name": "block", "material": "rock", "basis": basis, "points_per_cell": 2,
                "shape": {
                    "type": "box", "lower": corner, "angle": turn,
                    "upper": [corner[0] + 1.0, corner[1] + SLENDERNESS],
                },
            }
        ],
        "boundaries": [
            {
                "name": "plane", "type": "implicit", "geometry": flat(corner, normal.tolist()),
                "contact": contact, "wished_in_place": True,
            }
        ],
        "loads": [
            {
                "type": "body_force", "acceleration": (-GRAVITY * normal).tolist(),
                "factor": [[0, 0], [1, 1]],
            },
            {
                "type": "body_force", "acceleration": (share * GRAVITY * along).tolist(),
                "factor": [[0, 0], [1, 0], [2, 1]],
            },
        ],
        "schedule": {"end": 2.0, "steps": 16, "minimum_step": 1e-2},
        "output": {"report": False},
    }  # fmt: skip
    return Model.from_dict(entries)


@pytest.mark.parametrize(("cells", "within"), [(2, 0.05), (4, 0.02)])
@pytest.mark.parametrize(("basis", "turn"), [("gimp", 0.0), ("cpdi2", 20.0)])
def test_a_block_tips_about_its_edge(basis: str, turn: float, cells: int, within: float) -> None:
    """Without supports of their own at the ends of its base at 0.71 and 0.81 of the exact share."""
    march(block(cells, basis, turn, (1.0 - within) / SLENDERNESS), lambda *_: None)
    with pytest.raises(TilthError):
        march(block(cells, basis, turn, (1.0 + within) / SLENDERNESS), lambda *_: None)
