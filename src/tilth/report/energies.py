# SPDX-License-Identifier: BSD-3-Clause
"""Energies of a run with inertia: where the work and the energy at the start went."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tilth.arrays import Floats
from tilth.output.history import FIRST_COLUMNS, OF_STAGES
from tilth.report.blocks import Table
from tilth.report.charts import Chart, Line
from tilth.report.fields import with_unit
from tilth.report.stage_marks import Span

WORK, NUMERICAL = "external_work", "numerical_dissipation"
_STYLES: dict[str, tuple[str, int, tuple[int, ...]]] = {
    "kinetic": ("kinetic", 1, ()),
    "elastic": ("elastic", 0, ()),
    "plastic_dissipation": ("dissipated by plasticity", 2, ()),
    "friction_dissipation": ("dissipated by friction", 3, ()),
    "damping_dissipation": ("dissipated by damping", 4, ()),
    "radiation": ("left through absorbing boundaries", 5, ()),
    NUMERICAL: ("numerical", 6, (6, 3)),
}
"""Name, number of the colour and dashes [pixel] of each kind of energy."""

_STATED: dict[str, tuple[str, int, tuple[int, ...]]] = {
    "time_integration": ("of the time integration", 7, (2, 3)),
    "stabilisation": ("of ghost stabilisation", 4, (6, 2, 2, 2)),
    "contact_gaps": ("of contact that closes or opens", 3, (6, 3)),
}
"""The same of what is numerical, of each kind that has a formula of its own."""

_GIVEN = ("at the start, and work since", 7)

_LEAST = 1e-12
"""Share of the greatest energy below which a kind is left out."""


def energies_of(table: Mapping[str, Floats]) -> tuple[dict[str, Floats], str]:
    """Returns the columns of energies.csv by kind, and the label of their unit."""
    names = [name for name in table if name not in (*FIRST_COLUMNS, *OF_STAGES)]
    unit = names[0].partition(" [")[2].rstrip("]") if names else ""
    return {name.partition(" [")[0]: table[name] for name in names}, unit


def _parts(energies: Mapping[str, Floats]) -> dict[str, Floats]:
    """Returns the kinds into which the energy went that are not negligible."""
    greatest = max(float(np.abs(each).max()) for each in energies.values())
    return {
        kind: energies[kind]
        for kind in _STYLES
        if kind == NUMERICAL or float(np.abs(energies[kind]).max()) > _LEAST * greatest
    }


def _given(energies: Mapping[str, Floats]) -> Floats:
    """Returns the energy at the start and the work since then, (rows,): the sum of all parts."""
    first = sum(float(energies[kind][0]) for kind in _STYLES)
    return np.asarray(first + energies[WORK])


def energy_charts(
    table: Mapping[str, Floats], time_unit: str, stages: Sequence[Span] = ()
) -> list[Chart]:
    """Returns charts of all energies and of what is numerical over time; none without any energy.

    table: columns of energies.csv. stages: those of the run by their total times.
    """
    energies, unit = energies_of(table)
    if not any(each.any() for each in energies.values()):
        return []
    time, greatest, label = table["time"], _greatest(energies), with_unit("time", time_unit)
    text, colour = _GIVEN
    lines = [Line(time, _given(energies), text, colour, width=2.6)]
    for kind, values in _parts(energies).items():
        text, colour, dash = _STYLES[kind]
        lines.append(Line(time, values, text, colour, dash=dash))
    share = [Line(time, 100.0 * energies[NUMERICAL] / greatest, "all", _STYLES[NUMERICAL][1])]
    for kind in _stated(energies):
        text, colour, dash = _STATED[kind]
        share.append(Line(time, 100.0 * energies[kind] / greatest, text, colour, dash=dash))
    numerical = "numerical, % of the greatest energy"
    return [
        Chart("Energies over time", label, with_unit("energy", unit), lines, stages=stages),
        Chart("Numerical energy over time", label, numerical, share, stages=stages),
    ]


def _stated(energies: Mapping[str, Floats]) -> list[str]:
    """Returns the kinds of what is numerical that are not negligible; older runs lack some."""
    least = _LEAST * _greatest(energies)
    return [k for k in _STATED if k in energies and float(np.abs(energies[k]).max()) > least]


def _greatest(energies: Mapping[str, Floats]) -> float:
    """Returns the greatest energy of any kind at any time."""
    return max(float(np.abs(each).max()) for each in (*energies.values(), _given(energies)))


def energy_table(table: Mapping[str, Floats]) -> Table:
    """Returns a table of the balance after the last step.

    table: columns of energies.csv.
    """
    energies, unit = energies_of(table)
    given, greatest = _given(energies), _greatest(energies)
    rows = [("at the start", given[0] - energies[WORK][0]), ("work since", energies[WORK][-1])]
    rows.append(("sum", given[-1]))
    parts = _parts(energies)
    rows += [(_STYLES[kind][0], values[-1]) for kind, values in parts.items()]
    rows.append(("sum", sum(float(energies[kind][-1]) for kind in _STYLES)))
    stated = {f"of what is numerical, that {_STATED[k][0]}": energies[k] for k in _stated(energies)}
    rows += [(name, values[-1]) for name, values in stated.items()]
    head = with_unit("energy after the last step", unit)
    cells = [[n, f"{value:.5g}", f"{100.0 * value / greatest:.3g} %"] for n, value in rows]
    return Table(cells, ["", head, "of the greatest energy"])
