# SPDX-License-Identifier: BSD-3-Clause
"""Contact between two soil bodies, and the overlays that their bodies need for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, BeforeValidator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.contact import Contact
from tilth.model.fields import AsTuple, CellName, Entries, Name
from tilth.model.problems import reject, unknown_name

if TYPE_CHECKING:
    from tilth.model.bodies import Body
    from tilth.model.declaration import Declaration
    from tilth.model.shapes import Bounds

MOST_OVERLAYS = 7
"""Overlays in one grid, at most."""

_TWO = 'name two soil bodies, such as bodies = ["block", "ground"]'


def _list_of_names(value: Any) -> Any:
    if isinstance(value, str):
        raise reject("must be a list of two names", _TWO)
    return value


def _two(value: tuple[str, ...]) -> tuple[str, ...]:
    if len(value) != 2:
        count = (
            "no body" if not value else "one body" if len(value) == 1 else f"{len(value)} bodies"
        )
        raise reject(f"names {count}, but contact is between two", _TWO)
    if value[0] == value[1]:
        raise reject("names the same body twice", _TWO + "; a body has no contact with itself")
    return value


TwoBodies = Annotated[
    Sequence[Name], BeforeValidator(_list_of_names), Entries, AsTuple, AfterValidator(_two)
]


class ContactPair(Declared):
    """Contact between two soil bodies, which move independently of each other.

    It acts while both bodies are there. Bodies that are not in contact pairs with each other share
    the nodes of the grid where they meet, and stick together.
    """

    name: CellName
    """Name of the contact in results, unique, also among boundaries and rigid bodies."""
    bodies: TwoBodies
    """Names of the two bodies. On the tracked surface of the first, which it must have, the contact
    is integrated: choose the body with the finer or the more curved surface.
    """
    contact: Contact
    """Law of the contact. With "rough" and with `adhesion_factor` the strength is that of the
    weaker of the two bodies.
    """
    wished_in_place: bool = False
    """Whether the bodies are in contact from the start wherever they are not more than a quarter of
    a cell apart.
    """


def overlays_of_bodies(bodies: Sequence[Body], pairs: Sequence[ContactPair]) -> dict[str, int]:
    """Returns the number of the overlay of each body, by name.

    In the order of the case file each body has the smallest number that differs from those of the
    bodies with which it is paired.
    """
    overlays: dict[str, int] = {}
    for body in bodies:
        partners = {n for pair in pairs if body.name in pair.bodies for n in pair.bodies}
        taken = {overlays[name] for name in partners & overlays.keys()}
        overlays[body.name] = min(set(range(len(taken) + 1)) - taken)
    return overlays


def contact_pair_problems(model: Declaration) -> Iterator[Problem]:
    """Yields what is wrong with the contact pairs of a model, but not with their laws."""
    bodies = {body.name: body for body in model.bodies}
    first_with: dict[frozenset[str], int] = {}
    for i, pair in enumerate(model.contact_pairs):
        key = f"contact_pairs[{i}].bodies"
        unknown = [name for name in pair.bodies if name not in bodies]
        for name in unknown:
            yield Problem(key, *unknown_name("body", name, bodies), name)
        if unknown:
            continue
        first = first_with.setdefault(frozenset(pair.bodies), i)
        if first != i:
            what = f"are already the two bodies of contact_pairs[{first}]"
            yield Problem(key, what, "declare their contact once", pair.bodies)
        yield from _surface_problems(model, key, bodies[pair.bodies[0]])


def _surface_problems(model: Declaration, key: str, body: Body) -> Iterator[Problem]:
    where = f"bodies[{[each.name for each in model.bodies].index(body.name)}]"
    if body.surface is None:
        what = f"the first body, {body.name!r}, has no tracked surface, on which contact acts"
        remedy = f"add `surface = {{}}` to {where}, or name the other body first if it has one"
        yield Problem(key, what, remedy, body.name)
    elif body.surface.points == "outer_layer":
        what = (
            f"the surface of the first body, {body.name!r}, is one through its outer material "
            "points, half their spacing inside"
        )
        remedy = f'give `points = "extra"` in {where}.surface, or name the other body first'
        yield Problem(key, what, remedy, body.name)


def overlay_problems(model: Declaration) -> Iterator[Problem]:
    """Yields too many overlays."""
    overlays = model.overlays()
    if max(overlays.values()) >= MOST_OVERLAYS:
        most = max(overlays, key=overlays.__getitem__)
        what = (
            f"{most!r} and the bodies paired with it need {max(overlays.values()) + 1} "
            f"overlays, and there can be {MOST_OVERLAYS}"
        )
        yield Problem("contact_pairs", what, "declare fewer pairs between the same bodies")


def unpaired_bodies(model: Declaration) -> Iterator[tuple[str, str]]:
    """Yields names of bodies of different overlays that have no contact pair but may meet.

    They are there at the same time, and bounding boxes, where they are known, are near.
    """
    overlays = model.overlays()
    paired = {frozenset(pair.bodies) for pair in model.contact_pairs}
    bounds = {body.name: body.shape.bounds() for body in model.bodies}
    for i, body in enumerate(model.bodies):
        for other in model.bodies[:i]:
            names = other.name, body.name
            if overlays[body.name] == overlays[other.name] or frozenset(names) in paired:
                continue
            if _together(model, *names) and _near(model, bounds[body.name], bounds[other.name]):
                yield names


def _together(model: Declaration, *names: str) -> bool:
    """Whether bodies are there at the same time in any stage."""
    absences = model.of_stages[0].stage.absences or (frozenset(),)
    return any(not each.intersection(names) for each in absences)


def _near(model: Declaration, one: Bounds | None, other: Bounds | None) -> bool:
    """Whether two bounding boxes come nearer than a cell, or one of them is not known (a mesh)."""
    if one is None or other is None:
        return True
    axes = [model.grid_axis(k) for k in range(model.dimension)]
    return all(
        one[0][k] < other[1][k] + axis.size_at(other[1][k])
        and other[0][k] < one[1][k] + axis.size_at(one[1][k])
        for k, axis in enumerate(axes)
    )
