# SPDX-License-Identifier: BSD-3-Clause
"""A block of soft clay that collapses under its weight, against AMPLE."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.analysis.march import initial_position, march
from tilth.arrays import Floats
from tilth.boundaries.surfaces.motion import rotation_matrix
from tilth.model import Model
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, absolute, at_least, relative, vanishing
from tilth_verification.reference import collapse_by_ample
from tilth_verification.turned import ALIGNED, aligned, copies

FIGURE = "AMPLE, figure"
AMPLE = "AMPLE 1.1, run"
HEIGHT = 8.0
"""Initial height of the block [m]."""


@dataclass(frozen=True)
class Outcome:
    """Initial and final positions of the points, by their numbers [length], shape (n, 2).

    upper_corner: upper right corners of their domains [length], shape (n, 2); volume_change: of
    the whole body, relative [-].
    """

    initial: Floats
    final: Floats
    upper_corner: Floats
    volume_change: float


def comparisons(long: bool) -> Iterator[Comparison]:
    """Point by point at h 1 m; run-out and surface at h 0.5 m and 0.25 m; turned."""
    model = example("collapse")
    for file, grid, tolerance in (
        ("ample.toml", "h 1 m", 0.05),
        ("ample_grid.toml", "h 1 m, AMPLE's grid", 0.005),
    ):
        distance = distances_to_ample(solve(example("collapse", file)))
        mean, largest = float(distance.mean()), float(distance.max())
        yield vanishing(f"mean distance, {grid}", mean, tolerance, AMPLE, "m")
        quantity = f"largest distance, {grid}"
        yield vanishing(quantity, largest, 2.0 * tolerance, AMPLE, "m")
    yield from surface(model, 0.5)
    if long:
        yield from surface(model, 0.25)
    yield from turned_copies(long)


def turned_copies(long: bool) -> Iterator[Comparison]:
    """Turned against the grid, and on a grid that is shifted: where the points end.

    Aligned ones of h 1 and 0.5 m are 0.90 % of the height apart, those of 0.5 and 0.25 m 0.97 %.
    """
    worst = []
    for size, tolerance in ((1.0, 0.01), (0.5, 0.007)) if long else ((1.0, 0.01),):
        model = aligned("collapse", size)
        final = solve(model).final
        quantity = f"RMS distance of the points over the height, h {size:g} m"
        distances = []
        for at, angle, copy in copies(model):
            distance = rms(solve(copy).final @ rotation_matrix(angle, None, 2), final)
            yield vanishing(f"{quantity}, {at}", distance, tolerance, ALIGNED)
            if angle:
                distances.append(distance)
        worst.append(max(distances))
    if long:
        quantity = "largest RMS distance of a turned copy, h 1 over 0.5 m"
        yield at_least(quantity, worst[0] / worst[1], 1.0, 0.0, "it falls with the cell")


def rms(position: Floats, reference: Floats) -> float:
    """Returns the RMS of the points' distances from the reference over the block's height [-]."""
    return float(np.sqrt(((position - reference) ** 2).sum(axis=1).mean())) / HEIGHT


def distances_to_ample(outcome: Outcome) -> Floats:
    """Returns each point's final distance from AMPLE's point of the same origin [length], (n,)."""
    reference = collapse_by_ample()
    ours, theirs = _by_origin(outcome.initial), _by_origin(reference.initial_position)
    return np.asarray(
        np.linalg.norm(outcome.final[ours] - reference.final_position[theirs], axis=1)
    )


def surface(model: Model, cell_size: float) -> Iterator[Comparison]:
    """Run-out, symmetry axis, crest and dip; the figure can be read to 0.1 m."""
    outcome = solve(varied(model, {"grid.cell_size": cell_size}))
    at = f"h {cell_size:g} m"
    upper_corner = outcome.upper_corner
    yield relative(f"run-out, {at}", float(upper_corner[:, 0].max()), 13.9, 0.03, FIGURE, "m")
    axis = outcome.initial[:, 0] == outcome.initial[:, 0].min()
    top = float(upper_corner[axis, 1].max())
    yield absolute(f"height at the symmetry axis, {at}", top, 5.25, 0.1, FIGURE, "m")
    crest = upper_corner[:, 1].argmax()
    crest_x, crest_y = float(outcome.final[crest, 0]), float(upper_corner[crest, 1])
    yield absolute(f"height of the crest, {at}", crest_y, 6.3, 0.1, FIGURE, "m")
    yield absolute(f"position of the crest, {at}", crest_x, 8.5, 0.1, FIGURE, "m")
    upper = np.flatnonzero(outcome.initial[:, 1] == outcome.initial[:, 1].max())
    dip = upper[upper_corner[upper, 1].argmin()]
    dip_x, dip_y = float(outcome.final[dip, 0]), float(upper_corner[dip, 1])
    yield absolute(f"height of the dip, {at}", dip_y, 4.85, 0.1, FIGURE, "m")
    yield absolute(f"position of the dip, {at}", dip_x, 5.8, 0.1, FIGURE, "m")
    change = outcome.volume_change
    yield vanishing(f"change of the volume, {at}", change, 0.02, "elastic strain is small")


def solve(model: Model) -> Outcome:
    """Runs a collapse to its end; returns its outcome."""
    points = march(model).state.points
    order = np.argsort(points.point_id)
    return Outcome(
        initial=np.round(initial_position(points)[order], 9),
        final=points.position[order],
        upper_corner=(points.position + points.half_length)[order],
        volume_change=float(points.volume.sum() / points.initial_volume.sum() - 1.0),
    )


def _by_origin(position: Floats) -> npt.NDArray[np.intp]:
    """Returns the order by initial position, y first, to round-off."""
    return np.lexsort(np.round(position, 6).T)
