# SPDX-License-Identifier: BSD-3-Clause
"""Exporting the results of a run into a new folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, get_args

from tilth.errors import BadInput
from tilth.export.csv_files import write_csv, write_outputs
from tilth.export.files import new_folder
from tilth.export.gmsh_files import write_gmsh
from tilth.export.paraview_view import write_view
from tilth.export.parts import Show
from tilth.export.source import Times, source_of
from tilth.export.vtk_files import write_vtk
from tilth.input_files import absolute

Format = Literal["vtk", "csv", "gmsh", "paraview"]
FORMATS: tuple[Format, ...] = get_args(Format)


def export_run(
    folder: Path | str,
    to: Format,
    out: Path | str | None = None,
    *,
    times: Times = None,
    fields: Sequence[str] | None = None,
    show: Show = "domains",
) -> list[Path]:
    """Writes results of a run for other programs into a new folder; returns the files.

    Args:
        folder: of the run.
        to: ``vtk``: a file for each body or surface and output, with a collection of the times;
            ``csv``: tables; ``gmsh``: a mesh with views for each output; ``paraview``: the script
            ``view.py``, which opens the results themselves.
        out: the new folder, or an empty one; beside that of the run and named after it if None.
        times: of outputs, or "all"; the last output if None. A state of ParaView has all outputs,
            and shows this one first.
        fields: names of fields or components; all if None. A state of ParaView is coloured by one.
        show: in VTK and Gmsh the domains of the points, or the points.

    Raises:
        BadInput: there are no results, a time or field is none of theirs, the format is unknown or
            does not take the choice, the folder is not empty, or a package is missing.
        AnalysisFailed: a file cannot be written. Nothing is left of the export then.
    """
    if to not in FORMATS:
        raise BadInput("is not a format", f"choose from {', '.join(FORMATS)}", key="to", value=to)
    if show not in get_args(Show):
        raise BadInput(
            "is unknown", f"choose from {', '.join(get_args(Show))}", key="show", value=show
        )
    source = source_of(folder, times, fields)
    if out is None:
        own = absolute(folder)
        out = own.with_name(f"{own.name}_{to}")
    with new_folder(Path(out)) as into:
        if to == "paraview":
            write_view(source, into, chosen=fields)
        else:
            write_outputs(source, into)
        if to == "vtk":
            write_vtk(source, into, show)
        elif to == "csv":
            write_csv(source, into)
        elif to == "gmsh":
            write_gmsh(source, into, show)
    return into.files
