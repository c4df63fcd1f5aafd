# SPDX-License-Identifier: BSD-3-Clause
"""The matrix of several processes in PETSc, and the solution of systems with it.

Each process gives PETSc the rows of the nodes that it owns; they are complete, so that nothing is
summed over the processes. The rows and columns of constrained unknowns are those of the identity.
"""

from __future__ import annotations

import atexit
import weakref
from typing import Any, Protocol

import numpy as np

from tilth.arrays import Flags, Floats, Shorts
from tilth.comm import Communicator, norm
from tilth.solvers.protocol import SolveFailed
from tilth.solvers.schwarz import SchwarzMultigrid
from tilth.solvers.system import LinearSystem

MAXIMUM_ITERATIONS = {"multigrid": 100, "gamg": 300, "hypre": 300, "mumps": 1}
"""Iterations of each solver after which the direct solver takes over."""

ITERATIONS_WITH_FEWER = 50
"""Iterations of multigrid after which the equations of more nodes are solved directly."""

SYMMETRY_TOLERANCE = 1e-6
"""Relative asymmetry of a matrix up to which conjugate gradients are used."""

LARGEST_DIRECT_RESIDUAL = 1e-8
"""Relative residual above which the matrix of a direct solution counts as singular."""

KRYLOV: dict[str, str | float] = {
    "ksp_type": "fgmres",
    "ksp_gmres_restart": 100,
    "ksp_gmres_cgs_refinement_type": "refine_ifneeded",
}
"""Options of the Krylov method for matrices that are not symmetric."""

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
"""Options of PETSc by the name of the solver, for assembled matrices."""


class PetscMatrix(Protocol):
    """The matrix of a step's systems with a solver; all processes call its methods together."""

    def begin(self, system: LinearSystem) -> bool:
        """Prepares for the systems of another step, the first of which is there.

        Returns False if their pattern differs.
        """

    def destroy(self) -> None:
        """Frees the memory in all processes."""

    def fill(self, name: str, similar: bool) -> None:
        """Takes the matrix that the system has now, for the solver `name`.

        similar: whether the preconditioner of the last matrix may stay.

        Raises:
            SolveFailed: it has entries that are not numbers.
        """

    def solve(self, owned: Floats, size: float, tolerance: float) -> tuple[Floats, int]:
        """Returns the solution, (owned nodes, components), and the iterations.

        Args:
            owned: right side, shape (owned nodes, components), zero where constrained.
            size: its norm over all processes.
            tolerance: relative residual required of an iterative solver.

        Raises:
            SolveFailed: it is not reached.
        """


class _Operators:
    """What PETSc calls for products and preconditioning; it keeps this object."""

    def __init__(self, multigrid: SchwarzMultigrid, components: int) -> None:
        self._multigrid, self._components = multigrid, components

    def mult(self, matrix: Any, x: Any, product: Any) -> None:
        """Fills the product with a vector."""
        owned = x.getArray(readonly=True).reshape(-1, self._components)
        product.array[:] = self._multigrid.product(owned).ravel()

    def apply(self, preconditioner: Any, residual: Any, correction: Any) -> None:
        """Fills the correction for a residual."""
        owned = residual.getArray(readonly=True).reshape(-1, self._components)
        correction.array[:] = self._multigrid.precondition(owned).ravel()


class MatrixOfMultigrid:
    """The matrix as an operator, with the multigrid of tilth.

    Args:
        system: has the matrices, the first one already.

    Raises:
        SolveFailed: there are no levels of multigrid.
    """

    def __init__(self, system: LinearSystem) -> None:
        from petsc4py import PETSc

        self._multigrid, self._comm = SchwarzMultigrid(system), system.comm
        operators = _Operators(self._multigrid, system.components)
        own = system.active.owned_nodes * system.components
        size = ((own, None), (own, None))
        self._matrix = PETSc.Mat().createPython(size, operators, comm=_communicator(system))
        self._matrix.setUp()
        self._solver = PETSc.KSP().create(comm=self._matrix.comm)
        self._solver.setOperators(self._matrix)
        preconditioner = self._solver.getPC()
        preconditioner.setType(PETSc.PC.Type.PYTHON)
        preconditioner.setPythonContext(operators)
        _set_options(self._solver, "multigrid", KRYLOV)
        self._solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        atexit.register(_destroy, weakref.ref(self))

    def __del__(self) -> None:
        if hasattr(self, "_solver"):
            self.destroy()

    def begin(self, system: LinearSystem) -> bool:
        """As `PetscMatrix.begin`."""
        return self._multigrid.begin(system)

    def destroy(self) -> None:
        """As `PetscMatrix.destroy`."""
        self._solver.destroy()
        self._matrix.destroy()

    def fill(self, name: str, similar: bool) -> None:
        """As `PetscMatrix.fill`."""
        self._multigrid.fill(keep_levels=similar)

    def solve(self, owned: Floats, size: float, tolerance: float) -> tuple[Floats, int]:
        """As `PetscMatrix.solve`."""
        if self._multigrid.may_increase:
            try:
                return self._solved(owned, size, tolerance, ITERATIONS_WITH_FEWER)
            except SolveFailed:
                self._multigrid.increase()
        return self._solved(owned, size, tolerance, MAXIMUM_ITERATIONS["multigrid"])

    def _solved(
        self, owned: Floats, size: float, tolerance: float, most: int
    ) -> tuple[Floats, int]:
        vectors = self._matrix.createVecs()
        self._solver.setTolerances(rtol=tolerance, atol=0.0, max_it=most)
        return _solved("multigrid", self._comm, self._solver, vectors, owned, size, 2.0 * tolerance)


