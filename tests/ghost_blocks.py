# SPDX-License-Identifier: BSD-3-Clause
"""Blocks of soil that lie across the cells of a grid, for tests of ghost stabilisation."""

from __future__ import annotations

from typing import Any

from small_problems import (
    AXES,
    block_entries,
    dimension,
    plane,
    spaced,
)

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate


def block(
    kind: str,
    basis: str,
    shift: float,
    *,
    angle: float = 0.0,
    cells: int = 2,
    points: int = 4,
    spacing: str = "uniform",
) -> tuple[Simulation, ActiveGrid]:
    """A stress-free block of this many cells a side, shifted along the diagonal."""
    dim = dimension(kind)
    boundaries = [plane(axis, axis, 0.0) for axis in AXES[:dim]]
    entries: dict[str, Any] = block_entries(kind, basis, boundaries=boundaries)
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body["points"] = [points] * dim
    body["shape"] = {"type": "box", "lower": [shift] * dim, "upper": [cells + shift] * dim}
    if angle:
        body["shape"]["angle"] = angle
        body["shape"]["lower"] = [10.0 + shift] * dim
        body["shape"]["upper"] = [10.0 + shift + cells] * dim
    simulation = Simulation(Model.from_dict(spaced(entries, spacing)))
    return simulation, locate(simulation.state.points, simulation.state.grid, Buffers())
