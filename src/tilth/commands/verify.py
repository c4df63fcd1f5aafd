# SPDX-License-Identifier: BSD-3-Clause
"""`tilth verify`: compares with reference solutions."""

from __future__ import annotations

import click
from click.shell_completion import CompletionItem


def complete_problem(_: click.Context, __: click.Parameter, typed: str) -> list[CompletionItem]:
    """Returns the reference problems whose name begins with what is typed."""
    from tilth.verification.problems import PROBLEMS

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
    from tilth.verification import run_verification

    context.exit(run_verification(names, long=long, as_json=as_json))