def _destroy(matrix: weakref.ref[MatrixOfMultigrid]) -> None:
    """Frees a matrix at the end of the run: PETSc ends after Python, and would call its objects."""
    found = matrix()
    if found is not None:
        found.destroy()


class AssembledMatrix:
    """The matrix in PETSc's format, for its own solvers.

    Args:
        system: has the matrices.
    """

    def __init__(self, system: LinearSystem) -> None:
        from petsc4py import PETSc

        active, components = system.active, system.components
        self._system = system
        self._solvers: dict[str, Any] = {}
        self._kept = self._pattern_of(system)
        shared = active.shared
        number = np.arange(active.nodes) if shared is None else shared.number
        first = 0 if shared is None else shared.first
        nodes = active.owned_nodes
        owned = np.arange(active.nodes)[active.owned]
        counts = np.diff(active.row_start)[owned]
        start = np.concatenate([[0], np.cumsum(counts)])
        entry = np.arange(start[-1]) + np.repeat(active.row_start[owned] - start[:-1], counts)
        row, column = np.repeat(owned, counts), active.column[entry]
        held = system.constrained
        touched = np.asarray(held.any(axis=1))
        self._entry = entry
        self._masked = np.flatnonzero(np.logical_or(touched[row], touched[column]))
        self._free_rows = ~held[row[self._masked]]
        self._free_columns = ~held[column[self._masked]]
        self._diagonal = np.flatnonzero(row == column)
        self._fixed: Flags = np.asarray(held[owned])
        self._index: Shorts = number[column].astype(PETSc.IntType)
        self._start: Shorts = start.astype(PETSc.IntType)
        local = (self._index >= first) & (self._index < first + nodes)
        inside = np.add.reduceat(local, start[:-1]) if nodes else np.zeros(0, dtype=np.int64)
        self._matrix = PETSc.Mat().create(comm=_communicator(system))
        self._matrix.setSizes(((nodes * components, None), (nodes * components, None)))
        self._matrix.setBlockSize(components)
        self._matrix.setType("aij")
        per_row = [
            np.repeat(part * components, components).astype(PETSc.IntType)
            for part in (inside, counts - inside)
        ]
        self._matrix.setPreallocationNNZ(tuple(per_row))
        self._matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, True)

    @staticmethod
    def _pattern_of(system: LinearSystem) -> list[np.ndarray[Any, Any]]:
        active = system.active
        owned = np.arange(active.nodes)[active.owned]
        number = np.zeros(0) if active.shared is None else active.shared.number
        return [active.row_start, active.column, owned, number, system.constrained]

    def begin(self, system: LinearSystem) -> bool:
        """As `PetscMatrix.begin`."""
        new = self._pattern_of(system)
        same = all(np.array_equal(a, b) for a, b in zip(self._kept, new, strict=True))
        if system.comm.max(float(not same)) > 0.0:
            return False
        self._system, self._kept = system, new
        self._destroy_solvers()
        return True

    def destroy(self) -> None:
        """As `PetscMatrix.destroy`."""
        self._destroy_solvers()
        self._matrix.destroy()

    def _destroy_solvers(self) -> None:
        for solver in self._solvers.values():
            solver.destroy()
        self._solvers.clear()

    def fill(self, name: str, similar: bool) -> None:
        """As `PetscMatrix.fill`."""
        system = self._system
        blocks = system.blocks[self._entry]
        if system.comm.max(float(not np.isfinite(blocks).all())) > 0.0:
            raise SolveFailed("the matrix of the linear system has entries that are not numbers")
        masked = blocks[self._masked]
        masked *= self._free_rows[:, :, None]
        masked *= self._free_columns[:, None, :]
        blocks[self._masked] = masked
        k = np.arange(system.components)
        blocks[self._diagonal[:, None], k, k] += self._fixed
        self._matrix.setValuesBlockedCSR(self._start, self._index, blocks.ravel())
        self._matrix.assemble()
        solver = self._solvers.get(name)
        if solver is None:
            self._solvers[name] = self._solver(name)
        else:
            solver.setOperators(self._matrix)
            solver.getPC().setReusePreconditioner(similar and name != "mumps")

    def solve(self, owned: Floats, size: float, tolerance: float) -> tuple[Floats, int]:
        """As `PetscMatrix.solve`."""
        ((name, solver),) = self._solvers.items()
        direct = name == "mumps"
        solver.setTolerances(rtol=tolerance, atol=0.0, max_it=MAXIMUM_ITERATIONS[name])
        limit = LARGEST_DIRECT_RESIDUAL if direct else 2.0 * tolerance
        vectors = self._matrix.createVecs()
        return _solved(name, self._system.comm, solver, vectors, owned, size, limit)

    def _solver(self, name: str) -> Any:
        from petsc4py import PETSc

        options = dict(OPTIONS[name])
        iterative = name != "mumps"
        if iterative and self._asymmetry() < SYMMETRY_TOLERANCE:
            options["ksp_type"] = "cg"
        elif iterative:
            options |= KRYLOV
        solver = PETSc.KSP().create(comm=self._matrix.comm)
        solver.setOperators(self._matrix)
        if name == "gamg":
            self._matrix.setNearNullSpace(self._rigid_motions())
        _set_options(solver, name, options)
        if iterative:
            solver.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        return solver

    def _rigid_motions(self) -> Any:
        """Returns the rigid motions of the free unknowns, for the coarse levels.

        Of unknowns that are not displacements only the constants.
        """
        from petsc4py import PETSc

        system = self._system
        active, components = system.active, system.components
        dim = active.grid.dim
        place = active.position[active.owned]
        x = (place - active.grid.position(np.zeros(dim))) / float(active.grid.cell_size.max())
        modes = [np.tile(unit, (len(x), 1)) for unit in np.eye(components)]
        planes = {2: [(0, 1)], 3: [(0, 1), (1, 2), (0, 2)]}[dim] if components == dim else []
        for i, j in planes:
            mode = np.zeros_like(x)
            mode[:, i], mode[:, j] = -x[:, j], x[:, i]
            modes.append(mode)
        vectors: list[Any] = []
        for mode in modes:
            vector = self._matrix.createVecRight()
            vector.array[:] = np.where(self._fixed, 0.0, mode).ravel()
            before = vector.norm()
            for other in vectors:
                vector.axpy(-other.dot(vector), other)
            if vector.norm() > 1e-8 * before:  # else constraints leave no such motion
                vector.normalize()
                vectors.append(vector)
        return PETSc.NullSpace().create(vectors=vectors, comm=self._matrix.comm)

    def _asymmetry(self) -> float:
        """Returns |u . A v - v . A u| / |A v| for two vectors u and v; 0 for a zero matrix."""
        u, v = self._matrix.createVecs()
        first, last = u.getOwnershipRange()
        angle = np.arange(first, last, dtype=float)
        u.array[:], v.array[:] = np.cos(1.3 * angle), np.cos(2.1 * angle)
        of_u, of_v = u.duplicate(), v.duplicate()
        self._matrix.mult(u, of_u)
        self._matrix.mult(v, of_v)
        size = of_v.norm()
        difference = abs(u.dot(of_v) - v.dot(of_u))
        for each in (u, v, of_u, of_v):
            each.destroy()
        return 0.0 if size == 0.0 else difference / float(size)


