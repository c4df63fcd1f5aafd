# SPDX-License-Identifier: BSD-3-Clause
"""A new run that goes on from the end of a stage of another one.

The folder of the new run gets what the other one wrote up to that moment, so that history and
results run through, and is then resumed.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tilth.analysis.contact_output import contact_names
from tilth.analysis.differences import differences
from tilth.analysis.motions import motion_columns
from tilth.analysis.staged import PointFields, StagedAnalysis
from tilth.analysis.stored_run import StoredRun
from tilth.errors import BadInput
from tilth.model import Model
from tilth.model.problems import unknown_name
from tilth.output import ResultsWriter, Snapshot, read_checkpoint, read_results, write_checkpoint
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.output.folder import (
    BOUNDARIES,
    CHECKPOINT,
    ENERGIES,
    HISTORY,
    LOG,
    MODEL,
    RESULTS,
    load_model,
    require_folder,
    safety_files,
    stage_checkpoint,
)
from tilth.output.history import mark_of, with_columns
from tilth.output.snapshot import ContactShape, SurfaceShape


def parse_start(text: str) -> tuple[Path, str]:
    """Returns folder and name of the stage of "DIR:STAGE".

    Raises:
        BadInput: it is not of this form.
    """
    folder, colon, stage = text.rpartition(":")
    if not (folder and colon and stage):
        raise BadInput(
            "does not name a folder and a stage",
            'write the folder of a run, a colon and the name of a stage, such as "pit.results:dig"',
            key="from",
            value=text,
        )
    return Path(folder), stage


def stored_stage(model: Model, folder: Path | str, stage: str) -> StoredRun:
    """Returns the run in `folder` at the end of a stage, from which a run of `model` can go on.

    Raises:
        BadInput: there is no such stage, it is not finished, or `model` differs from that of the
            run before its end.
    """
    folder = require_folder(folder)
    earlier = load_model(folder)
    names = [each.stage.name for each in earlier.of_stages if earlier.stages]
    if any(each.name == stage for each in earlier.stages) and stage not in names:
        raise BadInput(
            "this stage is a strength reduction, after which nothing can go on",
            "name the stage before it that loads the soil",
            key="from",
            value=f"{folder}:{stage}",
        )
    if stage not in names:
        words = unknown_name("stage", stage, names)
        raise BadInput(words[0], words[1], key="from", value=f"{folder}:{stage}")
    number = names.index(stage)
    if number >= len(model.of_stages) or model.of_stages[number].stage.name != stage:
        raise BadInput(
            f"the new case does not have {stage!r} after the same stages",
            "leave the stages up to that one as they were",
            key="stages",
        )
    if not (folder / stage_checkpoint(earlier.of_stages[number].stage.index)).exists():
        raise BadInput(
            f"the run in {folder} has not finished the stage {stage!r}",
            f"finish it with: tilth resume {folder}",
            key="from",
            value=f"{folder}:{stage}",
        )
    for key, what in differences(earlier, model, number):
        raise BadInput(
            f"{what} is not as in the run in {folder}, up to the end of the stage {stage!r}",
            "only what comes later may differ; run the whole case for other changes",
            key=key,
        )
    here = model.of_stages[number].stage
    if number + 1 == len(model.of_stages) and not here.reductions:
        raise BadInput(
            f"the case has no stage after {stage!r}", "add the stages that follow", key="stages"
        )
    return StoredRun.read(folder, number)


def begin_from(stored: StoredRun, model: Model, folder: Path) -> None:
    """Writes into an empty folder what the stored run wrote up to its checkpoint.

    The model is the new one; the run is then resumed.

    Raises:
        BadInput: a file of the stored run is damaged.
        AnalysisFailed: a file cannot be written.
    """
    declared = json.dumps(model.to_dict(), indent=1).encode()
    with writing(folder / MODEL):
        write_durably(folder / MODEL, declared)
    with writing(folder / HISTORY):
        write_durably(folder / HISTORY, stored.rows.history)
    boundaries = _rows_of_boundaries(stored, model)
    if boundaries:
        with writing(folder / BOUNDARIES):
            write_durably(folder / BOUNDARIES, boundaries)
    if stored.rows.energies:
        with writing(folder / ENERGIES):
            write_durably(folder / ENERGIES, stored.rows.energies)
    with writing(folder / LOG):
        write_durably(folder / LOG, (stored.folder / LOG).read_bytes())
    outputs = _copy_results(stored, model, folder)
    number = stored.progress.stage
    for i in range(number + 1):
        source, target = (
            stage_checkpoint(each.of_stages[i].stage.index) for each in (stored.model, model)
        )
        if not (stored.folder / source).exists():
            continue
        arrays, meta = read_checkpoint(stored.folder / source)
        meta["model"] = zlib.crc32(declared)
        meta["outputs"] = outputs[: len(meta["outputs"])]
        meta["boundaries"] = mark_of(boundaries, meta["clock"]["step"])
        write_checkpoint(folder / target, arrays, meta)
        if i == number:
            write_checkpoint(folder / CHECKPOINT, arrays, meta)
        elif model.of_stages[i].stage.reductions == stored.model.of_stages[i].stage.reductions:
            _copy_safety(stored, i, folder)


def _rows_of_boundaries(stored: StoredRun, model: Model) -> bytes:
    """Returns boundaries.csv with the columns of the new model; empty if nothing moves in it."""
    columns = motion_columns(model)
    if not columns or columns == motion_columns(stored.model):
        return stored.rows.boundaries if columns else b""
    rows = stored.rows.boundaries or with_columns(stored.rows.history, [])
    return with_columns(rows, columns)


def _copy_safety(stored: StoredRun, number: int, folder: Path) -> None:
    """Copies the files of the strength reductions at the end of an earlier stage."""
    for index, _ in stored.model.of_stages[number].stage.reductions:
        for name in safety_files(index):
            if (source := stored.folder / name).exists():
                with writing(folder / name):
                    write_durably(folder / name, source.read_bytes())


def _copy_results(stored: StoredRun, model: Model, folder: Path) -> list[tuple[int, int]]:
    """Copies the outputs up to the checkpoint, with the fields of the new run's outputs."""
    results = read_results(stored.folder / RESULTS)
    names = StagedAnalysis.fields_of(model)
    old = StagedAnalysis.fields_of(stored.model)
    surfaces = [body.name for body in model.bodies if body.surface is not None]
    writer = ResultsWriter(folder / RESULTS, title=model.title, units=results.units)
    for index in range(len(stored.progress.outputs)):
        state = _with_contact(results.snapshot(index), model)
        writer.append(_with_fields(state, names, old, surfaces))
    writer.close()
    return writer.outputs


