# SPDX-License-Identifier: BSD-3-Clause
"""A model whose relation is checked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from random import Random

from metamorphic.choices import Choice
from metamorphic.models import Tree
from metamorphic.runs import Run, run_in_memory


@dataclass
class Subject:
    """A model whose relation is checked; choice: that it was made for; seed: of random amounts."""

    entries: Tree
    choice: Choice
    seed: str

    @cached_property
    def run(self) -> Run:
        return run_in_memory(self.entries)

    @property
    def kind(self) -> str:
        return str(self.entries["analysis"]["kind"])

    @property
    def dim(self) -> int:
        return 3 if self.kind == "3d" else 2

    @property
    def random(self) -> Random:
        """Random amounts of a relation, from the start."""
        return Random(self.seed)
