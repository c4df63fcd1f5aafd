# SPDX-License-Identifier: BSD-3-Clause
"""`tilth.steps`: a run whose caller has the word after each load step."""

from __future__ import annotations

import weakref
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tilth.analysis.changed_load import curve_of, with_factors
from tilth.analysis.run import Result, resume_steps, run_steps
from tilth.analysis.snapshots import snapshot, units_of
from tilth.analysis.stepping import LEAVE, STOP, TakenStep
from tilth.analysis.stepping import Steps as TakenSteps
from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.interrupt import StopSignals
from tilth.model import Model
from tilth.model.problems import unknown_name
from tilth.output.folder import HISTORY
from tilth.output.history import read_history
from tilth.output.snapshot import Snapshot
from tilth.plot.names import require_field
from tilth.report.fields import field_values
from tilth.results.table import ByHeading, History

if TYPE_CHECKING:
    from typing_extensions import Self


def steps(
    model: Model | None,
    out: Path | str,
    *,
    threads: int | None = None,
    until: float | None = None,
    memory_limit: float | str | None = None,
    overwrite: bool = False,
    from_stage: tuple[Path | str, str] | None = None,
    continues: bool = False,
    quiet: bool = True,
) -> Steps:
    """Runs the analysis of a model as `run` does, and gives each load step to the caller's loop.

    Files and results are those of `run`, to the last bit. The run begins when the first step is
    asked for, and the errors of `run` are raised in the loop. In code of the loop signals are those
    of the program: Ctrl-C there leaves the loop.

    Args:
        model: None to go on with the run in `out` from its checkpoint, as `resume` does.
        out, threads, until, memory_limit, overwrite, from_stage, continues: as in `run`.
        quiet: whether the progress bar is left out.

    Raises:
        BadInput: `overwrite`, `from_stage` or `continues` is given without a model.
    """
    if model is not None:
        return Steps(
            run_steps(
                model, out, threads, until, memory_limit, overwrite, from_stage, continues, quiet
            )
        )
    if overwrite or continues or from_stage is not None:
        what = "a run that is gone on with keeps its files, its stage and its model"
        remedy = "leave `overwrite`, `from_stage` and `continues` out, or give a model"
        raise BadInput(what, remedy, key="model")
    return Steps(resume_steps(out, threads, until, memory_limit, quiet))


class Steps(Iterator["Step"]):
    """The load steps of a run, one after the other, see `steps`.

    Leaving the loop, by ``break`` or an error, ends the run after the present step as `Step.stop`
    does, as soon as nothing refers to this object any more. Where a name does, ``close`` or a
    ``with`` block ends it. Of several processes all stop where one does.

    Attributes:
        result: as of `run`; None until the run has ended.
    """

    def __init__(self, taken: TakenSteps[Result]) -> None:
        self._run = _Run(taken)
        # also called at the end of the program, while files can still be written
        self._finalizer = weakref.finalize(self, self._run.leave)

    @property
    def result(self) -> Result | None:
        """As of `run`; None until the run has ended."""
        return self._run.result

    def __next__(self) -> Step:
        return Step(self._run, self._run.next())

    def close(self) -> None:
        """Ends the run after the present step; does nothing after its end.

        Raises:
            AnalysisFailed: a file cannot be written.
        """
        self._finalizer()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


class _Run:
    """A run between two steps; does not refer to `Steps`, which ends it."""

    def __init__(self, taken: TakenSteps[Result]) -> None:
        self._taken = taken
        self.present: TakenStep | None = None
        self.result: Result | None = None

    def next(self) -> TakenStep:
        """Takes the next step; raises `StopIteration` after the last one."""
        before, self.present = self.present, None
        with StopSignals():
            if before is not None:
                before.signals.go_on()
            try:
                found = next(self._taken)
            except StopIteration as end:
                self.result = end.value or self.result
                raise
            found.signals.pause()
        self.present = found
        return found

    def leave(self) -> None:
        """Ends the run after the present step."""
        if self.present is None:  # not begun, or at its end
            self._taken.close()
            return
        self.present.asked = LEAVE
        with suppress(StopIteration):
            self.next()


