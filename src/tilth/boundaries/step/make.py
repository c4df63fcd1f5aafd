# SPDX-License-Identifier: BSD-3-Clause
"""Construction of implicit boundaries from their declarations."""

from __future__ import annotations

import numpy as np

from tilth.boundaries.contact.make import make_contact
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.boundaries.surfaces.grid_properties import grid_properties
from tilth.boundaries.surfaces.motion import make_motion
from tilth.geometry.make import make_geometry, make_shape
from tilth.model import ImplicitBoundary, Model
from tilth.model.geometry import DeclaredGeometry
from tilth.model.load_curve import LoadCurve


def make(declared: ImplicitBoundary, model: Model, kind: type[Implicit] = Implicit) -> Implicit:
    """Returns a declared implicit boundary of a model; kind: its class, without contact.

    Raises:
        BadInput: a file or function of the boundary cannot be used.
    """
    if declared.contact is not None:
        return make_contact(declared, model)
    key = model.boundary_keys()[declared.name]
    geometry = make_geometry(declared, model)
    return kind(
        declared,
        key,
        model.load_curve(declared),
        geometry,
        make_motion(declared, geometry, f"{key}.motion", np.array(model.cell_size)),
        model.delta(declared),
        grid_properties(model),
    )


def make_still(name: str, geometry: DeclaredGeometry, model: Model, key: str) -> Implicit:
    """Returns a surface in the grid that does not move and holds nothing.

    key: of its declaration in the case file.

    Raises:
        BadInput: a file or function of its geometry cannot be used.
    """
    declared = ImplicitBoundary(name=name, geometry=geometry, condition="fixed")
    made = make_shape(geometry, model, f"{key}.geometry")
    size = np.array(model.cell_size)
    return Implicit(
        declared, key, LoadCurve(((0.0, 0.0),)), made, make_motion(declared, made, key, size),
        model.delta(declared), grid_properties(model),
    )  # fmt: skip
