# SPDX-License-Identifier: BSD-3-Clause
"""The list of single-line changes in `tests/mutants/*.toml`, each of which a test must notice."""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]
LISTS = Path(__file__).with_name("mutants")


@dataclass(frozen=True)
class Mutant:
    """A change of one line.

    Attributes:
        name: of the mutant, unique.
        file: that it changes, relative to the root of the repository.
        line: the text that it replaces, which the file has exactly once: a line or a part of it.
        change: the text in its place.
        guards: what is wrong with the change, in a few words.
        tests: arguments of pytest, the nearest tests first, and of these the shortest.
    """

    name: str
    file: str
    line: str
    change: str
    guards: str
    tests: tuple[str, ...]

    @property
    def is_compiled(self) -> bool:
        """Whether the core has to be built."""
        return not self.file.endswith(".py")

    @property
    def needs_processes(self) -> bool:
        """Whether some of its tests start runs of several processes."""
        return any("test_processes_" in each or "test_petsc" in each for each in self.tests)

    def applied(self, text: str) -> str:
        """Returns the text of the file with the change; raises `ValueError` if it does not fit."""
        if (found := text.count(self.line)) != 1:
            raise ValueError(f"{self.name}: {found} places in {self.file} have `{self.line}`")
        return text.replace(self.line, self.change)


def read_list(folder: Path = LISTS) -> list[Mutant]:
    """Returns all mutants, in the order of the files' names and of the entries."""
    mutants = []
    for file in sorted(folder.glob("*.toml")):
        for entry in tomllib.loads(file.read_text(encoding="utf-8"))["mutant"]:
            mutants.append(_mutant(entry, file.name))
    return mutants


def _mutant(entry: Mapping[str, Any], source: str) -> Mutant:
    tests = tuple(entry.get("tests", ()))
    try:
        return Mutant(**{**entry, "tests": tests})
    except TypeError as error:
        raise ValueError(f"{source}: {entry.get('name', entry)}: {error}") from error


def mistakes(mutants: Iterable[Mutant], root: Path = ROOT) -> list[str]:
    """Returns what is wrong with a list of mutants: nothing if each of them can be applied."""
    found = []
    mutants = list(mutants)
    for name, count in Counter(each.name for each in mutants).items():
        if count > 1:
            found.append(f"{name}: {count} mutants have this name")
    for mutant in mutants:
        found += _mistakes_of(mutant, root)
    return found


def _mistakes_of(mutant: Mutant, root: Path) -> list[str]:
    name, file = mutant.name, root / mutant.file
    if not file.is_file():
        return [f"{name}: there is no file {mutant.file}"]
    found = []
    if "\n" in mutant.line or "\n" in mutant.change:
        found.append(f"{name}: changes more than one line")
    if not mutant.guards:
        found.append(f"{name}: does not say what is wrong with it")
    if not mutant.tests:
        found.append(f"{name}: names no test")
    for test in mutant.tests:
        path, *names = test.split("::")
        if not (root / path).is_file():
            found.append(f"{name}: there is no file {path}")
            continue
        wanted = names[0].split("[")[0] if names else ""
        source = (root / path).read_text(encoding="utf-8")
        if not names and "pytestmark = pytest.mark.slow" in source:
            found.append(f"{name}: {path} has no fast tests; name some of its tests")
        if f"def {wanted}" not in source:
            found.append(f"{name}: {path} has no test {wanted}")
    try:
        text = mutant.applied(before := file.read_text(encoding="utf-8"))
    except ValueError as error:
        return [*found, str(error)]
    if text == before:
        found.append(f"{name}: changes nothing")
    if not mutant.is_compiled and _tree(text) in (None, _tree(before)):
        found.append(f"{name}: the changed file is no other valid Python")
    return found


def _tree(text: str) -> str | None:
    try:
        return ast.dump(ast.parse(text))
    except SyntaxError:
        return None


def packages(root: Path = ROOT) -> set[str]:
    """Returns the folders of source that at least one mutant must change."""
    folders = set()
    for kind, ending in (("src", "*.py"), ("cpp/tilth", "*.hpp")):
        for file in (root / kind).rglob(ending):
            text = file.read_text(encoding="utf-8")
            if file.name != "__init__.py" and len(text.splitlines()) > 1:
                folders.add(file.parent.relative_to(root).as_posix())
    return folders
