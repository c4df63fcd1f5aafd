# SPDX-License-Identifier: BSD-3-Clause
"""From a TOML case file to a validated model."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tilth.errors import BadInput, Problem
from tilth.input_files import absolute, require_file, why_no_file, why_no_folder
from tilth.model import ElementCase, FunctionOutcome, Model, Study
from tilth.model.declaration import FORMAT
from tilth.model.problems import dotted

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


MOST_BYTES = 4_000_000
"""Size of a case file [bytes], at most; reading TOML takes a second per megabyte."""


MANY_PARTS = 10
"""Parts of a key, with points between them, that no case file needs."""

MOST_WORK = 1_000_000
"""Squares of the parts of all such keys, at most: the parser takes as long as that."""

_TEXTS = re.compile(
    r'"""(?:\\.|[^\\])*?(?:"""|\Z)'
    r"|'''.*?(?:'''|\Z)"
    r'|"(?:\\.|[^"\\\n])*"?'
    r"|'[^'\n]*'?|#[^\n]*",
    re.DOTALL,
)
_LONG_KEY = re.compile(rf"(?<![\w-])(?:[\w-]+[ \t]*\.[ \t]*){{{MANY_PARTS},}}")
"""Texts and comments in TOML, also those without an end; a key of many parts where each text is one
letter. Neither takes longer than in proportion to the file."""

_PLAIN = ("file", "folder", "library")
"""Keys whose value is a path alone."""

LONGEST_PATH = 4096
"""Characters in the path of a file, at most."""


def load_case(path: str | Path) -> Model:
    """Returns the model that a case file declares.

    Paths in the file are relative to it. Raises `BadInput`, naming the file, for a file that
    cannot be read or is not TOML, and for every wrong entry.
    """
    entries = case_entries(path)
    try:
        return Model.from_dict(entries)
    except BadInput as error:
        raise error.in_file(path) from None


def case_entries(path: str | Path) -> dict[str, Any]:
    """Returns what a case file contains, with absolute paths, before the model is validated.

    Raises as `load_case`, but for entries that are wrong in the model.
    """
    file = Path(path)
    try:
        entries = _entries(file)
        if "tests" in entries and "bodies" not in entries:
            raise BadInput("has element tests, no analysis", "make them with: tilth element")
        if "vary" in entries and "bodies" not in entries:
            raise BadInput("is a study, not a case", "run it with: tilth study")
        _resolve_files(entries, file.parent)
        return entries
    except BadInput as error:
        raise error.in_file(file) from None


def named_files(entries: dict[str, Any]) -> set[str]:
    """Returns the files, with absolute paths, that the entries of a case name."""
    named = set()
    for _, table, name in _files(entries):
        if isinstance(given := table.get(name), str):
            path = given if name in _PLAIN else given.rpartition(":")[0]
            if path and not why_no_file(path):
                named.add(path)
    return named


def load_study(path: str | Path) -> Study:
    """Returns the study that a file declares, with absolute paths; raises as `load_case`."""
    file = Path(path)
    try:
        entries = _entries(file)
        if "bodies" in entries:
            raise BadInput("is a case, not a study", "run it with: tilth run")
        if "case" not in entries:
            raise BadInput("missing", "name the case file", key="case")
        study = Study.from_dict(entries)
        case = str(absolute(file.parent / str(study.case)))
        outcomes = [
            each.model_copy(update={"function": str(absolute(file.parent / each.function))})
            if isinstance(each, FunctionOutcome)
            else each
            for each in study.outcomes
        ]
        return study.model_copy(update={"case": case, "outcomes": outcomes})
    except BadInput as error:
        raise error.in_file(file) from None


def load_element_case(path: str | Path) -> ElementCase:
    """Returns the element tests that a case file declares; raises as `load_case`."""
    file = Path(path)
    try:
        entries = _entries(file)
        if "bodies" in entries and "tests" not in entries:
            raise BadInput("has an analysis, no element tests", "run it with: tilth run")
        _resolve_files(entries, file.parent)
        return ElementCase.from_dict(entries)
    except BadInput as error:
        raise error.in_file(file) from None


def _entries(file: Path) -> dict[str, Any]:
    """Returns what a case file of the format of this version contains."""
    entries = _parsed(_text_of(file))
    _check_format(entries)
    return entries


def _text_of(file: Path) -> str:
    try:
        require_file(file)
        with file.open("rb") as opened:
            content = opened.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise BadInput(
                f"is larger than {MOST_BYTES // 1_000_000} MB, too large for a case file",
                "give large geometries as a mesh, an STL file or a function in a file of their own",
            )
        return content.decode("utf-8-sig")  # Windows editors put a mark at the start
    except FileNotFoundError:
        others = sorted(other.name for other in file.parent.glob("*.toml"))
        found = f"case files in this folder: {', '.join(others)}" if others else "check the path"
        raise BadInput("there is no such file", found) from None
    except IsADirectoryError:
        inside = sorted(other.name for other in file.glob("*.toml"))
        found = f"case files in it: {', '.join(inside)}" if inside else "give the case file itself"
        raise BadInput("is a folder, not a case file", found) from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise BadInput(f"cannot be read: {reason}", "check the path and its permissions") from None
    except UnicodeDecodeError as error:
        raise BadInput(
            f"is not a text file in UTF-8: byte {error.start} is 0x{error.object[error.start]:02x}",
            "a case file is TOML text; save it as UTF-8",
        ) from None


def _parsed(text: str) -> dict[str, Any]:
    _require_short_keys(text)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise BadInput(
            f"is not valid TOML: {error}",
            "check quotes, brackets and commas there; a key may be given only once in a section",
        ) from None
    except RecursionError:
        raise BadInput(
            "has brackets nested too deeply to be read", "a case file needs six levels at most"
        ) from None
    except ValueError as error:  # what Python, not TOML, cannot read, such as too long a number
        raise BadInput(f"has a value that cannot be read: {error}", "check the numbers") from None


def _require_short_keys(text: str) -> None:
    """Refuses keys of so many parts that parsing takes long: as the square of their number."""
    if not any(line.count(".") >= MANY_PARTS for line in text.splitlines()):
        return
    plain = _TEXTS.sub("q", text)  # what is quoted may have points, and is one part as a key
    found = list(_LONG_KEY.finditer(plain))
    if sum(each[0].count(".") ** 2 for each in found) > MOST_WORK:
        number = plain.count("\n", 0, found[0].start()) + 1
        raise BadInput(
            f"has keys of too many parts, the first one in about line {number}",
            "a case file needs six levels at most",
        )


def _check_format(entries: dict[str, Any]) -> None:
    """Refuses another format at once: all else in such a file may have another meaning."""
    line = f"write format = {FORMAT} in the first line"
    if "format" not in entries:
        raise BadInput("missing", line, key="format")
    given = entries["format"]
    if type(given) is not int or given != FORMAT:
        problem = f"this version of tilth reads format {FORMAT} only"
        raise BadInput(problem, line, key="format", value=given)


def _resolve_files(entries: dict[str, Any], folder: Path) -> None:
    """Makes the paths of other files absolute, and refuses those that do not exist."""
    problems = []
    for key, table, name in _files(entries):
        given = table.get(name)
        if not isinstance(given, str):
            continue
        path, function = given, ""
        if name not in _PLAIN:  # "file.py:name"; what has another form is refused with the model
            path, colon, function = given.rpartition(":")
            if not colon:
                continue
        if "\0" in path or len(path) > LONGEST_PATH:
            what = "is not the path of a file"
            problems.append(Problem(f"{key}.{name}", what, "name a file", given))
            continue
        file = absolute(folder / path)
        if reason := (why_no_folder if name == "folder" else why_no_file)(file):
            remedy = f"the path is relative to the case file: {os.path.abspath(folder / path)}"
            problems.append(Problem(f"{key}.{name}", reason, remedy, given))
        table[name] = f"{file}:{function}" if function else str(file)
    if problems:
        raise BadInput.of(problems)


def _files(entries: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Yields every entry that may name another file: key of its table, table, key in it."""
    for i, body in enumerate(_tables(entries.get("bodies"))):
        yield from _files_of_shape(f"bodies[{i}].shape", body.get("shape"))
        for j, layer in enumerate(_tables(body.get("layers"))):
            if isinstance(layer.get("bottom"), dict):
                yield f"bodies[{i}].layers[{j}].bottom", layer["bottom"], "file"
    initial = entries.get("initial")
    stresses = initial.get("stress") if isinstance(initial, dict) else None
    for i, entry in enumerate(_tables(stresses)):
        yield from _files_of_parameters(f"initial.stress[{i}]", entry)
        yield f"initial.stress[{i}]", entry, "folder"
    velocities = initial.get("velocity") if isinstance(initial, dict) else None
    for i, entry in enumerate(_tables(velocities)):
        yield from _files_of_parameters(f"initial.velocity[{i}]", entry)
    stages = _tables(entries.get("stages"))
    for i, stage in enumerate(stages):
        for j, region in enumerate(_tables(stage.get("excavate"))):
            yield from _files_of_shape(f"stages[{i}].excavate[{j}].shape", region.get("shape"))
    tables = {"water": entries.get("water")}
    tables |= {f"stages[{i}].water": stage.get("water") for i, stage in enumerate(stages)}
    for key, water in tables.items():
        for level in ("level", "initial_level"):
            if isinstance(water, dict) and isinstance(water.get(level), dict):
                yield f"{key}.{level}", water[level], "file"
    materials = entries.get("materials")
    for material, parameters in materials.items() if isinstance(materials, dict) else ():
        if isinstance(parameters, dict):
            yield from _files_of_parameters(dotted(("materials", material)), parameters)
    for i, boundary in enumerate(_tables(entries.get("boundaries"))):
        yield f"boundaries[{i}]", boundary, "motion"
        if isinstance(boundary.get("acceleration"), dict):
            yield f"boundaries[{i}].acceleration", boundary["acceleration"], "file"
        yield from _files_of_geometry(f"boundaries[{i}].geometry", boundary.get("geometry"))
    for i, body in enumerate(_tables(entries.get("rigid_bodies"))):
        yield from _files_of_geometry(f"rigid_bodies[{i}].geometry", body.get("geometry"))
        for j, shape in enumerate(_tables(body.get("geometries"))):
            yield from _files_of_geometry(f"rigid_bodies[{i}].geometries[{j}]", shape)
    flow = entries.get("flow")
    drains = flow.get("boundaries") if isinstance(flow, dict) else None
    for i, each in enumerate(_tables(drains)):
        yield from _files_of_geometry(f"flow.boundaries[{i}].geometry", each.get("geometry"))


def _files_of_shape(key: str, shape: Any) -> Iterator[tuple[str, dict[str, Any], str]]:
    if isinstance(shape, dict):
        yield key, shape, "file"
        for level in ("surface", "base"):
            if isinstance(shape.get(level), dict):
                yield f"{key}.{level}", shape[level], "file"
        for i, hole in enumerate(_tables(shape.get("holes"))):
            yield f"{key}.holes[{i}]", hole, "file"


def _files_of_geometry(key: str, geometry: Any) -> Iterator[tuple[str, dict[str, Any], str]]:
    if isinstance(geometry, dict):
        yield key, geometry, "file"
        yield key, geometry, "function"


def _files_of_parameters(
    key: str, table: dict[str, Any]
) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Yields the entries of a material, and of the tables in it, that may name another file."""
    for name, value in table.items():
        if isinstance(value, str) and (name in ("file", "library") or ".py:" in value):
            yield key, table, name
        elif isinstance(value, dict):
            yield from _files_of_parameters(f"{key}.{name}", value)


def _tables(entries: Any) -> list[dict[str, Any]]:
    """Returns the entries of a list, an empty table for each that is none."""
    listed = entries if isinstance(entries, list) else []
    return [entry if isinstance(entry, dict) else {} for entry in listed]