def _with_contact(state: Snapshot, model: Model) -> Snapshot:
    """Returns an output with the contact surfaces and rigid bodies of another model."""
    contacts = {shape.name: shape for shape in state.contacts}
    bodies = {shape.name: shape for shape in state.rigid_bodies}
    return replace(
        state,
        contacts=tuple(
            contacts.get(name, ContactShape.empty(name, state.dim)) for name in contact_names(model)
        ),
        rigid_bodies=tuple(
            bodies.get(body.name, SurfaceShape.nowhere(body.name, state.dim))
            for body in model.rigid_bodies
        ),
    )


def _with_fields(
    state: Snapshot, names: PointFields, old: PointFields, surfaces: list[str]
) -> Snapshot:
    """Returns an output with other state variables, varying parameters and surfaces."""
    wanted, known = [*names[0], *names[1]], {*old[0], *old[1]}
    if not names[2]:
        known |= {"effective_stress", "pore_pressure"}
    fields: Mapping[str, Any] = {
        name: values
        for name, values in state.point_fields.items()
        if name in wanted or name not in known
    }
    added = {name: np.full(len(state.position), np.nan) for name in wanted if name not in fields}
    if names[2] and not old[2]:  # without a pore fluid, see `differences`
        added["effective_stress"] = state.point_fields["cauchy_stress"]
        added["pore_pressure"] = np.zeros(len(state.position))
    there = {surface.name: surface for surface in state.surfaces}
    return replace(
        state,
        point_fields={**fields, **added},
        surfaces=tuple(there.get(name, SurfaceShape.empty(name, state.dim)) for name in surfaces),
    )
