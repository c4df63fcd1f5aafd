# SPDX-License-Identifier: BSD-3-Clause
"""Direct solution, by several processes, of systems with unknowns that belong to no node.

MUMPS factorises the whole matrix [[A, B], [C, D]], as the direct solvers of one process do: A may
be singular. The global unknowns are the last ones of the last process.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth.algebra.border import Border
from tilth.arrays import Floats
from tilth.comm import norm
from tilth.solvers.bordered_system import LARGEST_CONDITION, require_regular
from tilth.solvers.protocol import LARGEST_RESIDUAL, SolveFailed
from tilth.solvers.system import LinearSystem

REFINED = 1e-12
"""Relative residual below which a solution is not refined."""

MAXIMUM_REFINEMENTS = 3
"""Number of refinements after which a solution that leaves more than `LARGEST_RESIDUAL` failed."""

WORKSPACE = 50
"""Percent by which MUMPS' working memory exceeds its estimate: rows of the border are long."""

PREFIX = "tilth_bordered_"
"""Of PETSc's options."""


def solve_bordered_directly(
    system: LinearSystem, border: Border, right_side: Floats, global_right_side: Floats
) -> tuple[Floats, Floats]:
    """Returns nodal and global unknowns; all processes call it.

    Args:
        system: contains A.
        border: contains B, C and D, scaled.
        right_side: r, shape (nodes, components).
        global_right_side: s, scaled, shape (m,), the same in all processes.

    Returns:
        x, shape (nodes, components), zero where constrained, and g, scaled, shape (m,).

    Raises:
        SolveFailed: if the matrix is singular or nearly so.
    """
    whole = _Whole(system, border)
    try:
        inverse = np.stack([whole.solve(None, unit)[1] for unit in np.eye(border.unknowns)], axis=1)
        comm = system.comm
        largest = max(float(np.abs(part).max()) for part in (border.columns, border.rows))
        terms = comm.max(max(largest, float(np.abs(border.corner).max())))
        require_regular(inverse, terms, LARGEST_CONDITION)
        return whole.solve(right_side, global_right_side)
    finally:
        whole.destroy()


class _Whole:
    """The whole matrix in PETSc, its rows over the processes, and its factors.

    Args:
        system, border: see `solve_bordered_directly`.
    """

    def __init__(self, system: LinearSystem, border: Border) -> None:
        from petsc4py import PETSc

        self._system, self._unknowns = system, border.unknowns
        self._is_last = system.comm.rank == system.comm.size - 1
        rows = _rows(system, border)
        size = (rows.shape[0], None)
        kind = PETSc.IntType
        csr = (rows.indptr.astype(kind), rows.indices.astype(kind), rows.data)
        mpi = getattr(system.comm, "mpi", PETSc.COMM_SELF)
        self._matrix = PETSc.Mat().createAIJ((size, size), csr=csr, comm=mpi)
        self._matrix.assemble()
        self._solver = PETSc.KSP().create(comm=mpi)
        self._solver.setOperators(self._matrix)
        self._solver.setOptionsPrefix(PREFIX)
        options = PETSc.Options()
        for key, value in {
            "ksp_type": "preonly",
            "pc_type": "lu",
            "pc_factor_mat_solver_type": "mumps",
            "mat_mumps_icntl_14": WORKSPACE,
        }.items():
            options[PREFIX + key] = value
        self._solver.setFromOptions()

    def destroy(self) -> None:
        """Frees the memory of matrix and factors."""
        self._solver.destroy()
        self._matrix.destroy()

    def solve(self, nodal: Floats | None, of_border: Floats) -> tuple[Floats, Floats]:
        """Returns nodal and global unknowns for a right side; the nodal part is zero if None.

        Raises:
            SolveFailed: the residual does not fall below `LARGEST_RESIDUAL`.
        """
        system = self._system
        own, shape = system.active.owned, system.constrained.shape
        b, x = self._matrix.createVecs()
        b.array[:] = 0.0
        nodes = system.active.owned_nodes * system.components
        if nodal is not None:
            b.array[:nodes] = np.where(system.constrained, 0.0, nodal)[own].ravel()
        if self._is_last:
            b.array[nodes:] = of_border
        self._refine(b, x)
        found = np.zeros(shape)
        found[own] = x.array[:nodes].reshape(-1, system.components)
        unknowns: Floats = system.comm.gathered(x.array[nodes:].copy())[-1]
        for each in (b, x):
            each.destroy()
        return system.active.updated(found), unknowns

    def _refine(self, b: Any, x: Any) -> None:
        """Solves for b, with iterative refinement where it helps."""
        comm = self._system.comm
        size, x.array[:] = norm(comm, b.array), 0.0  # PETSc's may be one that it remembers
        if size == 0.0:
            return
        residual, correction = b.copy(), x.duplicate()
        for _ in range(1 + MAXIMUM_REFINEMENTS):
            self._solver.solve(residual, correction)
            x.axpy(1.0, correction)
            self._matrix.mult(x, residual)
            residual.aypx(-1.0, b)
            relative = norm(comm, residual.array) / size
            if not REFINED <= relative < np.inf:
                break
        residual.destroy()
        correction.destroy()
        if not relative < LARGEST_RESIDUAL:
            raise SolveFailed(f"the linear system is singular (relative residual {relative:.1e})")


def _rows(system: LinearSystem, border: Border) -> Any:
    """Returns this process' rows of the whole matrix in SciPy's format, columns ascending."""
    import scipy.sparse as sp  # takes 0.2 s: only where it is used

    active, count, unknowns = system.active, system.components, border.unknowns
    shared, free = active.shared, ~system.constrained
    number = np.arange(active.nodes) if shared is None else shared.number
    total = active.nodes if shared is None else shared.total
    nodes = np.arange(active.nodes)[active.owned]
    blocks = np.diff(active.row_start)[nodes]
    start = np.concatenate([[0], np.cumsum(blocks)])
    entry = np.arange(start[-1]) + np.repeat(active.row_start[nodes] - start[:-1], blocks)
    row, column = np.repeat(nodes, blocks), active.column[entry]
    values = system.blocks[entry] * free[row][:, :, None] * free[column][:, None, :]
    k = np.arange(count)
    values[np.flatnonzero(row == column)[:, None], k, k] += ~free[nodes]
    shape = (len(nodes) * count, total * count)
    within = sp.bsr_matrix((values, number[column], start), shape=shape)
    columns = np.where(free, border.columns, 0.0)[:, nodes].reshape(unknowns, -1)
    parts = [[within.tocsr(), sp.csr_matrix(columns.T)]]
    of_rows = np.where(free, border.rows, 0.0)[:, nodes]
    which = np.nonzero(of_rows)
    of_all = system.comm.gathered((which[0], number[nodes[which[1]]] * count + which[2],
                                   of_rows[which]))  # fmt: skip
    if system.comm.rank == system.comm.size - 1:
        unknown, place, value = (np.concatenate(each) for each in zip(*of_all, strict=True))
        last = sp.csr_matrix((value, (unknown, place)), shape=(unknowns, shape[1]))
        parts.append([last, sp.csr_matrix(border.corner)])
    whole = sp.bmat(parts, format="csr")
    whole.sort_indices()
    return whole
