# SPDX-License-Identifier: BSD-3-Clause
"""The boundary where a user's function of place is zero."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations, product

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.geometry.protocol import Facets

# Step of the central differences of the function, in cells: its error, the square of this, is
# below the round-off of the differences.
DIFFERENCE = 1e-5
# The least step, as a fraction of the coordinates: those of a map may be millions of cells.
FAR_DIFFERENCE = 1e-10
# Step of the differences of the projection along a facet, in cells.
STRETCH = 1e-4
# Facets with an area below this fraction of size^(dim - 1) are dropped.
DEGENERATE = 1e-10
# A function whose gradient's norm is nearer to 1 than this is taken as a signed distance.
UNIT_SLOPE = 1e-5
# Places at which the function is evaluated at once.
CHUNK = 1 << 19
# The projection ends with a move below this fraction of a cell; Newton's method squares it.
CONVERGED = 1e-7
# Iterations of the search along an edge of the lattice, and of the projection.
SEARCH = 100
PROJECTION = 20


class LevelSet:
    """The places where `function` is zero; the soil is where it is positive.

    function: takes places (n, dim) [length] and returns a number for each, shape (n,). It should
        be the signed distance [length]. Where it is not, value and gradient are divided by the
        gradient's norm, which gives the distance to first order: right on the boundary, an
        estimate far from it. Its gradient must not vanish on the boundary. It is also evaluated
        one cell of the lattice outside the box that the facets are asked for.
    dim: 2 or 3.
    cell_size: lengths of the grid's cells [length]; the smallest scales the differences.

    Where the function has a kink (a corner of the boundary) the facets cut the corner off by up
    to their size; a polyline or a box has exact corners. A part of the boundary or of the soil
    that is thinner than a facet can be missed.
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
        """Returns the signed distance [length] of places (n, dim), > 0 in the soil, shape (n,).

        The function itself where its gradient has the norm 1; otherwise divided by that norm.
        """
        value = np.empty(len(x))
        for part in _chunks(len(x)):
            value[part] = self.function(x[part])
            slope, steepest = self._slopes(x[part], value[part])
            norm = np.linalg.norm(slope, axis=1)
            # At a kink, such as the middle between two walls, the central difference is less than
            # the slope on either side.
            norm = np.where(steepest > (1.0 + 1e-2) * norm, steepest, norm)
            usable = (norm > 0.0) & (np.abs(norm - 1.0) > UNIT_SLOPE)
            value[part] /= np.where(usable, norm, 1.0)
        return value

    def gradient(self, x: Floats) -> Floats:
        """Returns the direction into the soil at places (n, dim): unit vectors, same shape.

        By central differences. Where they vanish (the centre of a circle) the forward difference
        is taken, and the first axis where that vanishes too.
        """
        direction = np.empty_like(x)
        for part in _chunks(len(x)):
            direction[part] = self._directions(x[part])
        return direction

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """Returns the facets in and a little around the box from `lower` to `upper` (dim,) each.

        The nodes of the lattice lie at the multiples of `size` [length]. Each of its cells is cut
        into 2 triangles or 6 tetrahedra, all cut in the same way, and the function's zeros on
        their edges are the corners of the facets. So the facets are closed where the boundary is,
        their corners lie on it, and none is longer than sqrt(dim) size. A zero at a node counts
        as positive. The corners of a facet are in such an order that the soil is on the left of a
        segment, and that a triangle is anticlockwise seen from the soil.
        """
        first = np.floor(np.asarray(lower) / size).astype(np.int64) - 1
        nodes = np.ceil(np.asarray(upper) / size).astype(np.int64) + 2 - first
        value = np.empty(int(np.prod(nodes)))
        for part in _chunks(len(value)):
            number = np.arange(part.start, min(part.stop, len(value)))
            value[part] = self.function(_node_places(number, first, nodes, size))
        cells = _cut_cells((value >= 0.0).reshape(nodes))
        corners = np.array(list(product((0, 1), repeat=self.dim)))
        stride = np.append(np.cumprod(nodes[:0:-1])[::-1], 1)
        node = (cells @ stride)[:, None] + corners @ stride  # (cells, 2^dim)

        row, edge = self._crossed_edges(value[node] >= 0.0)
        ends = node[row[:, None, None], edge].reshape(-1, 2)
        unique, which = np.unique(ends[:, 0] * len(value) + ends[:, 1], return_inverse=True)
        start, end = np.divmod(unique, len(value))
        zero = self._zeros(
            _node_places(start, first, nodes, size),
            _node_places(end, first, nodes, size),
            value[start],
            value[end],
        )
        corner = zero[which.reshape(-1)].reshape(-1, self.dim, self.dim)
        area_vector = _area_vectors(corner)
        area = np.linalg.norm(area_vector, axis=1)
        kept = area > DEGENERATE * size ** (self.dim - 1)
        patch = _packed(cells + first)[row]
        return Facets(corner[kept], area_vector[kept] / area[kept, None], patch[kept])

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """Returns the places (n, dim) on the boundary for places on facets, and the area's ratio.

        x, normal: places on facets and the facets' unit normals, shape (n, dim) each. A place is
        moved along the gradient by Newton's method until the function is zero.
        ratio: area on the boundary per area on the facet, shape (n,). The projection y(x) is a
        parametrisation of the boundary over the facet, so the ratio is the norm of the cross
        product of its derivatives along the facet (in 2D of its one derivative), whatever the
        function. They are taken by central differences. To first order it is n . m / det(I + s H),
        with m the gradient, s the distance moved and H the curvature of the boundary. An integral
        by the facets' Gauss points then has the order of the Gauss rule.
        A place that the projection moves by more than a cell stays where it is, with ratio 1.
        """
        place, ratio = np.empty_like(x), np.empty(len(x))
        for part in _chunks(len(x)):
            place[part], ratio[part] = self._project(x[part], normal[part])
        return place, ratio

    def _project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        place, found = self._nearest(x)
        step = STRETCH * self.cell
        derivatives = []
        for tangent in _tangents(normal):
            ahead, found_ahead = self._nearest(x + step * tangent)
            behind, found_behind = self._nearest(x - step * tangent)
            derivatives.append((ahead - behind) / (2.0 * step))
            found &= found_ahead & found_behind
        ratio = np.linalg.norm(_normal_to(np.stack(derivatives, axis=1)), axis=1)
        # Next to a kink the two sides of a difference may be projected onto different pieces.
        along = np.abs(np.sum(normal * self._directions(place), axis=1))
        ratio = np.where((ratio > 0.5 * along) & (ratio < 2.0 * along), ratio, along)
        return np.where(found[:, None], place, x), np.where(found, ratio, 1.0)

    def _nearest(self, x: Floats) -> tuple[Floats, Flags]:
        """Places (n, dim) along the gradient where the function is zero, and whether found."""
        place = x.copy()
        found = np.zeros(len(x), dtype=bool)
        active = np.arange(len(x))
        for _ in range(PROJECTION):
            value = self.function(place[active])
            slope, _steepest = self._slopes(place[active], value)
            square = np.sum(slope * slope, axis=1)
            move = (value / np.where(square > 0.0, square, np.inf))[:, None] * slope
            place[active] -= move
            length = np.linalg.norm(move, axis=1)
            far = np.linalg.norm(place[active] - x[active], axis=1) > self.cell
            done = (length <= CONVERGED * self.cell) & (square > 0.0) & ~far
            found[active[done]] = True
            active = active[~done & ~far & (square > 0.0)]
            if not len(active):
                break
        return place, found

    def _slopes(self, x: Floats, value: Floats) -> tuple[Floats, Floats]:
        """Gradient of the function (n, dim) by central differences, and its steepest slope (n,).

        The steepest slope takes the steeper one of the two sides in each direction.
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
        """Step of the central differences at places (n, dim), longer far from the origin, (n,)."""
        return np.asarray(
            np.maximum(DIFFERENCE * self.cell, FAR_DIFFERENCE * np.abs(x).max(axis=1))
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
        """Facets of cells with the signs `positive` (cells, 2^dim) of their corners.

        Returns the cell of each facet (n,) and, for each of its corners, the two corners of the
        cell between which it lies (n, dim, 2); cells in order, and always the same order in one.
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
        """Zeros of the function between `start` and `end` (n, dim), where its signs differ.

        By the Illinois form of the regula falsi, with a bisection every third time. Searching on
        the edge, not along the gradient, keeps each corner in its cell for any function.
        """
        low, high = np.zeros(len(start)), np.ones(len(start))
        f_low, f_high = at_start.copy(), at_end.copy()
        scale = np.abs(at_start) + np.abs(at_end)
        best = np.where(at_start == 0.0, 0.0, 1.0)
        moved_low = np.zeros(len(start), dtype=bool)
        active = np.flatnonzero((at_start != 0.0) & (at_end != 0.0))
        for iteration in range(SEARCH):
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
            # An end that stays a second time counts half from then on.
            stays = np.where(to_low == moved_low[active], 0.5, 1.0) if iteration else 1.0
            f_low[active] = np.where(to_low, f, stays * fa)
            f_high[active] = np.where(to_low, stays * fb, f)
            low[active], high[active] = np.where(to_low, t, a), np.where(to_low, b, t)
            moved_low[active] = to_low
            best[active] = t
            width = high[active] - low[active]
            active = active[(np.abs(f) > 1e-15 * scale[active]) & (width > 1e-15)]
        return start + best[:, None] * (end - start)


