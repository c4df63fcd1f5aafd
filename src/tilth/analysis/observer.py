# SPDX-License-Identifier: BSD-3-Clause
"""What watches the load steps of a run while they are solved, without any effect on them."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from enum import Enum, auto
from typing import Final

from tilth.analysis.residual import Guess, Iterate, Newton
from tilth.model import Model
from tilth.mpm.soil import Soil
from tilth.terms.balance import Balance


class Search(Enum):
    """What an iteration of Newton's method looks for."""

    STEP = auto()
    """The equilibrium of the step."""
    CREEPING = auto()
    """Where soil that creeps against a drag is after a pseudo-step."""
    REST = auto()
    """The equilibrium of the step, without drag, from where the soil has crept."""


class Observer:
    """Is shown the attempts at each load step, from the first to the accepted one.

    An attempt at a step is one `Simulation.advance`; within it Newton's iteration may be begun
    several times. This one looks at nothing.
    """

    def attempt(
        self, model: Model, number: int, before: float, after: float
    ) -> AbstractContextManager[None]:
        """Surrounds an attempt at a step; an error that leaves it is that of the attempt.

        Args:
            model: of the present stage.
            number: of the step, counted through all stages from 1.
            before, after: times of the stage at its start and end.
        """
        return nullcontext()

    def prepared(self, soil: Soil, balance: Balance) -> None:
        """Is shown the terms of the attempt; what is shown may not be changed.

        Args:
            soil: on the grid of the step.
            balance: of the step, whose forces may be kept.
        """

    def solving(
        self, newton: Newton, guess: Guess | None, search: Search
    ) -> AbstractContextManager[None]:
        """Surrounds one iteration of Newton's method; an error that leaves it is its failure.

        newton: its settings. guess: where it begins; None for the start of the step.
        search: what it looks for.
        """
        return nullcontext()

    def iteration(self, number: int, state: Iterate, moving: bool) -> None:
        """Is shown the state after an iteration, to which the trial state of all terms belongs.

        number: of linear solves before. moving: whether prescribed degrees of freedom have yet to
        move: the forces are then those at the start of the step.
        """


UNOBSERVED: Final = Observer()
"""Looks at nothing."""
