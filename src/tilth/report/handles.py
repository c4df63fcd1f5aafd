# SPDX-License-Identifier: BSD-3-Clause
"""Entries of legends of figures and pages, and lines with a halo."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass
class Handle:
    """An entry of a legend: a patch of one colour, or a line with or without a marker.

    Attributes:
        label: its text.
        style: of the line, as for `plot_line`.
        patch: colour, edge and hatching of an area; empty for a line.
        sign: a character that stands for it in a page; that of a line or area if empty.
    """

    label: str
    style: dict[str, Any] = field(default_factory=dict)
    patch: dict[str, Any] = field(default_factory=dict)
    sign: str = ""

    def __post_init__(self) -> None:
        self.sign = self.sign or ("\N{BLACK SQUARE}" if self.patch else "\N{HORIZONTAL BAR}")

    @property
    def colour(self) -> str:
        """Of the area, line or marker; empty if there is none."""
        given = {**self.style, **self.patch}
        names = ("color", "facecolor", "markeredgecolor")
        return str(next((given[name] for name in names if name in given), ""))

    def matplotlib(self) -> Any:
        """Returns the handle of matplotlib."""
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        if self.patch:
            return Patch(label=self.label, **self.patch)
        return Line2D([], [], label=self.label, **_of_matplotlib(self.style))


def plot_line(axes: Any, x: Any, y: Any, **style: Any) -> None:
    """Draws a line or markers; style as in matplotlib, and `halo`.

    halo: width of a white line below [point].
    """
    axes.plot(x, y, **_of_matplotlib(style))


def _of_matplotlib(style: dict[str, Any]) -> dict[str, Any]:
    own = dict(style)
    if callable(marker := own.get("marker")):
        own["marker"] = marker()
    if "halo" in own:
        from matplotlib.patheffects import withStroke

        own["path_effects"] = [withStroke(linewidth=own.pop("halo"), foreground="white")]
    return own
