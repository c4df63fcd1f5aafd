# SPDX-License-Identifier: BSD-3-Clause
"""VTK's XML files: one for each body or surface and output, and collections with the times."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from tilth.export.files import FileNames, NewFolder
from tilth.export.parts import Part, Show, meshio, parts_of
from tilth.export.source import Source

BODIES = "bodies"
"""Name of the collection of all bodies, if there are several."""


def write_vtk(source: Source, folder: NewFolder, show: Show) -> None:
    """Writes ``NAME/0000.vtu``, ... for each body or surface, and ``NAME.pvd`` with the times.

    ``bodies.pvd`` has several bodies together. A body that is not there at an output has a file
    without points: else programs would go on showing it. Raises ``BadInput`` without meshio,
    ``AnalysisFailed`` if a file cannot be written.
    """
    names = FileNames([BODIES])
    written: dict[str, set[int]] = {}
    nothing: dict[str, Part] = {}
    for index in source.outputs:
        for part in parts_of(source, source.results.snapshot(index), show):
            name = names.of(part.family, part.name)
            nothing[name] = part.emptied()
            written.setdefault(name, set()).add(index)
            with folder.file(_file(name, index)) as path:
                _write(part, path)
    for name, empty in nothing.items():
        for index in source.outputs:
            if index not in written[name]:
                with folder.file(_file(name, index)) as path:
                    _write(empty, path)
        _write_collection(source, folder, name, [name])
    bodies = [name for name, part in nothing.items() if part.family == ""]
    if len(bodies) > 1:
        _write_collection(source, folder, BODIES, bodies)


def _file(name: str, index: int) -> str:
    return f"{name}/{index:04d}.vtu"


def _write(part: Part, path: Path) -> None:
    mesh = meshio().Mesh(
        part.vertices,
        [(part.kind, part.cells)],
        point_data=dict(part.vertex_fields),
        cell_data={name: [values] for name, values in part.cell_fields.items()},
    )
    mesh.write(path, file_format="vtu")


def _write_collection(
    source: Source, folder: NewFolder, collection: str, names: Sequence[str]
) -> None:
    """Writes the collection of the files of bodies or surfaces, with their times."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    sets = ElementTree.SubElement(root, "Collection")
    # of outputs at the same time the last one: programs would show them together
    outputs = {source.results.times[index]: index for index in source.outputs}
    for time, index in outputs.items():
        for part, name in enumerate(names):
            which = {"part": str(part), "name": name, "file": _file(name, index)}
            ElementTree.SubElement(sets, "DataSet", {"timestep": repr(time), **which})
    ElementTree.indent(root)
    with folder.file(f"{collection}.pvd") as path:
        ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
