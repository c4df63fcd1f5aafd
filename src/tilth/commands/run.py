# SPDX-License-Identifier: BSD-3-Clause
"""`tilth run`: runs the analysis of a case file."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import click

from tilth.commands.common import (
    CASE,
    MEMORY_LIMIT,
    OUT,
    QUIET,
    THREADS,
    UNTIL,
    folder_of_results,
    interrupted,
    say_what_runs,
    where,
)
from tilth.errors import BadInput


@click.command()
@CASE
@OUT
@THREADS
@UNTIL
@MEMORY_LIMIT
@click.option("--overwrite", is_flag=True, help="Replace the results of an earlier run in DIR.")
@click.option(
    "--from",
    "start",
    metavar="DIR:STAGE",
    help="Go on from the end of a stage of the run in DIR; the stages up to it must be the same.",
)
@QUIET
def run(
    case: Path,
    out: Path | None,
    threads: int | None,
    until: float | None,
    memory_limit: str | None,
    overwrite: bool,
    start: str | None,
    quiet: bool,
) -> None:
    """Run the analysis of a case file.

    Writes results.vtkhdf (for ParaView), history.csv, report.html and log.txt.
    """
    from tilth.case import load_case

    model = load_case(case)
    if not quiet:
        say_what_runs(model.functions, model.user_laws)
    folder = folder_of_results(case, out)
    from tilth.analysis import run as analysis
    from tilth.analysis.from_stage import parse_start

    try:
        result = analysis.run(
            model,
            folder,
            from_stage=None if start is None else parse_start(start),
            threads=threads,
            until=until,
            memory_limit=memory_limit,
            overwrite=overwrite,
            quiet=quiet,
        )
    except KeyboardInterrupt:
        raise interrupted(folder) from None
    except BadInput as error:
        raise error if error.file else error.in_file(case) from None
    if not quiet:
        with suppress(BrokenPipeError):  # the run is done, whoever reads of it
            click.echo(where(folder, result.finished))
