# SPDX-License-Identifier: BSD-3-Clause
"""Whether boundaries that coincide prescribe displacements that one field can meet."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.implicit.constraint import ImplicitConstraint
from tilth.boundaries.implicit.constraints import ImplicitConstraints
from tilth.boundaries.protocol import Boundary
from tilth.boundaries.together import NOBODY, Conditions
from tilth.errors import BadInput
from tilth.model import Model

TOLERANCE = 1e-6
"""Difference of displacements, relative to the larger one, that counts as a contradiction."""

NEGLIGIBLE = 1e-9
"""Value of a shape function below which a node has no part in what happens at a place."""


def require_agreement(
    boundaries: list[Boundary],
    constraints: ImplicitConstraints,
    times: list[float],
    keys: Mapping[str, str],
) -> None:
    """Checks the boundaries where they are at the start, with their motions of several times.

    boundaries: those that act by elimination. times: see `turning_times`. keys: where each
    boundary stands in the case file, by name.

    Raises:
        BadInput: names two boundaries and the place.
    """
    for time in times:
        conditions = Conditions.gather(boundaries, constraints.active, 0.0, time)
        for part in constraints.parts:
            _compare_with_nodes(part, conditions, time, keys)
        for part, other in permutations(constraints.parts, 2):
            _compare(part, other, time, keys)


def turning_times(model: Model) -> list[float]:
    """Returns the times after 0 at which a table of factors turns, and the end of a first step."""
    times = {model.schedule.end, model.schedule.regular_time(1)}
    for declared in model.boundaries:
        times |= {time for time, _ in model.load_curve(declared).table}
    return sorted(times - {0.0})


def _compare(
    part: ImplicitConstraint, other: ImplicitConstraint, time: float, keys: Mapping[str, str]
) -> None:
    """Compares where the quadrature points of one boundary lie on the other."""
    places = _at_rest(part)
    delta = max(part.boundary.delta, other.boundary.delta)
    chosen = np.flatnonzero(np.abs(other.boundary.distance(places, 0.0)) <= delta)
    if len(chosen) == 0:
        return
    place = places[chosen]
    theirs = other.boundary.motion.place(place, other.boundary.factor(time)) - place
    _refuse_contradiction(
        keys,
        (part.boundary.name, other.boundary.name),
        place,
        (part.pose.projector[chosen], _prescribed(part, place, time)),
        (other.boundary.projector_at(place), theirs),
    )


def _compare_with_nodes(
    part: ImplicitConstraint, conditions: Conditions, time: float, keys: Mapping[str, str]
) -> None:
    """Compares where all nodes that a quadrature point acts on are constrained."""
    node = part.at.node[part.at.cell]
    idle = np.abs(part.at.value) < NEGLIGIBLE
    constrained = np.asarray((conditions.constrained[node] | idle[..., None]).all(axis=1))
    chosen = np.flatnonzero(constrained.any(axis=1))
    if len(chosen) == 0:
        return
    place = _at_rest(part)[chosen]
    by_nodes = part.at.interpolate(conditions.increment)[chosen]
    heaviest = node[chosen, part.at.value[chosen].argmax(axis=1)]
    holder = np.asarray(conditions.holder[heaviest].max(axis=1))
    for number in np.unique(holder[holder != NOBODY]):
        those = holder == number
        _refuse_contradiction(
            keys,
            (conditions.names[number], part.boundary.name),
            place[those],
            (part.pose.projector[chosen][those], _prescribed(part, place, time)[those]),
            (constrained[chosen][those, :, None] * np.eye(place.shape[1]), by_nodes[those]),
        )


def _at_rest(part: ImplicitConstraint) -> Floats:
    assert part.boundary.quadrature is not None
    return part.boundary.quadrature.reference[part.chosen]


def _prescribed(part: ImplicitConstraint, place: Floats, time: float) -> Floats:
    return part.boundary.motion.place(place, part.boundary.factor(time)) - place


def _refuse_contradiction(
    keys: Mapping[str, str],
    names: tuple[str, str],
    place: Floats,
    one: tuple[Floats, Floats],
    other: tuple[Floats, Floats],
) -> None:
    """Looks for a displacement that meets both (projectors, displacements) at each place."""
    both = np.concatenate([one[0], other[0]], axis=1)
    wanted = np.concatenate(
        [np.einsum("nij,nj->ni", projector, value) for projector, value in (one, other)], axis=1
    )
    best = np.einsum("nij,nj->ni", np.linalg.pinv(both), wanted)
    rest = np.abs(np.einsum("nij,nj->ni", both, best) - wanted).max(axis=1)
    worst = int(rest.argmax())
    if rest[worst] <= TOLERANCE * float(np.abs(wanted).max()):
        return
    at = ", ".join(f"{x:g}" for x in place[worst])
    raise BadInput(
        f"boundaries {names[0]!r} and {names[1]!r} prescribe contradictory displacements at the "
        f"place ({at})",
        "move one of them, or give both the same motion",
        key=keys[names[1]],
    )
