# SPDX-License-Identifier: BSD-3-Clause
"""Checks a model without running it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tilth.analysis.consolidation_time import consolidation_time
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


def consolidation_texts(model: Model) -> Iterator[str]:
    """Yields what `tilth check` tells of the consolidation in stages with flow, if it is new.

    Raises:
        BadInput: as `StagedAnalysis.starts`.
    """
    length, time = model.units.length, model.units.time
    told: set[str] = set()
    for simulation, _ in StagedAnalysis(model).starts():
        of, state = simulation.setup.model, simulation.state
        found = consolidation_time(of, state.undeformed(), state.surfaces, state.grid)
        if found is None:
            continue
        least, greatest = (f"{each:.3g}" for each in found.coefficients)
        both = least if least == greatest else f"{least} to {greatest}"
        text = f"c_v {both} {length}^2/{time} with the stiffness at the start, "
        if found.time is None:
            text += "no pressure is given where water could leave"
        else:
            text += (
                f"longest way of the water about {found.path:.3g} {length}: 90 % after about "
                f"{found.time:.3g} {time}; a first step of about {found.first_step:.2g} {time} "
                "resolves the beginning"
            )
        if text not in told:
            told.add(text)
            yield f"{of.stage.name}: {text}" if of.stage.name else text
