# SPDX-License-Identifier: BSD-3-Clause
"""The body at all outputs, as numbers inside the page: within a budget, and what was left out."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.corners import corner_signs
from tilth.output.snapshot import Snapshot
from tilth.output.vtkhdf import Results
from tilth.report.colour_scale import ColourScale
from tilth.report.explorer.fields import Shown, column_values, columns_of, shown_fields
from tilth.report.explorer.packing import Blobs, packed_line
from tilth.report.fields import field_values

FEWEST_POINTS = 20_000
"""Points that are shown at least, where there are so many."""
_FEWEST_FIELDS = 8
"""As long as there is an output other than the first and the last to leave out."""
_SPARE = 1.04
"""More points than that are wanted: they are chosen at random."""
_PATIENCE = 3
"""Tries that believe in sizes in proportion; later ones at least halve what they leave."""


@dataclass(frozen=True)
class Choice:
    """What of the results goes into the page."""

    frames: tuple[int, ...]
    """Numbers of the outputs."""
    fields: tuple[Shown, ...]
    share: float
    """Of the points."""
    surroundings: bool = True
    """Tracked surfaces, rigid bodies and boundaries."""


def pack_body(
    results: Results,
    colour_by: str,
    budget: int,
    *,
    axis_names: Sequence[str],
    stage_at: Callable[[float], str],
    boundaries: Callable[[int], list[dict[str, Any]]],
) -> tuple[dict[str, Any], Blobs] | None:
    """Returns the description of all outputs and their numbers, at most ``budget`` characters.

    Points are left out first, down to ``FEWEST_POINTS``, then fields, then outputs evenly but for
    the first and the last one, then all fields but one, then what surrounds the soil; ``notes`` of
    the description say so. None if even that does not fit. ``stage_at`` names the stage at a total
    time, ``boundaries`` returns the boundaries at a step as parts with ``name``, ``position``
    (k, 2, dim) and ``kind``.
    """
    first, last = results.snapshot(0), results.snapshot(-1)
    every = shown_fields(last, results.units, colour_by)
    count = max(len(first.position), len(last.position))
    everything = Choice(tuple(range(len(results))), tuple(every), 1.0)
    choice, tries = everything, 0
    while True:
        frames, blobs = _pack(results, choice, boundaries, stage_at, budget)
        used = blobs.size + _size(frames) + _size(_described(choice.fields, frames))
        complete = len(frames) == len(choice.frames)
        if complete and used <= budget:
            break
        ratio = 0.93 * budget / used * len(frames) / len(choice.frames)
        tries += 1
        smaller = _less(choice, min(max(ratio, 0.0), 0.9 if tries <= _PATIENCE else 0.5), count)
        if smaller is None:
            return None
        choice = smaller
    low = np.min([frame["low"] for frame in frames], axis=0)
    high = np.max([frame["high"] for frame in frames], axis=0)
    named = next((s.name for s in choice.fields if s.name == colour_by), choice.fields[0].name)
    description = {
        "dim": results.dim,
        "axes": list(axis_names)[: results.dim],
        "length": results.units.get("length", ""),
        "time_unit": results.units.get("time", ""),
        "low": low.tolist(),
        "high": high.tolist(),
        "spacing": _spacing(first),
        "columns": [list(column) for column in columns_of(choice.fields)],
        "fields": _described(choice.fields, frames),
        "start": named,
        "frames": frames,
        "notes": _notes(everything, choice, frames),
    }
    return description, blobs


def _size(content: Any) -> int:
    """Returns the number of characters of a description."""
    return len(json.dumps(content, separators=(",", ":"), default=float))


def _less(choice: Choice, ratio: float, count: int) -> Choice | None:
    """Returns a choice of about ``ratio`` of the size, None if there is no smaller one."""
    least = min(1.0, _SPARE * FEWEST_POINTS / max(count, 1))
    fields, frames = len(choice.fields), len(choice.frames)
    if choice.share > least:
        return replace(choice, share=max(least, choice.share * ratio))
    if fields > _FEWEST_FIELDS:
        return replace(choice, fields=choice.fields[: max(_FEWEST_FIELDS, int(fields * ratio))])
    if frames > 2:
        chosen = np.round(np.linspace(0, frames - 1, max(2, int(frames * ratio)))).astype(int)
        return replace(choice, frames=tuple(choice.frames[index] for index in chosen.tolist()))
    if fields > 1:
        return replace(choice, fields=choice.fields[:1])
    return replace(choice, surroundings=False) if choice.surroundings else None


def _notes(everything: Choice, choice: Choice, frames: Sequence[dict[str, Any]]) -> list[str]:
    """Returns sentences on what the page leaves out."""
    notes = []
    last = frames[-1]
    if last["count"] < last["total"]:
        notes.append(
            f"{last['count']:,} of {last['total']:,} points are shown, chosen at random, "
            "with larger domains."
        )
    if len(choice.fields) < len(everything.fields):
        names = ", ".join(s.name.replace("_", " ") for s in everything.fields[len(choice.fields) :])
        notes.append(f"Not in this page, but in results.vtkhdf: {names}.")
    if len(choice.frames) < len(everything.frames):
        notes.append(
            f"{len(choice.frames)} of {len(everything.frames)} outputs are shown; all are in "
            "results.vtkhdf."
        )
    if not choice.surroundings:
        notes.append("Surfaces, rigid bodies and boundaries are not in this page.")
    return notes


def _pack(
    results: Results,
    choice: Choice,
    boundaries: Callable[[int], list[dict[str, Any]]],
    stage_at: Callable[[float], str],
    budget: int,
) -> tuple[list[dict[str, Any]], Blobs]:
    """Returns frames and blobs; stops at twice the budget."""
    blobs, frames = Blobs(), []
    for index in choice.frames:
        snapshot = results.snapshot(index)
        frame = _frame(snapshot, choice, results, blobs)
        frame["stage"] = stage_at(snapshot.time)
        if choice.surroundings:
            frame["lines"] += _surroundings(blobs, snapshot, boundaries(snapshot.step))
        frames.append(frame)
        if blobs.size > 2 * budget:
            break
    return frames, blobs


def _frame(snapshot: Snapshot, choice: Choice, results: Results, blobs: Blobs) -> dict[str, Any]:
    n = len(snapshot.point_id)
    share = min(1.0, max(choice.share, _SPARE * FEWEST_POINTS / max(n, 1)))
    chosen = _chosen(snapshot.point_id, share)
    position = snapshot.position[chosen]
    inside = [position] if len(position) else [np.zeros((1, snapshot.dim))]
    ranges = []
    for shown in choice.fields:
        values = _values(snapshot, shown, results)
        known = values[np.isfinite(values)]
        ranges.append([float(known.min()), float(known.max())] if len(known) else None)
    return {
        "step": snapshot.step,
        "time": snapshot.time,
        "count": len(chosen),
        "total": len(snapshot.position),
        "enlarged": share ** (-1.0 / snapshot.dim),
        "id": blobs.exact(snapshot.point_id[chosen], "<u4"),
        "position": [blobs.rounded(column) for column in position.T],
        "domain": [blobs.rounded(column) for column in _edges(snapshot, chosen).T],
        "values": [
            blobs.rounded(column_values(snapshot, column)[chosen])
            for column in columns_of(choice.fields)
        ],
        "ranges": ranges,
        "lines": [],
        "low": np.min([part.min(axis=0) for part in inside], axis=0).tolist(),
        "high": np.max([part.max(axis=0) for part in inside], axis=0).tolist(),
    }


def _surroundings(
    blobs: Blobs, snapshot: Snapshot, boundaries: Sequence[dict[str, Any]]
) -> list[dict[str, Any]]:
    shapes = [("tracked", shape) for shape in snapshot.surfaces]
    shapes += [("rigid", shape) for shape in snapshot.rigid_bodies]
    parts = [
        {"name": shape.name, "kind": kind, "position": shape.position[shape.cells]}
        for kind, shape in shapes
        if len(shape.cells)
    ]
    return [packed_line(blobs, part) for part in [*parts, *boundaries]]


def _values(snapshot: Snapshot, shown: Shown, results: Results) -> Floats:
    if shown.columns[0][0] not in snapshot.point_fields:
        return np.zeros(0)
    return field_values(snapshot, shown.name, results.units)[0]


def _chosen(point_id: Integers, share: float) -> Integers:
    """Returns the rows of about a share of points, the same points at each output."""
    if share >= 1.0:
        return np.arange(len(point_id), dtype=np.int64)
    mixed = point_id.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= mixed >> np.uint64(32)
    mixed *= np.uint64(0xD6E8FEB86659FD93)
    return np.flatnonzero((mixed >> np.uint64(40)) < np.uint64(int(share * 2**24)))


def _edges(snapshot: Snapshot, chosen: Integers) -> Floats:
    """Returns half edges of the domains: half lengths (k, dim), or with corners (k, 6) or (k, 9).

    The corners of a plane domain are ``s a + t b + s t c``, with s and t of -1 and 1; six numbers
    are a, b and c. In space they are the half edges of the nearest parallelepiped.
    """
    dim, fields = snapshot.dim, snapshot.point_fields
    if "domain_corners" in fields:
        return half_edges(np.asarray(fields["domain_corners"])[chosen])
    if "domain" in fields and np.asarray(fields["domain"]).any():
        return np.asarray(fields["domain"], dtype=np.float64)[chosen]
    return np.full((len(chosen), dim), 0.5 * _spacing(snapshot))


def half_edges(corners: Floats) -> Floats:
    """Returns the half edges of domains by their corners (k, 2**dim, dim), (k, 6) or (k, 9)."""
    dim = corners.shape[-1]
    signs = corner_signs(dim)
    parts = [np.einsum("c,pcx->px", signs[:, axis], corners) for axis in range(dim)]
    if dim == 2:
        parts.append(np.einsum("c,pcx->px", signs.prod(axis=1), corners))
    return np.asarray(np.concatenate(parts, axis=1) / 2**dim)


def _spacing(snapshot: Snapshot) -> float:
    """Returns the distance of points, about [length]."""
    n, dim = len(snapshot.position), snapshot.dim
    if "domain" in snapshot.point_fields and n:
        half = np.asarray(snapshot.point_fields["domain"], dtype=np.float64)
        if half.any():
            return float(2.0 * np.median(half.prod(axis=1)) ** (1.0 / dim))
    size = np.ptp(snapshot.position, axis=0) if n else np.ones(dim)
    return float((np.maximum(size, 1e-9 * size.max()).prod() / max(n, 1)) ** (1.0 / dim))


def _described(fields: Sequence[Shown], frames: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    columns = columns_of(fields)
    found = []
    for number, shown in enumerate(fields):
        ranges = [f["ranges"][number] for f in frames if f["ranges"][number] is not None]
        scale = ColourScale.of([np.array(each) for each in ranges])
        found.append(
            {
                "name": shown.name,
                "title": shown.title,
                "operation": shown.operation,
                "columns": [columns.index(column) for column in shown.columns],
                "low": scale.low,
                "high": scale.high,
                "map": scale.name,
            }
        )
    return found
