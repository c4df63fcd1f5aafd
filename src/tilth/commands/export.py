# SPDX-License-Identifier: BSD-3-Clause
"""`tilth export`: results in files for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from tilth.commands.common import FOLDER
from tilth.errors import BadInput, visible


@click.command()
@FOLDER
@click.option(
    "--to",
    required=True,
    type=click.Choice(["vtk", "csv", "gmsh", "paraview"]),
    help="VTK files with a collection of the times, tables, meshes of Gmsh with views, or a script "
    "that shows the results in ParaView.",
)
@click.option(
    "--time",
    "times",
    type=float,
    multiple=True,
    help="Time of an output, may be repeated; the last output if not given.",
)
@click.option("--all", "all_times", is_flag=True, help="All outputs.")
@click.option(
    "--fields",
    metavar="A,B,...",
    help="Fields or components, as for `tilth plot`; all fields if not given.",
)
@click.option(
    "--show",
    type=click.Choice(["domains", "points"]),
    default="domains",
    help="In VTK and Gmsh: each point's domain as a cell, or each point.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="New folder of the files; default: beside DIR and named after it.",
)
def export(
    folder: Path,
    to: Any,
    times: tuple[float, ...],
    all_times: bool,
    fields: str | None,
    show: Any,
    out: Path | None,
) -> None:
    """Write results of a run for other programs into a new folder; nothing is computed again."""
    from tilth.export.run import export_run

    if times and all_times:
        raise BadInput("both --time and --all are given", "give one of them")
    files = export_run(
        folder,
        to,
        out,
        times="all" if all_times else times or None,
        fields=None if fields is None else [name.strip() for name in fields.split(",")],
        show=show,
    )
    where = files[0].parent
    click.echo(visible(f"{len(files)} file{'' if len(files) == 1 else 's'} written to {where}"))
