# SPDX-License-Identifier: BSD-3-Clause
"""Checks a model without running it."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.analysis.staged import StagedAnalysis
from tilth.model import Model


@dataclass(frozen=True)
class CheckResult:
    """A model that can be computed: its size, and what in it is probably not meant.

    Attributes:
        points: number of material points, the largest of all stages.
        active_cells: number of grid cells in the points' supports before the first step, of the
            stage with the most points.
        unknowns: displacement components of their nodes, prescribed ones included.
        warnings: texts with place in the case file, numbers and remedy, as `tilth run` logs them.
    """

    points: int
    active_cells: int
    unknowns: int
    warnings: list[str]

    def __repr__(self) -> str:
        size = f"{self.points} points, {self.active_cells} active cells, {self.unknowns} unknowns"
        said = "".join(f"\n  warning: {text}" for text in self.warnings)
        count = f"{len(self.warnings) or 'no'} warning{'' if len(self.warnings) == 1 else 's'}"
        return f"<CheckResult: {size}, {count}{said}>"


def check(model: Model) -> CheckResult:
    """Checks a model as `run` does before its first step, without running it.

    The stages are gone through with the undeformed soil.

    Raises:
        BadInput: the model cannot be computed.
    """
    sizes: list[tuple[int, int, int]] = []
    warnings: list[str] = []
    for simulation, active in StagedAnalysis(model).starts():
        unknowns = active.nodes * model.dimension
        sizes.append((len(simulation.state.points), len(active.cell_keys), unknowns))
        warnings += simulation.services.warnings.texts
    points, active_cells, unknowns = max(sizes)
    return CheckResult(points, active_cells, unknowns, warnings)
