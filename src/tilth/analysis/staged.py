# SPDX-License-Identifier: BSD-3-Clause
"""An analysis stage by stage: the simulation of the present stage and its clock."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from tilth.analysis.clock import Clock
from tilth.analysis.gathering import collected
from tilth.analysis.initial_equilibrium import (
    InitialEquilibrium,
    find_initial_equilibrium,
    forces_at_rest,
    has_initial_equilibrium,
)
from tilth.analysis.load_steps import load_steps
from tilth.analysis.owners import Arrays
from tilth.analysis.services import Services
from tilth.analysis.setup import Setup
from tilth.analysis.simulation import Simulation
from tilth.analysis.stage_change import checked_next_stage, points_of_stages
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.comm import Communicator
from tilth.errors import BadInput, StepFailed
from tilth.model import Model
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.frozen_points import require_reducible
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints

PointFields = tuple[list[str], list[str], bool]
"""Names of the state variables and of the varying parameters that all outputs of a run have, and
whether they have the fields of water."""


def end_time(model: Model) -> float:
    """Returns the total time at the end of the last stage."""
    last = model.of_stages[-1]
    return last.stage.start + last.schedule.end


def output_times(model: Model) -> list[float]:
    """Returns the total times of output of all stages, without that at the start."""
    return [
        each.stage.start + time
        for each in model.of_stages
        for time in each.schedule.times_of_output()
    ]


def _fields_of(of_stages: Sequence[MaterialPoints], model: Model) -> PointFields:
    states = dict.fromkeys(name for each in of_stages for name in each.state_variables())
    varying = dict.fromkeys(name for each in of_stages for name in each.varying)
    return list(states), list(varying), model.has_water or model.flow is not None


class StagedAnalysis:
    """An analysis of one or several stages, at a moment of one of them.

    A model without stages is an analysis of one stage. Where the first stage changes the initial
    state, the analysis is in this state until `begin`, `enter_first` or `steps` is called.

    Args:
        model: the whole model.
        until: total time at which to stop; None for the end.

    Attributes:
        models: the model of each stage.
        simulation: of the present stage.
        clock: of the present stage; its time begins at 0 in each stage.
        out_of_balance: resultant of the forces released in the present stage [force], (dim,).
    """

    def __init__(self, model: Model, until: float | None = None) -> None:
        self._begin(model, until)
        self.simulation = self._at_first()
        self.clock = self._clock(0, step=0)

    def _begin(self, model: Model, until: float | None) -> None:
        self.model = model
        self.models = model.of_stages
        self._until = until
        self._initial = points_of_stages(self.models) if model.stages else []
        first = self.models[0]
        self._before = first.initial_model if first.stage.follows else None
        self.out_of_balance: Floats = np.zeros(model.dimension)

    def _at_first(self) -> Simulation:
        """Returns the simulation of the initial state."""
        if self._before is not None:
            return Simulation(self._before, initial=initial_points(self._before))
        return Simulation(self.models[0], initial=self._initial[0] if self.model.stages else None)

    @property
    def setup(self) -> Setup:
        """What is declared of the present stage."""
        return self.simulation.setup

    @property
    def state(self) -> State:
        """The state of the soil and of all else."""
        return self.simulation.state

    @property
    def services(self) -> Services:
        """What no result depends on."""
        return self.simulation.services

    @property
    def is_before_first(self) -> bool:
        """Whether the soil is in the initial state, which the first stage is going to change."""
        return self.setup.model is self._before

    @classmethod
    def restored(
        cls, model: Model, number: int, clock: dict[str, float], arrays: Arrays, until: float | None
    ) -> StagedAnalysis:
        """Returns the analysis at a moment that a checkpoint stored.

        Args:
            model: the whole model.
            number: of the stage.
            clock: step, time, size and successes of its clock.
            arrays: state of its simulation.
            until: as in the constructor.

        Raises:
            MissingState, WrongState: see `Simulation.restored`.
        """
        analysis = cls.__new__(cls)
        analysis._begin(model, until)
        initial = analysis._initial[number] if model.stages else None
        analysis.simulation = Simulation.restored(analysis.models[number], arrays, initial)
        analysis.clock = analysis._clock(number, **clock)
        return analysis

    def distribute(self, comm: Communicator) -> None:
        """Leaves this process its part of the points; all processes have them all before.

        Raises:
            BadInput: see `Simulation.distribute`.
        """
        self.simulation.distribute(comm)

    @property
    def point_fields(self) -> PointFields:
        """The state variables and varying parameters of all stages."""
        return _fields_of(self._initial or [self.state.points], self.model)

    @staticmethod
    def fields_of(model: Model) -> PointFields:
        """Returns the same for a model with stages that is not yet run."""
        return _fields_of(points_of_stages(model.of_stages), model)

    def _clock(self, number: int, **position: float) -> Clock:
        model = self.models[number]
        until = None if self._until is None else self._until - model.stage.start
        if until is not None and until > model.schedule.end * (1.0 + 1e-12):
            until = None
        return Clock(model.schedule, until=until, **position)  # type: ignore[arg-type]

    @property
    def soil(self) -> MaterialPoints:
        """The undeformed points of all bodies, with the materials of the first stage.

        Those of a model without stages are the points of the simulation, which change.
        """
        return self._initial[0] if self._initial else self.state.points

    @property
    def initial(self) -> MaterialPoints:
        """The undeformed points of all bodies, with the materials of the present stage."""
        number = self.setup.model.stage.number
        return self._initial[number] if self._initial else self.state.points

    @property
    def number(self) -> int:
        """Number of the present stage among those of the type "loading", from 0."""
        return self.setup.model.stage.number

    @property
    def time(self) -> float:
        """Total time reached."""
        return self.setup.model.stage.start + self.clock.time

    @property
    def done(self) -> bool:
        """Whether the end of the last stage is reached."""
        return self.clock.done and self.number == len(self.models) - 1

    @property
    def stops(self) -> bool:
        """Whether the time at which to stop is reached."""
        return self._until is not None and (self.clock.stops or self.time > self._until)

    def starts(self) -> Iterator[tuple[Simulation, ActiveGrid]]:
        """Goes through the stages with the undeformed soil and checks the first step of each.

        What needs the soil as it will be is checked by `enter_next`.

        Yields:
            The simulation at the start of each stage and the grid of its first step, which may
            not be used after the next one is asked for. `simulation` remains as it is.

        Raises:
            BadInput: see `next_stage` and `Simulation.check`.
        """
        for model in self.models:
            for _, reduction in model.stage.reductions:
                try:
                    require_reducible(model, reduction.davis)
                except BadInput as error:
                    raise error.during(f"in the stage {reduction.name!r}") from error
        active, first = self.simulation.check(), int(self._before is None)
        if first:
            yield self.simulation, active
        if len(self.models) > first:
            simulation = self._at_first()
            simulation.services.warnings.go_on_from(self.services.warnings)
            for model, initial in zip(self.models[first:], self._initial[first:], strict=True):
                simulation = checked_next_stage(simulation, model, initial, in_advance=True)
                yield simulation, simulation.locate(0.0)

    def check(self) -> ActiveGrid:
        """Checks all stages as `starts` does; returns the grid of the first step.

        Raises:
            BadInput: see `starts`.
        """
        first: ActiveGrid | None = None
        for _, active in self.starts():
            first = first or active
        assert first is not None
        return first

    def begin(
        self, on_iteration: Callable[[int, float], None] = lambda iteration, residual: None
    ) -> InitialEquilibrium | None:
        """Finds the equilibrium of the initial state and makes the changes of the first stage.

        Returns what was done for the equilibrium, with the forces after the changes; None if none
        is to be found.

        on_iteration: see `find_initial_equilibrium`.

        Raises:
            AnalysisFailed, BadInput: see `find_initial_equilibrium` and `enter_next`.
        """
        found = None
        if has_initial_equilibrium(self.setup.model):
            found = find_initial_equilibrium(self.simulation, on_iteration)
        if self.is_before_first:
            self.enter_first()
            if found is not None:
                found = replace(found, result=forces_at_rest(self.simulation))
        return found

    def enter_first(self) -> None:
        """Makes the changes of the first stage to the initial state, as `enter_next`."""
        self._enter(0)

    def enter_next(self) -> None:
        """Goes to the start of the next stage, whose clock begins at 0.

        Each process changes all soil, and is then left its part of it.

        Raises:
            BadInput: see `next_stage` and `Simulation.distribute`.
        """
        self._enter(self.number + 1)

    def _enter(self, number: int) -> None:
        model, initial = self.models[number], self._initial[number]
        comm = self.state.comm
        self.simulation = checked_next_stage(collected(self.simulation), model, initial)
        self.out_of_balance = self.state.released.force.sum(axis=0)
        self.simulation.distribute(comm)
        self.clock = self._clock(number, step=self.clock.step)

    def stop(self) -> None:
        """Stops at the time reached, as if it had been the time at which to stop."""
        self._until, self.clock.until = self.time, self.clock.time

    def change(self, model: Model) -> None:
        """Goes on from here with a model that differs in load curves only, without stages.

        The simulation is that which a resumed run of this model would begin with; `steps` has to be
        called again. All processes call it.
        """
        last, comm = self.simulation, self.state.comm
        self.model, self.models = model, model.of_stages
        arrays, declared = collected(last).state.arrays(), last.setup
        simulation = Simulation.restored(
            model, arrays, terms=declared.terms, fields=declared.fields
        )
        simulation.services.go_on_from(last.services)
        simulation.locate(self.clock.time)
        simulation.distribute(comm)
        self.simulation = simulation

    def steps(
        self,
        on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
        on_cut: Callable[[float, StepFailed], None] = lambda time, failure: None,
        on_stage_end: Callable[[], None] = lambda: None,
        on_stage_start: Callable[[], None] = lambda: None,
    ) -> Iterator[tuple[float, StepResult]]:
        """Takes the load steps of all stages that are left, see `load_steps`.

        on_stage_end, on_stage_start: are called at the end of each stage and at the start of the
            next one.

        Yields:
            The size of each converged step [time] and its result.

        Raises:
            AnalysisFailed: no equilibrium with the smallest step.
            BadInput: code of the user fails, or a stage cannot begin.
        """
        if self.is_before_first:
            self.enter_first()
        while True:
            yield from load_steps(self.simulation, self.clock, on_iteration, on_cut)
            stopped = self.clock.stops and not self.clock.done
            if not self.clock.done or stopped:
                return
            on_stage_end()
            if self.number == len(self.models) - 1 or self.clock.stops:
                return
            self.enter_next()
            on_stage_start()
