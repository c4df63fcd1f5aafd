# SPDX-License-Identifier: BSD-3-Clause
"""Writes the files of a strength reduction: its trials, its summary, the mechanism."""

from __future__ import annotations

import io
import math
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from tilth.analysis.gathering import gathered_snapshot
from tilth.analysis.prepare import locate
from tilth.analysis.safety import SafetyResult
from tilth.analysis.services import Services
from tilth.analysis.setup import Setup
from tilth.analysis.snapshots import snapshot, units_of
from tilth.analysis.state import State
from tilth.comm import together
from tilth.model import Model
from tilth.output import ResultsWriter, Snapshot, read_results
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.output.folder import SafetyFiles, safety_files
from tilth.output.safety_files import SafetySummary, StoredTrial, write_safety
from tilth.report.safety import PLASTIC_INCREMENT, draw_mechanism
from tilth.report.texts import save
from tilth.terms.released import ReleasedForces

LEAST_SHARE = 1e-9
"""Share of released forces that does not count, of round-off."""


def record(
    folder: Path,
    setup: Setup,
    state: State,
    services: Services,
    step: int,
    time: float,
    result: SafetyResult,
    index: int | None = None,
) -> None:
    """Writes the files of a strength reduction into a folder, replacing those of an earlier one.

    All processes call it; process 0 writes.

    Args:
        folder: of the run.
        setup, state, services: of the analysis, in the state at the start of the reduction.
        step, time: of this state, the time of its stage.
        result: of the reduction.
        index: of its stage, see `safety_files`.

    Raises:
        AnalysisFailed: a file cannot be written.
    """
    total = setup.model.stage.start + time
    active = locate(setup, state, services, time)
    points = gathered_snapshot(snapshot(setup, state, active, None, step, total), active)
    with together(state.comm):
        if state.comm.rank == 0:
            held = _still_held(setup.model, state.released, time)
            _write(folder, setup.model, points, result, safety_files(index), held)


def _write(
    folder: Path,
    model: Model,
    state: Snapshot,
    result: SafetyResult,
    files: SafetyFiles,
    held: str,
) -> None:
    """Writes the files; state: of all points at the start of the reduction. held: see
    `_still_held`."""
    for name in files:
        with suppress(FileNotFoundError):
            (folder / name).unlink()
    units = units_of(model)
    moved = {"displacement": result.displacement, PLASTIC_INCREMENT: result.plastic_strain}
    fields = {name: np.asarray(values) for name, values in state.point_fields.items()} | moved
    writer = ResultsWriter(folder / files.mechanism, title=model.title, units=units)
    try:
        writer.append(replace(state, point_fields=fields))
    finally:
        writer.close()
    axisymmetric = model.analysis.kind == "axisymmetric"
    drawn = draw_mechanism(read_results(folder / files.mechanism), axisymmetric=axisymmetric)
    picture = io.BytesIO()
    save(next(iter(drawn.values())), picture, dpi=130)
    with writing(folder / files.picture):
        write_durably(folder / files.picture, picture.getvalue())
    trials = [
        StoredTrial(
            factor=trial.factor,
            displacement=None if math.isnan(trial.displacement) else trial.displacement,
            iterations=trial.iterations,
            outcome=trial.outcome.value,
            reason=trial.failure,
        )
        for trial in result.trials
    ]
    summary = SafetySummary(
        factor=result.factor,
        above=None if math.isinf(result.above) else result.above,
        tolerance=result.tolerance,
        undecided=result.undecided,
        time=state.time,
        criterion=result.criterion + held,
        largest_displacement=result.largest_displacement,
        trials=trials,
        davis=result.davis,
    )
    write_safety(folder, summary, units["length"], files)


def _still_held(model: Model, released: ReleasedForces, time: float) -> str:
    """Returns words on forces that the stage has not released yet; empty if there are none."""
    share = released.remaining(time)
    if share < LEAST_SHARE or not released.force.any():
        return ""
    return (
        f"; the stage {model.stage.name!r} is not finished: {100.0 * share:.3g} % of "
        "the forces that it releases still act on the soil"
    )
