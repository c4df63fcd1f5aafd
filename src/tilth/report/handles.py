# SPDX-License-Identifier: BSD-3-Clause
"""Entries of legends, and lines and markers, for both kinds of axes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from tilth.report.symbols import Shape


@dataclass
class Handle:
    """An entry of a legend: a patch of one colour, or a line with or without a marker.

    Attributes:
        label: its text.
        style: of the line, as for `plot_line`.
        patch: colour, edge and hatching of an area; empty for a line.
    """

    label: str
    style: dict[str, Any] = field(default_factory=dict)
    patch: dict[str, Any] = field(default_factory=dict)

    def matplotlib(self) -> Any:
        """Returns the handle of matplotlib."""
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        if self.patch:
            return Patch(label=self.label, **self.patch)
        return Line2D([], [], label=self.label, **_of_matplotlib(self.style))


def plot_line(axes: Any, x: Any, y: Any, **style: Any) -> None:
    """Draws a line or markers; style as in matplotlib, with a `Shape` as `marker`, and `halo`.

    halo: width of a white line below [point].
    """
    from tilth.report.svg_axes import SvgAxes

    own = style if isinstance(axes, SvgAxes) else _of_matplotlib(style)
    axes.plot(x, y, **own)


def collections_for(axes: Any) -> Any:
    """Returns the module with the collections that the axes take."""
    from tilth.report.svg_axes import SvgAxes

    if isinstance(axes, SvgAxes):
        from tilth.report import svg_parts

        return svg_parts
    from matplotlib import collections

    return collections


def _of_matplotlib(style: dict[str, Any]) -> dict[str, Any]:
    own = dict(style)
    if isinstance(marker := own.get("marker"), Shape):
        own["marker"] = marker.path()
    if "halo" in own:
        from matplotlib.patheffects import withStroke

        own["path_effects"] = [withStroke(linewidth=own.pop("halo"), foreground="white")]
    return own
