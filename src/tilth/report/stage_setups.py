# SPDX-License-Identifier: BSD-3-Clause
"""Contents of the figures of the stages of a set-up, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.output.snapshot import SurfaceShape
from tilth.report.setup_data import Setup, Soil


@dataclass(frozen=True, eq=False)
class StageSetup:
    """A stage: its soil by its numbers, and what acts in it."""

    name: str
    number: int
    """That in the case file, among all stages, from 1."""
    start: float
    """Total time at its start [time]."""
    end: float
    """Total time at its end [time]."""
    changes: Sequence[str]
    """What changes at its start, in a few words each."""
    present: Flags
    """Which points are there, shape (n,)."""
    setup: Setup
    """What acts: conditions, surfaces and loads at its end, without soil and tracked surfaces."""


@dataclass(frozen=True, eq=False)
class StagedSetup:
    """The set-up of an analysis with stages, whose soil is undeformed; n points in all."""

    soil: Soil
    """Of all bodies of all stages, in the order of the points' numbers."""
    surfaces: Sequence[SurfaceShape]
    """Surfaces of bodies that are tracked, of all stages."""
    stages: Sequence[StageSetup]
    before: Flags | None = None
    """Which points are there in the initial state, shape (n,); None if the first stage begins with
    it."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about probable mistakes, of all stages."""
        return tuple(text for stage in self.stages for text in stage.setup.warnings)

    def at(self, index: int) -> Setup:
        """Returns what the figure of a stage shows, by its index in `stages`."""
        stage = self.stages[index]
        before = stage.present if self.before is None else self.before
        if index > 0:
            before = self.stages[index - 1].present
        there = np.unique(self.soil.body_id[stage.present])
        names = {stage.setup.body_names[body] for body in there}
        return replace(
            self._with_soil(stage.present, stage.setup),
            tracked=[
                shape if shape.name in names else SurfaceShape.empty(shape.name, stage.setup.dim)
                for shape in self.surfaces
            ],
            is_new=(stage.present & ~before)[stage.present],
            removed=self.soil.selected(before & ~stage.present),
        )

    def water_at(self, time: float) -> Floats | None:
        """Returns the vertices of the water's surface at a total time [length], shape (k, 2)."""
        stage = next((each for each in self.stages if time <= each.end), self.stages[-1])
        return stage.setup.water_at(time)

    def whole(self) -> Setup:
        """Returns the first stage's set-up with the soil of all stages."""
        return self._with_soil(np.ones(len(self.soil.position), bool), self.stages[0].setup)

    def _with_soil(self, chosen: Flags, setup: Setup) -> Setup:
        soil = self.soil.selected(chosen)
        return replace(
            setup,
            position=soil.position,
            half_lengths=soil.half_lengths,
            corners=soil.corners,
            body_id=soil.body_id,
        )
