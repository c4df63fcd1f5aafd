# SPDX-License-Identifier: BSD-3-Clause
"""Where soil went beyond a limit load: table, marks in plots over time, titles of pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.model.track import OF_RELAXATION
from tilth.report.blocks import Block, Paragraph, Table


@dataclass(frozen=True)
class Relaxed:
    """A relaxation: its number, total time, first and last step, and whether it ended at rest.

    share: largest kinetic energy over the work of loads and boundaries in it [-].
    """

    number: int
    time: float
    first: int
    last: int
    at_rest: bool
    share: float


def relaxations(history: Mapping[str, Floats]) -> list[Relaxed]:
    """Returns the relaxations of a run."""
    name, kinetic, worked = OF_RELAXATION
    if name not in history:
        return []
    energy, work = (
        next(values for heading, values in history.items() if heading.startswith(f"{each} ["))
        for each in (kinetic, worked)
    )
    number = np.asarray(history[name])
    begins = np.flatnonzero((number > 0.0) & (np.diff(number, prepend=0.0) != 0.0))
    found = []
    for first in begins:
        same = number[first:] == number[first]
        last = first + (len(same) if same.all() else int(np.argmin(same))) - 1
        done = float(work[last])
        share = float(energy[first : last + 1].max()) / done if done > 0.0 else 0.0
        begin, end = (int(history["step"][i]) for i in (first, last))
        time, at_rest = float(history["time"][first]), bool(energy[last] == 0.0)
        found.append(Relaxed(int(number[first]), time, begin, end, at_rest, share))
    return found


def relaxation_table(found: Sequence[Relaxed]) -> list[Block]:
    """Returns a table of all relaxations with an explanation."""
    heading = ("number", "time", "steps", "largest kinetic energy over the work", "end")
    rows = [
        (
            str(each.number),
            f"{each.time:.6g}",
            f"{each.first} to {each.last}",
            f"{100.0 * each.share:.2g} %",
            "at rest" if each.at_rest else "moving",
        )
        for each in found
    ]
    return [Paragraph(_ABOUT), Table(rows, heading)]


def after(found: Sequence[Relaxed], step: int) -> str:
    """Returns what the title of an output says of the relaxations up to its step."""
    count = sum(each.last <= step and each.at_rest for each in found)
    if any(each.first <= step <= each.last and not each.at_rest for each in found):
        return "in motion beyond the limit load"
    if count == 0:
        return ""
    return f"after {count} relaxation{'s' * (count > 1)}"


_ABOUT = """No equilibrium was near. There the soil moved with damped inertia, under a constant
load, until it was at rest; plots over time have a dotted red line. The smaller the kinetic energy,
the less do the places depend on the damping."""
