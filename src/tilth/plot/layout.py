# SPDX-License-Identifier: BSD-3-Clause
"""Sizes of a picture: to scale with the body, the colour bar beside it or below a long one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.texts import LEGEND_WIDTH, on_lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LONG = 0.42
"""Height over width below which the colour bar is below."""
_WIDTH, _MOST_WIDTH, _MOST_HEIGHT = 7.0, 9.0, 5.0
"""Width of a long body, and at most; height of any other, at most [inch]."""
_LEAST = 0.3
"""Shorter side of the axes, at least [inch]; a longer body is stretched, with a note."""
_READABLE = 0.8
"""Height of a long body up to which it is drawn wider [inch]."""
_SPACE = (6.0, 6.0)
"""Size of axes in space [inch], of which only what is drawn is kept."""
_BAR, _GAP = 0.14, 0.14
"""Thickness of the colour bar and its distance [inch]."""
_STRIP, _STRIP_WIDTH = 1.1, 3.6
"""Height of the axes with a curve, and their least width [inch]."""
_LEFT, _BOTTOM, _LINE = 1.2, 4.0, 0.16
_SHEET = 12.0
"""Side of the figure before it is cut [inch]."""
_PAD = 0.06
"""Margin around all that is drawn [inch]."""


@dataclass(frozen=True)
class Layout:
    """Sizes and places of the parts of a picture [inch]."""

    size: tuple[float, float]
    """Width and height of the axes of the field."""
    bar_below: bool
    note: str
    """What is not to scale, "" if nothing."""

    @classmethod
    def of(cls, extent: Floats) -> Layout:
        """Returns the layout for a body with these lengths of its sides, shape (2,) or (3,)."""
        if len(extent) == 3:
            return cls(_SPACE, False, "")
        ratio = float(extent[1] / extent[0])
        if ratio < _LONG:
            width = min(_MOST_WIDTH, max(_WIDTH, _READABLE / ratio))
            height = max(width * ratio, _LEAST)
        else:
            height = min(_MOST_HEIGHT, 5.4 * ratio)
            width = max(height / ratio, _LEAST)
        stretch = height / (width * ratio)
        note = ""
        if stretch > 1.001:
            note = f"vertical scale stretched {stretch:.3g} times"
        elif stretch < 0.999:
            note = f"horizontal scale stretched {1.0 / stretch:.3g} times"
        return cls((width, height), ratio < _LONG, note)

    def boxes(self, note: str, strip: bool) -> dict[str, tuple[float, float, float, float]]:
        """Returns the places of ``field``, ``bar`` and ``strip`` on a sheet, as its shares."""
        width, height = self.size
        below = 0.46 + (_LINE if note else 0.0)
        found = {"field": (_LEFT, _BOTTOM, width, height)}
        if self.bar_below:
            length = min(0.6 * width, 4.5)
            place = (_LEFT + 0.5 * (width - length), _BOTTOM - below - _BAR, length, _BAR)
            below += _BAR + 0.48
        else:
            place = (_LEFT + width + _GAP, _BOTTOM, _BAR, height)
        found["bar"] = place
        if strip:
            length = max(width, _STRIP_WIDTH)
            found["strip"] = (_LEFT, _BOTTOM - below - _STRIP - 0.12, length, _STRIP)
        return {name: tuple(x / _SHEET for x in box) for name, box in found.items()}  # type: ignore[misc]

    @property
    def ticks(self) -> tuple[int, int]:
        """Numbers of intervals along the axes, at most."""
        width, height = self.size
        return int(np.clip(width / 0.6, 2, 10)), int(np.clip(height / 0.35, 2, 9))

    @property
    def label_width(self) -> int:
        """Characters of a line beside the colour bar, at most."""
        return int(max(24.0, (60.0 if self.bar_below else 13.0 * self.size[1])))

    @property
    def title_width(self) -> int:
        """Characters of a line of the title, at most."""
        return int(max(26.0, 13.0 * self.size[0]))

    def columns(self, labels: Sequence[str]) -> int:
        """Returns the number of columns of a legend with these labels."""
        longest = max(len(line) for text in labels for line in _lines(text))
        room = max(self.size[0], 3.0) + (0.0 if self.bar_below else 0.6)
        return int(np.clip(room / (0.6 + 0.072 * longest), 1, len(labels)))


def _lines(text: str) -> list[str]:
    return on_lines(text, LEGEND_WIDTH).split("\n")


def span_in_space(axes: Any) -> tuple[float, float]:
    """Returns the lower and the upper end of what axes in space show, over their height."""
    _drawn(axes.figure)
    box = _box_in_space(axes, axes.figure.canvas.get_renderer())
    low, high = axes.transAxes.inverted().transform(box.get_points())[:, 1]
    return float(low), float(high)


def fit(figure: Figure) -> None:
    """Cuts a figure to what is drawn in it; all that is drawn keeps its size."""
    from matplotlib.transforms import Bbox

    _drawn(figure)
    canvas: Any = figure.canvas
    renderer = canvas.get_renderer()
    boxes = [legend.get_window_extent(renderer) for legend in figure.legends]
    for axes in figure.axes:
        if axes.name == "3d":
            boxes += [_box_in_space(axes, renderer), axes.title.get_window_extent(renderer)]
        elif (around := axes.get_tightbbox(renderer)) is not None:
            boxes.append(around)
    box = Bbox(Bbox.union(boxes).get_points() / figure.dpi)  # inches
    size = figure.get_size_inches()
    places = [np.array(axes.get_position(original=True).bounds) for axes in figure.axes]
    width, height = box.width + 2.0 * _PAD, box.height + 2.0 * _PAD
    figure.set_size_inches(width, height)
    for axes, place in zip(figure.axes, places, strict=True):
        x, y = place[:2] * size - [box.x0 - _PAD, box.y0 - _PAD]
        across, up = place[2:] * size
        axes.set_position((x / width, y / height, across / width, up / height))


def _drawn(figure: Any) -> None:
    """Draws a figure, so that what is in it has its place."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]


def _box_in_space(axes: Any, renderer: Any) -> Any:
    """Returns the box around the sides of the space that axes show, and their labels [pixel]."""
    from matplotlib.transforms import Bbox
    from mpl_toolkits.mplot3d.proj3d import proj_transform  # type: ignore[import-untyped]

    limits = (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())
    corner = np.stack(np.meshgrid(*limits), axis=-1).reshape(-1, 3)
    x, y, _ = proj_transform(*corner.T, axes.get_proj())
    place = axes.transData.transform(np.column_stack([x, y]))
    labels = [axis.get_tightbbox(renderer) for axis in (axes.xaxis, axes.yaxis, axes.zaxis)]
    own = Bbox([place.min(axis=0), place.max(axis=0)])
    return Bbox.union([own, *(each for each in labels if each is not None)])
