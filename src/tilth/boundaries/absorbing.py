# SPDX-License-Identifier: BSD-3-Clause
"""Absorbing boundaries: waves leave through them (Lysmer and Kuhlemeyer 1969).

A boundary is a surface at any position in the grid, that of a plane of the grid too, with the
quadrature points of an implicit boundary. In the search for an equilibrium it holds the soil. When
inertia begins it takes over the forces that hold the soil at rest, and keeps them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats
from tilth.boundaries.implicit.constraint import ImplicitConstraint
from tilth.boundaries.step.make import make
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.errors import BadInput
from tilth.geometry.protocol import QuadraturePoints
from tilth.model import Ground, ImplicitBoundary, Model, PlaneBoundary, PlaneGeometry
from tilth.model.boundaries import Ranges
from tilth.model.fields import AXES
from tilth.model.load_curve import LoadCurve
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.soil import Soil
from tilth.terms.dashpots import Dashpots
from tilth.terms.inertia import Inertia
from tilth.terms.released import Release, ReleasedForces
from tilth.variation.record import Record, read_record

LEAST_SHARE = 1e-6
"""Share of a force across a boundary in that along it, where another boundary may take it."""

NO_SHARE = 1e-9
"""Value of a shape function below which a node does not belong to a point."""


class Absorbing:
    """An absorbing boundary with the forces that it keeps.

    Args:
        declared: the user's declaration.
        surface: its points in the grid; it holds all components.
        record: of its outcrop; None without.
        start: total time at the start of the stage [time].

    Attributes:
        name: given by the user.
        surface: its points in the grid.
        record: of its outcrop; None without.
        begun: whether it has taken over the forces at rest.
    """

    def __init__(
        self,
        declared: PlaneBoundary | ImplicitBoundary,
        surface: Implicit,
        record: Record | None,
        start: float,
    ) -> None:
        self.name, self.surface, self.record = declared.name, surface, record
        self._ground: Ground | None = declared.ground
        self._held = ReleasedForces(surface.dim, LoadCurve(((0.0, 0.0),)))
        self._stage_start, self._begin, self.begun = start, start, False

    def terms(
        self, part: ImplicitConstraint, soil: Soil, mass: Floats, inertia: Inertia,
        before: float, after: float,
    ) -> list[Dashpots | Release]:  # fmt: skip
        """Returns its dashpots and the forces that it keeps in a step.

        part: its points near soil. mass: of the material points [mass], shape (n,).
        """
        compression, shear = self._impedances(part, soil, mass)
        normal = part.pose.normal
        impedance = (compression - shear)[:, None, None] * normal[:, :, None] * normal[:, None]
        impedance = impedance + shear[:, None, None] * np.eye(normal.shape[1])
        impedance *= part.pose.weight[:, None, None]
        outcrop = np.array([self._outcrop(time) for time in (before, after)])
        held = Release(self._held, soil.active, before, after)
        return [Dashpots(self.name, part.at, impedance, outcrop, inertia, held), held]

    def _outcrop(self, time: float) -> Floats:
        if self.record is None:
            return np.zeros(self.surface.dim)
        return self.record.velocity_at(self._stage_start + time - self._begin)

    def _impedances(
        self, part: ImplicitConstraint, soil: Soil, mass: Floats
    ) -> tuple[Floats, Floats]:
        """Returns rho c_p and rho c_s at its points [force time/length^3], shape (n,) each."""
        if (ground := self._ground) is not None:
            ones = np.ones(len(part.chosen))
            return (
                ground.density * ground.p_wave_speed * ones,
                ground.density * ground.s_wave_speed * ones,
            )
        points = soil.points
        moduli, volume = points.elastic_moduli(), points.initial_volume
        of_points = np.column_stack([volume, mass, volume * moduli.constrained])
        sums = soil.scatter(np.column_stack([of_points, volume * moduli.shear]))
        sums = soil.active.updated(sums)
        nearby = part.at.interpolate(np.ascontiguousarray(sums))
        volume_there, mass_there, constrained, shear = nearby.T
        density = mass_there / volume_there
        return (
            np.sqrt(density * constrained / volume_there),
            np.sqrt(density * shear / volume_there),
        )

    def nodes(self, part: ImplicitConstraint, active: ActiveGrid) -> Flags:
        """Returns the nodes on which it acts, shape (nodes,)."""
        found = np.zeros(active.nodes, dtype=bool)
        takes_part = np.add.reduceat(np.abs(part.at.value), part.at.start[:-1], axis=0) > NO_SHARE
        found[part.at.node[takes_part]] = True
        return found

    def shares(self, part: ImplicitConstraint, active: ActiveGrid) -> Floats:
        """Returns weights of its part in the forces of nodes [length^(dim - 1)], (nodes, dim).

        Where several boundaries meet each takes what acts along its normal.
        """
        along = part.pose.normal**2 + LEAST_SHARE
        found = part.at.scatter(part.pose.weight[:, None] * along, active.nodes)
        return np.asarray(np.maximum(found, LEAST_SHARE * found.max()))

    def keep(self, active: ActiveGrid, force: Floats) -> None:
        """Keeps forces on the soil from now on [force], shape (nodes, dim)."""
        self._held.set(active, force)
        self.begun = True

    def kept(self, active: ActiveGrid) -> Floats:
        """Returns the forces that it keeps on the nodes of a grid [force], shape (nodes, dim)."""
        return Release(self._held, active, 0.0, 0.0).load_before()

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        own = {"begin": np.array([self._begin]), "begun": np.array([self.begun])}
        return self._held.state() | own

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        if state["begin"].shape != (1,) or state["begun"].shape != (1,):
            raise ValueError("'begin' is not one time")
        self._held.restore({name: state[name] for name in self._held.state()})
        self._begin, self.begun = float(state["begin"][0]), bool(state["begun"][0])


class _OnPlane(Implicit):
    """The surface of a plane of the grid, or of a part of it."""

    ranges: Ranges | None = None

    def _kept(self, points: QuadraturePoints) -> QuadraturePoints:
        points = super()._kept(points)
        inside = np.ones(len(points.position), dtype=bool)
        for axis, (low, high) in (self.ranges or {}).items():
            along = points.position[:, AXES.index(axis)]
            inside &= (along >= low) & (along <= high)
        return points.of(inside)


def make_absorbing(model: Model, position: Floats) -> list[Absorbing]:
    """Returns the absorbing boundaries of a model; position: of the soil's points, (n, dim).

    Raises:
        BadInput: a file of a boundary cannot be used, or soil lies on both sides of a plane.
    """
    found = []
    keys = model.boundary_keys()
    for declared in model.boundaries:
        if not isinstance(declared, PlaneBoundary | ImplicitBoundary):
            continue
        if declared.condition != "absorbing":
            continue
        record = None
        if declared.acceleration is not None:
            key = f"{keys[declared.name]}.acceleration"
            record = read_record(declared.acceleration, model.dimension, key)
        if isinstance(declared, PlaneBoundary):
            surface = _plane(declared, model, position, keys[declared.name])
        else:
            surface = make(declared.model_copy(update={"condition": "fixed"}), model)
        found.append(Absorbing(declared, surface, record, model.stage.start))
    return found


def _plane(declared: PlaneBoundary, model: Model, position: Floats, key: str) -> Implicit:
    axis = AXES.index(declared.axis)
    beside = position[:, axis] - declared.at
    if beside.min() < 0.0 < beside.max():
        raise BadInput(
            f"soil lies on both sides of the absorbing boundary {declared.name!r}",
            "move it to the outer face of the soil",
            key=f"{key}.at",
            value=declared.at,
        )
    point, normal = np.zeros(model.dimension), np.zeros(model.dimension)
    point[axis], normal[axis] = declared.at, 1.0 if beside.max() > 0.0 else -1.0
    geometry = PlaneGeometry(point=tuple(point.tolist()), normal=tuple(normal.tolist()))
    flat = ImplicitBoundary(name=declared.name, geometry=geometry, condition="fixed")
    surface = make(flat, model, _OnPlane)
    assert isinstance(surface, _OnPlane)
    surface.ranges = declared.range
    return surface
