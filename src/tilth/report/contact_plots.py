# SPDX-License-Identifier: BSD-3-Clause
"""Pressure and shear on contact surfaces at an output, in the soil and along the surface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.output.snapshot import ContactShape, Snapshot
from tilth.report.charts import Chart, Line
from tilth.report.colour_scale import ColourScale
from tilth.report.fields import with_unit
from tilth.report.rigid_bodies import rigid_vertices
from tilth.report.setup_page import BODIES
from tilth.report.views import Cloud, Panel, View, surface_lines

PRESSURE = "#c1121f"
_LONGEST_BAR = 0.22
"""Length of the greatest pressure in the picture of the soil, over its longer side."""
_NEW_PART = 4.0
"""Distance of neighbours above which another part of the surface begins, over the usual one."""
_TURN = 3.0
"""Distance that a change of the normal by 1 counts for, over the usual distance: the two sides of a
thin plate are apart."""


def contact_view(
    snapshot: Snapshot, shape: ContactShape, units: Mapping[str, str], axisymmetric: bool = False
) -> View:
    """Returns the pictures of a contact surface with points near soil.

    In the plane the pressure is drawn on the surface in the soil near it; in space patches are
    coloured by pressure and shear.
    """
    pressure, shear, touching = _stresses(shape)
    draw = _plane_panels if snapshot.dim == 2 else _space_panels
    low, high, clouds, panels, spacing = draw(snapshot, shape, pressure, shear, touching, units)
    return View(
        f"Pressure and shear on {shape.name}",
        ("r" if axisymmetric else "x", "y", "z"),
        units.get("length", ""),
        low,
        high,
        spacing,
        clouds,
        panels,
    )


def contact_chart(shape: ContactShape, units: Mapping[str, str]) -> Chart:
    """Returns a chart of pressure and shear over the arc length, in the plane."""
    pressure, shear, touching = _stresses(shape)
    order, length, breaks = along_surface(shape.position, shape.fields["normal"])
    lines = []
    for values, colour, label in (
        (pressure, 1, "pressure"),
        (shear, 0, "shear stress along the surface"),
    ):
        shown = np.where(touching, values, 0.0)[order]
        x = np.concatenate([_with_gap(part) for part in np.split(length, breaks)])
        y = np.concatenate([_with_gap(part) for part in np.split(shown, breaks)])
        lines.append(Line(x, y, label, colour))
    return Chart(
        f"Pressure and shear along {shape.name}",
        with_unit("arc length", units.get("length", "")),
        with_unit("stress", units.get("stress", "")),
        lines,
        across=[0.0],
    )


def _with_gap(values: Floats) -> Floats:
    return np.append(values, np.nan)


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


_Drawn = tuple[Floats, Floats, list[Cloud], list[Panel], float]


def _plane_panels(
    snapshot: Snapshot,
    shape: ContactShape,
    pressure: Floats,
    shear: Floats,
    touching: Any,
    units: Mapping[str, str],
) -> _Drawn:
    """Returns the soil near the surface, rigid bodies and bars of the pressure normal to it."""
    low, high = shape.position.min(axis=0), shape.position.max(axis=0)
    size = max(float((high - low).max()), 1e-300)
    low, high = low - 0.6 * size, high + 0.6 * size
    half = np.asarray(snapshot.point_fields["domain"])
    near = ((snapshot.position + half >= low) & (snapshot.position - half <= high)).all(axis=1)
    corners = snapshot.point_fields.get("domain_corners")
    greatest = float(np.abs(pressure).max()) or 1.0
    ends = shape.position - _LONGEST_BAR * size / greatest * (
        pressure[:, None] * shape.fields["normal"]
    )
    lines = surface_lines(snapshot.rigid_bodies, "rigid")
    bars = np.stack([shape.position, ends], axis=1)
    lines.append({"name": shape.name, "kind": "bars", "position": bars, "colour": PRESSURE})
    cloud = Cloud.of(
        snapshot.position[near], half[near], None if corners is None else corners[near], lines
    )
    title = f"longest bar: {greatest:.4g} {units.get('stress', '')}".rstrip()
    soil = np.full(int(near.sum()), 255.0)
    spacing = float(2.0 * np.median(half.prod(axis=1)) ** 0.5)
    return low, high, [cloud], [Panel(title, 0, soil, BODIES)], spacing


def _space_panels(
    snapshot: Snapshot,
    shape: ContactShape,
    pressure: Floats,
    shear: Floats,
    touching: Any,
    units: Mapping[str, str],
) -> _Drawn:
    """Returns patches coloured by pressure and shear, grey where there is no contact."""
    everything = [shape.position, *rigid_vertices([snapshot])]
    low = np.min([each.min(axis=0) for each in everything], axis=0)
    high = np.max([each.max(axis=0) for each in everything], axis=0)
    side = 0.5 * np.sqrt(np.maximum(np.asarray(shape.fields["area"]), 1e-300))
    half = np.tile(side[:, None], (1, 3))
    every = np.arange(len(side), dtype=np.int64)
    cloud = Cloud(shape.position, half, every, lines=surface_lines(snapshot.rigid_bodies, "rigid"))
    upward = float(shape.fields["normal"][:, 2].mean()) >= 0.0
    panels = []
    for values, label in ((pressure, "pressure"), (shear, "shear stress")):
        shown = np.where(touching, values, np.nan)
        bar = with_unit(label, units.get("stress", ""))
        scale = ColourScale.of([shown])
        look = "space" if upward else "below"
        panels.append(Panel("", 0, shown, scale, bar, drawn="points", look=look))
    return low, high, [cloud], panels, float(2.0 * np.median(side))


def contact_note(dim: int) -> str:
    """Returns the text below the pictures."""
    shear = (
        "the shear stress of the surface on the soil is positive in the direction of the arc "
        "length, with the soil on the left"
        if dim == 2
        else "the shear stress is its magnitude, and grey points are without contact"
    )
    return (
        f"At the last output. The pressure is positive in compression; {shear}. contact.csv has "
        "these numbers, results.vtkhdf has those of all outputs."
    )
