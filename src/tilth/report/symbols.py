# SPDX-License-Identifier: BSD-3-Clause
"""Symbols of structural mechanics as matplotlib markers, with their tip at the node."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.path import Path


def support(kind: str, axis: int, sign: int) -> Path:
    """Returns the marker of a ``roller`` or ``fixed`` support on the given side of its node.

    ``axis`` 0 is to the right and 1 upwards in the figure, ``sign`` -1 is the opposite direction.
    A roller is a circle between the node and the ground line, a fixed support a triangle.
    """
    from matplotlib.path import Path

    if kind == "roller":
        circle = Path.unit_circle()
        body = Path(0.30 * np.asarray(circle.vertices) + [0.0, -0.30], circle.codes)
    else:
        corners = [[0.0, 0.0], [-0.42, -0.60], [0.42, -0.60], [0.0, 0.0]]
        body = Path(corners, [Path.MOVETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY])
    ground = Path([[-0.5, -0.68], [0.5, -0.68]], [Path.MOVETO, Path.LINETO])
    hatches = [
        Path([[x, -0.68], [x - 0.18, -0.92]], [Path.MOVETO, Path.LINETO])
        for x in (-0.30, 0.0, 0.30, 0.5)
    ]
    frame = Path([[0.0, 1.0], [0.0, 1.0]], [Path.MOVETO, Path.LINETO])  # fixes the scale
    path = Path.make_compound_path(body, ground, *hatches, frame)
    return Path(_rotated(np.asarray(path.vertices), axis, sign), path.codes)


def arrow(direction: tuple[float, float]) -> Path:
    """Returns a centred arrow in ``direction``, not of zero length, as marker of a legend."""
    from matplotlib.path import Path

    shape = np.array(
        [[-1, 0.12], [0.25, 0.12], [0.25, 0.42], [1, 0], [0.25, -0.42], [0.25, -0.12], [-1, -0.12]]
    )
    length = float(np.hypot(*direction))
    c, s = direction[0] / length, direction[1] / length
    rotated = shape @ np.array([[c, s], [-s, c]])
    codes = [Path.MOVETO] + [Path.LINETO] * 6 + [Path.CLOSEPOLY]
    return Path(np.vstack([rotated, rotated[:1]]), codes)


def hatching() -> Path:
    """Returns the marker of a rigid boundary in legends: hatching below a line."""
    from matplotlib.path import Path

    strokes = [
        Path([[x, 0.0], [x - 0.25, -0.45]], [Path.MOVETO, Path.LINETO])
        for x in (-0.25, 0.05, 0.35, 0.65)
    ]
    frame = Path([[0.0, 1.0], [0.0, 1.0]], [Path.MOVETO, Path.LINETO])  # fixes the scale
    return Path.make_compound_path(*strokes, frame)


def arrows(axes: Axes, position: Floats, vectors: Floats, colour: str, pivot: str) -> None:
    """Draws arrows of at most 0.45 inch with their ``pivot`` (tip, tail or middle) at positions."""
    longest = float(np.linalg.norm(vectors, axis=1).max(initial=0.0))
    if longest == 0.0:
        axes.plot(
            *position.T, "x", color=colour, markersize=4, zorder=4, clip_on=False, in_layout=False
        )
        return
    axes.quiver(
        *position.T,
        *(0.45 * vectors / longest).T,
        color=colour,
        angles="xy",
        scale=1.0,
        scale_units="inches",
        units="inches",
        width=0.022,
        headwidth=4.5,
        headlength=5.5,
        headaxislength=5.0,
        pivot=pivot,
        zorder=5,
        clip_on=False,
        in_layout=False,
    )


def _rotated(vertices: Floats, axis: int, sign: int) -> Floats:
    """Returns the vertices of a shape below the origin, rotated to the side (axis, sign)."""
    x, y = vertices[:, 0], vertices[:, 1]
    if axis == 1:
        return np.column_stack([x, -sign * y])
    return np.column_stack([-sign * y, x])