def _solved(
    name: str,
    comm: Communicator,
    solver: Any,
    vectors: tuple[Any, Any],
    owned: Floats,
    size: float,
    limit: float,
) -> tuple[Floats, int]:
    """Solves and checks the true residual; see `PetscMatrix.solve`.

    vectors: two of PETSc, for right side and solution; they are destroyed.
    limit: largest relative residual.
    """
    from petsc4py import PETSc

    b, x = vectors
    b.array[:] = owned.ravel()
    try:
        solver.solve(b, x)
    except PETSc.Error as error:
        raise SolveFailed(f"{name} did not solve a linear system ({error})") from error
    iterations, reason = solver.getIterationNumber(), solver.getConvergedReason()
    residual = b.duplicate()
    solver.getOperators()[0].mult(x, residual)
    left = norm(comm, b.array - residual.array) / size
    solution = x.array.reshape(owned.shape).copy()
    for each in (b, x, residual):
        each.destroy()
    if not left <= limit:
        raise SolveFailed(
            f"{name} did not solve a linear system (relative residual {left:.1e} after "
            f"{iterations} iterations, reason {reason} of PETSc)"
        )
    return solution, iterations


def _set_options(solver: Any, name: str, options: dict[str, str | float]) -> None:
    """Sets options of PETSc, and those of the environment variable PETSC_OPTIONS."""
    from petsc4py import PETSc

    prefix = f"tilth_{name}_"
    solver.setOptionsPrefix(prefix)
    database = PETSc.Options()
    for key, value in options.items():
        database[prefix + key] = value
    solver.setFromOptions()


def _communicator(system: LinearSystem) -> Any:
    from petsc4py import PETSc

    mpi = getattr(system.comm, "mpi", None)
    return PETSc.COMM_SELF if mpi is None else mpi
