# SPDX-License-Identifier: BSD-3-Clause
"""Wrong inertia of rigid bodies and wrong damping: one message that names key and remedy."""

from __future__ import annotations

from typing import Any

import pytest
from free_bodies import falling

from tilth import BadInput, Model

PLANE, RING, SPACE = "plane_strain", "axisymmetric", "3d"
BODY, INERTIA = "rigid_bodies.0", "analysis.inertia"

WRONG: list[tuple[str, dict[str, Any], str, str]] = [
    (PLANE, {f"{BODY}.mass": None}, "mass", "x, y are free and have inertia"),
    (PLANE, {f"{BODY}.mass": 0.0}, "mass", "greater than zero"),
    (PLANE, {f"{BODY}.mass": float("nan")}, "mass", "finite"),
    (PLANE, {f"{BODY}.moments_of_inertia": None}, "moments_of_inertia", "rotation is free"),
    (PLANE, {f"{BODY}.moments_of_inertia": 0.0}, "moments_of_inertia", "greater than zero"),
    (PLANE, {f"{BODY}.moments_of_inertia": [1.0, 1.0]}, "moments_of_inertia", "one number"),
    (SPACE, {f"{BODY}.moments_of_inertia": 1.0}, "moments_of_inertia", "[Ixx, Iyy, Izz]"),
    (SPACE, {f"{BODY}.moments_of_inertia": [1.0, 1.0, 3.0]}, "moments_of_inertia", "no body has"),
    (RING, {f"{BODY}.moments_of_inertia": 1.0}, "moments_of_inertia", "leave it out"),
    (PLANE, {f"{BODY}.velocity": [0.0, 0.0, 1.0]}, "velocity", "expected 2"),
    (PLANE, {f"{BODY}.velocity": [0.0, float("inf")]}, "velocity", "finite"),
    (PLANE, {f"{BODY}.displacement": {"y": 0.0}}, "velocity", "which is not free"),
    (RING, {f"{BODY}.velocity": [1.0, 0.0]}, "velocity", "which is not free"),
    (PLANE, {f"{BODY}.angular_velocity": [0.0, 0.0, 1.0]}, "angular_velocity", "number in 2D"),
    (SPACE, {f"{BODY}.angular_velocity": 1.0}, "angular_velocity", "vector in 3D"),
    (RING, {f"{BODY}.angular_velocity": 1.0}, "angular_velocity", "no rotation is free"),
    (PLANE, {INERTIA: None}, "velocity", "add `inertia`"),
    (PLANE, {"units": {}}, "units.time", "has a unit"),
    (PLANE, {"schedule.end": 0.0}, "schedule.end", "greater than zero"),
    (PLANE, {f"{INERTIA}.damping": {"stiffness": -1.0}}, "damping.stiffness", "not be negative"),
    (PLANE, {f"{INERTIA}.damping": {}}, "inertia.damping", "leave `damping` out"),
    (PLANE, {f"{INERTIA}.spectral_radius": 2.0}, "spectral_radius", "from 0 to 1"),
    (PLANE, {f"{INERTIA}.spectral_radius": float("nan")}, "spectral_radius", "finite"),
    (PLANE, {f"{INERTIA}.spectral_radius": None}, "spectral_radius", "0.8 damps little"),
    (PLANE, {f"{INERTIA}.scheme": "newmark"}, "spectral_radius", "leave it out"),
    (PLANE, {INERTIA: "newmark"}, "analysis.inertia", "must be a table"),
    (PLANE, {f"{INERTIA}.damping": {"mass": -1.0}}, "damping.mass", "not be negative"),
    (PLANE, {f"{INERTIA}.largest_motion": 0.0}, "largest_motion", "greater than zero"),
    (PLANE, {f"{INERTIA}.largest_error": -1.0}, "largest_error", "greater than zero"),
    (PLANE, {"analysis.beyond_limit": "relax"}, "beyond_limit", "no meaning with `inertia`"),
    (PLANE, {"materials.soil.density": None}, "materials.soil.density", "it has inertia"),
    (PLANE, {"materials.soil.density": 0.0}, "materials.soil.density", "it has inertia"),
    (PLANE, {"schedule.end": None}, "schedule.end", "until which the motion is computed"),
    (PLANE, {"initial": {"velocity": [{"body": "soil"}]}}, "initial.velocity[0]", "no velocity"),
    (
        PLANE,
        {"initial": {"velocity": [{"body": "soil", "y": float("nan")}]}},
        "velocity[0].y",
        "finite",
    ),
    (
        PLANE,
        {
            "boundaries.0.condition": "base_motion",
            "boundaries.0.acceleration": {"file": "a.csv", "scale": 0.0},
        },
        "scale",
        "zero",
    ),
]


@pytest.mark.parametrize(("kind", "changes", "key", "text"), WRONG)
def test_wrong_input_has_one_message(
    kind: str, changes: dict[str, Any], key: str, text: str
) -> None:
    entries = falling(kind)
    for path, value in changes.items():
        *tables, last = path.split(".")
        table: Any = entries
        for name in tables:
            table = table[int(name) if isinstance(table, list) else name]
        if value is None:
            del table[last]
        else:
            table[last] = value
    with pytest.raises(BadInput) as caught:
        Model.from_dict(entries)
    message = str(caught.value)
    assert key in message
    assert text in message
    assert len(caught.value.problems) == 1
