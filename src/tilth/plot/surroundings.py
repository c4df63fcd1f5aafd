# SPDX-License-Identifier: BSD-3-Clause
"""Boundaries and rigid bodies in pictures: their lines, and their entries in the legend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tilth.arrays import Floats
from tilth.report.handles import Handle
from tilth.report.rigid_bodies import EDGE, FILL

_MOST_NAMES = 4
"""Names in an entry of the legend, at most; of more only what they are."""
BOUNDARY, BOUNDARY_WIDTH = "0.4", 2.4
"""Of the lines of boundaries, unlike those of tracked surfaces; the width [point]."""
_LINE = {"color": BOUNDARY, "linewidth": BOUNDARY_WIDTH}


def draw_segments(
    axes: Any, segment: Floats, colour: str = BOUNDARY, width: float = BOUNDARY_WIDTH
) -> None:
    """Draws lines in the plane, segments (k, 2, 2); the width [point]."""
    from matplotlib.collections import LineCollection

    lines = LineCollection(
        list(segment),
        colors=colour,
        linewidths=width,
        capstyle="round",
        zorder=2.4,
    )
    axes.add_collection(lines, autolim=False)


def boundary_handle(names: Sequence[str]) -> list[Handle]:
    """Returns the legend's entry of boundaries, none if there are no names."""
    return [Handle(_label("boundary", "boundaries", names), dict(_LINE))] if names else []


def rigid_handle(names: Sequence[str]) -> list[Handle]:
    """Returns the legend's entry of rigid bodies, none if there are no names."""
    patch = {"facecolor": FILL, "edgecolor": EDGE, "linewidth": 1.2}
    label = _label("rigid body", "rigid bodies", names)
    return [Handle(label, patch=patch)] if names else []


def _label(one: str, several: str, names: Sequence[str]) -> str:
    names = list(dict.fromkeys(names))
    if len(names) > _MOST_NAMES:
        return several
    return f"{one if len(names) == 1 else several}: {', '.join(names)}"
