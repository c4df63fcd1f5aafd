# SPDX-License-Identifier: BSD-3-Clause
"""A model with another load curve from a moment of its schedule on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from tilth.errors import BadInput
from tilth.model import Model
from tilth.model.load_curve import LoadCurve
from tilth.model.problems import unknown_name
from tilth.model.rigid_bodies import RigidBody
from tilth.model.staging import BOUNDARIES, moves

LISTS = ("loads", "boundaries", "rigid_bodies")

Curves = dict[str, tuple[str, int, str]]
"""List of the model, place in it, and key of the table of factors, by the name of its owner."""


def curves_of(model: Model, force: bool = False) -> Curves:
    """Returns where the load curves of a model are, of all loads with names and all motions.

    force: those of the forces on rigid bodies instead of their motions.
    """
    return {item.name: (key, i, table) for key, i, item, table in _curves(model, force)}


def _curves(model: Model, force: bool) -> Iterator[tuple[str, int, Any, str]]:
    for key in LISTS:
        for i, item in enumerate(getattr(model, key)):
            if isinstance(item, RigidBody):
                if item.has_force_numbers if force else item.has_motion_numbers:
                    yield key, i, item, "force_factor" if force else "factor"
            elif not force and item.name and (not isinstance(item, BOUNDARIES) or moves(item)):
                yield key, i, item, "factor"


def curve_of(model: Model, name: str, force: bool = False) -> LoadCurve:
    """Returns how a load, a moving boundary or a rigid body goes on; force: see `curves_of`.

    Raises:
        BadInput: there is none of this name.
    """
    key, i, table = _place(model, name, force)
    item = getattr(model, key)[i]
    return LoadCurve(getattr(item, table) or ((0.0, 0.0), (model.schedule.end, 1.0)))


def _place(model: Model, name: str, force: bool) -> tuple[str, int, str]:
    known = curves_of(model, force)
    if name not in known:
        what = "rigid body with a force" if force else "load, moving boundary or rigid body"
        raise BadInput(*unknown_name(what, name, known), key="name", value=name)
    return known[name]


def with_factors(
    model: Model, name: str, time: float, rows: Sequence[Sequence[float]], force: bool = False
) -> Model:
    """Returns a model without stages in which a factor goes on by other rows from a time on.

    Args:
        model: the declared problem.
        name: of a load, a moving boundary or a rigid body.
        time: from which on; the factor at this time is kept.
        rows: (time, factor [-]), later than `time` and ascending.
        force: see `curves_of`.

    Raises:
        BadInput: there is no such name, the rows are wrong, or the model has stages.
    """
    if model.stages:
        what = "the load of a model with stages cannot be changed between two steps"
        raise BadInput(what, "give its factors in the stage", key="name", value=name)
    key, i, table = _place(model, name, force)
    curve = curve_of(model, name, force)
    kept = [tuple(row) for row in curve.table if row[0] < time]
    items = list(getattr(model, key))
    try:
        later = [(float(row[0]), float(row[1])) for row in rows if len(row) == 2]
    except (TypeError, ValueError):
        later = []
    if not later or len(later) != len(rows) or not later[0][0] > time:
        raise BadInput(
            f"are not rows (time, factor) that begin after the present time {time:.6g}",
            f"give them such as [({model.schedule.end:.6g}, 1.0)]",
            key="rows",
            value=rows,
        )
    items[i] = items[i].model_copy(update={table: (*kept, (time, curve.factor(time)), *later)})
    return model.model_copy(update={key: tuple(items)})
