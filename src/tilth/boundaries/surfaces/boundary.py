# SPDX-License-Identifier: BSD-3-Clause
"""An implicit boundary with its quadrature points, its motion and its tractions.

The quadrature points are fixed to the boundary. In each step those in contact with soil constrain
the grid's displacement by the implicit boundary method (Kumar et al. 2008; Cortis et al. 2018;
docs/theory/implicit_boundaries.md). Each stores its traction for the next step; otherwise the
boundary would have to slip in each step to produce it again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers, require_table
from tilth.boundaries.surfaces.ends import FARTHEST_MOTION, LEAST_WIDTH, Ends, find_ends, width_of
from tilth.boundaries.surfaces.grid_properties import GridProperties
from tilth.boundaries.surfaces.motion import Motion, cofactor, rotation_part
from tilth.boundaries.surfaces.points import Pose
from tilth.boundaries.surfaces.quadrature import (
    BoundaryQuadrature,
    band_quadrature,
    surface_quadrature,
)
from tilth.errors import BadInput
from tilth.geometry.footing import Footing
from tilth.geometry.plane import Plane
from tilth.geometry.protocol import Geometry, QuadraturePoints
from tilth.geometry.quadrature import make_quadrature
from tilth.model import ImplicitBoundary
from tilth.model.load_curve import LoadCurve

ROUND_OFF = 1e-9
"""Of the components of a unit normal."""

FLAT_FACET_LENGTH = 4.0
"""Length of the facets of a flat fixed boundary, in cells: longer facets need fewer points."""


class Implicit:
    """An implicit boundary with the tractions that it carries from step to step.

    Args:
        declared: the user's declaration.
        key: of the boundary in the case file.
        curve: load curve of its motion.
        geometry: the boundary in the reference configuration.
        motion: its positions at a given factor.
        delta: width of the band [length].
        grid: the grid on which it acts.

    Attributes:
        name: given by the user.
        key: of the boundary in the case file.
        declared: the user's declaration.
        geometry: the boundary in the reference configuration; signed distance, > 0 in the soil.
        motion: its positions at a given factor.
        delta: width of the band [length].
        quadrature: its quadrature points; None before the first `extend_quadrature`.
        carried: stresses of each point for the next step, shape (n, columns): the traction as an
            internal force of the soil [stress], with the band form also the stress of the slip in
            the band (tensor, 9 entries) [stress].
    """

    def __init__(
        self,
        declared: ImplicitBoundary,
        key: str,
        curve: LoadCurve,
        geometry: Geometry,
        motion: Motion,
        delta: float,
        grid: GridProperties,
    ) -> None:
        self.name = declared.name
        self.key = key
        self.declared = declared
        self.geometry = geometry
        self.motion = motion
        self.delta = delta
        self._curve = curve
        self._grid = grid
        dim = grid.at_start.dim
        self._columns = dim if declared.form == "surface" else dim + 9
        self._lower, self._upper = np.full(dim, np.inf), np.full(dim, -np.inf)
        self.quadrature: BoundaryQuadrature | None = None
        self._ends: Ends | None = None
        self.carried: Floats = np.zeros((0, self._columns))

    @property
    def dim(self) -> int:
        """Number of directions."""
        return self._grid.at_start.dim

    @property
    def body_name(self) -> str | None:
        """Name of the rigid body whose surface it is, or None."""
        return None

    def factor(self, time: float) -> float:
        """Returns the factor of the motion at `time` [-]."""
        if not self.declared.is_moving:
            return 0.0
        return self._curve.factor(time)

    def leave(self) -> None:
        """Stores that no soil touches the boundary: its points carry nothing."""
        self.carried = np.zeros_like(self.carried)

    def extend_quadrature(self, lower: Floats, upper: Floats) -> BoundaryQuadrature:
        """Returns the quadrature points, which it first extends to the whole boundary in a box.

        lower, upper: corners of the box in the reference configuration [length], shape (dim,).
        """
        within = (lower >= self._lower).all() and (upper <= self._upper).all()
        if self.quadrature is not None and (self.geometry.bounded or within):
            return self.quadrature
        margin = 0.1 * (upper - lower)
        below, above = self._sizes_at(lower), self._sizes_at(upper)
        self._lower = np.minimum(self._lower, lower - margin - 2.0 * below)
        self._upper = np.maximum(self._upper, upper + margin + 2.0 * above)
        self._make_points()
        assert self.quadrature is not None
        return self.quadrature

    @property
    def _fixed(self) -> bool:
        """Whether it stays where it is in the grid."""
        return not self.declared.is_moving and not self._grid.grid_moves

    def _sizes_at(self, position: Floats) -> Floats:
        """Returns the sizes of the cells there [length]; of a moving boundary the largest."""
        grid = self._grid.at_start
        return grid.sizes_at(position) if self._fixed else grid.largest_size

    def _smallest_edge(self) -> float:
        """Returns that of the cells [length]; of a graded grid those along a flat boundary."""
        grid = self._grid.at_start
        size = grid.cell_size
        turns = self.declared.rotation is not None or self.declared.motion is not None
        keeps_normal = self.body_name is None and not turns
        if grid.graded and keeps_normal and isinstance(self.geometry, (Plane, Footing)):
            size = size[np.abs(self.geometry.normal) <= 1.0 - ROUND_OFF]
        return float(size.min())

    def _make_points(self) -> None:
        before, carried = self.quadrature, self.carried
        grid, fixed = self._grid.at_start, self._fixed
        piece = facet = self._smallest_edge() / (3.0 if grid.dim == 2 else 2.0)
        if fixed and self.geometry.flat:  # facets are cut at grid lines
            facet = (FLAT_FACET_LENGTH if grid.dim == 2 else 1.0) * float(grid.largest_size.min())
        points = make_quadrature(
            self.geometry, self._lower, self._upper, grid, piece, facet, local=fixed
        )
        points = self._kept(points)
        self._ends = self._found_ends(facet)
        make = surface_quadrature if self.declared.form == "surface" else band_quadrature
        self.quadrature = make(points, self.delta)
        self.carried = np.zeros((len(self.quadrature.weight), self._columns))
        if before is not None:
            old, new = _identifiers(before.group), _identifiers(self.quadrature.group)
            _, from_old, to_new = np.intersect1d(old, new, assume_unique=True, return_indices=True)
            assert len(from_old) == len(old), "a part of the boundary is not in the larger region"
            self.carried[to_new] = carried[from_old]

    def _kept(self, points: QuadraturePoints) -> QuadraturePoints:
        """Returns the points that are part of the boundary."""
        if self._grid.axisymmetric:  # a circle around the axis crosses the plane twice
            return points.of(points.position[:, 0] > 0.0)
        return points

    def _found_ends(self, facet: float) -> Ends | None:
        """Returns where the boundary ends; None if nowhere, or if it does not matter.

        It does not if the boundary is too narrow, moves too far or not at all.

        facet: length of the facets [length].
        """
        declared = self.declared
        if not (self.geometry.bounded and declared.is_moving and declared.form == "surface"):
            return None
        cell = self._smallest_edge()
        facets = self.geometry.facets(self._lower, self._upper, facet)
        if width_of(facets) < LEAST_WIDTH * cell:
            return None
        found = find_ends(self.geometry, facets, cell)
        moves = [
            self._positions(found.beyond, factor) - found.beyond for _, factor in self._curve.table
        ]
        farthest = np.linalg.norm(moves, axis=2).max(initial=0.0)
        return found if 0.0 < farthest <= FARTHEST_MOTION * cell else None

    def surface_points(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Returns the surface's quadrature points at `time`: positions, normals, tributary parts.

        Positions [length] and unit normals have the shape (m, dim), the parts [length] the shape
        (m, dim, dim), see `QuadraturePoints`.
        """
        quadrature = self.quadrature
        assert quadrature is not None
        position, normal = quadrature.surface, quadrature.surface_normal
        if not self.declared.is_moving:
            return position, normal, quadrature.tributary
        factor = self.factor(time)
        part = quadrature.tributary @ _transposed(self.motion.gradient(position, factor))
        return self._positions(position, factor), self._normals(position, normal, factor), part

    def ends(self, time: float) -> Ends | None:
        """Returns where the boundary ends at `time`; None if nowhere, or if it does not matter."""
        if self._ends is None:
            return None
        of, factor = self._ends, self.factor(time)
        corner, shape = of.corner.reshape(-1, self.dim), of.corner.shape
        return Ends(
            corner=self._positions(corner, factor).reshape(shape),
            beyond=self._positions(of.beyond, factor),
            normal=self._normals(of.beyond, of.normal, factor),
        )

    def _normals(self, reference: Floats, normal: Floats, factor: float) -> Floats:
        """Returns reference normals at reference positions as they are at a factor, (n, dim)."""
        gradient = self.motion.gradient(reference, factor)
        normal = _transformed(cofactor(gradient), normal)
        return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])

    def _positions(self, reference: Floats, factor: float) -> Floats:
        return self.motion.position(reference, factor) if self.declared.is_moving else reference

    def reference_position(self, position: Floats, time: float) -> Floats:
        """Returns the reference positions of positions at `time` [length], shape (n, dim) each."""
        if not self.declared.is_moving:
            return position
        return self.motion.reference(position, self.factor(time))

    def positions(self, time: float, chosen: Integers) -> Floats:
        """Returns the positions of chosen quadrature points at `time` [length], shape (n, dim)."""
        assert self.quadrature is not None
        return self._positions(self.quadrature.reference[chosen], self.factor(time))

    def weights(self, time: float, chosen: Integers) -> Floats:
        """Returns the weights of chosen quadrature points at `time`, shape (n,).

        Areas [length^(dim - 1)], in axisymmetry with 2 pi r [length^2].
        """
        quadrature, factor = self.quadrature, self.factor(time)
        assert quadrature is not None
        reference, weight = quadrature.reference[chosen], quadrature.weight[chosen]
        if self.declared.is_moving:
            gradient = self.motion.gradient(reference, factor)
            area = _transformed(cofactor(gradient), quadrature.normal[chosen])
            weight = weight * np.linalg.norm(area, axis=1)
        if self._grid.axisymmetric:
            weight = weight * 2.0 * np.pi * np.abs(self._positions(reference, factor)[:, 0])
        return weight

    def pose(self, before: float, after: float, chosen: Integers) -> Pose:
        """Returns the motion of chosen quadrature points in the step from `before` to `after`."""
        quadrature = self.quadrature
        assert quadrature is not None
        start, end = self.factor(before), self.factor(after)
        middle = 0.5 * (start + end)
        reference, normal = quadrature.reference[chosen], quadrature.normal[chosen]
        position = self._positions(reference, start)
        increment = np.zeros(position.shape)
        gradient = np.zeros((*position.shape, position.shape[1]))
        rotation, direction = None, self._direction(len(position))
        if self.declared.is_moving:
            increment = self.motion.position(reference, end) - position
            at_start = self.motion.gradient(reference, start)
            at_middle = self.motion.gradient(reference, middle)
            at_end = self.motion.gradient(reference, end)
            gradient = at_end @ np.linalg.inv(at_start) - np.eye(position.shape[1])
            normal = _transformed(cofactor(at_middle), normal)
            normal = normal / np.linalg.norm(normal, axis=1)[:, None]
            start_to = [rotation_part(g) for g in (at_start, at_middle, at_end)]
            if direction is not None:
                direction = _transformed(start_to[1], direction)
            rotation = (
                start_to[1] @ _transposed(start_to[0]),
                start_to[2] @ _transposed(start_to[1]),
            )
        return Pose(
            position=position,
            increment=increment,
            gradient=gradient,
            normal=normal,
            weight=self.weights(before, chosen),
            direction=direction,
            projector=self._projector(normal, direction),
            rotation=rotation,
        )

    def _direction(self, n: int) -> Floats | None:
        """Returns the declared reference direction, shape (n, dim); None if none is declared."""
        if self.declared.direction is None:
            return None
        direction = np.asarray(self.declared.direction)
        return np.tile(direction / np.linalg.norm(direction), (n, 1))

    def projector_at(self, reference: Floats) -> Floats:
        """Returns projectors on constrained directions at reference positions, (n, dim, dim)."""
        return self._projector(self.geometry.gradient(reference), self._direction(len(reference)))

    def _projector(self, normal: Floats, direction: Floats | None) -> Floats:
        """Returns the projector on the constrained directions, shape (n, dim, dim)."""
        identity = np.eye(normal.shape[1])
        across = normal[:, :, None] * normal[:, None, :]
        if self.declared.condition == "fixed":
            return np.broadcast_to(identity, across.shape)
        if self.declared.condition == "tangential":
            return np.asarray(identity - across)
        if direction is not None:
            return np.asarray(direction[:, :, None] * direction[:, None, :])
        return across

    def require_soil(self, position: Floats) -> None:
        """Checks that some of the points' initial positions (n, dim) are on the soil's side.

        Raises:
            BadInput: all are behind the boundary.
        """
        parts = max(len(position) // 1000, 1)  # soil is soon found, where there is any
        if any((self.geometry.distance(position[i::parts]) >= 0.0).any() for i in range(parts)):
            return
        raise BadInput(
            f"all material is behind the boundary {self.name!r}: its signed distance is "
            "negative everywhere",
            "turn the normal, exchange the sides (soil), or change the function's sign",
            key=f"{self.key}.geometry",
        )

    def distance(self, position: Floats, time: float) -> Floats:
        """Returns signed distances of positions (n, dim) at `time` [length], > 0 in the soil, (n,).

        Measured in the reference configuration.
        """
        return self.geometry.distance(self.reference_position(position, time))

    def penetration(self, position: Floats, time: float) -> float:
        """Returns the greatest distance of positions (n, dim) behind the boundary [length].

        Positions whose nearest point on a finite boundary lies on its edge are left out.
        """
        reference = self.reference_position(position, time)
        distance = self.geometry.distance(reference)
        behind = np.flatnonzero(distance < 0.0)
        if self.quadrature is None or len(behind) == 0:
            return 0.0
        if self.geometry.flat:
            away = self.geometry.gradient(reference[behind])
            foot = reference[behind] - distance[behind, None] * away
            from scipy.spatial import cKDTree

            _, nearest = cKDTree(self.quadrature.reference).query(foot)
            along = np.einsum("ni,ni->n", away, self.quadrature.normal[nearest])
            behind = behind[along > 1.0 - 1e-9]
        return float(-distance[behind].min(initial=0.0))

    def carry_from(self, other: Implicit) -> None:
        """Takes over the tractions of the same boundary on another grid, by nearest points.

        Of points at one place, as on both sides of a thin plate, that with the same normal counts.
        """
        assert other.quadrature is not None
        from scipy.spatial import cKDTree

        self._lower, self._upper = other._lower, other._upper
        self._make_points()
        assert self.quadrature is not None
        cell = float(self._grid.at_start.cell_size.min())
        place = [
            np.concatenate([each.reference, cell * each.normal], axis=1)
            for each in (other.quadrature, self.quadrature)
        ]
        _, nearest = cKDTree(place[0]).query(place[1])
        self.carried = other.carried[nearest]

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {"lower": self._lower, "upper": self._upper, "carried": self.carried}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        lower, upper = state["lower"], state["upper"]
        if len(lower) != len(self._lower) or len(upper) != len(self._upper):
            raise ValueError("'lower' and 'upper' are not of one place")
        self._lower, self._upper = lower, upper
        if len(state["carried"]):
            if not (lower <= upper).all() or not np.isfinite([lower, upper]).all():
                raise ValueError("'lower' is above 'upper', or one is infinite")
            self._make_points()
            require_table({"points": self.carried, "carried": state["carried"]})
            self.carried = state["carried"]


def _identifiers(group: Integers) -> npt.NDArray[np.void]:
    """Returns the identifier of each point: its group and its number among the group's points."""
    order = np.argsort(group, kind="stable")
    ordered = group[order]
    first = np.concatenate([[True], ordered[1:] != ordered[:-1]])
    start = np.maximum.accumulate(np.where(first, np.arange(len(group)), 0))
    identifier = np.empty(len(group), dtype=[("group", np.int64), ("number", np.int64)])
    identifier["group"] = group
    identifier["number"][order] = np.arange(len(group)) - start
    return identifier


def _transformed(matrix: Floats, vector: Floats) -> Floats:
    return np.asarray(np.einsum("nij,nj->ni", matrix, vector))


def _transposed(matrix: Floats) -> Floats:
    return np.swapaxes(matrix, 1, 2)