class Step:
    """A converged load step and the state after it.

    Arrays are read when they are asked for, and are copies. They can be read until the next step is
    asked for; ``row`` and the numbers below are kept. Of several processes each has the arrays of
    its own points; all of them call ``force``, ``stop`` and ``change_load``.

    Attributes:
        number: of the step, from 1.
        time: total time at its end.
        size: of the step [time]; 0 where soil has come to rest beyond a limit load.
        iterations: Newton iterations.
        residuals: relative residuals of equilibrium, that of the first guess first.
        stage: name of the stage; empty without stages.
        relaxation: number of the relaxation in which soil comes to rest beyond a limit load; 0 in
            equilibrium.
        row: tracked quantities after the step, by heading (``name [unit]``) or name.
        folder: of the run.
        finished: whether this is the last step.
    """

    def __init__(self, run: _Run, taken: TakenStep) -> None:
        analysis, equilibrium = taken.analysis, taken.result.equilibrium
        self._run, self._taken = run, taken
        self._snapshot: Snapshot | None = None
        self.number = analysis.clock.step
        self.time = analysis.time
        self.size = taken.size
        self.iterations = equilibrium.iterations
        self.residuals = tuple(equilibrium.residuals)
        self.stage = analysis.setup.model.stage.name
        recorder = taken.recorder
        values = zip(recorder.tables.headings, recorder.row, strict=True)
        self.row: ByHeading[float] = ByHeading(dict(values))
        self.folder = recorder.folder
        self.finished = analysis.done
        relaxing = taken.result.relaxing
        self.relaxation = 0 if relaxing is None else relaxing.number

    def __repr__(self) -> str:
        stage = f" of stage {self.stage!r}" if self.stage else ""
        return f"<Step {self.number}{stage}: time {self.time:.6g}, {self.iterations} iterations>"

    @property
    def model(self) -> Model:
        """The model with the changes of loads so far."""
        return self._now().analysis.model

    @property
    def history(self) -> History:
        """Every tracked quantity, a row per step so far, as ``tilth.open(...).history``."""
        columns = read_history(self.folder / HISTORY)
        return History({name: rows[: self.number + 1] for name, rows in columns.items()})

    @property
    def point_id(self) -> NDArray[np.int64]:
        """Permanent numbers of the material points, ascending, shape (n,)."""
        return np.array(self._state().point_id)

    def points(self) -> Floats:
        """Returns the positions of the material points [length], shape (n, dim)."""
        return np.array(self._state().position)

    def field(self, name: str) -> NDArray[Any]:
        """Returns a field of the points, as ``RunResults.field``, tension positive.

        Args:
            name: of a field of the results: scalars have shape (n,), vectors (n, dim), symmetric
                tensors (n, 6) in the order xx yy zz xy yz xz. Or one with a component, shape (n,):
                ``displacement_y``, ``cauchy_stress_xx``, ``cauchy_stress_von_mises``.

        Raises:
            BadInput: there is no such field, with names near it, or the step is over.
        """
        state = self._state()
        if name in state.point_fields:
            return np.array(state.point_fields[name])
        require_field(state, name)
        return np.array(field_values(state, name, units_of(self.model))[0])

    def force(self, name: str) -> Floats:
        """Returns the force of a boundary or rigid body on the soil [force], shape (dim,).

        In plane strain it is per length, in axisymmetry that of the whole circle.

        Raises:
            BadInput: there is none of this name, or the step is over.
        """
        result = self._now().result
        if name not in result.forces:
            raise BadInput(
                *unknown_name("boundary or rigid body", name, result.forces),
                key="name",
                value=name,
            )
        return np.array(result.resultant(name))

    def factor(self, name: str, *, force: bool = False) -> float:
        """Returns the factor of a load, a moving boundary or a rigid body after the step [-].

        Args:
            name: of the load, boundary or rigid body.
            force: of a rigid body that of its force and moment instead of its motion.

        Raises:
            BadInput: there is none of this name, or the step is over.
        """
        analysis = self._now().analysis
        curve = curve_of(analysis.setup.model, name, force)
        return curve.factor(analysis.clock.time)

    def stop(self) -> None:
        """Ends the run after this step, as `until` does: the loop gets no further one.

        Results, a checkpoint and the report are written, and `resume` continues. Soil that is
        coming to rest beyond a limit load comes to rest before.
        """
        self._between().asked = STOP

    def change_load(
        self, name: str, rows: Sequence[Sequence[float]], *, force: bool = False
    ) -> None:
        """Lets a load or a motion go on by another table of factors from here.

        The factor goes on linearly from its present value to the first row, and is constant after
        the last one. The log says so, and the model in the folder has the changed table, so that
        `resume` and the report go by it: the run is that of a model with this table from the start.

        Args:
            name: of a load, a moving boundary or a rigid body.
            rows: (time, factor [-]), later than this step and ascending, shape (n, 2).
            force: of a rigid body, the factor of its force and moment instead of its motion.

        Raises:
            BadInput: there is none of this name, the rows are wrong, the model has stages, soil is
                coming to rest beyond a limit load, or the step is over.
        """
        taken = self._between()
        analysis, recorder = taken.analysis, taken.recorder
        if analysis.clock.relaxing:
            what = "no load can be changed while soil comes to rest beyond a limit load"
            raise BadInput(what, "change it after a step that is not of such a motion", key="name")
        model = with_factors(analysis.model, name, analysis.clock.time, rows, force)
        given = ", ".join(f"({row[0]:.6g}, {row[1]:.6g})" for row in rows)
        recorder.change(
            model,
            f"{name!r} after step {self.number}, from factor {self.factor(name, force=force):.6g} "
            f"at time {self.time:.6g} to {given}",
        )
        analysis.change(model)

    def _between(self) -> TakenStep:
        """Returns the step if the run waits for its caller after it."""
        if self._run.present is not self._taken:
            raise self._over()
        return self._taken

    def _now(self) -> TakenStep:
        """Returns the step if the state is still that after it."""
        if self._taken.analysis.clock.step != self.number:
            raise self._over()
        return self._taken

    def _over(self) -> BadInput:
        return BadInput(
            f"step {self.number} is over: the run is at step {self._taken.analysis.clock.step}",
            "ask for what is needed of a step before the next one begins, in the loop",
        )

    def _state(self) -> Snapshot:
        taken = self._now()
        if self._snapshot is None:
            analysis = taken.analysis
            self._snapshot = snapshot(
                analysis.setup, analysis.state, taken.result.active, taken.result, self.number,
                self.time, analysis.point_fields,
            )  # fmt: skip
        return self._snapshot
