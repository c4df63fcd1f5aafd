# SPDX-License-Identifier: BSD-3-Clause
"""Values of all unknowns of a step, and vectors of the same form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tilth.algebra.field import DISPLACEMENT
from tilth.arrays import Floats


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Values of all fields and of the unknowns that belong to no node; or corrections, residuals.

    Attributes:
        of: by the names of the fields, shape (nodes, components) each.
        globals: of all terms, one term after the other, shape (m,); a term is given its own.
    """

    of: Mapping[str, Floats]
    globals: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def u(self) -> Floats:
        """The displacement of the nodes in the step [length], shape (nodes, dim)."""
        return self.of[DISPLACEMENT]

    def __getitem__(self, name: str) -> Floats:
        return self.of[name]

    def with_globals(self, values: Floats) -> Unknowns:
        """Returns the same with other global unknowns."""
        return Unknowns(self.of, values)

    def plus(self, other: Unknowns, share: float = 1.0) -> Unknowns:
        """Returns the sum with `share` times another one."""
        of = {name: own + share * other.of[name] for name, own in self.of.items()}
        return Unknowns(of, self.globals + share * other.globals)
