# SPDX-License-Identifier: BSD-3-Clause
"""A run that goes on in its folder with a model that differs only in what is still to come.

Nothing is lost whenever this is interrupted: checkpoints that accept the earlier model and the new
one come first, model.json last.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator
from pathlib import Path

from tilth.analysis.contact_output import contact_names
from tilth.analysis.differences import (
    END,
    differences,
    differing_tables,
    first_difference,
    without_tables,
)
from tilth.analysis.motions import motion_columns
from tilth.analysis.staged import StagedAnalysis, end_time
from tilth.analysis.stored_run import StoredRun
from tilth.errors import BadInput, shown
from tilth.model import Model
from tilth.output import read_checkpoint, read_results, write_checkpoint
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.output.folder import CHECKPOINT, MODEL, RESULTS, SETUP, stage_checkpoint
from tilth.report.setup_data import Setup
from tilth.report.setup_file import write_setup
from tilth.report.stage_setups import StagedSetup

_FREE = ("format", "title", "schedule", "stages", "output")
"""What may differ in a model without stages: it is not needed for what is done."""

_LATER = (
    "only what comes later may differ: the schedule, rows of tables after this time, stages at the "
    "end, the title and `output`; run the whole case for other changes"
)


def require_continuable(stored: StoredRun, model: Model, until: float | None) -> str:
    """Checks that a run can go on with another model from where it is.

    until: total time at which it is to stop; None for the end. Returns what is new, for the log.

    Raises:
        BadInput: the models differ in something that has already acted, nothing is to come, or the
            files of the run lack what the new stages bring.
    """
    earlier, clock = stored.model, stored.progress.clock
    number = stored.progress.stage
    reached = earlier.of_stages[number].stage.start + clock.time
    where = f"as in the run in {stored.folder}, which has reached the time {reached:.6g}"
    if clock.relaxing:
        what = f"in the run in {stored.folder} soil is coming to rest beyond a limit load"
        raise BadInput(what, f"let it come to rest first: tilth resume {stored.folder}")
    _require_same_stages(earlier, model, number)
    if earlier.stages:
        for key, what in differences(earlier, model, number, clock.time):
            raise BadInput(f"{what} is not {where}", _LATER, key=key)
        _require_same_files(stored.folder, earlier, model, number)
    else:
        for key in _first_differences(earlier, model):
            raise BadInput(f"is not {where}", _LATER, key=key)
    for key, curve in differing_tables(
        earlier.of_stages[number], model.of_stages[number], clock.time
    ):
        if key.endswith(END):
            what = "must stay: the water moves to its `level` up to there, and is on its way"
            raise BadInput(what, "leave it, and add a stage for what follows", key=key)
        rows = [[float(time), float(value)] for time, value in curve.table]
        raise BadInput(
            f"is not {where}: there it was {shown(rows, 200)}",
            "write these rows, up to this time, and others after them (without a table it grows up "
            "to the end of the schedule)",
            key=key,
        )
    last = model.of_stages[number]
    round_off = 1e-9 * last.schedule.first_step
    key = "schedule.end" if not model.stages else f"{last.stage.key}.schedule.end"
    if last.schedule.end < clock.time - round_off:
        what = f"is before the time {clock.time:.6g} that the run in {stored.folder} has reached"
        raise BadInput(what, "give a later one", key=key, value=last.schedule.end)
    if end_time(model) <= reached + round_off:
        what = f"nothing is to come: the run in {stored.folder} has reached the time {reached:.6g}"
        raise BadInput(what, "give a later end, or add a stage", key=key, value=last.schedule.end)
    if until is not None and until <= reached + round_off:
        what = f"the run is already complete up to time {reached:.6g}"
        raise BadInput(what, "give a later time, or leave it out", key="until", value=until)
    added = len(model.stages) - len(earlier.stages)
    stages = f", with {added} more stage{'s' if added > 1 else ''}" if added > 0 else ""
    return f"from time {reached:.6g} to {end_time(model):.6g} (was {end_time(earlier):.6g}){stages}"


def _first_differences(earlier: Model, model: Model) -> Iterator[str]:
    """Yields the keys of what differs in two models without stages, without their tables."""
    for key in type(model).model_fields:
        if key not in _FREE:
            before, after = (without_tables(getattr(each, key)) for each in (earlier, model))
            if found := first_difference(before, after, key):
                yield found
    if earlier.output.deformation_gradient != model.output.deformation_gradient:
        yield "output.deformation_gradient"


def _require_same_stages(earlier: Model, model: Model, number: int) -> None:
    """Checks that a model has the stages up to a number, by name, and in the same places."""
    names = [
        [(each.stage.index, each.stage.name) for each in of]
        for of in _up_to(number, earlier, model)
    ]
    if names[0] != names[1] or bool(earlier.stages) != bool(model.stages):
        done = ", ".join(repr(name) for _, name in names[0]) if earlier.stages else "none"
        raise BadInput(
            f"are not those of the run up to where it is ({done})",
            "leave these stages as they were, and add others after them",
            key="stages",
        )
    for one, other in zip(*_up_to(number - 1, earlier, model), strict=True):
        if one.stage.reductions != other.stage.reductions:
            what = "a strength reduction after this stage is not as in the run"
            raise BadInput(what, _LATER, key=other.stage.key)


def _up_to(number: int, *models: Model) -> list[tuple[Model, ...]]:
    return [model.of_stages[: number + 1] for model in models]


def _require_same_files(folder: Path, earlier: Model, model: Model, number: int) -> None:
    """Checks that results and tables of a run have all that the stages of a model write."""
    name = earlier.of_stages[number].stage.name
    for what, one, other in (
        ("fields", *(StagedAnalysis.fields_of(each) for each in (earlier, model))),
        ("tracked surfaces", *(_surfaces(each) for each in (earlier, model))),
        ("contact surfaces", *(contact_names(each) for each in (earlier, model))),
        ("rigid bodies", *([b.name for b in each.rigid_bodies] for each in (earlier, model))),
        ("columns of boundaries.csv", *(motion_columns(each) for each in (earlier, model))),
    ):
        if one != other:
            raise BadInput(
                f"the new stages bring {what} that the results in {folder} do not have",
                "go on in another folder, into which they are copied with these: tilth run "
                f"CASE.toml --from {folder}:{name} --out NEW",
                key="stages",
            )


def _surfaces(model: Model) -> list[str]:
    return [body.name for body in model.bodies if body.surface is not None]


def go_on_with(stored: StoredRun, model: Model, setup: Setup | StagedSetup) -> None:
    """Writes into the folder of a run that it goes on with another model; it is then resumed.

    Raises:
        AnalysisFailed: a file cannot be written. The run is then as it was.
    """
    folder = stored.folder
    declared = json.dumps(model.to_dict(), indent=1).encode()
    checksums = {
        "model": zlib.crc32((folder / MODEL).read_bytes()),
        "next_model": zlib.crc32(declared),
    }
    times = read_results(folder / RESULTS).times
    of_stages = stored.model.of_stages[: stored.progress.stage + 1] if model.stages else ()
    files = [folder / stage_checkpoint(each.stage.index) for each in of_stages]
    for file in [*files, folder / CHECKPOINT]:
        if file.exists():
            arrays, meta = read_checkpoint(file)
            of_stage = model.of_stages[meta["stage"]]
            earlier = {
                "until": of_stage.stage.start + of_stage.schedule.snapped(meta["clock"]["time"]),
                "times": list(times[: len(meta["outputs"])]),
            }
            write_checkpoint(file, arrays, meta | checksums | {"earlier_outputs": earlier})
    write_setup(folder / SETUP, setup)
    with writing(folder / MODEL):
        write_durably(folder / MODEL, declared)
