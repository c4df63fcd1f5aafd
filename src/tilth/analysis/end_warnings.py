# SPDX-License-Identifier: BSD-3-Clause
"""Warnings of narrow boundaries that hold soil: how much wider they act than they are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tilth.boundaries.step.constraints import holding
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.geometry.footing import Footing
from tilth.grid.background import Grid
from tilth.mpm.points import MaterialPoints

LEAST_CELLS = 5.0
"""Width of a footing in cells from which on its load is at most a fifth too high in clay."""

ROUND_OFF = 1e-6
"""Of a number of cells."""


def end_warnings(
    boundaries: Sequence[Implicit], points: MaterialPoints, grid: Grid
) -> Iterator[tuple[str, str]]:
    """Moving footings of a few cells that end in soil: a key for each, and its text."""
    from scipy.spatial import cKDTree

    for boundary in holding(boundaries):
        shape = boundary.geometry
        if not (isinstance(shape, Footing) and boundary.declared.is_moving):
            continue
        half = shape.half[:, None] * shape.axes
        along = np.concatenate([-half, half])
        size = grid.sizes_at(shape.centre + along)
        # the cell's edge along the width on which an end lies
        cell = (size * np.abs(along)).sum(axis=1) / np.abs(along).sum(axis=1)
        beyond = shape.centre + along * (1.0 + 0.5 * cell / np.linalg.norm(along, axis=1))[:, None]
        away = cKDTree(points.position).query(beyond)[0]
        wider = np.where(away <= cell, cell, 0.0).reshape(2, -1).max(axis=0)
        widths = 2.0 * shape.half
        worst = int((wider / widths).argmax())
        if wider[worst] * LEAST_CELLS <= widths[worst] * (1.0 + ROUND_OFF):
            continue
        yield (
            f"width of {boundary.name}",
            f"{boundary.key}.geometry.width: the boundary {boundary.name!r} is only "
            f"{widths[worst] / wider[worst]:.2g} cells wide; soil is held up to half a cell beyond "
            f"its ends, so that it can act {100.0 * wider[worst] / widths[worst]:.2g} % wider "
            "than it is (docs/choosing.md); choose smaller cells, at least at its ends "
            "(grid.cell_size with places)",
        )
