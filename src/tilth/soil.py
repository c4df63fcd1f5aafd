# SPDX-License-Identifier: BSD-3-Clause
"""The soil's answer to a nodal displacement: stress update, internal force, stiffness.

Every method loops over the bodies and hands flat arrays to a kernel of the core. The arrays of
the trial state are allocated once and reused by all steps.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.domains import keep_off_axis
from tilth.errors import StepFailed
from tilth.f_bar import Centres
from tilth.grid import ActiveGrid
from tilth.points import MaterialPoints, PointRange
from tilth.timers import Timers

Floats = npt.NDArray[np.float64]

_FAILURES = {
    1: "a material point inverted (det F <= 0)",
    2: "the return mapping of a material point did not converge",
}

_FOLDED = "the domain of a material point folded or inverted"
_UNFOLDED = 'the domains of basis = "cpdi1" and "gimp" cannot fold: choose one of them for {!r}'


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
        n = len(points)
        self._deformation = np.empty((n, 6))
        self._increment = np.empty((n, 9))
        self._strain = np.empty((n, 6))
        self._plastic = np.empty((n, 2))
        self._state = np.zeros_like(points.state)  # not every material writes all columns
        self._response = np.empty((n, _core.response_size(kind)))
        self._active: ActiveGrid | None = None
        self._centres: list[Centres | None] = []
        self._weighed: tuple[ActiveGrid, Floats] | None = None

    def begin_step(self) -> None:
        """Prepares what depends on the state at the start of the step; points must be sorted."""
        with self._timers.measure("stress"):
            _core.elastic_deformation(self.kind, self.points.elastic_strain, self._deformation)

    def update(self, active: ActiveGrid, displacement: Floats) -> None:
        """Updates the trial state for the step's nodal displacement [length], (nodes, dim).

        Raises:
            StepFailed: if a point inverts or its return mapping fails.
        """
        points = self.points
        self._find_centres(active)
        with self._timers.measure("stress"):
            for body, stencil, centres in zip(
                points.bodies, active.stencils, self._centres, strict=True
            ):
                s = slice(body.start, body.stop)
                if centres is not None:
                    centres.update(displacement)
                point, status = _core.stress_update(
                    self.kind, body.material, body.parameters, stencil, displacement,
                    points.position[s], self._deformation[s], points.plastic[s], points.state[s],
                    self._increment[s], self._strain[s], self._plastic[s], self._state[s],
                    self._response[s], centres,
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
                    self._response[s], force,
                )  # fmt: skip
        return force

    def stiffness(self, active: ActiveGrid, matrix: Floats) -> None:
        """Fills `matrix` (blocks, dim, dim) with the derivative of the force [force/length]."""
        with self._timers.measure("assembly"):
            matrix.fill(0.0)
            for body, stencil, (start, position), volume, centres in zip(
                self.points.bodies, active.stencils, active.block_positions, self._volumes(),
                self._centres, strict=True,
            ):  # fmt: skip
                s = slice(body.start, body.stop)
                _core.stiffness(
                    self.kind, stencil, start, position,
                    volume, self.points.position[s], self._response[s],
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
        yielding = self._plastic[:, :1] > self.points.plastic[:, :1]
        if not yielding.any():
            return np.zeros(active.nodes, dtype=bool)
        return np.asarray(self.scatter(active, yielding.astype(np.float64))[:, 0] > 0.0)

    def interpolate(self, active: ActiveGrid, nodal: Floats) -> Floats:
        """Returns sum_a S_ap nodal_a at the points, shape (n, dim)."""
        vector = np.empty((len(self.points), nodal.shape[1]))
        for body, stencil in zip(self.points.bodies, active.stencils, strict=True):
            _core.interpolate(stencil, nodal, vector[body.start : body.stop])
        return vector

    def advance(self, active: ActiveGrid, displacement: Floats) -> None:
        """Makes the trial state the state of the points and moves them with the grid."""
        points = self.points
        with self._timers.measure("rest"):
            for body in points.bodies:
                if body.domain_update == "corners":
                    part = points.part(body)
                    _core.move_domain_faces(
                        part.position, active.key, displacement, active.grid.origin,
                        active.grid.cell_size, part.half_length,
                    )  # fmt: skip
            corners = self.moved_corners(active, displacement)
            moved = self.interpolate(active, displacement)
            for number, (corner, shift) in corners.items():
                body = points.bodies[number]
                points.corner[body.start : body.stop] = corner
                moved[body.start : body.stop] = shift
            points.position += moved
            points.displacement += moved
            points.last_displacement[:] = moved
            for i, j in np.ndindex(points.last_gradient.shape[1:]):
                points.last_gradient[:, i, j] = self._increment[:, 3 * i + j] - float(i == j)
            _core.advance(
                self.kind, self._increment, self._response, points.deformation_gradient,
                points.stress,
            )  # fmt: skip
            for body, centres in zip(points.bodies, self._centres, strict=True):
                if centres is not None:
                    points.assumed_jacobian[body.start : body.stop] *= centres.jacobian
                    points.stress[body.start : body.stop] *= centres.after[:, None]
                    self._level(body, active, centres)
            self._active = self._weighed = None  # the points have moved
            points.elastic_share = self._elastic_share()
            points.elastic_strain, self._strain = self._strain, points.elastic_strain
            points.plastic, self._plastic = self._plastic, points.plastic
            points.state, self._state = self._state, points.state
            for body in points.bodies:
                if body.has_corners:
                    if body.basis == "cpdi1":
                        self._carry_corners(body)
                    continue
                # the boxes of linear points are followed for the eye, and for what they touch
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

    def _elastic_share(self) -> Floats:
        """Returns what share of the points' deviatoric strain increment is elastic [-], (n,)."""
        plastic = self._plastic[:, 0] - self.points.plastic[:, 0]  # sqrt(2/3) of the tensor's norm
        share = np.ones(len(plastic))
        yielding = np.flatnonzero(plastic > 0.0)
        if len(yielding) == 0:
            return share
        strain = self._increment.reshape(-1, 3, 3)[yielding] - np.eye(3)
        strain = 0.5 * (strain + strain.transpose(0, 2, 1))
        strain -= np.trace(strain, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
        size = np.linalg.norm(strain, axis=(1, 2))
        share[yielding] = np.clip(
            1.0 - np.sqrt(1.5) * plastic[yielding] / np.maximum(size, 1e-300), 0.0, 1.0
        )
        return share

    def _level(self, body: PointRange, active: ActiveGrid, centres: Centres) -> None:
        """Lets the volumetric strains of points that flow go towards those of their cells."""
        s, points = slice(body.start, body.stop), self.points
        strain, jacobian = self._strain[s], points.assumed_jacobian[s]
        flow = self._plastic[s, 0] - points.plastic[s, 0]
        if not flow.any():
            return
        stencil = active.stencils[self.points.bodies.index(body)]
        volume, volumetric = points.part(body).volume, strain[:, :3].sum(axis=1)
        nodal = np.zeros((active.nodes, 2))
        _core.scatter(stencil, np.column_stack([volume, volume * volumetric]), nodal)
        smooth = np.empty((len(volume), 1))
        _core.interpolate(stencil, nodal[:, 1:] / np.maximum(nodal[:, :1], 1e-300), smooth)
        change = centres.level(volumetric - smooth[:, 0], volume, flow)
        bulk = body.young_modulus / (3.0 * (1.0 - 2.0 * body.poisson_ratio))
        moved = np.flatnonzero(change)
        change = change[moved]
        shrink = np.exp(-change)  # J_bar before over after; the Kirchhoff pressure is linear
        stress = points.stress[s][moved] * shrink[:, None]
        stress[:, :3] += (bulk * change * shrink / jacobian[moved])[:, None]
        points.stress[s][moved] = stress
        strain[moved, :3] += change[:, None] / 3.0
        jacobian[moved] /= shrink

    def elastic_energy(self) -> float:
        """Returns the elastic strain energy of all points [force length]."""
        total = 0.0
        for body in self.points.bodies:
            part = self.points.part(body)
            density = np.empty(len(part))
            _core.elastic_energy(body.material, body.parameters, part.elastic_strain, density)
            total += float(density @ part.initial_volume)
        return total
