# SPDX-License-Identifier: BSD-3-Clause
"""The linear equations of a step: the matrix of all fields, and what of them is prescribed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from tilth.algebra.block_matrix import BlockMatrix
from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers.system import LinearSystem


class CoupledSystem:
    """The linear equations of a step.

    Args:
        active: the grid of the step, with the pattern of the displacement.
        matrix: of all fields; its entries change from iteration to iteration.
        constrained: which unknowns are none, by the names of the fields, (nodes, components) each.

    Attributes:
        matrix, constrained: see above.
        displacement: the equations of the displacement and of the global unknowns alone, with the
            nodes that an iterative solver may solve exactly.
        schur: approximations of what is left for each other field if the displacement is
            eliminated, K_pp - K_pu K_uu^-1 K_up, in the pattern of K_pp, shape (entries,
            components, components); of the sign that K_pp has. For preconditioners.
    """

    def __init__(
        self, active: ActiveGrid, matrix: BlockMatrix, constrained: Mapping[str, Flags]
    ) -> None:
        self.matrix, self.constrained = matrix, constrained
        values = matrix[DISPLACEMENT, DISPLACEMENT].values
        self.displacement = LinearSystem(active, constrained[DISPLACEMENT], values.ravel())
        self.schur: dict[str, Floats] = {}

    @property
    def is_coupled(self) -> bool:
        """Whether there are other fields than the displacement."""
        return len(self.matrix.fields) > 1


class SystemSolver(Protocol):
    """Solves the linear systems of one step."""

    @property
    def by_multigrid(self) -> bool:
        """Whether multigrid solves the next system."""
        ...

    def renew(self, similar: bool = False) -> None:
        """Discards what was made of the last matrix: the system has another one.

        similar: whether it is so close to the last one that the levels of multigrid may stay.
        """
        ...

    def solve(self, right_side: Unknowns, tolerance: float) -> Unknowns:
        """Returns the solution, 0 where constrained; right sides there do not matter.

        tolerance: relative residual that an iterative solver may leave, the residual of each field
            over its scale.

        Raises:
            SolveFailed: there is none.
        """
        ...
