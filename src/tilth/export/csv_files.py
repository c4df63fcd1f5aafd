# SPDX-License-Identifier: BSD-3-Clause
"""Tables of the points and surfaces, one file per output, with all digits."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilth.export.files import FileNames, NewFolder
from tilth.export.source import Source, components
from tilth.output.snapshot import ContactShape, Snapshot, SurfaceShape
from tilth.report.fields import AXES, with_unit

OUTPUTS = "outputs.csv"
"""The table of the outputs: number, step and time."""

_UNITS = {
    "area": "area",
    "arc_length": "length",
    "gap": "length",
    "normal_stress": "stress",
    "shear_stress": "stress",
}
"""Units of the fields of surfaces; others are pure numbers."""


def write_outputs(source: Source, folder: NewFolder) -> None:
    """Writes the table of the exported outputs; raises ``AnalysisFailed`` if it cannot be."""
    results = source.results
    columns: dict[str, list[Any]] = {
        "output": list(source.outputs),
        "step": [results.steps[index] for index in source.outputs],
        with_unit("time", results.units.get("time", "")): [
            results.times[index] for index in source.outputs
        ],
    }
    _write(folder, OUTPUTS, columns)


def write_csv(source: Source, folder: NewFolder) -> None:
    """Writes ``points_0000.csv``, ... and a table for each surface, contact and rigid body.

    A row is a point or a vertex. Raises ``AnalysisFailed`` if a file cannot be written.
    """
    names = FileNames()
    for index in source.outputs:
        snapshot = source.results.snapshot(index)
        _write(folder, f"points_{index:04d}.csv", _of_points(source, snapshot))
        for family, shapes in (
            ("surface_", snapshot.surfaces),
            ("contact_", snapshot.contacts),
            ("rigid_", snapshot.rigid_bodies),
        ):
            for shape in shapes:
                name = f"{names.of(family, shape.name)}_{index:04d}.csv"
                _write(folder, name, _of_surface(source, shape))


def _of_points(source: Source, snapshot: Snapshot) -> dict[str, list[Any]]:
    columns: dict[str, list[Any]] = {
        "point_id": snapshot.point_id.tolist(),
        "body": [source.body_name(body) for body in snapshot.body_id.tolist()],
    }
    columns |= _positions(source, snapshot.position)
    for name, values in source.values(snapshot).items():
        columns |= _of_field(name, values, source.fields[name])
    return columns


def _of_surface(source: Source, shape: SurfaceShape | ContactShape) -> dict[str, list[Any]]:
    units = source.results.units | {"area": source.area_unit}
    columns = _positions(source, shape.position)
    for name, values in shape.fields.items():
        unit = units.get(_UNITS.get(name, ""), "")
        columns |= _of_field(name, values, unit)
    return columns


def _positions(source: Source, position: NDArray[np.float64]) -> dict[str, list[Any]]:
    unit = source.results.units.get("length", "")
    return {
        with_unit(axis, unit): column.tolist()
        for axis, column in zip(AXES, position.T, strict=False)
    }


def _of_field(name: str, values: NDArray[Any], unit: str) -> dict[str, list[Any]]:
    columns = values.reshape(len(values), int(np.prod(values.shape[1:]))).T
    headings = (with_unit(each, unit) for each in components(name, values))
    return {heading: column.tolist() for heading, column in zip(headings, columns, strict=True)}


def _write(folder: NewFolder, name: str, columns: Mapping[str, Sequence[Any]]) -> None:
    """Writes columns of equal length by their headings."""
    with folder.file(name) as path, path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(columns)
        table.writerows(zip(*columns.values(), strict=True))
