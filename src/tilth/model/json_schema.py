# SPDX-License-Identifier: BSD-3-Clause
"""JSON schema (draft 2020-12) of case files, from the declarations: for editors and validators.

It knows keys, required keys, types, bounds and choices. What depends on several entries, such as
names that refer to each other, only `tilth check` finds.
"""

from __future__ import annotations

import inspect
import types
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import BeforeValidator, PlainValidator
from pydantic.fields import FieldInfo

from tilth.model import fields
from tilth.model.base import Declared, meaning_of
from tilth.model.declaration import FORMAT
from tilth.model.element_case import ElementCase
from tilth.model.model import Model
from tilth.model.stages import Stage

DIALECT = "https://json-schema.org/draft/2020-12/schema"
"""The dialect of the schema."""

_PLAIN = {float: "number", int: "integer", bool: "boolean", str: "string"}

_BOUNDS: dict[Any, dict[str, float]] = {
    fields.Positive: {"exclusiveMinimum": 0},
    fields.NotNegative: {"minimum": 0},
    fields.Count: {"minimum": 1},
    fields.CountOrZero: {"minimum": 0},
    fields.Share: {"exclusiveMinimum": 0, "exclusiveMaximum": 1},
}
"""Bounds of the kinds of numbers."""

_BOUND_OF_CHECK = {get_args(kind)[1]: bounds for kind, bounds in _BOUNDS.items()}

_TAKEN: dict[Any, Any] = {
    get_args(fields.CountPerDirection)[1]: fields.Count | Sequence[fields.Count],
    get_args(fields.Tensor)[1]: Sequence[fields.Positive] | Sequence[Sequence[fields.Real]],
    get_args(fields.PositivePerDirection)[1]: fields.Positive | Sequence[fields.Positive],
}
"""What a check takes, where its own type says less."""

_SECTIONS = ("type", "model")
"""Keys that select the kind of a table; Python takes them from the class."""


def case_schema() -> dict[str, Any]:
    """Returns the JSON schema of a case file of `tilth run`, as dictionaries and lists."""
    either = [{"required": ["schedule"]}, {"required": ["stages"]}]
    return {**_Schema().of(Model, "Case file of tilth"), "anyOf": either}


def element_schema() -> dict[str, Any]:
    """Returns the JSON schema of a case file of `tilth element`, as dictionaries and lists."""
    return _Schema().of(ElementCase, "Case file of element tests of tilth")


class _Schema:
    """Collects the tables that a schema refers to."""

    def __init__(self) -> None:
        self._tables: dict[str, dict[str, Any]] = {}

    def of(self, cls: type[Declared], title: str) -> dict[str, Any]:
        """Returns the schema of a whole file, declared by `cls`."""
        whole = self._table(cls)
        whole["properties"]["format"] = {"const": FORMAT, "description": meaning_of(cls, "format")}
        whole["required"] = sorted({*whole["required"], "format"})
        return {"$schema": DIALECT, "title": title, **whole, "$defs": self._tables}

    def _table(self, cls: type[Declared]) -> dict[str, Any]:
        """Returns the schema of a table."""
        hints = get_type_hints(cls, include_extras=True)
        properties, required = {}, []
        for name, field in cls.model_fields.items():
            key = field.alias or name
            entry = self._entry(hints[name])
            if text := meaning_of(cls, name):
                entry = {**entry, "description": text}
            if isinstance(field.default, bool | int | float | str):
                entry.setdefault("default", field.default)
            properties[key] = entry
            if field.is_required() or _selects_kind(cls, name, field):
                required.append(key)
        return {
            "type": "object",
            "description": _first_paragraph(cls),
            "properties": properties,
            "required": required,
            "additionalProperties": False,
        }

    def _entry(self, kind: Any) -> dict[str, Any]:
        """Returns the schema of a value of the type `kind`."""
        origin, arguments = get_origin(kind), get_args(kind)
        if origin is Annotated:
            return self._checked(arguments[0], arguments[1:])
        if origin is Literal:
            return {"const": arguments[0]} if len(arguments) == 1 else {"enum": list(arguments)}
        if origin in (Union, types.UnionType):
            kinds = [self._entry(each) for each in arguments if each is not type(None)]
            return kinds[0] if len(kinds) == 1 else {"anyOf": kinds}
        if origin is Mapping:
            return self._mapping(*arguments)
        if origin in (Sequence, tuple):
            return {"type": "array", "items": self._entry(arguments[0])}
        if inspect.isclass(kind) and issubclass(kind, Declared):
            if kind.__name__ not in self._tables:
                self._tables[kind.__name__] = {}  # before it is made: tables may contain each other
                self._tables[kind.__name__] = self._table(kind)
            return {"$ref": f"#/$defs/{kind.__name__}"}
        return {"type": _PLAIN[kind]}

    def _checked(self, kind: Any, checks: Sequence[Any]) -> dict[str, Any]:
        """Returns the schema of a value that is checked: of what is taken, not what it becomes."""
        for check in checks:
            if isinstance(check, PlainValidator | BeforeValidator):
                taken = check.json_schema_input_type
                taken = _TAKEN.get(check, taken)
                if taken is not Any and repr(taken) != "PydanticUndefined":
                    return self._entry(taken)
        entry = self._entry(kind)
        if checks == get_args(fields.PythonFunction)[1:]:
            entry = {**entry, "pattern": r"\.py:"}
        if any(isinstance(each, FieldInfo) and each.discriminator for each in checks):
            entry = {"oneOf": entry["anyOf"]}
        for check in checks:
            if isinstance(check, PlainValidator):
                entry = {**entry, **_BOUND_OF_CHECK.get(check, {})}
        return entry

    def _mapping(self, key: Any, value: Any) -> dict[str, Any]:
        """Returns the schema of a table with any names as keys, or with those of a choice."""
        entry = self._entry(value)
        if get_origin(key) is Literal:
            properties = dict.fromkeys(get_args(key), entry)
            return {"type": "object", "properties": properties, "additionalProperties": False}
        return {"type": "object", "additionalProperties": entry}


def _selects_kind(cls: type[Declared], name: str, field: FieldInfo) -> bool:
    """Returns whether a file must give the key although Python takes it from the class."""
    is_constant = get_origin(field.annotation) is Literal and len(get_args(field.annotation)) == 1
    return name in _SECTIONS and is_constant and cls is not Stage


def _first_paragraph(cls: type[Declared]) -> str:
    """Returns the first paragraph of the docstring of a class, on one line."""
    return " ".join((inspect.getdoc(cls) or "").split("\n\n")[0].split())
