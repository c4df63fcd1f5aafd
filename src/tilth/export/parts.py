# SPDX-License-Identifier: BSD-3-Clause
"""The meshes of one output: each body's points or domains, surfaces, contacts, rigid bodies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats, Integers
from tilth.export.source import Source
from tilth.output.snapshot import ContactShape, Snapshot, SurfaceShape
from tilth.plot.extras import require_extra
from tilth.report.domains import corners_of

Show = Literal["domains", "points"]

_ROUND = {2: [0, 1, 3, 2], 3: [0, 1, 3, 2, 4, 5, 7, 6]}
"""Corners, x fastest, in the order of VTK's quadrilateral and hexahedron."""


@dataclass(frozen=True, eq=False)
class Part:
    """A mesh of ``n`` vertices and ``c`` cells of one type."""

    name: str
    """Name of the body or surface."""
    family: str
    """How the names of its files begin: "", "surface_", "contact_" or "rigid_"."""
    vertices: Floats
    """Positions [length], shape (n, 3); z is 0 in 2D."""
    kind: str
    """Type of the cells in meshio's words: vertex, line, triangle, quad or hexahedron."""
    cells: Integers
    """Vertices of each cell, shape (c, k)."""
    vertex_fields: Mapping[str, NDArray[Any]]
    cell_fields: Mapping[str, NDArray[Any]]

    def emptied(self) -> Part:
        """Returns the part without vertices and cells."""
        return replace(
            self,
            vertices=self.vertices[:0].copy(),
            cells=self.cells[:0].copy(),
            vertex_fields={name: each[:0].copy() for name, each in self.vertex_fields.items()},
            cell_fields={name: each[:0].copy() for name, each in self.cell_fields.items()},
        )


def parts_of(source: Source, snapshot: Snapshot, show: Show) -> Iterator[Part]:
    """Yields the bodies that have points, and all surfaces, contact surfaces and rigid bodies.

    The fields of domains are those of their cells, and have ``position``, that of the points; all
    other fields are those of vertices. Vectors have three components, tensors (3, 3) nine, row by
    row.
    """
    fields = {"point_id": snapshot.point_id, "body_id": snapshot.body_id}
    fields |= source.values(snapshot)
    corners = corners_of(snapshot) if show == "domains" else None
    for body in np.unique(snapshot.body_id):
        of_body = snapshot.body_id == body
        own = {name: in_space(values[of_body]) for name, values in fields.items()}
        place, name = snapshot.position[of_body], source.body_name(int(body))
        yield _body(name, place, None if corners is None else corners[of_body], own)
    for surface in snapshot.surfaces:
        yield _surface(surface, "surface_")
    for contact in snapshot.contacts:
        yield _surface(contact, "contact_")
    for rigid in snapshot.rigid_bodies:
        yield _surface(rigid, "rigid_")


def in_space(values: NDArray[Any]) -> NDArray[Any]:
    """Returns plane vectors, shape (n, 2), with a third component 0, and matrices as rows."""
    if values.ndim == 2 and values.shape[1] == 2:
        return np.pad(values, ((0, 0), (0, 1)))
    return (
        values.reshape(len(values), int(np.prod(values.shape[1:]))) if values.ndim > 2 else values
    )


def _body(
    name: str, position: Floats, corners: Floats | None, fields: Mapping[str, NDArray[Any]]
) -> Part:
    """Returns the domains of a body, or its points if their domains are not known."""
    place = in_space(position)
    if corners is None or not np.isfinite(corners).all():
        each = np.arange(len(place))[:, None]
        return Part(name, "", place, "vertex", each, fields, {})
    dim = position.shape[1]
    vertices = (position[:, None] + corners[:, _ROUND[dim]]).reshape(-1, dim)
    cells = np.arange(len(vertices)).reshape(-1, 2**dim)
    kind = "quad" if dim == 2 else "hexahedron"
    return Part(name, "", in_space(vertices), kind, cells, {}, {"position": place, **fields})


def _surface(shape: SurfaceShape | ContactShape, family: str) -> Part:
    kind = {1: "vertex", 2: "line", 3: "triangle"}[shape.cells.shape[1]]
    fields = {name: in_space(values) for name, values in shape.fields.items()}
    return Part(shape.name, family, in_space(shape.position), kind, shape.cells, fields, {})


def meshio() -> Any:
    """Returns the package meshio; raises ``BadInput`` if it cannot be imported."""
    return require_extra("meshio", "mesh")
