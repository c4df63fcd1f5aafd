# SPDX-License-Identifier: BSD-3-Clause
"""The nodes and cells of one overlay among those of all."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.arrays import Integers
from tilth.grid.keys import first_of_overlays, overlay_shift


@dataclass(frozen=True)
class Overlay:
    """The active nodes and cells of one overlay.

    Attributes:
        first_node, first_cell: their first numbers among those of all overlays.
        key, cell_keys: sorted keys of its nodes and cells, as those of the overlay 0.
    """

    first_node: int
    first_cell: int
    key: Integers
    cell_keys: Integers

    @property
    def nodes(self) -> slice:
        """The numbers of its nodes."""
        return slice(self.first_node, self.first_node + len(self.key))

    @property
    def cells(self) -> slice:
        """The numbers of its cells."""
        return slice(self.first_cell, self.first_cell + len(self.cell_keys))


def overlay_of_grid(key: Integers, cell_keys: Integers, number: int, overlays: int) -> Overlay:
    """Returns those of an overlay by its number, from the sorted keys of all overlays."""
    node, end = first_of_overlays(key, overlays)[number : number + 2]
    cell, cell_end = first_of_overlays(cell_keys, overlays)[number : number + 2]
    shift = overlay_shift(number)
    return Overlay(int(node), int(cell), key[node:end] - shift, cell_keys[cell:cell_end] - shift)
