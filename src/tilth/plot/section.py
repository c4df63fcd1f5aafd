# SPDX-License-Identifier: BSD-3-Clause
"""The section of a run in space: its soil, boundaries, rigid bodies and surfaces on a plane."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.errors import BadInput
from tilth.output.snapshot import Snapshot, SurfaceShape
from tilth.plot.plane import Plane, cut_domains, cut_triangles
from tilth.plot.run import PlottedRun
from tilth.plot.surroundings import boundary_handle, draw_segments, rigid_handle
from tilth.plot.views import Limits, View
from tilth.report.continuous import ContinuousField
from tilth.report.domains import corners_of, drawn_at_once
from tilth.report.fields import with_unit
from tilth.report.handles import Handle
from tilth.report.interpolation import values_at
from tilth.report.region import Part, Region, part_of_polygons
from tilth.report.rigid_bodies import EDGE
from tilth.report.surface_lines import clip_segments
from tilth.report.tracked_surfaces import LINE_WIDTH, colour_of, tracked_handles

_MARGIN = 0.03
"""Width around the soil, over its sides."""
_NEAR = 0.25
"""Distance from the soil up to which rigid bodies are inside the picture, over its longest side."""


@dataclass(frozen=True, eq=False)
class SectionPart(Part):
    """The section of one body; a field's values come from the points of this body alone."""

    plane: Plane
    body: Integers
    """Numbers of the body's points in space."""

    def values(self, position: Floats, values: Floats) -> Floats:
        """Returns a field's values at the vertices, from those of all points in space (n, 3)."""
        places = self.plane.space(self.vertex)
        return values_at(position[self.body], values[self.body], places)


@dataclass(frozen=True, eq=False)
class Section:
    """What a plane cuts of the soil at an output."""

    region: Region
    polygon: Floats
    """Where it cuts the points' domains, shape (m, k, 2)."""
    point: Integers
    """The points of these domains, shape (m,)."""

    @classmethod
    def of(cls, plane: Plane, snapshot: Snapshot) -> Section:
        """Returns the section; raises ``BadInput`` if the points have no domains."""
        corners = corners_of(snapshot)
        if corners is None:
            problem = "the results have no domains of the points to cut"
            raise BadInput(problem, key="section", value=plane.text)
        parts, polygons, points = [], [], []
        for body in np.unique(snapshot.body_id):
            own = np.flatnonzero(snapshot.body_id == body)
            polygon, cut = cut_domains(plane, snapshot.position[own], corners[own])
            if len(cut) == 0:
                continue
            polygons.append(polygon)
            points.append(own[cut])
            if (part := part_of_polygons(polygon)) is not None:
                parts.append(SectionPart(**vars(part), plane=plane, body=own))
        longest = max((each.shape[1] for each in polygons), default=3)
        polygons = [
            np.pad(p, ((0, 0), (0, longest - p.shape[1]), (0, 0)), "edge") for p in polygons
        ]
        return cls(
            Region(tuple(parts)),
            np.concatenate([np.zeros((0, longest, 2)), *polygons]),
            np.concatenate([np.zeros(0, dtype=np.int64), *points]),
        )

    def values_in(self, snapshot: Snapshot, values: Floats, places: Floats) -> Floats:
        """Returns a field's values at places in the plane, (m, 2); NaN outside of the soil."""
        return self.region.values_in(snapshot.position, values, places)


