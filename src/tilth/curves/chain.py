# SPDX-License-Identifier: BSD-3-Clause
"""Chain of boundary points in the plane, with the soil on its left; angles between its chords."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats, Integers

# Neighbours coincide if their distance is below this many machine epsilons times the largest
# coordinate.
COINCIDENCE_EPSILONS = 16.0
# Largest number of points or triangles that a message lists.
MAXIMUM_LISTED = 5


class BadSurface(ValueError):
    """A chain of points that defines no curve, or triangles that define no surface.

    Attributes:
        problem: what is wrong.
        remedy: how to correct it.
        numbers: numbers of the points or triangles concerned, counted from 0.
    """

    def __init__(self, problem: str, remedy: str, numbers: Iterable[int] = ()) -> None:
        super().__init__(problem, remedy)
        self.problem = problem
        self.remedy = remedy
        self.numbers = tuple(int(number) for number in numbers)

    def __str__(self) -> str:
        return f"{self.problem}\n  {self.remedy}"


class Chain:
    """Points in order, joined by chords, with the soil on the left along the chain.

    Chord i leads from point i to the next one; that of the last point of a closed chain leads
    back to point 0. An open chain has one chord less than points.

    Args:
        points: [length], shape (n, 2), each different from the one before it.
        closed: whether the last point is joined to the first. The soil is inside an anticlockwise
            chain, and outside a clockwise one (a hole).
        corner: which points are corners, shape (n,); none if not given. The ends of an open
            chain are always ends of the curve, whether flagged or not.

    Raises:
        BadSurface: too few points, repeated ones, or coordinates that are not numbers.
    """

    def __init__(self, points: npt.ArrayLike, closed: bool, corner: Flags | None = None) -> None:
        self.points: Floats = np.array(points, dtype=np.float64)
        self.closed = bool(closed)
        if self.points.ndim != 2 or self.points.shape[1] != 2:
            raise BadSurface(
                f"points of shape {self.points.shape}", "give two coordinates for each point"
            )
        n = len(self.points)
        self.corner: Flags = np.zeros(n, bool) if corner is None else np.array(corner, dtype=bool)
        if self.corner.shape != (n,):
            raise BadSurface(
                f"{len(self.corner)} corner flags for {n} points", "give one flag for each point"
            )
        least, kind = (3, "closed") if closed else (2, "open")
        if n < least:
            raise BadSurface(
                f"{n} points are too few for a chain that is {kind}",
                f"give at least {least} points",
                range(n),
            )
        wrong = np.flatnonzero(~np.isfinite(self.points).all(axis=1))
        if len(wrong):
            raise BadSurface(
                f"coordinates of points {listed(wrong)} are not numbers",
                "give finite numbers",
                wrong,
            )
        tolerance = COINCIDENCE_EPSILONS * np.finfo(float).eps * float(np.abs(self.points).max())
        first = np.flatnonzero(np.linalg.norm(self.chord, axis=1) <= tolerance)
        if len(first):
            both = np.unique(np.concatenate([first, (first + 1) % n]))
            raise BadSurface(
                f"neighbours in the chain are the same point: points {listed(both)}",
                "give each point once; a closed chain does not repeat its first point at the end",
                both,
            )

    def __len__(self) -> int:
        return len(self.points)

    @property
    def chord(self) -> Floats:
        """Vectors from each point to the next [length], shape (chords, 2)."""
        ahead = np.roll(self.points, -1, axis=0) - self.points
        return ahead if self.closed else ahead[:-1]

    @property
    def ends(self) -> Flags:
        """Which points end a smooth curve: corners and the ends of an open chain, shape (n,)."""
        ends = self.corner.copy()
        if not self.closed:
            ends[[0, -1]] = True
        return ends

    def require_closed(self, purpose: str) -> None:
        """Raises BadSurface if the chain is open; its message names the purpose."""
        if not self.closed:
            last = len(self) - 1
            raise BadSurface(
                f"{purpose} needs a closed chain; this one is open between points {last} and 0",
                "close the chain",
                (last, 0),
            )


def sharp_corners(points: Floats, closed: bool, angle: float) -> Flags:
    """Returns at which points (n, 2) the chords turn by more than `angle` [degrees], shape (n,).

    The ends of an open chain are none.
    """
    ahead = np.roll(points, -1, axis=0) - points
    sharp = np.abs(turning_angle(np.roll(ahead, 1, axis=0), ahead)) > np.radians(angle)
    if not closed:
        sharp[[0, -1]] = False
    return np.asarray(sharp)


def turning_angle(before: Floats, after: Floats) -> Floats:
    """Returns the angles from vectors `before` to `after` (n, 2) [rad], > 0 to the left, (n,)."""
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(np.arctan2(cross, (before * after).sum(axis=1)))


def listed(numbers: Integers) -> str:
    """Returns the first numbers as text, up to `MAXIMUM_LISTED`, and how many more there are."""
    more = f" and {len(numbers) - MAXIMUM_LISTED} more" if len(numbers) > MAXIMUM_LISTED else ""
    return f"{', '.join(str(number) for number in numbers[:MAXIMUM_LISTED])}{more}"
