# SPDX-License-Identifier: BSD-3-Clause
"""Pressure and shear on contact surfaces at an output, beside the deformed soil."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.output.snapshot import ContactShape, Snapshot
from tilth.report.fields import with_unit
from tilth.report.rigid_bodies import draw_rigid_2d, draw_rigid_3d, rigid_vertices
from tilth.report.texts import AS_IT_IS, LABEL_WIDTH, any_characters, on_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PRESSURE, SHEAR = "#c1121f", "#1d3557"
_SOIL = "#d9c8a5"
_LONGEST_BAR = 0.22
"""Length of the greatest pressure in the picture of the soil, over its longer side."""
_NEW_PART = 4.0
"""Distance of neighbours above which another part of the surface begins, over the usual one."""
_TURN = 3.0
"""Distance that a change of the normal by 1 counts for, over the usual distance: the two sides of a
thin plate are apart."""


_ELEVATION = 25.0
"""Angle of the view in space above the horizon, or below it if the surface looks down [degrees]."""


def draw_contact(
    snapshot: Snapshot, name: str, units: Mapping[str, str], axisymmetric: bool = False
) -> Figure | None:
    """Returns the figure of a contact surface; None where it has no points near soil.

    In the plane the pressure is drawn on the surface, and pressure and shear over the arc length;
    in space patches are coloured by both.
    """
    shape = next((each for each in snapshot.contacts if each.name == name), None)
    if shape is None or len(shape.position) == 0:
        return None
    figure = (
        _draw_plane(snapshot, shape, units, axisymmetric)
        if snapshot.dim == 2
        else _draw_space(snapshot, shape, units)
    )
    time = f"step {snapshot.step}, time {snapshot.time:.4g}"
    figure.suptitle(on_lines(f"{name}: {time}", 90), fontsize=10, **AS_IT_IS)
    return figure


def along_surface(position: Floats, normal: Floats) -> tuple[Integers, Floats, Integers]:
    """Returns the order of points along a curve, their arc lengths and the starts of its parts.

    The shapes are (n,), (n,) and (parts - 1,). The order goes from neighbour to neighbour, from
    an end of the curve, with the normals on the left; of a closed curve from its lowest point. The
    arc length is the sum of the distances, also from part to part.
    """
    n = len(position)
    if n == 1:
        return np.zeros(1, dtype=np.int64), np.zeros(1), np.zeros(0, dtype=np.int64)
    usual = _usual_distance(position, normal)
    order = _chain(position, normal, usual)
    step = np.linalg.norm(np.diff(position[order], axis=0), axis=1)
    tangent = np.diff(position[order], axis=0)
    middle = normal[order][:-1]
    if float((tangent[:, 0] * middle[:, 1] - tangent[:, 1] * middle[:, 0]).sum()) < 0.0:
        order, step = order[::-1], step[::-1]
    breaks = np.flatnonzero(step > _NEW_PART * usual) + 1
    return order, np.append(0.0, np.cumsum(step)), breaks


def _usual_distance(position: Floats, normal: Floats) -> float:
    """Returns the median distance of a point from the next one on its side of the body."""
    from scipy.spatial import cKDTree

    size = float(np.ptp(position, axis=0).max())
    place = np.hstack([position, size * normal])
    _, neighbour = cKDTree(place).query(place, k=2)
    apart = np.linalg.norm(position[neighbour[:, 1]] - position[neighbour[:, 0]], axis=1)
    return float(np.median(apart[apart > 0.0])) if (apart > 0.0).any() else 1.0


def _chain(position: Floats, normal: Floats, usual: float) -> Integers:
    """Returns an order of the points (n,) that goes from nearest neighbour to neighbour."""
    place = np.hstack([position, _TURN * usual * normal])
    order = _from(int(np.argmin(position[:, -1])), place)
    step = np.linalg.norm(np.diff(place[order], axis=0), axis=1)
    jumps = np.flatnonzero(step > _NEW_PART * usual)
    return _from(int(order[jumps[0]]), place) if len(jumps) else order  # from an end of the curve


def _from(first: int, place: Floats) -> Integers:
    order, left = [first], np.ones(len(place), dtype=bool)
    left[first] = False
    while left.any():
        others = np.flatnonzero(left)
        apart = ((place[others] - place[order[-1]]) ** 2).sum(axis=1)
        order.append(int(others[np.argmin(apart)]))
        left[order[-1]] = False
    return np.array(order)


def _draw_plane(
    snapshot: Snapshot, shape: ContactShape, units: Mapping[str, str], axisymmetric: bool
) -> Figure:
    from matplotlib.figure import Figure

    pressure, shear, touching = _stresses(shape)
    order, length, breaks = along_surface(shape.position, shape.fields["normal"])
    figure = Figure(figsize=(10.2, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    _draw_soil(left, snapshot, shape, pressure, units, axisymmetric)
    unit = units.get("stress", "")
    for values, colour, label in (
        (pressure, PRESSURE, "pressure"),
        (shear, SHEAR, "shear stress along the surface"),
    ):
        shown = np.where(touching, values, 0.0)[order]
        for part, at in zip(np.split(shown, breaks), np.split(length, breaks), strict=True):
            right.plot(at, part, color=colour, linewidth=1.3, label=label, marker=".", markersize=3)
            label = "_"
    right.axhline(0.0, color="0.6", linewidth=0.6, zorder=0.8)
    right.set_xlabel(with_unit("arc length", units.get("length", "")), fontsize=9, **AS_IT_IS)
    right.set_ylabel(with_unit("stress", unit), fontsize=9, **AS_IT_IS)
    right.ticklabel_format(scilimits=(-3, 5))
    right.tick_params(labelsize=8)
    right.grid(color="0.9", linewidth=0.6)
    right.legend(fontsize=8, frameon=False)
    return figure


def _stresses(shape: ContactShape) -> tuple[Floats, Floats, Any]:
    """Returns pressure, shear and where there is contact, shape (n,) each.

    The shear is positive in the direction in which the soil is on the left, in space its magnitude.
    """
    fields = shape.fields
    shear, normal = fields["shear_stress"], fields["normal"]
    if shape.position.shape[1] == 2:
        tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
        along = (shear * tangent).sum(axis=1)
    else:
        along = np.linalg.norm(shear, axis=1)
    return -fields["normal_stress"] + 0.0, along, fields["in_contact"] != 0


def _draw_soil(
    axes: Axes,
    snapshot: Snapshot,
    shape: ContactShape,
    pressure: Floats,
    units: Mapping[str, str],
    axisymmetric: bool,
) -> None:
    """Draws the soil near the surface, the rigid bodies and the pressure normal to the surface."""
    from matplotlib.collections import LineCollection, PolyCollection

    from tilth.report.domains import corners_of, drawn_at_once, outlines

    low, high = shape.position.min(axis=0), shape.position.max(axis=0)
    size = max(float((high - low).max()), 1e-300)
    low, high = low - 0.6 * size, high + 0.6 * size
    half = snapshot.point_fields["domain"]
    corners = corners_of(snapshot)
    assert corners is not None
    near = ((snapshot.position + half >= low) & (snapshot.position - half <= high)).all(axis=1)
    axes.add_collection(
        PolyCollection(
            drawn_at_once(outlines(snapshot.position[near], corners[near])),
            facecolors=_SOIL,
            edgecolors="white",
            linewidths=0.2,
        )
    )
    draw_rigid_2d(axes, snapshot.rigid_bodies)
    greatest = float(np.abs(pressure).max()) or 1.0
    ends = shape.position - _LONGEST_BAR * size / greatest * (
        pressure[:, None] * shape.fields["normal"]
    )
    bars = np.stack([shape.position, ends], axis=1)
    axes.add_collection(LineCollection(list(bars), colors=PRESSURE, linewidths=0.9, zorder=3.0))
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    unit = units.get("length", "")
    axes.set_xlabel(with_unit("r" if axisymmetric else "x", unit), fontsize=9, **AS_IT_IS)
    axes.set_ylabel(with_unit("y", unit), fontsize=9, **AS_IT_IS)
    axes.tick_params(labelsize=8)
    axes.locator_params(axis="x", nbins=5)  # it is narrow where the surface is high
    axes.set_facecolor("0.97")
    text = f"longest bar: {greatest:.4g} {units.get('stress', '')}".rstrip()
    axes.set_title(text, fontsize=8.5, color=PRESSURE, **AS_IT_IS)


def _draw_space(snapshot: Snapshot, shape: ContactShape, units: Mapping[str, str]) -> Figure:
    from matplotlib.figure import Figure

    pressure, shear, touching = _stresses(shape)
    figure = Figure(figsize=(10.2, 4.6), layout="constrained")
    low = np.min(
        [shape.position.min(axis=0), *(p.min(axis=0) for p in rigid_vertices([snapshot]))], axis=0
    )
    high = np.max(
        [shape.position.max(axis=0), *(p.max(axis=0) for p in rigid_vertices([snapshot]))], axis=0
    )
    margin = 0.05 * float((high - low).max())
    upward = float(shape.fields["normal"][:, 2].mean()) >= 0.0
    for index, (values, label) in enumerate(((pressure, "pressure"), (shear, "shear stress"))):
        axes: Any = figure.add_subplot(1, 2, index + 1, projection="3d")
        axes.computed_zorder = False
        axes.view_init(elev=_ELEVATION if upward else -_ELEVATION, azim=-55.0)
        axes.set_box_aspect(np.maximum(high - low + 2.0 * margin, 1e-300), zoom=0.85)
        draw_rigid_3d(axes, snapshot.rigid_bodies)
        area = np.maximum(shape.fields["area"], 1e-300)
        points = 220.0 * np.sqrt(area) / float((high - low).max() or 1.0)
        drawn = axes.scatter(
            *shape.position[touching].T,
            c=values[touching],
            s=np.clip(points[touching], 1.5, 14.0) ** 2,
            marker="s",
            linewidths=0.0,
            cmap="viridis",
            depthshade=False,
            zorder=3.0,
        )
        if (~touching).any():
            axes.scatter(*shape.position[~touching].T, c="0.8", s=2.0, linewidths=0.0, zorder=2.8)
        bar = figure.colorbar(drawn, ax=axes, shrink=0.75, pad=0.14)
        name = with_unit(label, units.get("stress", ""))
        bar.set_label(on_lines(name, LABEL_WIDTH), fontsize=9, **AS_IT_IS)
        bar.ax.tick_params(labelsize=8)
        for k, axis in enumerate("xyz"):
            getattr(axes, f"set_{axis}lim")(low[k] - margin, high[k] + margin)
            named = with_unit(axis, units.get("length", ""))
            axes.locator_params(axis=axis, nbins=4)
            getattr(axes, f"set_{axis}label")(named, fontsize=8, **AS_IT_IS)
        axes.tick_params(labelsize=7)
    layout = figure.get_layout_engine()
    assert layout is not None
    with any_characters():
        layout.execute(figure)
    return figure


def contact_note(dim: int) -> str:
    """Returns the text below the figures."""
    shear = (
        "the shear stress of the surface on the soil is positive in the direction of the arc "
        "length, with the soil on the left"
        if dim == 2
        else "the shear stress is its magnitude, and small grey dots are points without contact"
    )
    return (
        f"At the last output. The pressure is positive in compression; {shear}. contact.csv has "
        "these numbers, results.vtkhdf has those of all outputs."
    )
