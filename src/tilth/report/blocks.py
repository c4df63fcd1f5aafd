# SPDX-License-Identifier: BSD-3-Clause
"""What sections of a page consist of, and the HTML of it by the templates of this package."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup


@dataclass(frozen=True)
class Paragraph:
    """A paragraph of text, with a link at its end if ``link`` gives its place and its words."""

    kind: ClassVar[str] = "paragraph"
    text: str
    style: str = ""
    strong: str = ""
    """Words before the text that matter most."""
    link: tuple[str, str] | None = None


@dataclass(frozen=True)
class Heading:
    """A heading within a section."""

    kind: ClassVar[str] = "heading"
    text: str


@dataclass(frozen=True)
class Items:
    """A list of texts."""

    kind: ClassVar[str] = "items"
    texts: Sequence[str]
    style: str = ""


@dataclass(frozen=True)
class Link:
    """A cell of a table that leads to another page."""

    text: str
    place: str


@dataclass(frozen=True)
class Table:
    """Rows of cells below their headings; the first cells of rows without headings are names.

    With a ``summary`` it can be folded; it is open where the page has no JavaScript.
    """

    kind: ClassVar[str] = "table"
    rows: Sequence[Sequence[str | Link]]
    heads: Sequence[str] = ()
    summary: str = ""
    wide: bool = False


@dataclass(frozen=True)
class Template:
    """A template of its own."""

    kind: ClassVar[str] = "template"
    name: str
    values: Mapping[str, Any]


Block = Paragraph | Heading | Items | Table | Template


@dataclass(frozen=True)
class Section:
    """A part of a page with a heading and the name of its place."""

    heading: str
    blocks: Sequence[Block]
    style: str = ""
    name: str = ""

    @property
    def place(self) -> str:
        """Its name, or the heading in letters, digits and hyphens."""
        if self.name:
            return self.name
        words = "".join(c if c.isascii() and c.isalnum() else " " for c in self.heading.lower())
        return "-".join(words.split())


def render(name: str, **values: Any) -> Markup:
    """Returns a template with values; those that are not markup are escaped."""
    from markupsafe import Markup

    return Markup(_environment().get_template(name).render(values))


@cache
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    return Environment(
        loader=PackageLoader("tilth.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
