# SPDX-License-Identifier: BSD-3-Clause
"""One step of an element test: Newton's method for the strains whose stresses are given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.element_tests.point import ElementPoint
from tilth.element_tests.stages import Specimen, Stage
from tilth.errors import StepFailed
from tilth.model.element_tests import GREATEST_STRAIN
from tilth.mpm.interval import Interval

TOLERANCE = 1e-12
"""Largest difference of a given and a computed stress over the largest stress."""

ROUND_OFF = 4e-16
"""Round-off of a strain: times the stiffness, a difference of stresses that none can avoid."""

GREATEST_CHANGE = 0.2
"""Greatest change of a strain in one Newton iteration [-]; a larger correction is shortened."""

MOST_ITERATIONS = 40
MOST_HALVINGS = 12
_SHORTEST = 2.0**-10


def advance(specimen: Specimen, stage: Stage, before: float, after: float) -> int:
    """Takes the specimen through a part of a stage; returns the number of Newton iterations.

    before, after: fractions of the stage. A step that fails is halved, and so on.

    Raises:
        StepFailed: the shortest step fails; the specimen is then where its last step ended.
    """
    return _advance(specimen, stage, before, after, 0)


def _advance(specimen: Specimen, stage: Stage, before: float, after: float, halvings: int) -> int:
    try:
        interval = stage.interval(specimen.time, before, after)
        point, strain, iterations = _solve(specimen, stage, stage.given(after), interval)
    except StepFailed:
        if halvings == MOST_HALVINGS:
            raise
    else:
        specimen.point, specimen.strain = point, strain
        specimen.time += interval.size
        return iterations
    middle = 0.5 * (before + after)
    first = _advance(specimen, stage, before, middle, halvings + 1)
    return first + _advance(specimen, stage, middle, after, halvings + 1)


@dataclass
class _Trial:
    """A trial state: strains, point, d stress / d strain (6, 6), and what of the stress is wrong.

    residual: given less computed stress by unknown [stress], shape (unknowns,).
    """

    strain: Floats
    point: ElementPoint
    tangent: Floats
    residual: Floats

    @property
    def size(self) -> float:
        """Norm of the residual [stress]."""
        return float(np.linalg.norm(self.residual))


def _solve(
    specimen: Specimen, stage: Stage, given: Floats, interval: Interval
) -> tuple[ElementPoint, Floats, int]:
    """Returns point and strains at the end of a step, and the number of corrections."""
    unknowns = stage.unknowns

    def at(strain: Floats) -> _Trial:
        if not np.abs(strain).max() <= 2.0 * GREATEST_STRAIN:
            raise StepFailed("no strain was found that has the given stress")
        gradient, slope = stage.kinematics(strain)
        point, tangent = specimen.point.deformed(gradient, interval)
        missing = np.where(stage.stressed, given - point.stress, 0.0)
        by_strain = np.einsum("kij,ijl->kl", tangent, slope)
        return _Trial(strain, point, by_strain, unknowns.T @ missing)

    trial = at(np.where(stage.stressed, specimen.strain, given))
    for iteration in range(MOST_ITERATIONS):
        scale = max(np.abs(trial.point.stress).max(), np.abs(given[stage.stressed]).max(initial=0))
        allowed = TOLERANCE * scale + ROUND_OFF * np.abs(trial.tangent).max()
        if np.abs(trial.residual).max(initial=0.0) <= allowed:
            return trial.point, trial.strain, iteration
        try:
            matrix = unknowns.T @ trial.tangent @ unknowns
            change = unknowns @ np.linalg.solve(matrix, trial.residual)
            change *= min(1.0, GREATEST_CHANGE / np.abs(change).max())
        except np.linalg.LinAlgError:
            break
        found = _line_search(at, trial, change)
        if found is None:
            break
        trial = found
    raise StepFailed("no strain was found that has the given stress")


def _line_search(at: Callable[[Floats], _Trial], trial: _Trial, change: Floats) -> _Trial | None:
    """Returns the state after the first part of a change, of 1, 1/2, ..., that has a smaller
    residual; where none has, that with the smallest one; None if no part can be computed.
    """
    best, share = None, 1.0
    while share >= _SHORTEST:
        try:
            found = at(trial.strain + share * change)
            if best is None or found.size < best.size:
                best = found
            if found.size < trial.size:
                break
        except StepFailed:
            pass
        share *= 0.5
    return best
