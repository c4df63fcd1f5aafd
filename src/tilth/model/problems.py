# SPDX-License-Identifier: BSD-3-Clause
"""Translation of pydantic's validation errors into clear messages with the case file's keys."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from tilth.errors import Problem

_REJECTED = "rejected"
_DISCRIMINATORS = ("type", "model")

_IMPLIED_TAGS = ["loading"]
"""Kinds that an entry without a discriminator has."""

MOST_NAMES = 30
"""Names among which a misspelt one is sought, and which are listed, at most."""

_PLAIN_WORDS = {
    "model_type": "must be a table of keys",
    "model_attributes_type": "must be a table of keys",
    "mapping_type": "must be a table of keys",
    "dict_type": "must be a table of keys, such as { x = 0 }",
    "union_tag_not_found": "must be a table of keys",
    "sequence_str": "must be a list, not a text",
    "is_instance_of": "must be a list",
}


def rejection(problems: Sequence[Problem]) -> PydanticCustomError:
    """Returns the error with which a validator reports `problems`; keys are relative to it."""
    return PydanticCustomError(_REJECTED, "rejected", {"problems": tuple(problems)})


def reject(problem: str, remedy: str = "") -> PydanticCustomError:
    """Returns the error that a field's validator raises to refuse the value it was given."""
    return rejection([Problem("", problem, remedy)])


def below(key: str, problems: Iterable[Problem]) -> Iterator[Problem]:
    """Yields `problems`, whose keys are relative to the entry `key`, with their whole keys."""
    for problem in problems:
        yield Problem(f"{key}.{problem.key}", problem.problem, problem.remedy, problem.value)


def suggestion(word: object, known: Iterable[str]) -> str | None:
    """Returns the entry of `known` of which `word` is probably a misspelling, or None."""
    likely = difflib.get_close_matches(str(word), list(known), n=1, cutoff=0.6)
    return likely[0] if likely else None


def unknown_name(what: str, name: str, known: Iterable[str]) -> tuple[str, str]:
    """Returns (problem, remedy) for a `name` that is not the name of any declared `what`."""
    names = list(islice(known, MOST_NAMES))
    likely = suggestion(name, names)
    listed = ", ".join(f"`{n}`" for n in names) or "none"
    if len(names) == MOST_NAMES:
        listed += ", ..."
    remedy = f"did you mean `{likely}`?" if likely else f"declared: {listed}"
    return f"there is no {what} of this name", remedy


def problems_of(error: ValidationError, entries: Any) -> list[Problem]:
    """Returns every problem that `error` reports about the raw input `entries`."""
    found: list[Problem] = []
    for detail in error.errors(include_url=False):
        key = dotted(_path(detail["loc"], entries))
        if detail["type"] == _REJECTED:
            for p in detail["ctx"]["problems"]:
                value = detail["input"] if not p.key else p.value
                found.append(Problem(_joined(key, p.key), p.problem, p.remedy, value))
        else:
            found.append(_in_plain_words(key, detail))
    return found


def dotted(path: Iterable[str | int]) -> str:
    """Returns the key of a path: `("bodies", 0, "name")` is `bodies[0].name`."""
    key = ""
    for part in path:
        if isinstance(part, int):
            key += f"[{part}]"
        else:
            bare = part if re.fullmatch(r"[A-Za-z0-9_-]+", part) else f'"{part}"'
            key = _joined(key, bare)
    return key


def _joined(key: str, rest: str) -> str:
    if not key or not rest or rest.startswith("["):
        return key + rest
    return f"{key}.{rest}"


def _path(location: Sequence[str | int], entries: Any) -> list[str | int]:
    """Returns pydantic's location without the tags it inserts for discriminated unions."""
    path: list[str | int] = []
    current, tag_may_follow = entries, True
    for part in location:
        if isinstance(current, Mapping):
            tags = [current[name] for name in _DISCRIMINATORS if name in current] or _IMPLIED_TAGS
            if tag_may_follow and part in tags:
                tag_may_follow = False
                continue
        if part == "[key]":
            continue
        path.append(part)
        tag_may_follow = True
        current = _child(current, part)
    return path


def _child(current: Any, part: str | int) -> Any:
    if isinstance(current, Mapping):
        return current.get(part)
    if isinstance(current, Sequence) and isinstance(part, int) and part < len(current):
        return current[part]
    return None


def _in_plain_words(key: str, detail: ErrorDetails) -> Problem:
    """Returns the problem for one of pydantic's own error types."""
    kind, value = detail["type"], detail["input"]
    context = detail.get("ctx", {})
    if kind == "literal_error":
        return _choice(key, value, re.findall(r"'([^']*)'", str(context["expected"])))
    if kind == "union_tag_invalid":
        discriminator = str(context["discriminator"]).strip("'")
        choices = re.findall(r"'([^']*)'", str(context["expected_tags"]))
        return _choice(_joined(key, discriminator), value[discriminator], choices)
    if kind in _PLAIN_WORDS:
        return Problem(key, _PLAIN_WORDS[kind], value=value)
    return Problem(key, detail["msg"].replace("Input should be", "must be"), value=value)


def _choice(key: str, value: Any, choices: Sequence[str]) -> Problem:
    likely = suggestion(value, choices) if isinstance(value, str) else None
    listed = ", ".join(f'"{choice}"' for choice in choices)
    remedy = f'did you mean "{likely}"? ' if likely else ""
    return Problem(key, "not one of the choices", f"{remedy}choose from {listed}", value)
