# SPDX-License-Identifier: BSD-3-Clause
"""Which fields the page shows, and the columns of results that they are computed from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.output.snapshot import Snapshot
from tilth.report.fields import AXES, TENSOR, field_values

NOT_SHOWN = ("domain", "domain_corners")
_LAST = ("volume", "deformation_gradient")


@dataclass(frozen=True)
class Shown:
    """A field in the list of the page."""

    name: str
    """As ``output.colour_by`` takes it."""
    title: str
    """Full name with its unit."""
    operation: str
    """``value`` of one column, or ``magnitude``, ``mean``, ``von_mises`` of several."""
    columns: tuple[tuple[str, int], ...]
    """Point field and number of its component, in the order of the operation."""


def shown_fields(snapshot: Snapshot, units: Mapping[str, str], first: str) -> list[Shown]:
    """Returns all fields of an output, those of the field ``first`` at the front.

    In the plane components that are zero by definition are left out.
    """
    found = []
    for field, values in snapshot.point_fields.items():
        if field not in NOT_SHOWN:
            found += _of_field(snapshot, field, np.asarray(values), units)
    order = {"displacement": 1, "cauchy_stress": 2, "plastic_strain": 3}

    def rank(shown: Shown) -> tuple[bool, int]:
        field = shown.columns[0][0]
        of_first = first == field or first.startswith(f"{field}_")
        return not of_first, 9 if field in _LAST else order.get(field, 4)

    return sorted(found, key=rank)


def columns_of(fields: Sequence[Shown]) -> list[tuple[str, int]]:
    """Returns every column that one of the fields needs, once, in their order."""
    return list(dict.fromkeys(column for shown in fields for column in shown.columns))


def column_values(snapshot: Snapshot, column: tuple[str, int]) -> Floats:
    """Returns one component of a point field as numbers, shape (n,); NaN if it is absent."""
    field, component = column
    n = len(snapshot.position)
    if field not in snapshot.point_fields:
        return np.full(n, np.nan)
    values = np.asarray(snapshot.point_fields[field], dtype=np.float64)
    return np.asarray(values.reshape(n, -1)[:, component])


def _of_field(snapshot: Snapshot, field: str, values: Any, units: Mapping[str, str]) -> list[Shown]:
    plane = snapshot.dim == 2
    parts: list[tuple[str, str, tuple[int, ...]]]
    if values.ndim == 1:
        parts = [("", "value", (0,))]
    elif values.ndim == 2 and values.shape[1] == 6:
        every = tuple(range(6))
        some = range(4) if plane else range(6)
        parts = [("_von_mises", "von_mises", every), ("_mean", "mean", (0, 1, 2))]
        parts += [(f"_{TENSOR[k]}", "value", (k,)) for k in some]
        if plane:
            parts[0] = ("_von_mises", "von_mises", (0, 1, 2, 3))
    elif values.ndim == 2:
        count = values.shape[1]
        parts = [("", "magnitude", tuple(range(count)))]
        parts += [(f"_{axis}", "value", (k,)) for k, axis in enumerate(AXES[:count])]
    else:
        pairs = [(i, j) for i in range(3) for j in range(3)]
        parts = [(f"_{AXES[i]}{AXES[j]}", "value", (3 * i + j,)) for i, j in pairs]
    return [
        Shown(
            name=field + suffix,
            title=field_values(snapshot, field + suffix, units)[1],
            operation=operation,
            columns=tuple((field, k) for k in components),
        )
        for suffix, operation, components in parts
    ]
