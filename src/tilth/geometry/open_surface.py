# SPDX-License-Identifier: BSD-3-Clause
"""Open triangulated surface, such as a terrain (3D)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.stl_file import open_surface, read_stl
from tilth.errors import NOT_GIVEN, BadInput
from tilth.geometry.triangle_mesh import TriangleMesh


class OpenSurface(TriangleMesh):
    """An open triangulated surface with the soil on one side.

    Points beyond its border are on the side on which they are of the plane of the nearest triangle.

    Args:
        vertex: coordinates of its vertices [length], shape (m, 3).
        node: numbers of the triangles' corners (n, 3), anticlockwise seen from their front; each
            edge belongs to one triangle, at the border, or to two with opposite directions.
        front: whether the soil is in front, where the normals point.
    """

    def __init__(self, vertex: Floats, node: Integers, front: bool) -> None:
        node = self._set(vertex, node, 1.0 if front else -1.0)
        ends = np.sort(np.stack([node, np.roll(node, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        _, edge, uses = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
        single = (uses == 1)[edge.reshape(-1)]
        self._at_border = np.zeros((len(node), 7), dtype=bool)  # features as of `TriangleMesh`
        self._at_border[:, 1:4] = single.reshape(-1, 3)
        self._at_border[:, 4:] = np.isin(node, np.unique(ends[single]))
        self._border: tuple[float, Any] | None = None

    @classmethod
    def from_corners(
        cls, corner: Floats, front: bool, *, key: str = "geometry", value: Any = NOT_GIVEN
    ) -> OpenSurface:
        """Returns the surface of triangles with corners (n, 3, 3) [length], which are merged.

        Raises BadInput if the triangles are turned to different sides, more than two meet at an
        edge, or the surface is closed.
        """
        try:
            return cls(*open_surface(corner), front)
        except BadInput as error:
            raise BadInput(error.problem, error.remedy, key=key, value=value) from None

    @classmethod
    def from_file(cls, path: str | Path, soil: str, *, key: str = "geometry.file") -> OpenSurface:
        """Returns the surface in an STL file; soil: "front" or "back". Raises as `from_corners`."""
        return cls.from_corners(
            read_stl(Path(path), key), soil == "front", key=key, value=str(path)
        )

    def beyond_border(self, x: Floats, reach: float) -> Integers:
        """Returns the numbers of points (n, 3) beyond the border, within `reach` of it, (k,).

        There the nearest place is on the border, and no triangle is above or below the point.
        """
        from scipy.spatial import cKDTree  # takes 0.2 s: only where there is such a surface

        if self._border is None or self._border[0] != reach:
            self._border = reach, cKDTree(self.border(reach))
        tree = self._border[1]
        near = np.flatnonzero(np.isfinite(tree.query(x, distance_upper_bound=1.5 * reach)[0]))
        offset, _, number, feature = self._nearest(x[near])
        normal = self._pseudo_normal[number, 0]
        across = offset - np.einsum("ni,ni->n", offset, normal)[:, None] * normal
        away = np.linalg.norm(across, axis=1) > self._tolerance
        within = np.linalg.norm(offset, axis=1) <= reach
        return np.asarray(near[self._at_border[number, feature] & away & within])

    def border(self, spacing: float) -> Floats:
        """Returns places on the border at most `spacing` apart [length], shape (m, 3)."""
        places = []
        for k in range(3):
            own = self._at_border[:, 1 + k]
            start, end = self.corner[own, k], self.corner[own, (k + 1) % 3]
            count = np.ceil(np.linalg.norm(end - start, axis=1) / spacing).astype(np.int64)
            row = np.repeat(np.arange(len(start)), count)
            share = (np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)) / count[row]
            places.append(start[row] + share[:, None] * (end - start)[row])
        return np.concatenate(places)
