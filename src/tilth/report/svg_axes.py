# SPDX-License-Identifier: BSD-3-Clause
"""A panel of a picture in a page, with the methods of matplotlib's axes that are used.

To load matplotlib takes as long as to compute a small model, and to draw with it, too. So functions
that draw in the plane take either kind of axes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.svg_parts import INCH, POINT, Place, css, dashes_of, path_of, text_at, text_width
from tilth.report.symbols import Shape
from tilth.report.ticks import decades, linear_labels, linear_ticks

TICK, GAP = 3.5 * POINT, 3.0 * POINT
"""Length of a tick, and from it to its label [pixel]."""
LABELS, TITLES = 8.0, 9.0
"""Sizes of the fonts of ticks, and of titles and labels of axes [point]."""
LINE_HEIGHT = 1.2 * POINT
"""Height of a line over the size of its font [pixel/point]."""
_MARGIN = 0.05
"""Room beside the data over their range, where no limits are set."""


@dataclass
class Axis:
    """Settings of the ticks in one direction."""

    label: str = ""
    limits: tuple[float, float] = (0.0, 1.0)
    most: int = 9
    whole: bool = False
    logarithmic: bool = False
    labelled: bool = True

    def ticks(self) -> tuple[Floats, list[str], str]:
        """Returns places, labels and their common factor."""
        if self.logarithmic:
            places, texts = decades(*self.limits, self.most)
            return places, texts, ""
        places = linear_ticks(*self.limits, self.most, self.whole)
        return places, *linear_labels(places)

    def fit(self, values: Floats) -> None:
        """Sets the limits around values, with a margin."""
        values = values[np.isfinite(values)]
        if self.logarithmic:
            values = np.log10(values[values > 0.0])
        low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
        margin = _MARGIN * (high - low) or _MARGIN * abs(high) or 1.0
        low, high = low - margin, high + margin
        self.limits = (10.0**low, 10.0**high) if self.logarithmic else (low, high)

    @property
    def height(self) -> float:
        """Of the label [pixel]."""
        return LINE_HEIGHT * TITLES * len(self.label.split("\n")) if self.label else 0.0

    def share(self, values: Floats) -> Floats:
        """Returns where values are between the limits, 0 to 1."""
        low, high = self.limits
        if self.logarithmic:
            low, high, values = np.log10(low), np.log10(high), np.log10(values)
        return np.asarray((values - low) / (high - low))


class SvgAxes:
    """Collects what is drawn; `render` draws it.

    Attributes:
        x, y: settings of the axes.
        aspect: length of a unit of y over that of x; None if they are independent.
        rows, columns: of the grid of panels that it takes.
    """

    transData = None  # noqa: N815 (named as that of matplotlib)

    def __init__(self, rows: range, columns: range, is_last: bool) -> None:
        self.x, self.y = Axis(), Axis()
        self.aspect: float | None = None
        self.rows, self.columns = rows, columns
        self._is_last = is_last
        self._above = 0.0
        self.title = ""
        self._grid = False
        self._face = "white"
        self._items: list[tuple[float, bool, Callable[[Place, tuple[float, float]], str]]] = []
        self._seen: list[Floats] = []
        self._given: set[str] = set()

    # --- settings, named as those of matplotlib ---------------------------------------------------

    def set_xlim(self, low: float, high: float) -> None:
        self._given.add("x")
        self.x.limits = float(low), float(high)

    def set_ylim(self, low: float, high: float) -> None:
        self._given.add("y")
        self.y.limits = float(low), float(high)

    def get_xlim(self) -> tuple[float, float]:
        return self.x.limits

    def get_ylim(self) -> tuple[float, float]:
        return self.y.limits

    def set_xlabel(self, text: str, **style: Any) -> None:
        self.x.label = text

    def set_ylabel(self, text: str, **style: Any) -> None:
        self.y.label = text

    def set_title(self, text: str, **style: Any) -> None:
        self.title = text

    def set_aspect(self, aspect: float | str) -> None:
        self.aspect = 1.0 if isinstance(aspect, str) else aspect

    def set_facecolor(self, colour: Any) -> None:
        self._face = colour

    def locator_params(self, axis: str, nbins: int) -> None:
        (self.x if axis == "x" else self.y).most = nbins

    def tick_params(self, **style: Any) -> None:
        """Ticks are always the same."""

    def label_outer(self) -> None:
        """Leaves out what the panels at the edge have."""
        self.x.labelled, self.y.labelled = self._is_last, self.columns.start == 0

    def grid(self) -> None:
        self._grid = True

    # --- drawing ----------------------------------------------------------------------------------

    def add_collection(self, collection: Any) -> None:
        self._items.append((collection.zorder, True, collection.draw))

    def plot(
        self, x: Any, y: Any, kind: str = "", *, color: Any = "k", linewidth: float = 1.5,
        linestyle: Any = "-", marker: Any = None, markersize: float = 6.0, alpha: float = 1.0,
        markerfacecolor: Any = None, markeredgecolor: Any = None, markeredgewidth: float = 1.0,
        zorder: float = 2.0, clip_on: bool = True, halo: float = 0.0, **unused: Any,
    ) -> None:  # fmt: skip
        """Draws a line, a marker at each place, or both; `halo`: width of a white line below."""
        points = np.stack([np.asarray(x, dtype=float), np.asarray(y, dtype=float)], axis=1)
        self._seen.append(points)
        if kind.strip("-"):
            marker, linestyle = kind.strip("-"), linestyle if "-" in kind else "none"
        if linestyle != "none":
            dashes = dashes_of(linestyle, POINT * linewidth)
            for width, colour, pattern in ((halo, "white", ""), (linewidth, color, dashes)):
                if width > 0.0:
                    draw = partial(_line, points, colour, POINT * width, pattern, alpha)
                    self._items.append((zorder, clip_on, draw))
        if marker is not None:
            edge = color if markeredgecolor is None else markeredgecolor
            face = color if markerfacecolor is None else markerfacecolor
            style = POINT * markersize, css(face), css(edge), POINT * markeredgewidth
            self._items.append((zorder, clip_on, partial(_markers, points, marker, *style)))

    def semilogy(self, x: Any, y: Any, kind: str, **style: Any) -> None:
        self.y.logarithmic = True
        self.plot(x, y, kind, **style)

    def vlines(self, x: Floats, low: float, high: Floats, color: Any, linewidth: float) -> None:
        ends = np.stack([x, np.full(len(x), low), x, high, x, np.full(len(x), np.nan)], axis=1)
        self.plot(*ends.reshape(-1, 2).T, color=color, linewidth=linewidth)

    def axvline(
        self, x: float, *, color: Any, linewidth: float, linestyle: Any, zorder: float
    ) -> None:
        """Draws a line from below to above."""

        def draw(place: Place, size: tuple[float, float]) -> str:
            across = float(place(np.array([[x, self.y.limits[0]]]))[0, 0])
            ends = np.array([[across, 0.0], [across, size[1]]])
            dashes = dashes_of(linestyle, POINT * linewidth)
            return _line(ends, color, POINT * linewidth, dashes, 1.0, lambda ends: ends, size)

        self._items.append((zorder, True, draw))

    def fill(self, x: Any, y: Any, *, facecolor: Any, edgecolor: Any, zorder: float) -> None:
        points = np.stack([x, y], axis=1)
        self._items.append(
            (zorder, True, lambda place, size: (
                f'<path d="{path_of(place(points), closed=True)}" fill="{css(facecolor)}"/>'
            ))
        )  # fmt: skip

    def annotate(
        self, text: str, at: tuple[float, float], *, xytext: tuple[float, float], rotation: float,
        fontsize: float, color: Any, **unused: Any,
    ) -> None:  # fmt: skip
        """Writes at a fraction of the panel, moved by `xytext` [point]; upwards if turned."""
        high = text_width(text, fontsize) if rotation else LINE_HEIGHT * fontsize
        self._above = max(self._above, high + POINT * xytext[1])

        def draw(place: Place, size: tuple[float, float]) -> str:
            x, y = at[0] * size[0] + POINT * xytext[0], (1.0 - at[1]) * size[1] - POINT * xytext[1]
            if rotation:
                return text_at(x + 0.35 * POINT * fontsize, y, text, fontsize, "start", color, True)
            return text_at(x, y, text, fontsize, "middle", color)

        self._items.append((6.0, False, draw))

    def quiver(
        self, x: Floats, y: Floats, u: Floats, v: Floats, *, color: Any, width: float,
        headwidth: float, headlength: float, headaxislength: float, pivot: str, zorder: float,
        **unused: Any,
    ) -> None:  # fmt: skip
        """Draws arrows whose lengths and widths are in inches."""
        head = INCH * width * np.array([headlength, headaxislength, headwidth])
        start, vector = np.stack([x, y], axis=1), np.stack([u, v], axis=1)
        back = {"tail": 0.0, "middle": 0.5, "tip": 1.0}[pivot]
        draw = partial(_arrows, start, vector, css(color), INCH * width, head, back)
        self._items.append((zorder, False, draw))

    # --- rendering --------------------------------------------------------------------------------

    def settle(self, width: float, height: float) -> None:
        """Sets limits that are not given, and the number of ticks for about this size [pixel]."""
        for name, axis, column in (("x", self.x, 0), ("y", self.y, 1)):
            if name not in self._given and self._seen:
                axis.fit(np.concatenate([each[:, column] for each in self._seen]))
        self.y.most = int(np.clip(height / (2.6 * POINT * LABELS), 1, self.y.most))
        longest = max((text_width(text, LABELS) for text in self.x.ticks()[1]), default=0.0)
        self.x.most = int(np.clip(width / (longest + 18.0), 1, self.x.most))

    def margins(self) -> tuple[float, float, float, float]:
        """Returns the room for labels and titles: left, right, top and bottom [pixel]."""
        left, bottom, factor = TICK, TICK, self.y.ticks()[2]
        if self.y.labelled:
            texts = self.y.ticks()[1]
            left += GAP + max((text_width(text, LABELS) for text in texts), default=0.0)
            left += self.y.height + 4.0 * bool(self.y.label)
        if self.x.labelled:
            bottom += GAP + LINE_HEIGHT * LABELS + self.x.height
        top = LINE_HEIGHT * TITLES * len(self.title.split("\n")) + 4.0 if self.title else 0.0
        return left, 9.0, max(top + self._above, LINE_HEIGHT * LABELS * bool(factor)), bottom

    def render(self, x: float, y: float, width: float, height: float) -> str:
        """Returns the panel with its frame at a place [pixel]."""
        size = width, height

        def place(points: Floats) -> Floats:
            across, up = self.x.share(points[:, 0]), self.y.share(points[:, 1])
            return np.stack([width * across, height * (1.0 - up)], axis=1)

        inside: list[str] = []
        outside: list[str] = []
        for _, clipped, draw in sorted(self._items, key=lambda item: item[0]):
            (inside if clipped else outside).append(draw(place, size))
        box = f'width="{width:.1f}" height="{height:.1f}"'
        return (
            f'<g transform="translate({x:.1f} {y:.1f})"><rect {box} fill="{css(self._face)}"/>'
            f"<svg {box}>{self._grid_lines(place, size)}{''.join(inside)}</svg>"
            f'<rect {box} fill="none" stroke="black" stroke-width="{0.8 * POINT:.2f}"/>'
            f"{self._ticks(place, size)}{''.join(outside)}</g>"
        )

    def _grid_lines(self, place: Place, size: tuple[float, float]) -> str:
        if not self._grid:
            return ""
        across, up, _, _ = self._places(place)
        data = "".join(f"M{x:.1f} 0V{size[1]:.1f}" for x in across)
        data += "".join(f"M0 {y:.1f}H{size[0]:.1f}" for y in up)
        return f'<path d="{data}" stroke="{css("0.9")}" stroke-width="{0.6 * POINT:.2f}"/>'

    def _places(self, place: Place) -> tuple[list[float], list[float], list[str], list[str]]:
        """Returns the places of the ticks along the panel [pixel] and their labels."""
        (xs, across, _), (ys, up, _) = self.x.ticks(), self.y.ticks()
        x0, y0 = self.x.limits[0], self.y.limits[0]
        along = place(np.stack([xs, np.full(len(xs), y0)], axis=1))[:, 0]
        upward = place(np.stack([np.full(len(ys), x0), ys], axis=1))[:, 1]
        return along.tolist(), upward.tolist(), across, up

    def _ticks(self, place: Place, size: tuple[float, float]) -> str:
        width, height = size
        across, up, x_texts, y_texts = self._places(place)
        data = "".join(f"M{x:.1f} {height:.1f}v{TICK:.1f}" for x in across)
        data += "".join(f"M0 {y:.1f}h{-TICK:.1f}" for y in up)
        found = [f'<path d="{data}" stroke="black" stroke-width="{0.8 * POINT:.2f}"/>']
        below, beside = height + TICK + GAP, -TICK - GAP
        rise = 0.36 * POINT * LABELS  # from the middle of a digit to its foot
        if self.x.labelled:
            line = below + 0.8 * POINT * LABELS
            found += [
                text_at(x, line, text, LABELS) for x, text in zip(across, x_texts, strict=True)
            ]
            line = below + LINE_HEIGHT * LABELS + 0.95 * POINT * TITLES
            found.append(text_at(0.5 * width, line, self.x.label, TITLES))
            if factor := self.x.ticks()[2]:
                found.append(text_at(width, line, factor, LABELS, "end"))
        if self.y.labelled:
            found += [
                text_at(beside, y + rise, text, LABELS, "end")
                for y, text in zip(up, y_texts, strict=True)
            ]
            longest = max((text_width(text, LABELS) for text in y_texts), default=0.0)
            line = beside - longest - 4.0 - self.y.height + 0.8 * POINT * TITLES
            found.append(text_at(line, 0.5 * height, self.y.label, TITLES, turned=True))
            if factor := self.y.ticks()[2]:
                found.append(text_at(0.0, -GAP, factor, LABELS, "start"))
        lines = len(self.title.split("\n")) - 1
        found.append(text_at(0.5 * width, -5.0 - lines * LINE_HEIGHT * TITLES, self.title, TITLES))
        return "".join(found)


def _line(
    points: Floats, colour: Any, width: float, dashes: str, opacity: float, place: Place,
    size: tuple[float, float],
) -> str:  # fmt: skip
    return (
        f'<path d="{path_of(place(points))}" fill="none" stroke="{css(colour)}" '
        f'stroke-width="{width:.2f}" stroke-linejoin="round" opacity="{opacity:g}"{dashes}/>'
    )


def _markers(
    points: Floats, marker: Any, size: float, face: str, edge: str, width: float, place: Place,
    panel: tuple[float, float],
) -> str:  # fmt: skip
    """Returns markers of a size [pixel]: "o", "x", or a shape around the origin."""
    at = place(points)
    at = at[np.isfinite(at).all(axis=1)]
    if isinstance(marker, str) and marker == "o":
        data = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in at.tolist())
        style = f'stroke="{edge}" stroke-width="{size + width:.1f}" stroke-linecap="round"'
        return f'<path d="{data}" {style}/>'
    data = marker_path(marker, size)
    if isinstance(marker, str):
        face = "none"
    return "".join(
        f'<path d="{data}" transform="translate({x:.1f} {y:.1f})" fill="{face}" stroke="{edge}" '
        f'stroke-width="{width:.2f}"/>'
        for x, y in at.tolist()
    )


def marker_path(marker: Any, size: float) -> str:
    """Returns the path of a marker around the origin, as large as matplotlib draws it."""
    if isinstance(marker, str):
        marker = Shape.of([[[-0.5, -0.5], [0.5, 0.5]], [[-0.5, 0.5], [0.5, -0.5]]])
    elif not isinstance(marker, Shape):
        marker = Shape.of([marker])
    return str(marker.svg(0.5 * size / marker.extent))


def _arrows(
    start: Floats, vector: Floats, colour: str, width: float, head: Floats, back: float,
    place: Place, size: tuple[float, float],
) -> str:  # fmt: skip
    """Returns arrows: vector [inch], and length, length on the axis and width of a head [pixel]."""
    data = ""
    for at, (u, v) in zip(place(start), vector, strict=True):
        length = INCH * float(np.hypot(u, v))
        if length == 0.0:
            continue
        along = np.array([u, -v]) * INCH / length
        across = np.array([-along[1], along[0]])
        scale = min(1.0, length / head[0])
        tip, (neck, axis, wide) = length, (scale * head).tolist()
        outline = np.array(
            [
                [0.0, 0.5 * width], [tip - axis, 0.5 * width], [tip - neck, 0.5 * wide],
                [tip, 0.0], [tip - neck, -0.5 * wide], [tip - axis, -0.5 * width],
                [0.0, -0.5 * width],
            ]
        )  # fmt: skip
        outline[:, 0] -= back * length
        data += path_of(at + outline @ np.stack([along, across]), closed=True)
    return f'<path d="{data}" fill="{colour}"/>'
