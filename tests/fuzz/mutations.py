# SPDX-License-Identifier: BSD-3-Clause
"""Seeded changes of a case file: of its tree of entries, and of its bytes."""

from __future__ import annotations

import copy
import datetime
from collections.abc import Callable, Iterator
from contextlib import suppress
from random import Random
from typing import Any

from fuzz.toml_text import Literal, toml_text

Tree = dict[str, Any]
Place = tuple[Any, Any]
"""A table or list, and the key or index in it."""

NUMBERS: tuple[Any, ...] = (
    0, -1, 1, 2, 0.0, -0.0, 1e-300, 5e-324, 1e300, 1e308, -1e308, float("inf"), float("nan"),
    2**31, 2**63, 2**64, -(2**63), 10**400, 0.1 + 1e-16, 0.5, 1.0 - 1e-16, 10**9,
)  # fmt: skip
FACTORS = (-1.0, 1e30, 1e-30, 1e-3, 1e3, 0.5, 2.0, 1.0 + 1e-9, 1.01, 0.9)
OTHERS: tuple[Any, ...] = (
    "1", "", True, False, [], {}, [[]], [1.0], [[0.0, 0.0], [1.0, 1.0]], {"x": 1.0},
    {"type": "plane"}, datetime.date(2024, 2, 29), datetime.time(12, 30),
    datetime.datetime(2024, 2, 29, 12, 30), ["x", 1], [0.0, 0.0, 0.0, 0.0],
)  # fmt: skip
TEXTS = (
    "$x_1$", "$\\frac{1}{$", "\u202etxet\u202c", "a\u0000b", "line\nline", "\x1b[31mred", "\r",
    "=cmd|' /C calc'!A0", "@SUM(1)", "-1+1", "[red]x[/]", "[/]", "<script>alert(1)</script>", "\t",
    "../../outside", "/dev/null", "a/b", "_hidden", "\U0001f600", "\u0301" * 50, "x" * 10_000,
    "nan", "\u200b", "{0}", "%s", "\ufffe", "step 1", "finished: x", ",", '"',
)  # fmt: skip
CHOICES = (
    "plane_strain", "axisymmetric", "3d", "linear", "gimp", "cpdi1", "cpdi2", "none", "f_bar",
    "superlu", "banded", "multigrid", "roller", "fixed", "prescribed", "tangential", "direction",
    "surface", "band", "inside", "outside", "left", "right", "extra", "outer_layer", "x", "y", "z",
)  # fmt: skip


def places(tree: Any) -> Iterator[Place]:
    """Yields every place of a tree, from the top down."""
    keys = tree.keys() if isinstance(tree, dict) else range(len(tree))
    for key in keys:
        yield tree, key
        if isinstance(tree[key], dict | list):
            yield from places(tree[key])


def _numbers(tree: Tree) -> list[Place]:
    kinds = (int, float)
    return [(t, k) for t, k in places(tree) if isinstance(t[k], kinds) and type(t[k]) is not bool]


def _tables(tree: Tree) -> list[Tree]:
    return [tree, *(t[k] for t, k in places(tree) if isinstance(t[k], dict))]


def _lists(tree: Tree) -> list[list[Any]]:
    return [t[k] for t, k in places(tree) if isinstance(t[k], list) and t[k]]


def _delete(tree: Tree, others: list[Tree], random: Random) -> None:
    table, key = random.choice(list(places(tree)))
    del table[key]


def _rename(tree: Tree, others: list[Tree], random: Random) -> None:
    table = random.choice([table for table in _tables(tree) if table])
    key = random.choice(list(table))
    new = random.choice([key[:-1], f"{key}s", key.upper(), f"{key}.x", "", random.choice(TEXTS)])
    table[new] = table.pop(key)


def _swap(tree: Tree, others: list[Tree], random: Random) -> None:
    (one, first), (other, second) = random.sample(list(places(tree)), 2)
    # copies, so that no table comes to lie inside itself
    one[first], other[second] = copy.deepcopy(other[second]), copy.deepcopy(one[first])


