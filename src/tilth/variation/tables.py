# SPDX-License-Identifier: BSD-3-Clause
"""Tables of a value over one coordinate, linear between the rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput

ROUND_OFF = 1e-9
"""Share of a table's or a grid's extent by which a place may lie outside it."""


def place_text(components: Floats) -> str:
    """Returns a position or another vector (dim,) as a message writes it."""
    return "(" + ", ".join(f"{x:.6g}" for x in components) + ")"


def interpolate(
    rows: Sequence[Sequence[float]], at: Floats, position: Floats, what: str, key: str
) -> Floats:
    """Returns the values of a table at the coordinates `at`, shape (n,).

    Args:
        rows: (coordinate, value) with increasing coordinates.
        at: coordinates, shape (n,).
        position: of the points, shape (n, dim), for messages.
        what: name of the coordinate, for messages.
        key: of the table in the case file, for messages.

    Raises:
        BadInput: a coordinate outside the table, with the place of the point.
    """
    coordinate, value = np.array(rows, dtype=np.float64).T
    first, last = coordinate[0], coordinate[-1]
    tolerance = ROUND_OFF * (last - first)
    outside = np.flatnonzero((at < first - tolerance) | (at > last + tolerance))
    if len(outside):
        worst = outside[0]
        raise BadInput(
            f"the material point at {place_text(position[worst])} is outside the table: its "
            f"{what} is {at[worst]:.6g}, and the rows go from {first:.6g} to {last:.6g} "
            f"({len(outside)} of {len(at)} points are outside)",
            "add a row beyond it, with the same value where the value stays constant",
            key=key,
        )
    return np.asarray(np.interp(at, coordinate, value))
