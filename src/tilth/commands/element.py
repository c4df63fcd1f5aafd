# SPDX-License-Identifier: BSD-3-Clause
"""`tilth element`: makes element tests."""

from __future__ import annotations

from pathlib import Path

import click

from tilth.commands.common import CASE, OUT, QUIET, folder_of_results, say_what_runs
from tilth.errors import BadInput, visible


@click.command()
@CASE
@OUT
@click.option("--overwrite", is_flag=True, help="Replace the results of earlier tests in DIR.")
@click.option(
    "--check",
    "only_check",
    is_flag=True,
    help="Compare the tangents of the materials with differences, instead; write nothing.",
)
@QUIET
@click.pass_context
def element(
    context: click.Context,
    case: Path,
    out: Path | None,
    overwrite: bool,
    only_check: bool,
    quiet: bool,
) -> None:
    """Make the element tests of a case file: laboratory tests on one material point.

    Writes a table (CSV) of each test and material, and pictures. With --check exit code 1 if a
    tangent is out of its tolerance.
    """
    from tilth.case import load_element_case

    declared = load_element_case(case)
    say_what_runs(declared.user_laws, declared.user_laws)
    folder = folder_of_results(case, out)
    from tilth.element_tests.command import make_tests, print_check

    try:
        if only_check:
            context.exit(print_check(declared))
        make_tests(declared, folder, overwrite=overwrite, quiet=quiet)
    except BadInput as error:
        raise error if error.file else error.in_file(case) from None
    if not quiet:
        click.echo(visible(f"results in {folder}"))
