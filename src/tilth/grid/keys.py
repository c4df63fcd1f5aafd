# SPDX-License-Identifier: BSD-3-Clause
"""Keys of nodes and cells of the grid, one set of them for each overlay.

The key of a lattice index packs 20 bits per direction, x fastest (cpp/tilth/grid.hpp). A cell has
the key of its lowest node. The keys of an overlay are those of lattice indices that are shifted
along the third direction, so that nodes of different overlays at the same place have different
keys, the nodes of each overlay are consecutive, and neighbours in one overlay have the same
differences of keys.
"""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Integers

OVERLAY_BITS = 16
"""The lattice indices of an overlay are shifted by this power of two, times its number."""

LARGEST_INDEX = 1 << (OVERLAY_BITS - 1)
"""With several overlays in 3D the indices along z are smaller than this in magnitude."""

_SHIFT = OVERLAY_BITS + 40


def overlay_shift(overlay: Integers | int) -> Integers | int:
    """Returns what an overlay adds to the keys of its nodes and cells."""
    return overlay << _SHIFT


def lattice_keys(lattice: Integers, overlay: Integers | int = 0) -> Integers:
    """Returns the keys of lattice indices (n, dim) in an overlay, one number or shape (n,)."""
    in_space = np.zeros((len(lattice), 3), dtype=np.int64)
    in_space[:, : lattice.shape[1]] = lattice
    keys = np.asarray(_core.node_keys(in_space))
    return keys if isinstance(overlay, int) and overlay == 0 else keys + overlay_shift(overlay)


def find_keys(keys: Integers, sought: Integers) -> Integers:
    """Returns the positions of the keys `sought` in the sorted `keys`; -1 for those not in it."""
    if len(keys) == 0:
        return np.full(len(sought), -1)
    number = keys.searchsorted(sought)
    number[number == len(keys)] = 0
    number[keys[number] != sought] = -1
    return number


def places_of_keys(keys: Integers, overlays: int) -> tuple[Integers, Integers]:
    """Returns lattice indices (n, 3) and overlays (n,) of keys of so many overlays."""
    lattice = np.asarray(_core.lattice(keys))
    if overlays == 1:
        return lattice, np.zeros(len(keys), dtype=np.int64)
    overlay = (lattice[:, 2] + LARGEST_INDEX) >> OVERLAY_BITS
    lattice = lattice.copy()
    lattice[:, 2] -= overlay << OVERLAY_BITS
    return lattice, overlay


def first_of_overlays(keys: Integers, overlays: int) -> Integers:
    """Returns where each overlay begins in sorted keys, and their number, shape (overlays + 1,)."""
    if overlays == 1:
        return np.array([0, len(keys)])
    lowest = np.zeros((overlays, 3), dtype=np.int64)
    lowest[:, 2] = (np.arange(overlays) << OVERLAY_BITS) - LARGEST_INDEX
    corner = lattice_keys(lowest)
    corner -= corner[0] & ((1 << 40) - 1)  # before all x and y
    return np.append(keys.searchsorted(corner), len(keys))
