# SPDX-License-Identifier: BSD-3-Clause
"""The stress of the material points at the start."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.errors import BadInput
from tilth.fields.level import elevation
from tilth.model import BodyForce, Model
from tilth.model.initial import AtRest, GivenStress
from tilth.mpm.points import MaterialPoints

WITHIN_YIELD = 1e-9
"""Plastic flow of a starting stress, at most, over its elastic strain [-]."""


def declared_stress(model: Model, number: int, position: Floats) -> Floats | None:
    """Returns the initial stress of a body's points, tension positive, (n, 6); None without one.

    Args:
        model: the declared problem.
        number: of the body in it.
        position: of its points [length], shape (n, dim).

    Raises:
        BadInput: a point lies above the declared ground, or no weight balances the stress.
    """
    body = model.bodies[number]
    found = (i for i, each in enumerate(model.initial.stress) if each.body == body.name)
    if (i := next(found, None)) is None:
        return None
    entry, key = model.initial.stress[i], f"initial.stress[{i}]"
    stress = np.zeros((len(position), 6))
    if isinstance(entry, GivenStress):
        stress[:, : len(entry.stress)] = entry.stress
    else:
        vertical = _overburden(model, key, entry, number, position)
        stress[:, :3] = -entry.K0 * vertical[:, None]
        stress[:, model.dimension - 1] = -vertical
    return stress


def start_with_stress(points: MaterialPoints, model: Model, stresses: Mapping[int, Floats]) -> None:
    """Gives undeformed points their initial stress, and the state variables that belong to it.

    stresses: of the ranges of `points` that have one, by number, shape (points of the range, 6).

    Raises:
        BadInput: a law cannot have its stress, or the stress lies outside the yield surface.
    """
    keys = {each.body: f"initial.stress[{i}]" for i, each in enumerate(model.initial.stress)}
    for number, stress in stresses.items():
        part, key = points.part(points.bodies[number]), keys[points.bodies[number].name]
        failed = part.start_with(stress)
        if failed >= 0:
            raise _refused(part, failed, key, "is not possible with this law")
        outside = np.flatnonzero(_outside_yield(part))
        if len(outside):
            raise _refused(part, int(outside[0]), key, "lies outside the yield surface")


def _overburden(model: Model, key: str, entry: AtRest, number: int, position: Floats) -> Floats:
    """Returns the vertical stress of the weight above the points, compression positive, (n,)."""
    height = position[:, -1]
    if (height > entry.surface_level).any():
        raise BadInput(
            f"the point at {_place(position[height.argmax()])} lies above this level",
            "give the height of the ground's surface",
            key=f"{key}.surface_level",
            value=entry.surface_level,
        )
    mass = _mass_above(model, key, entry.surface_level, number, position)
    return entry.surcharge + _gravity(model, key) * mass


def _mass_above(
    model: Model, key: str, surface_level: float, number: int, position: Floats
) -> Floats:
    """Returns the mass per area between the ground and the points of a body, shape (n,).

    The sum over the layers of the density times the thickness of the part above the point.
    """
    body, height = model.bodies[number], position[:, -1]
    densities = [model.materials[name].density or 0.0 for name in body.materials]
    if len(set(densities)) > 1 and body.layers[0].group is not None:
        raise BadInput(
            "layers that are groups of a mesh have no horizons from which their weight follows",
            'give the layers of different density a `bottom`, or the stress as type = "given"',
            key=f"{key}.type",
            value="k0",
        )
    mass, above = np.zeros(len(position)), np.full(len(position), surface_level)
    for i, density in enumerate(densities):
        layer = body.layers[i] if body.layers else None
        below = height
        if layer is not None and layer.bottom is not None:
            horizon = elevation(layer.bottom, position, f"bodies[{number}].layers[{i}].bottom")
            below = np.clip(horizon, height, surface_level)
        mass += density * np.maximum(above - below, 0.0)
        above = np.minimum(above, below)
    return mass


def _gravity(model: Model, key: str) -> float:
    """Returns the downward acceleration at time 0 [length / time^2]."""
    total = np.zeros(model.dimension)
    for _, load in model.acting_loads():
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
