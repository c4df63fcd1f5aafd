# SPDX-License-Identifier: BSD-3-Clause
"""The equations of single fields on the nodes of the active grid."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from tilth.algebra.field import DISPLACEMENT
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Pattern
from tilth.solvers.coupled_system import CoupledSystem
from tilth.solvers.row_scaling import diagonal_of
from tilth.solvers.system import LinearSystem


@dataclass(frozen=True, eq=False)
class GridOfField(ActiveGrid):
    """The active grid with the pattern of another field than the displacement.

    Attributes:
        pattern: of that field with itself.
    """

    pattern: Pattern | None = None

    @property
    def _pattern(self) -> Pattern:
        assert self.pattern is not None
        return self.pattern


def grid_of(system: CoupledSystem, name: str) -> ActiveGrid:
    """Returns the active grid with the pattern of one of its fields."""
    active = system.displacement.active
    if name == DISPLACEMENT:
        return active
    same = {each.name: getattr(active, each.name) for each in fields(ActiveGrid)}
    pattern = system.matrix[name, name].pattern
    assert isinstance(pattern, Pattern), "fields of the grid have patterns of the grid"
    return GridOfField(**same, pattern=pattern)


class EliminatedSystem:
    """Equations of a field of the grid that remain if the displacement is eliminated.

    Args:
        system: has the matrices of all fields, and `schur`.
        name: of the field.

    Attributes:
        linear: its equations, of the sign that makes their diagonal positive.
    """

    def __init__(self, system: CoupledSystem, name: str) -> None:
        self._system, self._name = system, name
        self.linear = LinearSystem(grid_of(system, name), system.constrained[name])
        self._diagonal = diagonal_of(system, name)
        self.sign = 1.0

    def fill(self) -> None:
        """Takes the matrix that the system has now; all processes call it."""
        system, name = self._system, self._name
        values = system.schur.get(name, system.matrix[name, name].values)
        own = self.linear.active.owned
        diagonal = np.einsum("eii->ei", values[self._diagonal])[own]
        trace = float(diagonal[~self.linear.constrained[own]].sum())
        self.sign = -1.0 if self.linear.comm.sum(trace) < 0.0 else 1.0
        np.multiply(values, self.sign, out=self.linear.blocks)
