# SPDX-License-Identifier: BSD-3-Clause
"""Which boundaries, rigid bodies and contact pairs a tracked quantity can be of."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from tilth.errors import Problem
from tilth.model.implicit import ImplicitBoundary
from tilth.model.track import OF_RELAXATION, Track

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration

_OF_BODIES = ("rigid_displacement", "rigid_rotation")
_OF_IMPLICIT = ("penetration",)
_OF_BOTH = ("contact_area", "embedment")
_OF_PAIRS = ("reaction", "moment", "contact_area")
_MOTIONS = ("velocity", "acceleration")
_OF_INERTIA = (
    "kinetic",
    "damping_dissipation",
    "radiation",
    "numerical_dissipation",
    "time_integration",
)
WITHOUT_END = ("plane", "cylinder", "function")
"""Geometries without a lowest point."""


def track_problems(model: Declaration) -> Iterator[Problem]:
    """Yields tracked quantities of boundaries or bodies that do not have them."""
    bodies = {body.name: body for body in model.rigid_bodies}
    boundaries = {boundary.name: boundary for boundary in model.boundaries}
    implicit = [name for name, each in boundaries.items() if isinstance(each, ImplicitBoundary)]
    pairs = [pair.name for pair in model.contact_pairs]
    own = OF_RELAXATION if model.analysis.beyond_limit == "relax" else ()
    for i, track in enumerate(model.track):
        if track.name in own:
            what = 'is the name of a column that history.csv has with beyond_limit = "relax"'
            yield Problem(f"track[{i}].name", what, "choose another name", track.name)
        if track.kind in _OF_INERTIA and not model.analysis.has_mass:
            remedy = 'add `inertia` or beyond_limit = "relax" to [analysis], or leave it out'
            yield Problem(f"track[{i}].kind", "has no meaning without inertia", remedy, track.kind)
        if track.kind == "seepage" and model.flow is None:
            remedy = "add a section [flow], or leave it out"
            yield Problem(f"track[{i}].kind", "no water flows", remedy, track.kind)
        name, quantity = track.boundary or "", track.quantity
        if quantity in _MOTIONS and model.analysis.inertia is None:
            remedy = "add `inertia` to [analysis], or leave it out"
            yield Problem(
                f"track[{i}].quantity", "has no meaning without inertia", remedy, quantity
            )
        if name in pairs and name not in bodies and name not in boundaries:
            yield from _problems_of_pair(i, track)
            continue
        if name not in bodies and name not in boundaries:
            continue
        kind = "rigid body" if name in bodies else boundaries[name].type
        if quantity in _OF_BODIES and name not in bodies:
            yield _wrong(i, quantity, "rigid bodies", kind, list(bodies), name)
        elif quantity in _OF_IMPLICIT and name not in implicit:
            yield _wrong(i, quantity, "implicit boundaries", kind, implicit, name)
        elif quantity in _OF_BOTH and name not in (*implicit, *bodies):
            choices = [*implicit, *bodies]
            yield _wrong(i, quantity, "implicit boundaries and rigid bodies", kind, choices, name)
        elif quantity == "embedment":
            declared = boundaries.get(name)
            shapes = (
                (declared.geometry,)
                if isinstance(declared, ImplicitBoundary)
                else bodies[name].shapes
            )
            endless = [shape.type for shape in shapes if shape.type in WITHOUT_END]
            if endless:
                what = f'a geometry of type = "{endless[0]}" has no lowest point'
                remedy = 'track a "displacement" or "rigid_displacement"'
                yield Problem(f"track[{i}].boundary", what, remedy, name)
        if quantity == "moment" and track.about is None and name not in bodies:
            remedy = 'quantity = "moment" needs `boundary` and `about` and `component`'
            yield Problem(f"track[{i}].about", "missing", remedy)


def _problems_of_pair(i: int, track: Track) -> Iterator[Problem]:
    if track.quantity not in _OF_PAIRS:
        what = f'quantity = "{track.quantity}" is not for contact pairs'
        listed = ", ".join(f'"{each}"' for each in _OF_PAIRS)
        yield Problem(f"track[{i}].quantity", what, f"choose from {listed}", track.quantity)
    elif track.quantity == "moment" and track.about is None:
        remedy = 'quantity = "moment" needs `boundary` and `about` and `component`'
        yield Problem(f"track[{i}].about", "missing", remedy)


def _wrong(i: int, quantity: str, of: str, kind: str, choices: list[str], name: str) -> Problem:
    what = f'quantity = "{quantity}" is for {of}, but this one is "{kind}"'
    listed = ", ".join(f"`{choice}`" for choice in choices)
    remedy = f"choose from {listed}" if choices else f"this model has no {_SINGULAR[of]}"
    return Problem(f"track[{i}].boundary", what, remedy, name)


_SINGULAR = {
    "rigid bodies": "rigid body",
    "implicit boundaries": "implicit boundary",
    "implicit boundaries and rigid bodies": "implicit boundary and no rigid body",
}
