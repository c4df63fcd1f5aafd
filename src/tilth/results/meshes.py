# SPDX-License-Identifier: BSD-3-Clause
"""One output of a run as meshes of PyVista."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats
from tilth.output.snapshot import Snapshot, SurfaceShape
from tilth.plot.extras import require_extra


def blocks_of(snapshot: Snapshot) -> Any:
    """Returns a ``pyvista.MultiBlock``: ``points``, ``grid``, ``surfaces`` and ``rigid_bodies``.

    The last two have a block for each surface or body, by name. In 2D z is 0, also of vectors.
    Tensors have 6 components xx yy zz xy yz xz, or 9 row by row. Raises ``BadInput`` if PyVista is
    not installed.
    """
    pyvista = require_extra("pyvista")
    points = pyvista.PolyData(_in_space(snapshot.position))
    own = {"point_id": snapshot.point_id, "body_id": snapshot.body_id}
    _put(points, {**own, **snapshot.point_fields}, snapshot.dim)
    shape = pyvista.CellType.QUAD if snapshot.dim == 2 else pyvista.CellType.HEXAHEDRON
    cells = {shape: snapshot.cells}
    grid = pyvista.UnstructuredGrid(cells, _in_space(snapshot.node_position))
    _put(grid, snapshot.node_fields, snapshot.dim)
    blocks = pyvista.MultiBlock({"points": points, "grid": grid})
    for name, shapes in (("surfaces", snapshot.surfaces), ("rigid_bodies", snapshot.rigid_bodies)):
        blocks[name] = pyvista.MultiBlock({each.name: _surface(pyvista, each) for each in shapes})
    return blocks


def _surface(pyvista: Any, shape: SurfaceShape) -> Any:
    """Returns the segments or triangles of a surface as ``pyvista.PolyData``."""
    corners = shape.position.shape[1]
    rows = np.insert(shape.cells, 0, corners, axis=1).ravel()
    kind = "lines" if corners == 2 else "faces"
    mesh = pyvista.PolyData(_in_space(shape.position), **({kind: rows} if len(rows) else {}))
    _put(mesh, shape.fields, corners)
    return mesh


def _in_space(vectors: NDArray[Any]) -> Floats:
    """Returns vectors of shape (n, 2) or (n, 3) with three components, shape (n, 3)."""
    return np.pad(np.asarray(vectors, dtype=np.float64), ((0, 0), (0, 3 - vectors.shape[1])))


def _put(mesh: Any, fields: Mapping[str, NDArray[Any]], dim: int) -> None:
    """Adds fields of its points to a mesh."""
    for name, values in fields.items():
        if len(values) == 0:  # PyVista refuses arrays of no points
            continue
        if values.ndim == 2 and values.shape[1] == dim:
            values = _in_space(values)
        mesh.point_data[name] = values.reshape(len(values), -1) if values.ndim > 2 else values
