# SPDX-License-Identifier: BSD-3-Clause
"""A closed surface of triangles, from an STL file."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.errors import NOT_GIVEN, BadInput
from tilth.geometry.protocol import Facets

# Corners nearer than this, as a fraction of the largest extent or coordinate, are the same: the
# precision of a binary file.
MERGED = 1e-7
# Triangles whose height is below this fraction of their longest edge have no normal: dropped.
DEGENERATE = 1e-9
# A place nearer than this, as a fraction of the mesh's extent and coordinates, lies on the surface
# as far as its direction is concerned. Also the margin for round-off in the search.
ON_SURFACE = 1e-12
# Pairs of places and triangles, or places, that are worked on at once.
PAIRS = 1 << 20
CHUNK = 1 << 14


class TriangleMesh:
    """The surface of a body of triangles; the soil is inside or outside of it.

    corner: coordinates of the triangles' corners (n, 3, 3) [length]. Corners that differ by no
        more than the round-off of a file in single precision are the same. The surface must be
        closed: each edge belongs to two triangles that pass it in opposite directions. It may
        have several pieces and hollows. Triangles without an area are left out.
    inside: whether the soil is inside.
    key, value: where the mesh stands in the case file, and what is said there, for messages.
    Raises BadInput if the surface is not closed or encloses no volume.
    """

    dim = 3
    bounded = True
    flat = True

    def __init__(
        self, corner: Floats, inside: bool, *, key: str = "geometry", value: Any = NOT_GIVEN
    ) -> None:
        corner = np.asarray(corner, dtype=np.float64)
        if not len(corner) or not np.isfinite(corner).all():
            raise BadInput(
                "holds no triangles" if not len(corner) else "holds places that are not numbers",
                "save the surface of a body as triangles",
                key=key,
                value=value,
            )
        vertex, node = _merged(corner)
        node = node[(node != np.roll(node, 1, axis=1)).all(axis=1)]
        problem = _not_closed(node, vertex)
        if problem:
            remedy = "repair the mesh (close its holes, turn its triangles alike), save it again"
            raise BadInput(problem, remedy, key=key, value=value)
        extent = float(np.ptp(vertex, axis=0).max())
        relative = (vertex - vertex.mean(axis=0))[node]
        volume = np.linalg.det(relative).sum() / 6.0
        if abs(volume) <= DEGENERATE * extent**3:
            raise BadInput(
                f"encloses no volume ({volume:.3g})",
                "save the closed surface of a body with a thickness",
                key=key,
                value=value,
            )
        if volume < 0.0:
            node = node[:, ::-1]
        self.volume = abs(float(volume))
        self._sign = -1.0 if inside else 1.0
        twice_area = np.cross(
            vertex[node[:, 1]] - vertex[node[:, 0]], vertex[node[:, 2]] - vertex[node[:, 0]]
        )
        longest = np.linalg.norm(vertex[node] - vertex[np.roll(node, 1, axis=1)], axis=2).max(
            axis=1
        )
        norm = np.linalg.norm(twice_area, axis=1)
        kept = norm > DEGENERATE * longest**2
        node, outward = node[kept], twice_area[kept] / norm[kept, None]
        self.corner = vertex[node]
        self._tolerance = ON_SURFACE * max(extent, float(np.abs(vertex).max()))
        self._pseudo_normal = _pseudo_normals(node, self.corner, outward)
        self._centre = self.corner.mean(axis=1)
        self._radius = np.linalg.norm(self.corner - self._centre[:, None], axis=2).max(axis=1)
        self._size_classes = _size_classes(self._centre, self._radius)

    @classmethod
    def from_file(cls, path: str | Path, soil: str, *, key: str = "geometry.file") -> TriangleMesh:
        """Returns the surface in an STL file, text or binary.

        soil: "inside" or "outside" of it.
        Raises BadInput for a file that is missing or cannot be read, a surface that is not closed,
        and if the package meshio is missing.
        """
        return cls(_read(Path(path), key), soil == "inside", key=key, value=str(path))

    def distance(self, x: Floats) -> Floats:
        """Returns the exact signed distance [length] of places (n, 3), > 0 in the soil, (n,)."""
        offset, pseudo_normal, _number, _feature = self._nearest(x)
        outside = np.sum(offset * pseudo_normal, axis=1)
        side = np.where(outside < 0.0, -self._sign, self._sign)
        return np.asarray(side * np.linalg.norm(offset, axis=1))

    def gradient(self, x: Floats) -> Floats:
        """Returns the direction into the soil at places (n, 3): unit vectors, same shape.

        Where the nearest place lies within a triangle, and at distance zero, the normal there; on
        an edge or a corner that is the mean of the triangles'.
        """
        offset, pseudo_normal, _number, feature = self._nearest(x)
        length = np.linalg.norm(offset, axis=1)
        outside = np.where(np.sum(offset * pseudo_normal, axis=1) < 0.0, -1.0, 1.0)
        by_normal = (feature == 0) | (length <= self._tolerance)
        direction = np.where(by_normal[:, None], pseudo_normal, outside[:, None] * offset)
        return np.asarray(self._sign * direction / np.linalg.norm(direction, axis=1)[:, None])

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """Returns all triangles, each cut into k^2 equal ones with edges up to `size` [length].

        The box from `lower` to `upper` is not used. The patch is the triangle's number.
        """
        del lower, upper
        edge = np.linalg.norm(self.corner - np.roll(self.corner, 1, axis=1), axis=2).max(axis=1)
        cuts = np.maximum(np.ceil(edge / size * (1.0 - 1e-12)), 1.0).astype(np.int64)
        number = cuts**2
        first = np.cumsum(number) - number
        corner = np.empty((int(number.sum()), 3, 3))
        for k in np.unique(cuts):
            chosen = np.flatnonzero(cuts == k)
            where = first[chosen][:, None] + np.arange(k * k)
            corner[where] = np.einsum("pcv,tvi->tpci", _pieces(int(k)), self.corner[chosen])
        patch = np.repeat(np.arange(len(cuts)), number)
        order = [0, 1, 2] if self._sign > 0.0 else [0, 2, 1]  # anticlockwise seen from the soil
        return Facets(corner[:, order], self._sign * self._pseudo_normal[patch, 0], patch)

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """Returns the places themselves (n, 3) and the ratio 1 (n,): facets are the surface."""
        del normal
        return x, np.ones(len(x))

    def _nearest(self, x: Floats) -> tuple[Floats, Floats, Integers, Integers]:
        """What is nearest to places (n, 3).

        Returns x minus the nearest place (n, 3), the outward pseudo-normal there (n, 3), not a
        unit vector on edges and corners, the triangle (n,) and its feature (n,), see `_closest`.
        """
        x = np.asarray(x, dtype=np.float64)
        number = np.empty(len(x), dtype=np.int64)
        for start in range(0, len(x), CHUNK):
            number[start : start + CHUNK] = self._nearest_triangle(x[start : start + CHUNK])
        offset, feature = _closest(x, self.corner[number])
        return offset, self._pseudo_normal[number, feature], number, feature

    def _nearest_triangle(self, x: Floats) -> Integers:
        """Numbers of the nearest triangles of places (n, 3).

        A first guess, the triangle with the nearest centre of each class of sizes, bounds the
        distance from above. Only triangles whose sphere about the centre comes as near as this
        can be nearer, and all of these are looked at.
        """
        best = np.full(len(x), np.inf)
        nearest = np.zeros(len(x), dtype=np.int64)
        for tree, member, _radius in self._size_classes:
            guess = member[tree.query(x)[1]]
            length = np.linalg.norm(_closest(x, self.corner[guess])[0], axis=1)
            nearest, best = np.where(length < best, guess, nearest), np.minimum(length, best)
        for tree, member, radius in self._size_classes:
            reach = (best + radius) * (1.0 + 1e-9) + self._tolerance
            found = np.asarray(tree.query_ball_point(x, reach, return_length=True))
            total = np.cumsum(found)
            start = 0
            while start < len(x):  # as many places as fill one batch of pairs, at least one
                passed = total[start - 1] if start else 0
                stop = max(int(np.searchsorted(total, passed + PAIRS, side="right")), start + 1)
                rows = np.arange(start, stop)
                lists = tree.query_ball_point(x[rows], reach[rows], return_sorted=True)
                place = np.repeat(rows, found[rows])
                if len(place):
                    local = np.concatenate(lists).astype(np.int64)
                    length, tried = self._tried(x, best, place, member[local])
                    _reduce(best, nearest, place[tried], member[local[tried]], length)
                start = stop
        return nearest

    def _tried(
        self, x: Floats, best: Floats, place: Integers, triangle: Integers
    ) -> tuple[Floats, Integers]:
        """Distances of the pairs that can beat `best`, and which of the pairs these are.

        A triangle is no nearer than the disc about its centre that holds it.
        """
        to = x[place] - self._centre[triangle]
        square = np.einsum("ni,ni->n", to, to)
        height = np.einsum("ni,ni->n", to, self._pseudo_normal[triangle, 0])
        beside = np.sqrt(np.maximum(square - height * height, 0.0)) - self._radius[triangle]
        gap = np.hypot(height, np.maximum(beside, 0.0))
        margin = 1e-6 * self._radius[triangle] + self._tolerance  # thin triangles' normals
        tried = np.flatnonzero(gap <= best[place] * (1.0 + 1e-9) + margin)
        offset, _feature = _closest(x[place[tried]], self.corner[triangle[tried]])
        return np.linalg.norm(offset, axis=1), tried


def _reduce(
    best: Floats, nearest: Integers, place: Integers, triangle: Integers, length: Floats
) -> None:
    """Enters into `best` and `nearest` what is nearer among the pairs of place and triangle."""
    order = np.lexsort((triangle, length, place))
    place, triangle, length = place[order], triangle[order], length[order]
    first = np.ones(len(place), dtype=bool)
    first[1:] = place[1:] != place[:-1]
    place, triangle, length = place[first], triangle[first], length[first]
    nearer = length < best[place]
    best[place[nearer]], nearest[place[nearer]] = length[nearer], triangle[nearer]


def _closest(x: Floats, corner: Floats) -> tuple[Floats, Integers]:
    """Vectors (n, 3) to places x from the nearest places of one triangle (n, 3, 3) each.

    Also on which feature of the triangle that place lies (n,): 0 its inside, 1 to 3 the edges
    from corners 0, 1 and 2 to the next ones, 4 to 6 the corners.
    """
    to = x[:, None] - corner
    edge = np.roll(corner, -1, axis=1) - corner
    normal = np.cross(edge[:, 0], edge[:, 1])
    inward = np.cross(normal[:, None], edge)
    inside = (np.einsum("nij,nij->ni", inward, to) > 0.0).all(axis=1)
    # On the outline: the nearest of the three edges.
    square = np.einsum("nij,nij->ni", edge, edge)
    along = np.clip(np.einsum("nij,nij->ni", edge, to) / square, 0.0, 1.0)
    offsets = to - along[..., None] * edge
    which = np.argmin(np.einsum("nij,nij->ni", offsets, offsets), axis=1)
    row = np.arange(len(x))
    at = along[row, which]
    feature = np.where(at == 0.0, 4 + which, np.where(at == 1.0, 4 + (which + 1) % 3, 1 + which))
    height = np.einsum("ni,ni->n", to[:, 0], normal) / np.einsum("ni,ni->n", normal, normal)
    offset = np.where(inside[:, None], height[:, None] * normal, offsets[row, which])
    return offset, np.where(inside, 0, feature)


def _pseudo_normals(node: Integers, corner: Floats, outward: Floats) -> Floats:
    """Outward normals (n, 7, 3) of each triangle's inside, edges and corners, as in `_closest`.

    On an edge the sum of the two triangles' normals, at a corner the sum of those of all
    triangles there, weighted by their angles: with these the sign of the distance is right
    (Baerentzen and Aanaes 2005, https://doi.org/10.1109/TVCG.2005.49).
    """
    normals = np.empty((len(node), 7, 3))
    normals[:, 0] = outward
    ends = np.sort(np.stack([node, np.roll(node, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    _, edge = np.unique(ends, axis=0, return_inverse=True)
    edge = edge.reshape(-1, 3)
    ahead = np.roll(corner, -1, axis=1) - corner
    back = np.roll(corner, 1, axis=1) - corner
    sine = np.linalg.norm(np.cross(ahead, back), axis=2)
    angle = np.arctan2(sine, np.einsum("nij,nij->ni", ahead, back))
    for columns, number, weight in (
        (slice(1, 4), edge, np.ones_like(angle)),
        (slice(4, 7), node, angle),
    ):
        total = np.zeros((int(number.max()) + 1, 3))
        np.add.at(total, number, weight[..., None] * outward[:, None])
        # Two triangles folded onto each other have no normal on their edge.
        lost = np.linalg.norm(total, axis=1)[number] <= 1e-12
        normals[:, columns] = np.where(lost[..., None], outward[:, None], total[number])
    return normals


def _size_classes(centre: Floats, radius: Floats) -> list[tuple[Any, Integers, float]]:
    """Triangles sorted by size: for each factor of 2 a tree of their centres.

    With each tree the triangles' numbers and the largest radius of a sphere about a centre.
    """
    from scipy.spatial import cKDTree  # takes 0.2 s: only where there is such a surface

    size = np.floor(np.log2(radius)).astype(np.int64)
    members = [np.flatnonzero(size == s) for s in np.unique(size)]
    return [(cKDTree(centre[m]), m, float(radius[m].max())) for m in members]


def _merged(corner: Floats) -> tuple[Floats, Integers]:
    """Different corners (m, 3) of triangles (n, 3, 3), and their numbers in each (n, 3)."""
    from scipy.sparse import coo_array  # take 0.2 s: only where there is such a surface
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    vertex, node = np.unique(corner.reshape(-1, 3), axis=0, return_inverse=True)
    reach = MERGED * max(float(np.ptp(vertex, axis=0).max()), float(np.abs(vertex).max()))
    pairs = cKDTree(vertex).query_pairs(reach, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), 2 * (len(vertex),))
    _, group = connected_components(links, directed=False)
    _, first, number = np.unique(group, return_index=True, return_inverse=True)
    return vertex[first], number[node].reshape(-1, 3).astype(np.int64)


def _not_closed(node: Integers, vertex: Floats) -> str:
    """What keeps the triangles (n, 3) from being a closed surface, in words; or nothing."""
    directed = np.stack([node, np.roll(node, -1, axis=1)], axis=2).reshape(-1, 2)
    forward = directed[:, 0] < directed[:, 1]
    ends, edge, uses = np.unique(
        np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    turns = np.bincount(edge.reshape(-1), weights=np.where(forward, 1.0, -1.0))
    problems = []
    for wrong, said in (
        (uses == 1, "with a triangle on one side only"),
        (uses > 2, "with more than two triangles"),
        ((uses == 2) & (turns != 0.0), "whose two triangles are turned to opposite sides"),
    ):
        if wrong.any():
            first = vertex[ends[np.argmax(wrong)]].mean(axis=0)
            place = ", ".join(f"{c:.6g}" for c in first)
            problems.append(f"{wrong.sum()} edges {said} (the first near {place})")
    return f"the surface is not closed: {'; '.join(problems)}" if problems else ""


def _pieces(k: int) -> Floats:
    """Weights (k^2, 3, 3) of a triangle's corners for the corners of its k^2 equal pieces."""
    pieces = []
    for i in range(k):
        for j in range(k - i):
            pieces.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j < k - 1:
                pieces.append([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    steps = np.array(pieces, dtype=np.float64)
    return np.concatenate([k - steps.sum(axis=2, keepdims=True), steps], axis=2) / k


def _read(file: Path, key: str) -> Floats:
    """Corners (n, 3, 3) of the triangles in an STL file."""

    def refused(problem: str, remedy: str) -> BadInput:
        return BadInput(problem, remedy, key=key, value=str(file))

    try:
        meshio = importlib.import_module("meshio")
    except ModuleNotFoundError as error:
        raise refused(
            "an STL file needs the package meshio, which is not installed",
            "install it with `pip install tilth[mesh]`",
        ) from error
    if not file.is_file():
        raise refused("there is no such file", "check the name and the folder")
    try:
        with np.errstate(over="ignore"):  # it takes a text for the number of triangles, and looks
            mesh = meshio.stl.read(file)
        node = mesh.get_cells_type("triangle")
        place = np.asarray(mesh.points, dtype=np.float64).reshape(-1, 3)
        return np.asarray(place[node.reshape(-1, 3)])
    except (meshio.ReadError, OSError, ValueError, KeyError, IndexError, AttributeError) as error:
        reason = str(error) or "it is not in that format, or not complete"
        raise refused(
            f"cannot be read as an STL file: {reason}", "save the surface as an .stl file"
        ) from error
