# SPDX-License-Identifier: BSD-3-Clause
"""A correction on a coarse grid that all processes have whole, each with its own copy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers, Shorts
from tilth.comm import Communicator
from tilth.grid.keys import lattice_keys
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers.hierarchies import PatternOfOverlay, lattice_by_size, patterns_of_overlays

LARGEST_COARSE_NODES = 20_000
"""Number of coarse nodes from which on cells are doubled once more."""


class CoarseCorrection:
    """Solves for smooth errors on coarser grids, one for each overlay.

    Args:
        active: the active grid, which owns the pattern.
        constrained: prescribed degrees of freedom, shape (nodes, components).
    """

    def __init__(self, active: ActiveGrid, constrained: Flags) -> None:
        lattice = lattice_by_size(active)
        owned = np.zeros(active.nodes, dtype=bool)
        owned[active.owned] = True
        self._parts = [
            (
                overlay,
                _CoarseGrid(
                    active.comm,
                    active.grid.dim,
                    overlay,
                    *(
                        np.ascontiguousarray(each[overlay.nodes])
                        for each in (lattice, constrained, owned)
                    ),
                ),
            )
            for overlay in patterns_of_overlays(active)
        ]

    def begin(self) -> None:
        """Discards all matrices."""
        for _, grid in self._parts:
            grid.begin()

    def fill(self, blocks: Floats) -> None:
        """Makes the coarse matrices; blocks: (entries of the pattern, components, components)."""
        for overlay, grid in self._parts:
            grid.fill(blocks if overlay.entries is None else blocks[overlay.entries])

    def correct(self, residual: Floats, correction: Floats) -> None:
        """Fills the correction for a residual that owners know, shape (nodes, components) each.

        It is known at all nodes of a process, and zero where they are constrained.
        """
        for overlay, grid in self._parts:
            grid.correct(residual[overlay.nodes], correction[overlay.nodes])


class _CoarseGrid:
    """The correction of one overlay.

    Each process makes of the rows that it owns its part of the coarse matrix P^T A P. All get the
    sum of the parts, and apply one cycle of multigrid to it.

    Args:
        comm: the processes.
        dim: number of directions.
        overlay: the pattern of the overlay.
        lattice: indices of its nodes, shape (nodes, 3).
        constrained: shape (nodes, components).
        owned: whether this process owns a node, shape (nodes,).
    """

    def __init__(
        self,
        comm: Communicator,
        dim: int,
        overlay: PatternOfOverlay,
        lattice: Integers,
        constrained: Flags,
        owned: Flags,
    ) -> None:
        self._comm, self._components = comm, constrained.shape[1]
        row_start, column = overlay.row_start, overlay.column
        self._parts: list[_core.CoarsePart] = []
        while True:
            part = _core.CoarsePart(
                dim, self._components, lattice, row_start, column, constrained, owned
            )
            self._parts.append(part)
            lattice, row_start, column = map(np.asarray, part.pattern())
            constrained = np.zeros((len(lattice), self._components), dtype=bool)
            owned = np.ones(len(lattice), dtype=bool)
            keys = comm.gathered(lattice_keys(lattice))
            key = np.unique(np.concatenate(keys))
            if len(key) <= LARGEST_COARSE_NODES:
                break
        self._number = [np.searchsorted(key, each) for each in keys]
        self._nodes = len(key)
        self._sizes = [len(each) for each in keys]
        self._make_levels(dim, key, row_start, column)

    def _make_levels(self, dim: int, key: Integers, row_start: Integers, column: Shorts) -> None:
        number = self._number[self._comm.rank]
        row = np.repeat(number, np.diff(row_start))
        entries = self._comm.gathered(row * len(key) + number[column])
        entry = np.unique(np.concatenate(entries))
        self._entry = [np.searchsorted(entry, each) for each in entries]
        self._entries = len(entry)
        row, of_entry = np.divmod(entry, max(len(key), 1))
        self._levels = _core.Multigrid(
            dim,
            self._components,
            np.asarray(_core.lattice(key)),
            np.searchsorted(row, np.arange(len(key) + 1)),
            of_entry.astype(np.int32),
            np.zeros((len(key), self._components), dtype=bool),
        )

    def begin(self) -> None:
        """As `CoarseCorrection.begin`."""
        self._levels.begin()

    def fill(self, blocks: Floats) -> None:
        """As `CoarseCorrection.fill`, of the blocks of the overlay."""
        for part in self._parts:
            blocks = np.asarray(part.blocks(blocks))
        whole = np.zeros((self._entries, self._components, self._components))
        shapes = [(len(each), *whole.shape[1:]) for each in self._entry]
        for at, part_of_whole in zip(self._entry, self._from_all(blocks, shapes), strict=True):
            whole[at] += part_of_whole
        self._levels.fill(whole)

    def correct(self, residual: Floats, correction: Floats) -> None:
        """As `CoarseCorrection.correct`, of the nodes of the overlay."""
        own = np.ascontiguousarray(residual)
        for part in self._parts:
            own = np.asarray(part.restricted(own))
        whole = np.zeros((self._nodes, self._components))
        shapes = [(size, self._components) for size in self._sizes]
        for number, part_of_whole in zip(self._number, self._from_all(own, shapes), strict=True):
            whole[number] += part_of_whole
        solution = np.empty_like(whole)
        self._levels.cycle(whole.ravel(), solution.ravel())
        own = solution[self._number[self._comm.rank]]
        for part in reversed(self._parts):
            own = np.asarray(part.interpolated(own))
        correction[:] = own

    def _from_all(self, own: Floats, shapes: Sequence[tuple[int, ...]]) -> list[Floats]:
        """Returns the arrays of all processes, in the order of their numbers."""
        own = np.ascontiguousarray(own)
        found = [own if r == self._comm.rank else np.empty(s) for r, s in enumerate(shapes)]
        self._comm.exchange_arrays([own] * self._comm.size, found)
        return found
