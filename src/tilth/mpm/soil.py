# SPDX-License-Identifier: BSD-3-Clause
"""The soil's answer to a nodal displacement: stress update, internal force, stiffness.

Every method loops over the bodies and hands flat arrays to a kernel of the core.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.mpm.domains import keep_off_axis
from tilth.mpm.f_bar import Centres
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.timers import Timers

_FAILURES = {
    1: "a material point inverted (det F <= 0)",
    2: "the return mapping of a material point did not converge",
}

_FOLDED = "the domain of a material point folded or inverted"
_UNFOLDED = 'the domains of basis = "cpdi1" and "gimp" cannot fold: choose one of them for {!r}'


@dataclass
class _Trial:
    """What a trial displacement makes of the points; each array has one row per point.

    Attributes:
        elastic: elastic left Cauchy-Green tensor less the identity [-].
        plastic, state: as those of `MaterialPoints`.
        response: what forces and stiffness need (kernel/response.hpp).
    """

    elastic: Floats
    plastic: Floats
    state: Floats
    response: Floats

    @classmethod
    def of(cls, points: MaterialPoints, kind: str) -> _Trial:
        """Returns arrays for these points."""
        return cls(
            elastic=np.empty_like(points.elastic_deformation),
            plastic=np.empty_like(points.plastic),
            state=np.zeros_like(points.state),  # not every material writes all columns
            response=np.empty((len(points), _core.response_size(kind))),
        )


class Soil:
    """Material points together with the trial state of the current step.

    Args:
        points: the points; changed by `advance` only.
        kind: "plane_strain", "axisymmetric" or "3d".
        timers: where the time of the kernels is booked.
    """

    def __init__(self, points: MaterialPoints, kind: str, timers: Timers) -> None:
        self.points = points
        self.kind = kind
        self._timers = timers
        self._kept: _Trial | None = None
        self._active: ActiveGrid | None = None
        self._centres: list[Centres | None] = []
        self._weighed: tuple[ActiveGrid, Floats] | None = None

    @property
    def _trial(self) -> _Trial:
        """The trial state; between the steps there is none, nor does it take memory."""
        if self._kept is None:
            self._kept = _Trial.of(self.points, self.kind)
        return self._kept

    def update(self, active: ActiveGrid, displacement: Floats) -> None:
        """Updates the trial state for the step's nodal displacement [length], (nodes, dim).

        Raises:
            StepFailed: if a point inverts or its return mapping fails.
        """
        points, trial = self.points, self._trial
        self._find_centres(active)
        with self._timers.measure("stress"):
            for body, stencil, centres in zip(
                points.bodies, active.stencils, self._centres, strict=True
            ):
                s = slice(body.start, body.stop)
                if centres is not None:
                    centres.update(displacement)
                point, status = _core.stress_update(
                    self.kind, body.law.name, body.parameters, stencil, displacement,
                    points.position[s], points.elastic_deformation[s], points.plastic[s],
                    points.state[s], trial.elastic[s], trial.plastic[s], trial.state[s],
                    trial.response[s], centres,
                )  # fmt: skip
                if status:
                    number = int(points.point_id[body.start + point])
                    raise StepFailed(_FAILURES[status], point=number)

    def _find_centres(self, active: ActiveGrid) -> None:
        """Finds the centres of F-bar, once on each grid."""
        if self._active is active:
            return
        self._active = active
        with self._timers.measure("basis"):
            self._centres = [
                Centres.of(self.points.part(body), stencil, active, self.kind)
                if body.anti_locking == "f_bar"
                else None
                for body, stencil in zip(self.points.bodies, active.stencils, strict=True)
            ]

    def _volumes(self) -> list[Floats]:
        """Returns what the Kirchhoff stress of each body's points acts on: V0 J / J_bar."""
        volumes = []
        for body, centres in zip(self.points.bodies, self._centres, strict=True):
            volume = self.points.initial_volume[body.start : body.stop]
            volumes.append(volume if centres is None else volume * centres.after)
        return volumes

    def internal_force(self, active: ActiveGrid) -> Floats:
        """Returns the internal force of the trial state [force], shape (nodes, dim)."""
        force = np.zeros((active.nodes, active.grid.dim))
        with self._timers.measure("assembly"):
            for body, stencil, volume in zip(
                self.points.bodies, active.stencils, self._volumes(), strict=True
            ):
                s = slice(body.start, body.stop)
                _core.internal_force(
                    self.kind, stencil, volume, self.points.position[s],
                    self._trial.response[s], force,
                )  # fmt: skip
        return force

    def add_stiffness(self, active: ActiveGrid, matrix: Floats) -> None:
        """Adds the derivative of the force to `matrix` (blocks, dim, dim) [force/length]."""
        with self._timers.measure("assembly"):
            for body, stencil, (start, position), volume, centres in zip(
                self.points.bodies, active.stencils, active.block_positions, self._volumes(),
                self._centres, strict=True,
            ):  # fmt: skip
                s = slice(body.start, body.stop)
                _core.stiffness(
                    self.kind, stencil, start, position,
                    volume, self.points.position[s], self._trial.response[s],
                    matrix, centres,
                )  # fmt: skip

    def scatter(self, active: ActiveGrid, vector: Floats) -> Floats:
        """Returns sum_p S_ap vector_p of a quantity of the points, (n, k) -> (nodes, k)."""
        nodal = np.zeros((active.nodes, *vector.shape[1:]))
        with self._timers.measure("assembly"):
            for body, stencil in zip(self.points.bodies, active.stencils, strict=True):
                part = np.ascontiguousarray(vector[body.start : body.stop], dtype=np.float64)
                _core.scatter(stencil, part, nodal)
        return nodal

    def nodal_volume(self, active: ActiveGrid) -> Floats:
        """Returns the volume that the points give each node at the start of the step, (nodes,)."""
        if self._weighed is None or self._weighed[0] is not active:
            self._weighed = (active, self.scatter(active, self.points.volume))
        return self._weighed[1]

    def yielding_nodes(self, active: ActiveGrid) -> npt.NDArray[np.bool_]:
        """Returns the nodes of points that yield in the trial state, shape (nodes,)."""
        yielding = self._trial.plastic[:, :1] > self.points.plastic[:, :1]
        if not yielding.any():
            return np.zeros(active.nodes, dtype=bool)
        return np.asarray(self.scatter(active, yielding.astype(np.float64))[:, 0] > 0.0)

    def interpolate(self, active: ActiveGrid, nodal: Floats) -> Floats:
        """Returns sum_a S_ap nodal_a at the points, shape (n, dim)."""
        vector = np.empty((len(self.points), nodal.shape[1]))
        for body, stencil in zip(self.points.bodies, active.stencils, strict=True):
            _core.interpolate(stencil, nodal, vector[body.start : body.stop])
        return vector

    def advance(
        self,
        active: ActiveGrid,
        displacement: Floats,
        corners: dict[int, tuple[Floats, Floats]],
    ) -> None:
        """Makes the trial state the state of the points and moves them with the grid.

        corners: what `moved_corners` returns for this displacement.
        """
        points = self.points
        with self._timers.measure("rest"):
            for body in points.bodies:
                if body.domain_update == "corners":
                    part = points.part(body)
                    _core.move_domain_faces(
                        part.position, active.key, displacement, active.grid.origin,
                        active.grid.cell_size, part.half_length,
                    )  # fmt: skip
            for body, stencil in zip(points.bodies, active.stencils, strict=True):
                part = points.part(body)
                s = slice(body.start, body.stop)
                _core.advance(
                    self.kind, stencil, displacement, part.position, self._trial.response[s],
                    part.plastic, self._trial.plastic[s], part.last_gradient,
                    part.deformation_gradient, part.stress, part.elastic_share,
                )  # fmt: skip
                _core.interpolate(stencil, displacement, part.last_displacement)
            for number, (corner, shift) in corners.items():
                body = points.bodies[number]
                points.corner[body.start : body.stop] = corner
                points.last_displacement[body.start : body.stop] = shift
            points.position += points.last_displacement
            points.displacement += points.last_displacement
            for body, centres in zip(points.bodies, self._centres, strict=True):
                if centres is not None:
                    points.assumed_jacobian[body.start : body.stop] *= centres.jacobian
                    points.stress[body.start : body.stop] *= centres.after[:, None]
                    self._level(body, active, centres)
            self._active = self._weighed = None  # the points have moved
            points.elastic_deformation = self._trial.elastic
            points.plastic, points.state = self._trial.plastic, self._trial.state
            self._kept = None
            for body in points.bodies:
                if body.has_corners:
                    if body.carried_by_gradient:
                        self._carry_corners(body)
                    continue
                # basis "linear" has no domains: boxes for pictures and to find what touches
                rule = body.domain_update or "right_stretch"
                if rule not in ("fixed", "corners"):
                    part = points.part(body)
                    _core.stretch_domains(
                        self.kind, rule, part.deformation_gradient,
                        part.initial_half_length, part.half_length,
                    )  # fmt: skip
            points.box_corners()

    def _carry_corners(self, body: PointRange) -> None:
        part = self.points.part(body)
        part.corner[:] = part.carried_corners()
        if self.kind == "axisymmetric":
            keep_off_axis(part)

    def moved_corners(
        self, active: ActiveGrid, displacement: Floats
    ) -> dict[int, tuple[Floats, Floats]]:
        """Returns the domains of bodies whose corners move with the grid (CPDI2), by body.

        Corners seen from the point, shape (n, 2^dim, dim), and the motion of the points, which
        stay the centroids of their domains, shape (n, dim) [length].

        Raises:
            StepFailed: if a domain folds or inverts.
        """
        found = {}
        for number, body in enumerate(self.points.bodies):
            if body.basis != "cpdi2":
                continue
            part = self.points.part(body)
            moved, shift = np.empty_like(part.corner), np.empty_like(part.position)
            folded = _core.move_corners(
                part.position, part.corner, active.key, displacement, active.grid.origin,
                active.grid.cell_size, self.kind == "axisymmetric", moved, shift,
            )  # fmt: skip
            if folded >= 0:
                remedy = _UNFOLDED.format(body.name)
                raise StepFailed(_FOLDED, remedy, point=int(part.point_id[folded]))
            found[number] = (moved, shift)
        return found

    def _level(self, body: PointRange, active: ActiveGrid, centres: Centres) -> None:
        """Lets the volumetric strains of points that flow go towards those of their cells."""
        s, points = slice(body.start, body.stop), self.points
        elastic, jacobian = self._trial.elastic[s], points.assumed_jacobian[s]
        flow = self._trial.plastic[s, 0] - points.plastic[s, 0]
        if not flow.any():
            return
        stencil = active.stencils[self.points.bodies.index(body)]
        volume, volumetric = points.part(body).volume, _core.volumetric_strains(elastic)
        nodal = np.zeros((active.nodes, 2))
        _core.scatter(stencil, np.column_stack([volume, volume * volumetric]), nodal)
        smooth = np.empty((len(volume), 1))
        _core.interpolate(stencil, nodal[:, 1:] / np.maximum(nodal[:, :1], 1e-300), smooth)
        change = centres.level(volumetric - smooth[:, 0], volume, flow)
        moved = np.flatnonzero(change)
        if len(moved) == 0:
            return
        trial = elastic[moved]
        identity = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        trial += np.expm1(2.0 / 3.0 * change[moved])[:, None] * (trial + identity)
        # a law whose strength depends on the pressure returns the stress to its yield surface
        state, plastic = self._trial.state[s], self._trial.plastic[s]
        returned, flown, stress = (
            np.empty_like(a) for a in (trial, plastic[moved], points.stress[s][moved])
        )
        state_after, good = state[moved], np.empty(len(moved), dtype=bool)
        _core.return_to_law(
            self.kind, body.law.name, body.parameters, trial, plastic[moved], state[moved],
            returned, flown, state_after, stress, good,
        )  # fmt: skip
        moved = moved[good]
        elastic[moved], plastic[moved], state[moved] = (
            returned[good],
            flown[good],
            state_after[good],
        )
        jacobian[moved] *= np.exp(change[moved])
        points.stress[s][moved] = stress[good] / jacobian[moved, None]
