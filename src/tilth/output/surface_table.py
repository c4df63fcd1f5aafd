# SPDX-License-Identifier: BSD-3-Clause
"""``surface.csv``: the vertices of all tracked surfaces at the last output."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilth.errors import BadInput
from tilth.input_files import require_file
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.output.snapshot import Snapshot, SurfaceShape

WHOLE_NUMBERS = ("step", "chain", "closed", "point")
"""Columns of whole numbers, counted from 0; ``closed`` is 1 or 0."""


def write_surfaces(path: Path | str, snapshot: Snapshot, length_unit: str) -> None:
    """Writes the table of the surfaces of ``snapshot``, replacing an older one atomically.

    In 2D each row is a point of a chain, in order along the curve, in 3D a vertex of the triangles.
    ``point`` is the vertex's number in the results file. Numbers are written with all digits, so
    that reading is bit-exact. A kill at any moment leaves the old or the new file. Raises
    ``AnalysisFailed`` if it cannot be written.
    """
    axes, unit = "xyz"[: snapshot.dim], f" [{length_unit}]" if length_unit else ""
    headings = ["step", "time", "surface"]
    headings += ["chain", "closed", "point"] if snapshot.dim == 2 else ["point"]
    headings += [f"{axis}{unit}" for axis in axes]
    headings += [f"arc_length{unit}"] if snapshot.dim == 2 else []
    headings += [f"normal_{axis}" for axis in axes]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(headings)
    moment = [str(snapshot.step), repr(float(snapshot.time))]
    for surface in snapshot.surfaces:
        rows = _plane_rows(surface) if snapshot.dim == 2 else _space_rows(surface)
        table.writerows([*moment, surface.name, *row] for row in rows)
    with writing(Path(path)):
        write_durably(Path(path), text.getvalue().encode())


def read_surface(path: Path | str) -> dict[str, NDArray[Any]]:
    """Returns all columns of a ``surface.csv`` by heading, each of shape (rows,).

    ``surface`` is text; ``step``, ``point`` and in 2D ``chain`` and ``closed`` are whole numbers;
    all others are floats, bit-exact. Raises ``BadInput`` if it is no such file.
    """
    path = Path(path)
    try:
        require_file(path)
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
    except OSError as error:
        raise BadInput(
            f"{path} cannot be read: {error.strerror}",
            "name the surface.csv of a run with tracked surfaces",
        ) from error
    if not rows or "surface" not in rows[0]:
        raise BadInput(f"{path} is not the surface.csv of a tilth run")
    columns: dict[str, NDArray[Any]] = {}
    try:
        for index, heading in enumerate(rows[0]):
            values = [row[index] for row in rows[1:]]
            kind: Any = np.int64 if heading in WHOLE_NUMBERS else np.float64
            columns[heading] = np.array(values, dtype=np.str_ if heading == "surface" else kind)
    except (IndexError, ValueError) as error:
        raise BadInput(f"{path}: not a table of surfaces ({error})") from error
    return columns


def _plane_rows(surface: SurfaceShape) -> Iterator[list[str]]:
    """Yields rows of chain, closed, point, x, y, arc length and normal."""
    normal, arc_length = surface.fields["normal"], surface.fields["arc_length"]
    for chain, line in enumerate(surface.polylines):
        closed = line[0] == line[-1]
        for point in line[:-1] if closed else line:
            numbers = [*surface.position[point], arc_length[point], *normal[point]]
            yield [str(chain), str(int(closed)), str(point), *_digits(numbers)]


def _space_rows(surface: SurfaceShape) -> Iterator[list[str]]:
    """Yields rows of point, x, y, z and normal."""
    for point, numbers in enumerate(np.hstack([surface.position, surface.fields["normal"]])):
        yield [str(point), *_digits(numbers)]


def _digits(numbers: Any) -> list[str]:
    return [repr(float(number)) for number in numbers]
