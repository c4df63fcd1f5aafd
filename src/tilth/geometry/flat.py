# SPDX-License-Identifier: BSD-3-Clause
"""Base class and geometric functions of boundaries with straight edges or flat faces."""

from __future__ import annotations

import math

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.geometry.protocol import Facets


class Flat:
    """A geometry whose facets coincide with the boundary, so that no projection is needed."""

    flat = True

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """As `Geometry.project`: the points themselves and the ratio 1."""
        return x, np.ones(len(x))


def unit(vector: Floats) -> Floats:
    """Returns the unit vectors in the directions of vectors (..., dim)."""
    return np.asarray(vector / np.linalg.norm(vector, axis=-1, keepdims=True))


def left_normal(direction: Floats) -> Floats:
    """Returns the vectors (n, 2) turned anticlockwise by a right angle."""
    return np.stack([-direction[:, 1], direction[:, 0]], axis=1)


def split_segments(start: Floats, end: Floats, size: float | Floats) -> tuple[Floats, Integers]:
    """Divides segments from `start` to `end`, shape (n, 2), evenly into parts of at most `size`.

    size: one number, or one of each segment [length], shape (n,).

    Returns the ends of the parts, shape (parts, 2, 2), and the segment of each, shape (parts,).
    """
    length = np.linalg.norm(end - start, axis=1)
    parts = np.maximum(1, np.ceil(length / size - 1e-9).astype(np.int64))
    segment = np.repeat(np.arange(len(start)), parts)
    number = np.arange(len(segment)) - np.repeat(np.cumsum(parts) - parts, parts)
    step = (end - start)[segment]
    low = (number / parts[segment])[:, None]
    high = ((number + 1) / parts[segment])[:, None]
    corner = np.stack([start[segment] + low * step, start[segment] + high * step], axis=1)
    return corner, segment


def split_rectangle(corner: Floats, first: Floats, second: Floats, size: float) -> Floats:
    """Divides the parallelogram at `corner` with two edges (3,) into triangles, (n, 3, 3)."""
    n = max(1, math.ceil(float(np.linalg.norm(first)) / size - 1e-9))
    m = max(1, math.ceil(float(np.linalg.norm(second)) / size - 1e-9))
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))

    def at(i: Integers, j: Integers) -> Floats:
        return np.asarray(corner + (i / n)[:, None] * first + (j / m)[:, None] * second)

    a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
    return np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)], axis=1).reshape(
        -1, 3, 3
    )


def box_corners(lower: Floats, upper: Floats) -> Floats:
    """Returns the corners of a box, shape (2^dim, dim)."""
    box = np.stack([lower, upper])
    choices = np.array(list(np.ndindex(*(2,) * len(lower))))
    return np.asarray(box[choices, np.arange(len(lower))])


def join(parts: list[Facets]) -> Facets:
    """Returns all facets of several lists, each facet a group of its own."""
    return Facets(
        np.concatenate([part.corner for part in parts]),
        np.concatenate([part.normal for part in parts]),
        np.arange(sum(len(part.corner) for part in parts)),
    )


def pack(*index: Integers) -> Integers:
    """Returns one unique number for each pair or triple of lattice indices in [-2^20, 2^20)."""
    packed = np.zeros(len(index[0]), dtype=np.int64)
    for part in index:
        packed = (packed << 21) | (part + (1 << 20))
    return packed


def perpendicular(normal: Floats) -> Floats:
    """Returns a unit vector perpendicular to a unit vector (3,), along an axis if possible."""
    axis = np.eye(3)[int(np.abs(normal).argmin())]
    return unit(axis - (axis @ normal) * normal)
