# SPDX-License-Identifier: BSD-3-Clause
"""Charts of a page, which it draws itself: axes, lines, and what marks places in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.blocks import Table
from tilth.report.explorer.packing import Blobs
from tilth.report.stage_marks import Span

MOST_ROWS = 4000
"""Points of a line, at most; of more, some are left out evenly."""
_ROWS_OF_TABLE = 12

CURVE, WARNING = 0, 1
"""Numbers of colours of the style sheet: of a single line, and of what needs attention."""


@dataclass(frozen=True, eq=False)
class Line:
    """Points (n,) each, joined in their order; what is not finite is a gap."""

    x: Floats
    y: Floats
    label: str = ""
    """In the legend; none if empty."""
    colour: int = CURVE
    """Number of a colour of the style sheet."""
    kind: str = "line"
    """line, dots, crosses, squares or rings alone, stems from zero, bars with their edges (n + 1,)
    in ``x``, or a band up to ``upper``."""
    dash: Sequence[int] = ()
    """Lengths of strokes and gaps [pixel]."""
    width: float = 1.6
    """[pixel]"""
    upper: Floats | None = None


@dataclass(frozen=True, eq=False)
class Chart:
    """A panel with labelled axes."""

    name: str
    """What it shows, for those who do not see it."""
    x: str
    """Label of an axis, with its unit."""
    y: str
    lines: Sequence[Line]
    logarithmic: bool = False
    """Whether the second axis is."""
    whole: str = ""
    """Axes, x, y or xy, whose labels are whole numbers."""
    limits: tuple[float | None, float | None] = (None, None)
    """Of the second axis, where they are not those of the lines."""
    stages: Sequence[Span] = ()
    """By the first axis."""
    upright: Sequence[tuple[float, int]] = ()
    """Places of thin lines on the first axis, and their colours."""
    across: Sequence[float] = ()
    """Places of thin lines on the second axis."""
    span: tuple[float, float] | None = None
    """Part of the first axis that is shaded."""
    words: Sequence[tuple[float, float, str]] = ()
    """Words beside places."""

    def packed(self, blobs: Blobs) -> dict[str, Any]:
        """Returns the description for the page; ``blobs`` take the numbers of the lines."""
        lines = []
        for line in self.lines:
            own = {
                "label": line.label,
                "colour": line.colour,
                "kind": line.kind,
                "dash": list(line.dash),
                "width": line.width,
            }
            columns = {"x": line.x, "y": line.y, "upper": line.upper}
            own |= {k: blobs.exact(fewer(v), "<f8") for k, v in columns.items() if v is not None}
            lines.append(own)
        known = {
            k: v for k, v in vars(self).items() if k != "lines" and v not in ((), None, False, "")
        }
        return known | {"lines": lines}


def fewer(values: Floats) -> Floats:
    """Returns at most about `MOST_ROWS` of values, with the first and the last one."""
    values = np.asarray(values, dtype=np.float64)
    every = -(-len(values) // MOST_ROWS)
    if every <= 1:
        return values
    return np.append(values[:-1:every], values[-1])


def numbers_table(columns: Mapping[str, Floats], summary: str) -> Table:
    """Returns a few rows of columns (n,) of equal length, with the first and the last one."""
    count = min(len(values) for values in columns.values())
    most = min(count, _ROWS_OF_TABLE)
    chosen = np.unique(np.round(np.linspace(0, max(count - 1, 0), most)).astype(int))
    rows = [[number(float(values[row])) for values in columns.values()] for row in chosen]
    return Table(rows, list(columns), summary)


def number(value: float) -> str:
    """Returns a number in six digits, a dash where it is not finite."""
    return f"{value:.6g}" if np.isfinite(value) else "\N{EN DASH}"
