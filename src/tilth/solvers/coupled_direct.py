# SPDX-License-Identifier: BSD-3-Clause
"""Direct solution of the equations of several fields in one process."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from tilth import _core
from tilth.algebra.field import DISPLACEMENT
from tilth.arrays import Floats, Integers
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers.bordered_system import factorise_with_border
from tilth.solvers.coupled_system import CoupledSystem
from tilth.solvers.free_unknowns import Entries, FreeUnknowns
from tilth.solvers.grid_fields import grid_of
from tilth.solvers.linear import LinearSolver
from tilth.solvers.protocol import Matrix, Solver
from tilth.solvers.row_scaling import RowScaling


class WholeMatrix:
    """The matrix of all free unknowns, and its factors by a direct solver.

    The unknowns of the grid are in the order of nested dissection, all fields of a node together;
    those of members follow, the global ones are the last.

    Args:
        system: has the matrices of a step.
        unknowns: the free ones.
        owner: has the direct solvers.
    """

    def __init__(self, system: CoupledSystem, unknowns: FreeUnknowns, owner: LinearSolver) -> None:
        import scipy.sparse as sp  # takes 0.2 s: only where it is used

        self._system, self._unknowns, self._owner = system, unknowns, owner
        self._scaling = RowScaling(system)
        self._order = _order(system, unknowns)
        place = np.empty(len(self._order), dtype=np.int32)
        place[self._order] = np.arange(len(place))
        entries = Entries.of(system.matrix, unknowns)
        index = place[entries.row], place[entries.column]
        found = sp.coo_matrix((entries.source, index), shape=(len(place), len(place))).tocsc()
        found.sort_indices()
        self._source, self._row, self._start = found.data, found.indices, found.indptr
        self._column = np.repeat(np.arange(len(place)), np.diff(found.indptr))
        self._solve: Callable[[Floats], Floats] | None = None

    @property
    def name(self) -> str:
        """Name of the direct solver of the present matrix."""
        return self._solver.name

    @property
    def _solver(self) -> Solver:
        fields, owner = self._system.matrix.fields, self._owner
        on_grid = [each for each in fields.values() if isinstance(each.nodes, ActiveGrid)]
        if len(on_grid) < len(fields) or self._system.matrix.border is not None:
            return owner.direct
        components = sum(each.components for each in on_grid)
        return owner.direct_for(self._system.displacement, components)

    def renew(self) -> None:
        """Discards the factors of the last matrix."""
        self._solve = None

    def solve(self, right_side: Floats) -> Floats:
        """Returns the solution for a right side, shape (n,), in the order of the free unknowns.

        Raises:
            SolveFailed: the matrix is singular or nearly so.
        """
        if self._solve is None:
            self._solve = self._factorised()
        return self._solve(right_side)

    def _factorised(self) -> Callable[[Floats], Floats]:
        matrix, order, count = self._system.matrix, self._order, self._unknowns.count
        scale = self._unknowns.of_fields(self._scaling.factors())[order]
        values = np.empty(len(self._source))
        _core.gather(self._source, matrix.memory, values)
        values *= scale[self._row]
        values *= scale[self._column]
        whole = Matrix(values, self._row, self._start, self._unknowns.comm)
        border, solver = matrix.border, self._solver
        solve: Callable[[Floats], Floats]
        if border is None:
            solver.setup(whole)
            solve = partial(_solution, solver)
        else:
            scaled = border.scaled()
            columns = self._at_unknowns({DISPLACEMENT: scaled.columns})[:, order]
            rows = self._at_unknowns(scaled.rows_by_field())[:, order]
            solve = factorise_with_border(solver, whole, scaled, columns, rows)
            scale = np.concatenate([scale, 1.0 / border.scale])
            order = np.concatenate([order, np.arange(count, count + border.unknowns)])

        def unscaled(right_side: Floats) -> Floats:
            found = np.empty_like(right_side)
            found[order] = scale * solve(scale * right_side[order])
            return found

        return unscaled

    def _at_unknowns(self, values: Mapping[str, Floats]) -> Floats:
        """Returns values of fields (m, nodes, components) at the unknowns, shape (m, n)."""
        found = np.zeros((len(values[DISPLACEMENT]), self._unknowns.count))
        for name, each in values.items():
            number = self._unknowns.number[name].ravel()
            found[:, number[number >= 0]] = each.reshape(len(each), -1)[:, number >= 0]
        return found


def _solution(solver: Solver, right_side: Floats) -> Floats:
    return solver.solve(right_side).x


def _order(system: CoupledSystem, unknowns: FreeUnknowns) -> Integers:
    """Returns the free unknowns in the order of their elimination."""
    active = system.displacement.active
    fields = system.matrix.fields
    on_grid = [name for name, each in fields.items() if isinstance(each.nodes, ActiveGrid)]
    distance = max(grid_of(system, name).coupling_distance for name in on_grid)
    rank = np.empty(active.nodes, dtype=np.int64)
    rank[np.asarray(_core.nested_dissection(active.lattice, distance))] = np.arange(active.nodes)
    of_node = np.full(unknowns.count, active.nodes)
    for name in on_grid:
        number = unknowns.number[name]
        of_node[number[number >= 0]] = np.repeat(rank[:, None], number.shape[1], 1)[number >= 0]
    return np.argsort(of_node, kind="stable")
