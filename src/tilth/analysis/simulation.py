# SPDX-License-Identifier: BSD-3-Clause
"""An analysis of one stage in memory: what is declared, the state, and what serves both."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tilth.analysis.advance import advance
from tilth.analysis.checks import check_first_step
from tilth.analysis.owners import Arrays, WrongState, restore_all, restored_points
from tilth.analysis.prepare import locate, prepare, soil_on
from tilth.analysis.services import Services
from tilth.analysis.setup import FieldOwner, InStep, Maker, Setup
from tilth.analysis.state import State
from tilth.analysis.step_result import PreparedStep, StepResult
from tilth.analysis.step_terms import TERMS, balance_of, terms_of
from tilth.arrays import Floats
from tilth.comm import SERIAL, Communicator
from tilth.model import Model
from tilth.mpi import return_memory
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.domains import bound_domains
from tilth.mpm.initial_points import initial_points, present_points
from tilth.mpm.interval import INSTANT, Interval
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.terms.balance import Balance
from tilth.terms.loads import Loads
from tilth.terms.protocol import Term


class Simulation:
    """What the loops over steps, stages and trials hold. All else takes of it what it uses.

    Args:
        model: the declared problem.
        points: the present points; those of the undeformed bodies if None.
        initial: the undeformed points of all bodies of all stages, in the order of their numbers;
            computed if None.
        terms: makers of the terms of the balance.
        fields: further fields than those of the model; the state has them as owners.

    Attributes:
        setup: what is declared, or follows from it; never changes.
        state: all that a later step reads; changes where a step is committed.
        services: what no result depends on.

    Raises:
        BadInput: a body without points, conditions that leave a rigid motion or contradict.
    """

    def __init__(
        self,
        model: Model,
        points: MaterialPoints | None = None,
        initial: MaterialPoints | None = None,
        terms: Sequence[Maker] = TERMS,
        fields: Sequence[FieldOwner] = (),
    ) -> None:
        model.require_state_variables()
        initial = initial_points(model) if initial is None else initial
        if points is None:
            present = present_points(model, initial)
            points = initial.selected(present) if model.stage.name else initial
        loads = Loads(model, initial, points)

        def acceleration(time: float) -> Floats:
            return loads.acceleration(time) + np.zeros(model.dimension)

        self.state = State(model, points, initial, acceleration)
        self.state.owners |= {f"field {each.name}": each for each in fields}
        self.setup = Setup.of(model, loads, self.state, terms, fields)
        self.services = Services.of(model, len(points), SERIAL)
        self.services.warnings.departures(model)
        self.services.warnings.bounds(bound_domains(points, self.state.grid))

    @classmethod
    def restored(
        cls,
        model: Model,
        arrays: Arrays,
        initial: MaterialPoints | None = None,
        terms: Sequence[Maker] = TERMS,
        fields: Sequence[FieldOwner] = (),
    ) -> Simulation:
        """Returns a simulation in the state that `arrays` stored.

        initial, terms, fields: as in the constructor.

        Raises:
            MissingState: they lack something that a step reads.
            WrongState: they are not of this model.
        """
        initial = initial_points(model) if initial is None else initial
        points = restored_points(initial, arrays, model.stage.name != "")
        simulation = cls(model, points, initial, terms, fields)
        restore_all(simulation.state.owners, arrays)
        if unknown := set(arrays) - set(simulation.state.arrays()):
            raise WrongState(f"{min(unknown)!r} belongs to nothing in it")
        return simulation

    def distribute(self, comm: Communicator) -> None:
        """Leaves this process its part of the points; all processes have them all before.

        Raises:
            BadInput: there are too many processes, or PETSc is missing.
        """
        if comm.size > 1:
            self.state.distribute(comm)
            self.services.distribute(self.setup.model, comm)
            return_memory()
            distribution = self.state.distribution
            distribution.own = distribution.own[distribution.own]

    def check(self, in_advance: bool = False) -> ActiveGrid:
        """As `check_first_step`."""
        return check_first_step(self.setup, self.state, self.services, in_advance)

    def locate(self, time: float) -> ActiveGrid:
        """As `tilth.analysis.prepare.locate`."""
        return locate(self.setup, self.state, self.services, time)

    def prepare(self, before: float, after: float) -> PreparedStep:
        """As `tilth.analysis.prepare.prepare`."""
        return prepare(self.setup, self.state, self.services, before, after)

    def soil_on(self, active: ActiveGrid, interval: Interval = INSTANT) -> Soil:
        """As `tilth.analysis.prepare.soil_on`."""
        return soil_on(active, self.setup, self.state, self.services, interval)

    def terms(self, step: PreparedStep, soil: Soil) -> list[Term]:
        """As `terms_of`."""
        return terms_of(InStep(self.setup, self.state, step, soil), self.services.timers)

    def balance(
        self,
        step: PreparedStep,
        soil: Soil,
        further: Sequence[Term] = (),
        holds_others: bool = True,
    ) -> Balance:
        """Returns the balance of a step with `further` terms.

        holds_others: see `balance_of`.
        """
        of = InStep(self.setup, self.state, step, soil)
        return balance_of(of, [*terms_of(of, self.services.timers), *further], holds_others)

    def advance(
        self,
        before: float,
        after: float,
        on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
        is_least: bool = False,
        is_short: bool = False,
    ) -> StepResult:
        """As `tilth.analysis.advance.advance`."""
        return advance(
            self.setup, self.state, self.services, before, after, on_iteration, is_least, is_short
        )
