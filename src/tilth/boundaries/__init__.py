# SPDX-License-Identifier: BSD-3-Clause
"""Essential boundary conditions on the active grid; one file a kind."""

from __future__ import annotations

from tilth.boundaries.affine import Affine
from tilth.boundaries.nodal import Nodal
from tilth.boundaries.protocol import Boundary, Prescribed
from tilth.boundaries.together import Conditions
from tilth.model import AffineBoundary, Model

__all__ = ["Boundary", "Conditions", "Prescribed", "make_boundaries"]


def make_boundaries(model: Model) -> list[Boundary]:
    """Returns the boundaries of a model, in the order in which they were declared."""
    return [
        Affine(declared, model) if isinstance(declared, AffineBoundary) else Nodal(declared, model)
        for declared in model.boundaries
    ]
