# SPDX-License-Identifier: BSD-3-Clause
"""Implicit boundaries beside the soil, where they are at an output."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.setup_data import Setup, Surface
from tilth.report.stage_setups import StagedSetup
from tilth.report.surface_lines import clip_segments, clip_triangles


def boundaries_at(
    setup: Setup | StagedSetup | None,
    table: Mapping[str, Floats],
    step: int,
    time: float,
    box: tuple[Floats, Floats] | None = None,
) -> list[dict[str, Any]]:
    """Returns the parts of boundaries near the soil: ``name``, ``kind`` and ``position`` [length].

    ``position`` are segments (k, 2, 2) or triangles (k, 3, 3). ``table`` is boundaries.csv by
    heading; boundaries are moved by their displacements in it. ``kind`` is ``boundary``, or
    ``rigid`` where one moves. Rigid bodies are left out: they are in the results. ``box``: lower
    and upper corner of what is returned [length], else those of the set-up's figure.
    """
    if setup is None:
        return []
    if isinstance(setup, StagedSetup):
        chosen = [k for k, stage in enumerate(setup.stages) if time <= stage.end]
        setup = setup.at(chosen[0] if chosen else -1)
    low, high = setup.bounds() if box is None else box
    found = []
    for surface in setup.surfaces:
        if surface.kind != "rigid body" and len(surface.corner):
            corner = surface.corner + _moved(surface, table, step)
            part = clipped(corner, low, high)
            if len(part):
                kind = "boundary" if surface.displacement is None else "rigid"
                found.append({"name": surface.name, "kind": kind, "position": part})
    return found


def _moved(surface: Surface, table: Mapping[str, Floats], step: int) -> Floats:
    """Returns the displacement of a boundary at a step [length], shape (dim,)."""
    dim = surface.corner.shape[-1]
    moved = np.zeros(dim)
    for axis, letter in enumerate("xyz"[:dim]):
        for heading, values in table.items():
            if heading.startswith(f"{surface.name} displacement_{letter}") and step < len(values):
                moved[axis] = values[step] if np.isfinite(values[step]) else 0.0
    return moved


def clipped(corner: Floats, low: Floats, high: Floats) -> Floats:
    """Returns the parts of segments (n, 2, 2) or triangles (n, 3, 3) within a box."""
    if corner.shape[-1] == 2:
        return np.asarray(clip_segments(corner, low, high)[0])
    fans = []
    for polygon in clip_triangles(corner, low, high)[0]:
        middle = np.arange(1, len(polygon) - 1)
        fans.append(
            np.stack([polygon[np.zeros_like(middle)], polygon[middle], polygon[middle + 1]], 1)
        )
    return np.concatenate(fans) if fans else np.zeros((0, 3, 3))
