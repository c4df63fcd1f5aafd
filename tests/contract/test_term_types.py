# SPDX-License-Identifier: BSD-3-Clause
"""No module outside a term's own room asks which type a term has: terms say what they are.

The sources are read as syntax trees. The types are those of all terms of the balance, in the sense
of `tilth.terms.protocol`; the room of a type is the package that defines it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2] / "src" / "tilth"
PROTOCOL = ("Term", "AssembledTerm", "GlobalUnknowns")
"""Types that every term is one of."""

KNOWN = {
    "AssembledContact": "boundaries/contact",
    "AssembledInertia": "terms",
    "AssembledDashpots": "terms",
    "AssembledStiffnessDamping": "terms",
    "GlobalUnknowns": "terms",
    "SurfaceLoads": "surface",
}
"""Some of the types that must be found, and their rooms."""


@cache
def sources() -> dict[str, ast.Module]:
    """Syntax trees of the modules of tilth that name a type of terms, by path under the package."""
    texts = {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(ROOT.rglob("*.py"))
    }
    trees: dict[str, ast.Module] = {}
    names = set(PROTOCOL)
    while True:
        new = [path for path in texts.keys() - trees if any(name in texts[path] for name in names)]
        if not new:
            return dict(sorted(trees.items()))
        trees |= {path: ast.parse(texts[path]) for path in new}
        names |= types_of_terms(trees).keys()


def room_of(path: str) -> str:
    """The package of a module, by its path."""
    return Path(path).parent.as_posix()


def names_in(expression: ast.AST) -> set[str]:
    """Last parts of all names that an expression contains."""
    names = {node.id for node in ast.walk(expression) if isinstance(node, ast.Name)}
    return names | {node.attr for node in ast.walk(expression) if isinstance(node, ast.Attribute)}


def types_of_terms(trees: Mapping[str, ast.Module]) -> dict[str, str]:
    """Names of all types of terms, those of the protocol too, and the room of each."""
    classes = [
        (path, node)
        for path, tree in trees.items()
        for node in tree.body
        if isinstance(node, ast.ClassDef)
    ]
    rooms = {node.name: room_of(path) for path, node in classes if node.name in PROTOCOL}
    found = 0
    while found < len(rooms):
        found = len(rooms)
        for path, node in classes:
            if any(names_in(base) & rooms.keys() for base in node.bases):
                rooms.setdefault(node.name, room_of(path))
    return rooms


def meanings(tree: ast.Module, types: Mapping[str, str]) -> dict[str, set[str]]:
    """Types of terms that each name of a module can stand for: other names of imports, tuples."""
    found = {name: {name} for name in types}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            found |= {each.asname: {each.name} for each in node.names if each.asname}
    found = {name: meant & types.keys() for name, meant in found.items()}
    assigned = [
        (target.id, node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and are_types(node.value)
        for target in node.targets
        if isinstance(target, ast.Name)
    ]
    for _ in assigned:  # one name may stand for another one
        for name, value in assigned:
            found.setdefault(name, set()).update(meant_by(value, found))
    return found


def are_types(value: ast.expr) -> bool:
    """Whether an expression can stand for types: a name, or several in a tuple, list or union."""
    if isinstance(value, ast.Tuple | ast.List | ast.Set):
        return all(are_types(each) for each in value.elts)
    if isinstance(value, ast.BinOp):
        return are_types(value.left) and are_types(value.right)
    return isinstance(value, ast.Name | ast.Attribute)


def meant_by(expression: ast.AST, names: Mapping[str, set[str]]) -> set[str]:
    """The types of terms that an expression names, also as texts."""
    found = {each for name in names_in(expression) for each in names.get(name, ())}
    texts = (each.value for each in ast.walk(expression) if isinstance(each, ast.Constant))
    return found | {each for each in texts if isinstance(each, str) and each in names}


def is_type_of(expression: ast.expr) -> bool:
    """Whether an expression is `type(x)` or `x.__class__`, or the name of such a type."""
    if isinstance(expression, ast.Attribute):
        if expression.attr in ("__name__", "__qualname__"):
            return is_type_of(expression.value)
        return expression.attr == "__class__"
    if not isinstance(expression, ast.Call) or len(expression.args) != 1:
        return False
    return isinstance(expression.func, ast.Name) and expression.func.id == "type"


def questions(tree: ast.Module) -> Iterator[tuple[int, ast.AST]]:
    """Lines that ask for the type of something, and the expressions with types in question."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and names_in(node.func) & {"isinstance", "issubclass"}:
            yield from ((node.lineno, types) for types in node.args[1:])
        elif isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            if any(is_type_of(side) for side in sides):
                yield from ((node.lineno, side) for side in sides if not is_type_of(side))
        elif isinstance(node, ast.MatchClass):
            yield node.lineno, node.cls


