# SPDX-License-Identifier: BSD-3-Clause
"""Base class of all declarations of the user: immutable, no unknown keys, clear messages."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from textwrap import dedent
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, model_validator

from tilth.errors import BadInput, Problem
from tilth.model.problems import MOST_NAMES, problems_of, rejection, suggestion

if TYPE_CHECKING:
    from typing_extensions import Self

MOST_LEVELS = 20
"""Levels of lists and tables in a case file, at most."""


class Declared(BaseModel):
    """An immutable, validated declaration; a wrong entry raises `BadInput` with key and value."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True, populate_by_name=True)

    if not TYPE_CHECKING:  # type checkers derive the signature from the fields

        def __init__(self, /, **entries: Any) -> None:
            try:
                self.__pydantic_validator__.validate_python(entries, self_instance=self)
            except ValidationError as error:
                raise BadInput.of(_named(type(self), problems_of(error, entries))) from None

        # Nested tables must be validated in place, not by this wrapper, to have full keys.
        __init__.__pydantic_base_init__ = True

        def __setattr__(self, name: str, value: Any) -> None:
            """Refuses the change: a declaration that was validated stays as it is."""
            changed = type(self).__name__
            raise BadInput(
                "a declaration is frozen: it cannot be changed",
                f"make a changed copy: {changed.lower()}.model_copy(update={{{name!r}: ...}}); it "
                "is validated, and goes into a copy of the model in the same way",
                key=f"{changed}.{name}",
                value=value,
            )

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Returns a copy with the entries of `update` in place of the declaration's own.

        The copy is validated like a new declaration; raises `BadInput` with every wrong entry.
        `deep` has no meaning for an immutable declaration.
        """
        given = {name: getattr(self, name) for name in self.model_fields_set}
        return type(self)(**{**given, **(update or {})})

    @classmethod
    def required_keys(cls, given: Mapping[str, Any]) -> set[str]:
        """Returns the names of the fields that must be given beside the entries `given`."""
        return {name for name, field in cls.model_fields.items() if field.is_required()}

    @model_validator(mode="before")
    @classmethod
    def _keys_are_known_and_complete(cls, data: Any) -> Any:
        """Refuses unknown keys, with a suggestion, and reports missing ones, with their meaning."""
        if not isinstance(data, dict):
            return data
        names = {field.alias or name: name for name, field in cls.model_fields.items()}
        keys = {name: key for key, name in names.items()}
        data = {keys.get(key, key): value for key, value in data.items()}
        fields = {key: cls.model_fields[name] for key, name in names.items()}
        unknown = [key for key in data if key not in fields]
        required = cls.required_keys(data)
        missing = [key for key in fields if names[key] in required and key not in data]
        problems = []
        for number, key in enumerate(unknown):
            open_keys = [name for name in fields if name not in data]
            likely = suggestion(key, open_keys) if number < MOST_NAMES else None
            if likely in missing:
                missing.remove(likely)
            remedy = f"did you mean `{likely}`?" if likely else f"known keys: {', '.join(fields)}"
            problems.append(Problem(str(key), "unknown key", remedy, data[key]))
        for key in missing:
            problems.append(Problem(key, "missing", f"give `{key}`: {meaning_of(cls, names[key])}"))
        if problems:
            raise rejection(problems)
        return data


class DeclaredFile(Declared):
    """A declaration that is the whole of a file of the user."""

    @classmethod
    def from_dict(cls, entries: Mapping[str, Any]) -> Self:
        """Returns the declaration from a dictionary like that of its file; raises `BadInput`."""
        _require_few_levels(entries)
        try:
            return cls.model_validate(dict(entries))
        except ValidationError as error:
            raise BadInput.of(problems_of(error, entries)) from None


def _require_few_levels(entries: Mapping[str, Any]) -> None:
    """Refuses lists and tables nested so deeply that functions that call themselves end in them."""
    found: list[tuple[str, Any, int]] = [(str(key), value, 1) for key, value in entries.items()]
    while found:
        key, value, level = found.pop()
        if isinstance(value, Mapping):
            value = list(value.values())
        if not isinstance(value, list | tuple):
            continue
        if level > MOST_LEVELS:
            what = f"has more than {MOST_LEVELS} levels of lists and tables"
            raise BadInput(what, "a case file needs six at most", key=key)
        found += [
            (key, each, level + 1) for each in value if isinstance(each, Mapping | list | tuple)
        ]


def chosen_by(discriminator: str, *classes: type[Declared]) -> BeforeValidator:
    """Returns a check that a table has the key `discriminator`, which selects one of `classes`."""
    choices = ", ".join(f'"{cls.model_fields[discriminator].default}"' for cls in classes)

    def names_its_kind(entries: Any) -> Any:
        if isinstance(entries, dict) and discriminator not in entries:
            raise rejection([Problem(discriminator, "missing", f"choose from {choices}")])
        return entries

    return BeforeValidator(names_its_kind)


def meaning_of(cls: type[Declared], key: str) -> str:
    """Returns the text below the field `key` in the source of `cls`, "" where there is none.

    It is read on demand: reading it for every field would slow down each start of the program.
    """
    owner = next(base for base in cls.__mro__ if key in inspect.get_annotations(base))
    return _meanings(owner).get(key, "")


@cache
def _meanings(cls: type) -> dict[str, str]:
    """Returns the text below each field in the source of `cls`."""
    try:
        body = ast.parse(dedent(inspect.getsource(cls))).body[0]
    except OSError:
        return {}
    assert isinstance(body, ast.ClassDef)
    return {
        ast.unparse(field.target): " ".join(str(below.value.value).split())
        for field, below in pairwise(body.body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(below, ast.Expr)
        and isinstance(below.value, ast.Constant)
    }


def _named(cls: type[Declared], problems: list[Problem]) -> list[Problem]:
    """Returns the problems with the class name before the key, unless it is the whole model."""
    if cls.__name__ == "Model":
        return problems
    return [
        Problem(".".join(filter(None, (cls.__name__, p.key))), p.problem, p.remedy, p.value)
        for p in problems
    ]
