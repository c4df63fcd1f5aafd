# SPDX-License-Identifier: BSD-3-Clause
"""Tables of nested plain data, such as the declared model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tilth.report.blocks import Block, Heading, Table


def facts_table(facts: Mapping[str, str]) -> Table:
    """Returns a table of two columns: name and value."""
    return Table(list(facts.items()))


def model_tables(summary: Mapping[str, Any]) -> list[Block]:
    """Returns one heading and table per part of the model.

    A mapping becomes rows of name and value; a list of mappings (bodies, boundaries, ...) and a
    mapping of mappings (materials) become one table with a row for each, a column for each key.
    """
    parts: list[Block] = []
    single_values = {}
    for name, value in summary.items():
        if isinstance(value, Mapping) and value and _all_mappings(list(value.values())):
            rows = [{"name": key, **entry} for key, entry in value.items()]
            parts += [_heading(name), _entries(rows)]
        elif isinstance(value, Mapping):
            if value:
                parts += [_heading(name), facts_table(_spaced(_filled(value)))]
        elif _is_list(value) and value and _all_mappings(value):
            parts += [_heading(name), _entries(list(value))]
        elif value is not None and not (_is_list(value) and not value):
            single_values[name] = _text(value)
    if single_values:
        parts.insert(0, facts_table(_spaced(single_values)))
    return parts


def _heading(name: str) -> Heading:
    return Heading(name.replace("_", " ").capitalize())


def _entries(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Returns a table with one row per entry; columns without values are left out."""
    keys = [
        key
        for key in dict.fromkeys(key for row in rows for key in row)
        if any(row.get(key) not in (None, [], {}, ()) for row in rows)
    ]
    cells = [[_text(row.get(key)) for key in keys] for row in rows]
    return Table(cells, [key.replace("_", " ") for key in keys])


def _filled(values: Mapping[str, Any]) -> dict[str, str]:
    return {name: text for name, value in values.items() if (text := _text(value))}


def _spaced(values: Mapping[str, str]) -> dict[str, str]:
    return {name.replace("_", " "): value for name, value in values.items()}


def _text(value: Any) -> str:
    """Returns a value as text without trailing zeros; nothing for none, and for an empty list."""
    if value is None or (_is_list(value) and not value):
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:,.10g}"
    if isinstance(value, Mapping):
        items = _filled(value)
        kind = items.pop("type", None)
        inner = ", ".join(f"{key.replace('_', ' ')} {item}" for key, item in items.items())
        return f"{kind}: {inner}" if kind and inner else str(kind) if kind else inner
    if _is_list(value):
        shown = list(value)
        if len(shown) > 12:
            return f"{_text(shown[:5])[:-1]}, ... {_text(shown[-1])}) ({len(shown)} entries)"
        return "(" + ", ".join(_text(item) for item in shown) + ")"
    return str(value)


def _is_list(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str)


def _all_mappings(values: Sequence[Any]) -> bool:
    return all(isinstance(value, Mapping) for value in values)
