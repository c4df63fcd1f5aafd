# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies in figures, where they are at an output."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.output.snapshot import Snapshot, SurfaceShape

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FILL, EDGE = "0.72", "0.15"
_OPACITY = 0.45
_NEAR = 0.5
"""Distance from the soil up to which bodies belong to the picture, over its longest side."""


def rigid_vertices(snapshots: Sequence[Snapshot]) -> list[Floats]:
    """Returns the vertices of the rigid bodies that are near the soil, shapes (n, dim)."""
    found = []
    for snapshot in snapshots:
        low, high = snapshot.position.min(axis=0), snapshot.position.max(axis=0)
        margin = _NEAR * float((high - low).max())
        for shape in snapshot.rigid_bodies:
            place = shape.position
            near = ((place >= low - margin) & (place <= high + margin)).all(axis=1)
            found.append(place[near])
    return [each for each in found if len(each)]


def draw_rigid_2d(axes: Axes, bodies: Sequence[SurfaceShape]) -> None:
    """Draws the bodies in the plane: outlines, filled where the soil is outside a closed one."""
    for body in bodies:
        for line in body.polylines:
            place = body.position[line]
            if _is_filled(place):
                axes.fill(*place.T, facecolor=FILL, edgecolor="none", zorder=2.5)
            axes.plot(*place.T, color=EDGE, linewidth=1.2, zorder=2.6)


def draw_rigid_3d(axes: Any, bodies: Sequence[SurfaceShape]) -> None:
    """Draws the surfaces of the bodies in space, transparent, in front of all soil.

    matplotlib sorts whole collections, not their parts.
    """
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

    if bodies:
        axes.computed_zorder = False
    for body in bodies:
        if len(body.cells) == 0:
            continue
        corner = body.position[body.cells]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        shade = 0.55 + 0.3 * (0.5 + 0.5 * normal @ np.array([0.35, -0.5, 0.79]))
        colours = np.column_stack([shade, shade, shade, np.full(len(shade), _OPACITY)])
        axes.add_collection3d(
            Poly3DCollection(corner, facecolors=colours, edgecolors="none", zorder=2.5),
            autolim=False,
        )


def _is_filled(place: Floats) -> bool:
    """Whether a chain with the soil on its left encloses the body; on the axis it may be open."""
    size = float(np.ptp(place, axis=0).max())
    ends = place[[0, -1]]
    on_axis = bool((np.abs(ends[:, 0]) <= 1e-6 * size).all())
    if not on_axis and np.abs(ends[0] - ends[1]).max() > 1e-9 * size:
        return False
    x, y = (place - place[0]).T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) < 0.0
