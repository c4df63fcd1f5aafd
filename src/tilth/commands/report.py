# SPDX-License-Identifier: BSD-3-Clause
"""`tilth report`: writes the report of a run again."""

from __future__ import annotations

from pathlib import Path

import click

from tilth.commands.common import FOLDER
from tilth.errors import visible


@click.command()
@FOLDER
def report(folder: Path) -> None:
    """Write report.html again from the results of a run; no function of the model is run."""
    from tilth.output.folder import require_folder
    from tilth.output.lock import holder_of

    require_folder(folder)
    from tilth.analysis.setup_picture import write_report

    click.echo(visible(f"report written to {write_report(folder)}"))
    if holder := holder_of(folder):
        note = f"the run is not finished and may replace the report at its end ({holder})"
        click.echo(visible(note))
