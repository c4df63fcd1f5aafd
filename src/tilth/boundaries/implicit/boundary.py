# SPDX-License-Identifier: BSD-3-Clause
"""Implicit boundaries: essential conditions anywhere, independent of the grid's lines.

A boundary has quadrature points that stay with it for ever. In each step those that touch soil
hold the grid's displacement by the implicit boundary method (Kumar et al. 2008; Cortis et al.
2018; docs/theory/implicit_boundaries.md), and each carries the boundary's traction over to the
next step, so that the boundary does not have to slip anew in every step to build it up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.boundaries.implicit.motion import Motion, cofactor, rotation_part
from tilth.errors import BadInput
from tilth.geometry.protocol import Geometry, QuadraturePoints
from tilth.geometry.quadrature import SEGMENT, make_quadrature
from tilth.model import ImplicitBoundary
from tilth.model.load_curve import LoadCurve

LONG_FACETS = 4.0
"""Length of the facets of a flat boundary at rest, in cells: fewer edges, fewer points."""


@dataclass(frozen=True)
class BoundaryQuadrature:
    """Where and how strongly a boundary acts: n quadrature points, of its surface or its band.

    With the distance s from the boundary, d = 1 - (1 - s / delta)^2 the Dirichlet function and d'
    its derivative.

    Attributes:
        reference: places at rest [length], shape (n, dim).
        normal: at rest, unit, into the soil, shape (n, dim).
        weight: area, or volume of the band, at rest [length^(dim - 1)], [length^dim], shape (n,).
        surface, surface_normal: the surface's own quadrature points [length], and normals.
        part: of the surface that each of its points stands for, see `QuadraturePoints`.
        on_surface: the surface point that each belongs to, shape (n,).
        d: Dirichlet function [-], shape (n,).
        d_prime: its derivative [1/length], shape (n,); 0 leaves K2 out.
        square: the factor of K3 [1/length^2], or [1/length] on the surface, shape (n,).
        patch: permanent number of the patch of the surface, shape (n,).
    """

    reference: Floats
    normal: Floats
    weight: Floats
    surface: Floats
    surface_normal: Floats
    part: Floats
    on_surface: Integers
    d: Floats
    d_prime: Floats
    square: Floats
    patch: Integers


def surface_quadrature(points: QuadraturePoints, delta: float) -> BoundaryQuadrature:
    """Returns the limit of a narrow band: K3 alone, with the integral 4 / (3 delta) of d'^2."""
    n = len(points.weight)
    return BoundaryQuadrature(
        reference=points.position,
        normal=points.normal,
        weight=points.weight,
        surface=points.position,
        surface_normal=points.normal,
        part=points.part,
        on_surface=np.arange(n),
        d=np.zeros(n),
        d_prime=np.zeros(n),
        square=np.full(n, 4.0 / (3.0 * delta)),
        patch=points.patch,
    )


def band_quadrature(points: QuadraturePoints, delta: float) -> BoundaryQuadrature:
    """Returns all three parts of the stiffness, by Gauss's three points across the band."""
    n = len(points.weight)
    share, weight = SEGMENT
    surface = np.repeat(np.arange(n), len(share))
    s = np.tile(share, n)
    d_prime = 2.0 * (1.0 - s) / delta
    normal = points.normal[surface]
    return BoundaryQuadrature(
        reference=points.position[surface] + (delta * s)[:, None] * normal,
        normal=normal,
        weight=points.weight[surface] * delta * np.tile(weight, n),
        surface=points.position,
        surface_normal=points.normal,
        part=points.part,
        on_surface=surface,
        d=1.0 - (1.0 - s) ** 2,
        d_prime=d_prime,
        square=d_prime**2,
        patch=points.patch[surface],
    )


@dataclass(frozen=True)
class Surroundings:
    """What an implicit boundary must know of the analysis that it is in.

    Attributes:
        origin: a node of the grid [length], shape (dim,).
        cell_size: [length], shape (dim,).
        axisymmetric: whether x is the radius.
        grid_moves: whether the grid follows a boundary.
    """

    origin: Floats
    cell_size: Floats
    axisymmetric: bool
    grid_moves: bool


@dataclass(frozen=True)
class Pose:
    """Quadrature points of a boundary in one step: places at its start, directions in its middle.

    Attributes:
        place: at the start of the step [length], shape (n, dim).
        increment: prescribed displacement in the step [length], shape (n, dim).
        gradient: of the prescribed displacement by `place` [-], shape (n, dim, dim).
        normal: unit, into the soil, shape (n, dim).
        weight: at the start of the step, 2 pi r included in axisymmetry, shape (n,).
        direction: the declared direction, unit, shape (n, dim); None where none is declared.
        projector: on the constrained directions, shape (n, dim, dim).
        turn: rotations from the start to the middle and from there to the end of the step,
            shape (n, dim, dim) each; None where nothing turns.
    """

    place: Floats
    increment: Floats
    gradient: Floats
    normal: Floats
    weight: Floats
    direction: Floats | None
    projector: Floats
    turn: tuple[Floats, Floats] | None


