# SPDX-License-Identifier: BSD-3-Clause
"""Where lines enter and leave soil through a tracked surface: a spline, or triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.surface.protocol import BodySurface

LINES_PER_BATCH = 1 << 12
"""Lines whose crossings are computed together; it bounds the memory."""
MOST_PARTS = 64
"""A line's window is searched in at most so many parts."""
SAME_DISTANCE = 1e-9
"""Crossings of a line nearer than this, relative to the window's length, are one: on an edge."""


@dataclass(frozen=True)
class Window:
    """The part of each line that is searched: distances from -behind (n,) to reach [length].

    Domains are wider across the line by the share `widening` [-].
    """

    behind: Floats
    reach: float
    widening: float

    def of(self, chosen: Flags | Integers | slice) -> Window:
        """Returns the window of the `chosen` lines."""
        return Window(np.ascontiguousarray(self.behind[chosen]), self.reach, self.widening)

    @property
    def middle(self) -> Floats:
        """Distances of the middles [length], shape (n,)."""
        return 0.5 * (self.reach - self.behind)

    @property
    def half_length(self) -> Floats:
        """Half of the lengths [length], shape (n,)."""
        return 0.5 * (self.reach + self.behind)


@dataclass(frozen=True)
class AlongLines:
    """What n lines meet in their windows.

    Attributes:
        entry: least distance at which the line enters soil [length], shape (n,); inf if none.
        crossed: whether it crosses the surface at all, shape (n,).
        inside: whether its point at distance 0 is in soil, shape (n,); only where `crossed`.
        folded: whether it enters twice without leaving, or leaves twice, shape (n,).
    """

    entry: Floats
    crossed: Flags
    inside: Flags
    folded: Flags


class SoilSurface(Protocol):
    """A tracked surface that lines can cross."""

    def cross(self, position: Floats, normal: Floats, window: Window) -> AlongLines:
        """Returns what the lines through positions (n, dim) along unit normals (n, dim) meet."""
        ...

    def contains(self, position: Floats) -> Flags | None:
        """Returns which positions (n, dim) are in the soil, shape (n,); None if it is open."""
        ...


def soil_surface(surface: BodySurface) -> SoilSurface | None:
    """Returns the surface for `measure_gap`; None where the domains are to be used instead.

    That is so for a curve that crosses or touches itself, and for one through material points.
    """
    # imported only where needed: they import much of the package
    from tilth.boundaries.surfaces.spline_crossings import SplineSurface
    from tilth.boundaries.surfaces.triangle_crossings import TriangleSurface
    from tilth.curves.crossing import find_crossings
    from tilth.surface.tracked import TrackedSurface
    from tilth.surface.tracked_triangles import TrackedSolidSurface

    if isinstance(surface, TrackedSurface):
        if any(len(chain.point_id) for chain in surface.chains):
            return None
        chains = [chain.current for chain in surface.chains]
        return None if len(find_crossings(chains)) else SplineSurface(chains)
    assert isinstance(surface, TrackedSolidSurface)
    return TriangleSurface(surface.triangles.current)


def summarised(lines: int, line: Integers, at: Floats, sign: Floats, window: Window) -> AlongLines:
    """Returns what lines meet, from their crossings in any order.

    Args:
        lines: number of lines.
        line: number of each crossing's line, shape (m,).
        at: its distance along the line [length], shape (m,).
        sign: > 0 where the line enters soil, shape (m,).
        window: of the lines.
    """
    kept = (at > -window.behind[line]) & (at < window.reach) & (sign != 0.0)
    order = np.lexsort((at[kept], line[kept]))
    line, at, enters = line[kept][order], at[kept][order], sign[kept][order] > 0.0
    again = np.zeros(len(line), dtype=bool)
    near = SAME_DISTANCE * 2.0 * window.half_length[line[1:]]
    again[1:] = (line[1:] == line[:-1]) & (enters[1:] == enters[:-1])
    distinct = np.append(True, ~(again[1:] & (np.diff(at) <= near)))[: len(line)]
    line, at, enters, again = line[distinct], at[distinct], enters[distinct], again[distinct]
    entry = np.full(lines, np.inf)
    np.minimum.at(entry, line[enters], at[enters])
    crossed, folded, inside = (np.zeros(lines, dtype=bool) for _ in range(3))
    crossed[line] = True
    folded[line[again]] = True
    # the last crossing up to 0 decides, without one the first beyond
    first_ahead = np.append(True, line[1:] != line[:-1])[: len(line)] & (at > 0.0)
    inside[line[first_ahead]] = ~enters[first_ahead]
    before = at <= 0.0
    inside[line[before]] = enters[before]  # in ascending order: the last one counts
    return AlongLines(entry, crossed, inside, folded)


def joined(parts: list[AlongLines]) -> AlongLines:
    """Returns what the lines of all parts meet, one part after the other."""
    names = ("entry", "crossed", "inside", "folded")
    empty = np.zeros(0)
    return AlongLines(
        *(
            np.concatenate([empty.astype(bool if i else float), *(getattr(p, n) for p in parts)])
            for i, n in enumerate(names)
        )
    )


def candidate_pairs(
    centre: Floats, radius: Floats, position: Floats, normal: Floats, window: Window
) -> tuple[Integers, Integers]:
    """Returns pairs (line, piece) of which the line may cross the piece, (m,) each; some twice.

    Args:
        centre, radius: balls around the pieces of a surface [length], (k, dim) and (k,).
        position, normal: of the lines, shape (n, dim) each.
        window: of the lines.
    """
    from scipy.spatial import cKDTree

    largest = float(radius.max())
    half = float(window.half_length.max(initial=0.0))
    parts = min(max(int(np.ceil(half / largest)), 1), MOST_PARTS)
    # balls around equal parts of the lines, compared with those of the pieces
    share = (2.0 * np.arange(parts) + 1.0) / parts - 1.0
    along = window.middle[:, None] + window.half_length[:, None] * share
    ball = (position[:, None] + along[..., None] * normal[:, None]).reshape(-1, position.shape[1])
    reach = (half / parts + largest) * (1.0 + SAME_DISTANCE)
    pairs = cKDTree(ball).sparse_distance_matrix(cKDTree(centre), reach, output_type="ndarray")
    line, piece = pairs["i"] // parts, pairs["j"]
    offset = centre[piece] - position[line]
    across = offset - (offset * normal[line]).sum(axis=1)[:, None] * normal[line]
    near = (across**2).sum(axis=1) <= (radius[piece] * (1.0 + SAME_DISTANCE)) ** 2
    return line[near].astype(np.int64), piece[near].astype(np.int64)
