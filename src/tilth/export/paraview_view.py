# SPDX-License-Identifier: BSD-3-Clause
"""A script that opens the results, or exported VTK files, in ParaView and shows a first view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.resources import files
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilth.errors import BadInput
from tilth.export.files import NewFolder
from tilth.export.source import CORNERS, Source
from tilth.input_files import absolute
from tilth.output.snapshot import Snapshot
from tilth.output.vtkhdf_layout import FAMILIES, block_names
from tilth.plot.names import not_one_of
from tilth.report.fields import AXES, TENSOR, with_unit

VIEW = "view.py"


def write_view(source: Source, folder: NewFolder, chosen: Sequence[str] | None) -> None:
    """Writes the script ``view.py``, which shows the last exported output first.

    ``chosen`` has the field or component for the colours; for None it is that of the report
    (``colour_by``) if ParaView finds it in the results and it varies, else the displacement.

    Raises:
        BadInput: the field is not stored, as the mean stress, or there are several.
        AnalysisFailed: the script cannot be written.
    """
    snapshot = source.results.snapshot(source.outputs[-1])
    known = _colourings(snapshot.point_fields, snapshot.dim)
    if chosen is None:
        field, component, ends = _telling(source, known)
    else:
        field, component = _chosen(chosen, known)
        ends = _range(source, field, component)
    script = _script(source, snapshot, field, component, ends)
    with folder.file(VIEW) as path:
        path.write_text(script, encoding="utf-8")


def _chosen(chosen: Sequence[str], known: Mapping[str, tuple[str, str]]) -> tuple[str, str]:
    """Returns field and component for the colours that the user names."""
    if len(chosen) != 1:
        raise BadInput("one field colours a view", "name one", key="fields", value=list(chosen))
    (name,) = chosen
    if name not in known:
        problem = "is not stored in the results, so ParaView does not find it"
        raise not_one_of(name, list(known), "fields", problem)
    return known[name]


def _telling(
    source: Source, known: Mapping[str, tuple[str, str]]
) -> tuple[str, str, tuple[float, float]]:
    """Returns field, component and range of the first that varies: of the report, displacement."""
    names = [n for n in (source.colour_by, "displacement") if n in known] or list(known)
    ranges = [(*known[name], _range(source, *known[name])) for name in names]
    return next((each for each in ranges if each[2][0] < each[2][1]), ranges[-1])


def _colourings(fields: Mapping[str, NDArray[Any]], dim: int) -> dict[str, tuple[str, str]]:
    """Returns ParaView's names of field and component, "" of scalars, by those of tilth."""
    found: dict[str, tuple[str, str]] = {}
    for name, values in fields.items():
        if values.ndim == 1:
            found[name] = name, ""
        elif values.ndim == 2 and values.shape[1] == dim:
            found[name] = name, "Magnitude"
            found |= {f"{name}_{axis}": (name, axis.upper()) for axis in AXES[:dim]}
        elif values.ndim == 2:
            found |= {f"{name}_{part}": (name, part.upper()) for part in TENSOR}
    return found


def _script(
    source: Source, snapshot: Snapshot, field: str, component: str, ends: tuple[float, float]
) -> str:
    """Returns the text of the script; ``ends`` are the values at the ends of the colours."""
    low, high = ends
    results = source.results
    part = {"": "", "Magnitude": ", magnitude"}.get(component, f", {component.lower()}")
    time_unit = results.units.get("time", "")
    values = {
        "RESULTS": str(absolute(results.path)),
        "TITLE": results.title or "results",
        "DIMENSIONS": results.dim,
        "FIELD": field,
        "COMPONENT": component,
        "LABEL": with_unit(field.replace("_", " ") + part, source.unit(field)),
        "RANGE": (low, high if low < high else low + (abs(low) or 1.0)),
        "RADIUS": _radius(snapshot) * results.dim**0.5,  # that round the corners of a domain
        "SURFACES": [
            block
            for key, start in FAMILIES.items()
            if key != "contacts"
            for block in block_names(start, results.names.get(key, ())).values()
        ],
        "TIME": results.times[source.outputs[-1]],
        "TIME_LABEL": f"time {{time:g}} {time_unit}".rstrip(),
    }
    template = (files("tilth.export") / "paraview_template.txt").read_text(encoding="utf-8")
    others = ", ".join(each for each in snapshot.point_fields if each not in (field, CORNERS))
    texts = {key: repr(value) for key, value in values.items()}
    return Template(template).substitute(texts, OTHERS=others)


def _range(source: Source, field: str, component: str) -> tuple[float, float]:
    """Returns the least and the largest value at all outputs, apart if they are equal."""
    low, high = np.inf, -np.inf
    for snapshot in source.results:
        values = np.asarray(snapshot.point_fields[field], dtype=np.float64)
        if component == "Magnitude":
            values = np.asarray(np.linalg.norm(values, axis=1))
        elif component:
            names = TENSOR if values.shape[1] == len(TENSOR) else AXES
            values = values[:, names.index(component.lower())]
        values = values[np.isfinite(values)]
        if len(values):
            low, high = min(low, float(values.min())), max(high, float(values.max()))
    return (low, high) if low <= high else (0.0, 0.0)


def _radius(snapshot: Snapshot) -> float:
    """Returns the mean half length of the points' domains [length]."""
    half = snapshot.point_fields.get("domain", np.zeros(0))
    half = half[np.isfinite(half)]
    if len(half):
        return float(half.mean())
    extent = np.ptp(snapshot.position, axis=0)
    spacing = extent.max() / len(snapshot.position) ** (1.0 / snapshot.dim)
    return float(0.5 * spacing)
