# SPDX-License-Identifier: BSD-3-Clause
"""A run that is left after a step and goes on from its state."""

from __future__ import annotations

import copy

from metamorphic.runs import Listener, Run, Tree
from metamorphic.watched import watched
from tilth import Model
from tilth.analysis.initial_equilibrium import find_initial_equilibrium, has_initial_equilibrium
from tilth.analysis.staged import StagedAnalysis
from tilth.errors import TilthError


def resumed_run(entries: Tree, step: int) -> Run:
    """Runs a model; after a step it goes on from a copy of what a checkpoint would have."""
    with watched():
        return _resumed_run(Model.from_dict(entries), step)


def _resumed_run(model: Model, step: int) -> Run:
    run = Run(model=model)
    listener = Listener(run)
    analysis = StagedAnalysis(model)
    analysis.check()
    if has_initial_equilibrium(analysis.simulation.setup.model):
        find_initial_equilibrium(analysis.simulation)
    listener.at_start(analysis)
    try:
        for count, (_, result) in enumerate(analysis.steps(), start=1):
            listener.after_step(analysis, result)
            if count == step:
                break
        arrays = copy.deepcopy(analysis.simulation.state.arrays())
        clock = analysis.clock
        position = {
            "step": clock.step, "time": clock.time, "size": clock.size,
            "successes": clock.successes, "relaxing": clock.relaxing,
        }  # fmt: skip
        again = StagedAnalysis.restored(model, analysis.number, position, arrays, None)
        for _, result in again.steps():
            listener.after_step(again, result)
    except TilthError as error:
        run.error, run.exit_code = error.message, error.exit_code
    return run
