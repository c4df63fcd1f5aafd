# SPDX-License-Identifier: BSD-3-Clause
"""A plane through a run in space, and where it cuts domains of points and triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.errors import BadInput
from tilth.report.fields import AXES

_UPWARD = np.array([0.0, 0.0, 1.0])
_EDGES = np.array([(a, a | 1 << axis) for axis in range(3) for a in range(8) if not a >> axis & 1])
"""Corners at the ends of a domain's edges, x fastest, shape (12, 2)."""
_SAME = 1e-10
"""Distance from the plane that counts as none, over the body's size."""
_INSIDE, _OUTSIDE = 0.25, 0.1
"""Distance of a plane from the end of a body, over a domain's length, up to which the outermost
domains are cut within; so the soil at a plane of symmetry is there, also where domains moved."""


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane with axes of its own; vectors have the shape (3,), lengths are [length]."""

    origin: Floats
    """Where both coordinates are zero."""
    normal: Floats
    """Unit vector."""
    axes: Floats
    """Unit vectors of the two coordinates, shape (2, 3)."""
    names: tuple[str, str]
    """Of the coordinates."""
    text: str
    """What the user wrote."""

    @classmethod
    def of(cls, text: str) -> Plane:
        """Returns the plane of a text: ``x=1.0``, or a point and a normal, ``0,0,1:1,1,0``.

        Raises ``BadInput`` for any other.
        """
        name, sign, number = text.partition("=")
        try:
            if sign:
                axis = AXES.index(name.strip())
                normal = np.eye(3)[axis]
                others = [k for k in range(3) if k != axis]
                origin = float(number) * normal
                if not np.isfinite(origin).all():
                    raise ValueError
                names = (AXES[others[0]], AXES[others[1]])
                return cls(origin, normal, np.eye(3)[others], names, text)
            point, normal = (
                np.array([float(part) for part in half.split(",")])
                for half in text.split(":", maxsplit=1)
            )
            length = float(np.linalg.norm(normal))
            if point.shape != (3,) or normal.shape != (3,) or not 0.0 < length < np.inf:
                raise ValueError
            if not np.isfinite(point).all():
                raise ValueError
        except ValueError:
            raise BadInput(
                "is not a plane",
                "write x=1.0, y=1.0 or z=1.0, or a point and a normal, X,Y,Z:NX,NY,NZ",
                key="section",
                value=text,
            ) from None
        normal = normal / length
        across = np.cross(_UPWARD, normal)
        level = float(np.linalg.norm(across)) < 1e-9  # a horizontal plane
        across = np.array([1.0, 0.0, 0.0]) if level else across / np.linalg.norm(across)
        up = np.cross(normal, across)
        along = [
            f"distance along ({', '.join(f'{x:.3g}' for x in np.round(axis, 12) + 0.0)})"
            for axis in (across, up)
        ]
        return cls(point, normal, np.stack([across, up]), (along[0], along[1]), text)

    def height(self, position: Floats) -> Floats:
        """Returns the distances of positions (..., 3) above the plane, shape (...)."""
        return np.asarray((position - self.origin) @ self.normal)

    def flat(self, position: Floats) -> Floats:
        """Returns the coordinates in the plane, shape (..., 2), of positions (..., 3)."""
        return np.asarray((position - self.origin) @ self.axes.T)

    def space(self, flat: Floats) -> Floats:
        """Returns the positions (..., 3) of coordinates in the plane, shape (..., 2)."""
        return np.asarray(self.origin + flat @ self.axes)


def cut_domains(plane: Plane, position: Floats, corners: Floats) -> tuple[Floats, Integers]:
    """Returns where a plane cuts the domains of one body's points.

    Those of parallelepipeds are exact. A plane at the body's end cuts its outermost domains.

    Args:
        plane: the plane.
        position: of the points [length], shape (n, 3).
        corners: of their domains, relative to them, x fastest [length], shape (n, 8, 3).

    Returns:
        The corners of m polygons in the plane, in order, the first one repeated up to the same
        number k, shape (m, k, 2); and the points of these domains, shape (m,).
    """
    place = position[:, None, :] + corners
    height = plane.height(place)
    height = height - _level(height)
    height = np.where(np.abs(height) <= _SAME * np.ptp(height), 0.0, height)  # of common faces
    above = height >= 0.0
    own = np.flatnonzero(above.any(axis=1) & ~above.all(axis=1))
    if len(own) == 0:
        return np.zeros((0, 3, 2)), own
    height, above, place = height[own][:, _EDGES], above[own][:, _EDGES], plane.flat(place[own])
    crossed = above[..., 0] != above[..., 1]
    first, second = place[:, _EDGES[:, 0]], place[:, _EDGES[:, 1]]
    share = height[..., 0] / np.where(crossed, height[..., 0] - height[..., 1], 1.0)
    point = first + share[..., None] * (second - first)
    count = crossed.sum(axis=1)
    weight = crossed[..., None] / count[:, None, None]
    away = point - (point * weight).sum(axis=1, keepdims=True)
    angle = np.where(crossed, np.arctan2(away[..., 1], away[..., 0]), np.inf)
    order = np.argsort(angle, axis=1)[:, : count.max()]
    order = np.where(np.arange(order.shape[1]) < count[:, None], order, order[:, :1])
    return np.take_along_axis(point, order[..., None], axis=1), own


def _level(height: Floats) -> float:
    """Returns the height at which domains are cut, of their corners' heights, shape (n, 8)."""
    low, high = float(height.min()), float(height.max())
    size = float(np.median(np.ptp(height, axis=1)))
    if -_INSIDE * size <= low <= _OUTSIDE * size:
        return low + _INSIDE * size
    if -_OUTSIDE * size <= high <= _INSIDE * size:
        return high - _INSIDE * size
    return 0.0


def cut_triangles(plane: Plane, corner: Floats) -> Floats:
    """Returns the segments (k, 2, 2) in the plane where it cuts triangles, shape (n, 3, 3)."""
    height = plane.height(corner)
    above = height >= 0.0
    cut = above.any(axis=1) & ~above.all(axis=1)
    height, above, flat = height[cut], above[cut], plane.flat(corner[cut])
    if len(flat) == 0:
        return np.zeros((0, 2, 2))
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    row = np.arange(len(flat))
    ends = []
    for step in (1, 2):
        other = (alone + step) % 3
        share = height[row, alone] / (height[row, alone] - height[row, other])
        ends.append(flat[row, alone] + share[:, None] * (flat[row, other] - flat[row, alone]))
    return np.stack(ends, axis=1)
