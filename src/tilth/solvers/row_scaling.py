# SPDX-License-Identifier: BSD-3-Clause
"""Factors that make residuals of different equations comparable with forces."""

from __future__ import annotations

import numpy as np

from tilth.algebra.field import DISPLACEMENT, MOMENTUM
from tilth.arrays import Floats, Integers
from tilth.solvers.coupled_system import CoupledSystem


class RowScaling:
    """Factors of the rows of a step's systems; all processes call its methods together.

    A residual over the scale of its field has the unit of its equation. Times the square root of
    the ratio of the typical diagonal of the displacement to that of the equation it is a force:
    the same factor of an unknown makes the whole matrix one of stiffnesses.

    Args:
        system: has the matrices.
    """

    def __init__(self, system: CoupledSystem) -> None:
        self._system = system
        self._diagonal = {name: diagonal_of(system, name) for name in system.matrix.fields}

    def factors(self) -> dict[str, Floats]:
        """Returns the factor of each component, by the fields' names, for the present matrix.

        That of an equation is a power of two, 1 for momentum.
        """
        of_equation, found = {MOMENTUM: 1.0}, {}
        typical = self._typical(DISPLACEMENT)
        for name, field in self._system.matrix.fields.items():
            if field.equation not in of_equation:
                ratio = np.sqrt(typical / self._typical(name))
                usable = np.isfinite(ratio) and ratio > 0.0
                factor = float(np.exp2(np.round(np.log2(ratio)))) if usable else 1.0
                of_equation[field.equation] = factor
            scale = np.ones(field.components) if field.scale is None else field.scale
            found[name] = of_equation[field.equation] / scale
        return found

    def _typical(self, name: str) -> np.float64:
        """Returns the geometric mean of the diagonal of a field; NaN without free unknowns."""
        system, field = self._system, self._system.matrix.fields[name]
        values = system.schur.get(name, system.matrix[name, name].values)
        diagonal = np.einsum("eii->ei", values[self._diagonal[name]])
        if field.scale is not None:
            diagonal = diagonal / field.scale**2
        own = field.nodes.owned
        size = np.abs(diagonal[own][~system.constrained[name][own]])
        logs, comm = np.log(size[size > 0.0]), field.nodes.comm
        count = comm.sum(float(len(logs)))
        total = comm.sum(float(logs.sum()))
        return np.exp(np.float64(total / count)) if count else np.float64(np.nan)


def diagonal_of(system: CoupledSystem, name: str) -> Integers:
    """Returns the positions of the diagonal blocks of a field, shape (nodes,)."""
    if name == DISPLACEMENT:
        return system.displacement.active.diagonal
    pattern = system.matrix[name, name].pattern
    row = np.repeat(np.arange(len(pattern.row_start) - 1), np.diff(pattern.row_start))
    return np.flatnonzero(row == pattern.column)