def _crossings(dim: int) -> list[tuple[Integers, dict[int, list[Integers]]]]:
    """The simplices of a cell (Kuhn) and their facets for every pattern of signs.

    For each simplex the numbers of its vertices among the cell's corners (dim + 1,), and for each
    pattern (bit i set: vertex i is positive) the facets (dim, 2): between which two corners of the
    cell each corner of the facet lies. Their normals point to the positive vertices.
    """
    simplices = []
    for axes in permutations(range(dim)):
        place = np.zeros((dim + 1, dim))
        for i, axis in enumerate(axes):
            place[i + 1 :, axis] = 1.0
        number = (place @ 2 ** np.arange(dim)[::-1]).astype(np.int64)
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
                towards = place[inside].mean(axis=0) - place[outside].mean(axis=0)
                if _area_vectors(place[edges].mean(axis=1)[None])[0] @ towards < 0.0:
                    edges[[0, 1]] = edges[[1, 0]]
                facets_of[pattern].append(number[edges])
        simplices.append((number, facets_of))
    return simplices


def _cut_cells(positive: Flags) -> Integers:
    """Cells (n, dim) of a lattice of nodes whose corners have different signs, in order."""
    every = np.ones([n - 1 for n in positive.shape], dtype=bool)
    some = np.zeros_like(every)
    for offset in product((0, 1), repeat=positive.ndim):
        corner = positive[tuple(slice(o, o + n) for o, n in zip(offset, every.shape, strict=True))]
        every &= corner
        some |= corner
    return np.argwhere(some & ~every)


