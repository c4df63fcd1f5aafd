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
from tilth.comm import Communicator, norm
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
    comm, own, shape = system.comm, system.active.owned, system.constrained.shape
    is_last, nodes = comm.rank == comm.size - 1, system.active.owned_nodes * shape[1]
    whole = Factors(comm, _rows(system, border))
    try:
        inverse = np.empty((border.unknowns, border.unknowns))
        for k, unit in enumerate(np.eye(border.unknowns)):
            found = whole.solve(np.concatenate([np.zeros(nodes), unit[: None if is_last else 0]]))
            inverse[:, k] = comm.gathered(found[nodes:].copy())[-1]
        largest = max(float(np.abs(part).max()) for part in (border.columns, border.rows))
        terms = comm.max(max(largest, float(np.abs(border.corner).max())))
        require_regular(inverse, terms, LARGEST_CONDITION)
        nodal = np.where(system.constrained, 0.0, right_side)[own].ravel()
        found = whole.solve(np.concatenate([nodal, global_right_side[: None if is_last else 0]]))
        x = np.zeros(shape)
        x[own] = found[:nodes].reshape(-1, shape[1])
        return system.active.updated(x), comm.gathered(found[nodes:].copy())[-1]
    finally:
        whole.destroy()


class Factors:
    """A matrix in PETSc, its rows over the processes, and its factors by MUMPS.

    Args:
        comm: the processes; all call each method together.
        rows: those of this process in SciPy's format, columns ascending.
    """

    def __init__(self, comm: Communicator, rows: Any) -> None:
        from petsc4py import PETSc

        self._comm = comm
        size = (rows.shape[0], None)
        kind = PETSc.IntType
        self._pattern = rows.indptr.astype(kind), rows.indices.astype(kind)
        mpi = getattr(comm, "mpi", PETSc.COMM_SELF)
        csr = (*self._pattern, rows.data)
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

    def replace(self, entries: Floats) -> None:
        """Takes the entries of another matrix of the same pattern."""
        self._matrix.setValuesCSR(*self._pattern, entries)
        self._matrix.assemble()

    def solve(self, right_side: Floats) -> Floats:
        """Returns the solution, both of the rows of this process, with refinement where it helps.

        Raises:
            SolveFailed: the residual does not fall below `LARGEST_RESIDUAL`.
        """
        b, x = self._matrix.createVecs()
        b.array[:], x.array[:] = right_side, 0.0  # PETSc's may be one that it remembers
        self._refine(b, x)
        found: Floats = x.array.copy()
        for each in (b, x):
            each.destroy()
        return found

    def _refine(self, b: Any, x: Any) -> None:
        size = norm(self._comm, b.array)
        if size == 0.0:
            return
        residual, correction = b.copy(), x.duplicate()
        for _ in range(1 + MAXIMUM_REFINEMENTS):
            self._solver.solve(residual, correction)
            x.axpy(1.0, correction)
            self._matrix.mult(x, residual)
            residual.aypx(-1.0, b)
            relative = norm(self._comm, residual.array) / size
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
