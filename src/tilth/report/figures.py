# SPDX-License-Identifier: BSD-3-Clause
"""Charts and pictures of one page: their places in it, and the data from which it draws them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from tilth.report.blocks import Block, Template
from tilth.report.charts import Chart
from tilth.report.colour_scale import ColourScale
from tilth.report.explorer.packing import Blobs
from tilth.report.setup_view import FILLS
from tilth.report.views import OutputsOnPaper, View

FOLDER = "tilth.report.explorer"
CHART_SCRIPTS = ("data.js", "vendor/uPlot.iife.min.js", "chart.js", "paper.js")
SCENE_SCRIPTS = (
    "vendor/three.min.js",
    "shaders.js",
    "soil.js",
    "field.js",
    "triad.js",
    "marks.js",
    "scene.js",
    "views.js",
)
STYLES = ("vendor/uPlot.min.css", "explorer.css")
_MAPS = ("viridis", "coolwarm")
_OTHER_SOIL = (0.85, 0.78, 0.65)
"""The last colour by number: soil of any body."""


@dataclass
class Figures:
    """Collects charts and pictures in the order in which they are in the page."""

    blobs: Blobs = field(default_factory=Blobs)
    charts: list[dict[str, Any]] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)

    def draw(self, figures: Sequence[Chart | View | OutputsOnPaper]) -> list[Block]:
        """Adds figures; returns their places side by side."""
        if not figures:
            return []
        entries = []
        for figure in figures:
            group = self.charts if isinstance(figure, Chart) else self.views
            entries.append((type(figure).__name__, len(group), figure))
            group.append(figure.packed(self.blobs))
        return [Template("figures.html", {"entries": entries})]

    def data(self, **more: Any) -> tuple[str, str]:
        """Returns the description of all figures as JSON, and the elements with their numbers."""
        content = {"charts": self.charts, "views": self.views, "maps": _maps(), **more}
        text = json.dumps(content, separators=(",", ":"), default=float)
        return text.replace("<", "\\u003c"), self.blobs.elements("page")


@cache
def source(name: str) -> str:
    """Returns a script or style sheet of the page; no script may end its element."""
    text = files(FOLDER).joinpath(name).read_text(encoding="utf-8")
    return text.replace("</script", "<\\/script") if name.endswith(".js") else text


def styles() -> str:
    """Returns the style sheets of charts and pictures."""
    return "\n".join(source(name) for name in STYLES)


def _maps() -> dict[str, list[int]]:
    """Returns 256 colours of each map, red, green and blue of each in turn, 0 to 255."""
    found = {
        name: ColourScale(0.0, 1.0, name).colours(np.linspace(0.0, 1.0, 256)) for name in _MAPS
    }
    found["bodies"] = np.resize(FILLS, (256, 3))
    found["bodies"][-1] = _OTHER_SOIL
    return {
        name: np.rint(255.0 * map_.ravel()).astype(int).tolist() for name, map_ in found.items()
    }
