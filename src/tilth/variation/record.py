# SPDX-License-Identifier: BSD-3-Clause
"""Records of ground acceleration over time, and the velocity that they lead to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model import GroundAcceleration
from tilth.model.fields import AXES
from tilth.variation.csv_file import read_csv

LARGEST_DRIFT = 0.02
"""Velocity at the end of a record over its greatest one, above which its baseline is off."""


@dataclass(frozen=True)
class Record:
    """An acceleration of the ground that starts from rest, linear between its times, then zero.

    Attributes:
        time: increasing, the first one 0 [time], shape (n,).
        acceleration: at these times [length/time^2], shape (n, dim).
        velocity: its integral [length/time], shape (n, dim).
    """

    time: Floats
    acceleration: Floats
    velocity: Floats

    @classmethod
    def of(cls, time: Floats, acceleration: Floats) -> Record:
        """Returns the record of accelerations at increasing times from 0."""
        steps = np.diff(time)[:, None] * 0.5 * (acceleration[1:] + acceleration[:-1])
        first = np.zeros((1, acceleration.shape[1]))
        return cls(time, acceleration, np.concatenate([first, np.cumsum(steps, axis=0)]))

    def acceleration_at(self, time: float) -> Floats:
        """Returns the acceleration at a time [length/time^2], shape (dim,)."""
        if time > self.time[-1]:
            return np.zeros(self.acceleration.shape[1])
        return np.array([np.interp(time, self.time, column) for column in self.acceleration.T])

    def velocity_at(self, time: float) -> Floats:
        """Returns the velocity at a time [length/time], shape (dim,)."""
        if time >= self.time[-1]:
            return np.array(self.velocity[-1])
        i = max(int(np.searchsorted(self.time, time, side="right")) - 1, 0)
        mean = 0.5 * (self.acceleration[i] + self.acceleration_at(time))
        return np.asarray(self.velocity[i] + (time - self.time[i]) * mean)

    def drift(self) -> str:
        """Returns a warning if the ground goes on moving after the record; else an empty text."""
        last = np.abs(self.velocity[-1]).max()
        greatest = np.abs(self.velocity).max()
        if last <= LARGEST_DRIFT * greatest:
            return ""
        steps = np.diff(self.time)[:, None] * 0.5 * (self.velocity[1:] + self.velocity[:-1])
        way = np.abs(steps.sum(axis=0)).max()
        return (
            f"the record ends with a velocity of {last:.3g}, {last / greatest:.0%} of its greatest "
            f"one, and a displacement of about {way:.3g}: the base goes on moving. Its baseline "
            "may need a correction"
        )


def read_record(declared: GroundAcceleration, dimension: int, key: str) -> Record:
    """Reads a record: a line with "time" and names of axes, then a row for each time.

    key: of the entry in the case file, for messages.

    Raises:
        BadInput: the file cannot be read, has other columns, or times that do not increase from 0.
    """
    known, where = AXES[:dimension], f"{key}.file"

    def accepted(names: list[str]) -> bool:
        axes = {name for name in names[1:] if name in known}
        return names[0] == "time" and bool(axes) and len(axes) == len(names) - 1

    def refused(problem: str, remedy: str) -> BadInput:
        return BadInput(problem, remedy, key=where, value=declared.file)

    example = ",".join(("time", *known))
    names, table = read_csv(declared.file, where, example, "each time", accepted)
    time = np.ascontiguousarray(table[:, 0])
    if len(time) < 2 or time[0] != 0.0:
        problem = f"begins with time {time[0]:g}" if len(time) > 1 else "has a single row"
        raise refused(problem, "give at least two rows, the first one for time 0")
    if (wrong := np.flatnonzero(np.diff(time) <= 0.0)).size:
        before, after = time[wrong[0]], time[wrong[0] + 1]
        row = f"row {wrong[0] + 2} below the names"
        raise refused(f"{row}: the time {after:g} follows {before:g}", "sort the rows by time")
    acceleration = np.zeros((len(time), dimension))
    for name, column in zip(names[1:], table[:, 1:].T, strict=True):
        acceleration[:, AXES.index(name)] = declared.scale * column
    return Record.of(time, acceleration)
