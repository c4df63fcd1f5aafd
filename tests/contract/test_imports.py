# SPDX-License-Identifier: BSD-3-Clause
"""The rooms of the house stand one above the other: no room imports from a higher one.

Imports for annotations alone count as well: who names a type depends on it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

SOURCES = Path(__file__).parents[2] / "src"
ROOT = SOURCES / "tilth"
VERIFICATION = SOURCES / "tilth_verification"

ROOMS = [
    "__main__",
    "cli",
    "commands",
    "studies",
    "analysis",
    "element_tests",
    "boundaries",
    "geometry surface",
    "terms solvers",
    "mpm",
    "algebra",
    "results",
    "export",
    "plot",
    "report",
    "bodies curves",
    "variation templates",
    "output",
    "grid",
    "case",
    "model",
    "grid_lines",
    "mpi",
    "comm",
    "input_files memory_estimate",
    "available_memory",
    "arrays environment errors interrupt memory_errors timers",
    "_core __init__",
]
"""From the top down; those of one line do not import each other."""

ROOMS_OF_BOUNDARIES = [
    "__init__",
    "absorbing flow",
    "step",
    "contact implicit",
    "surfaces",
    "base_motion plane_faces",
    "affine nodal",
    "protocol",
]
"""The same within `boundaries`."""

LARGEST_LOOP = 3
"""Modules that import each other, annotations counted, at most."""


def levels(rooms: list[str]) -> dict[str, int]:
    return {room: level for level, line in enumerate(rooms) for room in line.split()}


LEVEL = levels(ROOMS)


@cache
def imports(path: Path, at_once: bool = False) -> list[str]:
    """Full names of the modules of tilth and its verification that a file imports.

    at_once: only those that it imports as soon as it is loaded, not in a function.
    """
    return list(_imports(path, at_once))


def _imports(path: Path, at_once: bool) -> Iterator[str]:
    package = path.relative_to(SOURCES).parts[:-1]
    tree = ast.parse(path.read_text(encoding="utf-8"))
    if at_once:
        tree.body = [node for node in tree.body if not isinstance(node, ast.FunctionDef)]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name.startswith("tilth"))
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) + 1 - node.level] if node.level else ()
            module = ".".join([*base, *([node.module] if node.module else [])])
            if module == "tilth" or module.startswith(("tilth.", "tilth_verification")):
                named = (f"{module}.{name.name}" for name in node.names)
                yield from (
                    each if each in MODULES or module == "tilth" else module for each in named
                )


def modules() -> dict[str, Path]:
    """All modules by their full names."""
    paths = {
        ".".join(("tilth", *path.relative_to(ROOT).with_suffix("").parts)): path
        for path in sorted(ROOT.rglob("*.py"))
    }
    return {name.removesuffix(".__init__"): path for name, path in paths.items()}


MODULES = modules()


def upwards(within: Path, level: dict[str, int], depth: int) -> list[str]:
    """Imports from a room that is not below, of the files in a folder.

    depth: which part of a module's name is its room.
    """
    wrong = []
    for path in sorted(within.rglob("*.py")):
        room = path.relative_to(within).parts[0].removesuffix(".py")
        if within == ROOT and room == "__init__":
            continue  # offers the public names of all rooms, when they are asked for
        for module in imports(path):
            parts = [*module.split("."), "__init__"]
            if parts[0] != "tilth" or (depth == 2 and parts[1] != within.name):
                continue
            other = parts[depth] if parts[depth] in level else "__init__"
            if other != room and level[other] <= level[room]:
                wrong.append(f"{path.relative_to(ROOT)} imports {module}")
    return wrong


def test_every_module_has_a_room() -> None:
    for within, level in ((ROOT, LEVEL), (ROOT / "boundaries", levels(ROOMS_OF_BOUNDARIES))):
        parts = [path.relative_to(within).parts[0] for path in within.rglob("*.py")]
        assert {part.removesuffix(".py") for part in parts} == set(level) - {"_core"}


def test_no_room_imports_from_a_higher_one() -> None:
    assert upwards(ROOT, LEVEL, 1) == []


def test_no_room_of_the_boundaries_imports_from_a_higher_one() -> None:
    assert upwards(ROOT / "boundaries", levels(ROOMS_OF_BOUNDARIES), 2) == []


def test_few_modules_import_each_other() -> None:
    number = {name: i for i, name in enumerate(MODULES)}
    pairs = [
        (number[name], number[module])
        for name, path in MODULES.items()
        for module in imports(path)
        if module in number and module != "tilth"
    ]
    graph = coo_matrix((np.ones(len(pairs)), np.transpose(pairs)), (len(number), len(number)))
    _, loop = connected_components(graph, connection="strong")
    largest = np.bincount(loop).argmax()
    names = [name for name, i in number.items() if loop[i] == largest]
    assert len(names) <= LARGEST_LOOP, names


def importing_verification(at_once: bool = False) -> list[str]:
    """The modules of tilth that import its verification."""
    return [
        path.relative_to(ROOT).as_posix()
        for path in sorted(ROOT.rglob("*.py"))
        if any(name.startswith("tilth_verification") for name in imports(path, at_once))
    ]


def test_only_the_command_imports_the_verification_and_not_before_it_runs() -> None:
    assert importing_verification() == ["commands/verify.py"]
    assert importing_verification(at_once=True) == []


def test_the_verification_imports_neither_commands_nor_studies() -> None:
    wrong = [
        f"{path.relative_to(SOURCES)} imports {module}"
        for path in sorted(VERIFICATION.rglob("*.py"))
        for module in imports(path)
        if LEVEL.get(module.removeprefix("tilth.").partition(".")[0], LEVEL["model"])
        < LEVEL["analysis"]
    ]
    assert wrong == []
