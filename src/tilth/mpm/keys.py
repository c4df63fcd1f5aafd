# SPDX-License-Identifier: BSD-3-Clause
"""Keys of nodes and cells of the grid, one set of them for each displacement field.

The key of a lattice index packs 20 bits per direction, x fastest (cpp/tilth/grid.hpp). A cell has
the key of its lowest node. The keys of a field are those of lattice indices that are shifted along
the third direction, so that nodes of different fields at the same place have different keys, the
nodes of each field are consecutive, and neighbours in one field have the same differences of keys.
"""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Integers

FIELD_BITS = 16
"""The lattice indices of a field are shifted by this power of two, times its number."""

LARGEST_INDEX = 1 << (FIELD_BITS - 1)
"""With several fields in 3D the indices along z are smaller than this in magnitude."""

_SHIFT = FIELD_BITS + 40


def field_shift(field: Integers | int) -> Integers | int:
    """Returns what a field adds to the keys of its nodes and cells."""
    return field << _SHIFT


def lattice_keys(lattice: Integers, field: Integers | int = 0) -> Integers:
    """Returns the keys of lattice indices (n, dim) in a field, one number or shape (n,)."""
    in_space = np.zeros((len(lattice), 3), dtype=np.int64)
    in_space[:, : lattice.shape[1]] = lattice
    keys = np.asarray(_core.node_keys(in_space))
    return keys if isinstance(field, int) and field == 0 else keys + field_shift(field)


def find_keys(keys: Integers, sought: Integers) -> Integers:
    """Returns the positions of the keys `sought` in the sorted `keys`; -1 for those not in it."""
    if len(keys) == 0:
        return np.full(len(sought), -1)
    number = keys.searchsorted(sought)
    number[number == len(keys)] = 0
    number[keys[number] != sought] = -1
    return number


def places_of_keys(keys: Integers, fields: int) -> tuple[Integers, Integers]:
    """Returns lattice indices (n, 3) and fields (n,) of keys of so many fields."""
    lattice = np.asarray(_core.lattice(keys))
    if fields == 1:
        return lattice, np.zeros(len(keys), dtype=np.int64)
    field = (lattice[:, 2] + LARGEST_INDEX) >> FIELD_BITS
    lattice = lattice.copy()
    lattice[:, 2] -= field << FIELD_BITS
    return lattice, field


def first_of_fields(keys: Integers, fields: int) -> Integers:
    """Returns where each field begins in sorted keys, and their number, shape (fields + 1,)."""
    if fields == 1:
        return np.array([0, len(keys)])
    lowest = np.zeros((fields, 3), dtype=np.int64)
    lowest[:, 2] = (np.arange(fields) << FIELD_BITS) - LARGEST_INDEX
    corner = lattice_keys(lowest)
    corner -= corner[0] & ((1 << 40) - 1)  # before all x and y
    return np.append(keys.searchsorted(corner), len(keys))
