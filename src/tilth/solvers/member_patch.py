# SPDX-License-Identifier: BSD-3-Clause
"""Exact solution of members together with the soil that they touch.

A member is stiff, and the springs between it and the soil are, too: a preconditioner that treats
one after the other needs the more iterations, the stiffer the springs are beside the soil.
"""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.algebra.field import DISPLACEMENT
from tilth.arrays import Floats, Integers
from tilth.memory_errors import is_memory_error
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers.coupled_system import CoupledSystem
from tilth.solvers.free_unknowns import Entries, FreeUnknowns
from tilth.solvers.multigrid import INCREASED_EXACT_UNKNOWNS
from tilth.solvers.protocol import SolveFailed


class MemberPatch:
    """The unknowns of all fields with nodes of their own, and of the soil nodes that they touch.

    With more unknowns than multigrid solves exactly, the patch has those of the members alone. All
    processes have the factors; they call all methods together.

    Args:
        system: has the matrices of a step.
        unknowns: the free ones.
    """

    def __init__(self, system: CoupledSystem, unknowns: FreeUnknowns) -> None:
        self._system, self._unknowns = system, unknowns
        number = _of_patch(system, unknowns)
        self._own = number[(number >= unknowns.first) & (number < unknowns.first + unknowns.count)]
        place = np.full(unknowns.total, -1)
        place[number] = np.arange(len(number))
        entries = Entries.of(system.matrix, unknowns, place >= 0)
        row, column = place[entries.row], place[entries.column]
        inside = (row >= 0) & (column >= 0)
        self._index = row[inside], column[inside]
        self._source = entries.source[inside]
        self._place = place[self._own]
        self._size = len(number)

    def fill(self) -> None:
        """Takes the matrix that the system has now.

        Raises:
            SolveFailed: that of the patch is singular.
        """
        import scipy.sparse as sp  # take 0.2 s: only where they are used
        from scipy.sparse.linalg import splu

        values = np.empty(len(self._source))
        _core.gather(self._source, self._system.matrix.memory, values)
        parts = self._unknowns.comm.gathered((*self._index, values))
        row, column, values = (np.concatenate(each) for each in zip(*parts, strict=True))
        matrix = sp.coo_matrix((values, (row, column)), shape=(self._size, self._size))
        try:
            self._factors = splu(matrix.tocsc())
        except RuntimeError as error:
            if is_memory_error(error):
                raise MemoryError(f"SuperLU: {error}") from error
            raise SolveFailed(f"the matrix of members is singular ({error})") from error

    def solve(self, residual: Floats) -> Floats:
        """Returns the correction that removes a residual in the patch; 0 elsewhere.

        residual, correction: of the unknowns that this process owns, shape (n,).
        """
        own = self._own - self._unknowns.first
        whole = np.zeros(self._size)
        for place, values in self._unknowns.comm.gathered((self._place, residual[own])):
            whole[place] = values
        correction = np.zeros_like(residual)
        correction[own] = self._factors.solve(whole)[self._place]
        return correction


def _of_patch(system: CoupledSystem, unknowns: FreeUnknowns) -> Integers:
    """Returns the numbers of the unknowns of the patch, ascending, the same in all processes."""
    matrix, comm = system.matrix, unknowns.comm
    of_members, of_soil = [], []
    for name, field in matrix.fields.items():
        if isinstance(field.nodes, ActiveGrid):
            continue
        of_members.append(unknowns.number[name].ravel())
        if (DISPLACEMENT, name) in matrix.blocks:
            start = matrix[DISPLACEMENT, name].pattern.row_start
            own = np.zeros(len(start) - 1, dtype=bool)
            own[matrix.fields[DISPLACEMENT].nodes.owned] = True
            of_soil.append(unknowns.number[DISPLACEMENT][own & (np.diff(start) > 0)].ravel())

    def together(parts: list[Integers]) -> Integers:
        own = np.concatenate([np.zeros(0, dtype=np.int64), *parts])
        found = np.unique(np.concatenate(comm.gathered(own)))
        return found[found >= 0]

    members, soil = together(of_members), together(of_soil)
    limit = INCREASED_EXACT_UNKNOWNS[system.displacement.active.grid.dim]
    whole = len(members) + len(soil) <= limit
    return np.union1d(members, soil) if whole else members
