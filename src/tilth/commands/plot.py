# SPDX-License-Identifier: BSD-3-Clause
"""`tilth plot`: pictures of fields, histories and lines through the soil."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from tilth.errors import BadInput, visible


@click.command()
@click.argument(
    "folders", metavar="DIR...", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@click.option("--field", help="Field to draw, such as displacement_y or cauchy_stress_mean.")
@click.option("--time", type=float, help="Time of the output to draw; the last one if not given.")
@click.option(
    "--show",
    type=click.Choice(["field", "points", "domains"]),
    default="field",
    help="The field over the soil, each point, or each point's domain.",
)
@click.option(
    "--section",
    metavar="x=X",
    help="In 3D: the plane to draw, x=X, y=Y or z=Z, or a point and a normal, X,Y,Z:NX,NY,NZ.",
)
@click.option(
    "--range", "values", nargs=2, type=float, metavar="LOW HIGH", help="Ends of the colours."
)
@click.option("--path", metavar="X0,Y0:X1,Y1", help="Draw the field along a line, by its ends.")
@click.option(
    "--times",
    metavar="T1,T2,...",
    help="With --path: times of outputs, each with its curve, such as isochrones.",
)
@click.option(
    "--history", nargs=2, metavar="X Y", help="Draw columns of the history; DIR can be several."
)
@click.option(
    "--scale",
    type=click.Choice(["linear", "log", "root"]),
    default="linear",
    help="With --history: scale of X; log and root are those of settlements over time.",
)
@click.option(
    "--save",
    "file",
    type=click.Path(path_type=Path),
    help="File to write: .svg, .pdf or .png; plot.png if not given.",
)
def plot(folders: tuple[Path, ...], file: Path | None, **options: Any) -> None:
    """Draw a field at a time, a field along a line, or columns of histories."""
    from tilth.plot.files import require_format, save_figure

    file = Path("plot.png") if file is None else file
    require_format(file)
    save_figure(_figure(folders, **options), file)
    click.echo(visible(f"picture written to {file}"))


def _figure(
    folders: tuple[Path, ...],
    field: str | None,
    time: float | None,
    show: Any,
    section: str | None,
    values: tuple[float, float] | None,
    path: str | None,
    times: str | None,
    history: tuple[str, str] | None,
    scale: Any,
) -> Any:
    """Returns the figure that the options ask for; raises ``BadInput`` where they do not fit."""
    from tilth.plot.curves import curve_figure
    from tilth.plot.field import field_figure
    from tilth.plot.path import path_figure

    if (field is None) == (history is None):
        raise BadInput(
            "nothing to draw" if field is None else "both a field and a history are asked for",
            "give either --field F or --history X Y",
        )
    if times is not None and (path is None or time is not None):
        remedy = "give it with --path, or leave it out" if path is None else "leave out one of them"
        what = "is for lines" if path is None else "is given with --time"
        raise BadInput(what, remedy, key="times", value=times)
    if scale != "linear" and history is None:
        raise BadInput("is for histories", "leave it out", key="scale", value=scale)
    if history is not None:
        return curve_figure(folders, *history, scale=scale)
    assert field is not None
    if len(folders) > 1:
        raise BadInput("a field is drawn of one run", "name one folder", key="DIR")
    if path is None:
        return field_figure(folders[0], field, time=time, show=show, section=section, values=values)
    start, _, end = path.partition(":")
    at = () if times is None else _numbers(times, "times", times, "is no list of times", "T1,T2")
    ends = [_numbers(each, "path", path, "is not a line", "X0,Y0:X1,Y1") for each in (start, end)]
    return path_figure(folders[0], field, *ends, time=time, times=at)


def _numbers(text: str, key: str, value: str, problem: str, form: str) -> Any:
    """Returns numbers that commas separate; refuses a value that they are a part of."""
    import numpy as np

    try:
        numbers = np.array([float(part) for part in text.split(",")])
    except ValueError:
        numbers = np.array([np.nan])
    if not np.isfinite(numbers).all():
        raise BadInput(problem, f"write {form}", key=key, value=value)
    return numbers
