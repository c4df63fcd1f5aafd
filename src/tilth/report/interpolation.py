# SPDX-License-Identifier: BSD-3-Clause
"""Values of a point field at other positions: weighted least squares with a linear function."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats

_NEIGHBOURS = {2: 12, 3: 26}
"""Points that a fit takes, by the number of directions: those around and half of the next ones."""
_RIDGE = 1e-10
"""Share of the constant's weight that steadies a fit through points on a line."""
_BEYOND = 0.75
"""How far a value may lie beyond those of the points of its fit, over their range."""


def values_at(position: Floats, values: Floats, places: Floats) -> Floats:
    """Returns a field's values at other places, shape (m,).

    Each is that of a linear function, fitted to the nearest points with weights that fall with the
    distance, so a linear field is reproduced, also a little outside of the points.

    Args:
        position: of the points [length], shape (n, dim).
        values: of the points, shape (n,); NaN: none.
        places: where to evaluate [length], shape (m, dim); NaN results where the nearest point has
            no value.
    """
    from scipy.spatial import cKDTree

    if len(places) == 0 or len(position) == 0:
        return np.full(len(places), np.nan)
    dim = position.shape[1]
    count = min(_NEIGHBOURS[dim], len(position))
    distance, near = cKDTree(position).query(places, k=[*range(1, count + 1)])
    known = np.isfinite(values[near])
    width = np.maximum(distance[:, min(2 * dim - 1, count - 1)], 1e-300)[:, None]
    weight = np.exp(-((distance / width) ** 2)) * known
    weight /= np.maximum(weight.sum(axis=1), 1e-300)[:, None]
    found = np.where(known, values[near], 0.0)
    offset = (position[near] - places[:, None, :]) / width[:, :, None]
    row = np.concatenate([np.ones((*near.shape, 1)), offset], axis=2)
    weighted = row * weight[:, :, None]
    matrix = np.swapaxes(weighted, 1, 2) @ row + _RIDGE * np.eye(dim + 1)
    mean = (weight * found).sum(axis=1)
    right = np.einsum("mkj,mk->mj", weighted, np.where(known, found - mean[:, None], 0.0))
    fitted = mean + np.linalg.solve(matrix, right[:, :, None])[:, 0, 0]
    low = np.where(known, found, np.inf).min(axis=1)
    high = np.where(known, found, -np.inf).max(axis=1)
    room = np.where(known.any(axis=1), _BEYOND * (high - low), 0.0)
    fitted = np.clip(fitted, low - room, high + room)
    return np.asarray(np.where(known[:, 0], fitted, np.nan))
