# SPDX-License-Identifier: BSD-3-Clause
"""Random small problems of sand with hardly any cohesion, below its limit load or pushed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth import Model

UNIT_WEIGHT, ACCELERATION = 20.0, 10.0
"""Of the soil [kN/m3], of gravity [m/s2]."""
SAFE = 0.9
"""Angle of a slope over the angle of repose without change of volume (Davis 1968), at most."""
KINDS = ("heap", "slope", "layers", "footing", "wall", "pipe")
BASES = ("linear", "gimp", "cpdi1", "cpdi2")
STEPS, STILL_STEPS = 5, 10
"""Load steps, and further ones in which nothing changes, or something is pushed."""


@dataclass(frozen=True)
class SandProblem:
    """A problem and what it is, in a line."""

    model: Model
    text: str


def davis_angle(phi: float, psi: float) -> float:
    """Returns the angle of repose without cohesion [degrees], by Davis' strength."""
    sine, cosine = math.sin(math.radians(phi)), math.cos(math.radians(phi))
    share = math.cos(math.radians(psi)) * cosine / (1.0 - math.sin(math.radians(psi)) * sine)
    return math.degrees(math.atan(share * sine / cosine))


def sand_problem(seed: int) -> SandProblem:
    """Returns the problem of a seed: kind, angles, cohesion, basis, and place in the grid."""
    random = np.random.default_rng([47, seed])
    kind = KINDS[seed % len(KINDS)]
    in_space = kind in ("layers", "footing") and random.random() < 0.3
    phi = float(random.uniform(25.0, 45.0))
    psi = float(random.uniform(0.0, phi)) if random.random() < 0.5 else 0.0
    cohesion = float(random.choice([0.0, 0.0, 0.1, 1.0]))
    basis = str(random.choice(BASES))
    angle = float(random.uniform(0.0, 90.0)) if kind in ("heap", "slope") else 0.0
    cell = 0.4 if in_space else 0.3
    origin = random.uniform(0.0, cell, 3 if in_space else 2).tolist()
    steepest = davis_angle(phi, psi)
    slope = float(random.uniform(0.4, SAFE)) * steepest
    outline, body = _outline(kind, slope, random)
    width = max(x for x, _ in outline)
    locking = "f_bar" if random.random() < 0.7 else "none"
    shape: dict[str, Any] = {
        "type": "polygon", "vertices": [_turned(angle, *each) for each in outline]
    }  # fmt: skip
    planes = [
        _plane("base", [0.0, 0.0], _turned(angle, 0.0, 1.0), "fixed"),
        _plane("left", [0.0, 0.0], _turned(angle, 1.0, 0.0), "roller"),
        _plane("right", _turned(angle, width, 0.0), _turned(angle, -1.0, 0.0), "roller"),
    ]
    if kind == "wall":
        del planes[1]  # the wall is there
    down = _turned(angle, 0.0, -ACCELERATION)
    if in_space:
        height = max(y for _, y in outline)
        shape = {"type": "box", "lower": [0.0, 0.0, 0.0], "upper": [2.4, 1.2, height]}
        sides = [("left", 0, 0.0), ("right", 0, 2.4), ("front", 1, 0.0), ("rear", 1, 1.2)]
        planes = [_plane("base", [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], "fixed")]
        for name, axis, at in sides:
            point, normal = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
            point[axis], normal[axis] = at, 1.0 if at == 0.0 else -1.0
            planes.append(_plane(name, point, normal, "roller"))
        down = [0.0, 0.0, -ACCELERATION]
        body = None if body is None else _footing_in_space(height, body["displacement"]["y"])
    end = 1.0 + STILL_STEPS / STEPS if body is None else 2.0
    entries: dict[str, Any] = {
        "analysis": {"kind": "3d" if in_space else "plane_strain", "tolerance": 1e-6},
        "grid": {"cell_size": cell, "origin": origin},
        "materials": {
            "sand": {
                "model": "mohr_coulomb", "young_modulus": 2e4, "poisson_ratio": 0.3,
                "density": UNIT_WEIGHT / ACCELERATION, "cohesion": cohesion,
                "friction_angle": phi, "dilation_angle": psi,
            },
        },
        "bodies": [
            {
                "name": "sand", "material": "sand", "basis": basis, "points_per_cell": 2,
                "anti_locking": locking, "shape": shape,
                **({} if body is None or in_space else {"surface": {}}),
            }
        ],
        "boundaries": planes,
        "loads": [
            {
                "type": "body_force", "acceleration": down,
                "factor": [[0.0, 0.0], [1.0, 1.0], [end, 1.0]],
            }
        ],
        "schedule": {"end": end, "steps": STEPS + (STILL_STEPS if body is None else STEPS)},
    }  # fmt: skip
    if body is not None:
        entries["rigid_bodies"] = [
            {
                "name": "body", "contact": {"normal": "unilateral", "tangential": "rough"}, **body,
                "centre": [0.0] * (3 if in_space else 2),
                "factor": [[0.0, 0.0], [1.0, 0.0], [end, 1.0]],
            }
        ]  # fmt: skip
    text = (
        f"{kind}{' in space' if in_space else ''}, phi {phi:.1f}, psi {psi:.1f}, c {cohesion:g}, "
        f"slope {slope:.1f} of {steepest:.1f}, {basis}, {locking}, turned {angle:.1f}"
    )
    return SandProblem(Model.from_dict(entries), text)


