# SPDX-License-Identifier: BSD-3-Clause
"""Boundary given as the zero level set of a user's function of the position."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations, product

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.geometry.protocol import Facets

# Step of the central differences of the function [cell sizes]. Its truncation error, the square
# of the step, is below the round-off of the differences.
DIFFERENCE_STEP = 1e-5
# Least step of the central differences, relative to the largest coordinate: coordinates of a map
# may be millions of cells.
RELATIVE_DIFFERENCE_STEP = 1e-10
# Step of the central differences of the projection along a facet [cell sizes].
PROJECTION_DIFFERENCE_STEP = 1e-4
# Facets with an area below this fraction of size^(dim - 1) are dropped.
DEGENERATE_AREA_RATIO = 1e-10
# A function is a signed distance where the norm of its gradient differs from 1 by at most this.
UNIT_GRADIENT_TOLERANCE = 1e-5
# Points per call of the user's function.
POINTS_PER_BATCH = 1 << 19
# The projection ends with a correction below this [cell sizes]; Newton's method converges
# quadratically, so that the error is about its square.
PROJECTION_TOLERANCE = 1e-7
# Maximum iterations of the root search on a lattice edge, and of the projection.
MAXIMUM_EDGE_ITERATIONS = 100
MAXIMUM_PROJECTION_ITERATIONS = 20


class LevelSet:
    """The points where `function` is zero; the soil is where it is positive.

    function: takes points (n, dim) [length] and returns a value for each, shape (n,). It should
        be the signed distance [length]. Where it is not, value and gradient are divided by the
        gradient's norm, which gives the distance to first order: exact on the boundary, an
        estimate far from it. Its gradient must not vanish on the boundary. It is also evaluated
        up to one lattice cell outside the box of `facets`.
    dim: 2 or 3.
    cell_size: lengths of the grid's cells [length]; the smallest scales the differences.

    Where the gradient is discontinuous (at a corner of the boundary), the facets cut off the
    corner by up to their size; a polyline or a box has exact corners. A part of the boundary or
    of the soil that is thinner than a facet may not be found.
    """

    bounded = False
    flat = False

    def __init__(
        self, function: Callable[[Floats], Floats], dim: int, cell_size: float | Floats
    ) -> None:
        self.function = function
        self.dim = dim
        self.cell = float(np.min(cell_size))
        self._simplices = _crossings(dim)

    def distance(self, x: Floats) -> Floats:
        """Returns the signed distance [length] of points (n, dim), > 0 in the soil, shape (n,).

        It is the function divided by the norm of its gradient, unless that norm is 1.
        """
        value = np.empty(len(x))
        for part in _chunks(len(x)):
            value[part] = self.function(x[part])
            slope, steepest = self._slopes(x[part], value[part])
            norm = np.linalg.norm(slope, axis=1)
            # Where the gradient is discontinuous, as in the middle between two walls, the central
            # difference is less than the slope on either side.
            norm = np.where(steepest > (1.0 + 1e-2) * norm, steepest, norm)
            usable = (norm > 0.0) & (np.abs(norm - 1.0) > UNIT_GRADIENT_TOLERANCE)
            value[part] /= np.where(usable, norm, 1.0)
        return value

    def gradient(self, x: Floats) -> Floats:
        """Returns the direction into the soil at points (n, dim): unit vectors, same shape.

        It follows from central differences; where they vanish (the centre of a circle), from
        forward differences; where these vanish too, it is the first axis.
        """
        direction = np.empty_like(x)
        for part in _chunks(len(x)):
            direction[part] = self._directions(x[part])
        return direction

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """Returns the facets in the box from `lower` to `upper`, shape (dim,), and slightly beyond.

        The nodes of the lattice lie at the multiples of `size` [length]. Each of its cells is cut
        into 2 triangles or 6 tetrahedra, all cut in the same way, and the function's zeros on
        their edges are the corners of the facets. So the facets form a closed surface where the
        boundary is closed, their corners lie on it, and none is longer than sqrt(dim) size. A zero
        at a node counts as positive. The soil is on the left of a segment; the corners of a
        triangle are anticlockwise seen from the soil.
        """
        first = np.floor(np.asarray(lower) / size).astype(np.int64) - 1
        nodes = np.ceil(np.asarray(upper) / size).astype(np.int64) + 2 - first
        value = np.empty(int(np.prod(nodes)))
        for part in _chunks(len(value)):
            number = np.arange(part.start, min(part.stop, len(value)))
            value[part] = self.function(_node_positions(number, first, nodes, size))
        cells = _cut_cells((value >= 0.0).reshape(nodes))
        corners = np.array(list(product((0, 1), repeat=self.dim)))
        stride = np.append(np.cumprod(nodes[:0:-1])[::-1], 1)
        node = (cells @ stride)[:, None] + corners @ stride  # (cells, 2^dim)

        row, edge = self._crossed_edges(value[node] >= 0.0)
        ends = node[row[:, None, None], edge].reshape(-1, 2)
        unique, which = np.unique(ends[:, 0] * len(value) + ends[:, 1], return_inverse=True)
        start, end = np.divmod(unique, len(value))
        zero = self._zeros(
            _node_positions(start, first, nodes, size),
            _node_positions(end, first, nodes, size),
            value[start],
            value[end],
        )
        corner = zero[which.reshape(-1)].reshape(-1, self.dim, self.dim)
        area_vector = _area_vectors(corner)
        area = np.linalg.norm(area_vector, axis=1)
        kept = area > DEGENERATE_AREA_RATIO * size ** (self.dim - 1)
        group = _packed(cells + first)[row]
        return Facets(corner[kept], area_vector[kept] / area[kept, None], group[kept])

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """Returns the projections (n, dim) of points of facets onto the boundary, and area ratios.

        x, normal: points on facets and the facets' unit normals, shape (n, dim) each. A point is
        moved along the gradient by Newton's method until the function is zero.
        ratio: area on the boundary per area on the facet, shape (n,). The projection y(x) is a
        parametrisation of the boundary over the facet, so the ratio is the norm of the cross
        product of its derivatives along the facet (in 2D of its one derivative) for any function.
        The derivatives are central differences. To first order it is n . m / det(I + s H), with m
        the gradient, s the distance moved and H the curvature of the boundary. An integral by the
        facets' Gauss points then has the order of the Gauss rule.
        A point that the projection would move by more than a cell is returned unchanged, with
        ratio 1.
        """
        position, ratio = np.empty_like(x), np.empty(len(x))
        for part in _chunks(len(x)):
            position[part], ratio[part] = self._project(x[part], normal[part])
        return position, ratio

    def _project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        position, found = self._nearest(x)
        step = PROJECTION_DIFFERENCE_STEP * self.cell
        derivatives = []
        for tangent in _tangents(normal):
            ahead, found_ahead = self._nearest(x + step * tangent)
            behind, found_behind = self._nearest(x - step * tangent)
            derivatives.append((ahead - behind) / (2.0 * step))
            found &= found_ahead & found_behind
        ratio = np.linalg.norm(_normal_to(np.stack(derivatives, axis=1)), axis=1)
        # Near a corner the two points of a difference may be projected onto different sides of it.
        along = np.abs(np.sum(normal * self._directions(position), axis=1))
        ratio = np.where((ratio > 0.5 * along) & (ratio < 2.0 * along), ratio, along)
        return np.where(found[:, None], position, x), np.where(found, ratio, 1.0)

    def _nearest(self, x: Floats) -> tuple[Floats, Flags]:
        """Returns zeros of the function (n, dim) along its gradient, and the flags found (n,)."""
        position = x.copy()
        found = np.zeros(len(x), dtype=bool)
        active = np.arange(len(x))
        for _ in range(MAXIMUM_PROJECTION_ITERATIONS):
            value = self.function(position[active])
            slope, _steepest = self._slopes(position[active], value)
            square = np.sum(slope * slope, axis=1)
            move = (value / np.where(square > 0.0, square, np.inf))[:, None] * slope
            position[active] -= move
            length = np.linalg.norm(move, axis=1)
            far = np.linalg.norm(position[active] - x[active], axis=1) > self.cell
            done = (length <= PROJECTION_TOLERANCE * self.cell) & (square > 0.0) & ~far
            found[active[done]] = True
            active = active[~done & ~far & (square > 0.0)]
            if not len(active):
                break
        return position, found

    def _slopes(self, x: Floats, value: Floats) -> tuple[Floats, Floats]:
        """Returns the gradient (n, dim) by central differences, and the steepest slope (n,).

        The steepest slope is the norm of the larger one-sided differences along each axis.
        """
        step = self._difference(x)
        slope, steeper = np.empty_like(x), np.empty_like(x)
        for i in range(self.dim):
            ahead, behind = x.copy(), x.copy()
            ahead[:, i] += step
            behind[:, i] -= step
            width = ahead[:, i] - behind[:, i]  # as rounded
            after, before = self.function(ahead), self.function(behind)
            slope[:, i] = (after - before) / width
            steeper[:, i] = 2.0 * np.maximum(np.abs(after - value), np.abs(value - before)) / width
        return slope, np.linalg.norm(steeper, axis=1)

    def _difference(self, x: Floats) -> Floats:
        """Returns the step of the central differences at points (n, dim) [length], shape (n,)."""
        return np.asarray(
            np.maximum(
                DIFFERENCE_STEP * self.cell, RELATIVE_DIFFERENCE_STEP * np.abs(x).max(axis=1)
            )
        )

    def _directions(self, x: Floats) -> Floats:
        value = self.function(x)
        slope, _steepest = self._slopes(x, value)
        flat = np.flatnonzero(~(np.abs(slope).max(axis=1) > 0.0))
        for i in range(self.dim if len(flat) else 0):
            ahead = x[flat]
            ahead[:, i] += self._difference(ahead)
            slope[flat, i] = self.function(ahead) - value[flat]
        slope[~(np.abs(slope).max(axis=1) > 0.0), 0] = 1.0
        slope /= np.abs(slope).max(axis=1)[:, None]  # a tiny slope must not underflow
        return np.asarray(slope / np.linalg.norm(slope, axis=1)[:, None])

    def _crossed_edges(self, positive: Flags) -> tuple[Integers, Integers]:
        """Returns the facets of cells whose corners have the signs `positive` (cells, 2^dim).

        The results are the cell of each facet (n,) and, for each of its corners, the two corners of
        the cell between which it lies (n, dim, 2). Cells are in order; the order of the facets of a
        cell depends on its signs only.
        """
        rows, edges = [], []
        for vertices, facets_of in self._simplices:
            weight = 1 << np.arange(self.dim + 1)
            signs = positive[:, vertices] @ weight
            for pattern, facets in facets_of.items():
                chosen = np.flatnonzero(signs == pattern)
                for facet in facets:
                    rows.append(chosen)
                    edges.append(np.broadcast_to(facet, (len(chosen), *facet.shape)))
        row, edge = np.concatenate(rows), np.concatenate(edges)
        order = np.argsort(row, kind="stable")
        return row[order], edge[order]

    def _zeros(self, start: Floats, end: Floats, at_start: Floats, at_end: Floats) -> Floats:
        """Returns zeros of the function between `start` and `end` (n, dim), where its signs differ.

        The method is the Illinois form of the regula falsi, with a bisection every third iteration.
        The search on the edge, not along the gradient, keeps each corner in its cell.
        """
        low, high = np.zeros(len(start)), np.ones(len(start))
        f_low, f_high = at_start.copy(), at_end.copy()
        scale = np.abs(at_start) + np.abs(at_end)
        best = np.where(at_start == 0.0, 0.0, 1.0)
        moved_low = np.zeros(len(start), dtype=bool)
        active = np.flatnonzero((at_start != 0.0) & (at_end != 0.0))
        for iteration in range(MAXIMUM_EDGE_ITERATIONS):
            if not len(active):
                break
            a, b, fa, fb = low[active], high[active], f_low[active], f_high[active]
            t = 0.5 * (a + b)
            if iteration % 3 != 2:
                falsi = a - fa * (b - a) / (fb - fa)
                t = np.where((falsi > a) & (falsi < b), falsi, t)
            x = start[active] + t[:, None] * (end[active] - start[active])
            f = self.function(x)
            to_low = (f >= 0.0) == (fa >= 0.0)
            # The function value at an end that is kept twice is halved (Illinois).
            kept_factor = np.where(to_low == moved_low[active], 0.5, 1.0) if iteration else 1.0
            f_low[active] = np.where(to_low, f, kept_factor * fa)
            f_high[active] = np.where(to_low, kept_factor * fb, f)
            low[active], high[active] = np.where(to_low, t, a), np.where(to_low, b, t)
            moved_low[active] = to_low
            best[active] = t
            width = high[active] - low[active]
            active = active[(np.abs(f) > 1e-15 * scale[active]) & (width > 1e-15)]
        return start + best[:, None] * (end - start)


def _crossings(dim: int) -> list[tuple[Integers, dict[int, list[Integers]]]]:
    """Returns the simplices of a cell (Kuhn) and their facets for every pattern of signs.

    For each simplex they are the numbers of its vertices among the cell's corners (dim + 1,), and
    for each pattern (bit i set: vertex i is positive) the facets (dim, 2): the two corners of the
    cell between which each corner of the facet lies. The normals point to the positive vertices.
    """
    simplices = []
    for axes in permutations(range(dim)):
        vertex = np.zeros((dim + 1, dim))
        for i, axis in enumerate(axes):
            vertex[i + 1 :, axis] = 1.0
        number = (vertex @ 2 ** np.arange(dim)[::-1]).astype(np.int64)
        facets_of: dict[int, list[Integers]] = {}
        for pattern in range(1, 2 ** (dim + 1) - 1):
            inside = [i for i in range(dim + 1) if pattern >> i & 1]
            outside = [i for i in range(dim + 1) if not pattern >> i & 1]
            if len(inside) == 2 and len(outside) == 2:
                (a, b), (c, d) = inside, outside
                facets = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
            else:
                facets = [list(product(inside, outside))]
            facets_of[pattern] = []
            for facet in facets:
                edges = np.sort(np.array(facet), axis=1)
                towards = vertex[inside].mean(axis=0) - vertex[outside].mean(axis=0)
                if _area_vectors(vertex[edges].mean(axis=1)[None])[0] @ towards < 0.0:
                    edges[[0, 1]] = edges[[1, 0]]
                facets_of[pattern].append(number[edges])
        simplices.append((number, facets_of))
    return simplices


def _cut_cells(positive: Flags) -> Integers:
    """Returns the lattice cells (n, dim) whose corner nodes have different signs, in order."""
    every = np.ones([n - 1 for n in positive.shape], dtype=bool)
    some = np.zeros_like(every)
    for offset in product((0, 1), repeat=positive.ndim):
        corner = positive[tuple(slice(o, o + n) for o, n in zip(offset, every.shape, strict=True))]
        every &= corner
        some |= corner
    return np.argwhere(some & ~every)


def _node_positions(number: Integers, first: Integers, nodes: Integers, size: float) -> Floats:
    """Returns positions (n, dim) of numbered nodes; `first`: lowest index, `nodes`: their count."""
    index = np.stack(np.unravel_index(number, tuple(nodes)), axis=1)
    return size * (index + first).astype(np.float64)


def _packed(cell: Integers) -> Integers:
    """Returns one number for each lattice cell (n, dim), also for negative indices, shape (n,).

    The indices are taken modulo 2^31 (2D) or 2^20 (3D), more than the cells of one region.
    """
    bits = 31 if cell.shape[1] == 2 else 20
    packed = np.zeros(len(cell), dtype=np.int64)
    for i in range(cell.shape[1]):
        packed = packed << bits | cell[:, i] & (1 << bits) - 1
    return packed


def _area_vectors(corner: Floats) -> Floats:
    """Returns area vectors of facets (n, dim, dim): normal times length or area, (n, dim)."""
    vector = _normal_to(corner[:, 1:] - corner[:, :1])
    return vector if corner.shape[2] == 2 else 0.5 * vector


def _normal_to(edge: Floats) -> Floats:
    """Returns left normals of vectors (n, 1, 2), or cross products of pairs (n, 2, 3)."""
    if edge.shape[2] == 2:
        return np.stack([-edge[:, 0, 1], edge[:, 0, 0]], axis=1)
    return np.cross(edge[:, 0], edge[:, 1])


def _tangents(normal: Floats) -> list[Floats]:
    """Returns one (2D) or two (3D) orthonormal tangents (n, dim) to unit normals (n, dim)."""
    if normal.shape[1] == 2:
        return [np.stack([normal[:, 1], -normal[:, 0]], axis=1)]
    axis = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return [first, np.cross(normal, first)]


def _chunks(number: int) -> list[slice]:
    return [slice(i, i + POINTS_PER_BATCH) for i in range(0, number, POINTS_PER_BATCH)]
