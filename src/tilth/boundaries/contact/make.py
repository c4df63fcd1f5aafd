# SPDX-License-Identifier: BSD-3-Clause
"""Construction of rigid bodies and of surfaces in contact from their declarations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.contact.body_surface import BodyContactSurface
from tilth.boundaries.contact.rigid_body import RigidBody
from tilth.boundaries.contact.surface import ContactSurface
from tilth.boundaries.surfaces.grid_properties import grid_properties
from tilth.boundaries.surfaces.motion import make_motion
from tilth.boundaries.surfaces.patches import SLIVER
from tilth.errors import BadInput
from tilth.geometry.make import make_shape, make_shapes
from tilth.geometry.protocol import Geometry
from tilth.model import ContactPair, ImplicitBoundary, Model
from tilth.model.declaration import BAND
from tilth.model.load_curve import LoadCurve
from tilth.surface.protocol import BodySurface

DIRECTIONS = 100
"""Greatest number of directions in which the thickness of a shape is measured."""

ROUND_OFF = 1e-6
"""Length of the resultant of a shape's normals over its area that is round-off: it is closed."""


def make_rigid_bodies(
    model: Model, acceleration: Callable[[float], Floats]
) -> tuple[list[RigidBody], list[ContactSurface]]:
    """Returns the rigid bodies of a model and all their surfaces.

    acceleration: of all body forces at a time, shape (dim,).

    Raises:
        BadInput: a file of a shape cannot be used; a body is too small for contact on this grid.
    """
    bodies, surfaces = [], []
    keys = model.rigid_body_keys()
    for declared in model.rigid_bodies:
        key = keys[declared.name]
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
        _require_seen(shapes, declared.name, model, key)
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


def _size(shapes: list[Geometry], centre: Floats, cell_size: tuple[float, ...]) -> float:
    """Returns the greatest distance of a body's surface from its centre [length]."""
    cell = min(cell_size)
    farthest = 0.0
    for shape in shapes:
        corner = shape.facets(centre - cell, centre + cell, cell).corner
        farthest = max(farthest, float(np.linalg.norm(corner - centre, axis=2).max(initial=0.0)))
    return max(farthest, cell)


def _require_seen(shapes: list[Geometry], name: str, model: Model, key: str) -> None:
    """Checks that the soil can feel a body: that its sides are no slivers, see `SLIVER`."""
    cell = np.array(model.cell_size)
    area = sum(extents(shape, cell)[0] for shape in shapes)
    least = 2 * len(cell) * SLIVER * float(cell.min()) ** (len(cell) - 1)
    if area < least:
        what = "an outline" if len(cell) == 2 else "a surface"
        raise BadInput(
            f"the rigid body {name!r} has {what} of only {area:.3g}, and on cells of "
            f"{cell.min():.3g} the soil feels none below {least:.3g}",
            "enlarge the body, choose smaller cells, or apply its force to the soil as a load",
            key=key,
        )


def extents(shape: Geometry, cell_size: Floats) -> tuple[float, float]:
    """Returns the area [length^(dim - 1)] of a shape's surface and its thickness [length].

    The thickness is the least extent along the normals of its facets, which are up to a cell long.
    Both are infinite for an unbounded shape, the thickness also for one that is not closed.

    cell_size: of the grid [length], shape (dim,).
    """
    if not shape.bounded:
        return np.inf, np.inf
    dim = len(cell_size)
    facets = shape.facets(-cell_size, cell_size, float(cell_size.min()))
    edge = facets.corner[:, 1:] - facets.corner[:, :1]
    gram = np.einsum("nai,nbi->nab", edge, edge)
    area = np.sqrt(np.maximum(np.linalg.det(gram), 0.0)) / (dim - 1)
    total = float(area.sum())
    if np.linalg.norm(area @ facets.normal) > ROUND_OFF * total:
        return total, np.inf
    every = -(-len(facets.normal) // DIRECTIONS)
    along = facets.corner.reshape(-1, dim) @ facets.normal[::every].T
    return total, float((along.max(axis=0) - along.min(axis=0)).min())
