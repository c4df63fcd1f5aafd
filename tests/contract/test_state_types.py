# SPDX-License-Identifier: BSD-3-Clause
"""Only the loops over steps, stages and trials hold a whole analysis; else a function takes parts.

`Simulation` is setup, state and services together. Files that need it for their types alone would
close a ring, in which none can be read or changed without the others.
"""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2] / "src" / "tilth"
LOOPS = {
    "analysis/simulation.py",
    "analysis/load_steps.py",
    "analysis/march.py",
    "analysis/initial_equilibrium.py",
    "analysis/stage_change.py",
    "analysis/staged.py",
    "analysis/gathering.py",
    "analysis/safety.py",
    "analysis/safety_trials.py",
}
"""Files of the loops, and of what hands an analysis from one to the next."""


def whole_parameters(tree: ast.AST) -> list[str]:
    """The functions that take a whole simulation."""
    return [
        node.name
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        for each in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        if each.annotation is not None and ast.unparse(each.annotation).strip("'\"") == "Simulation"
    ]


def test_no_function_takes_the_whole_but_those_of_the_loops() -> None:
    found = []
    for path in sorted((ROOT / "analysis").glob("*.py")):
        name = str(path.relative_to(ROOT))
        if name not in LOOPS:
            tree = ast.parse(path.read_text(encoding="utf-8"))
            found += [f"{name}: {function}" for function in whole_parameters(tree)]
    assert found == []


def test_the_whole_is_found() -> None:
    tree = ast.parse(
        "def f(a: int, simulation: Simulation) -> None: ...\ndef g(a: int) -> None: ..."
    )
    assert whole_parameters(tree) == ["f"]