def _node_places(number: Integers, first: Integers, nodes: Integers, size: float) -> Floats:
    """Places (n, dim) of the nodes with these numbers; `first` is the lowest, `nodes` how many."""
    index = np.stack(np.unravel_index(number, tuple(nodes)), axis=1)
    return size * (index + first).astype(np.float64)


def _packed(cell: Integers) -> Integers:
    """One number for each lattice cell (n, dim), also for negative indices, shape (n,).

    The indices are kept modulo 2^31 (2D) or 2^20 (3D): far more than the cells of one region.
    """
    bits = 31 if cell.shape[1] == 2 else 20
    packed = np.zeros(len(cell), dtype=np.int64)
    for i in range(cell.shape[1]):
        packed = packed << bits | cell[:, i] & (1 << bits) - 1
    return packed


def _area_vectors(corner: Floats) -> Floats:
    """Normals of facets (n, dim, dim), with the facets' length or area as norm, shape (n, dim)."""
    vector = _normal_to(corner[:, 1:] - corner[:, :1])
    return vector if corner.shape[2] == 2 else 0.5 * vector


def _normal_to(edge: Floats) -> Floats:
    """Left normals of one vector (n, 1, 2), cross products of two (n, 2, 3), shape (n, dim)."""
    if edge.shape[2] == 2:
        return np.stack([-edge[:, 0, 1], edge[:, 0, 0]], axis=1)
    return np.cross(edge[:, 0], edge[:, 1])


def _tangents(normal: Floats) -> list[Floats]:
    """One (2D) or two (3D) orthonormal vectors (n, dim) at right angles to unit normals."""
    if normal.shape[1] == 2:
        return [np.stack([normal[:, 1], -normal[:, 0]], axis=1)]
    axis = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return [first, np.cross(normal, first)]


def _chunks(number: int) -> list[slice]:
    return [slice(i, i + CHUNK) for i in range(0, number, CHUNK)]
