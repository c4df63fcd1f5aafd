# SPDX-License-Identifier: BSD-3-Clause
"""The tracked surface of a soil body on which its contact with another soil body is integrated.

Its quadrature points stay with the soil. What they carry is in the frame of the surface: along its
normal and tangents, which move with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, require_table
from tilth.boundaries.contact.law import ContactLaw
from tilth.boundaries.contact.surface import NUMBERS, CarriedContact, parameters
from tilth.model import ContactPair
from tilth.surface.protocol import BodySurface
from tilth.surface.quadrature import SurfaceQuadrature, area_vector


class BodyContactSurface(CarriedContact):
    """The surface of the first of two bodies in contact.

    Args:
        declared: the user's declaration.
        tracked: surface of the first body.
        delta: width of the band of an implicit boundary, for the penalty [length].
        cell_size: [length], shape (dim,).

    Attributes:
        first, second: names of the bodies.
        contact: the law.
        square: factor of the penalty [1/length], see `BoundaryQuadrature`.
    """

    def __init__(
        self, declared: ContactPair, tracked: BodySurface, delta: float, cell_size: Floats
    ) -> None:
        self.name = declared.name
        self.body = None
        self.full = declared.wished_in_place
        self.first, self.second = declared.bodies
        self.contact = declared.contact
        self.square = 4.0 / (3.0 * delta)
        self._tracked = tracked
        self._cell = float(cell_size.min())
        dim = len(cell_size)
        self.carried = np.zeros((0, dim + NUMBERS))
        self._reference = np.zeros((0, dim))
        self._has_begun = False

    @property
    def cell(self) -> float:
        """As `CarriedContact.cell`."""
        return self._cell

    @property
    def is_flat(self) -> bool:
        """As `CarriedContact.is_flat`: a tracked surface may have any form."""
        return False

    @property
    def touches_nearly(self) -> bool:
        """As `CarriedContact.touches_nearly`: in the first step, as the bodies are declared."""
        return not self._has_begun

    def quadrature(self) -> SurfaceQuadrature:
        """Returns the points at the start of a step.

        Where boundary points were added, new points take what the nearest ones carried.
        """
        points = self._tracked.material_quadrature()
        reference = points.initial_position
        if len(self._reference) == 0:
            self.carried = np.zeros((len(reference), self.carried.shape[1]))
        elif not np.array_equal(reference, self._reference):
            from scipy.spatial import cKDTree

            self.carried = self.carried[cKDTree(self._reference).query(reference)[1]]
        self._reference = reference
        return points

    def begin(self) -> None:
        """Ends the first step: from now on bodies touch where their gap is closed."""
        self._has_begun = True

    def law(self, cohesion: Floats, slope: Floats) -> ContactLaw:
        """Returns the law of points between soils of these strengths, the lesser of both bodies.

        cohesion, slope: c [stress] and tan(phi) [-], shape (n,).
        """
        values = parameters(self.contact, cohesion, slope)
        full = [np.broadcast_to(np.asarray(value, np.float64), cohesion.shape) for value in values]
        bilateral = np.full(len(cohesion), self.contact.normal == "bilateral")
        return ContactLaw(full[0], full[1], full[2], full[3], bilateral)

    def carry_from(self, other: BodyContactSurface) -> None:
        """Takes over what the same surface carries in the last stage."""
        self.carried, self._reference = other.carried, other._reference
        self._has_begun = other._has_begun

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        begun = np.array([self._has_begun])
        return {"carried": self.carried, "reference": self._reference, "begun": begun}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        require_table({name: state[name] for name in ("carried", "reference")})
        self.carried, self._reference = state["carried"], state["reference"]
        self._has_begun = bool(state["begun"][0])


def frames_of(edges: Floats) -> Floats:
    """Returns normal away from the soil and tangents of edges (n, dim - 1, dim) as columns.

    See `SurfaceQuadrature`; the first tangent is along the first edge. Shape (n, dim, dim).
    """
    normal = -area_vector(edges)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    along = edges[:, 0] / np.linalg.norm(edges[:, 0], axis=1)[:, None]
    columns = [normal, along]
    if edges.shape[2] == 3:
        columns.append(np.cross(normal, along))
    return np.stack(columns, axis=2)


def tributary_parts(edges: Floats) -> Floats:
    """Returns the tributary parts of points with these edges, as in `QuadraturePoints`.

    Shape (n, dim, dim). In space they are parallelograms of the same area with sides of alike
    length.
    """
    sides = edges
    if edges.shape[1] == 2:
        length = np.linalg.norm(edges, axis=2)
        ratio = np.sqrt(length[:, 1] / length[:, 0])[:, None]
        sides = np.stack([edges[:, 0] * ratio, edges[:, 1] / ratio], axis=1)
    return np.concatenate([-0.5 * sides.sum(axis=1, keepdims=True), sides], axis=1)
