# SPDX-License-Identifier: BSD-3-Clause
"""Water at rest in and above the ground."""

from __future__ import annotations

from tilth.model.base import Declared
from tilth.model.fields import Positive
from tilth.model.variation import Level


class Water(Declared):
    """Water at rest."""

    level: Level
    unit_weight: Positive
    initial_level: Level | None = None
