# SPDX-License-Identifier: BSD-3-Clause
"""Rotations that no step can follow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.errors import Problem
from tilth.model.implicit import ImplicitBoundary

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration

LARGEST_TURN = 90.0
"""Rotation of a boundary or rigid body in a step of the schedule [degrees], at most."""


def turns_in_steps(model: Declaration) -> Iterator[Problem]:
    """Yields rotations by more than `LARGEST_TURN` in a step of the schedule.

    They are prescribed, or those of free bodies at the start. From half a turn on a step cannot
    tell one direction from the other, and a whole turn is none.
    """
    size, end = model.schedule.largest_step, model.schedule.end
    for key, rows in _rotations(model):
        time, angle = np.array(rows, dtype=float).T
        # between its rows an angle is linear: the largest change is in a step that ends at one
        before = np.clip(np.concatenate([time, time - size]), 0.0, max(end - size, 0.0))
        turned = np.interp(before + size, time, angle) - np.interp(before, time, angle)
        yield from _too_large(key, float(np.abs(turned).max()), "a smaller angle (in degrees)")
    keys = model.rigid_body_keys()
    for body in model.rigid_bodies:
        if body.angular_velocity is not None and model.stage.begins(body.name):
            turned = np.degrees(np.linalg.norm(body.angular_velocity)) * size
            slower = "a smaller velocity (in radians)"
            yield from _too_large(f"{keys[body.name]}.angular_velocity", float(turned), slower)


def _too_large(key: str, degrees: float, remedy: str) -> Iterator[Problem]:
    if degrees > LARGEST_TURN:
        what = f"turns by {degrees:.4g} degrees in a step of the schedule, more than "
        yield Problem(key, f"{what}{LARGEST_TURN:g}", f"give {remedy}, or more steps")


def _rotations(model: Declaration) -> Iterator[tuple[str, Any]]:
    """Yields the keys and the rows (time, angle [degrees]) of all prescribed rotations."""
    keys = model.boundary_keys()
    for boundary in model.boundaries:
        if isinstance(boundary, ImplicitBoundary) and boundary.rotation is not None:
            table, angle = model.load_curve(boundary).table, boundary.rotation.angle
            yield f"{keys[boundary.name]}.rotation.angle", [(t, angle * f) for t, f in table]
    keys = model.rigid_body_keys()
    for body in model.rigid_bodies:
        key, given = f"{keys[body.name]}.rotation", body.rotation
        components = given.items() if isinstance(given, Mapping) else [("", given)]
        for axis, value in components:
            own = f"{key}.{axis}" if axis else key
            if isinstance(value, Sequence):
                yield own, value
            elif value is not None:
                yield own, [(t, value * f) for t, f in model.load_curve(body).table]
