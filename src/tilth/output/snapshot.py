# SPDX-License-Identifier: BSD-3-Clause
"""One output of an analysis: material points, grid and surfaces at one moment."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats, Integers


@dataclass(frozen=True)
class FieldsOnDemand(Mapping[str, NDArray[Any]]):
    """Fields by name, each computed at every access: all at once need much memory."""

    make: Mapping[str, Callable[[], NDArray[Any]]]

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.make[name]()

    def __iter__(self) -> Iterator[str]:
        return iter(self.make)

    def __len__(self) -> int:
        return len(self.make)


@dataclass(frozen=True, eq=False)
class SurfaceShape:
    """A tracked surface at one output: ``n`` vertices, ``m`` cells, ``dim`` is 2 or 3.

    The arrays must not be changed after the shape is created.
    """

    name: str
    position: Floats
    """Position of the vertices [length], shape (n, dim)."""
    cells: Integers
    """Rows of ``position``: in 2D the segments of polylines, shape (m, 2), in order along the curve
    with the soil on their left; in 3D triangles, shape (m, 3), whose normals by the right-hand rule
    point into the soil."""
    fields: Mapping[str, NDArray[Any]]
    """Fields of the vertices: ``normal`` [-], unit vectors into the soil, shape (n, dim), and in 2D
    ``arc_length`` [length], shape (n,)."""

    @classmethod
    def empty(cls, name: str, dim: int) -> SurfaceShape:
        """Returns the surface of a body that is not there."""
        fields: dict[str, NDArray[Any]] = {"normal": np.zeros((0, dim))}
        if dim == 2:
            fields["arc_length"] = np.zeros(0)
        return cls(name, np.zeros((0, dim)), np.zeros((0, dim), dtype=np.int64), fields)

    @classmethod
    def nowhere(cls, name: str, dim: int) -> SurfaceShape:
        """Returns the surface of a rigid body that is not there."""
        return cls(name, np.zeros((0, dim)), np.zeros((0, dim), dtype=np.int64), {})

    @property
    def polylines(self) -> list[Integers]:
        """Vertices along each chain of a surface in 2D; a closed one ends with its first vertex."""
        if len(self.cells) == 0:
            return []
        breaks = np.flatnonzero(self.cells[1:, 0] != self.cells[:-1, 1]) + 1
        return [np.append(part[:, 0], part[-1, 1]) for part in np.split(self.cells, breaks)]


@dataclass(frozen=True, eq=False)
class ContactShape:
    """The points of a contact surface at one output: ``n`` points, ``dim`` is 2 or 3."""

    name: str
    position: Floats
    """Position of the points [length], shape (n, dim)."""
    fields: Mapping[str, NDArray[Any]]
    """Fields of the points: ``normal`` [-], unit vectors into the soil, shape (n, dim); ``area``
    [length^(dim - 1), in axisymmetry length^2]; ``normal_stress`` [stress], tension positive;
    ``shear_stress`` [stress] of the surface on the soil, shape (n, dim); ``gap`` [length], > 0
    open; ``in_contact`` and ``sliding``, 1 or 0 (int8)."""

    @classmethod
    def empty(cls, name: str, dim: int) -> ContactShape:
        """Returns a contact surface without points."""
        vectors = {key: np.zeros((0, dim)) for key in ("normal", "shear_stress")}
        numbers = {key: np.zeros(0) for key in ("area", "normal_stress", "gap")}
        flags = {key: np.zeros(0, dtype=np.int8) for key in ("in_contact", "sliding")}
        return cls(name, np.zeros((0, dim)), {**vectors, **numbers, **flags})

    @property
    def cells(self) -> Integers:
        """Rows of ``position``: each point is a cell, shape (n, 1)."""
        return np.arange(len(self.position), dtype=np.int64)[:, None]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Data written to ``results.vtkhdf`` at one output time.

    Point arrays have one row per material point, in the order of the permanent ``point_id``; in a
    run without stages row ``i`` is the point with ``point_id == i``. ``n`` is the number of points,
    ``m`` of active nodes, ``c`` of active cells, ``dim`` is 2 or 3. Units are the user's; tension
    is positive; tensors are in VTK's symmetric order xx yy zz xy yz xz with tensor (not
    engineering) shear components.

    The arrays must not be changed after the snapshot is created.
    """

    step: int
    """Number of the load step that was completed; 0 is the initial state."""
    time: float
    """Time of the schedule (argument of the load factor)."""
    position: Floats
    """Current position of the points [length], shape (n, dim)."""
    point_id: Integers
    """Permanent number of each point, ascending, shape (n,)."""
    body_id: Integers
    """Number of the body each point belongs to, shape (n,)."""
    point_fields: Mapping[str, NDArray[Any]]
    """Point fields by full name: scalars (n,), vectors (n, dim), symmetric tensors (n, 6), general
    tensors (n, 3, 3). ``displacement`` [length] since the start, ``cauchy_stress`` [stress],
    with inertia ``velocity`` [length/time] and ``acceleration`` [length/time^2],
    with water ``effective_stress`` and ``pore_pressure`` [stress], where it flows
    ``excess_pore_pressure`` [stress] and ``darcy_velocity`` [length/time],
    ``plastic_strain`` [-] (equivalent), ``volume`` [length^dim, in axisymmetry length^3],
    ``domain`` [length] (half lengths of the point's domain), where bodies have corners (CPDI)
    ``domain_corners`` [length], relative to the point, x fastest, shape (n, 2**dim, dim), on
    request ``deformation_gradient`` [-];
    material parameters that vary from place to place by their keys, and where a body has layers
    ``layer``, the number of a point's layer in its body."""
    node_position: Floats
    """Position of the active nodes [length], shape (m, dim)."""
    cells: Integers
    """Rows of ``node_position`` that span each active cell, shape (c, 2**dim), in the order of
    VTK's quadrilateral (2D) or hexahedron (3D)."""
    node_fields: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """Node fields by full name: ``displacement`` [length] of the last step (m, dim), ``reaction``
    [force] of the boundary on the soil (m, dim)."""
    surfaces: tuple[SurfaceShape, ...] = ()
    """Tracked surfaces, the same names in the same order in every snapshot of a run."""
    contacts: tuple[ContactShape, ...] = ()
    """Contact surfaces, by the names of their boundaries or rigid bodies; the same in every
    snapshot of a run."""
    body_fields: tuple[int, ...] = ()
    """Number of the overlay of each body, by its number: those of the same one stick
    together where they meet. Empty if all bodies have the same."""
    rigid_bodies: tuple[SurfaceShape, ...] = ()
    """Surfaces of the rigid bodies where they are at this output, without fields; the normals of
    their cells point into the soil; the same in every snapshot of a run."""

    @property
    def dim(self) -> int:
        """Number of space dimensions, 2 or 3."""
        return int(self.position.shape[1])
