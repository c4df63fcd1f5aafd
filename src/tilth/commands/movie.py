# SPDX-License-Identifier: BSD-3-Clause
"""`tilth movie`: a field at all outputs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from tilth.commands.common import FOLDER
from tilth.errors import visible


@click.command()
@FOLDER
@click.option("--field", required=True, help="Field to draw, such as displacement_y.")
@click.option(
    "--save",
    "file",
    type=click.Path(path_type=Path),
    default=Path("movie.gif"),
    help="File to write: .mp4, .gif or .webp; movie.gif if not given.",
)
@click.option(
    "--scale",
    type=click.Choice(["fixed", "frame"]),
    default="fixed",
    help="The same colours in all frames, or those of each frame's values.",
)
@click.option(
    "--range", "values", nargs=2, type=float, metavar="LOW HIGH", help="Ends of the colours."
)
@click.option("--fps", type=float, default=8.0, help="Outputs per second; 8 if not given.")
@click.option(
    "--show",
    type=click.Choice(["field", "points", "domains"]),
    default="field",
    help="The field over the soil, each point, or each point's domain.",
)
@click.option("--section", metavar="x=X", help="In 3D: the plane to draw, as of `tilth plot`.")
@click.option("--history", metavar="Y", help="Draw a column of the history over time below.")
def movie(folder: Path, field: str, file: Path, **options: Any) -> None:
    """Draw a field at all outputs of a run into a movie, one frame for each."""
    from tilth.plot.movie import write_movie

    with click.progressbar(length=1, label="drawing") as bar:

        def progress(done: int, count: int) -> None:
            bar.length = count
            bar.update(done - bar.pos)

        frames = write_movie(folder, field, file, progress=progress, **options)
    if frames == 1:
        click.echo("warning: the run has one output, so the movie has one frame")
    click.echo(visible(f"movie of {frames} frames written to {file}"))