def _retype(tree: Tree, others: list[Tree], random: Random) -> None:
    table, key = random.choice(list(places(tree)))
    value = table[key]
    wrapped = ([value], {"value": value}, str(value), [value, value])
    table[key] = copy.deepcopy(random.choice([*OTHERS, *wrapped]))


def _number(tree: Tree, others: list[Tree], random: Random) -> None:
    if found := _numbers(tree):
        table, key = random.choice(found)
        table[key] = random.choice(NUMBERS)


def _scale(tree: Tree, others: list[Tree], random: Random) -> None:
    if found := _numbers(tree):
        table, key = random.choice(found)
        table[key] = float(table[key]) * random.choice(FACTORS)


def _gentle(tree: Tree, others: list[Tree], random: Random) -> None:
    """Another number where most numbers make sense: no coordinate of a body or a boundary."""
    parts = [tree[key] for key in ("materials", "loads", "schedule", "analysis") if key in tree]
    boundaries = tree.get("boundaries", [])
    motions = [b.get("displacement", {}) for b in boundaries if isinstance(b, dict)]
    if found := [place for part in [*parts, *motions] for place in _numbers(part)]:
        table, key = random.choice(found)
        whole = isinstance(table[key], int)
        table[key] = 1 + table[key] // 2 if whole else table[key] * random.choice(FACTORS)


def _units(tree: Tree, others: list[Tree], random: Random) -> None:
    """All moduli and stresses, or all lengths and numbers, in another unit."""
    factor = random.choice((1e30, 1e-30, 1e100, 1e-100, 1e6))
    part = random.choice((tree, tree.get("materials", tree), tree.get("bodies", tree)))
    for table, key in _numbers(part):
        if isinstance(table[key], float):
            table[key] *= factor


def _text(tree: Tree, others: list[Tree], random: Random) -> None:
    found = [(t, k) for t, k in places(tree) if isinstance(t[k], str)]
    table, key = random.choice(found) if found else (tree, "title")
    table[key] = random.choice(TEXTS)


def _choice(tree: Tree, others: list[Tree], random: Random) -> None:
    found = [(t, k) for t, k in places(tree) if isinstance(t[k], str) and t[k] in CHOICES]
    if found:
        table, key = random.choice(found)
        table[key] = random.choice(CHOICES)


def _renamed_all(tree: Tree, others: list[Tree], random: Random) -> None:
    """A hostile name, the same wherever it is referred to, so that the model stays valid."""
    named = [entry for table in _tables(tree) if isinstance(entry := table.get("name"), str)]
    old, new = random.choice([*named, "title"]), random.choice(TEXTS)
    tree.setdefault("title", new)
    for table, key in list(places(tree)):
        if table[key] == old:
            table[key] = new


def _nest(tree: Tree, others: list[Tree], random: Random) -> None:
    depth = random.choice((50, 500, 5000, 100_000))
    table, key = random.choice([(t, k) for t, k in places(tree) if isinstance(t, dict)])
    kind = random.randrange(3)
    if kind == 0:
        table[key] = Literal("[" * depth + "]" * depth)
    elif kind == 1:
        table[key] = Literal("{a=" * depth + "1" + "}" * depth)
    else:
        tree[Literal(".".join(["a"] * depth))] = 1


def _splice(tree: Tree, others: list[Tree], random: Random) -> None:
    """A whole section from another case file, in place of or beside the own one."""
    other = copy.deepcopy(random.choice(others))
    key = random.choice(list(other))
    both = isinstance(other[key], list) and isinstance(tree.get(key), list)
    tree[key] = tree[key] + other[key] if both and random.random() < 0.5 else other[key]


def _graft(tree: Tree, others: list[Tree], random: Random) -> None:
    """The value that another case file gives to the same key."""
    donor = [(t[k], k) for t, k in places(random.choice(others)) if isinstance(t, dict)]
    keys = {k for t, k in places(tree) if isinstance(t, dict)}
    if fitting := [(value, key) for value, key in donor if key in keys]:
        value, key = random.choice(fitting)
        own = [t for t in _tables(tree) if key in t]
        random.choice(own)[key] = copy.deepcopy(value)


