# SPDX-License-Identifier: BSD-3-Clause
"""The `surface` of a declared body: round trip, and entries that need vertices."""

from __future__ import annotations

import json
from typing import Any

import pytest
from implicit_entries import boundary, entries, refused

from tilth.model import Model

VERTICES = [[0, 0], [1, 0], [1, 1]]


def with_surface(**surface: Any) -> dict[str, Any]:
    given = entries(boundary())
    given["bodies"][0]["surface"] = surface
    return given


@pytest.mark.parametrize(
    "surface",
    [
        {},
        {"points": "outer_layer", "spacing": 0.1, "corner_angle": 30},
        {"vertices": VERTICES},
        {"vertices": VERTICES, "closed": False, "corners": [1]},
        {"vertices": VERTICES, "corners": []},
    ],
)
def test_a_surface_survives_json_to_the_bit(surface: dict[str, Any]) -> None:
    model = Model.from_dict(with_surface(**surface))
    again = Model.from_dict(json.loads(json.dumps(model.to_dict(), allow_nan=False)))
    assert again == model
    assert again.to_dict() == model.to_dict()


@pytest.mark.parametrize(
    ("surface", "key", "words"),
    [
        ({"closed": False}, "closed", "is for `vertices` only"),
        ({"corners": [0]}, "corners", "is for `vertices` only"),
        ({"vertices": VERTICES, "corners": [3]}, "corners", "numbered from 0 to 2"),
        ({"vertices": VERTICES, "corners": [-1]}, "corners", "must not be negative"),
        ({"vertices": [[0, 0, 0]]}, "vertices", "points in 2D"),
        ({"vertices": VERTICES, "points": "outer_layer"}, "vertices", "consists of material"),
    ],
)
def test_wrong_surfaces(surface: dict[str, Any], key: str, words: str) -> None:
    error = refused(with_surface(**surface))
    assert error.key == f"bodies[0].surface.{key}"
    assert words in str(error)
    assert len(error.problems) == 1
