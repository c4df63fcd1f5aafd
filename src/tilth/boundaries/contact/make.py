# SPDX-License-Identifier: BSD-3-Clause
"""Construction of rigid bodies and of surfaces in contact from their declarations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.contact.body_surface import BodyContactSurface
from tilth.boundaries.contact.rigid_body import RigidBody
from tilth.boundaries.contact.surface import ContactSurface
from tilth.boundaries.implicit.boundary import GridProperties
from tilth.boundaries.implicit.motion import make_motion
from tilth.geometry.make import make_shape, make_shapes
from tilth.geometry.protocol import Geometry
from tilth.model import ContactPair, ImplicitBoundary, Model
from tilth.model.load_curve import LoadCurve
from tilth.model.model import BAND
from tilth.surface.protocol import BodySurface


def make_rigid_bodies(
    model: Model, acceleration: Callable[[float], Floats]
) -> tuple[list[RigidBody], list[ContactSurface]]:
    """Returns the rigid bodies of a model and all their surfaces.

    acceleration: of all body forces at a time, shape (dim,).

    Raises:
        BadInput: a file of a shape cannot be used.
    """
    bodies, surfaces = [], []
    for number, declared in enumerate(model.rigid_bodies):
        key = f"rigid_bodies[{number}]"
        body = RigidBody(
            declared, model.dimension, model.analysis.kind, model.schedule.end, acceleration,
            dynamic=model.analysis.inertia is not None,
        )  # fmt: skip
        shapes = make_shapes(declared, model)
        for i, shape in enumerate(shapes):
            stand_in = ImplicitBoundary(
                name=declared.name if i == 0 else f"{declared.name} ({i + 1})",
                geometry=declared.shapes[i],
                contact=declared.contact,
                contact_with=declared.contact_with,
                displacement={"x": 0.0},
            )
            surfaces.append(
                ContactSurface(
                    stand_in, key, LoadCurve(((0.0, 0.0), (1.0, 1.0))), shape, body,
                    model.delta(stand_in), grid_properties(model),
                    contact=declared.contact, contact_with=declared.contact_with or {},
                    body=body, shapes=shapes,
                    full=declared.wished_in_place,
                )
            )  # fmt: skip
        body.size = _size(shapes, np.array(declared.centre), model.cell_size)
        bodies.append(body)
    return bodies, surfaces


def make_contact(declared: ImplicitBoundary, model: Model) -> ContactSurface:
    """Returns a declared boundary with contact of a model.

    Raises:
        BadInput: a file or function of the boundary cannot be used.
    """
    key = model.boundary_keys()[declared.name]
    geometry = make_shape(declared.geometry, model, f"{key}.geometry")
    assert declared.contact is not None
    return ContactSurface(
        declared,
        key,
        model.load_curve(declared),
        geometry,
        make_motion(declared, geometry, f"{key}.motion", np.array(model.cell_size)),
        model.delta(declared),
        grid_properties(model),
        contact=declared.contact,
        contact_with=declared.contact_with or {},
        full=declared.wished_in_place,
    )


def make_body_contact(
    declared: ContactPair, model: Model, tracked: BodySurface
) -> BodyContactSurface:
    """Returns the surface of the first body of a pair; tracked: that surface."""
    cell_size = np.array(model.cell_size)
    return BodyContactSurface(declared, tracked, BAND * float(cell_size.min()), cell_size)


def grid_properties(model: Model) -> GridProperties:
    """Returns the grid on which the surfaces of a model act."""
    return GridProperties(
        origin=np.array(model.origin),
        cell_size=np.array(model.cell_size),
        axisymmetric=model.analysis.kind == "axisymmetric",
        grid_moves=model.grid.follow is not None,
    )


def _size(shapes: list[Geometry], centre: Floats, cell_size: tuple[float, ...]) -> float:
    """Returns the greatest distance of a body's surface from its centre [length]."""
    cell = min(cell_size)
    farthest = 0.0
    for shape in shapes:
        corner = shape.facets(centre - cell, centre + cell, cell).corner
        farthest = max(farthest, float(np.linalg.norm(corner - centre, axis=2).max(initial=0.0)))
    return max(farthest, cell)
