# SPDX-License-Identifier: BSD-3-Clause
"""The set-up in a page: one picture, or one for each stage, with what acts on the soil."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.colour_scale import ColourScale
from tilth.report.explorer.boundaries import clipped
from tilth.report.setup import legend_handles
from tilth.report.setup_data import Condition, Setup, Surface
from tilth.report.setup_view import (
    CONDITION_COLOURS,
    FILLS,
    LOAD_COLOUR,
    MAXIMUM_LINES,
    condition_colour,
    outward,
)
from tilth.report.stage_pages import everything
from tilth.report.stage_setups import StagedSetup
from tilth.report.surface_lines import clip_segments, moved_corners, oriented
from tilth.report.tracked_surfaces import TRACKED_COLOURS
from tilth.report.views import Cloud, Panel, View, surface_lines
from tilth.report.water_line import WATER_COLOUR, water_handle

BODIES = ColourScale(0.0, 255.0, "bodies")
"""Colours by number: two for each body, the second where soil is new."""
LOOKS = ("front", "side", "plan", "space")
_LOOK_TITLES = {"front": "front (along y)", "side": "side (along x)", "plan": "plan (along z)"}
MOST_STAGES = 24
"""Stages of which there are pictures, at most: the first ones."""
_MOST_SYMBOLS, _MOST_ARROWS = 400, 40
"""Of a condition or load, at most."""
_DASHES = {"tangential": [8, 2, 2, 2], "direction": [2, 2]}


def setup_view(setup: Setup | StagedSetup) -> View:
    """Returns the pictures of a set-up; of a staged one a picture for each stage.

    The soil of stages is undeformed, as each begins; loads are those at its end.
    """
    if isinstance(setup, Setup):
        setups, titles, legend = [setup], [""], setup
        notes = _outside([setup])
    else:
        stages = setup.stages[:MOST_STAGES]
        setups = [setup.at(k) for k in range(len(stages))]
        titles = [
            f"{stage.number} {stage.name} (time {stage.start:g} to {stage.end:g})"
            + "".join(f"; {change}" for change in stage.changes)
            for stage in stages
        ]
        legend = everything(setup, stages)
        notes = _outside(setups)
        if len(setup.stages) > MOST_STAGES:
            notes.append(f"Of {len(setup.stages)} stages the first {MOST_STAGES} are shown.")
    bounds = [each.bounds() for each in setups]
    low = np.min([b[0] for b in bounds], axis=0)
    high = np.max([b[1] for b in bounds], axis=0)
    first = next((each for each in setups if len(each.position)), setups[0])
    panels = []
    for number, (each, title) in enumerate(zip(setups, titles, strict=True)):
        marks = list(_marks(each, low, high))
        values = (each.shade % len(FILLS)).astype(np.float64)
        for look in LOOKS if each.dim == 3 and len(setups) == 1 else ("space",):
            named = title or _LOOK_TITLES.get(look, "" if each.dim == 2 else "in space")
            panels.append(Panel(named, number, values, BODIES, marks=marks, look=look))
    keys = [(handle.sign, handle.colour, handle.label) for handle in legend_handles(legend)]
    moving = [each.water for each in setups if each.water is not None]
    if moving and legend.water is None:
        handle = water_handle(any(not np.array_equal(*water) for water in moving))
        keys.append((handle.sign, handle.colour, handle.label))
    if any(np.any(each.is_new) for each in setups):
        keys.append(("\N{BLACK SQUARE}", "#8d744a", "darker: new in the stage"))
    if any(each.removed is not None and len(each.removed.position) for each in setups):
        keys.append(("\N{SQUARE WITH UPPER RIGHT TO LOWER LEFT FILL}", "#8c8c8c",
                     "removed at the start of the stage"))  # fmt: skip
    return View(
        "Set-up: points, grid, conditions and loads",
        first.axis_names,
        first.length_unit,
        low,
        high,
        _spacing(first),
        [_cloud(each, low, high) for each in setups],
        panels,
        grid=[_grid_lines(first, axis, low, high) for axis in range(first.dim)],
        keys=keys,
        notes=notes,
    )


def _cloud(setup: Setup, low: Floats, high: Floats) -> Cloud:
    half = setup.half_lengths
    if half is None:
        half = np.full_like(setup.position, 0.5 * _spacing(setup))
    lines = surface_lines(setup.tracked, "tracked", TRACKED_COLOURS)
    if setup.dim == 3:
        for number, surface in enumerate(setup.surfaces, start=len(setup.conditions)):
            part = clipped(surface.corner, low, high)
            if len(part):
                colour = _colour(setup, surface.name, number)
                kind = "rigid" if surface.kind == "rigid body" else "boundary"
                lines.append(
                    {"name": surface.name, "kind": kind, "position": part, "colour": colour}
                )
    return Cloud.of(setup.position, half, setup.corners, lines)


def _spacing(setup: Setup) -> float:
    """Returns the distance of points, about [length]."""
    if setup.half_lengths is not None and len(setup.half_lengths):
        return float(2.0 * np.median(setup.half_lengths.prod(axis=1)) ** (1.0 / setup.dim))
    return float(setup.cell_size.min()) / 2.0


def _grid_lines(setup: Setup, axis: int, low: Floats, high: Floats) -> list[float]:
    """Returns the places of grid lines in the picture along an axis; of many, some."""
    ends = setup.in_cells(np.array([low[axis], high[axis]]), axis)
    first, last = np.ceil(ends[0]), np.floor(ends[1])
    every = int(max(np.ceil((last - first + 1) / MAXIMUM_LINES), 1))
    lines = np.arange(np.ceil(first / every) * every, last + 1, every)
    return [float(f"{place:.9g}") for place in setup.coordinates(lines, axis)]


def _colour(setup: Setup, name: str, number: int) -> str:
    return CONDITION_COLOURS[setup.colour_of(name, number) % len(CONDITION_COLOURS)]


def _marks(setup: Setup, low: Floats, high: Floats) -> Iterator[dict[str, Any]]:
    """Yields the symbols of a set-up, in the order in which they are drawn."""
    if setup.removed is not None and len(setup.removed.position):
        removed = setup.removed
        yield {"kind": "removed", "position": removed.position, "half": removed.half_lengths}
    for number, surface in enumerate(setup.surfaces, start=len(setup.conditions)):
        yield from _surface(surface, _colour(setup, surface.name, number), low, high)
    if setup.water is not None:
        before, after = setup.water
        if not np.array_equal(before, after):
            yield {"kind": "path", "position": _pairs(before), "colour": WATER_COLOUR,
                   "dash": [5, 4]}  # fmt: skip
        yield {"kind": "path", "position": _pairs(after), "colour": WATER_COLOUR, "water": True}
    for number, condition in enumerate(setup.conditions):
        yield from _condition(condition, condition_colour(setup, condition, number), setup)
    for load in setup.loads:
        inside = ((load.position >= low) & (load.position <= high)).all(axis=1)
        yield _arrows(load.position[inside], load.force[inside], LOAD_COLOUR, "tip", _MOST_ARROWS)
    if setup.body_force is not None and np.any(setup.body_force):
        for body in np.unique(setup.body_id):
            middle = setup.position[setup.body_id == body].mean(axis=0, keepdims=True)
            yield _arrows(middle, setup.body_force[None], LOAD_COLOUR, "middle", 1)


def _surface(surface: Surface, colour: str, low: Floats, high: Floats) -> Iterator[dict[str, Any]]:
    """Yields line and supports of an implicit boundary or rigid body, and its motion."""
    if surface.corner.shape[-1] == 2:
        segment, seen = clip_segments(surface.corner, low, high)
        normal = surface.normal[seen]
        if len(segment):
            dash = _DASHES.get(surface.kind, [])
            yield {"kind": "edge", "support": surface.kind, "dash": dash, "colour": colour,
                   "position": oriented(segment, normal)}  # fmt: skip
    if surface.displacement is None or not np.any(surface.displacement):
        return
    if surface.corner.shape[-1] == 2:
        moved = clip_segments(moved_corners(surface.corner, surface.displacement), low, high)[0]
        if len(moved):
            yield {"kind": "path", "position": moved, "colour": colour, "dash": [6, 4]}
    centre = surface.corner.mean(axis=1)
    inside = ((centre >= low) & (centre <= high)).all(axis=1)
    yield _arrows(centre[inside], surface.displacement[inside], colour, "tail", 8)


def _condition(condition: Condition, colour: str, setup: Setup) -> Iterator[dict[str, Any]]:
    """Yields the symbols of one condition, on the side opposite to the soil."""
    if not len(condition.position):
        return
    if condition.displacement is not None:
        most = 60 if condition.kind == "affine" else 12
        yield _arrows(condition.position, condition.displacement, colour, "tail", most)
        return
    middle = 0.5 * (setup.position.min(axis=0) + setup.position.max(axis=0))
    for mask in np.unique(condition.constrained, axis=0):
        group = condition.position[(condition.constrained == mask).all(axis=1)]
        axis, sign = outward(group, mask, middle)
        kind = "fixed" if mask.all() else "roller"
        yield {
            "kind": "support",
            "support": "cross" if condition.kind == "affine" or not mask.any() else kind,
            "axis": axis,
            "sign": sign,
            "position": _some(group, _MOST_SYMBOLS),
            "colour": colour,
        }


def _arrows(position: Floats, vector: Floats, colour: str, pivot: str, most: int) -> dict[str, Any]:
    longest = float(np.linalg.norm(vector, axis=1).max(initial=0.0)) or 1.0
    return {
        "kind": "arrows",
        "pivot": pivot,
        "position": _some(position, most),
        "vector": _some(vector, most) / longest,
        "colour": colour,
    }


def _some(rows: Floats, most: int) -> Floats:
    """Returns at most so many of rows, evenly."""
    every = max(-(-len(rows) // most), 1)
    return np.asarray(rows[::every], dtype=np.float64)


def _pairs(line: Floats) -> Floats:
    """Returns the segments (k - 1, 2, 2) of a polyline (k, 2)."""
    return np.stack([line[:-1], line[1:]], axis=1)


def _outside(setups: Sequence[Setup]) -> list[str]:
    """Returns sentences on the surfaces that none of the pictures shows."""
    seen: dict[str, bool] = {}
    for setup in setups:
        low, high = setup.bounds()
        for surface in setup.surfaces:
            there = len(surface.visible_vertices(low, high)) > 0
            seen[surface.name] = seen.get(surface.name, False) or there
    return [f"{name} lies outside the picture." for name, there in seen.items() if not there]
