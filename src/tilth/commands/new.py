# SPDX-License-Identifier: BSD-3-Clause
"""`tilth new`: writes a commented case file to start from."""

from __future__ import annotations

from pathlib import Path

import click
from click.shell_completion import CompletionItem

from tilth.errors import BadInput, visible


def complete_template(_: click.Context, __: click.Parameter, typed: str) -> list[CompletionItem]:
    """Returns the templates that begin with what is typed, with their summaries."""
    from tilth.templates import summary, template_names

    names = [name for name in template_names() if name.startswith(typed)]
    return [CompletionItem(name, help=summary(name)) for name in names]


@click.command()
@click.argument("name", required=False, shell_complete=complete_template)
@click.argument("file", metavar="[FILE.toml]", required=False, type=click.Path(path_type=Path))
@click.option("--list", "listed", is_flag=True, help="List the templates.")
def new(name: str | None, file: Path | None, listed: bool) -> None:
    """Write a commented case file to start from, to FILE.toml or NAME.toml.

    An existing file is never replaced. `tilth new --list` lists the NAMEs.
    """
    from tilth.templates import summary, template_names, write_template

    if listed:
        for each in template_names():
            click.echo(f"{each:<12}{summary(each)}")
        return
    if name is None:
        names = ", ".join(template_names())
        raise BadInput("name a template", f"such as: tilth new footing; there are {names}")
    written = Path(f"{name}.toml") if file is None else file
    write_template(name, written)
    command = "element" if name == "triaxial" else "check"
    click.echo(visible(f"{written} written; next: tilth {command} {written}"))
