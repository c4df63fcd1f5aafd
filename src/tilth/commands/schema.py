# SPDX-License-Identifier: BSD-3-Clause
"""`tilth schema`: the JSON schema of case files, for editors."""

from __future__ import annotations

import json
from pathlib import Path

import click

from tilth.errors import visible


@click.command()
@click.option("--element", is_flag=True, help="That of the case files of `tilth element`.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="File to write, replaced if it exists; default: print the schema.",
)
def schema(element: bool, out: Path | None) -> None:
    """Write the JSON schema of case files, with which editors complete and check them.

    The first line of a case file names it: #:schema ./tilth.schema.json
    """
    from tilth.model.json_schema import case_schema, element_schema
    from tilth.output.disk import asked_to_write
    from tilth.output.files import written_whole

    declared = element_schema() if element else case_schema()
    text = json.dumps(declared, indent=1, ensure_ascii=False)
    if out is None:
        click.echo(text)
        return
    problem = f"the schema cannot be written to {out}"
    with asked_to_write(problem, "choose another file with --out"):
        if out.exists() and not out.is_file():  # such as /dev/stdout
            out.write_text(text + "\n", encoding="utf-8")
        else:
            with written_whole(out) as new:
                new.write_text(text + "\n", encoding="utf-8")
    click.echo(visible(f"schema written to {out}"))
