# SPDX-License-Identifier: BSD-3-Clause
"""A picture in a page: panels in a grid with titles, legend and colour bar, as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.colour_scale import ColourScale
from tilth.report.handles import Handle
from tilth.report.raster import png
from tilth.report.svg_axes import LABELS, LINE_HEIGHT, TICK, TITLES, SvgAxes, marker_path
from tilth.report.svg_parts import INCH, POINT, css, dashes_of, image_of, text_at, text_width
from tilth.report.texts import LABEL_WIDTH, LEGEND_WIDTH, on_lines
from tilth.report.ticks import linear_labels, linear_ticks

_PAD = 6.0
"""Room around the picture [pixel]."""
_ENTRY = 8.5
"""Size of the font of legends [point]."""
_HANDLE = 24.0
"""Width of what an entry of a legend shows [pixel]."""
_BAR = 16.0
"""Width of a colour bar [pixel]."""


class SvgFigure:
    """Panels and what is around them; the arguments are those of matplotlib's figure.

    The height follows from the panels where all have equal scales.
    """

    def __init__(self, figsize: tuple[float, float], **unused: Any) -> None:
        self.size = figsize
        self.axes: list[SvgAxes] = []
        self._ratios: tuple[Floats, Floats] = np.ones(1), np.ones(1)
        self._title: tuple[str, float] = "", 0.0
        self._notes: tuple[str, float] = "", 0.0
        self._bar: tuple[ColourScale, str] | None = None
        self._legend: list[Handle] = []
        self._legend_columns = 0

    def get_size_inches(self) -> tuple[float, float]:
        return self.size

    def set_size_inches(self, width: float, height: float) -> None:
        self.size = width, height

    def add_gridspec(
        self, rows: int, columns: int, *, width_ratios: Sequence[float] = (),
        height_ratios: Sequence[float] = (),
    ) -> SvgGrid:  # fmt: skip
        widths, heights = (
            np.array(width_ratios or [1.0] * columns),
            np.array(height_ratios or [1.0] * rows),
        )
        self._ratios = widths, heights
        return SvgGrid(rows, columns)

    def add_subplot(self, *place: Any, **unused: Any) -> SvgAxes:
        """Adds a panel: at rows, columns and number from 1, or at a place of a grid."""
        if len(place) == 1:
            rows, columns = place[0]
        else:
            count = place or (1, 1, 1)
            self.add_gridspec(count[0], count[1])
            row, column = divmod(count[2] - 1, count[1])
            rows, columns = range(row, row + 1), range(column, column + 1)
        self.axes.append(SvgAxes(rows, columns, rows.stop == len(self._ratios[1])))
        return self.axes[-1]

    def suptitle(self, text: str, *, fontsize: float, **unused: Any) -> None:
        self._title = text, fontsize

    def supxlabel(self, text: str, *, fontsize: float, **unused: Any) -> None:
        self._notes = text, fontsize

    def add_colour_bar(self, scale: ColourScale, label: str) -> None:
        """Adds a colour bar on the right."""
        self._bar = scale, on_lines(label, LABEL_WIDTH)

    def add_legend(self, handles: Sequence[Handle], columns: int = 0) -> None:
        """Adds a legend: above the panels in so many columns, or with 0 on the right."""
        self._legend, self._legend_columns = list(handles), columns

    def svg(self) -> str:
        """Returns the picture."""
        legend, wide, high = self._drawn_legend()
        above = bool(self._legend_columns)
        top = (
            _PAD + LINE_HEIGHT * self._title[1] * _lines(self._title[0]) + (high if above else 0.0)
        )
        beside = (0.0 if above else wide) + self._bar_width()
        left, widths, y, heights = self._grid(INCH * self.size[0] - beside - 2.0 * _PAD, top)
        bottom = y[-1] + LINE_HEIGHT * self._notes[1] * _lines(self._notes[0]) + _PAD
        width = INCH * self.size[0]
        height = max(bottom, top + (0.0 if above else high) + _PAD)
        parts = [self._panel(axes, left, widths, y, heights) for axes in self.axes]
        if self._bar is not None:
            low, end = float(y[0]), float(y[len(heights) - 1] + heights[-1])
            parts.append(self._drawn_bar(width - _PAD - self._bar_width() + 14.0, low, end - low))
        middle = 0.5 * (width - (0.0 if above else wide))
        at = (middle - 0.5 * wide, top - high) if above else (width - _PAD - wide, top)
        parts.append(f'<g transform="translate({at[0]:.1f} {at[1]:.1f})">{legend}</g>')
        line = _PAD + 0.8 * POINT * self._title[1]
        parts.append(text_at(0.02 * width, line, *self._title, "start"))
        parts.append(
            text_at(middle, y[-1] + POINT * self._notes[1], *self._notes, "middle", "0.35")
        )
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
            f'viewBox="0 0 {width:.0f} {height:.0f}" '
            'font-family="DejaVu Sans, Verdana, sans-serif"><rect width="100%" height="100%" '
            f'fill="white"/>{"".join(parts)}</svg>'
        )

    def _grid(self, width: float, top: float) -> tuple[Floats, Floats, Floats, Floats]:
        """Returns left sides and widths of the columns, upper sides and heights of the rows.

        The upper sides have one more: where the last row ends, with its labels.
        """
        columns, rows = len(self._ratios[0]), len(self._ratios[1])
        wanted = INCH * self.size[1] - top - _PAD
        margin = np.zeros((4, max(columns, rows)))
        for axes in self.axes:
            share = len(axes.columns) / columns, len(axes.rows) / rows
            axes.settle(share[0] * width - 60.0, share[1] * wanted - 45.0)
            for side, place in enumerate(
                (axes.columns[0], axes.columns[-1], axes.rows[0], axes.rows[-1])
            ):
                margin[side, place] = max(margin[side, place], axes.margins()[side])
        before, after = margin[0, :columns], margin[1, :columns]
        above, below = margin[2, :rows] + 2.0, margin[3, :rows] + 2.0
        room = max(width - before.sum() - after.sum(), 40.0 * columns)
        widths = room * self._ratios[0] / self._ratios[0].sum()
        left = _PAD + np.cumsum(before + np.append(0.0, (widths + after)[:-1]))
        room = max(wanted - above.sum() - below.sum(), 40.0 * rows)
        heights = room * self._ratios[1] / self._ratios[1].sum()
        for row in range(rows):
            own = [axes for axes in self.axes if axes.rows == range(row, row + 1)]
            if own and all(axes.aspect is not None for axes in own):
                needed = max(_span(left, widths, a.columns)[1] * _ratio(a) for a in own)
                heights[row] = min(heights[row], needed)
        y = top + np.cumsum(above + np.append(0.0, (heights + below)[:-1]))
        return left, widths, np.append(y, y[-1] + heights[-1] + below[-1]), heights

    def _panel(
        self, axes: SvgAxes, left: Floats, widths: Floats, top: Floats, heights: Floats
    ) -> str:
        x, width = _span(left, widths, axes.columns)
        y, height = _span(top, heights, axes.rows)
        if axes.aspect is not None:
            across = min(width, height / _ratio(axes))
            x, y = x + 0.5 * (width - across), y + 0.5 * (height - across * _ratio(axes))
            width, height = across, across * _ratio(axes)
        return axes.render(x, y, width, height)

    def _bar_width(self) -> float:
        if self._bar is None:
            return 0.0
        scale, label = self._bar
        texts = linear_labels(linear_ticks(scale.low, scale.high, 8))[0]
        longest = max((text_width(text, LABELS) for text in texts), default=0.0)
        return 18.0 + _BAR + TICK + longest + LINE_HEIGHT * TITLES * _lines(label) + 6.0

    def _drawn_bar(self, x: float, y: float, height: float) -> str:
        assert self._bar is not None
        scale, label = self._bar
        y, height = y + 0.05 * height, 0.9 * height
        values = np.linspace(scale.high, scale.low, 256)
        pixels = np.full((256, 1, 4), 255, dtype=np.uint8)
        pixels[:, 0, :3] = np.rint(255.0 * scale.colours(values))
        ticks = linear_ticks(scale.low, scale.high, int(np.clip(height / 28.0, 1, 8)))
        texts, factor = linear_labels(ticks)
        found = [
            image_of(png(pixels), x, y, _BAR, height),
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{_BAR}" height="{height:.1f}" fill="none" '
            f'stroke="black" stroke-width="{0.8 * POINT:.2f}"/>',
            text_at(x, y - 5.0, factor, LABELS, "start"),
        ]
        side = x + _BAR
        for tick, text in zip(ticks.tolist(), texts, strict=True):
            place = y + height * (scale.high - tick) / (scale.high - scale.low)
            found.append(f'<path d="M{side:.1f} {place:.1f}h{TICK:.1f}" stroke="black"/>')
            line = place + 0.36 * POINT * LABELS
            found.append(text_at(side + TICK + 3.0, line, text, LABELS, "start"))
        longest = max((text_width(text, LABELS) for text in texts), default=0.0)
        line = side + TICK + 5.0 + longest + POINT * TITLES
        found.append(text_at(line, y + 0.5 * height, label, TITLES, turned=True))
        return "".join(found)

    def _drawn_legend(self) -> tuple[str, float, float]:
        """Returns the legend at the origin, its width and height [pixel]."""
        texts = [on_lines(handle.label, LEGEND_WIDTH) for handle in self._legend]
        if not texts:
            return "", 0.0, 0.0
        wide = _HANDLE + 8.0 + max(text_width(text, _ENTRY) for text in texts) + 8.0
        columns = self._legend_columns or 1
        found, y = [], 0.0
        for first in range(0, len(texts), columns):
            row = range(first, min(first + columns, len(texts)))
            high = max(_lines(texts[number]) for number in row) * LINE_HEIGHT * _ENTRY
            for column, number in enumerate(row):
                middle = y + 0.5 * _lines(texts[number]) * LINE_HEIGHT * _ENTRY
                x = column * wide
                found.append(_entry(self._legend[number], x, middle))
                line = y + 0.85 * POINT * _ENTRY
                found.append(text_at(x + _HANDLE + 8.0, line, texts[number], _ENTRY, "start"))
            y += high + 0.9 * POINT * _ENTRY
        return "".join(found), wide * min(columns, len(texts)), y


class SvgGrid:
    """Places of a grid of panels by row and column, numbers or slices."""

    def __init__(self, rows: int, columns: int) -> None:
        self._count = rows, columns

    def __getitem__(self, key: tuple[int | slice, int | slice]) -> tuple[range, range]:
        rows, columns = (
            range(*each.indices(count)) if isinstance(each, slice) else range(each, each + 1)
            for each, count in zip(key, self._count, strict=True)
        )
        return rows, columns


def _entry(handle: Handle, x: float, y: float) -> str:
    """Returns what stands for an entry, from x on around y [pixel]."""
    style, found = handle.style, ""
    if handle.patch:
        colour, opacity = css(handle.patch["color"]), handle.patch.get("alpha", 1.0)
        return (
            f'<rect x="{x:.1f}" y="{y - 6.0:.1f}" width="{_HANDLE}" height="12" fill="{colour}" '
            f'opacity="{opacity}"/>'
        )
    if style.get("linestyle", "-") != "none" and "color" in style:
        width = style.get("linewidth", 1.5)
        dashes = dashes_of(style.get("linestyle", "-"), POINT * width)
        found += (
            f'<path d="M{x:.1f} {y:.1f}h{_HANDLE}" stroke="{css(style["color"])}" '
            f'stroke-width="{POINT * width:.2f}"{dashes}/>'
        )
    if (marker := style.get("marker")) is not None:
        edge = css(style.get("markeredgecolor", style.get("color", "k")))
        face = css(style.get("markerfacecolor", edge))
        data = marker_path(marker, POINT * style["markersize"])
        found += (
            f'<path d="{data}" transform="translate({x + 0.5 * _HANDLE:.1f} {y:.1f})" '
            f'fill="{face}" stroke="{edge}" '
            f'stroke-width="{POINT * style.get("markeredgewidth", 1.0):.2f}"/>'
        )
    return found


def _lines(text: str) -> int:
    return len(text.split("\n")) if text else 0


def _ratio(axes: SvgAxes) -> float:
    """Returns height over width of a panel with given scales."""
    (x0, x1), (y0, y1) = axes.x.limits, axes.y.limits
    assert axes.aspect is not None
    return axes.aspect * (y1 - y0) / (x1 - x0)


def _span(first: Floats, sizes: Floats, places: range) -> tuple[float, float]:
    """Returns beginning and length of several columns or rows with what is between them."""
    begin, last = float(first[places[0]]), places[-1]
    return begin, float(first[last] + sizes[last]) - begin
