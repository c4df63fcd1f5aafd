# SPDX-License-Identifier: BSD-3-Clause
"""`tilth study`: runs a case many times with other values in it."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import click

from tilth.commands.common import MOST_THREADS, OUT, QUIET, folder_of_results, say_what_runs
from tilth.errors import EXIT_ANALYSIS_FAILED, BadInput, Interrupted, visible


@click.command()
@click.argument("file", metavar="STUDY.toml", type=click.Path(path_type=Path))
@OUT
@click.option(
    "--processes",
    type=click.IntRange(min=1, max=MOST_THREADS),
    help="Samples to run at the same time, each with one thread; as many as cores if not given. "
    "The table does not depend on it.",
)
@click.option("--overwrite", is_flag=True, help="Replace another study in DIR.")
@QUIET
@click.pass_context
def study(
    context: click.Context,
    file: Path,
    out: Path | None,
    processes: int | None,
    overwrite: bool,
    quiet: bool,
) -> None:
    """Run a case many times with other values in it: parameter studies, Monte Carlo.

    Writes study.csv (a row for each sample), statistics.csv and study.html. Started again, it goes
    on where it stopped. Exit code 1 if samples failed.
    """
    from tilth.case import load_case, load_study
    from tilth.studies.run import study as run_study
    from tilth.studies.summary import print_study

    declared = load_study(file)
    folder = folder_of_results(file, out)
    if not quiet:
        model = load_case(str(declared.case))
        functions = [o.function for o in declared.outcomes if o.type == "function"]
        say_what_runs([*model.functions, *functions], model.user_laws)
    try:
        result = run_study(declared, folder, processes=processes, overwrite=overwrite, quiet=quiet)
    except KeyboardInterrupt:
        again = f"tilth study {file}" + (f" --out {out}" if out is not None else "")
        raise Interrupted(f"interrupted; go on with: {again}") from None
    except BadInput as error:
        raise error if error.file else error.in_file(file) from None
    if not quiet:
        with suppress(BrokenPipeError):
            print_study(result)
            click.echo(visible(f"results in {folder}"))
    if result.reasons:
        context.exit(EXIT_ANALYSIS_FAILED)
