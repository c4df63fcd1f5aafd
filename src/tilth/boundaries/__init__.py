# SPDX-License-Identifier: BSD-3-Clause
"""Essential boundary conditions on the active grid, one module for each kind."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from tilth.arrays import Floats
from tilth.boundaries.affine import Affine
from tilth.boundaries.conditions import Conditions
from tilth.boundaries.implicit.constraints import ImplicitConstraints
from tilth.boundaries.nodal import Nodal
from tilth.boundaries.protocol import Boundary, Prescribed
from tilth.model import AffineBoundary, ImplicitBoundary, Model

if TYPE_CHECKING:
    from tilth.boundaries.contact.rigid_body import RigidBody
    from tilth.boundaries.implicit.boundary import Implicit

__all__ = [
    "Boundary",
    "Conditions",
    "ImplicitConstraints",
    "Prescribed",
    "make_bodies",
    "make_boundaries",
    "make_implicit",
]


def make_boundaries(model: Model) -> list[Boundary]:
    """Returns the boundaries that act by elimination, in the order of declaration."""
    made: list[Boundary] = []
    for declared in model.boundaries:
        if isinstance(declared, AffineBoundary):
            made.append(Affine(declared, model.load_curve(declared)))
        elif not isinstance(declared, ImplicitBoundary):
            made.append(Nodal(declared, model.dimension, model.load_curve(declared)))
    return made


def make_implicit(model: Model) -> list[Implicit]:
    """Returns the implicit boundaries of a model, in the order of declaration.

    Raises:
        BadInput: a file or function of a boundary cannot be used.
    """
    declared = [entry for entry in model.boundaries if isinstance(entry, ImplicitBoundary)]
    if not declared:
        return []
    from tilth.boundaries.implicit.make import make  # loads all geometries

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
