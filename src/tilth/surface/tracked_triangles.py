# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surface of a body in space: triangles whose vertices move with the soil."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers, require_table, require_within
from tilth.curves.chain import BadSurface
from tilth.errors import BadInput, StepFailed
from tilth.model import Model, SurfaceLoad
from tilth.model.problems import unknown_name
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.output.snapshot import SurfaceShape
from tilth.surface.outline_3d import outline_3d
from tilth.surface.quadrature import SurfaceQuadrature
from tilth.surface.subdivide import subdivide
from tilth.surface.tracked import moved_with_grid
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

    A load without a named part does not act on planes of symmetry at which a shape is cut.

    Args:
        model: the declared problem.
        number: index of the body in the model; it declares a `surface`.

    Raises:
        BadInput: the body has no such surface, or a load names an unknown part of it.
    """

    def __init__(self, model: Model, number: int) -> None:
        body = model.bodies[number]
        assert body.surface is not None
        self.name = body.name
        self._spacing = body.surface.spacing or 0.5 * min(model.cell_size)
        triangles = outline_3d(body, model.cell_size, self._spacing)
        self.triangles = TrackedTriangles(triangles, triangles.vertices)
        self._part_of: dict[int, str | None] = {}
        for load_number, load in enumerate(model.loads):
            if isinstance(load, SurfaceLoad) and load.body == body.name:
                if load.part is not None and load.part not in triangles.part:
                    words = unknown_name("part of the surface", load.part, triangles.part)
                    raise BadInput(*words, key=f"loads[{load_number}].part", value=load.part)
                self._part_of[load_number] = load.part

    def quadrature(self, active: ActiveGrid) -> SurfaceQuadrature:
        """As `BodySurface.quadrature`: six points on each triangle, independent of the grid."""
        current, rule = self.triangles.current, triangle_rule(6)
        initial = Triangles(self.triangles.initial, current.triangle)
        count, points = len(current.triangle), len(rule.weight)
        element = np.repeat(np.arange(count), points)
        weight = np.tile(rule.weight, count)

        def edges(triangles: Triangles) -> Floats:
            both = triangles.tangent[element]
            return np.stack([weight[:, None] * both[:, 0], both[:, 1]], axis=1)

        def position(triangles: Triangles) -> Floats:
            points = np.einsum("qv,kvi->kqi", rule.barycentric, triangles.corner)
            return np.asarray(points.reshape(-1, 3))

        return SurfaceQuadrature(
            position=position(current),
            edges=edges(current),
            initial_position=position(initial),
            initial_edges=edges(initial),
            element=element,
            arc_length=np.zeros(len(element)),
        )

    def loaded(self, number: int, quadrature: SurfaceQuadrature) -> tuple[Integers, Floats]:
        """As `BodySurface.loaded`."""
        triangles, part = self.triangles.current, self._part_of[number]
        if part is None:
            loaded_parts = np.array([not name.startswith("cut ") for name in triangles.part])
            loaded = loaded_parts[triangles.part_number]
        else:
            loaded = triangles.in_part(part)
        rows = np.flatnonzero(loaded[quadrature.element])
        return rows, quadrature.arc_length[rows]

    def moved(
        self, active: ActiveGrid, displacement: Floats, points: MaterialPoints, position: Floats
    ) -> tuple[TrackedTriangles, str | None]:
        """As `BodySurface.moved`; triangles are not searched for crossings."""
        old = self.triangles.current
        position = moved_with_grid(active, old.vertices, displacement, self.name)
        try:
            current = Triangles(position, old.triangle, old.part, old.part_number)
        except BadSurface as error:
            raise StepFailed(f"the surface of {self.name!r}: {error.problem}") from error
        refined = subdivide(current, LONGEST_EDGE_RATIO * self._spacing)
        return TrackedTriangles(
            refined.triangles, refined.interpolated(self.triangles.initial)
        ), None

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
