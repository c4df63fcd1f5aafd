# SPDX-License-Identifier: BSD-3-Clause
"""What is written of an analysis while it runs: results, history, log and checkpoints."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, cast

from tilth import __version__, _core
from tilth.analysis.clock import Clock
from tilth.analysis.contact_output import ContactOutput
from tilth.analysis.energies import Energies
from tilth.analysis.gathering import gathered_snapshot, gathered_state, processes_text
from tilth.analysis.initial_equilibrium import InitialEquilibrium
from tilth.analysis.model_warnings import without_stage
from tilth.analysis.motions import area_unit
from tilth.analysis.owners import Arrays
from tilth.analysis.snapshots import snapshot, units_of
from tilth.analysis.staged import StagedAnalysis, end_time, output_times
from tilth.analysis.step_result import StepResult
from tilth.analysis.step_tables import StepTables
from tilth.analysis.stored_run import CHECKPOINT_FORMAT, StoredRun
from tilth.comm import count, together
from tilth.errors import AnalysisFailed, StepFailed, TilthError
from tilth.memory_errors import is_memory_error, memory_sentence
from tilth.model import Model
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.output import (
    CheckpointThread,
    Progress,
    ResultsWriter,
    RunLog,
    Snapshot,
    read_results,
    write_checkpoint,
    write_contacts,
    write_surfaces,
)
from tilth.output.checkpoint_thread import LARGEST_COPY
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.output.folder import (
    CHECKPOINT,
    CONTACT,
    HISTORY,
    LOG,
    MODEL,
    RESULTS,
    SURFACE,
    stage_checkpoint,
)
from tilth.output.log import START
from tilth.output.nothing import Nothing
from tilth.output.snapshot import SurfaceShape
from tilth.variation.tables import place_text


@dataclass
class Recorder:
    """Writes the files of a run; checkpoints beside the next step."""

    folder: Path
    analysis: StagedAnalysis
    results: ResultsWriter
    tables: StepTables
    contact: ContactOutput
    log: RunLog
    _model_checksum: int
    energies: Energies = field(default_factory=Energies)
    """Sums over the steps since the start."""
    _checkpoints: CheckpointThread = field(default_factory=CheckpointThread)
    _progress: Progress | None = None
    _last: tuple[int, float, StepResult] | None = None
    _at_start: str = ""
    """How the equilibrium of the initial state was found."""
    row: list[float] = field(default_factory=list)
    """Tracked quantities at the last step, in the order of `tables.headings`."""
    _next_checksum: int | None = None
    """Of model.json when a change of a load will be complete."""
    _earlier_outputs: dict[str, Any] = field(default_factory=dict)
    """That entry of `Progress`, if it has one."""
    _beside_schedule: bool = False
    """Whether the last output is that of a run that ended between the times of output."""

    @classmethod
    def start(
        cls,
        folder: Path,
        analysis: StagedAnalysis,
        active: ActiveGrid,
        threads: int,
        start: InitialEquilibrium | None = None,
        initial: MaterialPoints | None = None,
    ) -> Recorder:
        """Begins the files of a new run and writes the initial state.

        start: how the equilibrium of this state was found. initial: undeformed points of all
        processes; those of the analysis if None.
        """
        model, simulation = analysis.model, analysis.simulation
        setup, state, services = simulation.setup, simulation.state, simulation.services
        with together(state.comm):
            recorder = cls._of(folder, analysis, initial or analysis.initial, None)
        recorder.energies = Energies.at_start(setup, state)
        recorder._header(active, threads, 0)
        result, iterations = None, 0
        if start is not None:
            result, active, iterations = start.result, start.result.active, start.iterations
            recorder._at_start = start.text(model.units.stress)
            recorder.log.start(recorder._at_start)
        output = recorder._snapshot(active, result, 0, 0.0)
        rows = recorder.tables.rows(0.0, setup, state, result, recorder.energies, services.warnings)
        with together(state.comm):
            recorder._output(output)
            recorder.tables.append(0, 0.0, iterations, rows, (setup.model.stage.name, 0.0))
            recorder._log_stage()
        return recorder

    @classmethod
    def _of(
        cls,
        folder: Path,
        analysis: StagedAnalysis,
        initial: MaterialPoints,
        stored: StoredRun | None,
    ) -> Recorder:
        """Begins the files of a run, or goes on with them; only process 0 has them."""
        model, first = analysis.model, analysis.state.comm.rank == 0
        results, log = cast(ResultsWriter, Nothing()), cast(RunLog, Nothing())
        if first and stored is None:
            results = ResultsWriter(folder / RESULTS, title=model.title, units=units_of(model))
            log = RunLog(folder / LOG)
        elif first and stored is not None:
            progress = stored.progress
            results = ResultsWriter.resume(folder / RESULTS, progress.clock.step)
            log = RunLog(folder / LOG, resume=True, seconds=progress.seconds.total)
        rows = None if stored is None else stored.rows
        return cls(
            folder=folder,
            analysis=analysis,
            results=results,
            tables=StepTables(folder if first else None, model, initial, rows),
            contact=ContactOutput(model, initial),
            log=log,
            _model_checksum=zlib.crc32((folder / MODEL).read_bytes()) if first else 0,
        )

    @classmethod
    def resume(cls, stored: StoredRun, analysis: StagedAnalysis, threads: int) -> Recorder:
        """Goes on with the files of a run, dropping what was written after the checkpoint."""
        model, folder, progress = stored.model, stored.folder, stored.progress
        step, simulation = progress.clock.step, analysis.simulation
        simulation.services.timers.wall |= progress.seconds.wall
        simulation.services.timers.processor |= progress.seconds.processor
        active = simulation.locate(progress.clock.time)
        initial = analysis.initial if model.stages else initial_points(model)
        with together(simulation.state.comm):
            recorder = cls._of(folder, analysis, initial, stored)
            recorder.energies = Energies(**progress.energies.model_dump())
            recorder._earlier_outputs = progress.model_dump(
                include={"earlier_outputs"}, exclude_none=True
            )
            if recorder._writes:
                kept = read_results(folder / RESULTS)
                earlier = progress.earlier_outputs
                regular = {0.0, *output_times(model), *(earlier.times if earlier else ())}
                recorder._beside_schedule = kept.times[-1] not in regular
                if kept.surfaces or kept.names["contacts"]:
                    recorder._write_tables(kept.snapshot(-1))
        recorder._header(active, threads, step)
        return recorder

    @property
    def _writes(self) -> bool:
        """Whether this process writes the files."""
        return self.analysis.state.comm.rank == 0

    def stage_end(self) -> None:
        """Keeps the state at the end of a stage as a checkpoint of its own."""
        if self.analysis.model.stages:
            index = self.analysis.setup.model.stage.index
            self._checkpoint_at_once(stage_checkpoint(index))

    def factor_of_safety(self, stage: str, text: str) -> None:
        """Records the result of a strength reduction, and warnings of it."""
        self._collect_warnings()
        self.log.reduction(stage, self.analysis.time, text)
        if self._progress is not None:
            self._progress.message(f"{stage}: {text}")
        self._say_warnings()

    def _relaxed(self, time: float) -> None:
        """Records that soil has come to rest beyond a limit load."""
        relaxation = self.analysis.state.relaxation
        assert relaxation is not None
        text = (
            f"relaxation {relaxation.number}: at rest at time {time:.6g} after {relaxation.steps} "
            f"steps; largest kinetic energy {100.0 * relaxation.largest_share:.2g} % of the work"
        )
        self.log.relaxation(text)
        if self._progress is not None:
            self._progress.message(text)

    def stage_start(self) -> None:
        """Records that the next stage has begun."""
        self._collect_warnings()
        self._say_warnings()
        self._log_stage()
        if self._progress is not None:
            self._show_stage(self._progress)

    def _show_stage(self, progress: Progress) -> None:
        stage = self.analysis.setup.model.stage
        if stage.name:
            points, count = (
                self.analysis.state.distribution.total,
                len(self.analysis.model.stages),
            )
            progress.stage(stage.name, stage.index + 1, count, points)

    def _log_stage(self) -> None:
        stage = self.analysis.setup.model.stage
        if stage.name:
            released = place_text(self.analysis.out_of_balance) if stage.releases else ""
            self.log.stage(stage.name, stage.start, released)

    def _header(self, active: ActiveGrid, threads: int, last_step: int) -> None:
        comm = self.analysis.state.comm
        cells = count(comm, active.owned_cells)
        with together(comm):
            self.log.header(
                version=__version__,
                title=self.analysis.setup.model.title,
                processes=comm.size,
                threads=threads,
                points=self.analysis.state.distribution.total,
                cells=cells,
                last_step=last_step,
            )

    @contextmanager
    def recording(self, clock: Clock, quiet: bool) -> Iterator[Progress]:
        """Shows progress; closes all files however the run ends, and logs why."""
        end = end_time(self.analysis.model)
        if clock.until is not None:
            end = self.analysis.setup.model.stage.start + clock.until
        points = self.analysis.state.distribution.total
        progress = Progress(end, points, start=0.0, quiet=quiet or not self._writes)
        self._show_stage(progress)
        self._tell_user_code()
        failure: str | None = "the run was interrupted by an unexpected error"
        broken = True
        try:
            with progress:
                self._progress = progress
                if self._at_start:
                    progress.message(f"{START}{self._at_start}")
                self._collect_warnings()
                self._say_warnings()
                yield progress
                if not self.analysis.done:
                    self._write_last()
                with together(self.analysis.state.comm):
                    self._checkpoints.wait()
            failure, broken = None, False
            if not self.analysis.done:
                at = f"time {min(end, self.analysis.time):.6g}"
                failure = f"stopped at {at} as requested; `tilth resume` continues"
        except TilthError as error:
            failure = error.message
            with suppress(AnalysisFailed):
                self._write_last()
            raise
        except KeyboardInterrupt as error:
            failure = f"interrupted by {str(error) or 'the user'} after step {clock.step}"
            raise
        except Exception as error:
            if is_memory_error(error):
                failure = f"{memory_sentence(error)} after step {clock.step}"
            raise
        finally:
            self._finish(failure, broken)

    def _finish(self, failure: str | None, broken: bool) -> None:
        """Waits for the checkpoint, completes the log and closes all files.

        Raises `AnalysisFailed` if that cannot be written, unless the run is `broken` by another
        error, which is not to be hidden.
        """
        _core.set_user_code_note()
        unwritten: Exception | None = None
        services = self.analysis.services
        summary = partial(self.log.finish, failure, services.timers.wall, services.solver.summary)
        for action in (
            self._checkpoints.wait, self.results.close, self.tables.close, summary, self.log.close
        ):  # fmt: skip
            try:
                action()
            except Exception as error:
                unwritten = unwritten or error
        if not broken:
            with together(self.analysis.state.comm):
                if unwritten is not None:
                    raise unwritten

    def step(self, clock: Clock, size: float, result: StepResult) -> None:
        """Records a converged step."""
        equilibrium, setup, state = result.equilibrium, self.analysis.setup, self.analysis.state
        self.energies.add(result)
        time = self.analysis.time
        self._collect_warnings()
        with self.analysis.services.timers.measure("other"):
            rows = self.tables.rows(
                clock.time, setup, state, result, self.energies, self.analysis.services.warnings
            )
            stage = (setup.model.stage.name, clock.time)
            shared = processes_text(state)
            with together(state.comm):
                self.log.step(clock.step, time, size, equilibrium.residuals)
                self.log.processes(shared)
                if result.relaxing is not None and result.relaxing.at_rest:
                    self._relaxed(time)
                self._say_warnings()
                self.tables.append(clock.step, time, equilibrium.iterations, rows, stage)
                self._drop_output_of_stop()
            self._last, self.row = (clock.step, time, result), rows[HISTORY]
            if clock.is_output:
                self._write_last()
            every = self.analysis.model.output.checkpoint_every
            if clock.stops or (every and (clock.step % every == 0 or clock.done)):
                self._checkpoint(clock)

    def stop(self) -> None:
        """Writes a checkpoint of the last step, at which the caller stops the run."""
        self._checkpoint_at_once(CHECKPOINT)
        if self.analysis.clock.relaxing:  # a resumed run writes its output when the soil rests
            self._last = None

    def change(self, model: Model, text: str) -> None:
        """Records that the run goes on with a model with other load curves from here.

        A run that is killed meanwhile can be resumed: the checkpoint accepts both models.

        text: what is changed, for the log.
        """
        content = json.dumps(model.to_dict(), indent=1).encode()
        self._next_checksum = zlib.crc32(content)
        self._checkpoint_at_once(CHECKPOINT)
        with together(self.analysis.state.comm):
            if self._writes:
                with writing(self.folder / MODEL):
                    write_durably(self.folder / MODEL, content)
                self.log.change(text)
        self._model_checksum, self._next_checksum = self._next_checksum, None

    def _write_last(self) -> None:
        """Writes the last converged step to the results, unless it is there already."""
        if self._last is None:
            return
        step, time, result = self._last
        state = self._snapshot(result.active, result, step, time)
        with together(self.analysis.state.comm):
            self._output(state)
        self._last = None

    def _drop_output_of_stop(self) -> None:
        """Deletes the output of the stop, which an uninterrupted run would not have."""
        if self._beside_schedule:
            results = read_results(self.folder / RESULTS)
            self.results = ResultsWriter.resume(results.path, results.steps[-1] - 1)
            self._beside_schedule = False

    def _snapshot(
        self, active: ActiveGrid, result: StepResult | None, step: int, time: float
    ) -> Snapshot:
        names = self.analysis.point_fields
        own = snapshot(self.analysis.setup, self.analysis.state, active, result, step, time, names)
        state = gathered_snapshot(own, active)
        there = {surface.name: surface for surface in state.surfaces}
        model = self.analysis.model
        tracked = [body.name for body in model.bodies if body.surface is not None]
        empty = {name: SurfaceShape.empty(name, model.dimension) for name in tracked}
        return replace(
            state,
            surfaces=tuple((empty | there).values()),
            contacts=self.contact.contacts(result),
            rigid_bodies=self.contact.rigid_bodies(self.analysis.state),
        )

    def _output(self, state: Snapshot) -> None:
        if self._writes:
            self.results.append(state)
            self._write_tables(state)

    def _write_tables(self, state: Snapshot) -> None:
        """Writes the tables of surfaces and contact at the last output, where there are any."""
        model = self.analysis.model
        if state.surfaces:
            write_surfaces(self.folder / SURFACE, state, model.units.length)
        if state.contacts:
            units = units_of(model) | {"area": area_unit(model)}
            write_contacts(self.folder / CONTACT, state, units)

    def cut(self, clock: Clock, time: float, failure: StepFailed) -> None:
        """Records that the step towards `time` was undone; `clock` knows the new step size."""
        self._collect_warnings()
        time += self.analysis.setup.model.stage.start
        residuals = " ".join(f"{r:.1e}" for r in failure.residuals)
        reason = f"{failure.reason}; residuals {residuals}" if residuals else failure.reason
        self.log.cut(clock.step + 1, time, clock.size, reason)
        if self._progress is not None:
            self._progress.message(
                f"step {clock.step + 1} to time {time:.6g} undone: {failure.reason}"
            )
        self._say_warnings()

    def _collect_warnings(self) -> None:
        """Notes in all processes what each of them warns of; all call it."""
        self.analysis.services.warnings.collect(self.analysis.state.comm)

    def _say_warnings(self) -> None:
        texts = self.analysis.services.warnings.texts if self._writes else []
        said = {without_stage(text) for text in self.log.warnings} if texts else set()
        for text in texts:
            if self.analysis.number > 0 and without_stage(text) in said:
                continue  # in an earlier stage
            self.log.warning(text)
            if self._progress is not None:
                self._progress.message(f"warning: {text}")
        self.analysis.services.warnings.texts.clear()

    def _checkpoint(self, clock: Clock) -> None:
        """Writes the checkpoint beside the next step, unless it is the first, or a copy is large.

        So an error of any file can tell whether there is something to resume.
        """
        arrays = gathered_state(self.analysis.state)
        with together(self.analysis.state.comm):
            if self._writes:
                self._write_beside(clock, arrays)

    def _checkpoint_at_once(self, name: str) -> None:
        """Writes a checkpoint of the present state to a file of the folder, without a thread."""
        arrays = gathered_state(self.analysis.state)
        with together(self.analysis.state.comm):
            if self._writes:
                meta = self._progress_so_far(self.analysis.clock)
                self._checkpoints.wait()
                self._write_checkpoint(self.folder / name, arrays, meta)

    def _write_beside(self, clock: Clock, arrays: Arrays) -> None:  # in any working folder
        file, meta = (self.folder / CHECKPOINT).absolute(), self._progress_so_far(clock)
        if not file.exists() or sum(each.nbytes for each in arrays.values()) > LARGEST_COPY:
            self._checkpoints.wait()
            self._write_checkpoint(file, arrays, meta)
        else:
            copies = {name: each.copy(order="K") for name, each in arrays.items()}
            self._checkpoints.write(partial(self._write_checkpoint, file, copies, meta))

    def _write_checkpoint(self, file: Path, arrays: Arrays, meta: Mapping[str, Any]) -> None:
        """Writes a checkpoint when the rows that it counts on are on the disk; outputs are."""
        self.tables.sync()
        write_checkpoint(file, arrays, meta)
        self._tell_user_code()

    def _tell_user_code(self) -> None:
        """Says what is left of the run, and in its log, if code of the user ends the process."""
        if self._writes:
            has = (self.folder / CHECKPOINT).exists()
            then = f"; continue from the last checkpoint with: tilth resume {self.folder}" * has
            kept = f"results so far are in {self.folder}{then}"
            _core.set_user_code_note(kept, self.log.file_number)

    def _progress_so_far(self, clock: Clock) -> dict[str, Any]:
        """Returns the plain data of a checkpoint, see `Progress`, which do not change later."""
        return {
            "version": __version__,
            "format": CHECKPOINT_FORMAT,
            "stage": self.analysis.number,
            "clock": clock.state(),
            "energies": asdict(self.energies),
            "model": self._model_checksum,
            **({} if self._next_checksum is None else {"next_model": self._next_checksum}),
            **self.tables.marks(),
            "outputs": list(self.results.outputs),
            **self._earlier_outputs,
            "seconds": {
                "total": self.log.seconds,
                "wall": dict(self.analysis.services.timers.wall),
                "processor": dict(self.analysis.services.timers.processor),
            },
        }
