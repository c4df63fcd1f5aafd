# SPDX-License-Identifier: BSD-3-Clause
"""A row of random choices in which every pair of values that is allowed occurs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from random import Random

from metamorphic.choices import (
    DIMENSIONS,
    PLAIN,
    Choice,
    Pair,
    all_pairs,
    pairs_of,
    says_something,
    settled,
)

DENSITY = 0.4
"""Share of the dimensions that are not plain, apart from what a pair asks for."""
CANDIDATES = 16
"""Choices that are compared for each model."""
TRIALS = 6
"""Models of a pair that are refused or say nothing before it counts as such."""


@dataclass
class Covering:
    """Choices one after the other.

    Args:
        seed: of the choices.
        refused: message with which a choice's model is refused, empty if it is not.

    Attributes:
        missing: pairs that have not occurred yet.
        left_out: pairs that cannot occur, with the message of the last model that had them.
    """

    seed: int
    refused: Callable[[Choice, str], str]
    missing: dict[Pair, int] = field(default_factory=lambda: dict.fromkeys(all_pairs(), 0))
    left_out: dict[Pair, str] = field(default_factory=dict)

    def choices(self, count: int) -> Iterator[tuple[str, Choice]]:
        """Yields names and choices of models."""
        number = tries = 0
        while number < count:
            name = f"{self.seed}-{number}"
            choice = self._next(name, tries)
            tries += 1
            if choice is not None:
                number, tries = number + 1, 0
                for pair in pairs_of(choice):
                    self.missing.pop(pair, None)
                yield name, choice

    def _next(self, name: str, tries: int) -> Choice | None:
        """tries: before this one; where no pair is missing a choice is another in each."""
        random = Random(name if self.missing or not tries else f"{name} {tries}")
        pair = min(self.missing, key=self.missing.__getitem__, default=None)
        pinned = {} if pair is None else dict(pair)
        message = "the relation says nothing of it"
        drawn = [
            settled(self._drawn(random), pinned, random) for _ in range(CANDIDATES if pinned else 1)
        ]
        for choice in sorted(filter(says_something, drawn), key=self._new, reverse=True):
            message = self.refused(choice, name)
            if not message:
                return choice
        if pair is not None:
            self.missing[pair] += 1
            if self.missing[pair] >= TRIALS:
                del self.missing[pair]
                self.left_out[pair] = message
        return None

    def _drawn(self, random: Random) -> Choice:
        return {
            name: random.choice(values) if random.random() < DENSITY else PLAIN[name]
            for name, values in DIMENSIONS.items()
        }

    def _new(self, choice: Choice) -> int:
        return sum(pair in self.missing for pair in pairs_of(choice))