def searches(trees: Mapping[str, ast.Module]) -> list[str]:
    """Places that ask, outside the room of a type of terms, whether something is of this type."""
    types, found = types_of_terms(trees), []
    for path, tree in trees.items():
        asked = list(questions(tree))
        names = meanings(tree, types) if asked else {}
        found += [
            f"{path}:{line} asks for {name}"
            for line, expression in asked
            for name in sorted(meant_by(expression, names))
            if types[name] != room_of(path)
        ]
    return found


def test_the_types_of_terms_are_found() -> None:
    types = types_of_terms(sources())
    assert {name: types.get(name) for name in KNOWN} == KNOWN
    assert types.keys() >= set(PROTOCOL)


def test_nobody_searches_for_terms_by_their_type() -> None:
    assert searches(sources()) == []


def only(path: str, text: str) -> dict[str, ast.Module]:
    """Syntax trees of one more module and of those that it needs: protocol and inertia."""
    needed = ("terms/protocol.py", "terms/inertia.py")
    return {path: ast.parse(text), **{name: sources()[name] for name in needed}}


IMPORT = "from tilth.terms.inertia import AssembledInertia"


@pytest.mark.parametrize(
    "text",
    [
        f"{IMPORT}\nfound = [t for t in terms if isinstance(t, AssembledInertia)]",
        f"{IMPORT}\nfound = [t for t in terms if isinstance(t, (int, AssembledInertia))]",
        f"{IMPORT}\nfound = [t for t in terms if isinstance(t, int | AssembledInertia)]",
        f"{IMPORT}\ntypes = (int, AssembledInertia)\nother = types\nisinstance(t, other)",
        f"{IMPORT} as Mass\nisinstance(t, Mass)",
        f"{IMPORT}\nissubclass(type(t), AssembledInertia)",
        f"{IMPORT}\ntype(t) is AssembledInertia",
        f"{IMPORT}\nt.__class__ in (AssembledInertia, int)",
        f"{IMPORT}\nmatch t:\n    case AssembledInertia():\n        pass",
        "from tilth.terms import inertia\nisinstance(t, inertia.AssembledInertia)",
        "type(t).__name__ == 'AssembledInertia'",
    ],
)
def test_every_way_to_ask_is_noticed(text: str) -> None:
    """In another room, and not in the term's own."""
    (found,) = searches(only("analysis/other.py", text))
    assert found.startswith("analysis/other.py:")
    assert found.endswith("asks for AssembledInertia")
    assert searches(only("terms/other.py", text)) == []


@pytest.mark.parametrize(
    "text",
    [
        f"{IMPORT}\nfound = AssembledInertia(soil)",
        f"{IMPORT}\nterm: AssembledInertia = make()",
        f"{IMPORT}\nlength = term.role is Role.INERTIA",
    ],
)
def test_whoever_makes_a_term_may_name_its_type(text: str) -> None:
    assert searches(only("analysis/other.py", text)) == []
