# SPDX-License-Identifier: BSD-3-Clause
"""TOML text of a tree of entries, also of one that no case file should have."""

from __future__ import annotations

import datetime
import json
import math
import re
from typing import Any


class Literal(str):
    """Text that is written as it is, in place of a value."""


def toml_text(tree: dict[str, Any]) -> str:
    """Returns the TOML text of a tree: single values first, then a section for each table."""
    single = {key: value for key, value in tree.items() if not _sections(value)}
    lines = _entries(single)
    for key, value in tree.items():
        for table in _sections(value):
            lines += ["", f"[{_key(key)}]" if isinstance(value, dict) else f"[[{_key(key)}]]"]
            lines += _entries(table)
    return "\n".join(lines) + "\n"


def _sections(value: Any) -> list[dict[str, Any]]:
    """Returns the tables that are written as sections; none for a single value."""
    if isinstance(value, dict):
        return [value]
    tables = isinstance(value, list) and value and all(isinstance(v, dict) for v in value)
    return value if tables else []


def _entries(table: dict[str, Any]) -> list[str]:
    return [f"{_key(key)} = {_value(value)}" for key, value in table.items()]


def _key(key: str) -> str:
    if isinstance(key, Literal) or re.fullmatch(r"[A-Za-z0-9_-]+", key):
        return key
    return _text(key)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, Literal):
        return value
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(_entries(value))} }}"
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    return str(value)
