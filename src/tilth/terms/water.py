# SPDX-License-Identifier: BSD-3-Clause
"""Water at rest as a term of the balance: buoyancy, seepage forces and the weight of its mass.

The stress of the laws is the effective one. The pore pressure and the pressure of free water on
the surface of the soil are together the body force -grad u (docs/theory/water.md): no surface
enters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.mpm.water import PhreaticSurface, Planes, half_extents, wet_share
from tilth.mpm.wet_mass import pore_mass, without_wet_density
from tilth.terms.loads import Loads
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Role, Term
from tilth.terms.space import Space


@dataclass(frozen=True)
class _Moment:
    """The water above the points at a time, at their positions at the start of the step.

    Attributes:
        unit_weight: of the water [force/length^3].
        planes: that touch the phreatic surface above the points.
        extents: of the points' domains (`half_extents`).
        pore_weight: weight of the mass that the points have below the water only [force], (n, dim).
    """

    unit_weight: float
    planes: Planes
    extents: Floats
    pore_weight: Floats


@dataclass(frozen=True)
class Wetted:
    """Points for a displacement of the step; n of them.

    Attributes:
        share: of each domain that is below the water [-], shape (n,).
        share_by_depth: its derivative by the depth [1/length], shape (n,).
        volume: current volume [length^dim, in axisymmetry length^3], shape (n,).
        by_volume: derivative of `whole` by the volume [force/length^dim], shape (n, dim).
        whole: force on a point that is below the water entirely [force], shape (n, dim).
        inverse: of the step's deformation gradient [-], shape (n, 3, 3).
    """

    share: Floats
    share_by_depth: Floats
    volume: Floats
    by_volume: Floats
    whole: Floats
    inverse: Floats


class WaterForces(Term):
    """The force of the water on the soil in a step.

    The phreatic surface above a point is replaced by the plane that touches it above the point's
    position at the start of the step. The point's depth below this plane and its volume follow the
    displacement in the step.

    Args:
        surface: of the water.
        loads: of the model, for the weight of the water's mass.
        soil: the material points on the grid of the step.
        before, after: times at the start and end of the step.

    Raises:
        StepFailed: soil without a density for it is below the water.
    """

    def __init__(
        self, surface: PhreaticSurface, loads: Loads, soil: Soil, before: float, after: float
    ) -> None:
        points = soil.points
        self.soil = soil
        self._before, self._after = (
            _moment(surface, loads, soil, time) for time in (before, after)
        )
        self._volume = points.volume
        ranges = [(range_.keeps_water, range_.stop - range_.start) for range_ in points.ranges]
        self._keeps_water = np.repeat(*map(np.array, zip(*ranges, strict=True)))
        if loads.acts_on_mass:
            depth, extents = self._after.planes.depth, self._after.extents
            dry = without_wet_density(points, wet_share(depth, extents)[0] > 0.0)
            if dry is not None:
                raise StepFailed(
                    "soil whose material has no saturated_density moved below the water",
                    "give the material a saturated_density, or watertight = true",
                    point=int(points.point_id[dry]),
                )

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`; the pattern always contains the couplings of the points' nodes."""
        return _WaterForces(self, space.active)

    def force_before(self) -> Floats:
        """Returns the nodal force at the start of the step [force], shape (nodes, dim)."""
        active = self.soil.active
        none = np.zeros((active.nodes, active.grid.dim))
        return self.nodal(self._wetted(self._before, none))

    def wetted(self, displacement: Floats) -> Wetted:
        """Returns the points at the step's end for a nodal displacement, shape (nodes, dim).

        Raises:
            StepFailed: a point inverts.
        """
        return self._wetted(self._after, displacement)

    def nodal(self, at: Wetted) -> Floats:
        """Returns the nodal force [force], shape (nodes, dim)."""
        return self.soil.scatter(at.share[:, None] * at.whole)

    def derivative(self, at: Wetted) -> tuple[Floats, Floats]:
        """Returns the derivatives of the points' forces at the step's end.

        By their displacements [force/length], shape (n, dim, dim), and by its gradients [force],
        shape (n, dim, dim, dim): force, displacement, direction.
        """
        points, dim = self.soil.points, at.whole.shape[1]
        by_jacobian = (at.share * at.volume)[:, None] * at.by_volume
        # the derivative of ln J by the gradient is the transposed inverse
        logarithmic = at.inverse[:, :dim, :dim].transpose(0, 2, 1)
        by_gradient = by_jacobian[:, :, None, None] * logarithmic[:, None]
        by_depth = at.share_by_depth[:, None] * at.whole
        by_displacement = by_depth[:, :, None] * self._after.planes.direction[:, None]
        if self.soil.kind == "axisymmetric":
            hoop = at.inverse[:, 2, 2] / points.position[:, 0]
            by_displacement[:, :, 0] += by_jacobian * hoop[:, None]
        return by_displacement, by_gradient

    def _wetted(self, moment: _Moment, displacement: Floats) -> Wetted:
        points, planes = self.soil.points, moment.planes
        moved = self.soil.interpolate(displacement)
        share, share_by_depth = wet_share(
            planes.depth + (planes.direction * moved).sum(axis=1), moment.extents
        )
        jacobian, inverse = self.soil.step_inverses(displacement)
        if not (jacobian > 0.0).all():
            number = int(points.point_id[jacobian.argmin()])
            raise StepFailed("a material point inverted (det F <= 0)", point=number)
        volume = self._volume * jacobian
        by_volume = -moment.unit_weight * planes.direction
        whole = volume[:, None] * by_volume + moment.pore_weight
        # where the pores stay full, the weight of the water that enters is its buoyancy
        drains = ~self._keeps_water
        whole[drains, -1] -= (volume - points.initial_volume)[drains] * by_volume[drains, -1]
        by_volume[drains, -1] = 0.0
        return Wetted(share, share_by_depth, volume, by_volume, whole, inverse)


def _moment(surface: PhreaticSurface, loads: Loads, soil: Soil, time: float) -> _Moment:
    points = soil.points
    planes = surface.planes(points.position, time)
    weight = np.zeros_like(points.position)
    if loads.acts_on_mass:
        weight += pore_mass(points)[:, None] * loads.acceleration(time)
    extents = half_extents(points, planes.direction)
    return _Moment(surface.unit_weight(time), planes, extents, weight)


class _WaterForces(DisplacementTerm):
    role = Role.LOAD
    label = "water"

    def __init__(self, forces: WaterForces, active: ActiveGrid) -> None:
        self._forces, self._pattern = forces, active
        self._at: Wetted | None = None

    def force(self, displacement: Floats) -> Floats:
        self._at = self._forces.wetted(displacement)
        return -self._forces.nodal(self._at)

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        assert self._at is not None, "the force comes first"
        by_displacement, by_gradient = self._forces.derivative(self._at)
        self._forces.soil.add_force_derivative(
            self._pattern, -by_displacement, -by_gradient, blocks
        )

    def load_before(self) -> Floats:
        return self._forces.force_before()
