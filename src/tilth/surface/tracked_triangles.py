# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surface of a body in space: triangles whose vertices move with the soil."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats, require_table, require_within
from tilth.curves.chain import BadSurface
from tilth.errors import BadInput, StepFailed
from tilth.model import Model
from tilth.model.problems import unknown_name
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.output.snapshot import SurfaceShape
from tilth.surface.beside_soil import lost_points, moved_with_grid, points_near_soil
from tilth.surface.clipped import ClippedTriangles, area_in_plan, clip_in_plan
from tilth.surface.outline_3d import outline_3d
from tilth.surface.parts import DeclaredPart, declared_parts
from tilth.surface.quadrature import SurfaceQuadrature
from tilth.surface.subdivide import subdivide
from tilth.surface.triangles import Triangles, triangle_rule

LONGEST_EDGE_RATIO = 2.0
"""An edge longer than this many initial spacings is halved; initially the ratio is at most 1.5."""


@dataclass(frozen=True)
class TrackedTriangles:
    """The current triangles, and the initial positions of their vertices [length], shape (n, 3)."""

    current: Triangles
    initial: Floats


class TrackedSolidSurface:
    """The triangulated surface of one body in space, see `BodySurface`.

    What has no named part does not act on planes of symmetry at which a shape is cut.

    Args:
        model: the declared problem.
        number: index of the body in the model; it declares a `surface`.

    Raises:
        BadInput: the body has no such surface, or what acts on it names an unknown part of it.
    """

    def __init__(self, model: Model, number: int) -> None:
        body = model.bodies[number]
        assert body.surface is not None
        self.name = body.name
        self._spacing = body.surface.spacing or 0.5 * min(model.cell_size)
        triangles = outline_3d(body, model.cell_size, self._spacing, model.origin)
        self.triangles = TrackedTriangles(triangles, triangles.vertices)
        self._parts = declared_parts(model, body.name)
        self._clipped: dict[str, tuple[int, ClippedTriangles]] = {}
        for key, part in self._parts.items():
            if part.part is not None and part.part not in triangles.part:
                words = unknown_name("part of the surface", part.part, triangles.part)
                raise BadInput(*words, key=f"{key}.part", value=part.part)
            if part.within is not None:
                self._require_one_surface(key, part)

    def _require_one_surface(self, key: str, part: DeclaredPart) -> None:
        """Checks that a region in plan lies on soil, and on one surface."""
        assert part.within is not None
        covered = area_in_plan(self.triangles.current.corner, self._within(key))
        where = f"of the body {self.name!r}"
        if part.part is not None:
            where = f"{part.part!r} {where}"
        value = part.within.model_dump(exclude_none=True)
        if covered == 0.0:
            what = f"no surface {where} lies in this region"
            remedy = "move the region; without `part` it is on surfaces that face upwards"
            raise BadInput(what, remedy, key=f"{key}.within", value=value)
        if covered > part.within.area * (1.0 + 1e-6):
            what = f"surfaces {where} lie above each other in this region"
            raise BadInput(what, "name the `part` of them", key=f"{key}.within", value=value)

    def quadrature(self, active: ActiveGrid) -> SurfaceQuadrature:
        """As `BodySurface.quadrature`: six points on each triangle, independent of the grid."""
        return self.material_quadrature()

    def material_quadrature(self) -> SurfaceQuadrature:
        """As `BodySurface.material_quadrature`: six points on each triangle."""
        count = len(self.triangles.current.triangle)
        whole = np.broadcast_to(np.eye(3), (count, 3, 3))
        return self._on(ClippedTriangles(np.arange(count), whole, np.ones(count)))

    def _on(self, parts: ClippedTriangles) -> SurfaceQuadrature:
        """Returns six quadrature points on each of some parts of the triangles."""
        current, rule = self.triangles.current, triangle_rule(6)
        initial = Triangles(self.triangles.initial, current.triangle)
        count = len(rule.weight)
        element = np.repeat(parts.element, count)
        weight = np.outer(parts.share, rule.weight).ravel()
        barycentric = np.einsum("qv,kvb->kqb", rule.barycentric, parts.corner)

        def edges(triangles: Triangles) -> Floats:
            both = triangles.tangent[element]
            return np.stack([weight[:, None] * both[:, 0], both[:, 1]], axis=1)

        def position(triangles: Triangles) -> Floats:
            points = np.einsum("kqb,kbi->kqi", barycentric, triangles.corner[parts.element])
            return np.asarray(points.reshape(-1, 3))

        return SurfaceQuadrature(
            position=position(current),
            edges=edges(current),
            initial_position=position(initial),
            initial_edges=edges(initial),
            element=element,
            arc_length=np.zeros(len(element)),
        )

    def of_part(self, key: str, quadrature: SurfaceQuadrature) -> tuple[SurfaceQuadrature, Floats]:
        """As `BodySurface.of_part`."""
        if self._parts[key].within is not None:
            points = self._on(self._within(key))
        else:
            chosen = self._of_part(self._parts[key].part)
            points = quadrature.ordered(np.flatnonzero(chosen[quadrature.element]))
        return points, points.arc_length

    def long_parts(self) -> dict[str, float]:
        """As `BodySurface.long_parts`: none, the parts of a surface in space have no ends."""
        return {}

    def _of_part(self, part: str | None) -> Flags:
        """Returns the triangles of a part, or without one those of the body's own surface, (m,)."""
        triangles = self.triangles.current
        if part is not None:
            return triangles.in_part(part)
        own = np.array([not name.startswith("cut ") for name in triangles.part])
        return np.asarray(own[triangles.part_number])

    def _within(self, key: str) -> ClippedTriangles:
        """Returns the parts of the triangles in a declared region; they stay with the soil."""
        count, part = len(self.triangles.current.triangle), self._parts[key]
        if key not in self._clipped or self._clipped[key][0] != count:
            assert part.within is not None
            initial = Triangles(self.triangles.initial, self.triangles.current.triangle)
            chosen = self._of_part(part.part)
            upwards = chosen & (initial.area_vector[:, 2] < 0.0)
            if part.part is None or upwards.any():
                chosen = upwards
            region = np.array(part.within.corners())
            self._clipped[key] = count, clip_in_plan(initial.corner, chosen, region)
        return self._clipped[key][1]

    def moved(
        self, active: ActiveGrid, displacement: Floats, points: MaterialPoints, position: Floats
    ) -> tuple[TrackedTriangles, str | None]:
        """As `BodySurface.moved`; triangles are not searched for crossings."""
        old, warning = self.triangles.current, None
        try:
            position = moved_with_grid(active, old.vertices, displacement, self.name)
        except StepFailed:
            near = points_near_soil(active, old.vertices, self.name)
            if self._parts or not near.any():
                raise
            moved = np.zeros_like(old.vertices)
            moved[near] = moved_with_grid(active, old.vertices[near], displacement, self.name)
            moved[near] -= old.vertices[near]
            position = old.vertices + old.spread(moved, near)
            warning = lost_points(self.name, "moves there as beside them")
        try:
            current = Triangles(position, old.triangle, old.part, old.part_number)
        except BadSurface as error:
            raise StepFailed(f"the surface of {self.name!r}: {error.problem}") from error
        refined = subdivide(current, LONGEST_EDGE_RATIO * self._spacing)
        initial = refined.interpolated(self.triangles.initial)
        return TrackedTriangles(refined.triangles, initial), warning

    def commit(self, state: TrackedTriangles) -> None:
        """As `BodySurface.commit`."""
        self.triangles = state

    def move_vertically(self, displacement: Callable[[Floats], Floats]) -> None:
        """As `BodySurface.move_vertically`."""
        old = self.triangles.current
        vertices = old.vertices.copy()
        vertices[:, 2] += displacement(vertices[:, :2])
        current = Triangles(vertices, old.triangle, old.part, old.part_number)
        self.triangles = TrackedTriangles(current, vertices)

    def enclosed(self) -> float:
        """As `BodySurface.enclosed`."""
        return self.triangles.current.volume

    def shape(self) -> SurfaceShape:
        """As `BodySurface.shape`."""
        current = self.triangles.current
        return SurfaceShape(
            self.name, current.vertices, current.triangle, {"normal": current.vertex_normal}
        )

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """As `BodySurface.state`."""
        current = self.triangles.current
        return {
            "vertices": current.vertices,
            "triangle": current.triangle,
            "part_number": current.part_number,
            "initial": self.triangles.initial,
        }

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """As `BodySurface.restore`."""
        require_table({name: state[name] for name in ("vertices", "initial")})
        require_table({name: state[name] for name in ("triangle", "part_number")})
        require_within("triangle", state["triangle"], len(state["vertices"]))
        part = self.triangles.current.part
        require_within("part_number", state["part_number"], len(part))
        vertices, triangle = state["vertices"], state["triangle"]
        current = Triangles(vertices, triangle, part, state["part_number"])
        self.triangles = TrackedTriangles(current, state["initial"])
        self._clipped.clear()
