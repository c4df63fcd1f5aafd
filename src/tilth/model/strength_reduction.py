# SPDX-License-Identifier: BSD-3-Clause
"""Settings of the search for the factor of safety."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.davis import DavisForm
from tilth.model.fields import Name, Positive
from tilth.model.problems import reject, rejection

FINEST = 1e-4
"""Least tolerance of a factor of safety [-]."""


def _not_too_fine(value: float) -> float:
    if value < FINEST:
        raise reject(f"must be at least {FINEST:g}", "0.01 is usual")
    return value


FactorTolerance = Annotated[Positive, AfterValidator(_not_too_fine)]


class StrengthReduction(Declared):
    """Strength reduction: c and tan(phi), or s_u, divided by a factor until the soil collapses.

    Loads and boundaries stay as they are at the start; the state of the soil does not change.
    """

    type: Literal["strength_reduction"] = "strength_reduction"
    name: Name = "factor of safety"
    """Name in reports."""
    tolerance: FactorTolerance = 0.01
    """Greatest difference of the two factors between which the factor of safety lies [-], at least
    1e-4; what is undecided leaves a greater one."""
    start: Positive = 1.0
    """Factor that is tried first [-]; smaller ones follow if it has no equilibrium. At 1 the soil
    is as the run left it, unless `davis` is given: only a collapse leads below."""
    first_step: Positive = 0.1
    """First increase of the factor [-]; it is doubled while there is equilibrium, and halved where
    there is none."""
    minimum_factor: Positive = 0.1
    """Least factor that is tried [-]."""
    maximum_factor: Positive = 20.0
    """Greatest factor that is tried [-]."""
    displacement_ratio: Positive = 10.0
    """Displacement over the elastic one beyond which connected soil, at least three cells wide, has
    collapsed [-]. The elastic displacement is the mean elastic strain of the soil times its
    thickness."""
    davis: DavisForm | None = None
    """Form of Davis' associated equivalent that takes the place of soil with friction: with psi =
    phi, and c and tan(phi) times beta = cos(psi) cos(phi) / (1 - sin(psi) sin(phi)) of the declared
    angles ("A"), of both angles reduced by the factor ("B"), or of the reduced phi and the declared
    psi, at most phi ("C"). The soil itself if not given."""

    @model_validator(mode="after")
    def _in_order(self) -> Any:
        problems = []
        for key, wrong, than in (
            ("minimum_factor", self.minimum_factor > self.start, "at most `start`"),
            ("maximum_factor", self.maximum_factor < self.start, "at least `start`"),
        ):
            if wrong:
                what = f"must be {than} ({self.start:g})"
                problems.append(Problem(key, what, value=getattr(self, key)))
        if problems:
            raise rejection(problems)
        return self
