# SPDX-License-Identifier: BSD-3-Clause
"""Commented case files to start from, one for each kind of problem."""

from __future__ import annotations

from pathlib import Path

from tilth.errors import BadInput
from tilth.output.disk import asked_to_write
from tilth.output.files import removed_on_failure

_FOLDER = Path(__file__).parent


def template_names() -> tuple[str, ...]:
    """Returns the names of the templates, in alphabetical order."""
    return tuple(sorted(file.stem for file in _FOLDER.glob("*.toml")))


def template(name: str) -> str:
    """Returns the text of a template.

    Raises:
        BadInput: there is no template of this name.
    """
    if name not in template_names():
        names = ", ".join(template_names())
        raise BadInput("there is no such template", f"choose from {names}", key="NAME", value=name)
    return (_FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def summary(name: str) -> str:
    """Returns what a template is about: its first line."""
    return template(name).partition("\n")[0].removeprefix("#").strip()


def write_template(name: str, file: Path) -> None:
    """Writes a template to a new file.

    Raises:
        BadInput: there is no such template, the file exists, or it cannot be written there.
        AnalysisFailed: the disk is full, or cannot be written for another reason of its own.
    """
    text, value = template(name), str(file)
    with asked_to_write("cannot be written", "choose another file", key="FILE", value=value):
        try:
            opened = file.open("x", encoding="utf-8")
        except FileExistsError:
            raise BadInput(
                "exists already", "choose another name", key="FILE", value=value
            ) from None
        with removed_on_failure(file), opened:
            opened.write(text)
