# SPDX-License-Identifier: BSD-3-Clause
"""`tilth resume`: continues an interrupted run."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import click

from tilth.commands.common import (
    EXPLAIN,
    FOLDER,
    MEMORY_LIMIT,
    QUIET,
    THREADS,
    UNTIL,
    interrupted,
    require_decided,
    say_what_runs,
    where,
)


@click.command()
@FOLDER
@THREADS
@UNTIL
@MEMORY_LIMIT
@EXPLAIN
@QUIET
def resume(
    folder: Path,
    threads: int | None,
    until: float | None,
    memory_limit: str | None,
    explain: str | None,
    quiet: bool,
) -> None:
    """Continue an interrupted run from its last complete step.

    The result is identical, bit for bit, to that of an uninterrupted run. The folder is code where
    its model names a Python function: that function is run.
    """
    from tilth.output.folder import MODEL, load_model, require_folder

    require_folder(folder)
    if not quiet and (folder / MODEL).exists():
        model = load_model(folder)
        say_what_runs(model.functions, model.user_laws)
    from tilth.analysis import run as analysis

    try:
        result = analysis.resume(
            folder,
            threads=threads,
            until=until,
            memory_limit=memory_limit,
            quiet=quiet,
            explain=explain,
        )
    except KeyboardInterrupt:
        raise interrupted(folder) from None
    if not quiet:
        with suppress(BrokenPipeError):  # the run is done, whoever reads of it
            click.echo(where(folder, result.finished))
    require_decided(result.undecided)
