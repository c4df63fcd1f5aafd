# SPDX-License-Identifier: BSD-3-Clause
"""What a random model consists of: dimensions, their values, and which values go together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations
from random import Random

Choice = dict[str, str]
"""A value of each dimension."""
Pair = tuple[tuple[str, str], tuple[str, str]]
"""Two values of different dimensions."""

DIMENSIONS: dict[str, tuple[str, ...]] = {
    "kind": ("plane_strain", "axisymmetric", "3d"),
    "basis": ("linear", "gimp", "cpdi1", "cpdi2"),
    "anti_locking": ("none", "f_bar"),
    "law": (
        "hencky_elastic", "von_mises", "tresca", "mohr_coulomb", "drucker_prager",
        "modified_cam_clay", "undrained_mohr_coulomb", "separating_mohr_coulomb",
        "softening_mohr_coulomb", "layers", "varying",
    ),
    "base": (
        "rollers", "fixed", "implicit_roller", "implicit_fixed", "contact", "absorbing",
        "absorbing_implicit",
    ),
    "driver": (
        "none", "prescribed_plane", "footing", "rigid_prescribed", "rigid_free", "rigid_springs",
    ),
    "contact": (
        "none", "smooth", "friction", "adhesion", "rough", "bonded", "bilateral", "tensile",
    ),
    "second_body": ("none", "shared", "pair"),
    "initial": ("none", "K0", "1-sin_phi", "gravity", "table", "given"),
    "water": ("none", "level", "falling"),
    "stages": (
        "none", "loads", "boundary", "excavate", "remove", "fill", "refill", "exchange", "grid",
    ),
    "inertia": ("none", "newmark", "generalised_alpha", "damped", "pic"),
    "load": ("none", "pressure", "traction", "point_force", "line_force", "seismic"),
    "places": ("regular", "irregular"),
    "grid": ("uniform", "shifted", "graded", "follow"),
    "solver": ("auto", "superlu", "banded", "multigrid"),
    "relation": (
        "balance", "mirror", "turn", "shift", "units", "order", "resume", "threads", "rest",
        "halved", "unload", "commands",
    ),
}  # fmt: skip
"""The first value of each dimension is the plain one."""

PLAIN: Choice = {name: values[0] for name, values in DIMENSIONS.items()}

STATIC = ("none",)
MOVING = ("newmark", "generalised_alpha", "damped", "pic")

Rule = tuple[str, tuple[str, ...], str, tuple[str, ...]]
RULES: tuple[Rule, ...] = (
    ("base", ("absorbing", "absorbing_implicit"), "inertia", MOVING),
    ("law", ("modified_cam_clay",), "initial", ("K0", "1-sin_phi", "table", "given")),
    ("initial", ("1-sin_phi",), "law", (
        "mohr_coulomb", "drucker_prager", "modified_cam_clay", "undrained_mohr_coulomb",
        "separating_mohr_coulomb", "softening_mohr_coulomb",
    )),
    ("load", ("line_force",), "kind", ("3d",)),
    ("grid", ("follow",), "driver", ("footing",)),
    ("grid", ("follow",), "base", ("implicit_roller", "implicit_fixed", "contact")),
    ("driver", ("prescribed_plane",), "stages", (
        "none", "loads", "boundary", "excavate", "remove", "fill", "refill", "exchange")),
    ("stages", ("excavate",), "load", ("none", "point_force", "line_force", "seismic")),
    ("law", ("modified_cam_clay",), "stages", (
        "none", "loads", "boundary", "excavate", "remove", "grid")),
    ("contact", ("rough",), "law", (
        "von_mises", "tresca", "mohr_coulomb", "drucker_prager", "undrained_mohr_coulomb",
        "separating_mohr_coulomb", "softening_mohr_coulomb", "layers",
    )),
    ("stages", ("grid",), "grid", ("uniform", "shifted", "graded")),
)  # fmt: skip
"""What the model refuses, so that random models seldom are: a value with others of a dimension."""

VERTICAL = {
    "initial": ("K0", "1-sin_phi", "table"), "water": ("level", "falling"),
    "stages": ("fill", "refill"), "law": ("layers", "varying"),
}  # fmt: skip
"""Values by which the vertical direction has a meaning: the model cannot be laid on its side."""


def has_vertical(choice: Choice) -> bool:
    """Whether a model has a vertical direction."""
    return any(choice[name] in values for name, values in VERTICAL.items())


def says_something(choice: Choice) -> bool:
    """Whether the relation of a choice says something of its model."""
    relation, kind = choice["relation"], choice["kind"]
    if relation in ("mirror", "turn") and has_vertical(choice):
        return kind == "3d" or (kind == "plane_strain" and relation == "mirror")
    if relation == "turn":
        return kind != "axisymmetric"
    if relation == "rest":
        return choice["inertia"] == "none"
    if relation == "halved":
        jumps = choice["law"].startswith(("separating", "softening"))
        return choice["inertia"] == choice["contact"] == "none" and not jumps
    if relation == "unload":
        return (
            choice["law"] in ("hencky_elastic", "varying")
            and choice["inertia"] == choice["stages"] == choice["contact"] == "none"
            and choice["initial"] == "none"
            and choice["water"] != "falling"
        )
    return True


def touches(choice: Choice) -> bool:
    """Whether something is in contact."""
    return (
        choice["base"] == "contact"
        or choice["driver"].startswith("rigid")
        or choice["second_body"] == "pair"
    )


def settled(choice: Choice, pinned: Mapping[str, str], random: Random) -> Choice:
    """Returns a choice that obeys the rules, but for what the pinned values contradict."""
    choice = {**choice, **pinned}
    for _ in range(6):
        before = dict(choice)
        for one, values, other, allowed in RULES:
            if choice[one] in values and choice[other] not in allowed:
                if other not in pinned:
                    choice[other] = random.choice(allowed)
                elif one not in pinned:
                    choice[one] = PLAIN[one]
        if choice["contact"] == "none" and touches(choice):
            if "contact" not in pinned:
                choice["contact"] = random.choice(DIMENSIONS["contact"][1:])
            else:
                for name in ("base", "driver", "second_body"):
                    if name not in pinned:
                        choice[name] = PLAIN[name]
        if choice["contact"] != "none" and not touches(choice):
            wanted = {"driver": "rigid_prescribed", "base": "contact", "second_body": "pair"}
            free = [name for name in wanted if name not in pinned]
            if free:
                name = random.choice(free)
                choice[name] = wanted[name]
            elif "contact" not in pinned:
                choice["contact"] = "none"
        if not says_something(choice) and "relation" not in pinned:
            choice["relation"] = random.choice(("shift", "units", "order", "resume", "threads"))
        if choice == before:
            break
    return choice


def pairs_of(choice: Choice) -> Iterator[Pair]:
    """Yields the pairs of values of a choice."""
    yield from combinations(choice.items(), 2)


def all_pairs() -> Iterator[Pair]:
    """Yields every pair of values of different dimensions."""
    for one, other in combinations(DIMENSIONS, 2):
        for value in DIMENSIONS[one]:
            yield from (((one, value), (other, each)) for each in DIMENSIONS[other])


def contradicts(pair: Iterable[tuple[str, str]], rules: Iterable[Rule]) -> bool:
    """Whether a rule forbids a pair."""
    given = dict(pair)
    return any(
        given.get(one) in values and other in given and given[other] not in allowed
        for one, values, other, allowed in rules
    )
