# SPDX-License-Identifier: BSD-3-Clause
"""Places in the entries of a case file, such as `materials.clay.density`."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

from tilth.errors import BadInput
from tilth.model.problems import suggestion


def changed(entries: dict[str, Any], key: str, value: Any) -> dict[str, Any]:
    """Returns a copy of the entries of a case with another value at a place.

    Args:
        key: keys with points between them. An entry of a list is named by its `name`, or by its
            number from 0. The last key may be new; whether it is known is for the model to say.

    Raises:
        BadInput: there is no such place; with a near name if there is one.
    """
    result = copy.deepcopy(entries)
    parts = key.split(".")
    place: Any = result
    for i, part in enumerate(parts[:-1]):
        place = place[_index(place, part, parts[:i], key, new=False)]
    place[_index(place, parts[-1], parts[:-1], key, new=True)] = copy.deepcopy(value)
    return result


def value_at(entries: dict[str, Any], key: str) -> Any:
    """Returns the value at a place, see `changed`; None where the last key is not there."""
    parts = key.split(".")
    place: Any = entries
    for i, part in enumerate(parts):
        index = _index(place, part, parts[:i], key, new=i == len(parts) - 1)
        if isinstance(place, dict) and index not in place:
            return None
        place = place[index]
    return place


def near_key(entries: dict[str, Any], key: str) -> str | None:
    """Returns a key beside the last one of `key` of which that is probably a misspelling."""
    above, _, last = key.rpartition(".")
    table = value_at(entries, above) if above else entries
    if not isinstance(table, dict) or last in table:
        return None
    return suggestion(last, table)


def _index(place: Any, part: str, before: Sequence[str], key: str, *, new: bool) -> str | int:
    """Returns the key or the number that `part` means in a table or a list."""
    where = ".".join(before)
    if isinstance(place, dict):
        if part in place or (new and part):
            return part
        known = [str(name) for name in place]
        what = f"`{where}` has no `{part}`" if where else f"the case has no `{part}`"
    elif isinstance(place, list):
        if part.isascii() and part.isdigit() and int(part) < len(place):
            return int(part)
        names = [each.get("name") if isinstance(each, dict) else None for each in place]
        if part in names:
            return names.index(part)
        known = [str(name) for name in names if name is not None]
        known += [f"{i}" for i in range(len(place))]
        what = f"`{where}` has no entry `{part}`"
    else:
        what = f"`{where}` is a value, not a table or a list"
        raise BadInput(what, "leave out what follows it", key="key", value=key)
    likely = suggestion(part, known)
    remedy = f"did you mean `{likely}`?" if likely else f"there are: {', '.join(known) or 'none'}"
    raise BadInput(what, remedy, key="key", value=key)
