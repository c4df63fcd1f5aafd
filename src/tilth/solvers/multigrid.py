# SPDX-License-Identifier: BSD-3-Clause
"""Krylov methods preconditioned by geometric multigrid (docs/theory/linear_solvers.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.comm import SERIAL, Communicator, count
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers.hierarchies import make_hierarchy
from tilth.solvers.krylov import NotDefinite, conjugate_gradients, flexible_gmres
from tilth.solvers.protocol import Solution, SolveFailed
from tilth.solvers.subdomain_correction import SubdomainCorrection

MAXIMUM_ITERATIONS = 100
"""Iterations after which a direct solver is faster."""

ITERATIONS_WITH_FEWER = 50
"""Iterations after which the equations of a larger set of nodes, if there is one, are solved
directly."""

EXACT_UNKNOWNS = {2: 5_000, 3: 2_500}
"""Dimension -> number of unknowns up to which a set of nodes is solved directly."""

INCREASED_EXACT_UNKNOWNS = {2: 20_000, 3: 10_000}
"""The same after a solution with fewer has failed in the step: the factors take about a second."""

LARGEST_LINES_PER_NODE = 100
"""Largest number of grid lines in the nodes' bounding box, per node: levels store all lines."""

SYMMETRY_TOLERANCE = 1e-10
"""Relative asymmetry below which the matrix counts as symmetric."""


class Multigrid:
    """The levels of one active grid; a matrix of its pattern is set up by `fill`.

    Args:
        active: the active grid, which owns the pattern.
        constrained: prescribed degrees of freedom, shape (nodes, components): 1, 2 or 3
            components, independent of the dimension of the grid.
        comm: the processes that share the grid.

    Raises:
        SolveFailed: the nodes are scattered over a box that is far too large for their number.
    """

    def __init__(self, active: ActiveGrid, constrained: Flags, comm: Communicator = SERIAL) -> None:
        lines = np.prod(np.ptp(active.lattice[:, 1:], axis=0) + 1.0)
        if lines > LARGEST_LINES_PER_NODE * len(constrained):
            raise SolveFailed("the pieces of the active grid are too far apart")
        self._active = active
        self._comm = comm
        self._dim, self._components = active.grid.dim, constrained.shape[1]
        self._constrained = constrained.copy(order="C")
        self._pattern = (active.row_start, active.column)
        angle = np.arange(self._constrained.size, dtype=float)  # irregular, the same on any machine
        free = ~self._constrained.ravel()
        self._probes = [np.where(free, np.cos(k * angle), 0.0) for k in (1.3, 2.1)]
        self._exact: SubdomainCorrection | None = None
        self._limits = EXACT_UNKNOWNS
        self._hierarchy = make_hierarchy(active, self._constrained)

    @property
    def bytes(self) -> int:
        """Memory of all levels [byte]."""
        return self._hierarchy.bytes()

    def begin(self, active: ActiveGrid, constrained: Flags) -> bool:
        """Prepares the levels for another active grid; returns False if its pattern differs."""
        same = np.array_equal(constrained, self._constrained) and all(
            np.array_equal(getattr(active, name), getattr(self._active, name))
            for name in ("key", "row_start", "column")
        )
        if same:
            self._active, self._pattern = active, (active.row_start, active.column)
            self._hierarchy.begin()
            self._limits = EXACT_UNKNOWNS
        return same

    def fill(
        self, blocks: Floats, exact_nodes: Sequence[Flags] = (), keep_levels: bool = False
    ) -> None:
        """Sets the node blocks of the matrix, (entries of the pattern, components, components).

        keep_levels: whether the levels of the last matrix precondition this one, too.

        Before and after each cycle the equations of one set of nodes are solved directly. It is
        the first of the sets `exact_nodes`, shape (nodes,) each, from many to few, that is within
        the limit.

        Raises:
            SolveFailed: if the matrix has entries that are not numbers.
        """
        self._blocks = blocks
        if not keep_levels:
            self._hierarchy.fill(blocks)
        self._asymmetry = self._measure_asymmetry()
        if not math.isfinite(self._asymmetry):
            raise SolveFailed("the matrix has entries that are not numbers")
        counted = [(count(self._comm, int(flags.sum())), flags) for flags in exact_nodes]
        self._candidates = [(nodes, selected) for nodes, selected in counted if nodes]
        self._choose_exact()

    def _measure_asymmetry(self) -> float:
        """Returns |u . A v - v . A u| / |A v| for two vectors u and v; 0 for a zero matrix."""
        sums = _core.asymmetry(
            self._components, *self._pattern, self._blocks, self._constrained, *self._probes
        )
        square, u_of_v, v_of_u = map(self._comm.sum, sums)
        return 0.0 if square == 0.0 else abs(u_of_v - v_of_u) / math.sqrt(square)

    def _choose_exact(self) -> None:
        limit = self._limits[self._dim]
        within = [each for each in self._candidates if each[0] * self._components <= limit]
        self._exact, self._exact_nodes = None, 0
        if within:
            self._exact_nodes, selected = within[0]
            self._exact = SubdomainCorrection(
                self._active, self._constrained, self._blocks, selected
            )

    @property
    def may_increase(self) -> bool:
        """Whether a larger set of nodes could be solved directly."""
        limit = INCREASED_EXACT_UNKNOWNS[self._dim] // self._components
        return any(self._exact_nodes < nodes <= limit for nodes, _ in self._candidates)

    def increase(self) -> None:
        """Solves a larger set of nodes directly until the next step.

        Raises:
            SolveFailed: if their matrix is singular.
        """
        self._limits = INCREASED_EXACT_UNKNOWNS
        self._choose_exact()

    def solve(self, right_side: Floats, tolerance: float) -> Solution:
        """Returns the solution for a right side (nodes, components), ignored where constrained.

        Raises:
            SolveFailed: no solution to the relative `tolerance` within `MAXIMUM_ITERATIONS`.
        """
        free = np.where(self._constrained, 0.0, right_side).ravel()
        if not self.may_increase:
            return self._iterate(free, tolerance, MAXIMUM_ITERATIONS)
        try:
            return self._iterate(free, tolerance, ITERATIONS_WITH_FEWER)
        except SolveFailed:
            self.increase()
            return self._iterate(free, tolerance, MAXIMUM_ITERATIONS)

    def _iterate(self, free: Floats, tolerance: float, limit: int) -> Solution:
        operators = (self._product, self.precondition)
        if self._asymmetry < SYMMETRY_TOLERANCE:
            try:
                return conjugate_gradients(*operators, free, tolerance, limit, self._comm)
            except NotDefinite:  # the bound of the smoother's eigenvalues may be too low
                pass
        return flexible_gmres(*operators, free, tolerance, limit, self._comm)

    def _product(self, x: Floats, product: Floats) -> None:
        _core.block_product(
            self._components, *self._pattern, self._blocks, self._constrained, x, product
        )

    def precondition(self, residual: Floats, approximate: Floats) -> None:
        """Fills `approximate` with one cycle for `residual`, (unknowns,) each, 0 where constrained.

        Before and after it the equations of the chosen set of nodes are solved directly.
        """
        if self._exact is None:
            self._hierarchy.cycle(residual, approximate)
            return
        correction = self._exact.solve(residual)
        if self._asymmetry < SYMMETRY_TOLERANCE:
            remaining = self._exact.remaining(residual, correction)
        else:
            remaining = np.empty_like(residual)
            self._product(correction, remaining)
            _core.combine(1.0, residual, -1.0, remaining)
        self._hierarchy.cycle(remaining, approximate)
        approximate += correction
        self._exact.improve(approximate, residual)
