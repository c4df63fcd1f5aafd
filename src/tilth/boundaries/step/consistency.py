# SPDX-License-Identifier: BSD-3-Clause
"""Check that coinciding boundaries prescribe compatible displacements."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.implicit.constraint import ImplicitConstraint
from tilth.boundaries.protocol import Boundary
from tilth.boundaries.step.conditions import UNCONSTRAINED, Conditions
from tilth.boundaries.step.constraints import ImplicitConstraints
from tilth.errors import BadInput
from tilth.model import Model

DISPLACEMENT_TOLERANCE = 1e-6
"""Difference of displacements, relative to the larger one, above which they are contradictory."""

SHAPE_FUNCTION_TOLERANCE = 1e-9
"""Value of a shape function below which the node has no influence at a point."""


def require_consistency(
    boundaries: list[Boundary],
    constraints: ImplicitConstraints,
    times: list[float],
    keys: Mapping[str, str],
) -> None:
    """Checks the boundaries at their initial positions, with their motions up to several times.

    boundaries: those that act by elimination. times: see `table_times`. keys: the key of each
    boundary in the case file, by name.

    Raises:
        BadInput: the motions of two boundaries contradict each other at a point.
    """
    for time in times:
        conditions = Conditions.gather(boundaries, constraints.active, 0.0, time)
        for part in constraints.parts:
            _compare_with_nodes(part, conditions, time, keys)
        for part, other in permutations(constraints.parts, 2):
            _compare(part, other, time, keys)


def table_times(model: Model) -> list[float]:
    """Returns the times in all tables of factors, the end time and that of a first step; not 0."""
    times = {model.schedule.end, model.schedule.regular_time(1)}
    for declared in model.boundaries:
        times |= {time for time, _ in model.load_curve(declared).table}
    return sorted(times - {0.0})


def _compare(
    part: ImplicitConstraint, other: ImplicitConstraint, time: float, keys: Mapping[str, str]
) -> None:
    """Compares two boundaries at the quadrature points of the first that lie on the second."""
    reference = _reference_position(part)
    delta = max(part.boundary.delta, other.boundary.delta)
    chosen = np.flatnonzero(np.abs(other.boundary.distance(reference, 0.0)) <= delta)
    if len(chosen) == 0:
        return
    position = reference[chosen]
    of_other = other.boundary.motion.position(position, other.boundary.factor(time)) - position
    _refuse_contradiction(
        keys,
        (part.boundary.name, other.boundary.name),
        position,
        (part.pose.projector[chosen], _prescribed(part, position, time)),
        (other.boundary.projector_at(position), of_other),
    )


def _compare_with_nodes(
    part: ImplicitConstraint, conditions: Conditions, time: float, keys: Mapping[str, str]
) -> None:
    """Compares a boundary with constrained nodes.

    At its quadrature points for which all nodes with a shape function are constrained.
    """
    node = part.at.node[part.at.cell]
    no_influence = np.abs(part.at.value) < SHAPE_FUNCTION_TOLERANCE
    constrained = np.asarray((conditions.constrained[node] | no_influence[..., None]).all(axis=1))
    chosen = np.flatnonzero(constrained.any(axis=1))
    if len(chosen) == 0:
        return
    position = _reference_position(part)[chosen]
    by_nodes = part.at.interpolate(conditions.increment)[chosen]
    nearest = node[chosen, part.at.value[chosen].argmax(axis=1)]
    boundary = np.asarray(conditions.boundary[nearest].max(axis=1))
    for number in np.unique(boundary[boundary != UNCONSTRAINED]):
        those = boundary == number
        _refuse_contradiction(
            keys,
            (conditions.names[number], part.boundary.name),
            position[those],
            (part.pose.projector[chosen][those], _prescribed(part, position, time)[those]),
            (constrained[chosen][those, :, None] * np.eye(position.shape[1]), by_nodes[those]),
        )


def _reference_position(part: ImplicitConstraint) -> Floats:
    assert part.boundary.quadrature is not None
    return part.boundary.quadrature.reference[part.chosen]


def _prescribed(part: ImplicitConstraint, position: Floats, time: float) -> Floats:
    return part.boundary.motion.position(position, part.boundary.factor(time)) - position


def _refuse_contradiction(
    keys: Mapping[str, str],
    names: tuple[str, str],
    position: Floats,
    one: tuple[Floats, Floats],
    other: tuple[Floats, Floats],
) -> None:
    """Refuses two conditions (projectors, displacements) that no displacement satisfies.

    By the residual of the least-squares displacement at each position (n, dim).
    """
    both = np.concatenate([one[0], other[0]], axis=1)
    prescribed = np.concatenate(
        [np.einsum("nij,nj->ni", projector, value) for projector, value in (one, other)], axis=1
    )
    displacement = np.einsum("nij,nj->ni", np.linalg.pinv(both), prescribed)
    residual = np.einsum("nij,nj->ni", both, displacement) - prescribed
    largest = np.abs(residual).max(axis=1)
    worst = int(largest.argmax())
    if largest[worst] <= DISPLACEMENT_TOLERANCE * float(np.abs(prescribed).max()):
        return
    at = ", ".join(f"{x:g}" for x in position[worst])
    raise BadInput(
        f"boundaries {names[0]!r} and {names[1]!r} prescribe contradictory displacements at the "
        f"point ({at})",
        "move one of them, or give both the same motion",
        key=keys[names[1]],
    )
