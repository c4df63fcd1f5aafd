# SPDX-License-Identifier: BSD-3-Clause
"""Field types of texts: what the user names and labels, safe in pictures, tables and terminals.

Refused is what has no honest use in a title, a name or a unit: characters that are not printable
(control characters, changes of the writing direction, characters of no width, halves of surrogate
pairs), piles of accents, texts too long to be drawn, and what a spreadsheet would compute.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from typing import Annotated, Any, Final

from pydantic import AfterValidator, PlainValidator

from tilth.model.problems import reject

LONGEST_TITLE: Final = 200
LONGEST_NAME: Final = 100
LONGEST_UNIT: Final = 40
LONGEST_PATH: Final = 4096
MOST_MARKS: Final = 4
"""Accents and other combining marks in a row, at most."""


def _text_up_to(longest: int) -> Callable[[Any], str]:
    """Returns the check of a text of at most `longest` characters."""

    def checked(value: Any) -> str:
        if not isinstance(value, str):
            raise reject("must be a text", "put it in quotes")
        if len(value) > longest:
            raise reject(f"has {len(value):,} characters", f"use at most {longest:,}")
        for number, character in enumerate(value, start=1):
            if not character.isprintable():
                name = unicodedata.name(character, "").lower()
                which = f"U+{ord(character):04X}{name and f', {name}'}"
                raise reject(
                    "must be one line of printable characters",
                    f"leave out character {number} ({which}), or put a plain space there",
                )
        marks = 0
        for character in value:
            marks = marks + 1 if unicodedata.category(character) in ("Mn", "Me") else 0
            if marks > MOST_MARKS:
                raise reject(f"has more than {MOST_MARKS} combining marks in a row", "remove some")
        return value

    return checked


def _filled(value: str) -> str:
    if text := value.strip():
        return text
    raise reject("must not be empty")


def _never_a_formula(before: str) -> Callable[[str], str]:
    """Returns the check that no cell of a table starts with = + - @ after `before`, a pattern."""
    pattern = re.compile(rf"{before}[\s\"']*[=+\-@]")

    def checked(value: str) -> str:
        if found := pattern.search(unicodedata.normalize("NFKC", value)):
            where = "after a semicolon" if found[0][0] == ";" else "at the start"
            raise reject(
                f"has {found[0][-1]!r} {where}; a spreadsheet that opens the run's tables would "
                "take it for a formula",
                "put a letter or a digit before it",
            )
        return value

    return checked


Text = Annotated[str, PlainValidator(_text_up_to(LONGEST_TITLE))]
Label = Annotated[
    str, PlainValidator(_text_up_to(LONGEST_UNIT)), AfterValidator(_never_a_formula(";"))
]
"""A unit, which follows a name in the heading of a table."""
Name = Annotated[str, PlainValidator(_text_up_to(LONGEST_NAME)), AfterValidator(_filled)]
CellName = Annotated[Name, AfterValidator(_never_a_formula("(^|;)"))]
"""A name that begins a cell of a table."""
FileName = Annotated[str, PlainValidator(_text_up_to(LONGEST_PATH)), AfterValidator(_filled)]


def _function(value: str) -> str:
    file, colon, name = value.rpartition(":")
    if not (colon and file.endswith(".py") and name.isidentifier()):
        remedy = 'write the file, a colon and the function\'s name, such as "shape.py:distance"'
        raise reject("does not name a function in a Python file", remedy)
    return value


PythonFunction = Annotated[FileName, AfterValidator(_function)]
