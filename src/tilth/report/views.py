# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of points that a page draws itself: their numbers, and what surrounds them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.output.snapshot import Snapshot, SurfaceShape
from tilth.report.colour_scale import ColourScale
from tilth.report.explorer.body import half_edges
from tilth.report.explorer.packing import Blobs, packed_line
from tilth.report.visible_points import exterior_points

MOST_POINTS = 30_000
"""Points of a picture, at most; of more, some are left out at random, with larger domains."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points with their domains, and lines or triangles beside them; ``dim`` is 2 or 3."""

    position: Floats
    """[length], shape (n, dim)."""
    edges: Floats
    """Half lengths (n, dim) or half edges (n, 6) or (n, 9) of the domains [length]."""
    chosen: Integers
    """Rows of the points that are shown."""
    enlarged: float = 1.0
    """Lengths of their domains over the true ones."""
    lines: Sequence[dict[str, Any]] = ()
    """Parts with ``name``, ``kind``, ``position`` (k, 2, 2) or (k, 3, 3) [length] and perhaps
    ``colour``."""

    @classmethod
    def of(
        cls,
        position: Floats,
        half: Floats,
        corners: Floats | None = None,
        lines: Sequence[dict[str, Any]] = (),
    ) -> Cloud:
        """Returns a cloud of points with domains by half lengths (n, dim) or by corners."""
        edges = half if corners is None else half_edges(corners)
        n, dim = position.shape
        chosen = np.arange(n, dtype=np.int64)
        if dim == 3 and n > 1000:
            chosen = np.asarray(exterior_points(position, half), dtype=np.int64)
        share = MOST_POINTS / max(len(chosen), 1)
        if share >= 1.0:
            return cls(position, edges, chosen, lines=lines)
        kept = np.sort(np.random.default_rng(0).permutation(len(chosen))[:MOST_POINTS])
        return cls(position, edges, chosen[kept], share ** (-1.0 / dim), lines)

    @classmethod
    def of_snapshot(cls, snapshot: Snapshot, lines: Sequence[dict[str, Any]] = ()) -> Cloud:
        """Returns the points of an output."""
        fields = snapshot.point_fields
        corners = fields.get("domain_corners")
        return cls.of(snapshot.position, np.asarray(fields["domain"]), corners, lines)

    def packed(self, blobs: Blobs) -> dict[str, Any]:
        """Returns the description for the page."""
        position, edges = self.position[self.chosen], self.edges[self.chosen]
        return {
            "count": len(self.chosen),
            "enlarged": self.enlarged,
            "position": [blobs.rounded(column) for column in position.T],
            "domain": [blobs.rounded(column) for column in edges.T],
            "lines": [packed_line(blobs, part) for part in self.lines],
        }


@dataclass(frozen=True, eq=False)
class Panel:
    """One picture of a cloud."""

    title: str
    cloud: int
    """Number of the cloud of its view."""
    values: Floats | None
    """Of all points, shape (n,); grey where there is none."""
    scale: ColourScale
    bar: str = ""
    """Name of the values with their unit, beside the colours; no bar if empty."""
    drawn: str = "domains"
    """domains, points or, in the plane, field."""
    marks: Sequence[dict[str, Any]] = ()
    """Symbols over it; arrays are of positions and vectors [length], shape (k, dim)."""
    look: str = "space"
    """Direction of the view in space: space, front, side or plan."""


@dataclass(frozen=True, eq=False)
class View:
    """Panels with the same axes."""

    name: str
    """What it shows, for those who do not see it."""
    axes: Sequence[str]
    length: str
    """Label of the unit of lengths."""
    low: Floats
    """Corner of the panels [length], shape (dim,)."""
    high: Floats
    spacing: float
    """Distance of the points, about [length]."""
    clouds: Sequence[Cloud]
    panels: Sequence[Panel]
    grid: Sequence[Sequence[float]] = ()
    """Places of grid lines along each axis [length]."""
    keys: Sequence[tuple[str, str, str]] = ()
    """Sign, colour and words of each entry of the legend."""
    notes: Sequence[str] = field(default_factory=tuple)

    def packed(self, blobs: Blobs) -> dict[str, Any]:
        """Returns the description for the page."""
        panels = []
        for panel in self.panels:
            own = {
                "frame": panel.cloud,
                "drawn": panel.drawn,
                "look": panel.look,
                "bar": panel.bar,
                "low": panel.scale.low,
                "high": panel.scale.high,
                "map": panel.scale.name,
                "marks": [packed_mark(blobs, mark) for mark in panel.marks],
            }
            if panel.values is not None:
                own["values"] = blobs.rounded(panel.values[self.clouds[panel.cloud].chosen])
            panels.append(own)
        dim = len(self.low)
        return {
            "dim": dim,
            "axes": list(self.axes)[:dim],
            "length": self.length,
            "low": self.low.tolist(),
            "high": self.high.tolist(),
            "spacing": self.spacing,
            "frames": [cloud.packed(blobs) for cloud in self.clouds],
            "panels": panels,
            "grid": [list(places) for places in self.grid],
        }


@dataclass(frozen=True)
class OutputsOnPaper:
    """Outputs of the body at all outputs, side by side, where the page is printed."""

    name: str
    field: str
    """As ``output.colour_by`` takes it."""
    steps: Sequence[int]
    titles: Sequence[str]
    drawn: str
    """As that of a panel."""

    def packed(self, blobs: Blobs) -> dict[str, Any]:
        """Returns the description for the page, whose numbers are those of the body."""
        return {"field": self.field, "steps": list(self.steps), "drawn": self.drawn}


def surface_lines(shapes: Sequence[SurfaceShape], kind: str, colours: Sequence[str] = ()) -> Any:
    """Returns surfaces as parts for `Cloud.lines`."""
    return [
        {
            "name": shape.name,
            "kind": kind,
            "position": shape.position[shape.cells],
            **({"colour": colours[number % len(colours)]} if colours else {}),
        }
        for number, shape in enumerate(shapes)
        if len(shape.cells)
    ]


def packed_mark(blobs: Blobs, mark: dict[str, Any]) -> dict[str, Any]:
    """Stores the arrays of a mark column by column."""
    return {
        key: [blobs.rounded(column) for column in value.reshape(len(value), -1).T]
        if isinstance(value, np.ndarray)
        else value
        for key, value in mark.items()
    }
