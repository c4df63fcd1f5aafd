# SPDX-License-Identifier: BSD-3-Clause
"""Corners of the points' domains: their order, mean edges, and parallelepipeds."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats


def corner_signs(dim: int) -> Floats:
    """Returns the corners of [-1, 1]^dim, x fastest, shape (2^dim, dim)."""
    return np.asarray(2.0 * ((np.arange(2**dim)[:, None] >> np.arange(dim)) & 1) - 1.0)


def mean_half_edges(corner: Floats) -> Floats:
    """Returns half the mean of a domain's edges in each of its directions [length].

    corner: shape (n, 2^dim, dim), x fastest.
    Returns shape (n, dim, dim): row k is for the edges along which bit k of the corner changes.
    """
    dim = corner.shape[2]
    return np.asarray(np.einsum("ck,nci->nki", corner_signs(dim), corner) / 2**dim)


def parallelepiped(half_edge: Floats) -> Floats:
    """Returns the corners, relative to the centre, of parallelepipeds with these half edges.

    half_edge: shape (n, dim, dim), an edge in each row [length].
    Returns shape (n, 2^dim, dim), x fastest.
    """
    dim = half_edge.shape[2]
    return np.asarray(np.einsum("ck,nki->nci", corner_signs(dim), half_edge))