class Implicit:
    """An implicit boundary with the tractions that it carries from step to step.

    Args:
        declared: the user's declaration.
        key: where it stands in the case file.
        curve: how its motion grows.
        geometry: the boundary at rest.
        motion: where its places are at a given factor.
        delta: width of the band [length].
        surroundings: of the analysis.

    Attributes:
        name: the user's.
        key: where it stands in the case file.
        declared: the declaration.
        geometry: the boundary at rest; signed distance, > 0 in the soil.
        motion: where its places are at a given factor.
        delta: width of the band [length].
        quadrature: its quadrature points; none before the first `cover`.
        carried: what each of them carries to the next step, shape (n, columns): the traction
            on the soil's force side [stress], with the paper's full form also the stress that
            the slip leaves in the band (tensor, 9 entries).
    """

    def __init__(
        self,
        declared: ImplicitBoundary,
        key: str,
        curve: LoadCurve,
        geometry: Geometry,
        motion: Motion,
        delta: float,
        surroundings: Surroundings,
    ) -> None:
        self.name = declared.name
        self.key = key
        self.declared = declared
        self.geometry = geometry
        self.motion = motion
        self.delta = delta
        self._curve = curve
        self._surroundings = surroundings
        dim = len(surroundings.origin)
        self._columns = dim if declared.form == "surface" else dim + 9
        self._lower, self._upper = np.full(dim, np.inf), np.full(dim, -np.inf)
        self.quadrature: BoundaryQuadrature | None = None
        self.carried: Floats = np.zeros((0, self._columns))

    def factor(self, time: float) -> float:
        """Returns the factor of the motion at `time` [-]."""
        if not self.declared.is_moving:
            return 0.0
        return self._curve.factor(time)

    def cover(self, lower: Floats, upper: Floats) -> BoundaryQuadrature:
        """Makes sure that quadrature points exist wherever the boundary meets a box; returns them.

        lower, upper: corners in the boundary's own frame [length], shape (dim,).
        """
        within = (lower >= self._lower).all() and (upper <= self._upper).all()
        if self.quadrature is not None and (self.geometry.bounded or within):
            return self.quadrature
        cell = self._surroundings.cell_size
        margin = 0.1 * (upper - lower) + 2.0 * cell
        self._lower = np.minimum(self._lower, lower - margin)
        self._upper = np.maximum(self._upper, upper + margin)
        self._make_points()
        assert self.quadrature is not None
        return self.quadrature

    def _make_points(self) -> None:
        before, carried = self.quadrature, self.carried
        cell = self._surroundings.cell_size
        least = float(cell.min())
        piece = facet = least / (3.0 if len(cell) == 2 else 2.0)
        if not self.declared.is_moving and not self._surroundings.grid_moves and self.geometry.flat:
            facet = (LONG_FACETS if len(cell) == 2 else 1.0) * least  # the grid's lines cut them
        points = make_quadrature(
            self.geometry,
            self._lower,
            self._upper,
            self._surroundings.origin,
            cell,
            piece,
            facet,
        )
        if self._surroundings.axisymmetric:  # a circle around the axis is there twice
            points = points.of(points.position[:, 0] > 0.0)
        make = surface_quadrature if self.declared.form == "surface" else band_quadrature
        self.quadrature = make(points, self.delta)
        self.carried = np.zeros((len(self.quadrature.weight), self._columns))
        if before is not None:
            old, new = _numbered(before.patch), _numbered(self.quadrature.patch)
            _, from_old, to_new = np.intersect1d(old, new, assume_unique=True, return_indices=True)
            assert len(from_old) == len(old), "a larger region lost a part of the boundary"
            self.carried[to_new] = carried[from_old]

    def surface_places(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Returns where the surface's points are at `time` [length], and normals, (n, dim) each.

        The third: the parts that they stand for [length], shape (n, dim, dim).
        """
        quadrature = self.quadrature
        assert quadrature is not None
        factor = self.factor(time)
        normal, part = quadrature.surface_normal, quadrature.part
        if self.declared.is_moving:
            gradient = self.motion.gradient(quadrature.surface, factor)
            normal = _transformed(cofactor(gradient), normal)
            normal = normal / np.linalg.norm(normal, axis=1)[:, None]
            part = part @ _transposed(gradient)
        return self._places(quadrature.surface, factor), normal, part

    def _places(self, reference: Floats, factor: float) -> Floats:
        return self.motion.place(reference, factor) if self.declared.is_moving else reference

    def at_rest(self, place: Floats, time: float) -> Floats:
        """Returns where places at `time` are in the boundary's own frame [length], (n, dim)."""
        if not self.declared.is_moving:
            return place
        return self.motion.reference(place, self.factor(time))

    def places(self, time: float, chosen: Integers) -> Floats:
        """Returns where some quadrature points are at `time` [length], shape (n, dim)."""
        assert self.quadrature is not None
        return self._places(self.quadrature.reference[chosen], self.factor(time))

    def pose(self, before: float, after: float, chosen: Integers) -> Pose:
        """Returns where some quadrature points are in the step from time `before` to `after`."""
        quadrature = self.quadrature
        assert quadrature is not None
        start, end = self.factor(before), self.factor(after)
        middle = 0.5 * (start + end)
        reference, normal = quadrature.reference[chosen], quadrature.normal[chosen]
        weight = quadrature.weight[chosen]
        place = self._places(reference, start)
        increment = np.zeros(place.shape)
        gradient = np.zeros((*place.shape, place.shape[1]))
        turn, direction = None, self._direction(len(place))
        if self.declared.is_moving:
            increment = self.motion.place(reference, end) - place
            at_start = self.motion.gradient(reference, start)
            at_middle = self.motion.gradient(reference, middle)
            at_end = self.motion.gradient(reference, end)
            gradient = at_end @ np.linalg.inv(at_start) - np.eye(place.shape[1])
            weight = weight * np.linalg.norm(_transformed(cofactor(at_start), normal), axis=1)
            normal = _transformed(cofactor(at_middle), normal)
            normal = normal / np.linalg.norm(normal, axis=1)[:, None]
            turns = [rotation_part(g) for g in (at_start, at_middle, at_end)]
            if direction is not None:
                direction = _transformed(turns[1], direction)
            turn = (turns[1] @ _transposed(turns[0]), turns[2] @ _transposed(turns[1]))
        if self._surroundings.axisymmetric:
            weight = weight * 2.0 * np.pi * np.abs(place[:, 0])
        return Pose(
            place=place,
            increment=increment,
            gradient=gradient,
            normal=normal,
            weight=weight,
            direction=direction,
            projector=self._projector(normal, direction),
            turn=turn,
        )

    def _direction(self, n: int) -> Floats | None:
        """Returns the constrained direction at rest for n places, if one is declared."""
        if self.declared.direction is None:
            return None
        direction = np.asarray(self.declared.direction)
        return np.tile(direction / np.linalg.norm(direction), (n, 1))

    def projector_at(self, reference: Floats) -> Floats:
        """Returns the projector on the constrained directions at places on it at rest."""
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
        """Checks that some of the points at rest, (n, dim), are on the soil's side.

        Raises:
            BadInput: all are behind the boundary.
        """
        if (self.geometry.distance(position) < 0.0).all():
            raise BadInput(
                f"all material is behind the boundary {self.name!r}: its signed distance is "
                "negative everywhere",
                "turn the normal, exchange the sides (soil), or change the function's sign",
                key=f"{self.key}.geometry",
            )

    def distance(self, place: Floats, time: float) -> Floats:
        """Returns the signed distance of places from the boundary at rest, > 0 in the soil."""
        return self.geometry.distance(self.at_rest(place, time))

    def penetration(self, place: Floats, time: float) -> float:
        """Returns how far the deepest of the places (n, dim) is behind the boundary [length].

        Places beside a finite boundary, whose nearest place on it is an edge, do not count.
        """
        at_rest = self.at_rest(place, time)
        distance = self.geometry.distance(at_rest)
        behind = np.flatnonzero(distance < 0.0)
        if self.quadrature is None or len(behind) == 0:
            return 0.0
        if self.geometry.flat:
            away = self.geometry.gradient(at_rest[behind])
            foot = at_rest[behind] - distance[behind, None] * away
            from scipy.spatial import cKDTree

            _, nearest = cKDTree(self.quadrature.reference).query(foot)
            along = np.einsum("ni,ni->n", away, self.quadrature.normal[nearest])
            behind = behind[along > 1.0 - 1e-9]
        return float(-distance[behind].min(initial=0.0))

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns what a checkpoint must hold."""
        return {"lower": self._lower, "upper": self._upper, "carried": self.carried}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Goes on from the state of a checkpoint."""
        self._lower, self._upper = state["lower"], state["upper"]
        if len(state["carried"]):
            self._make_points()
            self.carried = state["carried"]


def _numbered(patch: Integers) -> npt.NDArray[np.void]:
    """Returns the name of each point: its patch, and which of the patch's points it is."""
    order = np.argsort(patch, kind="stable")
    ordered = patch[order]
    first = np.concatenate([[True], ordered[1:] != ordered[:-1]])
    start = np.maximum.accumulate(np.where(first, np.arange(len(patch)), 0))
    name = np.empty(len(patch), dtype=[("patch", np.int64), ("number", np.int64)])
    name["patch"] = patch
    name["number"][order] = np.arange(len(patch)) - start
    return name


def _transformed(matrix: Floats, vector: Floats) -> Floats:
    return np.asarray(np.einsum("nij,nj->ni", matrix, vector))


def _transposed(matrix: Floats) -> Floats:
    return np.swapaxes(matrix, 1, 2)
