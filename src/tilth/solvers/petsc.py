# SPDX-License-Identifier: BSD-3-Clause
"""Linear solvers of several processes: PETSc's Krylov methods with algebraic multigrid, and MUMPS.

Each process gives PETSc the rows of the nodes that it owns; they are complete, so that assembly
needs no messages. The rows and columns of constrained unknowns are those of the identity.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np

from tilth.arrays import Flags, Floats, Shorts
from tilth.comm import count, norm
from tilth.errors import BadInput
from tilth.mpi import INSTALL
from tilth.solvers.bordered_system import solve_condensed
from tilth.solvers.petsc_bordered import solve_bordered_directly
from tilth.solvers.protocol import SolveFailed
from tilth.solvers.system import LinearSystem

DIRECT = "mumps"
ITERATIVE = ("gamg", "hypre")

ITERATIVE_FROM_UNKNOWNS = {2: 400_000, 3: 30_000}
"""Dimension -> number of unknowns from which "auto" takes an iterative solver."""

MAXIMUM_ITERATIONS = 300
"""Iterations of a Krylov method after which the direct solver takes over."""

RESTART = 100
"""Iterations of GMRES after which it restarts."""

SYMMETRY_TOLERANCE = 1e-6
"""Relative asymmetry of a matrix up to which conjugate gradients are used."""

OPTIONS: dict[str, dict[str, str | float]] = {
    "gamg": {
        "pc_type": "gamg",
        "pc_gamg_type": "agg",
        "pc_gamg_agg_nsmooths": 1,
        "pc_gamg_threshold": 0.0,
        "mg_levels_ksp_type": "chebyshev",
        "mg_levels_pc_type": "jacobi",
        "mg_levels_ksp_max_it": 2,
        "pc_gamg_reuse_interpolation": "true",
    },
    "hypre": {
        "pc_type": "hypre",
        "pc_hypre_type": "boomeramg",
        "pc_hypre_boomeramg_strong_threshold": 0.5,
    },
    "mumps": {
        "ksp_type": "preonly",
        "pc_type": "lu",
        "pc_factor_mat_solver_type": "mumps",
    },
}
"""Options of PETSc by the name of the solver."""


class PetscSolver:
    """Solves the linear systems of all load steps; each step calls `begin`.

    Args:
        name: "auto", or a solver of `OPTIONS`.
        note: is called with the reason why an iterative solver failed.

    Attributes:
        solved: number of systems solved by each solver.
        iterations: of iterative solvers, for each system.

    Raises:
        BadInput: petsc4py cannot be imported.
    """

    def __init__(self, name: str, note: Callable[[str], None] = lambda reason: None) -> None:
        require_petsc()
        self.name, self.note = name, note
        self.solved: Counter[str] = Counter()
        self.iterations: list[int] = []

    def begin(self, system: LinearSystem) -> PetscStepSolver:
        """Returns the solver of the systems of one step, whose matrices `system` has in turn."""
        name = self.name
        if name == "auto":
            unknowns = system.components * count(system.comm, system.active.owned_nodes)
            large = unknowns >= ITERATIVE_FROM_UNKNOWNS[system.active.grid.dim]
            name = ITERATIVE[0] if large else DIRECT
        return PetscStepSolver(self, system, name)

    @property
    def summary(self) -> str:
        """Number of systems by solver, and the iterations of the iterative ones."""
        texts = [f"{number:,} by {name}" for name, number in self.solved.items()]
        if self.iterations:
            mean, most = float(np.mean(self.iterations)), max(self.iterations)
            texts.append(f"{mean:.1f} iterations each of the iterative solver, at most {most}")
        return ", ".join(texts) or "none"


def require_petsc() -> None:
    """Checks that petsc4py can be imported.

    Raises:
        BadInput: it cannot.
    """
    try:
        from petsc4py import PETSc  # noqa: F401
    except ImportError as error:
        missing = find_spec("petsc4py") is None
        reason = "is not installed" if missing else f"cannot be imported ({error})"
        raise BadInput(
            f"petsc4py, the linear solver of several processes, {reason}", INSTALL
        ) from (error)


class PetscStepSolver:
    """Solves the linear systems of one load step.

    If the iterative solver fails, the direct one solves the remaining systems of the step.

    Args:
        owner: counts.
        system: has the matrix; `renew` says that it is a new one.
        name: of the solver.
    """

    def __init__(self, owner: PetscSolver, system: LinearSystem, name: str) -> None:
        self._owner, self._system, self._name = owner, system, name
        self._rows = _OwnedRows(system)
        self._solvers: dict[str, Any] = {}
        self._filled = False

    @property
    def by_multigrid(self) -> bool:
        """Whether an iterative solver solves the next system."""
        return self._name in ITERATIVE

    def renew(self, similar: bool = False) -> None:
        """Discards what was made of the last matrix: the system has another one."""
        self._filled = False

    def solve(self, right_side: Floats, tolerance: float) -> Floats:
        """Returns the nodal solution of A x = r, shape (nodes, components), 0 where constrained.

        A border of the system is left out. At nodes of other processes the solution is theirs.

        Args:
            right_side: r, shape (nodes, components).
            tolerance: relative residual required of an iterative solver.

        Raises:
            SolveFailed: if the direct solver fails.
        """
        if not self._filled:
            self._rows.fill()
            self._filled = True
            for solver in self._solvers.values():
                solver.setOperators(self._rows.matrix)
        try:
            return self._solve(self._name, right_side, tolerance)
        except SolveFailed as error:
            if not self.by_multigrid:
                raise
            self._owner.note(str(error))
            self._name = DIRECT
            return self._solve(DIRECT, right_side, tolerance)

    def solve_bordered(
        self, right_side: Floats, global_right_side: Floats, tolerance: float
    ) -> tuple[Floats, Floats]:
        """As `StepSolver.solve_bordered`."""
        system = self._system
        if system.border is None:
            return self.solve(right_side, tolerance), np.zeros(0)
        scale, border = system.border.scale, system.border.scaled()
        scaled = global_right_side / scale
        if self.by_multigrid:
            try:
                x, g = solve_condensed(system, border, self.solve, right_side, scaled, tolerance)
                return x, g / scale
            except SolveFailed as error:
                self._owner.note(str(error))
                self._name = DIRECT
        x, g = solve_bordered_directly(system, border, right_side, scaled)
        self._owner.solved[DIRECT] += 1
        return x, g / scale

    def _solve(self, name: str, right_side: Floats, tolerance: float) -> Floats:
        system, rows = self._system, self._rows
        owned = np.where(system.constrained, 0.0, right_side)[system.active.owned]
        size = norm(system.comm, owned)
        if not math.isfinite(size):
            raise SolveFailed("the linear system has entries that are not numbers")
        found = np.zeros_like(right_side)
        if size == 0.0:
            return found
        solver = self._solvers.get(name)
        if solver is None:
            solver = self._solvers[name] = rows.solver(name)
        b, x = rows.matrix.createVecs()
        b.array[:] = owned.ravel()
        solver.setTolerances(rtol=tolerance, atol=0.0, max_it=MAXIMUM_ITERATIONS)
        solver.solve(b, x)
        reason = solver.getConvergedReason()
        residual = rows.matrix.createVecLeft()
        rows.matrix.mult(x, residual)
        left = norm(system.comm, b.array - residual.array) / size
        limit = 2.0 * tolerance if name in ITERATIVE else 1e-8
        if not left <= limit:
            steps = solver.getIterationNumber()
            raise SolveFailed(
                f"{name} did not solve a linear system (relative residual {left:.1e} after {steps} "
                f"iterations, reason {reason} of PETSc)"
            )
        self._owner.solved[name] += 1
        if name in ITERATIVE:
            self._owner.iterations.append(solver.getIterationNumber())
        found[system.active.owned] = x.array.reshape(-1, system.components)
        for each in (b, x, residual):
            each.destroy()
        return system.active.updated(found)


class _OwnedRows:
    """The matrix of the owned nodes' rows in PETSc.

    Attributes:
        matrix: of PETSc.
    """

    def __init__(self, system: LinearSystem) -> None:
        from petsc4py import PETSc

        active, components = system.active, system.components
        self._system = system
        shared = active.shared
        number = np.arange(active.nodes) if shared is None else shared.number
        first = 0 if shared is None else shared.first
        nodes = active.owned_nodes
        owned = np.arange(active.nodes)[active.owned]
        counts = np.diff(active.row_start)[owned]
        self._start = np.concatenate([[0], np.cumsum(counts)])
        entry = np.arange(self._start[-1]) + np.repeat(
            active.row_start[owned] - self._start[:-1], counts
        )
        row, column = np.repeat(owned, counts), active.column[entry]
        free = ~system.constrained
        self._entry, self._row, self._column = entry, row, column
        self._diagonal = np.flatnonzero(row == column)
        self._fixed: Flags = ~free[owned]
        self._index: Shorts = number[column].astype(PETSc.IntType)
        self._mask = free
        local = (self._index >= first) & (self._index < first + nodes)
        inside = np.add.reduceat(local, self._start[:-1]) if nodes else np.zeros(0, dtype=np.int64)
        self.matrix = PETSc.Mat().create(comm=_communicator(system))
        self.matrix.setSizes(((nodes * components, None), (nodes * components, None)))
        self.matrix.setBlockSize(components)
        self.matrix.setType("aij")
        per_row = [
            np.repeat(part * components, components).astype(PETSc.IntType)
            for part in (inside, counts - inside)
        ]
        self.matrix.setPreallocationNNZ(tuple(per_row))
        self.matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, True)
        self._int_start = self._start.astype(PETSc.IntType)

    def fill(self) -> None:
        """Sets the entries to those of the system."""
        system = self._system
        blocks = system.blocks[self._entry]
        blocks *= self._mask[self._row][:, :, None]
        blocks *= self._mask[self._column][:, None, :]
        k = np.arange(system.components)
        blocks[self._diagonal[:, None], k, k] += self._fixed
        self.matrix.setValuesBlockedCSR(
            self._int_start, self._index, np.ascontiguousarray(blocks).ravel()
        )
        self.matrix.assemble()

    def solver(self, name: str) -> Any:
        """Returns PETSc's solver of this matrix by its name in `OPTIONS`."""
        from petsc4py import PETSc

        options = dict(OPTIONS[name])
        if name in ITERATIVE:
            options["ksp_type"] = "cg" if self._asymmetry() < SYMMETRY_TOLERANCE else "fgmres"
            options["ksp_gmres_restart"] = RESTART
        solver = PETSc.KSP().create(comm=self.matrix.comm)
        solver.setOperators(self.matrix)
        prefix = f"tilth_{name}_"
        solver.setOptionsPrefix(prefix)
        database = PETSc.Options()
        for key, value in options.items():
            database[prefix + key] = value
        if name == "gamg":
            self.matrix.setNearNullSpace(self._rigid_motions())
        solver.setFromOptions()
        if name in ITERATIVE:
            solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        return solver

    def _rigid_motions(self) -> Any:
        """Returns the rigid motions of the free unknowns, for the coarse levels."""
        from petsc4py import PETSc

        system = self._system
        active, dim = system.active, system.components
        place = active.position[active.owned]
        middle = np.mean([active.grid.position(np.zeros(active.grid.dim))], axis=0)
        x = (place - middle) / float(active.grid.cell_size.max())
        modes = []
        for k in range(dim):
            mode = np.zeros_like(x)
            mode[:, k] = 1.0
            modes.append(mode)
        for i, j in [(0, 1)] if dim == 2 else [(0, 1), (1, 2), (0, 2)]:
            mode = np.zeros_like(x)
            mode[:, i], mode[:, j] = -x[:, j], x[:, i]
            modes.append(mode)
        vectors: list[Any] = []
        for mode in modes:
            vector = self.matrix.createVecRight()
            vector.array[:] = np.where(self._fixed, 0.0, mode).ravel()
            for other in vectors:
                vector.axpy(-other.dot(vector), other)
            vector.normalize()
            vectors.append(vector)
        return PETSc.NullSpace().create(vectors=vectors, comm=self.matrix.comm)

    def _asymmetry(self) -> float:
        """Returns |u . A v - v . A u| / |A v| for two vectors u and v; 0 for a zero matrix."""
        u, v = self.matrix.createVecs()
        first, last = u.getOwnershipRange()
        angle = np.arange(first, last, dtype=float)
        u.array[:], v.array[:] = np.cos(1.3 * angle), np.cos(2.1 * angle)
        of_u, of_v = u.duplicate(), v.duplicate()
        self.matrix.mult(u, of_u)
        self.matrix.mult(v, of_v)
        size = of_v.norm()
        return 0.0 if size == 0.0 else abs(u.dot(of_v) - v.dot(of_u)) / float(size)


def _communicator(system: LinearSystem) -> Any:
    from petsc4py import PETSc

    mpi = getattr(system.comm, "mpi", None)
    return PETSc.COMM_SELF if mpi is None else mpi
