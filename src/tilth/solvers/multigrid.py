# SPDX-License-Identifier: BSD-3-Clause
"""Krylov methods preconditioned by geometric multigrid (docs/theory/linear_solvers.md)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats
from tilth.mpm.grid import ActiveGrid
from tilth.solvers.exact_part import ExactPart
from tilth.solvers.krylov import NotDefinite, conjugate_gradients, flexible_gmres
from tilth.solvers.protocol import Solution, SolveFailed

ITERATIONS = 100
"""Iterations after which a direct solver is quicker."""

PATIENCE = 50
"""Iterations after which more equations are solved exactly, where there are more hard ones."""

HARD = {2: 5_000, 3: 2_500}
"""Unknowns up to which the hard nodes' equations are solved exactly, by dimension."""

HARDEST = {2: 20_000, 3: 10_000}
"""The same once a solution with fewer has failed in the step: the factors take a second or so."""

SCATTERED = 100
"""Grid lines of the box around all nodes, per node, up to which the levels list them all."""

SYMMETRIC = 1e-10
"""Relative asymmetry below which the matrix counts as symmetric."""


class Multigrid:
    """The levels of one active grid; a matrix of its pattern is set up by `fill`.

    Args:
        active: the active grid, which owns the pattern.
        held: prescribed degrees of freedom, shape (nodes, dim).

    Raises:
        SolveFailed: the nodes are scattered over a box that is far larger than they fill.
    """

    def __init__(self, active: ActiveGrid, held: npt.NDArray[np.bool_]) -> None:
        lines = np.prod(np.ptp(active.lattice[:, 1:], axis=0) + 1.0)
        if lines > SCATTERED * len(held):
            raise SolveFailed("the pieces of the active grid are too far apart")
        self._active = active
        self._dim = active.grid.dim
        self._held = held.copy(order="C")
        self._pattern = (active.row_start, active.column)
        angle = np.arange(self._held.size, dtype=float)  # no structure, the same on any machine
        self._probes = [np.where(held.ravel(), 0.0, np.cos(k * angle)) for k in (1.3, 2.1)]
        self._exact: ExactPart | None = None
        self._most_hard = HARD
        self._hierarchy = _core.Multigrid(self._dim, active.lattice, *self._pattern, self._held)

    @property
    def bytes(self) -> int:
        """Memory of all levels [byte]."""
        return self._hierarchy.bytes()

    def begin(self, active: ActiveGrid, held: npt.NDArray[np.bool_]) -> bool:
        """Makes ready for another active grid and returns True if it has the same pattern."""
        same = np.array_equal(held, self._held) and all(
            np.array_equal(getattr(active, name), getattr(self._active, name))
            for name in ("lattice", "row_start", "column")
        )
        if same:
            self._active, self._pattern = active, (active.row_start, active.column)
            self._hierarchy.begin()
            self._most_hard = HARD
        return same

    def fill(self, blocks: Floats, hard: Sequence[npt.NDArray[np.bool_]] = ()) -> None:
        """Takes the node blocks of a matrix, shape (entries of the pattern, dim, dim).

        On the nodes that are `hard`, shape (nodes,), the equations are solved exactly before and
        after each cycle: on the first of these choices, from many to few, that has few enough.

        Raises:
            SolveFailed: if it has entries that are not numbers.
        """
        self._blocks = blocks
        self._hierarchy.fill(blocks)
        self._asymmetry = _core.asymmetry(
            self._dim, *self._pattern, blocks, self._held, *self._probes
        )
        if not np.isfinite(self._asymmetry):
            raise SolveFailed("the matrix has entries that are not numbers")
        self._hard = [chosen for chosen in hard if chosen.any()]
        self._choose_exact()

    def _choose_exact(self) -> None:
        most = self._most_hard[self._dim]
        few = [chosen for chosen in self._hard if chosen.sum() * self._dim <= most]
        self._exact_nodes = int(few[0].sum()) if few else 0
        self._exact = (
            ExactPart(self._active, self._held, self._blocks, few[0]) if self._exact_nodes else None
        )

    def solve(self, right_side: Floats, tolerance: float) -> Solution:
        """Solves for nodal right sides, shape (nodes, dim), which are ignored where held.

        Raises:
            SolveFailed: no solution to the relative `tolerance` within `ITERATIONS`.
        """
        free = np.where(self._held, 0.0, right_side).ravel()
        more = HARDEST[self._dim] // self._dim
        if not any(self._exact_nodes < chosen.sum() <= more for chosen in self._hard):
            return self._iterate(free, tolerance, ITERATIONS)
        try:
            return self._iterate(free, tolerance, PATIENCE)
        except SolveFailed:
            self._most_hard = HARDEST
            self._choose_exact()
            return self._iterate(free, tolerance, ITERATIONS)

    def _iterate(self, free: Floats, tolerance: float, limit: int) -> Solution:
        operators = (self._product, self._precondition)
        if self._asymmetry < SYMMETRIC:
            try:
                return conjugate_gradients(*operators, free, tolerance, limit)
            except NotDefinite:  # the bound of the smoother's eigenvalues may be a little low
                pass
        return flexible_gmres(*operators, free, tolerance, limit)

    def _product(self, x: Floats, product: Floats) -> None:
        _core.block_product(self._dim, *self._pattern, self._blocks, self._held, x, product)

    def _precondition(self, residual: Floats, approximate: Floats) -> None:
        if self._exact is None:
            self._hierarchy.cycle(residual, approximate)
            return
        part = self._exact.solve(residual)
        rest = np.empty_like(residual)
        self._product(part, rest)
        _core.combine(1.0, residual, -1.0, rest)
        self._hierarchy.cycle(rest, approximate)
        approximate += part
        self._exact.improve(approximate, residual)
