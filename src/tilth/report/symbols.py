# SPDX-License-Identifier: BSD-3-Clause
"""Symbols of structural mechanics as markers of matplotlib, with their tip at the node.

What makes them is returned, so that a legend of a page needs no matplotlib.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.path import Path


def _marker(parts: Sequence[Any]) -> Callable[[], Path]:
    """Returns what makes the marker of open and closed polygons around the origin, y upwards.

    Those that are closed end where they begin.
    """

    def make() -> Path:
        from matplotlib.path import Path

        arrays = [np.asarray(part, dtype=float) for part in parts]
        return Path.make_compound_path(*(Path(part, closed=_is_closed(part)) for part in arrays))

    return make


def _is_closed(part: Floats) -> bool:
    return len(part) > 2 and bool((part[0] == part[-1]).all())


_FRAME = [[0.0, 1.0], [0.0, 1.0]]
"""A line without length at the distance that fixes the scale."""


def support(kind: str, axis: int, sign: int) -> Callable[[], Path]:
    """Returns the marker of a ``roller`` or ``fixed`` support on the given side of its node.

    ``axis`` 0 is to the right and 1 upwards in the figure, ``sign`` -1 is the opposite direction.
    A roller is a circle between the node and the ground line, a fixed support a triangle.
    """
    if kind == "roller":
        turn = np.append(np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False), 0.0)
        body = 0.30 * np.stack([np.cos(turn), np.sin(turn)], axis=1) + [0.0, -0.30]
    else:
        body = np.array([[0.0, 0.0], [-0.42, -0.60], [0.42, -0.60], [0.0, 0.0]])
    hatches = [[[x, -0.68], [x - 0.18, -0.92]] for x in (-0.30, 0.0, 0.30, 0.5)]
    parts = [body, [[-0.5, -0.68], [0.5, -0.68]], *hatches, _FRAME]
    return _marker([_rotated(np.asarray(part), axis, sign) for part in parts])


def arrow(direction: tuple[float, float]) -> Callable[[], Path]:
    """Returns a centred arrow in ``direction``, not of zero length, as marker of a legend."""
    shape = np.array(
        [[-1, 0.12], [0.25, 0.12], [0.25, 0.42], [1, 0], [0.25, -0.42], [0.25, -0.12], [-1, -0.12]]
    )
    length = float(np.hypot(*direction))
    c, s = direction[0] / length, direction[1] / length
    rotated = shape @ np.array([[c, s], [-s, c]])
    return _marker([np.vstack([rotated, rotated[:1]])])


def hatching() -> Callable[[], Path]:
    """Returns the marker of a rigid boundary in legends: hatching below a line."""
    strokes = [[[x, 0.0], [x - 0.25, -0.45]] for x in (-0.25, 0.05, 0.35, 0.65)]
    return _marker([*strokes, _FRAME])


def arrows(axes: Any, position: Floats, vectors: Floats, colour: str, pivot: str) -> None:
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
