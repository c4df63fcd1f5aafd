# SPDX-License-Identifier: BSD-3-Clause
"""What the SVG pictures of a page show."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from tilth.report.svg_axes import SvgAxes
from tilth.report.svg_figure import SvgFigure

SVG = "{http://www.w3.org/2000/svg}"


@dataclass(frozen=True)
class Words:
    """A text: its lines, where it is from the corner of the picture or panel, and its anchor."""

    text: str
    x: float
    y: float
    size: float
    anchor: str
    turned: bool


def words(element: ElementTree.Element) -> list[Words]:
    """All texts in an element."""
    found = []
    for each in element.iter(f"{SVG}text"):
        lines = [line.text or "" for line in each]
        if any(lines):
            first = each[0].attrib
            found.append(
                Words(
                    "\n".join(lines), float(first["x"]), float(first["y"]),
                    float(each.attrib["font-size"]), each.attrib["text-anchor"],
                    "transform" in each.attrib,
                )
            )  # fmt: skip
    return found


def texts_of_svg(figure: SvgFigure) -> list[str]:
    """All texts of a picture."""
    return [each.text for each in words(ElementTree.fromstring(figure.svg()))]


@dataclass(frozen=True)
class Panel:
    """A panel as it is drawn; `element` has it all."""

    axes: SvgAxes
    element: ElementTree.Element
    width: float
    height: float

    def dashed(self) -> list[float]:
        """Places on the first axis of dashed lines from below to above."""
        low, high = self.axes.x.limits
        found = []
        for path in self.element.iter(f"{SVG}path"):
            if "stroke-dasharray" in path.attrib:
                x = float(path.attrib["d"][1:].split()[0])
                found.append(low + (high - low) * x / self.width)
        return found

    def above(self) -> list[Words]:
        """Texts above the panel."""
        return [each for each in words(self.element) if each.y < 0.0 and "×" not in each.text]


def panels(figure: SvgFigure) -> list[Panel]:
    """The panels of a picture as it is drawn."""
    groups = [
        g for g in ElementTree.fromstring(figure.svg()).iter(f"{SVG}g") if g.find(f"{SVG}svg")
    ]
    sizes = [g.find(f"{SVG}rect").attrib for g in groups]  # type: ignore[union-attr]
    return [
        Panel(axes, group, float(size["width"]), float(size["height"]))
        for axes, group, size in zip(figure.axes, groups, sizes, strict=True)
    ]


def image_pixels(element: ElementTree.Element) -> np.ndarray:
    """The pixels of the only image in an element, shape (height, width, 4)."""
    import base64
    import io

    from PIL import Image

    (image,) = element.iter(f"{SVG}image")
    content = base64.b64decode(image.attrib["href"].split(",", 1)[1])
    return np.asarray(Image.open(io.BytesIO(content)))
