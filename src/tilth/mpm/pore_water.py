# SPDX-License-Identifier: BSD-3-Clause
"""Water in the pores of saturated soil: what points store, and how it flows through them.

Pressures are the excess over that of water at rest, positive in compression. A point stores the
volume of its water per initial volume, at the reference density,

    zeta = (J - 1 + n0) exp(p / K_w),

with J = det F and the porosity n0 at the start (grains do not change their volume; Coussy 2004).
The flux relative to the soil is q = -kappa grad p (Darcy), kappa the hydraulic conductivity over
the unit weight of water. Theory: docs/theory/consolidation.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from tilth.arrays import Flags, Floats

if TYPE_CHECKING:
    from tilth.mpm.points import MaterialPoints

STORED, PRESSURE, POROSITY, CONDUCTIVITY = range(4)
"""Columns of `MaterialPoints.water`."""
VELOCITY = 4
"""The first of its columns with the velocity of the flow, one for each direction."""
STORED_CHANGE, PRESSURE_CHANGE = -2, -1
"""Its last columns, if it keeps the changes of the two in the last step, see `keeps_changes`."""


def keeps_changes(water: Floats, dim: int) -> bool:
    """Returns whether water of points, as `MaterialPoints.water`, has the changes of a step."""
    return int(water.shape[1]) > VELOCITY + dim


@dataclass(frozen=True)
class Permeability:
    """How the conductivity changes with the void ratio e = n / (1 - n), and with the direction.

    Attributes:
        law: its name.
        parameter: C_k of Taylor's law, the exponent of the power law [-], > 0; others have none.
        ratios: tensor of the conductivities over the least one at the start, shape (dim, dim);
            None if all are the same.
    """

    law: Literal["constant", "kozeny_carman", "taylor", "power"] = "constant"
    parameter: float = 0.0
    ratios: Sequence[Sequence[float]] | None = None

    def relative(self, void_ratio: Floats, initial: Floats) -> tuple[Floats, Floats]:
        """Returns kappa over that at the start, and d ln kappa / de, shape (n,) each.

        Kozeny (1927) and Carman (1937): kappa ~ n^3 / (1 - n)^2 = e^3 / (1 + e). Taylor (1948):
        log10 kappa ~ e / C_k. Power law: kappa ~ e^m (Somogyi 1980).

        void_ratio, initial: now and at the start [-], > 0, shape (n,).
        """
        e, e0, parameter = void_ratio, initial, self.parameter
        if self.law == "kozeny_carman":
            return (e / e0) ** 3 * (1.0 + e0) / (1.0 + e), 3.0 / e - 1.0 / (1.0 + e)
        if self.law == "taylor":
            return 10.0 ** ((e - e0) / parameter), np.full_like(e, np.log(10.0) / parameter)
        if self.law == "power":
            return (e / e0) ** parameter, parameter / e
        return np.ones_like(e), np.zeros_like(e)


def normalised(ratios: Sequence[Sequence[float]] | None) -> Sequence[Sequence[float]] | None:
    """Returns a symmetric tensor over its least principal value, shape (dim, dim); None of None."""
    if ratios is None:
        return None
    tensor = np.array(ratios)
    return tuple(map(tuple, (tensor / np.linalg.eigvalsh(tensor)[0]).tolist()))


CONSTANT = Permeability()
"""A conductivity that does not change."""


@dataclass(frozen=True)
class PoreWater:
    """Pores and water of n points.

    Attributes:
        porosity: n0 [-], shape (n,); 0 of those that no water enters.
        conductivity: kappa at the start, the least k / gamma_w of all directions
            [length^4/(force time)], shape (n,); 0 in a stage without flow.
        permeabilities: how it changes with the pores and the direction, of the points of slices
            that follow each other.
        bulk_modulus: K_w of the water [stress]; infinite for water that cannot be compressed.
    """

    porosity: Floats
    conductivity: Floats
    permeabilities: Sequence[tuple[slice, Permeability]] = ()
    bulk_modulus: float = np.inf

    @classmethod
    def of(
        cls, points: MaterialPoints, water: Floats, bulk_modulus: float, flows: bool = True
    ) -> PoreWater:
        """Returns the pores of material points.

        water: as `MaterialPoints.water`. flows: whether there is flow in the stage.
        """
        conductivity = water[:, CONDUCTIVITY] if flows else np.zeros(len(points))
        laws = [(range_.points, range_.permeability) for range_ in points.ranges]
        return cls(water[:, POROSITY], conductivity, laws, bulk_modulus)

    @cached_property
    def wet(self) -> Flags:
        """Which points have water in their pores, shape (n,)."""
        return np.asarray(self.porosity > 0.0)

    def stored(self, jacobian: Floats, pressure: Floats) -> Floats:
        """Returns zeta [-], shape (n,)."""
        pores = jacobian - 1.0 + self.porosity
        return np.asarray(pores * np.exp(pressure / self.bulk_modulus))

    def stored_derivatives(self, jacobian: Floats, pressure: Floats) -> tuple[Floats, Floats]:
        """Returns those of zeta by J [-] and by the pressure [1/stress], shape (n,) each."""
        compressed = np.exp(pressure / self.bulk_modulus)
        pores = jacobian - 1.0 + self.porosity
        return compressed, pores * compressed / self.bulk_modulus

    def conductivities(self, jacobian: Floats) -> tuple[Floats, Floats]:
        """Returns kappa and J times its derivative by J, shape (n,) each; e = J (1 + e0) - 1."""
        conductivity, change = self.conductivity.copy(), np.zeros_like(self.conductivity)
        for own, law in self.permeabilities:
            if law.law == "constant" or not self.wet[own].any():
                continue
            volume = 1.0 / (1.0 - self.porosity[own])  # 1 + e0
            ratio, slope = law.relative(jacobian[own] * volume - 1.0, volume - 1.0)
            conductivity[own] *= ratio
            change[own] = conductivity[own] * slope * jacobian[own] * volume
        return conductivity, change

    def ratios(self, deformation_gradient: Floats) -> Floats:
        """Returns the conductivities of all directions over the least one, shape (n, dim, dim).

        R A R^T: they turn with the soil, R the rotation in the polar decomposition.

        deformation_gradient: of the dim directions, shape (n, dim, dim).
        """
        n, dim, _ = deformation_gradient.shape
        found = np.tile(np.eye(dim), (n, 1, 1))
        for own, law in self.permeabilities:
            if law.ratios is not None:
                left, _, right = np.linalg.svd(deformation_gradient[own])
                turn = left @ right
                found[own] = turn @ np.array(law.ratios) @ np.swapaxes(turn, 1, 2)
        return found


@dataclass(frozen=True, eq=False)
class WaterAt:
    """Water of n points at one displacement and pressure of a step.

    Gradients are those in the geometry of that displacement.

    Attributes:
        volume: V0 J, shape (n,).
        jacobian: J [-], shape (n,).
        inverse: of the step's deformation gradient, its `dim` directions, shape (n, dim, dim).
        radius: of the point in axisymmetry [length], shape (n,); None otherwise.
        pressure: [stress], shape (n,).
        gradient: of the pressure [stress/length], shape (n, dim).
        drive: this, with inertia and the density of water times the acceleration, shape (n, dim).
        stored: zeta [-], shape (n,).
    """

    volume: Floats
    jacobian: Floats
    inverse: Floats
    radius: Floats | None
    pressure: Floats
    gradient: Floats
    drive: Floats
    stored: Floats

    @property
    def dim(self) -> int:
        """Number of directions."""
        return int(self.gradient.shape[1])

    def at_start(self, flux: Floats) -> Floats:
        """Returns the fluxes through the geometry of the step's start, (n, c, dim) as given.

        Their product with a gradient there is that of the given ones with the gradient now.
        """
        return np.asarray(np.einsum("nck,nmk->ncm", flux, self.inverse))

    def matrices_at_start(self, matrices: Floats) -> Floats:
        """Returns the same for matrices by value and gradient, see `PointIntegrals.add_blocks`.

        matrices: shape (n, r, 1 + dim, c, 1 + dim).
        """
        n, dim = len(self.volume), self.dim
        turn = np.zeros((n, 1 + dim, 1 + dim))
        turn[:, 0, 0] = 1.0
        turn[:, 1:, 1:] = self.inverse
        return np.ascontiguousarray(
            np.einsum("nmk,nikjl,npl->nimjp", turn, matrices, turn, optimize=True)
        )

    def divergence(self) -> Floats:
        """Returns what takes (N, grad N) of a node to the divergence of its unit displacements.

        Shape (n, dim, 1 + dim): gradient, and in axisymmetry N / r of the radial one.
        """
        n, dim = len(self.volume), self.dim
        found = np.zeros((n, dim, 1 + dim))
        found[:, np.arange(dim), 1 + np.arange(dim)] = 1.0
        if self.radius is not None:
            found[:, 0, 0] = 1.0 / self.radius
        return found
