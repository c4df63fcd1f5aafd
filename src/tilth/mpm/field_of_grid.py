# SPDX-License-Identifier: BSD-3-Clause
"""The nodes and cells of one displacement field among those of all."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.arrays import Integers
from tilth.mpm.keys import field_shift, first_of_fields


@dataclass(frozen=True)
class FieldOfGrid:
    """The active nodes and cells of one displacement field.

    Attributes:
        first_node, first_cell: their first numbers among those of all fields.
        key, cell_keys: sorted keys of its nodes and cells, as those of the field 0.
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


def field_of_grid(key: Integers, cell_keys: Integers, number: int, fields: int) -> FieldOfGrid:
    """Returns those of a field by its number, from the sorted keys of all fields."""
    node, end = first_of_fields(key, fields)[number : number + 2]
    cell, cell_end = first_of_fields(cell_keys, fields)[number : number + 2]
    shift = field_shift(number)
    return FieldOfGrid(
        int(node), int(cell), key[node:end] - shift, cell_keys[cell:cell_end] - shift
    )
