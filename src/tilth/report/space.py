# SPDX-License-Identifier: BSD-3-Clause
"""Points of a three-dimensional body in space: the sides of their domains that face the viewer."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.domains import corners_of_boxes, sides_towards
from tilth.report.fields import with_unit
from tilth.report.outer import free_sides, outer_points

MOST_SOLIDS = 8_000
"""Outer points up to which the sides of the domains are drawn, beyond it markers."""
MOST_MARKERS = 30_000
_SHADES = (0.84, 0.92, 1.0)
"""Brightness of sides normal to x, y and z."""
_AZIMUTH, _ELEVATION = -55.0, 22.0
"""Direction to the viewer [degrees]: from in front, the right and a little above."""
_ZOOM = 0.82
"""Leaves room for the axes' labels, which are not part of the layout of the panels."""


def draw_space(
    axes: Any,
    position: Floats,
    half_lengths: Floats | None,
    colours: Floats,
    lower: Floats,
    upper: Floats,
    unit: str,
    thinnest: float,
    corners: Floats | None = None,
) -> None:
    """Draw what is seen of a body from outside, from the front and a little above.

    ``position`` and ``half_lengths`` have the shape (n, 3), ``colours`` (n, 4), ``corners`` of the
    domains, seen from the points, (n, 8, 3); without them domains are boxes. The sides of the
    space between the corners ``lower`` and ``upper`` are to scale, but none is shown shorter than
    ``thinnest`` times the longest. Without domains, or with too many of them to draw their sides,
    markers as large as a domain are drawn.
    """
    size = upper - lower
    shown = np.maximum(size, thinnest * float(size.max()))
    axes.patch.set_visible(False)  # it would cover the labels of the neighbouring panels
    axes.set_box_aspect(shown, zoom=_ZOOM)
    axes.view_init(elev=_ELEVATION, azim=_AZIMUTH)
    for k, name in enumerate("xyz"):
        getattr(axes, f"set_{name}lim")(lower[k], upper[k])
        getattr(axes, f"set_{name}label")(with_unit(name, unit), fontsize=8)
        axes.locator_params(axis=name, nbins=4 if shown[k] > 0.4 * shown.max() else 2)
    axes.tick_params(labelsize=7)
    if corners is None:
        seen = outer_points(position, half_lengths)
    else:
        seen = free_sides(position, corners)
    if half_lengths is not None and len(seen) <= MOST_SOLIDS:
        own = corners_of_boxes(half_lengths[seen]) if corners is None else corners[seen]
        _draw_sides(axes, position[seen], own, colours[seen])
        return
    every = -(-len(seen) // MOST_MARKERS)
    if half_lengths is None:
        extent = np.maximum(np.ptp(position, axis=0), 1e-300)
        diameter = np.full(3, float(np.cbrt(np.prod(extent) / len(position))))
    else:
        diameter = 2.0 * np.median(half_lengths, axis=0)
    axes.scatter(
        *position[seen[::every]].T,
        c=colours[seen[::every]],
        s=every * marker_area(diameter / size * shown, shown, _inches(axes)),
        linewidths=0.0,
        depthshade=False,
    )


def marker_area(diameter: Floats, shown: Floats, inches: float) -> float:
    """Area in square points of a marker that covers a domain with sides ``diameter``, shape (3,).

    ``shown`` are the sides of the space, shape (3,), that a panel ``inches`` wide shows.
    """
    # Seen askew, a cube is about 1.5 times as wide as its side; the whole space fits the panel.
    points_per_length = 72.0 * _ZOOM * inches / (1.5 * float(np.linalg.norm(shown)) / np.sqrt(3.0))
    return float(max(1.5 * diameter.max() * points_per_length, 1.0) ** 2)


def _inches(axes: Any) -> float:
    """The smaller side of the panel, before the layout makes room for labels."""
    box, figure = axes.get_position(), axes.get_figure().get_size_inches()
    return float(min(box.width * figure[0], box.height * figure[1]))


def _draw_sides(axes: Any, position: Floats, corners: Floats, colours: Floats) -> None:
    """The sides of each domain that face the viewer, shaded by their direction."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

    azimuth, elevation = np.deg2rad([_AZIMUTH, _ELEVATION])
    across = np.cos(elevation)
    viewer = np.array([across * np.cos(azimuth), across * np.sin(azimuth), np.sin(elevation)])
    sides, normals, number = sides_towards(position, corners, viewer)
    faces = np.array(colours[number])
    faces[:, :3] *= (normals**2 @ np.array(_SHADES))[:, None]
    few = len(faces) < 6000
    axes.add_collection3d(
        Poly3DCollection(
            sides,
            facecolors=faces,
            edgecolors=faces * np.array([0.8, 0.8, 0.8, 1.0]) if few else faces,
            linewidths=0.3,
        )
    )
