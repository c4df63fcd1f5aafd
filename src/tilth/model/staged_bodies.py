# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies in the stages of an analysis: how each goes on where the last stage ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import BaseModel

from tilth.model.load_curve import LoadCurve
from tilth.model.rigid_bodies import RigidBody
from tilth.model.stages import Stage

Rows = Sequence[Sequence[float]]


def in_stage(
    body: RigidBody, stage: Stage, last: RigidBody | None, last_end: float
) -> tuple[RigidBody, tuple[float, float] | None]:
    """Returns a rigid body as it is in a stage, and a jump of its forces.

    Its tables run in the first stage in which it is there; later ones hold what they ended with.

    Args:
        body: as declared.
        stage: the stage.
        last: as it was in the last stage; None if it was not there.
        last_end: time at the end of that stage.

    The jump is the force factor at the end of the last stage with the first one of this stage; None
    if they are the same.
    """
    ramp = ((0.0, 0.0), (stage.schedule.end, 1.0))
    changes: dict[str, Any] = {}
    jump = None
    for key, given, numbers in (
        ("factor", stage.factors, body.has_motion_numbers),
        ("force_factor", stage.force_factors, body.has_force_numbers),
    ):
        if not numbers:
            continue
        if last is None:
            changes[key] = given.get(body.name) or getattr(body, key) or ramp
            continue
        held = LoadCurve(getattr(last, key)).factor(last_end)
        changes[key] = given.get(body.name) or ((0.0, held),)
        if key == "force_factor" and changes[key][0][1] != held:
            jump = (held, changes[key][0][1])
    if last is not None:
        for key in ("displacement", "rotation", "force", "moment"):
            changes[key] = _held(getattr(last, key), last_end)
    return BaseModel.model_copy(body, update=changes), jump


def at_start(body: RigidBody, stage: Stage) -> RigidBody:
    """Returns a rigid body as it is at time 0, before the first stage, and as it stays there."""
    now, _ = in_stage(body, stage, None, 0.0)
    changes: dict[str, Any] = {
        key: _held(getattr(now, key), 0.0)
        for key in ("displacement", "rotation", "force", "moment")
    }
    for key, numbers in (
        ("factor", body.has_motion_numbers), ("force_factor", body.has_force_numbers)
    ):  # fmt: skip
        if numbers:
            changes[key] = ((0.0, LoadCurve(getattr(now, key)).factor(0.0)),)
    return BaseModel.model_copy(now, update=changes)


def _held(entry: Any, end: float) -> Any:
    """Returns numbers as they are, and in place of each table its value at the end."""
    if isinstance(entry, Mapping):
        return {axis: _held(value, end) for axis, value in entry.items()}
    if isinstance(entry, Sequence):
        return ((0.0, LoadCurve(entry).factor(end)),)
    return entry
