# SPDX-License-Identifier: BSD-3-Clause
"""Three-dimensional view of material points: the visible sides of their domains, or markers."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.domains import corners_of_boxes, sides_towards
from tilth.report.fields import with_unit
from tilth.report.texts import AS_IT_IS
from tilth.report.visible_points import exterior_points, points_with_free_sides, uneven

MAXIMUM_DRAWN_DOMAINS = 8_000
"""Visible points up to which the sides of the domains are drawn, above it markers."""
MAXIMUM_MARKERS = 30_000
_SHADES = (0.84, 0.92, 1.0)
"""Brightness of sides normal to x, y and z."""
_AZIMUTH, _ELEVATION = -55.0, 22.0
"""Direction to the viewer [degrees]: from the front, the right and slightly above."""
_ZOOM = 0.82
"""Leaves room for the axes' labels, which are not part of the layout of the panels."""


def draw_points_3d(
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
    """Draws the visible points of a body from the front and slightly above.

    ``position`` and ``half_lengths`` have the shape (n, 3), ``colours`` (n, 4), ``corners`` of the
    domains, relative to the points, (n, 8, 3); without them domains are boxes. The sides of the
    space between the corners ``lower`` and ``upper`` are to scale, but none is shown shorter than
    ``thinnest`` times the longest. Without domains, or with too many of them to draw their sides,
    markers as large as a domain are drawn.
    """
    size = upper - lower
    shown = np.maximum(size, thinnest * float(size.max()))
    axes.patch.set_visible(False)  # otherwise it hides the labels of the neighbouring panels
    axes.set_box_aspect(shown, zoom=_ZOOM)
    axes.view_init(elev=_ELEVATION, azim=_AZIMUTH)
    for k, name in enumerate("xyz"):
        getattr(axes, f"set_{name}lim")(lower[k], upper[k])
        getattr(axes, f"set_{name}label")(with_unit(name, unit), fontsize=8, **AS_IT_IS)
        axes.locator_params(axis=name, nbins=4 if shown[k] > 0.4 * shown.max() else 2)
    axes.tick_params(labelsize=7)
    if corners is None:
        seen = exterior_points(position, half_lengths)
    else:
        seen = points_with_free_sides(position, corners)
    if half_lengths is not None and len(seen) <= MAXIMUM_DRAWN_DOMAINS:
        own = corners_of_boxes(half_lengths[seen]) if corners is None else corners[seen]
        _draw_sides(axes, position[seen], own, colours[seen])
        return
    every = -(-len(seen) // MAXIMUM_MARKERS)
    if half_lengths is None:
        extent = np.maximum(np.ptp(position, axis=0), 1e-300)
        diameter = np.full(3, float(np.cbrt(np.prod(extent) / len(position))))
    else:
        diameter = 2.0 * np.median(half_lengths, axis=0)
        if uneven(half_lengths):
            diameter = 2.0 * half_lengths[seen[::every]]
    axes.scatter(
        *position[seen[::every]].T,
        c=colours[seen[::every]],
        s=every * marker_area(diameter / size * shown, shown, _inches(axes)),
        linewidths=0.0,
        depthshade=False,
    )


def marker_area(diameter: Floats, shown: Floats, inches: float) -> Floats:
    """Returns the area [square points] of a marker as large as a domain, shape ().

    ``diameter`` are the sides of the domain, ``shown`` those of the space in a panel of width
    ``inches``, shape (3,) each; or of domains, shapes (n, 3) and (n,).
    """
    # In this view a cube is about 1.5 times as wide as its side; the whole space fits the panel.
    points_per_length = 72.0 * _ZOOM * inches / (1.5 * float(np.linalg.norm(shown)) / np.sqrt(3.0))
    return np.asarray(np.maximum(1.5 * diameter.max(axis=-1) * points_per_length, 1.0) ** 2)


def _inches(axes: Any) -> float:
    """Returns the smaller side of the panel [inch], before the layout reserves space for labels."""
    box, figure = axes.get_position(), axes.get_figure().get_size_inches()
    return float(min(box.width * figure[0], box.height * figure[1]))


def _draw_sides(axes: Any, position: Floats, corners: Floats, colours: Floats) -> None:
    """Draws the sides of each domain that face the viewer, shaded by their direction."""
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