def _add(tree: Tree, others: list[Tree], random: Random) -> None:
    """A key of another case file's table, in a table of the same name."""
    donor = random.choice(others)
    section = random.choice([key for key in donor if isinstance(donor[key], dict | list)])
    given = donor[section] if isinstance(donor[section], list) else [donor[section]]
    own = tree.get(section, {})
    own = own if isinstance(own, list) else [own]
    tables = [table for table in given if isinstance(table, dict) and table]
    targets = [table for table in own if isinstance(table, dict)]
    if tables and targets:
        key, value = random.choice(list(random.choice(tables).items()))
        random.choice(targets)[key] = copy.deepcopy(value)


def _repeat(tree: Tree, others: list[Tree], random: Random) -> None:
    if lists := _lists(tree):
        entries = random.choice(lists)
        entry = random.choice(entries)
        count = random.choice((1, 1, 1000))
        for number in range(count):
            new = copy.deepcopy(entry)
            if isinstance(new, dict) and "name" in new and random.random() < 0.9:
                new["name"] = f"{new['name']} {number}"
            entries.append(new)


def _contradict(tree: Tree, others: list[Tree], random: Random) -> None:
    """Entries that are right by themselves and contradict each other."""
    kind = random.randrange(4)
    schedule, boundaries = tree.get("schedule"), tree.get("boundaries")
    if kind == 0 and isinstance(schedule, dict):
        new = {"outputs": 3, "output_times": [0.5], "output_every": 2, "step_size": 0.1, "steps": 3}
        schedule.update(random.sample(list(new.items()), 2))
    elif isinstance(boundaries, list) and boundaries and isinstance(boundaries[0], dict):
        new = copy.deepcopy(random.choice(boundaries))
        new["name"] = f"{new.get('name')} again"
        new["condition"] = random.choice(("roller", "fixed", "prescribed", "tangential"))
        if random.random() < 0.5:
            new["displacement"] = {random.choice("xyz"): random.choice((0.0, 0.001, -0.1))}
        boundaries.append(new)


TREE_CHANGES: tuple[Callable[[Tree, list[Tree], Random], None], ...] = (
    _delete, _rename, _swap, _retype, _number, _number, _number, _scale, _scale, _units, _text,
    _choice, _choice, _renamed_all, _nest, _splice, _splice, _graft, _graft, _add, _add, _repeat,
    _contradict,
)  # fmt: skip
MILD = (
    _gentle, _gentle, _gentle, _gentle, _scale, _number, _choice, _choice, _graft, _graft, _add,
    _contradict, _repeat,
)  # fmt: skip
"""Changes that often leave a model that can be computed."""
MISFITS = (AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError)
"""What a change raises where earlier ones left no place for it; it is left out then."""


def changed_tree(tree: Tree, others: list[Tree], random: Random, mild: bool) -> str:
    """Returns the text of a case file with one to three changes of its entries.

    others: trees of all case files. mild: whether most changes should leave a valid model.
    """
    tree = copy.deepcopy(tree)
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        changes = MILD if mild and random.random() < 0.8 else TREE_CHANGES
        with suppress(*MISFITS):
            random.choice(changes)(tree, others, random)
    return toml_text(tree)


def changed_bytes(content: bytes, random: Random) -> bytes:
    """Returns the content of a file with one to four changes of its bytes."""
    data = bytearray(content)
    for _ in range(random.choice((1, 1, 2, 4))):
        if not data:
            break
        at = random.randrange(len(data))
        kind = random.randrange(7)
        if kind == 0:
            data[at] ^= 1 << random.randrange(8)
        elif kind == 1:
            del data[at:]
        elif kind == 2:
            del data[at : at + random.choice((1, 2, 8, 64))]
        elif kind == 3:
            data[at:at] = random.choice((b"\0", b"\xff", b"\xef\xbb\xbf", b"\r", b"[", b'"', b"\n"))
        elif kind == 4:
            data[at] = random.randrange(256)
        elif kind == 5:
            data[at:at] = data[at : at + random.choice((8, 64, 512))]
        else:
            data[at : at + 4] = bytes(4)
    return bytes(data)
