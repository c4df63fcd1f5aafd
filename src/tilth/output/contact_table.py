# SPDX-License-Identifier: BSD-3-Clause
"""``contact.csv``: the points of all contact surfaces at the last output."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilth.errors import BadInput
from tilth.input_files import require_file
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.output.snapshot import ContactShape, Snapshot

STATES = ("open", "stick", "slip")
_WORDS = ("boundary", "state")
_HINT = "name the contact.csv of a run with contact"


def write_contacts(path: Path | str, snapshot: Snapshot, units: Mapping[str, str]) -> None:
    """Writes the table of the contact surfaces of ``snapshot``, replacing an older one atomically.

    Each row is a point. ``units`` are labels (keys ``length``, ``area``, ``stress``). Numbers are
    written with all digits, so that reading is bit-exact. Raises ``AnalysisFailed`` if it cannot be
    written.
    """
    length, stress = units.get("length", ""), units.get("stress", "")
    length, stress = units.get("length", ""), units.get("stress", "")
    axes = "xyz"[: snapshot.dim]
    headings = [
        *((axis, length) for axis in axes),
        *((f"normal_{axis}", "") for axis in axes),
        ("area", units.get("area", "")),
        ("normal_stress", stress),
        *((f"shear_{axis}", stress) for axis in axes),
        ("gap", length),
    ]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    named = [f"{name} [{unit}]" if unit else name for name, unit in headings]
    table.writerow(["step", "time", "boundary", *named, "state"])
    moment = [str(snapshot.step), repr(float(snapshot.time))]
    for shape in snapshot.contacts:
        table.writerows([*moment, shape.name, *row] for row in _rows(shape))
    with writing(Path(path)):
        write_durably(Path(path), text.getvalue().encode())


def states(shape: ContactShape) -> NDArray[np.int64]:
    """Returns the number in ``STATES`` of each point, shape (n,)."""
    touching, sliding = shape.fields["in_contact"], shape.fields["sliding"]
    return np.where(touching == 0, 0, np.where(sliding == 0, 1, 2))


def read_contacts(path: Path | str) -> dict[str, NDArray[Any]]:
    """Returns all columns of a ``contact.csv`` by heading, each of shape (rows,).

    ``boundary`` and ``state`` are text, ``step`` is a whole number; all others are floats,
    bit-exact. Raises ``BadInput`` if it is no such file.
    """
    path = Path(path)
    try:
        require_file(path)
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror}", _HINT) from error
    if not rows or rows[0][:3] != ["step", "time", "boundary"] or rows[0][-1] != "state":
        raise BadInput(f"{path} is not the contact.csv of a tilth run", _HINT)
    columns: dict[str, NDArray[Any]] = {}
    try:
        for index, heading in enumerate(rows[0]):
            kind: Any = np.str_ if heading in _WORDS else np.float64
            kind = np.int64 if heading == "step" else kind
            columns[heading] = np.array([row[index] for row in rows[1:]], dtype=kind)
    except (IndexError, ValueError) as error:
        raise BadInput(f"{path}: not a table of contact surfaces ({error})", _HINT) from error
    return columns


def _rows(shape: ContactShape) -> Iterator[list[str]]:
    fields = shape.fields
    numbers = np.column_stack(
        [
            shape.position,
            fields["normal"],
            fields["area"],
            fields["normal_stress"],
            fields["shear_stress"],
            fields["gap"],
        ]
    )
    for row, state in zip(numbers.tolist(), states(shape), strict=True):
        yield [*map(repr, row), STATES[state]]
