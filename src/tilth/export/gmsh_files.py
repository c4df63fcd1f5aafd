# SPDX-License-Identifier: BSD-3-Clause
"""Files of Gmsh (MSH 4.1), one per output: bodies and surfaces as physical groups, and views."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats
from tilth.export.files import FileNames, NewFolder
from tilth.export.parts import Part, Show, meshio, parts_of
from tilth.export.source import Source
from tilth.report.fields import TENSOR, with_unit

_DIMENSION = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2, "hexahedron": 3}
_SQUARE = [0, 3, 5, 3, 1, 4, 5, 4, 2]
"""Components xx yy zz xy yz xz of a symmetric tensor, row by row."""


def write_gmsh(source: Source, folder: NewFolder, show: Show) -> None:
    """Writes ``output_0000.msh``, ..., each with a view per field, and their options.

    Where the soil is not, the values are "not a number", which Gmsh does not draw. The options,
    ``output_0000.msh.opt``, which Gmsh reads by itself, show the first view alone. Raises
    ``BadInput`` without meshio, ``AnalysisFailed`` if a file cannot be written.
    """
    names = FileNames()
    for index in source.outputs:
        snapshot = source.results.snapshot(index)
        parts = [part for part in parts_of(source, snapshot, show) if part.family != "contact_"]
        there = [part for part in parts if len(part.cells)]
        with folder.file(f"output_{index:04d}.msh") as path:
            _write_mesh(there, [names.of(part.family, part.name) for part in there], path)
            with path.open("ab") as file:
                for name, unit in source.fields.items():
                    heading = with_unit(name, unit).replace('"', "'")
                    file.write(_view(heading, source.results.times[index], _values(name, there)))
        with folder.file(f"output_{index:04d}.msh.opt") as path:
            path.write_text(_options(len(source.fields)), encoding="utf-8")


def _options(views: int) -> str:
    """Returns the options that hide the edges of the cells and all views but the first."""
    hidden = [f"View[{view}].Visible = 0;" for view in range(1, views)]
    return "\n".join(["Mesh.SurfaceEdges = 0;", "Mesh.VolumeEdges = 0;", *hidden, ""])


def _write_mesh(parts: Sequence[Part], names: Sequence[str], path: Path) -> None:
    """Writes the mesh; each part is an entity and a physical group of its name."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    groups = [(_DIMENSION[part.kind], number) for number, part in enumerate(parts, start=1)]
    tags = [np.full(len(part.cells), tag) for part, (_, tag) in zip(parts, groups, strict=True)]
    of_vertices = [
        np.tile(group, (len(part.vertices), 1)) for part, group in zip(parts, groups, strict=True)
    ]
    mesh = meshio().Mesh(
        np.concatenate([part.vertices for part in parts]),
        [(part.kind, part.cells + start) for part, start in zip(parts, starts, strict=False)],
        point_data={"gmsh:dim_tags": np.concatenate(of_vertices)},
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={
            name: np.array([tag, dim]) for name, (dim, tag) in zip(names, groups, strict=True)
        },
    )
    mesh.write(path, file_format="gmsh", binary=True)


def _values(name: str, parts: Sequence[Part]) -> Floats:
    """Returns a field in all cells, as 1, 3 or 9 components; NaN in surfaces."""
    found: list[NDArray[Any] | None] = []
    for part in parts:
        fields = part.vertex_fields if part.kind == "vertex" else part.cell_fields
        found.append(fields[name] if part.family == "" else None)
    shape = next(each.shape[1:] for each in found if each is not None)
    whole = [
        np.full((len(part.cells), *shape), np.nan) if each is None else each
        for part, each in zip(parts, found, strict=True)
    ]
    values = np.asarray(np.concatenate(whole), dtype=np.float64).reshape(-1, *(shape or (1,)))
    return values[:, _SQUARE] if values.shape[1] == len(TENSOR) else values


def _view(heading: str, time: float, values: Floats) -> bytes:
    """Returns the section of a view, which meshio cannot write with its time.

    Source: Gmsh's reference manual, "MSH file format": text tags (the name), real tags (the time),
    whole tags (number of the time step, of components, of values), then a row for each element.
    """
    count, width = values.shape
    rows = np.zeros(count, dtype=[("element", np.int32), ("values", np.float64, (width,))])
    rows["element"] = np.arange(1, count + 1)
    rows["values"] = values
    head = f'$ElementData\n1\n"{heading}"\n1\n{time!r}\n3\n0\n{width}\n{count}\n'
    return head.encode() + rows.tobytes() + b"\n$EndElementData\n"
