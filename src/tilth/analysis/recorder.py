# SPDX-License-Identifier: BSD-3-Clause
"""What is written of an analysis while it runs: results, history, log and checkpoints."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth import __version__
from tilth.analysis.clock import Clock
from tilth.analysis.contact_output import ContactOutput
from tilth.analysis.energies import Energies
from tilth.analysis.initial_equilibrium import InitialEquilibrium
from tilth.analysis.model_warnings import without_stage
from tilth.analysis.motions import area_unit
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import PointFields, StagedAnalysis, end_time, output_times
from tilth.analysis.state import Arrays
from tilth.analysis.step_result import StepResult
from tilth.analysis.step_tables import StepTables
from tilth.analysis.stored_run import CHECKPOINT_FORMAT, StoredRun
from tilth.arrays import Floats, Integers
from tilth.errors import AnalysisFailed, StepFailed, TilthError
from tilth.fields.tables import place_text
from tilth.memory_errors import is_memory_error, memory_sentence
from tilth.model import Model
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.mpm.wet_mass import effective_stress, pore_pressure, total_stress
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
from tilth.output.folder import (
    CHECKPOINT,
    CONTACT,
    LOG,
    MODEL,
    RESULTS,
    SURFACE,
    stage_checkpoint,
)
from tilth.output.log import START
from tilth.output.snapshot import FieldsOnDemand, SurfaceShape


@dataclass
class Recorder:
    """Writes the files of a run; checkpoints beside the next step."""

    folder: Path
    analysis: StagedAnalysis
    results: ResultsWriter
    tables: StepTables
    contact: ContactOutput
    log: RunLog
    energies: Energies
    """Sums over the steps since the start."""
    _model_checksum: int
    _checkpoints: CheckpointThread = field(default_factory=CheckpointThread)
    _progress: Progress | None = None
    _last: tuple[int, float, StepResult] | None = None
    _at_start: str = ""
    """How the equilibrium of the initial state was found."""
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
    ) -> Recorder:
        """Begins the files of a new run and writes the initial state.

        start: how the equilibrium of this state was found.
        """
        model, simulation = analysis.model, analysis.simulation
        recorder = cls(
            folder=folder,
            analysis=analysis,
            results=ResultsWriter(folder / RESULTS, title=model.title, units=units_of(model)),
            tables=StepTables(folder, model, analysis.initial),
            contact=ContactOutput(model, analysis.initial),
            log=RunLog(folder / LOG),
            energies=Energies.at_start(simulation),
            _model_checksum=zlib.crc32((folder / MODEL).read_bytes()),
        )
        recorder._header(len(active.cells()), threads, 0)
        result, iterations = None, 0
        if start is not None:
            result, active, iterations = start.result, start.result.active, start.iterations
            recorder._at_start = start.text(model.units.stress)
            recorder.log.start(recorder._at_start)
        recorder._output(recorder._snapshot(active, result, 0, 0.0))
        recorder.tables.append(0, (0.0, 0.0), simulation, result, iterations, recorder.energies)
        recorder._log_stage()
        return recorder

    @classmethod
    def resume(cls, stored: StoredRun, analysis: StagedAnalysis, threads: int) -> Recorder:
        """Goes on with the files of a run, dropping what was written after the checkpoint."""
        model, folder, progress = stored.model, stored.folder, stored.progress
        step, simulation = progress.clock.step, analysis.simulation
        simulation.timers.wall |= progress.seconds.wall
        simulation.timers.processor |= progress.seconds.processor
        active = simulation.locate(progress.clock.time)
        initial = analysis.initial if model.stages else initial_points(model)
        recorder = cls(
            folder=folder,
            analysis=analysis,
            results=ResultsWriter.resume(folder / RESULTS, step),
            tables=StepTables(folder, model, initial, stored.rows),
            contact=ContactOutput(model, initial),
            log=RunLog(folder / LOG, resume=True, seconds=progress.seconds.total),
            energies=Energies(**progress.energies.model_dump()),
            _model_checksum=progress.model,
        )
        kept = read_results(folder / RESULTS)
        regular = {0.0, *output_times(model)}
        recorder._beside_schedule = kept.times[-1] not in regular
        if kept.surfaces or kept.names["contacts"]:
            recorder._write_tables(kept.snapshot(-1))
        recorder._header(len(active.cells()), threads, step)
        return recorder

    @property
    def simulation(self) -> Simulation:
        """The simulation of the present stage."""
        return self.analysis.simulation

    def stage_end(self) -> None:
        """Keeps the state at the end of a stage as a checkpoint of its own."""
        if self.analysis.model.stages:
            index = self.simulation.model.stage.index
            meta = self._progress_so_far(self.analysis.clock)
            self._checkpoints.wait()
            file = self.folder / stage_checkpoint(index)
            self._write_checkpoint(file, self.simulation.arrays(), meta)

    def factor_of_safety(self, stage: str, factor: float, above: float) -> None:
        """Records the result of a strength reduction."""
        text = f"factor of safety {factor:.4g} (none in equilibrium from {above:.4g} on)"
        self.log.reduction(stage, self.analysis.time, text)
        if self._progress is not None:
            self._progress.message(f"{stage}: {text}")

    def _relaxed(self, time: float) -> None:
        """Records that soil has come to rest beyond a limit load."""
        relaxation = self.simulation.relaxation
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
        self._say_warnings()
        self._log_stage()
        if self._progress is not None:
            self._show_stage(self._progress)

    def _show_stage(self, progress: Progress) -> None:
        stage = self.simulation.model.stage
        if stage.name:
            points, count = len(self.simulation.points), len(self.analysis.model.stages)
            progress.stage(stage.name, stage.index + 1, count, points)

    def _log_stage(self) -> None:
        stage = self.simulation.model.stage
        if stage.name:
            released = "" if stage.number == 0 else place_text(self.analysis.out_of_balance)
            self.log.stage(stage.name, stage.start, released)

    def _header(self, cells: int, threads: int, last_step: int) -> None:
        self.log.header(
            version=__version__,
            title=self.simulation.model.title,
            threads=threads,
            points=len(self.simulation.points),
            cells=cells,
            last_step=last_step,
        )

    @contextmanager
    def recording(self, clock: Clock, quiet: bool) -> Iterator[Progress]:
        """Shows progress; closes all files however the run ends, and logs why."""
        end = end_time(self.analysis.model)
        if clock.until is not None:
            end = self.simulation.model.stage.start + clock.until
        progress = Progress(end, len(self.simulation.points), start=0.0, quiet=quiet)
        self._show_stage(progress)
        failure: str | None = "the run was interrupted by an unexpected error"
        broken = True
        try:
            with progress:
                self._progress = progress
                if self._at_start:
                    progress.message(f"{START}{self._at_start}")
                self._say_warnings()
                yield progress
                if not self.analysis.done:
                    self._write_last()
                self._checkpoints.wait()
            failure, broken = None, False
            if not self.analysis.done:
                at = f"time {end:.6g}"
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
        unwritten: Exception | None = None
        summary = partial(
            self.log.finish, failure, self.simulation.timers.wall, self.simulation.solved
        )
        for action in (
            self._checkpoints.wait, self.results.close, self.tables.close, summary, self.log.close
        ):  # fmt: skip
            try:
                action()
            except Exception as error:
                unwritten = unwritten or error
        if unwritten is not None and not broken:
            raise unwritten

    def step(self, clock: Clock, size: float, result: StepResult) -> None:
        """Records a converged step."""
        equilibrium = result.equilibrium
        self.energies.add(result)
        time = self.analysis.time
        self.log.step(clock.step, time, size, equilibrium.residuals)
        if result.relaxing is not None and result.relaxing.at_rest:
            self._relaxed(time)
        self._say_warnings()
        model = self.analysis.model
        with self.simulation.timers.measure("other"):
            self.tables.append(
                clock.step, (time, clock.time), self.simulation, result,
                equilibrium.iterations, self.energies,
            )  # fmt: skip
            self._last = (clock.step, time, result)
            self._drop_output_of_stop()
            if clock.is_output:
                self._write_last()
            every = model.output.checkpoint_every
            if clock.stops or (every and (clock.step % every == 0 or clock.done)):
                self._checkpoint(clock)

    def _write_last(self) -> None:
        """Writes the last converged step to the results, unless it is there already."""
        if self._last is None:
            return
        step, time, result = self._last
        self._output(self._snapshot(result.active, result, step, time))
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
        state = snapshot(self.simulation, active, result, step, time, self.analysis.point_fields)
        there = {surface.name: surface for surface in state.surfaces}
        model = self.analysis.model
        names = [body.name for body in model.bodies if body.surface is not None]
        empty = {name: SurfaceShape.empty(name, model.dimension) for name in names}
        return replace(
            state,
            surfaces=tuple((empty | there).values()),
            contacts=self.contact.contacts(result),
            rigid_bodies=self.contact.rigid_bodies(self.simulation),
        )

    def _output(self, state: Snapshot) -> None:
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
        time += self.simulation.model.stage.start
        residuals = " ".join(f"{r:.1e}" for r in failure.residuals)
        reason = f"{failure.reason}; residuals {residuals}" if residuals else failure.reason
        self.log.cut(clock.step + 1, time, clock.size, reason)
        if self._progress is not None:
            self._progress.message(
                f"step {clock.step + 1} to time {time:.6g} undone: {failure.reason}"
            )
        self._say_warnings()

    def _say_warnings(self) -> None:
        said = {without_stage(text) for text in self.log.warnings}
        for text in self.simulation.warnings:
            if self.analysis.number > 0 and without_stage(text) in said:
                continue  # in an earlier stage
            self.log.warning(text)
            if self._progress is not None:
                self._progress.message(f"warning: {text}")
        self.simulation.warnings.clear()

    def _checkpoint(self, clock: Clock) -> None:
        """Writes the checkpoint beside the next step, unless it is the first, or a copy is large.

        So an error of any file can tell whether there is something to resume.
        """
        file, meta = self.folder / CHECKPOINT, self._progress_so_far(clock)
        arrays = self.simulation.arrays()
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

    def _progress_so_far(self, clock: Clock) -> dict[str, Any]:
        """Returns the plain data of a checkpoint, see `Progress`, which do not change later."""
        return {
            "version": __version__,
            "format": CHECKPOINT_FORMAT,
            "stage": self.analysis.number,
            "clock": {
                "step": clock.step,
                "time": clock.time,
                "size": clock.size,
                "successes": clock.successes,
                "relaxing": clock.relaxing,
            },
            "energies": asdict(self.energies),
            "model": self._model_checksum,
            **self.tables.marks(),
            "outputs": list(self.results.outputs),
            "seconds": {
                "total": self.log.seconds,
                "wall": dict(self.simulation.timers.wall),
                "processor": dict(self.simulation.timers.processor),
            },
        }


def snapshot(
    simulation: Simulation,
    active: ActiveGrid,
    result: StepResult | None,
    step: int,
    time: float,
    names: PointFields | None = None,
) -> Snapshot:
    """Returns the state for the results file, points in the order of their permanent numbers.

    The point fields are computed on access: write them before the points change.

    names: what fields there are; those of the points and the water if None.
    """
    points, water = simulation.points, simulation.water
    order = points.in_order
    number = points.point_id[order]
    of_stage = time - simulation.model.stage.start
    states, varying, wet = names or (
        points.state_variables(), list(points.varying), water is not None
    )  # fmt: skip
    fields: dict[str, Callable[[], npt.NDArray[Any]]] = {
        "displacement": lambda: points.displacement[order],
        "cauchy_stress": lambda: total_stress(points, water, of_stage)[order],
        **{name: partial(lambda name: points.state_variable(name)[order], name) for name in states},
        "volume": lambda: points.volume[order],
        **{name: partial(_varying, points, name, number) for name in varying},
        "domain": lambda: points.half_length[order],
    }
    if wet:
        fields["effective_stress"] = lambda: effective_stress(points)[order]
        fields["pore_pressure"] = lambda: pore_pressure(points, water, of_stage)[order]
    if simulation.model.analysis.inertia is not None:
        fields["velocity"] = lambda: points.motion[order, 0]
        fields["acceleration"] = lambda: points.motion[order, 1]
    corners = points.all_corners()
    if corners is not None:
        fields["domain_corners"] = lambda: corners[order]
    if any(body.layers for body in simulation.model.bodies):
        fields["layer"] = lambda: points.layer[order]
    if simulation.model.output.deformation_gradient:
        fields["deformation_gradient"] = lambda: points.deformation_gradient[order]
    zero = np.zeros(active.position.shape)
    return Snapshot(
        step=step,
        time=time,
        position=points.position[order],
        point_id=number,
        body_id=points.body_id[order],
        point_fields=FieldsOnDemand(fields),
        node_position=active.position,
        cells=active.cells(),
        node_fields={
            "displacement": zero if result is None else result.equilibrium.displacement,
            "reaction": zero if result is None else result.reaction,
        },
        surfaces=simulation.surface_shapes(),
    )


def _varying(points: MaterialPoints, name: str, number: Integers) -> Floats:
    """Returns a varying parameter at points by their numbers, NaN where it does not vary, (n,)."""
    if name not in points.varying:
        return np.full(len(number), np.nan)
    return points.varying[name][number]


def units_of(model: Model) -> dict[str, str]:
    """Returns the labels of the units, and of the state variables of the user's laws."""
    labels = {name: str(label) for name, label in model.units.model_dump().items()}
    of_laws = {name for law in model.laws.values() if law.source for name in law.state_variables}
    units = model.state_units()
    own = {name: labels["stress"] for name in sorted(of_laws) if units[name] == "stress"}
    return labels | own
