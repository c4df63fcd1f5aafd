# SPDX-License-Identifier: BSD-3-Clause
"""Loads distributed over surfaces, in one load step (docs/theory/surface.md).

With the points of the surface at x = X + u, u the grid's displacement, an element of the surface
with edges E has the edges (1 + grad u) E. Pressure and shear act on these: the load follows the
surface within the Newton iterations, and its derivative belongs to the stiffness.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.model import Model, SurfaceLoad
from tilth.model.load_curve import LoadCurve
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements, same_starts
from tilth.mpm.quadrature import PointsInCells
from tilth.surface.parts import load_key, locate_part
from tilth.surface.protocol import BodySurface
from tilth.surface.quadrature import SurfaceQuadrature, area_derivative, area_vector
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Role, Term
from tilth.terms.space import Coupled, Space


@dataclass(frozen=True)
class DeclaredLoad:
    """A declared load on a surface.

    Attributes:
        number: index among all loads of the model.
        load: the declaration.
        curve: load factor over time.
    """

    number: int
    load: SurfaceLoad
    curve: LoadCurve


def declared_loads(model: Model) -> list[DeclaredLoad]:
    """Returns the loads on surfaces of a model."""
    return [
        DeclaredLoad(number, load, model.load_curve(load))
        for number, load in model.acting_loads()
        if isinstance(load, SurfaceLoad)
    ]


@dataclass(frozen=True)
class _Loaded:
    """One load on its quadrature points, sorted by cell."""

    load: SurfaceLoad
    curve: LoadCurve
    at: PointsInCells
    points: SurfaceQuadrature
    arc_length: Floats


class SurfaceLoads(Term):
    """All loads on surfaces in one step, as far as they act on the nodes of this process.

    Args:
        loads: the declared loads.
        kind: "plane_strain", "axisymmetric" or "3d".
        surfaces: surfaces of the bodies, by the bodies' names.
        active: the grid of the step.
        before, after: times at the start and the end of the step.

    Raises:
        StepFailed: a loaded surface is more than a cell away from the soil.
    """

    def __init__(
        self,
        loads: Sequence[DeclaredLoad],
        kind: str,
        surfaces: Mapping[str, BodySurface],
        active: ActiveGrid,
        before: float,
        after: float,
    ) -> None:
        self._active, self._before, self._after = active, before, after
        self._axisymmetric = kind == "axisymmetric"
        self._loaded = []
        quadrature = {}
        for declared in loads:
            load = declared.load
            surface = surfaces[load.body]
            if load.body not in quadrature:
                quadrature[load.body] = surface.quadrature(active)
            points, arc_length = surface.of_part(load_key(declared.number), quadrature[load.body])
            order, at = locate_part(active, load.body, points.position)
            points, arc_length = points.ordered(order), arc_length[order]
            self._loaded.append(_Loaded(load, declared.curve, at, points, arc_length))

    def __bool__(self) -> bool:
        return bool(self._loaded)

    @property
    def coupled(self) -> list[Coupled]:
        """As `Term.coupled`: the nodes of each cell that contains loaded points."""
        return [Coupled(same_starts(each.at.node), each.at.node.ravel()) for each in self._loaded]

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        return _AssembledSurfaceLoads(self, elements)

    def force_before(self) -> Floats:
        """Returns the nodal force at the start of the step [force], shape (nodes, dim)."""
        return self._force(np.zeros((self._active.nodes, self._active.grid.dim)), self._before)

    def force(self, displacement: Floats) -> Floats:
        """Returns the nodal force at the step's end for a displacement [force], (nodes, dim)."""
        return self._force(displacement, self._after)

    def at_points(self, displacement: Floats) -> list[tuple[SurfaceLoad, Floats, Floats]]:
        """Returns each load with its quadrature points [length] and their forces [force], (n, dim).

        The points are those at the start of the step, the forces those at its end.
        """
        return [
            (
                loaded.load,
                loaded.points.position,
                self._force_at_points(loaded, displacement, self._after),
            )
            for loaded in self._loaded
        ]

    def _force(self, displacement: Floats, time: float) -> Floats:
        force = np.zeros_like(displacement)
        for loaded in self._loaded:
            force += loaded.at.scatter(
                self._force_at_points(loaded, displacement, time), len(force)
            )
        return force

    def subtract_derivative(
        self, displacement: Floats, elements: Sequence[Elements], blocks: Floats
    ) -> None:
        """Subtracts the derivative of `force` from the node blocks (blocks, dim, dim)."""
        for loaded, cell_elements in zip(self._loaded, elements, strict=True):
            derivative = self._derivative(loaded, displacement, self._after)  # (n, b, i, k)
            if derivative is None:
                continue
            matrix = -np.einsum("na,nbik->nabik", loaded.at.value, derivative)
            matrix = np.ascontiguousarray(np.add.reduceat(matrix, loaded.at.start[:-1], axis=0))
            _core.add_dense_blocks(cell_elements, matrix, blocks)

    def _moved(self, loaded: _Loaded, displacement: Floats) -> tuple[Floats, Floats]:
        """Returns positions and edges of the quadrature points for a nodal displacement."""
        nodal = displacement[loaded.at.node[loaded.at.cell]]
        position = loaded.points.position + np.einsum("na,nai->ni", loaded.at.value, nodal)
        gradient = np.einsum("nai,naj->nij", nodal, loaded.at.gradient)
        edges = loaded.points.edges
        return position, edges + np.einsum("nij,nej->nei", gradient, edges)

    def _pressure(self, loaded: _Loaded, height: Floats, time: float) -> Floats:
        """Returns the pressure at the quadrature points [stress], shape (n,)."""
        load = loaded.load
        pressure = np.full(len(height), load.pressure)
        if load.pressure_along is not None:
            table = np.array(load.pressure_along)
            pressure += np.interp(loaded.arc_length, *table.T)
        if load.hydrostatic is not None:
            depth = np.maximum(_level(load, time) - height, 0.0)
            pressure += load.hydrostatic.unit_weight * depth
        return loaded.curve.factor(time) * pressure

    def _force_at_points(self, loaded: _Loaded, displacement: Floats, time: float) -> Floats:
        """Returns the force of each quadrature point [force], shape (n, dim)."""
        load, points = loaded.load, loaded.points
        factor = loaded.curve.factor(time)
        position, edges = points.initial_position, points.initial_edges
        if load.follower:
            position, edges = self._moved(loaded, displacement)
        force = self._pressure(loaded, position[:, -1], time)[:, None] * area_vector(edges)
        force += factor * load.shear * edges[:, 0]
        if self._axisymmetric:
            force *= 2.0 * np.pi * position[:, :1]
        if load.traction is not None:
            area = np.linalg.norm(area_vector(points.initial_edges), axis=1)
            if self._axisymmetric:
                area *= 2.0 * np.pi * points.initial_position[:, 0]
            force += factor * area[:, None] * np.array(load.traction)
        return force

    def _derivative(self, loaded: _Loaded, displacement: Floats, time: float) -> Floats | None:
        """Returns the derivative of `_force_at_points` by nodal displacements (n, nodes, i, k)."""
        load, at = loaded.load, loaded.at
        if not load.follower or not (
            load.pressure or load.shear or load.pressure_along or load.hydrostatic
        ):
            return None
        factor = loaded.curve.factor(time)
        position, edges = self._moved(loaded, displacement)
        dim = position.shape[1]
        pressure = self._pressure(loaded, position[:, -1], time)
        area = area_vector(edges)
        by_edge = pressure[:, None, None, None] * area_derivative(edges)
        by_edge[:, 0] += factor * load.shear * np.eye(dim)
        along = np.einsum("naj,nej->nae", at.gradient, loaded.points.edges)
        derivative = np.einsum("nae,neik->naik", along, by_edge)
        if load.hydrostatic is not None:
            wet = position[:, -1] < _level(load, time)
            by_height = -factor * load.hydrostatic.unit_weight * wet[:, None] * area
            derivative[..., -1] += at.value[:, :, None] * by_height[:, None]
        if self._axisymmetric:
            derivative *= 2.0 * np.pi * position[:, 0, None, None, None]
            force = pressure[:, None] * area + factor * load.shear * edges[:, 0]
            derivative[..., 0] += 2.0 * np.pi * at.value[:, :, None] * force[:, None]
        return np.asarray(derivative)


class _AssembledSurfaceLoads(DisplacementTerm):
    role = Role.LOAD
    label = "loads on surfaces"

    def __init__(self, loads: SurfaceLoads, elements: Sequence[Elements]) -> None:
        self._loads, self._elements = loads, elements

    def force(self, displacement: Floats) -> Floats:
        return -self._loads.force(displacement)

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        self._loads.subtract_derivative(displacement, self._elements, blocks)

    def load_before(self) -> Floats:
        return self._loads.force_before()


def _level(load: SurfaceLoad, time: float) -> float:
    """Returns the water level [length] at a time."""
    assert load.hydrostatic is not None
    level = load.hydrostatic.level
    return level if isinstance(level, float) else LoadCurve(level).factor(time)
