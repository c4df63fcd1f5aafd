# SPDX-License-Identifier: BSD-3-Clause
"""Essential boundary conditions on the active grid, one module for each kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from tilth.arrays import Floats
from tilth.boundaries.affine import Affine
from tilth.boundaries.base_motion import BaseMotion, StepOf
from tilth.boundaries.nodal import Nodal
from tilth.boundaries.protocol import Boundary, Prescribed
from tilth.boundaries.step.conditions import Conditions
from tilth.boundaries.step.constraints import ImplicitConstraints
from tilth.model import AffineBoundary, ImplicitBoundary, Model, PlaneBoundary
from tilth.variation.record import read_record

if TYPE_CHECKING:
    from tilth.boundaries.contact.body_surface import BodyContactSurface
    from tilth.boundaries.contact.rigid_body import RigidBody
    from tilth.boundaries.surfaces.boundary import Implicit
    from tilth.surface.protocol import BodySurface

__all__ = [
    "Boundary",
    "Conditions",
    "ImplicitConstraints",
    "Prescribed",
    "make_bodies",
    "make_body_contacts",
    "make_boundaries",
    "make_implicit",
]


def make_boundaries(model: Model, step_of: StepOf) -> list[Boundary]:
    """Returns the boundaries that act by elimination, in the order of declaration.

    step_of: step of the equations of motion between two times, for bases that move.

    Raises:
        BadInput: the record of a base cannot be used.
    """
    made: list[Boundary] = []
    for declared in model.boundaries:
        if isinstance(declared, AffineBoundary):
            made.append(Affine(declared, model.load_curve(declared)))
        elif isinstance(declared, PlaneBoundary) and declared.condition == "base_motion":
            assert declared.acceleration is not None
            key = f"{model.boundary_keys()[declared.name]}.acceleration"
            record = read_record(declared.acceleration, model.dimension, key)
            made.append(BaseMotion(declared, model, record, step_of))
        elif not isinstance(declared, ImplicitBoundary) and declared.condition != "absorbing":
            made.append(Nodal(declared, model.dimension, model.load_curve(declared)))
    return made


def make_implicit(model: Model) -> list[Implicit]:
    """Returns the implicit boundaries of a model, in the order of declaration.

    Raises:
        BadInput: a file or function of a boundary cannot be used.
    """
    declared = [
        entry
        for entry in model.boundaries
        if isinstance(entry, ImplicitBoundary) and entry.condition != "absorbing"
    ]
    if not declared:
        return []
    from tilth.boundaries.step.make import make  # loads all geometries

    return [make(entry, model) for entry in declared]


def make_bodies(
    model: Model, acceleration: Callable[[float], Floats]
) -> tuple[list[RigidBody], list[Implicit]]:
    """Returns the rigid bodies of a model and all their surfaces, in the order of declaration.

    acceleration: of all body forces at a time, shape (dim,).

    Raises:
        BadInput: a file of a body cannot be used.
    """
    if not model.rigid_bodies:
        return [], []
    from tilth.boundaries.contact.make import make_rigid_bodies

    bodies, surfaces = make_rigid_bodies(model, acceleration)
    return bodies, list(surfaces)


def make_body_contacts(
    model: Model, surfaces: Mapping[str, BodySurface]
) -> list[BodyContactSurface]:
    """Returns the surfaces on which bodies that are present touch each other.

    surfaces: tracked surfaces by the names of the bodies.
    """
    present = [pair for pair in model.contact_pairs if all(map(model.present, pair.bodies))]
    if not present:
        return []
    from tilth.boundaries.contact.make import make_body_contact

    return [make_body_contact(pair, model, surfaces[pair.bodies[0]]) for pair in present]
