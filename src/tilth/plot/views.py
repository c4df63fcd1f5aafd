# SPDX-License-Identifier: BSD-3-Clause
"""What a picture of an output shows: the plane or space, the soil in it and what is around."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.output.snapshot import Snapshot
from tilth.plot.run import PlottedRun
from tilth.plot.surroundings import boundary_handle, draw_segments, rigid_handle
from tilth.report.field_plots import draw_plane, extent
from tilth.report.fields import with_unit
from tilth.report.handles import Handle
from tilth.report.points_3d import draw_points_3d
from tilth.report.rigid_bodies import draw_rigid_2d, draw_rigid_3d, rigid_vertices
from tilth.report.tracked_surfaces import (
    INITIAL_LINE,
    draw_tracked_2d,
    draw_tracked_3d,
    tracked_handles,
    tracked_vertices,
)
from tilth.report.water_line import draw_water, nearby, water_handle

AROUND = 0.12
"""Distance from the soil up to which moving boundaries are inside a picture, over its longest
side."""
Limits = tuple[Floats, Floats]


class View(ABC):
    """A way to show outputs in axes of matplotlib."""

    title = ""
    """What the title says beside the time, "" for nothing."""

    @property
    @abstractmethod
    def labels(self) -> Sequence[str]:
        """Labels of the axes, two or three."""

    @abstractmethod
    def limits(self, snapshot: Snapshot) -> Limits | None:
        """Returns the corners of what is shown of an output [length]; None without soil."""

    def nothing(self, snapshot: Snapshot) -> BadInput:
        """Returns the error where no output has soil to show."""
        return BadInput("the results have no soil", "choose another run", key="DIR")

    @abstractmethod
    def handles(self, snapshot: Snapshot, limits: Limits) -> list[Handle]:
        """Returns the entries of the legend for an output."""

    @abstractmethod
    def draw(
        self,
        axes: Any,
        snapshot: Snapshot,
        values: Floats,
        colours: Callable[[Floats], Any],
        limits: Limits,
    ) -> None:
        """Draws values (n,) of the points and all around them."""


class PlaneView(View):
    """The plane of a run in the plane, with boundaries, rigid bodies, surfaces and water."""

    def __init__(self, run: PlottedRun, show: str) -> None:
        """``show``: field, points or domains, as of ``draw_plane``."""
        self._run, self._show = run, show
        self._initial = run.results.snapshot(0)

    @property
    def labels(self) -> Sequence[str]:
        """Labels of the two axes."""
        return [with_unit(name, self._run.length_unit) for name in self._run.axis_names[:2]]

    def limits(self, snapshot: Snapshot) -> Limits:
        """Returns the corners around the soil, what is tracked, and what moves near it."""
        others = tracked_vertices([self._initial, snapshot]) + rigid_vertices([snapshot])
        low, high = extent([snapshot], others)
        room = AROUND * float((high - low).max())
        for part in self._run.boundaries(snapshot, low - room, high + room):
            if part["kind"] == "rigid":
                place = part["position"].reshape(-1, 2)
                if ((place > low - 0.99 * room) & (place < high + 0.99 * room)).all():
                    others.append(place)  # not what goes on beyond the picture
        others = [each for each in others if len(each)]
        if (line := self._run.water(snapshot.time)) is not None and len(
            near := nearby(line, low, high)
        ):
            others.append(near)
        return extent([snapshot], others)

    def handles(self, snapshot: Snapshot, limits: Limits) -> list[Handle]:
        """Returns the entries of the legend for an output."""
        handles = _surface_handles(snapshot)
        if handles and snapshot.step != self._initial.step:
            handles.append(Handle("surface at the start", {"color": "0.3", **INITIAL_LINE}))
        parts = self._run.boundaries(snapshot, *limits)
        handles += boundary_handle([part["name"] for part in parts])
        handles += rigid_handle([body.name for body in snapshot.rigid_bodies if len(body.cells)])
        if self._run.water(snapshot.time) is not None:
            handles.append(water_handle(moves=False))
        return handles

    def draw(
        self,
        axes: Any,
        snapshot: Snapshot,
        values: Floats,
        colours: Callable[[Floats], Any],
        limits: Limits,
    ) -> None:
        """Draws values (n,) of the points and all around them."""
        draw_plane(axes, snapshot, values, colours, self._show)
        for part in self._run.boundaries(snapshot, *limits):
            draw_segments(axes, part["position"])
        draw_rigid_2d(axes, snapshot.rigid_bodies)
        draw_tracked_2d(axes, snapshot, self._initial)
        axes.set_xlim(limits[0][0], limits[1][0])
        axes.set_ylim(limits[0][1], limits[1][1])
        if (line := self._run.water(snapshot.time)) is not None:
            draw_water(axes, line)


class SpaceView(View):
    """The points of a run in space that are visible from outside, with bodies and surfaces."""

    THINNEST = 0.05
    """Sides of the space are not shown shorter than this, over the longest one."""

    def __init__(self, run: PlottedRun) -> None:
        self._run = run

    @property
    def labels(self) -> Sequence[str]:
        """Labels of the three axes."""
        return [with_unit(name, self._run.length_unit) for name in self._run.axis_names]

    def limits(self, snapshot: Snapshot) -> Limits:
        """Returns the corners around the soil, what is tracked, and rigid bodies near it."""
        return extent([snapshot], tracked_vertices([snapshot]) + rigid_vertices([snapshot]))

    def handles(self, snapshot: Snapshot, limits: Limits) -> list[Handle]:
        """Returns the entries of the legend for an output."""
        handles = _surface_handles(snapshot)
        return handles + rigid_handle([b.name for b in snapshot.rigid_bodies if len(b.cells)])

    def draw(
        self,
        axes: Any,
        snapshot: Snapshot,
        values: Floats,
        colours: Callable[[Floats], Any],
        limits: Limits,
    ) -> None:
        """Draws values (n,) of the points and all around them."""
        draw_points_3d(
            axes,
            snapshot.position,
            snapshot.point_fields.get("domain"),
            np.asarray(colours(values)),
            *limits,
            self._run.length_unit,
            self.THINNEST,
            snapshot.point_fields.get("domain_corners"),
        )
        draw_rigid_3d(axes, snapshot.rigid_bodies)
        draw_tracked_3d(axes, snapshot.surfaces)


def _surface_handles(snapshot: Snapshot) -> list[Handle]:
    """Returns the entries of the legend of the tracked surfaces that are there."""
    there = [len(shape.cells) > 0 for shape in snapshot.surfaces]
    return tracked_handles(snapshot.surfaces, there)


def around(limits: Sequence[Limits]) -> Limits:
    """Returns the corners around several pairs of corners."""
    return (
        np.min([low for low, _ in limits], axis=0),
        np.max([high for _, high in limits], axis=0),
    )
