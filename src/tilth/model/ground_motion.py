# SPDX-License-Identifier: BSD-3-Clause
"""Ground motion at a base, and the ground beyond an absorbing boundary."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import FileName, Positive, Real
from tilth.model.problems import rejection


class GroundAcceleration(Declared):
    """A record of accelerations over time, linear between its rows and zero after the last one."""

    file: FileName
    """Path of the .csv file, relative to the case file. Its first line names the columns: "time",
    then one or more of "x", "y", "z", such as time,x,y; the times increase and begin with 0, which
    is the start of the stage in which the boundary begins to act."""
    scale: Real = 1.0
    """Factor on all accelerations, such as 9.81 for a record in parts of gravity; not 0."""

    @model_validator(mode="after")
    def _moves(self) -> Any:
        if self.scale == 0.0:
            what, remedy = "is zero: nothing moves", 'give another one, or condition = "fixed"'
            raise rejection([Problem("scale", what, remedy, self.scale)])
        return self


class Ground(Declared):
    """Elastic ground beyond an absorbing boundary."""

    density: Positive
    """Mass per volume [mass / length^3], > 0."""
    p_wave_speed: Positive
    """Speed of compression waves, sqrt(M / density) [length / time], > 0."""
    s_wave_speed: Positive
    """Speed of shear waves, sqrt(G / density) [length / time], > 0."""

    @model_validator(mode="after")
    def _possible(self) -> Any:
        least = (4.0 / 3.0) ** 0.5 * self.s_wave_speed
        if self.p_wave_speed <= least:
            what = f"needs a negative bulk modulus with s_wave_speed = {self.s_wave_speed:g}"
            remedy = f"it is more than {least:g}, sqrt(4/3) times that of shear waves"
            raise rejection([Problem("p_wave_speed", what, remedy, self.p_wave_speed)])
        return self
