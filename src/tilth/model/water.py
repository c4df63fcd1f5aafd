# SPDX-License-Identifier: BSD-3-Clause
"""Water at rest: its level and unit weight."""

from __future__ import annotations

from tilth.model.base import Declared
from tilth.model.fields import Positive, Table
from tilth.model.variation import Level


class Water(Declared):
    """Water at rest in the soil and above it: pore pressure below its level, and no suction above.

    The pressure at a place is unit_weight (level - height) below the level. The laws' stress is the
    effective one ([theory](../theory/water.md)). At the start every material point must lie within
    the ends of a polyline or a grid; beyond them the level goes on horizontally, for soil that
    moves there.
    """

    level: Level
    """Elevation of the water's surface [length]: a number, in 2D also a polyline of rows
    (x, elevation), or { file = "level.csv" } with a grid over the horizontal axes. It may stand
    above the ground: the water then loads the ground, without a load on its surface.
    """
    unit_weight: Positive
    """Unit weight of the water [force / length^3], > 0."""
    initial_level: Level | None = None
    """Elevation at the start of the schedule, from which the water moves to `level` linearly in
    time, up to the end of the schedule; the water does not move if not given.
    """
    factor: Table | None = None
    """Rows (time, factor) by which the unit weight is multiplied, shape (n, 2), such as those of a
    body force that grows from zero; 1 if not given: unlike a load, water is there from the start.
    """
