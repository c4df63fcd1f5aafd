# SPDX-License-Identifier: BSD-3-Clause
"""Tables over time that go on after the end of the schedule, where nobody reads them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from tilth.model.load_curve import LoadCurve

if TYPE_CHECKING:
    from tilth.model import Model

Rows = Sequence[Sequence[float]]


def table_warnings(model: Model) -> Iterator[tuple[str, str]]:
    """Yields the tables whose values still change after the end of the schedule.

    Not in a model with stages: those of a stage are refused there, and a load's or a motion's own
    one may be meant for a longer stage than this.
    """
    if model.stage.declared is not None:
        return
    end = model.schedule.end
    for key, rows in _tables(model):
        value, last = LoadCurve(rows).factor(end), rows[-1][1]
        if all(row[1] == value for row in rows if row[0] > end):
            continue
        yield (
            f"rows of {key}",
            f"{key}: the rows go on to time {rows[-1][0]:g}, but the schedule ends at {end:g}, "
            f"where the value is {value:.4g} and not yet {last:.4g}; give schedule.end = "
            f"{rows[-1][0]:g}, or times up to {end:g}",
        )


def _tables(model: Model) -> Iterator[tuple[str, Rows]]:
    boundaries, bodies = model.boundary_keys(), model.rigid_body_keys()
    keyed: list[tuple[str, object]] = [
        *((f"loads[{i}]", load) for i, load in model.acting_loads()),
        *((boundaries[each.name], each) for each in model.boundaries),
        *((bodies[each.name], each) for each in model.rigid_bodies),
        ("water", model.water),
    ]
    if model.flow is not None:
        of_flow = model.flow_boundary_keys()
        keyed += [(of_flow[each.name], each) for each in model.flow.boundaries]
    for key, entry in keyed:
        for name in ("factor", "force_factor"):
            if rows := getattr(entry, name, None):
                yield f"{key}.{name}", rows
    for body in model.rigid_bodies:
        for name in ("displacement", "rotation", "force", "moment"):
            yield from _components(f"{bodies[body.name]}.{name}", getattr(body, name))


def _components(key: str, given: object) -> Iterator[tuple[str, Rows]]:
    """Yields the tables among the components of a motion or a force."""
    if isinstance(given, Mapping):
        for axis, value in given.items():
            yield from _components(f"{key}.{axis}", value)
    elif isinstance(given, Sequence):
        yield key, given