class SectionView(View):
    """The view of a plane through a run in space."""

    def __init__(self, run: PlottedRun, plane: Plane, show: str) -> None:
        """``show``: field or domains; raises ``BadInput`` for points."""
        if show == "points":
            problem = "a section cuts domains, not points"
            raise BadInput(problem, "leave out --show, or take domains", key="show", value=show)
        self._run, self._plane, self._show = run, plane, show
        self._last: tuple[int, Section] | None = None
        self.title = f"plane {plane.text}"
        if "=" in plane.text:
            name, _, place = plane.text.partition("=")
            self.title = f"{name.strip()} = {place.strip()} {run.length_unit}".strip()

    @property
    def labels(self) -> Sequence[str]:
        """Labels of the two axes."""
        return [with_unit(name, self._run.length_unit) for name in self._plane.names]

    def limits(self, snapshot: Snapshot) -> Limits | None:
        """Returns the corners around the soil and the rigid bodies near it; None without soil."""
        polygon = self._section(snapshot).polygon.reshape(-1, 2)
        if len(polygon) == 0:
            return None
        low, high = polygon.min(axis=0), polygon.max(axis=0)
        room = _NEAR * float((high - low).max())
        near = [polygon]
        for _, segment in self._rigid(snapshot):
            near.append(clip_segments(segment, low - room, high + room)[0].reshape(-1, 2))
        place = np.concatenate(near)
        low, high = place.min(axis=0), place.max(axis=0)
        margin = _MARGIN * np.maximum(high - low, 1e-3 * float((high - low).max()))
        return low - margin, high + margin

    def nothing(self, snapshot: Snapshot) -> BadInput:
        """Returns the error for a plane that cuts no soil."""
        height = self._plane.height(snapshot.position)
        ends = np.sort([float(height.min()), float(height.max())])
        if "=" in self._plane.text:
            ends = ends + float(self._plane.origin @ self._plane.normal)
            along = self._plane.text.partition("=")[0].strip()
            remedy = f"the points are at {along} from {ends[0]:.4g} to {ends[1]:.4g}"
        else:
            remedy = f"the points are from {ends[0]:.4g} to {ends[1]:.4g} above it"
        return BadInput("cuts no soil", remedy, key="section", value=self._plane.text)

    def handles(self, snapshot: Snapshot, limits: Limits) -> list[Handle]:
        """Returns the entries of the legend for an output."""
        cut = [len(self._cut(shape)) > 0 for shape in snapshot.surfaces]
        handles = tracked_handles(snapshot.surfaces, cut)
        handles += boundary_handle([name for name, _ in self._boundaries(snapshot, limits)])
        return handles + rigid_handle([name for name, _ in self._rigid(snapshot)])

    def draw(
        self,
        axes: Any,
        snapshot: Snapshot,
        values: Floats,
        colours: Callable[[Floats], Any],
        limits: Limits,
    ) -> None:
        """Draws values (n,) of the points in space on the plane, and all that it cuts."""
        from matplotlib.collections import PolyCollection

        section = self._section(snapshot)
        if self._show == "field":
            field = ContinuousField(section.region, snapshot.position, values, colours)
            field.add_to(axes)
        elif len(section.point):
            colour = colours(values[section.point])
            area = drawn_at_once(section.polygon)
            axes.add_collection(
                PolyCollection(area, facecolors=colour, edgecolors=colour, linewidths=0.3)
            )
        for _, segment in self._boundaries(snapshot, limits):
            draw_segments(axes, segment)
        for _, segment in self._rigid(snapshot):
            draw_segments(axes, segment, EDGE, 1.2)
        for number, shape in enumerate(snapshot.surfaces):
            draw_segments(axes, self._cut(shape), colour_of(number), LINE_WIDTH)

    def _section(self, snapshot: Snapshot) -> Section:
        if self._last is None or self._last[0] != snapshot.step:
            self._last = snapshot.step, Section.of(self._plane, snapshot)
        return self._last[1]

    def _cut(self, shape: SurfaceShape) -> Floats:
        return cut_triangles(self._plane, shape.position[shape.cells])

    def _rigid(self, snapshot: Snapshot) -> list[tuple[str, Floats]]:
        found = [(body.name, self._cut(body)) for body in snapshot.rigid_bodies]
        return [(name, segment) for name, segment in found if len(segment)]

    def _boundaries(self, snapshot: Snapshot, limits: Limits) -> list[tuple[str, Floats]]:
        """Returns names and segments of the boundaries that the plane cuts near the soil."""
        square = np.array([[limits[i][0], limits[j][1]] for i in (0, 1) for j in (0, 1)])
        place = self._plane.space(square)
        room = 1e-6 * float(np.ptp(place, axis=0).max())
        low, high = place.min(axis=0) - room, place.max(axis=0) + room
        found = []
        for part in self._run.boundaries(snapshot, low, high):
            segment = clip_segments(cut_triangles(self._plane, part["position"]), *limits)[0]
            if len(segment):
                found.append((part["name"], segment))
        return found
