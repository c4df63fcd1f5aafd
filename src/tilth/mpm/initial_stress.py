# SPDX-License-Identifier: BSD-3-Clause
"""The stress of the material points at the start."""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.errors import BadInput
from tilth.model import BodyForce, Model
from tilth.model.initial import AtRest, GivenStress
from tilth.mpm.points import MaterialPoints

WITHIN_YIELD = 1e-9
"""Plastic flow of a starting stress, at most, over its elastic strain [-]."""


def set_initial_stress(points: MaterialPoints, model: Model) -> None:
    """Gives undeformed points the declared stress, and the state variables that belong to it.

    Raises:
        BadInput: a point lies above the declared ground, no weight balances the stress, a law
            cannot have its stress, or the stress lies outside the yield surface.
    """
    ranges = {body.name: body for body in points.bodies}
    for i, entry in enumerate(model.initial.stress):
        part, key = points.part(ranges[entry.body]), f"initial.stress[{i}]"
        stress = np.zeros((len(part), 6))
        if isinstance(entry, GivenStress):
            stress[:, : len(entry.stress)] = entry.stress
        else:
            vertical = _overburden(model, key, entry, part)
            stress[:, :3] = -entry.K0 * vertical[:, None]
            stress[:, model.dimension - 1] = -vertical
        failed = part.start_with(stress)
        if failed >= 0:
            raise _refused(part, failed, key, "is not possible with this law")
        outside = np.flatnonzero(_outside_yield(part))
        if len(outside):
            raise _refused(part, int(outside[0]), key, "lies outside the yield surface")


def _overburden(model: Model, key: str, entry: AtRest, part: MaterialPoints) -> Floats:
    """Returns the vertical stress of the weight above the points, compression positive, (n,)."""
    depth = entry.surface_level - part.position[:, -1]
    if depth.min() < 0.0:
        raise BadInput(
            f"the point at {_place(part.position[depth.argmin()])} lies above this level",
            "give the height of the ground's surface",
            key=f"{key}.surface_level",
            value=entry.surface_level,
        )
    return entry.surcharge + part.bodies[0].density * _gravity(model, key) * depth


def _gravity(model: Model, key: str) -> float:
    """Returns the downward acceleration at time 0 [length / time^2]."""
    total = np.zeros(model.dimension)
    for load in model.loads:
        if isinstance(load, BodyForce):
            total += model.load_curve(load).factor(0.0) * np.asarray(load.acceleration)
    if np.any(total[:-1]) or total[-1] > 0.0:
        raise BadInput(
            f"the body force at time 0, {_place(total)}, does not act downwards only",
            'give the stress as type = "given", or a vertical body force',
            key=f"{key}.type",
            value="k0",
        )
    if total[-1] == 0.0:
        raise BadInput(
            "no body force acts at time 0, so the stress would not be in equilibrium",
            "add a load of the type body_force, with its whole factor from the start: "
            "factor = [[0, 1], [1, 1]]",
            key=f"{key}.type",
            value="k0",
        )
    return float(-total[-1])


def _outside_yield(part: MaterialPoints) -> Flags:
    """Returns which points of a body would flow without any deformation, shape (n,)."""
    body = part.bodies[0]
    elastic, plastic, state = (
        np.empty_like(each) for each in (part.elastic_deformation, part.plastic, part.state)
    )
    kirchhoff, admissible = np.empty_like(part.stress), np.empty(len(part), dtype=bool)
    _core.return_to_law(
        part.tensors, body.law.core, part.parameters_of(body), part.elastic_deformation,
        part.plastic, part.state, elastic, plastic, state, kirchhoff, admissible,
    )  # fmt: skip
    change = np.abs(elastic - part.elastic_deformation).max(axis=1)
    size = np.abs(part.elastic_deformation).max(axis=1)
    return np.asarray(~admissible | (change > WITHIN_YIELD * size))


def _refused(part: MaterialPoints, point: int, key: str, problem: str) -> BadInput:
    body = part.bodies[0]
    stress = ", ".join(f"{value:.4g}" for value in part.stress[point])
    return BadInput(
        f"the starting stress {problem} ({body.law.name}) at {_place(part.position[point])}: "
        f"[{stress}], xx yy zz xy yz xz",
        "change the stress or the strength; tension is positive",
        key=key,
    )


def _place(vector: Floats) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in vector) + ")"
