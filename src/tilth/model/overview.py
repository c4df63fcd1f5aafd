# SPDX-License-Identifier: BSD-3-Clause
"""What a notebook shows of a model."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration

MOST = 6
"""Entries of a list that are named."""


def html_table(rows: Mapping[str, str]) -> str:
    """Returns a table of HTML with a heading and a text in each row; empty texts are left out."""
    cells = (f"<tr><th>{escape(key)}</th><td>{escape(text)}</td></tr>" for key, text in rows.items()
             if text)  # fmt: skip
    return f"<table>{''.join(cells)}</table>"


def overview(model: Declaration) -> dict[str, str]:
    """Returns what is shown of a model, by headings."""
    cells = " x ".join(f"{size:g}" for size in model.cell_size)
    graded = any(len(line) for line in model.lines)
    lists = ("boundaries", "rigid_bodies", "loads", "track", "stages")
    return {
        "title": model.title,
        "analysis": model.analysis.kind.replace("_", " "),
        "smallest cell" if graded else "cell": f"{cells} {model.units.length}".rstrip(),
        "bodies": _listed(model.bodies),
        "materials": ", ".join(
            f"{name} ({material.model})" for name, material in model.materials.items()
        ),
        **{key.replace("_", " "): _listed(getattr(model, key)) for key in lists},
        "steps": " + ".join(f"{each.schedule.number_of_steps:,}" for each in model.of_stages),
    }


def _listed(entries: Any) -> str:
    """Returns the names of the entries of a list, of those without one what they are."""
    names = [each.name or each.type.replace("_", " ") for each in entries[:MOST]]
    more = len(entries) - MOST
    return ", ".join(names) + (f" and {more} more" if more > 0 else "")
