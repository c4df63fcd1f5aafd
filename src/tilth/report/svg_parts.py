# SPDX-License-Identifier: BSD-3-Clause
"""Parts of pictures in pages as SVG: texts, paths, and collections named as those of matplotlib."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby
from operator import itemgetter
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.report.raster import draw_polygons, png

POINT = 96.0 / 72.0
"""Pixels of a page in a point of a font or line."""
INCH = 96.0
MOST_SHAPES, MOST_EDGED = 400, 6_000
"""Polygons that are shapes, without and with edges of another colour; more are an image."""
_FINER = 2.0
"""Pixels of such an image over those of the page."""
_CHARACTER = 0.6
"""Mean width of a character over the size of its font."""

Place = Callable[[Floats], Floats]
"""Goes from data to pixels from the upper left corner of the panel, shape (n, 2)."""


def css(colour: Any) -> str:
    """Returns a colour as SVG has it; numbers in [0, 1] are red, green and blue."""
    if not isinstance(colour, str):
        return "#" + "".join(f"{round(255 * float(each)):02x}" for each in colour[:3])
    if colour[0].isdecimal():
        return css([float(colour)] * 3)
    return {"k": "black", "w": "white"}.get(colour, colour)


def text_width(text: str, size: float) -> float:
    """Returns about the width of the longest line of a text [pixel]; size: of the font [point]."""
    longest = max(text.split("\n"), key=len)
    wide = sum(character in "WMm%@" for character in longest)
    return POINT * size * (_CHARACTER * len(longest) + 0.3 * wide)


def text_at(
    x: float, y: float, text: str, size: float, anchor: str = "middle", fill: Any = "0.13",
    turned: bool = False,
) -> str:  # fmt: skip
    """Returns lines of text, the first one on the line at y [pixel]; turned: they go upwards."""
    step = 1.2 * POINT * size
    turn = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turned else ""
    rows = "".join(
        f'<tspan x="{x:.1f}" y="{y + number * step:.1f}">{escape(line)}</tspan>'
        for number, line in enumerate(text.split("\n"))
    )
    return (
        f'<text font-size="{POINT * size:.1f}" text-anchor="{anchor}" fill="{css(fill)}"{turn}>'
        f"{rows}</text>"
    )


def path_of(points: Floats, closed: bool = False) -> str:
    """Returns the data of a path through points [pixel], (n, 2); not finite ones are gaps."""
    parts, begin = [], True
    for x, y in points.tolist():
        if x - x != 0.0 or y - y != 0.0:
            begin = True
            continue
        parts.append(f"{'M' if begin else 'L'}{x:.1f} {y:.1f}")
        begin = False
    return "".join(parts) + ("Z" if closed and parts else "")


def image_of(content: bytes, x: float, y: float, width: float, height: float) -> str:
    """Returns a PNG image at a place [pixel]."""
    data = base64.b64encode(content).decode()
    return (
        f'<image x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" '
        f'preserveAspectRatio="none" href="data:image/png;base64,{data}"/>'
    )


def dashes_of(linestyle: Any, width: float) -> str:
    """Returns the attribute of a dash pattern; numbers are multiples of the width, as before."""
    named = {"-": (), "--": (3.7, 1.6), ":": (1.0, 1.65), "none": ()}
    pattern = named[linestyle] if isinstance(linestyle, str) else linestyle[1]
    if not pattern:
        return ""
    lengths = " ".join(f"{each * width:.1f}" for each in pattern)
    return f' stroke-dasharray="{lengths}"'


@dataclass(frozen=True)
class LineCollection:
    """Lines, shape (n, 2, 2)."""

    segments: Sequence[Any]
    colors: Any
    linewidths: float
    alpha: float = 1.0
    zorder: float = 2.0

    def draw(self, place: Place, size: tuple[float, float]) -> str:
        """Returns them as one path."""
        ends = np.asarray(self.segments, dtype=float).reshape(-1, 2, 2)
        data = "".join(path_of(place(line)) for line in ends)
        return (
            f'<path d="{data}" fill="none" stroke="{css(self.colors)}" '
            f'stroke-width="{POINT * self.linewidths:.2f}" opacity="{self.alpha:g}"/>'
        )


@dataclass(frozen=True, eq=False)
class PolyCollection:
    """Polygons, shape (n, k, 2), with colours of all or each."""

    area: npt.ArrayLike
    facecolors: Any
    edgecolors: Any
    linewidths: float
    zorder: float = 1.0

    def draw(self, place: Place, size: tuple[float, float]) -> str:
        """Returns shapes, or an image of many."""
        area = np.asarray(self.area, dtype=float)
        if len(area) == 0:
            return ""
        corners = place(area.reshape(-1, 2)).reshape(area.shape)
        edged = self.edgecolors is not self.facecolors
        if isinstance(self.facecolors, str) or len(area) <= (MOST_EDGED if edged else MOST_SHAPES):
            return self._shapes(corners)
        return self._image(corners, size)

    def _shapes(self, corners: Floats) -> str:
        """Returns a path of each run of polygons of the same colours."""
        colours = [
            [each] * len(corners) if isinstance(each, str) else [css(one) for one in each]
            for each in (self.facecolors, self.edgecolors)
        ]
        shapes = (path_of(corner, closed=True) for corner in corners)
        styled = zip(zip(*colours, strict=True), shapes, strict=True)
        return "".join(
            f'<path d="{"".join(shape for _, shape in run)}" fill="{css(fill)}" '
            f'stroke="{css(edge)}" stroke-width="{POINT * self.linewidths:.2f}"/>'
            for (fill, edge), run in groupby(styled, key=itemgetter(0))
        )

    def _image(self, corners: Floats, size: tuple[float, float]) -> str:
        """Returns the part of an image of the panel in which there are polygons."""
        low = np.clip(np.floor(corners.min(axis=(0, 1))) - 1.0, 0.0, size)
        high = np.clip(np.ceil(corners.max(axis=(0, 1))) + 1.0, 0.0, size)
        width, height = np.ceil(_FINER * (high - low)).astype(int).tolist()
        if width <= 0 or height <= 0:
            return ""
        number = draw_polygons(_FINER * (corners - low), width, height)
        pixels = np.zeros((height, width, 4), dtype=np.uint8)
        there = number >= 0
        colours = np.asarray(self.facecolors, dtype=float)[:, :3]
        pixels[there, :3] = np.rint(255.0 * colours).astype(np.uint8)[number[there]]
        pixels[there, 3] = 255
        x, y = low.tolist()
        return image_of(png(pixels), x, y, width / _FINER, height / _FINER)


@dataclass(frozen=True, eq=False)
class EllipseCollection:
    """Circles: diameters [length] of all, or of each, and centres, shape (n, 2)."""

    widths: Any
    heights: Any
    angles: Any
    units: str
    offsets: Floats
    facecolors: Any
    edgecolors: Any
    transOffset: Any = None  # noqa: N815 (named as that of matplotlib)
    linewidths: float = 0.0
    zorder: float = 2.0

    def draw(self, place: Place, size: tuple[float, float]) -> str:
        """Returns circles, as wide as along the first axis; many without edge as an image."""
        centre = place(self.offsets)
        diameter = np.broadcast_to(np.asarray(self.widths, dtype=float), (len(centre),))
        unit = place(np.array([[0.0, 0.0], [1.0, 0.0]]))
        radius = 0.5 * diameter * float(unit[1, 0] - unit[0, 0])
        each = not isinstance(self.facecolors, str)
        if each and len(centre) > MOST_SHAPES:
            turn = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
            rim = np.stack([np.cos(turn), np.sin(turn)], axis=1)
            area = centre[:, None, :] + radius[:, None, None] * rim
            return PolyCollection(area, self.facecolors, "none", 0.0)._image(area, size)
        edge = f'stroke="{css(self.edgecolors)}" stroke-width="{POINT * self.linewidths:.2f}"'
        return "".join(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.2f}" '
            f'fill="{css(self.facecolors[i] if each else self.facecolors)}" {edge}/>'
            for i, ((x, y), r) in enumerate(zip(centre.tolist(), radius.tolist(), strict=True))
        )
