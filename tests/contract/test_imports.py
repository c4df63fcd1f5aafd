# SPDX-License-Identifier: BSD-3-Clause
"""The rooms of the house stand one above the other: no room imports from a higher one."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

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
    "results",
    "export",
    "plot",
    "report",
    "bodies curves",
    "variation templates",
    "output",
    "case",
    "model",
    "grid_lines input_files",
    "mpi",
    "comm",
    "input_files",
    "arrays environment errors interrupt memory_errors timers",
    "_core __init__",
]
"""From the top down; those of one line do not import each other."""

LEVEL = {room: level for level, rooms in enumerate(ROOMS) for room in rooms.split()}


def room_of(module: str) -> str:
    """The room of a module by its full name, or of a name that the package itself offers."""
    parts = module.split(".")
    return parts[1] if module.startswith("tilth.") and parts[1] in LEVEL else "__init__"


def imports(path: Path, at_once: bool = False) -> Iterator[str]:
    """Full names of the modules of tilth and its verification that a file imports when it runs.

    at_once: only those that it imports as soon as it is loaded, not in a function.
    """
    package = path.relative_to(SOURCES).parts[:-1]
    tree = ast.parse(path.read_text(encoding="utf-8"))
    if at_once:
        tree.body = [node for node in tree.body if not isinstance(node, ast.FunctionDef)]
    for_types = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        if id(node) in for_types:
            continue
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name.startswith("tilth"))
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) + 1 - node.level] if node.level else ()
            module = ".".join([*base, *([node.module] if node.module else [])])
            if module == "tilth":
                yield from (f"tilth.{name.name}" for name in node.names)
            elif module.startswith(("tilth.", "tilth_verification")):
                yield module


def test_every_module_has_a_room() -> None:
    found = {path.relative_to(ROOT).parts[0].removesuffix(".py") for path in ROOT.rglob("*.py")}
    assert found | {"_core"} == set(LEVEL)


def test_no_room_imports_from_a_higher_one() -> None:
    wrong = []
    for path in sorted(ROOT.rglob("*.py")):
        name = path.relative_to(ROOT)
        room = name.parts[0].removesuffix(".py")
        if room == "__init__":
            continue  # offers the public names of all rooms, when they are asked for
        for module in imports(path):
            other = room_of(module)
            if other != room and LEVEL[other] <= LEVEL[room]:
                wrong.append(f"{name} imports {module}")
    assert wrong == []


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
        if module.startswith("tilth.") and LEVEL[room_of(module)] < LEVEL["analysis"]
    ]
    assert wrong == []
