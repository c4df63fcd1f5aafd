# SPDX-License-Identifier: BSD-3-Clause
"""Essential boundary conditions on the active grid; one file a kind."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tilth.boundaries.affine import Affine
from tilth.boundaries.implicit.constraints import ImplicitConstraints
from tilth.boundaries.nodal import Nodal
from tilth.boundaries.protocol import Boundary, Prescribed
from tilth.boundaries.together import Conditions
from tilth.model import AffineBoundary, ImplicitBoundary, Model

if TYPE_CHECKING:
    from tilth.boundaries.implicit.boundary import Implicit

__all__ = [
    "Boundary",
    "Conditions",
    "ImplicitConstraints",
    "Prescribed",
    "make_boundaries",
    "make_implicit",
]


def make_boundaries(model: Model) -> list[Boundary]:
    """Returns the boundaries that act by elimination, in the order in which they were declared."""
    return [
        Affine(declared, model) if isinstance(declared, AffineBoundary) else Nodal(declared, model)
        for declared in model.boundaries
        if not isinstance(declared, ImplicitBoundary)
    ]


def make_implicit(model: Model) -> list[Implicit]:
    """Returns the implicit boundaries of a model, in the order in which they were declared.

    Raises:
        BadInput: a file or function that a boundary names cannot be used.
    """
    declared = [entry for entry in model.boundaries if isinstance(entry, ImplicitBoundary)]
    if not declared:
        return []
    from tilth.boundaries.implicit.boundary import (
        Implicit,  # and all geometries: only where there are some
    )

    return [Implicit(entry, model) for entry in declared]
