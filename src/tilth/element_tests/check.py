# SPDX-License-Identifier: BSD-3-Clause
"""`tilth element --check`: the tangents of the laws against differences along the tests' paths."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.element_tests.point import ElementPoint
from tilth.element_tests.run import specimen_of, taken_steps
from tilth.errors import StepFailed
from tilth.model import ElementCase
from tilth.mpm.interval import INSTANT, Interval

TOLERANCE = 1e-6
"""Largest error of a tangent that passes [-]."""

INTERVALS = (1e-5, 1e-6, 1e-7)
"""Half intervals of the central differences, in the displacement gradient [-]."""


@dataclass(frozen=True)
class TangentCheck:
    """The tangents along one test with one material.

    Attributes:
        test, material, law: their names.
        states: number of states whose tangent was compared.
        skipped: number of states at which the stress has no derivative, as where yielding starts.
        error: largest difference of a tangent's entry, over the largest entry of this tangent or of
            that at the start of the step [-].
        step: where it was found, counted over all stages; 0 for none.
        at_random: whether it was found at a random state near the step, not on the path.
        stopped: why the path ended early; "" if it did not.
    """

    test: str
    material: str
    law: str
    states: int
    skipped: int
    error: float
    step: int
    at_random: bool
    stopped: str

    @property
    def passed(self) -> bool:
        """Whether all states passed, and there was at least one."""
        return self.states > 0 and self.error <= TOLERANCE


def check_tangents(case: ElementCase, seed: int = 1) -> Iterator[TangentCheck]:
    """Compares the consistent tangents with central differences; yields each test and material.

    At each step of a test the derivative of the Kirchhoff stress by the displacement gradient of
    the step is compared, at the step's own gradient and at a random one of a similar size, with
    rotation and shear in any direction.

    Args:
        case: the declared tests.
        seed: of the random gradients.

    Raises:
        BadInput: as `element`.
    """
    for number, test in enumerate(case.tests):
        for name in test.material:
            random = np.random.default_rng(seed)
            specimen = specimen_of(case, number, name)
            errors: list[tuple[float, int, bool]] = []
            skipped, step, stopped = 0, 0, ""
            try:
                for step, (_, taken) in enumerate(taken_steps(test, specimen), start=1):
                    backward = np.linalg.inv(taken.before.deformation_gradient)
                    own = taken.deformation_gradient @ backward - np.eye(3)
                    size = np.abs(own).max() * 10.0 ** random.uniform(-1.0, 1.0)
                    for gradient in (own, size * random.normal(size=(3, 3))):
                        error = tangent_error(taken.before, gradient, taken.interval)
                        if error is None:
                            skipped += 1
                        else:
                            errors.append((error, step, gradient is not own))
            except StepFailed as error:
                stopped = f"after step {step}: {error.reason}"
            worst = max(errors, default=(0.0, 0, False))
            law = case.materials[name].model
            yield TangentCheck(test.name, name, law, len(errors), skipped, *worst, stopped)


def tangent_error(
    point: ElementPoint, gradient: Floats, interval: Interval = INSTANT
) -> float | None:
    """Returns the largest error of a tangent, as in `TangentCheck`; None if there is none.

    Central differences with several intervals are formed, and the best one counts. Where it differs
    by less than the one-sided differences do from each other, the stress has a kink there, and no
    derivative.

    Args:
        point: the state before the step.
        gradient: displacement gradient of the step [-], shape (3, 3).
        interval: the time that the step takes.
    """
    shifts = np.concatenate([h * np.eye(9).reshape(9, 3, 3) for h in INTERVALS])
    try:
        here = point.update(np.stack([gradient, np.zeros((3, 3))]), interval)
        above = point.update(gradient + shifts, interval)
        below = point.update(gradient - shifts, interval)
    except StepFailed:
        return None
    stress, tangent = here.kirchhoff[0], here.tangent[0].reshape(6, 9)
    scale = max(np.abs(here.tangent).max(), np.finfo(float).tiny)  # the stress at an apex has none
    best, kink = np.inf, 0.0
    for n, h in enumerate(INTERVALS):
        own = slice(9 * n, 9 * (n + 1))
        forward = (above.kirchhoff[own] - stress) / h
        backward = (stress - below.kirchhoff[own]) / h
        best = min(best, float(np.abs(0.5 * (forward + backward).T - tangent).max() / scale))
        kink = float(np.abs(forward - backward).max() / scale)
    return None if TOLERANCE < best <= kink else best
