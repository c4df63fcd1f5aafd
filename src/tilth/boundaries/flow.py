# SPDX-License-Identifier: BSD-3-Clause
"""Boundaries at which the excess pore pressure or the flux of water is given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.nodal import Nodal
from tilth.boundaries.plane_faces import faces_on_plane, wet_cells
from tilth.boundaries.step.make import make_still
from tilth.boundaries.surfaces.near_soil import NearSoil, find_near_soil
from tilth.errors import BadInput
from tilth.grid.keys import find_keys
from tilth.model import (
    ImplicitFlowBoundary,
    Model,
    PlaneBoundary,
    PlaneFlowBoundary,
    SurfaceFlowBoundary,
)
from tilth.model.flow import UNSCALED, FlowBoundary
from tilth.model.load_curve import LoadCurve
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import points_in_cells
from tilth.mpm.water import PhreaticSurface
from tilth.surface.parts import locate_part
from tilth.surface.protocol import BodySurface
from tilth.surface.quadrature import area_vector
from tilth.terms.pore_water import WaterInStep
from tilth.terms.protocol import Term
from tilth.terms.surface_flow import FlowSurface, GivenFlux, GivenPressure


class FlowBoundaries:
    """The flow boundaries that act in a stage of a model.

    Where two planes with pressures meet, the later one counts.

    Args:
        model: with flowing water.

    Raises:
        BadInput: a file or function of a geometry cannot be used.
    """

    def __init__(self, model: Model) -> None:
        assert model.flow is not None
        keys = model.flow_boundary_keys()
        self._planes: list[_OnPlane] = []
        self._faces: list[_OnFaces] = []
        self._implicit: list[_OnGeometry] = []
        self._surfaces: list[_OnSurface] = []
        self._plane_of_nodes: Integers = np.zeros(0, dtype=np.int64)  # in the present step, else -1
        for each in model.flow.boundaries:
            if isinstance(each, PlaneFlowBoundary) and each.condition == "flux":
                self._faces.append(_OnFaces(each, model))
            elif isinstance(each, PlaneFlowBoundary):
                self._planes.append(_OnPlane(each, model))
            elif isinstance(each, ImplicitFlowBoundary):
                self._implicit.append(_OnGeometry(each, model, keys[each.name]))
            elif model.present(each.body):
                self._surfaces.append(_OnSurface(each, model, keys[each.name]))

    def on_nodes(self, active: ActiveGrid, time: float, stabilised: Flags) -> tuple[Flags, Floats]:
        """Returns which nodes have a given pressure at a time, and this, shape (nodes, 1) each.

        Nodes beyond a plane have it, too, but for those that the ghost term holds: it would bend
        the pressure in front of the plane.

        stabilised: nodes of the faces with a ghost term, shape (nodes,).
        """
        value = np.zeros((active.nodes, 1))
        self._plane_of_nodes = np.full(active.nodes, -1)
        for number, plane in enumerate(self._planes):
            nodes = plane.nodes.on_plane(active)
            nodes |= plane.nodes.nodes(active) & ~stabilised
            value[nodes, 0] = plane.pressure(active.position[nodes], time)
            self._plane_of_nodes[nodes] = number
        held = self._plane_of_nodes[:, None] >= 0
        return active.updated(held), active.updated(value)

    def outflow_of_nodes(self, reaction: Floats) -> dict[str, Floats]:
        """Returns the water that leaves through each plane, shape (nodes, 1), by its name.

        reaction: residual of the balance of water where the pressure was given last, (nodes, 1).
        """
        which = self._plane_of_nodes[:, None]
        return {
            plane.name: np.where(which == number, reaction, 0.0)
            for number, plane in enumerate(self._planes)
        }

    def terms(
        self, water: WaterInStep, surfaces: Mapping[str, BodySurface], before: float, after: float
    ) -> Sequence[Term]:
        """Returns the terms of the boundaries that are not on nodes; all processes call it.

        surfaces: of the bodies, by their names. before, after: times at start and end of the step.

        Raises:
            StepFailed: a part of a surface is more than a cell away from the soil.
        """
        points, active = water.soil.points, water.soil.active
        near = find_near_soil([each.surface for each in self._implicit], points, active, before)
        found = [
            each.term(water, each.part(active, of, before), after)
            for each, of in zip(self._implicit, near, strict=True)
        ]
        found += [each.term(water, each.part(active), after) for each in self._faces]
        return found + [
            each.term(water, each.part(active, surfaces[each.body]), after)
            for each in self._surfaces
        ]

    def require_soil(self, points: MaterialPoints, active: ActiveGrid) -> None:
        """Checks that the boundaries on geometries touch soil at the start of the first step.

        Raises:
            BadInput: one of them does not.
        """
        near = find_near_soil([each.surface for each in self._implicit], points, active, 0.0)
        for each, of in zip(self._implicit, near, strict=True):
            each.surface.require_soil(points.position)
            if len(of.chosen) == 0:
                distance = np.abs(each.surface.distance(points.position, 0.0)).min(initial=np.inf)
                raise BadInput(
                    f"the flow boundary {each.name!r} touches no soil: the nearest material point "
                    f"is {-active.comm.max(-float(distance)):.3g} away",
                    "correct its position, or let it act from a later stage",
                    key=f"{each.surface.key}.geometry",
                )


class _Acting:
    """What is given at a flow boundary.

    Attributes:
        name: given by the user.
    """

    def __init__(self, declared: FlowBoundary, model: Model) -> None:
        self.name = declared.name
        self._at_rest = PhreaticSurface.of(model) if declared.condition == "head" else None
        self._declared = declared
        self._curve = LoadCurve(declared.factor or UNSCALED)

    def value(self, time: float) -> float:
        """Returns the excess pore pressure, the head or the flux into the soil at a time."""
        return self._declared.value * self._curve.factor(time)

    def pressure(self, position: Floats, time: float) -> Floats:
        """Returns the excess pore pressure at positions (n, dim) and a time [stress], shape (n,).

        Of a head H at the height y it is gamma_w (H - y) less the pressure of the water at rest.
        """
        value, rest = self.value(time), self._at_rest
        if rest is None:
            return np.full(len(position), value)
        total = rest.unit_weight(time) * (value - position[:, -1])
        return np.asarray(total - rest.pore_pressure(position, time))

    def term(self, water: WaterInStep, surface: FlowSurface, after: float) -> Term:
        """Returns the term of a boundary with these points, at the end of the step."""
        if self._declared.condition == "flux":
            return GivenFlux(self.name, water, surface, self.value(after))
        return GivenPressure(self.name, water, surface, lambda at: self.pressure(at, after))


class _OnPlane(_Acting):
    """A pressure on the nodes of a plane.

    Attributes:
        nodes: tells which they are.
    """

    def __init__(self, declared: PlaneFlowBoundary, model: Model) -> None:
        super().__init__(declared, model)
        plane = PlaneBoundary(
            name=declared.name, axis=declared.axis, at=declared.at, range=declared.range,
            condition="fixed",
        )  # fmt: skip
        self.nodes = _WetNodes(plane, model.dimension, self._curve)


class _OnFaces(_Acting):
    """A flux through the faces of cells on a plane."""

    def __init__(self, declared: PlaneFlowBoundary, model: Model) -> None:
        super().__init__(declared, model)
        self._plane, self._axisymmetric = declared, model.analysis.kind == "axisymmetric"

    def part(self, active: ActiveGrid) -> FlowSurface:
        """Returns the faces with soil beside them at the start of the step."""
        return faces_on_plane(self._plane, active, self._axisymmetric)


class _OnGeometry(_Acting):
    """A condition on a geometry.

    Attributes:
        surface: its points in the grid.
    """

    def __init__(self, declared: ImplicitFlowBoundary, model: Model, key: str) -> None:
        super().__init__(declared, model)
        self.surface = make_still(declared.name, declared.geometry, model, key)

    def part(self, active: ActiveGrid, near: NearSoil, time: float) -> FlowSurface:
        """Returns its points near soil in the cells of this process at a time."""
        known = find_keys(active.cell_keys, near.key) >= 0
        chosen = near.chosen[known]
        assert self.surface.quadrature is not None
        return FlowSurface(
            points_in_cells(active, near.key[known], near.local[known]),
            -self.surface.quadrature.normal[chosen],
            self.surface.weights(time, chosen) * near.fraction[known],
            self.surface.positions(time, chosen),
        )


class _OnSurface(_Acting):
    """A condition on a tracked surface.

    Attributes:
        body: whose surface it is.
    """

    def __init__(self, declared: SurfaceFlowBoundary, model: Model, key: str) -> None:
        super().__init__(declared, model)
        self.body, self._key = declared.body, key
        self._axisymmetric = model.analysis.kind == "axisymmetric"

    def part(self, active: ActiveGrid, surface: BodySurface) -> FlowSurface:
        """Returns its points near this process, where the surface is at the start of the step."""
        points, _ = surface.of_part(self._key, surface.quadrature(active))
        order, at = locate_part(active, self.body, points.position)
        area = area_vector(points.edges[order])
        weight = np.linalg.norm(area, axis=1)
        normal = -area / np.maximum(weight, 1e-300)[:, None]
        if self._axisymmetric:
            weight = weight * 2.0 * np.pi * points.position[order, 0]
        return FlowSurface(at, normal, weight, points.position[order])


class _WetNodes(Nodal):
    """The nodes of a plane, and those beyond it where no soil with water in its pores is.

    Domains of wet points may extend a hair beyond the plane into soil that lets no water in. The
    pressure of the nodes there would be free, and keep the water from the plane.
    """

    def _occupied(self, active: ActiveGrid) -> Integers:
        return wet_cells(active)
