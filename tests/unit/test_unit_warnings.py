# SPDX-License-Identifier: BSD-3-Clause
"""Numbers in another unit than the one they are taken for: warned of there, and only there."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from small_problems import block_entries, rollers, weight

import tilth
from tilth import Model


def warnings_of(**changed: Any) -> list[str]:
    given = {"boundaries": rollers("plane_strain"), "loads": [weight("plane_strain", 0.1)]}
    entries = block_entries("plane_strain", "gimp", **given)
    return tilth.check(Model.from_dict({**entries, **changed})).warnings


def pipe(rotation: Any) -> list[dict[str, Any]]:
    circle = {"type": "circle", "centre": [1.0, 20.0], "radius": 5.0, "soil": "outside"}
    law = {"normal": "unilateral", "tangential": "friction", "friction": 0.5}
    body = {"name": "pipe", "centre": [1.0, 20.0], "geometry": circle, "contact": law}
    return [{**body, "displacement": {"x": 0.0, "y": 0.0}, "rotation": rotation}]


@pytest.mark.parametrize(
    ("rotation", "steps", "warned"),
    [
        (1e7, 3, True),
        (-1e7, 3, True),
        (170.0, 1, False),
        (1000.0, 10, False),
        (1000.0, 3, True),
        ([[0.0, 0.0], [0.9, 0.0], [1.0, 300.0]], 10, True),
        ([[0.0, 0.0], [1.0, 300.0]], 10, False),
    ],
)
def test_turns_in_a_step(rotation: Any, steps: int, warned: bool) -> None:
    found = warnings_of(rigid_bodies=pipe(rotation), schedule={"steps": steps})
    named = [each for each in found if "degrees in a step" in each]
    assert bool(named) == warned, found
    assert all(each.startswith("rigid_bodies[0].rotation: the body 'pipe'") for each in named)


@pytest.mark.parametrize(
    ("corner", "size", "warned"),
    [
        ((7.44, 46.95), 0.01, True),
        ((-70.6, -33.4), 0.5, True),
        ((0.0, 0.0), 0.5, False),
        ((7.44, 46.95), 2.0, False),
        ((2600000.0, 1200000.0), 0.5, False),
        ((200.0, 46.0), 0.5, False),
    ],
)
def test_places_in_degrees(
    corner: tuple[float, float], size: float, warned: bool, tmp_path: Path
) -> None:
    """Those of a map; no specimen of the laboratory, and no place in metres."""
    x, y = corner
    ring = [[x, y], [x + size, y], [x + size, y + size], [x, y + size], [x, y]]
    file = tmp_path / "map.geojson"
    file.write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}), encoding="utf-8")
    shape = {"type": "outline", "file": str(file), "scale": 1.0, "origin": [x, y]}
    body = {"name": "block", "material": "soil", "basis": "gimp", "points_per_cell": 2}
    found = warnings_of(
        bodies=[{**body, "shape": shape}],
        grid={"cell_size": size / 4.0},
        boundaries=[
            {"name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "fixed"}
        ],
    )
    named = [each for each in found if "longitude and latitude" in each]
    assert bool(named) == warned, found
    assert all(each.startswith("bodies[0].shape.file: its places, (") for each in named)


def test_water_without_weight() -> None:
    """The soil below it floats, whatever its density."""
    water = {"unit_weight": 1.0, "level": 1.0}
    found = warnings_of(loads=[], water=water)
    assert any("water: no body force acts" in each for each in found), found
    assert not any("no body force acts" in each for each in warnings_of(loads=[]))
