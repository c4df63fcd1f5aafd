# SPDX-License-Identifier: BSD-3-Clause
"""Energies of a run with inertia: where the work and the energy at the start went."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Floats
from tilth.output.history import FIRST_COLUMNS, OF_STAGES
from tilth.report.fields import with_unit
from tilth.report.stage_marks import Span, mark_stages, room_for_names
from tilth.report.texts import AS_IT_IS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WORK, NUMERICAL = "external_work", "numerical_dissipation"
_STYLES = {
    "kinetic": ("kinetic", "#c1121f", "-"),
    "elastic": ("elastic", "#1d3557", "-"),
    "plastic_dissipation": ("dissipated by plasticity", "#b5651d", "-"),
    "friction_dissipation": ("dissipated by friction", "#6a4c93", "-"),
    "damping_dissipation": ("dissipated by damping", "#2a6f4e", "-"),
    "radiation": ("left through absorbing boundaries", "#118ab2", "-"),
    NUMERICAL: ("numerical", "#777777", "--"),
}
"""Name, colour and line of each kind of energy."""

_STATED = {
    "time_integration": ("of the time integration", "#222222", ":"),
    "stabilisation": ("of ghost stabilisation", "#2a6f4e", "-."),
    "contact_gaps": ("of contact that closes or opens", "#6a4c93", "--"),
}
"""The same of what is numerical, of each kind that has a formula of its own."""

_LEAST = 1e-12
"""Share of the greatest energy below which a kind is left out."""
_WIDTH = 4.2


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


def draw_energies(
    table: Mapping[str, Floats], time_unit: str, stages: Sequence[Span] = ()
) -> Figure | None:
    """Returns plots of all energies and of what is numerical over time; None without any energy.

    table: columns of energies.csv. stages: those of the run by their total times.
    """
    from matplotlib.figure import Figure

    energies, unit = energies_of(table)
    if not any(each.any() for each in energies.values()):
        return None
    height = 3.6 + room_for_names(stages, _WIDTH)
    figure = Figure(figsize=(9.6, height), layout="constrained")
    left, right = figure.subplots(1, 2)
    time, given, parts = table["time"], _given(energies), _parts(energies)
    left.plot(time, given, color="black", linewidth=2.2, label="at the start, and work since")
    for kind, values in parts.items():
        label, colour, line = _STYLES[kind]
        left.plot(time, values, color=colour, linestyle=line, linewidth=1.3, label=label)
    left.set_ylabel(with_unit("energy", unit), fontsize=9, **AS_IT_IS)
    left.legend(fontsize=7, framealpha=0.9)
    greatest = _greatest(energies)
    share = 100.0 * energies[NUMERICAL] / greatest
    right.plot(time, share, color=_STYLES[NUMERICAL][1], linewidth=1.3, label="all")
    for kind in _stated(energies):
        label, colour, line = _STATED[kind]
        part = 100.0 * energies[kind] / greatest
        right.plot(time, part, color=colour, linestyle=line, linewidth=1.3, label=label)
        right.legend(fontsize=7, framealpha=0.9)
    right.set_ylabel("numerical, % of the greatest energy", fontsize=9)
    for axes in (left, right):
        mark_stages(axes, stages, _WIDTH)
        axes.set_xlabel(with_unit("time", time_unit), fontsize=9, **AS_IT_IS)
        axes.tick_params(labelsize=8)
        axes.ticklabel_format(axis="y", scilimits=(-3, 5))
        axes.grid(color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)
    return figure


def _stated(energies: Mapping[str, Floats]) -> list[str]:
    """Returns the kinds of what is numerical that are not negligible; older runs lack some."""
    least = _LEAST * _greatest(energies)
    return [k for k in _STATED if k in energies and float(np.abs(energies[k]).max()) > least]


def _greatest(energies: Mapping[str, Floats]) -> float:
    """Returns the greatest energy of any kind at any time."""
    return max(float(np.abs(each).max()) for each in (*energies.values(), _given(energies)))


def energy_table(table: Mapping[str, Floats]) -> str:
    """Returns an HTML table of the balance after the last step.

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
    body = "".join(
        f"<tr><th>{escape(name)}</th><td>{value:.5g}</td><td>{100.0 * value / greatest:.3g} %</td>"
        "</tr>"
        for name, value in rows
    )
    head = escape(with_unit("energy after the last step", unit))
    share = "of the greatest energy"
    return f"<table><tr><th></th><th>{head}</th><th>{share}</th></tr>{body}</table>"
