# SPDX-License-Identifier: BSD-3-Clause
"""Response of the soil to a nodal displacement: stress update, internal force, stiffness.

Every method loops over the bodies and passes flat arrays to a kernel of the core.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.errors import StepFailed
from tilth.model.laws import laws
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.domains import MovedDomains, move_domain_faces, moved_domains, update_domains
from tilth.mpm.elastic_moduli import ElasticModuli
from tilth.mpm.f_bar import Centres
from tilth.mpm.interval import INSTANT, Interval
from tilth.mpm.plastic_volumes import PlasticVolumes, with_volume_change
from tilth.mpm.point_integrals import PointIntegrals
from tilth.mpm.points import MaterialPoints
from tilth.mpm.torn_off import torn_off
from tilth.timers import Timers

COMPRESSION = 5e-3
"""Strain after which soil tells how it yields in compression [-]."""

LEAST_SHARE = 0.1
"""Least modulus of soil that yields over the elastic one [-]."""

INVERTED = 1
"""Status of a point whose deformation gradient has no positive determinant."""


@dataclass
class _Trial:
    """Trial state of the points; each array has one row per point.

    Attributes:
        elastic: elastic left Cauchy-Green tensor less the identity [-].
        plastic, state: as those of `MaterialPoints`.
        response: data for forces and stiffness (kernel/response.hpp).
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


@dataclass(frozen=True)
class PastFlow:
    """What soil that has flowed within a step would have started it with, see `Soil.flow`.

    Attributes:
        elastic: elastic left Cauchy-Green tensor less the identity [-], shape (n, 6).
        plastic, state: as those of `MaterialPoints`.
        difference: of the plastic volume changes that it has, see `PlasticVolumes`, shape (n,).
    """

    elastic: Floats
    plastic: Floats
    state: Floats
    difference: Floats


_TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
"""Components of a symmetric tensor, 6, in its matrix."""

_COMPONENTS = np.array([0, 4, 8, 1, 5, 2])
"""Their places in the matrix, row by row."""


