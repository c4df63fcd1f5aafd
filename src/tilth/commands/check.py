# SPDX-License-Identifier: BSD-3-Clause
"""`tilth check`: validates a case file and draws its set-up."""

from __future__ import annotations

from pathlib import Path

import click

from tilth.commands.common import CASE, say_what_runs
from tilth.errors import BadInput, visible

PICTURES = (".png", ".pdf", ".svg")


def picture_name(context: click.Context, option: click.Parameter, file: Path | None) -> Path | None:
    """Refuses the name of a picture that is none of `PICTURES`."""
    if file is not None and file.suffix.lower() not in PICTURES:
        raise click.BadParameter(f"'{visible(str(file))}' does not end with {', '.join(PICTURES)}.")
    return file


@click.command()
@CASE
@click.option(
    "--picture",
    type=click.Path(path_type=Path, dir_okay=False),
    callback=picture_name,
    metavar="FILE.png",
    help="Picture of the set-up (.png, .pdf, .svg); default: CASE.setup.png beside the case file.",
)
def check(case: Path, picture: Path | None) -> None:
    """Validate a case file without running it, and draw its set-up.

    With stages the picture has a panel for each. Each parameter that varies from place to place
    gets a picture of its own beside it. The first steps are taken, for about a second, to estimate
    the time of the run. Python functions that the case names are run.
    """
    from tilth.case import load_case
    from tilth.report.setup_data import Setup
    from tilth.report.summary import print_summary

    model = load_case(case)
    from tilth.analysis.check import consolidation_texts
    from tilth.analysis.memory import memory_of, require_memory_to_check
    from tilth.analysis.run import set_threads
    from tilth.analysis.run_time import time_text
    from tilth.analysis.setup_picture import setup_figures
    from tilth.available_memory import available_memory
    from tilth.output.disk import asked_to_write
    from tilth.output.files import written_whole
    from tilth.report.texts import save

    file = case.with_suffix(".setup.png") if picture is None else picture
    say_what_runs(model.functions, model.user_laws)
    try:
        estimate, available = memory_of(model), available_memory()
        too_large = require_memory_to_check(estimate, available)
        setup, figures = setup_figures(model)
        soil = setup if isinstance(setup, Setup) else setup.whole()
        set_threads(None)
        time = "not estimated" if too_large else time_text(model)
        flow = [] if too_large or model.flow is None else [*consolidation_texts(model)]
        print_summary(model, soil, estimate, available, time=time, consolidation=flow)
    except BadInput as error:
        raise error if error.file else error.in_file(case) from None
    files = {name: _beside(file, name) for name in figures}
    problem = f"the picture cannot be written to {file}"
    with asked_to_write(problem, "choose another file with --picture"):
        for name, figure in figures.items():
            with written_whole(files[name]) as new:
                save(figure, new)
    for text in (*setup.warnings, *([too_large] if too_large else [])):
        click.echo(visible(f"warning: {text}"), err=True)
    for name, drawn in files.items():
        click.echo(visible(f"{name.replace('_', ' ') or 'set-up'} drawn in {drawn}"))


def _beside(file: Path, name: str) -> Path:
    """Returns the file of a further picture: NAME.png is NAME.parameter.png."""
    return file.with_name(f"{file.stem}.{name}{file.suffix}") if name else file
