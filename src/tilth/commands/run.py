# SPDX-License-Identifier: BSD-3-Clause
"""`tilth run`: runs the analysis of a case file."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import click

from tilth.commands.common import (
    CASE,
    EXPLAIN,
    MEMORY_LIMIT,
    OUT,
    QUIET,
    THREADS,
    UNTIL,
    folder_of_results,
    interrupted,
    require_decided,
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
@click.option(
    "--continue",
    "going_on",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Let the run in DIR, finished or not, go on with this case, which may differ in what is "
    "still to come only: a later end, later rows of tables, further stages, output.",
)
@EXPLAIN
@QUIET
def run(
    case: Path,
    out: Path | None,
    threads: int | None,
    until: float | None,
    memory_limit: str | None,
    overwrite: bool,
    start: str | None,
    going_on: Path | None,
    explain: str | None,
    quiet: bool,
) -> None:
    """Run the analysis of a case file.

    Writes results.vtkhdf (for ParaView), history.csv, report.html and log.txt.
    """
    from tilth.case import load_case

    model = load_case(case)
    if not quiet:
        say_what_runs(model.functions, model.user_laws)
    if going_on is not None and (out is not None or overwrite or start is not None):
        what = "does not go with --out, --overwrite or --from: the run goes on in its own folder"
        raise BadInput(f"--continue {what}", f"tilth run {case} --continue {going_on}")
    folder = folder_of_results(case, out) if going_on is None else going_on
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
            continues=going_on is not None,
            quiet=quiet,
            explain=explain,
        )
    except KeyboardInterrupt:
        raise interrupted(folder) from None
    except BadInput as error:
        raise error if error.file else error.in_file(case) from None
    if not quiet:
        with suppress(BrokenPipeError):  # the run is done, whoever reads of it
            click.echo(where(folder, result.finished))
    require_decided(result.undecided)
