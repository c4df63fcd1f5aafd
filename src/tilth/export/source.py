# SPDX-License-Identifier: BSD-3-Clause
"""What is exported: a run, some of its outputs, some of their fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.output.folder import read_declared
from tilth.output.snapshot import Snapshot
from tilth.output.vtkhdf import Results
from tilth.plot.names import field_names, not_one_of, output_at
from tilth.plot.run import results_of
from tilth.report.fields import AXES, TENSOR, field_unit, field_values

CORNERS = "domain_corners"
"""The field that is no value but the shape of the points' domains."""

Times = Sequence[float] | Floats | Literal["all"] | None
"""Times of outputs, at least one; None for the last one."""


@dataclass(frozen=True)
class Source:
    """The results of a run, and what of them is exported."""

    results: Results
    outputs: tuple[int, ...]
    """Numbers of the outputs, from 0, ascending."""
    fields: Mapping[str, str]
    """Names of the fields of the points, whole ones or components, with the labels of their units,
    "" for pure numbers."""
    body_names: Sequence[str]
    """Names of the bodies; none if the run has no model."""
    kind: str
    """Kind of the analysis; "" if the run has no model."""
    colour_by: str
    """Field that colours the report; "" if the run has no model."""

    def body_name(self, number: int) -> str:
        """Returns the name of a body, or one made of its number if the run has no model."""
        if number < len(self.body_names):
            return self.body_names[number]
        return f"body_{number}"

    def unit(self, field: str) -> str:
        """Returns the label of the unit of a whole field, "" for a pure number."""
        return _unit(field, self.results)

    @property
    def area_unit(self) -> str:
        """Label of the unit of an area in contact, per length in plane strain."""
        length = self.results.units.get("length", "")
        if not length or not self.kind:
            return ""
        return f"{length}^2/{length}" if self.kind == "plane_strain" else f"{length}^2"

    def values(self, snapshot: Snapshot) -> dict[str, NDArray[Any]]:
        """Returns the fields of all points of an output, each of shape (n, ...)."""
        whole, units = snapshot.point_fields, self.results.units
        return {
            name: np.asarray(whole[name])
            if name in whole
            else field_values(snapshot, name, units)[0]
            for name in self.fields
        }


def source_of(folder: Path | str, times: Times, fields: Sequence[str] | None) -> Source:
    """Returns what is exported of the run in a folder.

    Args:
        folder: of the run.
        times: of the outputs.
        fields: names of fields or components, as of ``tilth plot``; all whole fields but the
            corners of domains for None.

    Raises:
        BadInput: there are no results, or a time or field is none of theirs.
    """
    results = results_of(folder)
    if isinstance(times, str):
        outputs = list(range(len(results)))
    elif times is None:
        outputs = [len(results) - 1]
    else:
        outputs = [output_at(results, time) for time in times]
    if not outputs:
        raise BadInput(
            "no time is given", "give times of outputs, or none for the last", key="times"
        )
    snapshot = results.snapshot(outputs[-1])
    whole = [name for name in snapshot.point_fields if name != CORNERS]
    known = list(dict.fromkeys([*whole, *field_names(snapshot)]))
    for name in fields or ():
        if name not in known:
            raise not_one_of(name, known, "fields", "is not a field of the results")
    units = {}
    for name in whole if fields is None else fields:
        field = max((each for each in whole if f"{name}_".startswith(f"{each}_")), key=len)
        units[name] = _unit(field, results)
    return Source(results, tuple(sorted(set(outputs))), units, *_declared(folder))


def components(name: str, values: NDArray[Any]) -> list[str]:
    """Returns the name of each column of a field with values of shape (n, ...), row by row."""
    if values.ndim == 1:
        return [name]
    if values.ndim == 3:
        return [f"{name}_{a}{b}" for a in AXES for b in AXES]
    count = values.shape[1]
    return [f"{name}_{part}" for part in (TENSOR if count == len(TENSOR) else AXES[:count])]


def _unit(field: str, results: Results) -> str:
    unit = field_unit(field, results.units)
    return "" if unit == "-" else unit


def _declared(folder: Path | str) -> tuple[list[str], str, str]:
    """Returns names of the bodies, kind of the analysis and field of the report of its model."""
    with suppress(BadInput, KeyError, TypeError):
        declared = read_declared(folder)
        names = [str(body["name"]) for body in declared["bodies"]]
        colour_by = declared.get("output", {}).get("colour_by", "")
        return names, str(declared["analysis"]["kind"]), str(colour_by)
    return [], "", ""