def _footing_in_space(height: float, way: float) -> dict[str, Any]:
    """Returns the entries of a footing over a corner of the soil."""
    return {
        "geometry": {
            "type": "box", "lower": [-0.6, -0.6, height], "upper": [0.6, 0.6, height + 0.5],
            "soil": "outside",
        },
        "displacement": {"x": 0.0, "y": 0.0, "z": way},
        "rotation": {"x": 0.0, "y": 0.0, "z": 0.0},
    }  # fmt: skip


def _outline(
    kind: str, slope: float, random: np.random.Generator
) -> tuple[list[tuple[float, float]], dict[str, Any] | None]:
    """Returns the soil's outline from the left bottom on, and what is pushed into it."""
    height = 1.2
    run = height / math.tan(math.radians(slope))
    flat = [(0.0, 0.0), (4.0, 0.0), (4.0, height), (0.0, height)]
    if kind == "heap":
        width = 2.0 * run
        low = 0.5
        return [
            (0.0, 0.0), (width, 0.0), (width, low), (run, low + height), (0.0, low)
        ], None  # fmt: skip
    if kind == "slope":
        low = 0.5
        return [
            (0.0, 0.0), (run + 2.0, 0.0), (run + 2.0, low), (run + 1.0, low),
            (1.0, low + height), (0.0, low + height),
        ], None  # fmt: skip
    if kind == "layers":
        wave = float(random.uniform(0.0, 0.3))
        return [(0.0, 0.0), (3.0, 0.0), (3.0, height), (1.5, height + wave), (0.0, height)], None
    way = 0.1 * float(random.uniform(0.3, 1.0))
    if kind == "footing":
        return flat, {
            "geometry": {
                "type": "box", "lower": [-0.6, height], "upper": [0.6, height + 0.5],
                "soil": "outside",
            },
            "displacement": {"x": 0.0, "y": -way},
            "rotation": 0.0,
        }  # fmt: skip
    if kind == "wall":
        side = float(random.choice([-1.0, 1.0]))
        return flat, {
            "geometry": {
                "type": "box", "lower": [-0.5, -0.5], "upper": [0.0, height + 0.5],
                "soil": "outside",
            },
            "displacement": {"x": side * way, "y": 0.0},
            "rotation": 0.0,
        }  # fmt: skip
    return flat, {
        "geometry": {
            "type": "circle", "centre": [2.0, height + 0.4], "radius": 0.4, "soil": "outside"
        },
        "displacement": {"x": 0.5 * way, "y": -way},
        "rotation": 0.0,
    }  # fmt: skip


def _turned(angle: float, x: float, y: float) -> list[float]:
    """Returns a place or direction, turned by an angle [degrees]."""
    cosine, sine = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return [cosine * x - sine * y, sine * x + cosine * y]


def _plane(name: str, point: list[float], normal: list[float], condition: str) -> dict[str, Any]:
    """Returns the entries of a plane that holds soil."""
    geometry = {"type": "plane", "point": point, "normal": normal}
    return {"name": name, "type": "implicit", "condition": condition, "geometry": geometry}
