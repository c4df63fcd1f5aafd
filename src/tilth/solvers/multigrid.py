# SPDX-License-Identifier: BSD-3-Clause
"""Krylov methods preconditioned by geometric multigrid (docs/theory/linear_solvers.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.comm import SERIAL, Communicator, count
from tilth.mpm.grid import ActiveGrid
from tilth.solvers.exact_part import ExactPart
from tilth.solvers.krylov import NotDefinite, conjugate_gradients, flexible_gmres
from tilth.solvers.protocol import Solution, SolveFailed

ITERATIONS = 100
"""Iterations after which a direct solver is quicker."""

ITERATIONS_BEFORE_MORE = 50
"""Iterations after which the equations of more nodes are solved exactly, where there are such."""

EXACT_UNKNOWNS = {2: 5_000, 3: 2_500}
"""Unknowns up to which the equations of chosen nodes are solved exactly, by dimension."""

MOST_EXACT_UNKNOWNS = {2: 20_000, 3: 10_000}
"""The same once a solution with fewer has failed in the step: the factors take a second or so."""

SCATTERED = 100
"""Grid lines of the box around all nodes, per node, up to which the levels list them all."""

SYMMETRIC = 1e-10
"""Relative asymmetry below which the matrix counts as symmetric."""


class Multigrid:
    """The levels of one active grid; a matrix of its pattern is set up by `fill`.

    Args:
        active: the active grid, which owns the pattern.
        constrained: prescribed degrees of freedom, shape (nodes, components); its shape says how
            many components the unknown field has, 1, 2 or 3, whatever the dimension of the grid.
        comm: the processes that share the grid.

    Raises:
        SolveFailed: the nodes are scattered over a box that is far larger than they fill.
    """

    def __init__(self, active: ActiveGrid, constrained: Flags, comm: Communicator = SERIAL) -> None:
        lines = np.prod(np.ptp(active.lattice[:, 1:], axis=0) + 1.0)
        if lines > SCATTERED * len(constrained):
            raise SolveFailed("the pieces of the active grid are too far apart")
        self._active = active
        self._comm = comm
        self._dim, self._components = active.grid.dim, constrained.shape[1]
        self._constrained = constrained.copy(order="C")
        self._pattern = (active.row_start, active.column)
        angle = np.arange(
            self._constrained.size, dtype=float
        )  # no structure, the same on any machine
        free = ~self._constrained.ravel()
        self._probes = [np.where(free, np.cos(k * angle), 0.0) for k in (1.3, 2.1)]
        self._exact: ExactPart | None = None
        self._limits = EXACT_UNKNOWNS
        self._hierarchy = _core.Multigrid(
            self._dim, self._components, active.lattice, *self._pattern, self._constrained
        )

    @property
    def bytes(self) -> int:
        """Memory of all levels [byte]."""
        return self._hierarchy.bytes()

    def begin(self, active: ActiveGrid, constrained: Flags) -> bool:
        """Makes ready for another active grid and returns True if it has the same pattern."""
        same = np.array_equal(constrained, self._constrained) and all(
            np.array_equal(getattr(active, name), getattr(self._active, name))
            for name in ("lattice", "row_start", "column")
        )
        if same:
            self._active, self._pattern = active, (active.row_start, active.column)
            self._hierarchy.begin()
            self._limits = EXACT_UNKNOWNS
        return same

    def fill(self, blocks: Floats, exact_nodes: Sequence[Flags] = ()) -> None:
        """Takes the node blocks of a matrix, (entries of the pattern, components, components).

        On the nodes of one of the choices `exact_nodes`, shape (nodes,) each, the equations are
        solved exactly before and after each cycle: on the first, from many to few, that has few
        enough.

        Raises:
            SolveFailed: if it has entries that are not numbers.
        """
        self._blocks = blocks
        self._hierarchy.fill(blocks)
        self._asymmetry = self._measure_asymmetry()
        if not math.isfinite(self._asymmetry):
            raise SolveFailed("the matrix has entries that are not numbers")
        counted = [(count(self._comm, int(chosen.sum())), chosen) for chosen in exact_nodes]
        self._choices = [(nodes, chosen) for nodes, chosen in counted if nodes]
        self._choose_exact()

    def _measure_asymmetry(self) -> float:
        """Returns |u . A v - v . A u| / |A v| for two vectors u and v; 0 of no matrix."""
        sums = _core.asymmetry(
            self._components, *self._pattern, self._blocks, self._constrained, *self._probes
        )
        square, u_of_v, v_of_u = map(self._comm.sum, sums)
        return 0.0 if square == 0.0 else abs(u_of_v - v_of_u) / math.sqrt(square)

    def _choose_exact(self) -> None:
        most = self._limits[self._dim]
        few = [choice for choice in self._choices if choice[0] * self._components <= most]
        self._exact, self._exact_nodes = None, 0
        if few:
            self._exact_nodes, chosen = few[0]
            self._exact = ExactPart(self._active, self._constrained, self._blocks, chosen)

    def solve(self, right_side: Floats, tolerance: float) -> Solution:
        """Solves for a nodal right side, shape (nodes, components); ignored where constrained.

        Raises:
            SolveFailed: no solution to the relative `tolerance` within `ITERATIONS`.
        """
        free = np.where(self._constrained, 0.0, right_side).ravel()
        more = MOST_EXACT_UNKNOWNS[self._dim] // self._components
        if not any(self._exact_nodes < nodes <= more for nodes, _ in self._choices):
            return self._iterate(free, tolerance, ITERATIONS)
        try:
            return self._iterate(free, tolerance, ITERATIONS_BEFORE_MORE)
        except SolveFailed:
            self._limits = MOST_EXACT_UNKNOWNS
            self._choose_exact()
            return self._iterate(free, tolerance, ITERATIONS)

    def _iterate(self, free: Floats, tolerance: float, limit: int) -> Solution:
        operators = (self._product, self._precondition)
        if self._asymmetry < SYMMETRIC:
            try:
                return conjugate_gradients(*operators, free, tolerance, limit, self._comm)
            except NotDefinite:  # the bound of the smoother's eigenvalues may be a little low
                pass
        return flexible_gmres(*operators, free, tolerance, limit, self._comm)

    def _product(self, x: Floats, product: Floats) -> None:
        _core.block_product(
            self._components, *self._pattern, self._blocks, self._constrained, x, product
        )

    def _precondition(self, residual: Floats, approximate: Floats) -> None:
        if self._exact is None:
            self._hierarchy.cycle(residual, approximate)
            return
        part = self._exact.solve(residual)
        remaining = np.empty_like(residual)
        self._product(part, remaining)
        _core.combine(1.0, residual, -1.0, remaining)
        self._hierarchy.cycle(remaining, approximate)
        approximate += part
        self._exact.improve(approximate, residual)
