# SPDX-License-Identifier: BSD-3-Clause
"""What a run left in its folder, checked before it is resumed; nothing is changed on the disk."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tilth import __version__
from tilth.analysis.owners import MissingState, WrongState
from tilth.analysis.staged import StagedAnalysis, output_times
from tilth.analysis.step_tables import StoredRows
from tilth.errors import BadInput, StepFailed, shown
from tilth.model import Model
from tilth.output import read_checkpoint, read_results
from tilth.output.files import RESTORE
from tilth.output.folder import (
    CHECKPOINT,
    MODEL,
    RESULTS,
    load_model,
    stage_checkpoint,
)
from tilth.output.history import Mark

CHECKPOINT_FORMAT = 9
"""Version of what a checkpoint contains."""

_Seconds = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
_Number = Annotated[int, Field(ge=0)]


class _Plain(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class ClockState(_Plain):
    """Where the run is in its schedule, see `Clock`."""

    step: Annotated[int, Field(ge=1)]
    time: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
    size: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
    successes: _Number
    relaxing: bool


class TimeTaken(_Plain):
    """Wall-clock time of the run [s], and wall-clock and processor time of its parts, by name."""

    total: _Seconds
    wall: dict[str, _Seconds]
    processor: dict[str, _Seconds]


_Energy = Annotated[float, Field(allow_inf_nan=False)]


class EnergySums(_Plain):
    """As `Energies`."""

    start: _Energy
    work: _Energy
    friction: _Energy
    damping: _Energy
    radiated: _Energy
    integration: _Energy
    stabilisation: _Energy
    gaps: _Energy
    seepage: _Energy


class EarlierOutputs(_Plain):
    """The outputs of a run that went on with another model, up to the total time `until`."""

    until: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
    times: list[Annotated[float, Field(ge=0.0, allow_inf_nan=False)]]


class Progress(_Plain):
    """The plain data of a checkpoint, and what it counts on in the other files.

    Attributes:
        version: of tilth.
        format: of the checkpoint, `CHECKPOINT_FORMAT`.
        stage: number of the stage among those of the type "loading", from 0.
        clock: where the run is in its schedule.
        energies: see `Energies`.
        model: check sum of model.json.
        next_model: the same after the change of a load that was being made; None without.
        history: size and check sum of the rows of history.csv up to the step.
        boundaries: the same of boundaries.csv; zeros without that file.
        energy_rows: the same of energies.csv.
        outputs: step and check sum of each output up to the step.
        earlier_outputs: the first of them, where they are those of an earlier model; else None.
        seconds: time taken so far.
    """

    version: str
    format: _Number
    stage: _Number
    clock: ClockState
    energies: EnergySums
    model: _Number
    next_model: _Number | None = None
    history: tuple[_Number, _Number]
    boundaries: tuple[_Number, _Number]
    energy_rows: tuple[_Number, _Number]
    outputs: list[tuple[_Number, _Number]]
    earlier_outputs: EarlierOutputs | None = None
    seconds: TimeTaken


@dataclass(frozen=True)
class StoredRun:
    """A run that can be resumed.

    Attributes:
        folder: of the run.
        model: the declared problem.
        progress: plain data of the checkpoint.
        rows: of the files with one row per step, up to the checkpoint.
        checkpoint: its file.
    """

    folder: Path
    model: Model
    progress: Progress
    rows: StoredRows
    checkpoint: Path
    _arrays: Mapping[str, npt.NDArray[Any]]

    @classmethod
    def read(cls, folder: Path, stage: int | None = None) -> StoredRun:
        """Reads and checks the files of a run.

        stage: number of the stage whose end is meant, as `Progress.stage`; None for the last
            checkpoint.

        Raises:
            BadInput: one is missing, damaged, or not as the checkpoint expects it.
        """
        model = load_model(folder)
        checkpoint = folder / CHECKPOINT
        if stage is not None:
            checkpoint = folder / stage_checkpoint(model.of_stages[stage].stage.index)
        arrays, meta = read_checkpoint(checkpoint)
        progress = _progress(checkpoint, meta)
        known = (progress.model, progress.next_model)
        if _checksums(folder / MODEL).isdisjoint(known):
            remedy = (
                "restore it from a copy; to go on with a later end, further stages, or other loads "
                f"from here on, change the case file: tilth run CASE.toml --continue {folder}"
            )
            raise BadInput(f"{folder / MODEL} was changed after the run began", remedy)
        progress = _in_schedule(progress, model)
        _check_clock(checkpoint, progress, model)
        kept = progress.history, progress.boundaries, progress.energy_rows
        marks = (Mark(*each) for each in kept)
        rows = StoredRows.read(folder, model, progress.clock.step, *marks)
        _check_outputs(folder / RESULTS, progress, model)
        return cls(folder, model, progress, rows, checkpoint, arrays)

    def analysis(self, until: float | None) -> StagedAnalysis:
        """Returns the analysis in the state of the checkpoint; until: see `StagedAnalysis`.

        Raises:
            BadInput: the checkpoint's arrays are not those of this model.
        """
        file = self.checkpoint
        try:
            analysis = StagedAnalysis.restored(
                self.model, self.progress.stage, self.progress.clock.model_dump(), self._arrays,
                until,
            )  # fmt: skip
            analysis.simulation.locate(self.progress.clock.time)
            return analysis
        except MissingState as missing:
            raise BadInput(
                f"{file} has no {str(missing)!r}: it is of another version of tilth "
                f"({self.progress.version})",
                "resume it with that version, or run the case again",
            ) from missing
        except (WrongState, StepFailed) as wrong:
            raise BadInput(f"{file} does not fit the model: {wrong}", RESTORE) from wrong
        except BadInput as error:
            raise error if error.file else error.in_file(self.folder / MODEL) from None


def _progress(file: Path, meta: Mapping[str, Any]) -> Progress:
    if (found := meta.get("format")) != CHECKPOINT_FORMAT:
        which = "has no format" if found is None else f"is of format {shown(found)}"
        raise BadInput(
            f"{file} {which} (tilth {shown(meta.get('version', 'unknown'))} wrote it); this "
            f"version of tilth ({__version__}) reads format {CHECKPOINT_FORMAT}",
            "resume it with that version, or run the case again",
        )
    try:
        # lists of JSON stand for tuples
        entries = dict(meta)
        for file_of_rows in ("history", "boundaries", "energy_rows"):
            if isinstance(entries.get(file_of_rows), list):
                entries[file_of_rows] = tuple(entries[file_of_rows])
        if isinstance(entries.get("outputs"), list):
            entries["outputs"] = [
                tuple(each) if isinstance(each, list) else each for each in entries["outputs"]
            ]
        return Progress.model_validate(entries)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key = ".".join(map(str, first["loc"]))
        if first["type"] == "missing":
            problem = f"has no {key!r}"
        else:
            problem = f"{key} = {shown(first['input'])} is wrong ({first['msg'].lower()})"
        raise BadInput(
            f"{file}: {problem}: it is damaged or of another version of tilth "
            f"({shown(meta.get('version', 'unknown'))})",
            "resume it with that version, restore it from a copy, or run the case again",
        ) from None


def _checksums(file: Path) -> set[int]:
    """Returns the check sum of model.json, and that of its entries as tilth writes them."""
    content = file.read_bytes()
    rewritten = json.dumps(json.loads(content), indent=1).encode()
    return {zlib.crc32(content), zlib.crc32(rewritten)}


def _in_schedule(progress: Progress, model: Model) -> Progress:
    """Returns the progress of a run in the schedule of the model with which it goes on from there.

    Its last time may differ from one of the new schedule by round-off, and its step may be larger.
    """
    if progress.earlier_outputs is None or progress.stage >= len(model.of_stages):
        return progress
    of_stage, clock = model.of_stages[progress.stage], progress.clock
    schedule = of_stage.schedule
    time = schedule.snapped(clock.time)
    if of_stage.stage.start + time != progress.earlier_outputs.until:
        return progress  # it has gone on since
    here = clock.model_copy(update={"time": time, "size": min(clock.size, schedule.largest_step)})
    return progress.model_copy(update={"clock": here})


def _check_clock(file: Path, progress: Progress, model: Model) -> None:
    if progress.stage >= len(model.of_stages):
        problem = f"{file}: stage = {progress.stage} is more than the model has"
        raise BadInput(problem, RESTORE)
    clock, schedule = progress.clock, model.of_stages[progress.stage].schedule
    for name, value, most in (
        ("time", clock.time, schedule.end),
        ("size", clock.size, schedule.largest_step * (1.0 + 1e-9)),
    ):
        if value > most:
            problem = f"{file}: clock.{name} = {value:g} is more than the schedule's {most:g}"
            raise BadInput(problem, RESTORE)


def _check_outputs(file: Path, progress: Progress, model: Model) -> None:
    """Checks that the results have every output up to the checkpoint, as it was written.

    The state at which a run stopped may come in addition.
    """
    results, clock = read_results(file), progress.clock
    total = model.of_stages[progress.stage].stage.start + clock.time
    earlier = progress.earlier_outputs
    first, since = ([0.0], 0.0) if earlier is None else (earlier.times, earlier.until)
    due = [*first, *(time for time in output_times(model) if since < time <= total)]
    if clock.relaxing and due[-1] == total:
        due.pop()
    found = [output for output in results.outputs if output[0] <= clock.step]
    if found != progress.outputs and not (
        found[:-1] == progress.outputs and found[-1][0] == clock.step
    ):
        here = dict(found)
        wrong = [step for step, checksum in progress.outputs if here.get(step) != checksum]
        problem = f"the output of step {wrong[0]} is missing or changed" if wrong else (
            f"there are more outputs up to step {clock.step} than the checkpoint counts on"
        )  # fmt: skip
        raise BadInput(f"{file}: {problem}", RESTORE)
    times = results.times[: len(progress.outputs)]
    if times != due:
        problem = f"the times of output {times} are not those of the schedule, {due}"
        raise BadInput(f"{file}: {shown(problem, 300)}", RESTORE)
    for index in range(len(found)):
        results.snapshot(index)
