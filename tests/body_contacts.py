# SPDX-License-Identifier: BSD-3-Clause
"""Two blocks of soil in contact with each other, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np
from contact_terms import LAWS

from tilth import Model
from tilth.analysis.simulation import Simulation

YOUNG, STRENGTH = {"top": 1000.0, "ground": 1600.0}, 10.0
CELL = 0.5


def two_blocks(
    kind: str, law: str, basis: str = "gimp", steps: int = 4, **more: Any
) -> dict[str, Any]:
    """A block on a wider one, the interface within cells; a lid presses it down and aside.

    more: entries of the model that replace these.
    """
    dim = 3 if kind == "3d" else 2
    axes = "xyz"[:dim]
    inner = 0.0 if kind == "axisymmetric" else 0.3
    low, high = [inner] * (dim - 1), [1.5, *[1.2] * (dim - 2)]
    wide = [1.8, *[1.5] * (dim - 2)]
    motion = {axes[-1]: -0.04} | ({} if kind == "axisymmetric" else {"x": 0.02})
    up, down = [0.0] * (dim - 1) + [1.0], [0.0] * (dim - 1) + [-1.0]
    base = {
        "name": "base", "type": "implicit", "condition": "fixed",
        "geometry": {"type": "plane", "point": [0.0] * dim, "normal": up},
    }  # fmt: skip
    lid = {
        "name": "lid", "type": "implicit", "condition": "fixed",
        "geometry": {"type": "plane", "point": [0.0] * (dim - 1) + [1.6], "normal": down},
        "displacement": motion,
    }  # fmt: skip
    return {
        "analysis": {"kind": kind, "tolerance": 1e-11, "ghost_stabilisation": 0.005},
        "grid": {"cell_size": CELL},
        "materials": {
            name: {
                "model": "von_mises", "young_modulus": young, "poisson_ratio": 0.3,
                "yield_stress": np.sqrt(3.0) * STRENGTH, "hardening_modulus": 0.0,
            }
            for name, young in YOUNG.items()
        },
        "bodies": [
            {
                "name": "top", "material": "top", "basis": basis, "points_per_cell": 2,
                "shape": {"type": "box", "lower": [*low, 0.8], "upper": [*high, 1.6]},
                "surface": {},
            },
            {
                "name": "ground", "material": "ground", "basis": basis, "points_per_cell": 2,
                "shape": {"type": "box", "lower": [0.0] * dim, "upper": [*wide, 0.8]},
            },
        ],
        "contact_pairs": [
            {"name": "pair", "bodies": ["top", "ground"], "contact": LAWS[law]}
        ],
        "boundaries": [base, lid],
        "schedule": {"steps": steps},
        **more,
    }  # fmt: skip


def simulation_of(entries: dict[str, Any]) -> Simulation:
    """The simulation before its first step."""
    return Simulation(Model.from_dict(entries))
