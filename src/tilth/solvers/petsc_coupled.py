# SPDX-License-Identifier: BSD-3-Clause
"""Direct solution of the equations of several fields by several processes."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth import _core
from tilth.algebra.border import Border
from tilth.algebra.field import DISPLACEMENT
from tilth.arrays import Floats
from tilth.solvers.bordered_system import LARGEST_CONDITION, require_regular
from tilth.solvers.coupled_system import CoupledSystem
from tilth.solvers.free_unknowns import Entries, FreeUnknowns
from tilth.solvers.petsc_bordered import Factors
from tilth.solvers.protocol import SolveFailed
from tilth.solvers.row_scaling import RowScaling


class MumpsMatrix:
    """The matrix of all free unknowns, each process with its rows, and its factors by MUMPS.

    Args:
        system: has the matrices of a step.
        unknowns: the free ones.
    """

    name = "mumps"

    def __init__(self, system: CoupledSystem, unknowns: FreeUnknowns) -> None:
        import scipy.sparse as sp  # takes 0.2 s: only where it is used

        self._system, self._unknowns = system, unknowns
        self._scaling = RowScaling(system)
        entries = Entries.of(system.matrix, unknowns)
        index = entries.row - unknowns.first, entries.column
        shape = (unknowns.count, unknowns.total)
        self._places = sp.coo_matrix((entries.source, index), shape=shape).tocsr()
        self._places.sort_indices()
        self._factors: Factors | None = None
        self._with_border = self._filled = False

    def __del__(self) -> None:
        if (factors := getattr(self, "_factors", None)) is not None:
            factors.destroy()

    def renew(self) -> None:
        """Says that the system has another matrix."""
        self._filled = False

    def solve(self, right_side: Floats) -> Floats:
        """Returns the solution for a right side, (n,) each, of this process' unknowns.

        Raises:
            SolveFailed: the matrix is singular or nearly so.
        """
        factors = self._filled_factors()
        scale = self._scale
        return np.asarray(scale * factors.solve(scale * right_side))

    def _filled_factors(self) -> Factors:
        """Returns the present matrix with its factors."""
        if self._factors is not None and self._filled:
            return self._factors
        comm, matrix, border = self._unknowns.comm, self._system.matrix, self._system.matrix.border
        scale = self._unknowns.of_fields(self._scaling.factors())
        columns = np.concatenate(comm.gathered(scale))
        places = self._places
        values = np.empty(len(places.data))
        _core.gather(places.data, matrix.memory, values)
        if comm.max(float(not np.isfinite(values).all())) > 0.0:
            raise SolveFailed("the matrix of the linear system has entries that are not numbers")
        values *= np.repeat(scale, np.diff(places.indptr))
        values *= columns[places.indices]
        if self._factors is not None and border is None and not self._with_border:
            self._factors.replace(values)
        else:
            if self._factors is not None:
                self._factors.destroy()
                self._factors = None
            rows = type(places)((values, places.indices, places.indptr), shape=places.shape)
            if border is not None:
                rows = self._bordered(rows, border.scaled())
                if self._unknowns.has_globals:
                    scale = np.concatenate([scale, 1.0 / border.scale])
            self._factors = Factors(comm, rows)
        self._scale, self._filled, self._with_border = scale, True, border is not None
        if border is not None:
            self._require_regular(self._factors, border.scaled())
        return self._factors

    def _bordered(self, rows: Any, border: Border) -> Any:
        """Returns the rows of this process with the columns, and at the last the rows, of it."""
        import scipy.sparse as sp

        unknowns, m = self._unknowns, border.unknowns
        number = unknowns.number[DISPLACEMENT].ravel()
        local = number - unknowns.first
        own = np.flatnonzero((local >= 0) & (local < unknowns.count) & (number >= 0))
        flat = border.columns.reshape(m, -1)[:, own]
        k, place = np.nonzero(flat)
        columns = sp.coo_matrix((flat[k, place], (local[own[place]], k)), (unknowns.count, m))
        parts = [[rows, columns]]
        flat = border.rows.reshape(m, -1)[:, own]
        k, place = np.nonzero(flat)
        of_all = unknowns.comm.gathered((flat[k, place], k, number[own[place]]))
        if unknowns.has_globals:
            value, k, column = (np.concatenate(each) for each in zip(*of_all, strict=True))
            last = sp.coo_matrix((value, (k, column)), (m, unknowns.total))
            parts.append([last, sp.csr_matrix(border.corner)])
        whole = sp.bmat(parts, format="csr")
        whole.sort_indices()
        return whole

    def _require_regular(self, factors: Factors, border: Border) -> None:
        """Raises `SolveFailed` if the equations of the global unknowns are nearly singular."""
        unknowns, comm, m = self._unknowns, self._unknowns.comm, border.unknowns
        inverse = np.empty((m, m))
        for k, unit in enumerate(np.eye(m)):
            of_border = unit[: None if unknowns.has_globals else 0]
            found = factors.solve(np.concatenate([np.zeros(unknowns.count), of_border]))
            inverse[:, k] = comm.gathered(found[unknowns.count :].copy())[-1]
        parts = (border.columns, border.rows, border.corner)
        terms = comm.max(max(float(np.abs(part).max()) for part in parts))
        require_regular(inverse, terms, LARGEST_CONDITION)
