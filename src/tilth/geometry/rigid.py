# SPDX-License-Identifier: BSD-3-Clause
"""The surface of a rigid body where it is now: for pictures, and where it is deepest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.geometry.protocol import Geometry
from tilth.geometry.round import Circle, Sphere
from tilth.geometry.several import outside_of_others
from tilth.output.snapshot import SurfaceShape

_SAME_PLACE = 1e-9
"""Distance of vertices that are one, over the size of the body."""
_LEVEL = 1e-6
"""Difference of height of points that count as equally deep, over the size of the body."""


class RigidShape:
    """The surface of one or several shapes that move as one rigid body.

    Args:
        name: of the body.
        shapes: its geometries at time 0.
        centre: of its rotation at time 0 [length], shape (dim,).
        size: length of a facet, about [length].
        lower, upper: corners of a box that contains the soil [length], shape (dim,): unbounded
            geometries are cut there.
        axisymmetric: whether only what is on the right of the axis is kept.
    """

    def __init__(
        self,
        name: str,
        shapes: Sequence[Geometry],
        centre: Floats,
        size: float,
        lower: Floats,
        upper: Floats,
        axisymmetric: bool = False,
    ) -> None:
        self.name = name
        self._centre = np.asarray(centre, dtype=float)
        facets = [shape.facets(lower, upper, size) for shape in shapes]
        kept = [
            outside_of_others(shapes, number, each.corner.mean(axis=1), each.normal)
            for number, each in enumerate(facets)
        ]
        corner = np.concatenate([each.corner[own] for each, own in zip(facets, kept, strict=True)])
        normal = np.concatenate([each.normal[own] for each, own in zip(facets, kept, strict=True)])
        if axisymmetric:
            right = corner[:, :, 0].mean(axis=1) > 0.0
            corner, normal = corner[right], normal[right]
        self._vertex, self._cells = _joined(corner, normal)
        balls = [each for each in shapes if isinstance(each, Circle | Sphere)]
        self._balls = [(each.centre, each.radius) for each in balls]

    def at(self, displacement: Floats, rotation: Floats) -> SurfaceShape:
        """Returns the surface after a motion.

        displacement: of the centre [length], shape (dim,). rotation: rotation vector [rad], (3,).
        """
        position = self._moved(self._vertex, displacement, rotation)
        return SurfaceShape(self.name, position, self._cells, {})

    def lowest(self, displacement: Floats, rotation: Floats) -> Floats:
        """Returns the lowest point, the mean of all of them [length], shape (dim,).

        Exact for circles, spheres and shapes with flat sides; of other curved shapes that of the
        facets.
        """
        place = self._moved(self._vertex, displacement, rotation)
        for centre, radius in self._balls:
            bottom = self._moved(centre[None, :], displacement, rotation)
            bottom[:, -1] -= radius
            place = np.concatenate([place, bottom])
        depth = place[:, -1]
        level = depth <= depth.min() + _LEVEL * float(np.ptp(place, axis=0).max())
        found = place[level].mean(axis=0)
        found[-1] = depth.min()
        return np.asarray(found)

    def _moved(self, place: Floats, displacement: Floats, rotation: Floats) -> Floats:
        from scipy.spatial.transform import Rotation

        dim = len(self._centre)
        turn = Rotation.from_rotvec(rotation).as_matrix()[:dim, :dim]
        return np.asarray((place - self._centre) @ turn.T + self._centre + displacement)


def _joined(corner: Floats, normal: Floats) -> tuple[Floats, Integers]:
    """Returns vertices and cells of facets, with their normals on the left or by the right hand."""
    dim = corner.shape[2]
    first = corner[:, 1] - corner[:, 0]
    if dim == 2:
        side = first[:, 0] * normal[:, 1] - first[:, 1] * normal[:, 0]
    else:
        side = np.einsum("ni,ni->n", np.cross(first, corner[:, 2] - corner[:, 0]), normal)
    wrong = side < 0.0
    order = np.where(wrong[:, None], np.arange(dim)[::-1], np.arange(dim))
    corner = np.take_along_axis(corner, order[:, :, None], axis=1)
    size = float(np.ptp(corner.reshape(-1, dim), axis=0).max()) or 1.0
    key = np.round(corner.reshape(-1, dim) / (_SAME_PLACE * size) + 0.123)
    _, chosen, number = np.unique(key, axis=0, return_index=True, return_inverse=True)
    cells = number.reshape(-1, dim).astype(np.int64)
    return corner.reshape(-1, dim)[chosen], _in_chains(cells) if dim == 2 else cells


def _in_chains(segment: Integers) -> Integers:
    """Returns segments (m, 2) in such an order that each begins where the last one ends."""
    from_vertex: dict[int, list[int]] = {}
    for number, begin in enumerate(segment[:, 0].tolist()):
        from_vertex.setdefault(begin, []).append(number)
    ends = set(segment[:, 1].tolist())
    open_ones = [k for k, begin in enumerate(segment[:, 0].tolist()) if begin not in ends]
    order: dict[int, None] = {}
    for first in [*open_ones, *range(len(segment))]:
        following = [first]
        while following := [k for k in following if k not in order]:
            order[following[0]] = None
            following = from_vertex.get(int(segment[following[0], 1]), [])
    return segment[list(order)]
