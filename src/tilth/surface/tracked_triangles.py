# SPDX-License-Identifier: BSD-3-Clause
"""The surface of a body in space: triangles whose vertices move with the soil."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
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
from tilth.surface.tracked import moved_with
from tilth.surface.triangles import Triangles, triangle_rule

LONGEST = 2.0
"""An edge longer than this many spacings of the start is halved; some have 1.5 at the start."""


@dataclass(frozen=True)
class TrackedTriangles:
    """The triangles now, and where their vertices were at time 0 [length], shape (n, 3)."""

    now: Triangles
    initial: Floats


class TrackedSolidSurface:
    """The triangulated surface of one body; as `TrackedSurface`, which is a curve's.

    Planes of symmetry that a shape is cut at carry no load, unless it names them.
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
        """As `BodySurface.quadrature`: six places on each triangle, whatever the grid."""
        now, rule = self.triangles.now, triangle_rule(6)
        initial = Triangles(self.triangles.initial, now.triangle)
        count, places = len(now.triangle), len(rule.weight)
        patch = np.repeat(np.arange(count), places)
        weight = np.tile(rule.weight, count)

        def edges(triangles: Triangles) -> Floats:
            both = triangles.tangent[patch]
            return np.stack([weight[:, None] * both[:, 0], both[:, 1]], axis=1)

        def position(triangles: Triangles) -> Floats:
            places = np.einsum("qv,kvi->kqi", rule.place, triangles.corner)
            return np.asarray(places.reshape(-1, 3))

        return SurfaceQuadrature(
            position=position(now),
            edges=edges(now),
            initial_position=position(initial),
            initial_edges=edges(initial),
            patch=patch,
            arc_length=np.zeros(len(patch)),
        )

    def loaded(self, number: int, quadrature: SurfaceQuadrature) -> tuple[Integers, Floats]:
        """As `BodySurface.loaded`."""
        triangles, part = self.triangles.now, self._part_of[number]
        if part is None:
            of_soil = np.array([not name.startswith("cut ") for name in triangles.part])
            covered = of_soil[triangles.part_number]
        else:
            covered = triangles.in_part(part)
        rows = np.flatnonzero(covered[quadrature.patch])
        return rows, quadrature.arc_length[rows]

    def moved(
        self, active: ActiveGrid, displacement: Floats, points: MaterialPoints, position: Floats
    ) -> tuple[TrackedTriangles, str | None]:
        """As `BodySurface.moved`; triangles are not searched for crossings."""
        old = self.triangles.now
        place = moved_with(active, old.vertices, displacement, self.name)
        try:
            now = Triangles(place, old.triangle, old.part, old.part_number)
        except BadSurface as error:
            raise StepFailed(f"the surface of {self.name!r}: {error.problem}") from error
        finer = subdivide(now, LONGEST * self._spacing)
        return TrackedTriangles(finer.triangles, finer.carried(self.triangles.initial)), None

    def commit(self, state: TrackedTriangles) -> None:
        """As `BodySurface.commit`."""
        self.triangles = state

    def enclosed(self) -> float:
        """As `BodySurface.enclosed`."""
        return self.triangles.now.volume

    def shape(self) -> SurfaceShape:
        """As `BodySurface.shape`."""
        now = self.triangles.now
        return SurfaceShape(self.name, now.vertices, now.triangle, {"normal": now.vertex_normal})

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """As `BodySurface.state`."""
        now = self.triangles.now
        return {
            "vertices": now.vertices,
            "triangle": now.triangle,
            "part_number": now.part_number,
            "initial": self.triangles.initial,
        }

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """As `BodySurface.restore`."""
        part = self.triangles.now.part
        vertices, triangle = state["vertices"], state["triangle"]
        now = Triangles(vertices, triangle, part, state["part_number"])
        self.triangles = TrackedTriangles(now, state["initial"])
