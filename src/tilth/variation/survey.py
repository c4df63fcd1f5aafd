# SPDX-License-Identifier: BSD-3-Clause
"""Heights at survey points at any places in plan, linear on triangles between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.errors import BadInput
from tilth.variation.csv_file import read_csv
from tilth.variation.heights import NAMES
from tilth.variation.tables import ROUND_OFF


@dataclass(frozen=True)
class Survey:
    """Heights on the Delaunay triangulation of survey points.

    Attributes:
        origin: place of the file from which `place` counts [length], shape (2,). Map coordinates
            have few digits left for distances between points.
        extent: greatest extent of the points along x or y [length].
        place: places of the points less the origin, over the extent [-], shape (n, 2).
        height: their heights [length], shape (n,).
        triangulation: `scipy.spatial.Delaunay` of the places.
    """

    origin: Floats
    extent: float
    place: Floats
    height: Floats
    triangulation: Any

    def triangles(self) -> Floats:
        """Returns the corners x, y less the origin, and height [length], shape (m, 3, 3)."""
        corner = np.column_stack([self.place * self.extent, self.height])
        return np.asarray(corner[self.triangulation.simplices])

    def at(self, position: Floats, key: str, file: str) -> Floats:
        """Returns the heights at positions (n, dim), linear on each triangle, shape (n,).

        Raises:
            BadInput: a position outside the convex hull of the points, with its place; `key` and
                `file` are named.
        """
        from scipy.interpolate import LinearNDInterpolator  # takes 0.2 s: only where needed

        place = (position[:, :2] - self.origin) / self.extent
        height = np.asarray(LinearNDInterpolator(self.triangulation, self.height)(place))
        if len(none := np.flatnonzero(np.isnan(height))):
            distance, height[none] = self._on_hull(place[none])
            beyond = np.flatnonzero(distance > ROUND_OFF)
            if len(beyond):
                far = beyond[0]
                raise BadInput(
                    f"{map_text(position[none[far], :2])} is outside the survey, "
                    f"{distance[far] * self.extent:.6g} from the convex hull of its points "
                    f"({len(beyond)} of {len(height)} places are outside)",
                    "add survey points around the soil, or let the body end between those given",
                    key=key,
                    value=file,
                )
        return height

    def _on_hull(self, place: Floats) -> tuple[Floats, Floats]:
        """Returns the distance [-] of places (k, 2) from the hull, and the height there, (k,)."""
        least, height = np.full(len(place), np.inf), np.empty(len(place))
        for one, other in self.triangulation.convex_hull:
            edge, to = self.place[other] - self.place[one], place - self.place[one]
            share = np.clip(to @ edge / (edge @ edge), 0.0, 1.0)
            distance = np.linalg.norm(to - share[:, None] * edge, axis=1)
            nearer = distance < least
            own = self.height[one] + share * (self.height[other] - self.height[one])
            least, height = np.where(nearer, distance, least), np.where(nearer, own, height)
        return least, height


def map_text(place: Floats) -> str:
    """Returns a place in plan (dim - 1,) with the digits that map coordinates need."""
    return f"({', '.join(f'{each:.10g}' for each in place)})"


def read_survey(file: str, axes: int, key: str) -> Survey:
    """Reads survey points: a line with the names x, y, z, then a row for each point.

    The triangles are those of Delaunay (Barber, Dobkin & Huhdanpaa 1996, Qhull), with the convex
    hull of the points as boundary. A place may be repeated with the same height.

    Args:
        file: path of the .csv file.
        axes: number of horizontal axes.
        key: of the entry in the case file, for messages.

    Raises:
        BadInput: the file cannot be read, has two heights at a place, or has no three points that
            are not on one line.
    """
    from scipy.spatial import Delaunay, QhullError, cKDTree

    def refused(problem: str, remedy: str) -> BadInput:
        return BadInput(problem, remedy, key=key, value=file)

    if axes != 2:
        raise refused("survey points are for 3D", "leave `places` out: rows x,z need no order")
    if file.lower().endswith(".asc"):
        raise refused("an ASCII grid has no scattered heights", "leave `places` out")
    names, table = read_csv(
        file, key, "x,y,z", "each survey point",
        lambda names: sorted(names[:-1]) == ["x", "y"] and names[-1] in NAMES,
    )  # fmt: skip
    where, height = table[:, [names.index("x"), names.index("y")]], table[:, -1]
    origin, extent = where.min(axis=0), float(np.ptp(where, axis=0).max())
    few = "has no three points that are not on one line"
    remedy = "give the points of an area, such as those of a survey around the body"
    if extent == 0.0:
        raise refused(few, remedy)
    place = (where - origin) / extent
    same: Integers = cKDTree(place).query_pairs(ROUND_OFF, output_type="ndarray")
    rise = np.abs(np.diff(height[same], axis=1)).ravel()
    if (rise > ROUND_OFF * np.ptp(height)).any():
        one, other = same[int(rise.argmax())]
        raise refused(
            f"has two heights, {height[one]:.9g} and {height[other]:.9g}, at "
            f"{map_text(where[one])} (rows {one + 1} and {other + 1} below the names)",
            "keep one row for each place",
        )
    kept = np.setdiff1d(np.arange(len(place)), same.max(axis=1, initial=-1))
    place, height = place[kept], height[kept]
    spread = np.linalg.svd(place - place.mean(axis=0), compute_uv=False)
    if len(place) < 3 or spread[1] <= ROUND_OFF * spread[0]:
        raise refused(few, remedy)
    try:
        triangulation = Delaunay(place)
    except QhullError:
        raise refused(few, remedy) from None
    if len(triangulation.coplanar):
        one, _, other = kept[triangulation.coplanar[0][[0, 0, 2]]]
        raise refused(
            f"has points too close to each other for triangles: {map_text(where[one])} and "
            f"{map_text(where[other])} (rows {one + 1} and {other + 1} below the names)",
            "keep one of them",
        )
    return Survey(origin, extent, place, height, triangulation)
