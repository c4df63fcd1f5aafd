# SPDX-License-Identifier: BSD-3-Clause
"""`tilth safety`: finds a factor of safety."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from tilth.commands.common import (
    OUT,
    QUIET,
    THREADS,
    folder_of_results,
    interrupted,
    say_what_runs,
)
from tilth.errors import BadInput, Interrupted

if TYPE_CHECKING:
    from tilth.model.davis import DavisForm


@click.command()
@click.argument("case", metavar="CASE.toml|DIR", type=click.Path(path_type=Path))
@OUT
@click.option("--tolerance", type=float, default=0.01, show_default=True, help="Of the factor.")
@click.option("--start", type=float, default=1.0, show_default=True, help="Factor to try first.")
@click.option(
    "--davis",
    type=click.Choice(["A", "B", "C"]),
    help="Form of Davis' associated equivalent, which takes the place of soil with friction.",
)
@THREADS
@click.option("--overwrite", is_flag=True, help="Replace the results of an earlier run in DIR.")
@QUIET
def safety(
    case: Path,
    out: Path | None,
    tolerance: float,
    start: float,
    davis: DavisForm | None,
    threads: int | None,
    overwrite: bool,
    quiet: bool,
) -> None:
    """Run a case, then find its factor of safety by strength reduction.

    Or find that of an earlier run in the folder DIR, at its last checkpoint. Adds safety.csv,
    safety.png, safety.vtkhdf and safety.json to the folder of the results, and the mechanism to the
    report.
    """
    from tilth.analysis.safety_command import find_safety

    is_run = case.is_dir()
    if is_run and (out is not None or overwrite):
        raise BadInput(
            "--out and --overwrite are for case files", "leave them out for the folder of a run"
        )
    folder = case if is_run else folder_of_results(case, out)
    try:
        find_safety(
            case, folder, tolerance=tolerance, start=start, davis=davis, threads=threads,
            overwrite=overwrite, quiet=quiet, say=say_what_runs,
        )  # fmt: skip
    except KeyboardInterrupt:
        stopped = interrupted(folder)
        raise Interrupted(f"{stopped.message}, then: tilth safety {folder}") from None