class Soil:
    """Material points on the grid of one step, with the trial state of this step.

    Args:
        points: the points; changed by `advance` only.
        active: the grid of the step.
        kind: "plane_strain", "axisymmetric" or "3d".
        timers: takes the time of the kernels.
        own: which points this process owns, shape (n,); all if not given.
        interval: the time that the step takes.

    Attributes:
        integrals: over the points, of any quantity of theirs.
        past: plastic flow in the step that cannot be undone; None without.
    """

    def __init__(
        self,
        points: MaterialPoints,
        active: ActiveGrid,
        kind: str,
        timers: Timers,
        own: Flags | None = None,
        interval: Interval = INSTANT,
    ) -> None:
        self.points = points
        self.active = active
        self.integrals = PointIntegrals(active)
        self.kind = kind
        self._timers = timers
        self._interval = interval.array
        with timers.measure("basis"):
            self._centres = [
                Centres.of(points.part(range_), stencil, active, kind)
                if range_.anti_locking == "f_bar"
                else None
                for range_, stencil in zip(points.ranges, active.stencils, strict=True)
            ]
        self._torn_off = torn_off(points)
        if not self._torn_off.any():
            self._torn_off = np.zeros(0, dtype=bool)
        self._kept = np.zeros_like(self._torn_off)
        self._plastic_volumes = PlasticVolumes(points, self._centres, own, active.comm)
        self.past: PastFlow | None = None

    def without_strain(self, factor: float) -> Soil:
        """Returns linear elastic soil at the same points, with no strain and no stress.

        factor: of the elastic moduli at the points now, in any unit.
        """
        points, moduli, law = self.points, self.elastic_moduli, laws()["hencky_elastic"]
        n = len(points)
        same = replace(
            points,
            ranges=[replace(range_, law=law, parameters=None) for range_ in points.ranges],
            initial_volume=points.volume,
            deformation_gradient=np.tile(np.eye(3), (n, 1, 1)),
            elastic_deformation=np.zeros((n, 6)),
            stress=np.zeros((n, 6)),
            plastic=np.zeros((n, 2)),
            assumed_jacobian=np.ones(n),
            state=np.zeros((n, 0)),
            parameters=np.column_stack([factor * moduli.young, moduli.poisson]),
        )
        return Soil(same, self.active, self.kind, self._timers)

    @cached_property
    def _trial(self) -> _Trial:
        return _Trial.of(self.points, self.kind)

    def update(self, displacement: Floats) -> None:
        """Updates the trial state for the step's nodal displacement [length], (nodes, dim).

        Raises:
            StepFailed: if a point inverts or its return mapping fails.
        """
        points, trial = self.points, self._trial
        with self._timers.measure("stress"):
            elastic, plastic, state = self._start()
            for range_, stencil, centres in zip(
                points.ranges, self.active.stencils, self._centres, strict=True
            ):
                s = slice(range_.start, range_.stop)
                if centres is not None:
                    centres.update(displacement)
                point, status = _core.stress_update(
                    self.kind, range_.law.core, points.parameters_of(range_), stencil, displacement,
                    points.position[s], elastic[s], plastic[s], state[s],
                    trial.elastic[s], trial.plastic[s], trial.state[s], trial.response[s], centres,
                    self._torn_off[s], self._kept[s], self._interval,
                )  # fmt: skip
                if status:
                    number = int(points.point_id[range_.start + point])
                    inverted = "a material point inverted (det F <= 0)"
                    reason = inverted if status == INVERTED else range_.law.failure
                    raise StepFailed(reason, point=number)

    def _start(self) -> tuple[Floats, Floats, Floats]:
        """Returns elastic deformation, plastic strain and state from which the soil flows."""
        points, past = self.points, self.past
        if past is None:
            elastic = self._plastic_volumes.scaled(points.elastic_deformation)
            return elastic, points.plastic, points.state
        return self._plastic_volumes.scaled(past.elastic, past.difference), past.plastic, past.state

    def flow(self, displacement: Floats) -> None:
        """Makes the plastic flow to the trial state past: from there the soil unloads elastically.

        The elastic deformation b at the trial state F is that of soil which starts the step with
        F^-1 b F^-T, with the plastic strain and state of the trial.

        displacement: of the trial state [length], shape (nodes, dim).
        """
        determinant, inverse = self.step_inverses(displacement)
        scaled = 2 if self.kind == "plane_strain" else 3
        for range_, centres in zip(self.points.ranges, self._centres, strict=True):
            if centres is not None:
                s = range_.points
                ratio = (determinant[s] / centres.jacobian) ** (1.0 / scaled)
                inverse[s, :scaled, :scaled] *= ratio[:, None, None]
        trial = self._trial
        elastic = inverse @ (np.eye(3) + trial.elastic[:, _TENSOR]) @ inverse.transpose(0, 2, 1)
        self.past = PastFlow(
            np.ascontiguousarray((elastic - np.eye(3)).reshape(-1, 9)[:, _COMPONENTS]),
            trial.plastic.copy(),
            trial.state.copy(),
            self._plastic_volumes.difference,
        )

    def restart(self) -> None:
        """Begins anew with the revisions of plastic volume changes."""
        self._plastic_volumes.restart()

    def refine(self) -> float:
        """Revises the plastic volume changes of points with F-bar by the trial state.

        Only where the trial state does not become that of the points.

        Returns:
            How far they are from settled; at most 1 if they are, see `PlasticVolumes.revise`.
        """
        with self._timers.measure("stress"):
            return self._plastic_volumes.revise(self._trial.elastic, self.plastic_increment())

    def _volumes(self) -> list[Floats]:
        """Returns the volumes of the Kirchhoff stress, V0 J / J_bar before the step, by range."""
        volumes = []
        for range_, centres in zip(self.points.ranges, self._centres, strict=True):
            volume = self.points.initial_volume[range_.start : range_.stop]
            volumes.append(volume if centres is None else volume * centres.jacobian_ratio_before)
        return volumes

    def internal_force(self) -> Floats:
        """Returns the internal force of the trial state [force], shape (nodes, dim)."""
        force = np.zeros((self.active.nodes, self.active.grid.dim))
        with self._timers.measure("assembly"):
            for range_, stencil, volume, centres in zip(
                self.points.ranges, self.active.stencils, self._volumes(), self._centres,
                strict=True,
            ):  # fmt: skip
                s = slice(range_.start, range_.stop)
                _core.internal_force(
                    self.kind, stencil, volume, self.points.position[s],
                    self._trial.response[s], force, centres,
                )  # fmt: skip
        return force

    def add_stiffness(self, pattern: ActiveGrid, matrix: Floats) -> None:
        """Adds the derivative of the force to `matrix` (blocks, dim, dim) [force/length].

        pattern: the grid of the step with the pattern of the matrix.
        """
        with self._timers.measure("assembly"):
            for range_, stencil, (start, position), volume, centres in zip(
                self.points.ranges, self.active.stencils, pattern.block_positions, self._volumes(),
                self._centres, strict=True,
            ):  # fmt: skip
                s = slice(range_.start, range_.stop)
                _core.stiffness(
                    self.kind, stencil, start, position,
                    volume, self.points.position[s], self._trial.response[s],
                    matrix, centres,
                )  # fmt: skip

    def scatter(self, vector: Floats) -> Floats:
        """Returns sum_p S_ap vector_p of a quantity of the points, (n, k) -> (nodes, k)."""
        with self._timers.measure("assembly"):
            return self.integrals.scattered(vector)

    @cached_property
    def elastic_moduli(self) -> ElasticModuli:
        """The tangent elastic moduli of the points at the start of the step."""
        return self.points.elastic_moduli()

    @cached_property
    def nodal_volume(self) -> Floats:
        """Sum of S_ap V_p at each node at the start of the step, shape (nodes,).

        In [length^dim, in axisymmetry length^3].
        """
        return self.scatter(self.points.volume)

    def compressed_moduli(self) -> Floats:
        """Returns the constrained moduli of the points as they yield in compression, shape (n,).

        In [stress], at the start of the step: the law's tangent along the vertical after a uniaxial
        compression along it, between `LEAST_SHARE` of the elastic modulus and this. The trial state
        is then another one.
        """
        elastic, dim = self.elastic_moduli.constrained, self.active.grid.dim
        compression = np.zeros((self.active.nodes, dim))
        height = self.active.position[:, -1]
        compression[:, -1] = -COMPRESSION * (height - height.mean())
        try:
            self.update(compression)
        except StepFailed:
            return elastic
        response, first = self._trial.response, int(self.kind == "axisymmetric") + dim**2
        along = response[:, first + dim * (dim - 1) : first + dim**2]  # kernel/response.hpp
        principal = np.abs(along).argmax(axis=1)
        tangent = response[np.arange(len(response)), first + dim**2 + 3 + 4 * principal]
        return np.asarray(np.clip(tangent, LEAST_SHARE * elastic, elastic))

    def plastic_increment(self) -> Floats:
        """Returns the equivalent plastic strain since the start of the step [-], shape (n,).

        It is that of the trial state.
        """
        return np.asarray(self._trial.plastic[:, 0] - self.points.plastic[:, 0])

    def yielding_nodes(self) -> Flags:
        """Returns whether a point in a node's support yields in the trial state, (nodes,)."""
        yielding = self._trial.plastic[:, :1] > self.points.plastic[:, :1]
        if not yielding.any():
            return np.zeros(self.active.nodes, dtype=bool)
        return np.asarray(self.scatter(yielding.astype(np.float64))[:, 0] > 0.0)

    def interpolate(self, nodal: Floats) -> Floats:
        """Returns sum_a S_ap nodal_a at the points, shape (n, dim)."""
        return self.integrals.interpolated(nodal)

    def step_inverses(self, displacement: Floats) -> tuple[Floats, Floats]:
        """Returns determinants and inverses of the step's deformation gradients at the points [-].

        Shapes (n,) and (n, 3, 3); in axisymmetry with the hoop stretch, see `MaterialPoints`.
        """
        points = self.points
        determinant, inverse = np.empty(len(points)), np.empty((len(points), 3, 3))
        with self._timers.measure("assembly"):
            for range_, stencil in zip(points.ranges, self.active.stencils, strict=True):
                s = range_.points
                _core.step_inverses(
                    self.kind, stencil, displacement, points.position[s], determinant[s],
                    inverse[s],
                )  # fmt: skip
        kept = np.flatnonzero(self._kept)
        determinant[kept], inverse[kept] = 1.0, np.eye(3)
        return determinant, inverse

    def add_force_derivative(
        self, pattern: ActiveGrid, by_displacement: Floats, by_gradient: Floats, matrix: Floats
    ) -> None:
        """Adds the derivative of sum_p S_ap f_p to `matrix` (blocks, dim, dim) [force/length].

        Args:
            pattern: the grid of the step with the pattern of the matrix.
            by_displacement: derivative of f by the point's displacement [force/length], shape
                (n, dim, dim).
            by_gradient: derivative of f_i by the gradient of its component k in direction j
                [force], shape (n, i, k, j).
            matrix: to which it is added.
        """
        with self._timers.measure("assembly"):
            for range_, stencil, (start, position) in zip(
                self.points.ranges, self.active.stencils, pattern.block_positions, strict=True
            ):
                _core.add_force_derivative(
                    stencil, start, position, np.ascontiguousarray(by_displacement[range_.points]),
                    np.ascontiguousarray(by_gradient[range_.points]), matrix,
                )  # fmt: skip

    def moved_domains(self, displacement: Floats) -> MovedDomains:
        """Returns the domains whose corners move with the grid, at the end of the step.

        Raises:
            StepFailed: a domain folds or inverts.
        """
        return moved_domains(self.points, self.active, self.kind, displacement)

    def advance(self, displacement: Floats, domains: MovedDomains) -> None:
        """Makes the trial state the state of the points and moves them with the grid.

        domains: what `moved_domains` returns for this displacement.
        """
        points, trial = self.points, self._trial
        with self._timers.measure("other"):
            move_domain_faces(points, self.active, displacement)
            for range_, stencil in zip(points.ranges, self.active.stencils, strict=True):
                part = points.part(range_)
                s = slice(range_.start, range_.stop)
                _core.advance(
                    self.kind, stencil, displacement, part.position, trial.response[s],
                    part.plastic, trial.plastic[s], part.last_gradient,
                    part.deformation_gradient, part.stress, part.elastic_share,
                    range_.forgotten_strain, self._kept[s],
                )  # fmt: skip
                _core.interpolate(stencil, displacement, part.last_displacement)
            for number, (corner, shift) in domains.items():
                range_ = points.ranges[number]
                points.corner[range_.start : range_.stop] = corner
                points.last_displacement[range_.start : range_.stop] = shift
            points.position += points.last_displacement
            points.displacement += points.last_displacement
            for number, centres in enumerate(self._centres):
                if centres is not None:
                    self._advance_f_bar(number, centres)
            points.elastic_deformation = trial.elastic
            points.plastic, points.state = trial.plastic, trial.state
            update_domains(points, self.kind)

    def _advance_f_bar(self, number: int, centres: Centres) -> None:
        """Updates the assumed Jacobian and the Cauchy stress of a range with F-bar."""
        range_ = self.points.ranges[number]
        s = slice(range_.start, range_.stop)
        self.points.assumed_jacobian[s] *= centres.jacobian
        self.points.stress[s] *= centres.jacobian_ratio[:, None]
        self._smooth_volumetric_strains(number, centres)

    def _smooth_volumetric_strains(self, number: int, centres: Centres) -> None:
        """Smooths the volumetric strains of yielding points towards the means of their cells."""
        range_, stencil = self.points.ranges[number], self.active.stencils[number]
        s, points = slice(range_.start, range_.stop), self.points
        elastic, jacobian = self._trial.elastic[s], points.assumed_jacobian[s]
        plastic_increment = self._trial.plastic[s, 0] - points.plastic[s, 0]
        if not plastic_increment.any():
            return
        volume, volumetric = points.part(range_).volume, _core.volumetric_strains(elastic)
        nodal = np.zeros((self.active.nodes, 2))
        _core.scatter(stencil, np.column_stack([volume, volume * volumetric]), nodal)
        smooth = np.empty((len(volume), 1))
        _core.interpolate(stencil, nodal[:, 1:] / np.maximum(nodal[:, :1], 1e-300), smooth)
        correction = centres.smoothing(volumetric - smooth[:, 0], volume, plastic_increment)
        smoothed = np.flatnonzero(correction)
        if len(smoothed) == 0:
            return
        trial = with_volume_change(elastic[smoothed], correction[smoothed])
        # a law whose strength depends on the pressure returns the stress to its yield surface
        state, plastic = self._trial.state[s], self._trial.plastic[s]
        returned, plastic_after, stress = (
            np.empty_like(a) for a in (trial, plastic[smoothed], points.stress[s][smoothed])
        )
        state_after, admissible = state[smoothed], np.empty(len(smoothed), dtype=bool)
        parameters = points.parameters_of(range_)
        _core.return_to_law(
            self.kind, range_.law.core,
            parameters if parameters.ndim == 1 else parameters[smoothed],
            trial, plastic[smoothed], state[smoothed],
            returned, plastic_after, state_after, stress, admissible,
        )  # fmt: skip
        smoothed = smoothed[admissible]
        elastic[smoothed], plastic[smoothed], state[smoothed] = (
            returned[admissible],
            plastic_after[admissible],
            state_after[admissible],
        )
        jacobian[smoothed] *= np.exp(correction[smoothed])
        points.stress[s][smoothed] = stress[admissible] / jacobian[smoothed, None]
