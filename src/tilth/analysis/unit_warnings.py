# SPDX-License-Identifier: BSD-3-Clause
"""Numbers that are probably in another unit than the one they are taken for."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.arrays import Floats
from tilth.model import Model, Outline, RigidBody
from tilth.mpm.points import MaterialPoints

HALF_TURN = math.pi
"""Rotation in a step beyond which the way from its start to its end is not known [rad]."""

MOST_TIMES = 1000
"""Times at which a rotation is evaluated, at most."""

MOST_DEGREES = np.array([180.0, 90.0])
"""Of longitude and latitude."""


def unit_warnings(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Yields rotations that are turns on turns, and outlines drawn in degrees."""
    for i, body in enumerate(model.rigid_bodies):
        turned = _turned_in_a_step(model, body)
        if turned > HALF_TURN:
            yield (
                f"turns of {body.name}",
                f"rigid_bodies[{i}].rotation: the body {body.name!r} turns by "
                f"{math.degrees(turned):.4g} degrees in a step, and contact sees only where it "
                "ends; take more steps, or correct the rotation, which is in degrees",
            )
    for i, soil in enumerate(model.bodies):
        own = points.position[points.body_id == i]
        if isinstance(soil.shape, Outline) and len(own):
            yield from _in_degrees(f"bodies[{i}].shape.file", soil.shape, own)


def _turned_in_a_step(model: Model, body: RigidBody) -> float:
    """Returns the largest prescribed rotation in a regular step of a schedule [rad]."""
    schedule = model.schedule
    count = min(schedule.number_of_steps, MOST_TIMES)
    most = 0.0
    for component in body.components(model.dimension, model.analysis.kind):
        if not component.startswith("rotation") or not body.is_prescribed(component):
            continue
        times = np.linspace(0.0, schedule.end, count + 1)
        angle = [body.prescribed(component, time, schedule.end) or 0.0 for time in times]
        share = count / schedule.number_of_steps
        most = max(most, share * float(np.abs(np.diff(angle)).max()))
    return most


def _in_degrees(key: str, shape: Outline, position: Floats) -> Iterator[tuple[str, str]]:
    """Yields a warning of places that are degrees of longitude and latitude, as in RFC 7946."""
    if shape.file.lower().endswith(".dxf"):
        return
    low, high = (
        end / shape.scale + np.array(shape.origin) for end in (position.min(0), position.max(0))
    )
    is_on_earth = bool((np.maximum(np.abs(low), np.abs(high)) <= MOST_DEGREES).all())
    size = high - low
    is_small = size.max() < 1.0 and bool((size < 0.1 * np.abs(low + high) / 2.0).all())
    if is_on_earth and is_small:
        places = " to ".join(f"({x:.6g}, {y:.6g})" for x, y in (low, high))
        yield (
            f"degrees of {key}",
            f"{key}: its places, {places}, look like degrees of longitude and latitude, which are "
            "no lengths; save it in plane coordinates, such as those of the national grid",
        )
