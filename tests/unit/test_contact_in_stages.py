# SPDX-License-Identifier: BSD-3-Clause
"""A stage in which nothing changes does not change the force of contact, on another grid either."""

from __future__ import annotations

from typing import Any

import pytest

from tilth import Model
from tilth.analysis.march import march_stages

WEIGHT = 19.2
"""Of the upper block, 1.2 by 0.8."""
LAW = {"normal": "unilateral", "tangential": "friction", "friction": 0.5}


def block(name: str, lower: list[float], upper: list[float], basis: str) -> dict[str, Any]:
    return {
        "name": name, "material": "soil", "basis": basis, "points_per_cell": 2, "surface": {},
        "shape": {"type": "box", "lower": lower, "upper": upper},
    }  # fmt: skip


def at_rest(contact: str, basis: str, grid: dict[str, Any] | None) -> Model:
    """A block that rests on another one, or on a rigid surface, and then nothing changes."""
    entries: dict[str, Any] = {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 0.5},
        "materials": {
            "soil": {
                "model": "hencky_elastic", "young_modulus": 1e4, "poisson_ratio": 0.3,
                "density": 2.0,
            }
        },
        "bodies": [block("top", [0.3, 1.0], [1.5, 1.8], basis)],
        "loads": [{"name": "weight", "type": "body_force", "acceleration": [0.0, -10.0]}],
        "stages": [
            {"name": "load", "schedule": {"steps": 3}, "factors": {"weight": [[0, 0], [1, 1]]}},
            {"name": "rest", "schedule": {"steps": 3}} | ({"grid": grid} if grid else {}),
        ],
    }  # fmt: skip
    if contact == "pair":
        entries["bodies"].append(block("ground", [0.0, 0.0], [2.0, 1.0], basis))
        entries["boundaries"] = [
            {"name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "fixed"}
        ]
        pair = {"name": "contact", "bodies": ["top", "ground"], "contact": LAW}
        entries["contact_pairs"] = [pair | {"wished_in_place": True}]
    else:
        plane = {"type": "plane", "point": [0.0, 1.0], "normal": [0.0, 1.0]}
        surface = {"name": "contact", "type": "implicit", "geometry": plane, "contact": LAW}
        entries["boundaries"] = [surface | {"wished_in_place": True}]
    return Model.from_dict(entries)


@pytest.mark.parametrize("contact", ["boundary", "pair"])
@pytest.mark.parametrize(
    ("basis", "grid"),
    [
        ("gimp", None),
        ("cpdi2", None),
        ("gimp", {"cell_size": 0.25}),
        ("gimp", {"cell_size": 0.5, "origin": [0.13, 0.0]}),
        ("cpdi2", {"cell_size": 0.5, "origin": [0.13, 0.0]}),
    ],
)
def test_a_stage_of_rest_keeps_the_force(
    contact: str, basis: str, grid: dict[str, Any] | None
) -> None:
    """To a thousandth: what another grid puts out of balance within the soil is released."""
    forces = []
    march_stages(
        at_rest(contact, basis, grid),
        lambda _, result: forces.append(abs(result.resultant("contact")[1])),
    )
    assert len(forces) == 6
    assert forces[:3] == pytest.approx([WEIGHT / 3, 2 * WEIGHT / 3, WEIGHT], rel=1e-6)
    assert forces[3:] == pytest.approx([WEIGHT] * 3, rel=1e-3)
