# SPDX-License-Identifier: BSD-3-Clause
"""`tilth verify`: compares with reference solutions."""

from __future__ import annotations

import click
from click.shell_completion import CompletionItem

from tilth.errors import BadInput


def complete_problem(_: click.Context, __: click.Parameter, typed: str) -> list[CompletionItem]:
    """Returns the reference problems whose name begins with what is typed."""
    try:
        from tilth_verification.problems import PROBLEMS
    except ModuleNotFoundError:
        return []
    return [CompletionItem(name) for name in PROBLEMS if name.startswith(typed)]


@click.command()
@click.argument("names", metavar="[NAME]...", nargs=-1, shell_complete=complete_problem)
@click.option("--long", is_flag=True, help="Include the fine grids that take long.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
@click.pass_context
def verify(context: click.Context, names: tuple[str, ...], long: bool, as_json: bool) -> None:
    """Compare with reference solutions: all problems, or those NAMEd.

    Exit code 1 if any row is out of its tolerance.
    """
    try:
        from tilth_verification import run_verification
    except ModuleNotFoundError as error:
        if error.name != "tilth_verification":
            raise
        raise BadInput(
            "the reference problems are not installed: there is no package tilth_verification",
            "install tilth from its sources or from a wheel, which have it",
        ) from error
    context.exit(run_verification(names, long=long, as_json=as_json))
