# SPDX-License-Identifier: BSD-3-Clause
"""A round rigid body pressed into soil, with stresses on it that are known, for tests of output."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tilth.geometry.rigid import RigidShape
from tilth.geometry.round import Circle, Sphere
from tilth.output import ContactShape, Snapshot

PRESSURE, SHEAR = 200.0, 50.0
RADIUS = 1.0


def ball(dim: int) -> RigidShape:
    """A circle or sphere around the origin with the soil outside."""
    shape = Circle if dim == 2 else Sphere
    geometry = shape(np.zeros(dim), RADIUS, False)
    return RigidShape("ball", [geometry], np.zeros(dim), 0.2, -np.ones(dim), np.ones(dim))


def lower_half(count: int = 60, centre: tuple[float, ...] = (0.0, 0.0)) -> ContactShape:
    """Points on the lower half of the circle in random order; the pressure is greatest below."""
    angle = np.random.default_rng(5).permutation(np.pi * (np.arange(count) + 0.5) / count)
    return on_circle(-angle, np.array(centre))


def on_circle(angle: np.ndarray, centre: np.ndarray) -> ContactShape:
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    depth = -np.sin(angle)
    along = np.column_stack([out[:, 1], -out[:, 0]])
    return ContactShape(
        "ball",
        centre + RADIUS * out,
        {
            "normal": out,
            "area": np.full(len(angle), np.pi * RADIUS / len(angle)),
            "normal_stress": -PRESSURE * np.maximum(depth, 0.0),
            "shear_stress": SHEAR * along,
            "gap": np.where(depth > 0.2, 0.0, 0.01),
            "in_contact": (depth > 0.2).astype(np.int8),
            "sliding": (depth < 0.6).astype(np.int8),
        },
    )


def in_space(count: int = 300) -> ContactShape:
    """Points on the lower half of the sphere."""
    number = np.arange(count) + 0.5
    height, turn = -number / count, np.pi * (1.0 + 5.0**0.5) * number
    across = np.sqrt(1.0 - height**2)
    out = np.column_stack([across * np.cos(turn), across * np.sin(turn), height])
    return ContactShape(
        "ball",
        RADIUS * out,
        {
            "normal": out,
            "area": np.full(count, 2.0 * np.pi * RADIUS**2 / count),
            "normal_stress": PRESSURE * height,
            "shear_stress": SHEAR * np.cross(out, [0.0, 1.0, 0.0]),
            "gap": np.zeros(count),
            "in_contact": (height < -0.1).astype(np.int8),
            "sliding": np.zeros(count, dtype=np.int8),
        },
    )


def with_contact(snapshot: Snapshot) -> Snapshot:
    """The snapshot with the body and the stresses on it; each step it is 0.1 lower."""
    down = np.zeros(snapshot.dim)
    down[-1] = -0.1 * snapshot.step
    body = ball(snapshot.dim).at(down, np.zeros(3))
    shape = lower_half() if snapshot.dim == 2 else in_space()
    return replace(
        snapshot,
        contacts=(replace(shape, position=shape.position + down),),
        rigid_bodies=(body,),
    )
