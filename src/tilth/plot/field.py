# SPDX-License-Identifier: BSD-3-Clause
"""A field of a run at one time, as a figure for a paper."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from tilth.errors import BadInput
from tilth.output.snapshot import Snapshot
from tilth.plot.names import output_at, require_field
from tilth.plot.picture import FieldPicture, Scene
from tilth.plot.plane import Plane
from tilth.plot.run import PlottedRun
from tilth.plot.section import SectionView
from tilth.plot.views import PlaneView, SpaceView, View
from tilth.report.colour_scale import ColourScale
from tilth.report.fields import parameter_fields

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Show = Literal["field", "points", "domains"]


def field_figure(
    folder: Path | str,
    field: str,
    *,
    time: float | None = None,
    show: Show = "field",
    section: str | None = None,
    values: tuple[float, float] | None = None,
) -> Figure:
    """Returns the figure of a field over the deformed soil, to scale, with what is around it.

    That are boundaries, rigid bodies, tracked surfaces and the water level.

    Args:
        folder: of the run.
        field: its name, or with a component, such as ``cauchy_stress_yy``.
        time: of an output; the last one if None.
        show: the field over the region of the soil, or each point, or each point's domain.
        section: of a run in space the plane to draw, ``x=1.0`` or a point and a normal,
            ``0,0,1:1,1,0``; without it the points are drawn that are visible from outside.
        values: those at the ends of the colours; by default the least and the largest one.

    Raises:
        BadInput: there are no results, or the field or the time is none of theirs, or the plane
            cuts no soil.
    """
    run = PlottedRun.of(folder)
    index = output_at(run.results, time)
    snapshot = run.results.snapshot(index)
    require_field(snapshot, field)
    view = view_of(run, snapshot, field, show, section)
    scene = Scene.of(run, view, field, [index], scale_between(values))
    picture = FieldPicture(run, view, field, scene)
    picture.draw(snapshot)
    picture.finish()
    return picture.figure


def view_of(
    run: PlottedRun, snapshot: Snapshot, field: str, show: Show, section: str | None = None
) -> View:
    """Returns how outputs like this one are shown; raises ``BadInput`` for what does not fit."""
    if show == "field" and field in parameter_fields(snapshot):
        show = "domains"  # the values of neighbours may have nothing between them
    if section is not None:
        if run.results.dim == 2:
            problem = "the results are in the plane"
            raise BadInput(problem, "leave out --section", key="section", value=section)
        return SectionView(run, Plane.of(section), show)
    return SpaceView(run) if run.results.dim == 3 else PlaneView(run, show)


def scale_between(values: tuple[float, float] | None) -> ColourScale | None:
    """Returns the colours between two values; None for None, ``BadInput`` if not increasing."""
    if values is None:
        return None
    low, high = values
    if not low < high:
        raise BadInput("the first value must be below the second", key="range", value=[low, high])
    return ColourScale(low, high, "coolwarm" if low == -high else "viridis")
