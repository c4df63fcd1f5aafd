# SPDX-License-Identifier: BSD-3-Clause
"""Names and times that a user gives, found in results, or refused with those that are near."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches

import numpy as np

from tilth.errors import BadInput, shown
from tilth.output.snapshot import Snapshot
from tilth.output.vtkhdf import Results
from tilth.report.fields import AXES, TENSOR

_NAMED = 12
"""Names that a message lists, at most."""


def output_at(results: Results, time: float | None) -> int:
    """Returns the number of the output at a time, of the last one for None.

    Raises ``BadInput`` with the times of the outputs where there is none at that time.
    """
    if time is None:
        return len(results) - 1
    times = np.asarray(results.times)
    near = int(np.abs(times - time).argmin())
    if abs(times[near] - time) <= 1e-6 * max(float(times[-1] - times[0]), abs(time), 1e-300):
        return near
    around = np.sort(np.argsort(np.abs(times - time), kind="stable")[:_NAMED])
    raise BadInput(
        "is not the time of an output",
        f"choose from {', '.join(f'{each:.6g}' for each in times[around])}",
        key="time",
        value=float(time),
    )


def field_names(snapshot: Snapshot) -> list[str]:
    """Returns the names of the scalar fields of a snapshot, for ``field_values``."""
    found: list[str] = []
    for name, values in snapshot.point_fields.items():
        if name == "domain_corners":
            continue
        if values.ndim < 2 or values.shape[1:] == (snapshot.dim,):
            found.append(name)
        if values.ndim == 2:
            tensor = values.shape[1] == len(TENSOR)
            parts = (*TENSOR, "mean", "von_mises") if tensor else AXES[: values.shape[1]]
            found += [f"{name}_{part}" for part in parts]
        elif values.ndim == 3:
            found += [f"{name}_{a}{b}" for a in AXES for b in AXES]
    return found


def require_field(snapshot: Snapshot, name: str) -> None:
    """Raises ``BadInput`` with near names if a snapshot has no such field."""
    if name not in (names := field_names(snapshot)):
        raise not_one_of(name, names, "field", "is not a field of the results")


def column_of(headings: Sequence[str], name: str) -> str:
    """Returns the heading of a history's column, by that or by its name without the unit.

    Raises ``BadInput`` with near names where there is none.
    """
    plain = [heading.split(" [")[0] for heading in headings]
    for names in (list(headings), plain):
        if name in names:
            return headings[names.index(name)]
    raise not_one_of(name, plain, "history", "is not a column of the history")


def not_one_of(name: str, names: Sequence[str], key: str, problem: str) -> BadInput:
    """Returns the error for a name that is none of ``names``; it lists those near it."""
    near = get_close_matches(name, names, _NAMED, 0.55)
    if near:
        remedy = f"did you mean {', '.join(near[:3])}?"
    else:
        more = ", ..." if len(names) > 4 * _NAMED else ""
        remedy = f"choose from {', '.join(shown(each) for each in names[: 4 * _NAMED])}{more}"
    return BadInput(problem, remedy, key=key, value=name)
