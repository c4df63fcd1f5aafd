# SPDX-License-Identifier: BSD-3-Clause
"""Terms of water that flows through soil: its pressure on the soil, what is stored, what flows.

The balance of momentum has the force -V p div, with all derivatives at finite strain; that of
water, in volume per step, takes the sign that makes the coupling symmetric:

    R_u = -sum_p V p D_a,   R_p = -sum_p [V0 N_a (zeta - zeta_n) + h V kappa grad N_a . A grad p],

D_a = grad N_a, in axisymmetry with N_a / r in the radial direction, h the size of the step
(backward Euler; with the formula of order 2 theta h, and changes less w times those of the last
step, see `BackwardDifference`), A the ratios of the conductivities in all directions at the start
of the step. Nodes of pressure and displacement are the same: `water_stabilisation.py`.
Theory: docs/theory/consolidation.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

import numpy as np

from tilth.algebra.block_matrix import BlockMatrix, Pair
from tilth.algebra.field import DISPLACEMENT, Field
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.mpm.pattern import Elements
from tilth.mpm.point_integrals import PointIntegrals
from tilth.mpm.pore_water import (
    PRESSURE,
    PRESSURE_CHANGE,
    STORED,
    STORED_CHANGE,
    VELOCITY,
    PoreWater,
    WaterAt,
    keeps_changes,
)
from tilth.mpm.soil import Soil
from tilth.terms.backward_difference import BackwardDifference
from tilth.terms.filled_cells import sums_in_cells
from tilth.terms.inertia import Inertia
from tilth.terms.outcome import Outcome, Work
from tilth.terms.protocol import AssembledTerm, Role, Term
from tilth.terms.space import Space

PORE_PRESSURE = "p"
"""Name of the field: the excess pore pressure [stress], compression positive."""

WATER = "water"
"""Its equation: the balance of the water's volume in a step [length^dim]."""

COUPLINGS: Sequence[Pair] = ((DISPLACEMENT, PORE_PRESSURE), (PORE_PRESSURE, PORE_PRESSURE))

LARGEST_COMPRESSION = 100.0
"""Pore pressure over the bulk modulus of the water, at most: exp of it is a number."""


class WaterInStep:
    """Water of the points in one step, at the unknowns of the last evaluation.

    Args:
        soil: on the grid of the step.
        water: pores and water of its points.
        formula: by which the step integrates.
        keep: is told the nodal pressures at the end of the step, and at its start, (nodes, 1) each.
        last_change: of the nodal pressures in the last step, shape (nodes, 1); 0 if the formula
            does not need it.
        inertia: of the soil in the step; None without.
        density: of the water [mass/length^3], for its own inertia.

    Attributes:
        size: theta h of the formula [time].
        stored_before: what the stored water changes from, zeta_n + w (zeta_n - zeta_{n-1}), (n,).
        initial_volume: of the soil with water in its pores [length^dim], shape (n,); 0 elsewhere.
        conductivity: kappa at the start of the step, the least of all directions, shape (n,).
        ratios: of the conductivities in all directions to the least one, at the start of the step,
            shape (n, dim, dim).
        nodal_volume: sum_p S_ap V_p of that soil at the start of the step, shape (nodes,).
        at: the last evaluation; None before.
    """

    def __init__(
        self,
        soil: Soil,
        water: PoreWater,
        formula: BackwardDifference,
        keep: Callable[[Floats, Floats], None],
        last_change: Floats | float = 0.0,
        inertia: Inertia | None = None,
        density: float = 0.0,
    ) -> None:
        points = soil.points
        self._inertia, self._density = inertia, density
        self.soil, self.water, self.formula, self.keep = soil, water, formula, keep
        self.size = formula.of_rate
        self.integrals: PointIntegrals = soil.integrals
        self.before = points.water
        self.stored_before: Floats = self.before[:, STORED].copy()
        if formula.ratio > 0.0:
            self.stored_before += formula.of_last_change * self.before[:, STORED_CHANGE]
        self._last_change = last_change
        self.initial_volume = points.initial_volume * water.wet
        self.nodal_volume = self.nodal_sums(np.ones(len(points)))
        self._jacobian = np.linalg.det(points.deformation_gradient)
        self.conductivity = water.conductivities(self._jacobian)[0]
        dim = soil.active.grid.dim
        self.ratios = water.ratios(points.deformation_gradient[:, :dim, :dim])
        self.at: WaterAt | None = None
        self._of: Mapping[str, Floats] | None = None

    def evaluate(self, x: Unknowns) -> WaterAt:
        """Returns the water at these unknowns.

        Raises:
            StepFailed: pores have closed, or water is compressed beyond all numbers.
        """
        if self.at is not None and self._of is x.of:
            return self.at
        points, dim = self.soil.points, self.soil.active.grid.dim
        determinant, inverse = self.soil.step_inverses(x.u)
        jacobian = self._jacobian * determinant
        inverse = np.ascontiguousarray(inverse[:, :dim, :dim])
        p = self.integrals.interpolated(x[PORE_PRESSURE])[:, 0]
        gradient = self.integrals.gradient(x[PORE_PRESSURE])[:, 0]
        self._require_pores(jacobian, p)
        radius = None
        if self.soil.kind == "axisymmetric":
            radius = points.position[:, 0] + self.soil.interpolate(x.u)[:, 0]
        self._of = x.of
        gradient = np.einsum("nm,nmk->nk", gradient, inverse)
        self.at = WaterAt(
            volume=self.initial_volume * jacobian,
            jacobian=jacobian,
            inverse=inverse,
            radius=radius,
            pressure=p,
            gradient=gradient,
            drive=gradient + self._density * self._acceleration(x.u),
            stored=self.water.stored(jacobian, p),
        )
        return self.at

    def _acceleration(self, displacement: Floats) -> Floats | float:
        """Returns the acceleration of the points at the end of the step, (n, dim); 0 without."""
        if self._inertia is None:
            return 0.0
        assert self._inertia.in_matrix is not None
        return self.soil.interpolate(self._inertia.in_matrix.after(displacement).acceleration)

    @property
    def inertia_by_motion(self) -> float:
        """Derivative of the water's inertia by the displacement [stress/length^2]."""
        if self._inertia is None:
            return 0.0
        assert self._inertia.in_matrix is not None
        return self._density * self._inertia.in_matrix.derivatives()[1]

    def _require_pores(self, jacobian: Floats, pressure: Floats) -> None:
        water, number = self.water, self.soil.points.point_id
        porosity = 1.0 - (1.0 - water.porosity) / jacobian
        largest = LARGEST_COMPRESSION * water.bulk_modulus
        closed = "the pores of a material point have closed"
        crushed = "the pore pressure of a material point is a multiple of flow.bulk_modulus"
        for wrong, what in ((porosity <= 0.0, closed), (np.abs(pressure) > largest, crushed)):
            if (found := np.flatnonzero(wrong & water.wet)).size:
                raise StepFailed(what, point=int(number[found[0]]))

    def nodal_sums(self, value: Floats) -> Floats:
        """Returns sum_p S_ap V_p value_p of the wet soil at the step's start, (n,) -> (nodes,)."""
        volume = self.soil.points.volume * self.water.wet
        return self.soil.scatter((volume * value)[:, None])[:, 0]

    @cached_property
    def softness(self) -> Floats:
        """max(1/(2G), 3/M) of the points at the start of the step [1/stress], shape (n,).

        M is that of soil as it yields in compression, see `Soil.compressed_moduli`.
        """
        shear = self.soil.elastic_moduli.shear
        return np.maximum(0.5 / shear, 3.0 / self.soil.compressed_moduli())

    def in_cells(self, value: Floats) -> tuple[Floats, Floats]:
        """Returns the wet soil's volume in each cell, and the mean of a value, shape (cells,)."""
        volume, total = sums_in_cells(self.soil, self.soil.points.volume * self.water.wet, value).T
        return volume, total / np.maximum(volume, 1e-300)

    def pressure_before(self, field: Field) -> Floats:
        """Returns what nodal pressures change from, p_n + w (p_n - p_{n-1}), shape (nodes, 1)."""
        return np.asarray(field.first() + self.formula.of_last_change * self._last_change)

    def turned(self, gradient: Floats) -> Floats:
        """Returns gradients (n, dim) times the ratios, the direction in which the water flows."""
        return np.asarray(np.einsum("nkl,nl->nk", self.ratios, gradient))

    @property
    def last(self) -> WaterAt:
        """The last evaluation."""
        assert self.at is not None, "water is assembled before it was evaluated"
        return self.at


class _AtPoints(Term):
    """A term of the water at the points.

    Args:
        water: of the step, which these terms share.
    """

    def __init__(self, water: WaterInStep) -> None:
        self._water = water

    @property
    def pairs_at_points(self) -> Sequence[Pair]:
        """As `Term.pairs_at_points`."""
        return COUPLINGS


class StoredWater(_AtPoints):
    """Water that the pores take up, and its pressure on the soil."""

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        return _StoredWater(self._water, space)


class Seepage(_AtPoints):
    """Water that flows through the soil."""

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        return _Seepage(self._water, space)


class _OfWater(AssembledTerm):
    def __init__(self, water: WaterInStep, space: Space) -> None:
        self._water, self._space = water, space

    def _add(self, matrix: BlockMatrix, pair: Pair, at: WaterAt, matrices: Floats) -> None:
        of_start = at.matrices_at_start(matrices)
        block = matrix[pair].values
        self._water.integrals.add_blocks(self._space.positions(pair), of_start, block)


class _StoredWater(_OfWater):
    role = Role.STORAGE
    label = "stored pore water"

    def evaluate(self, x: Unknowns) -> Unknowns:
        water = self._water
        at, integrals = water.evaluate(x), water.integrals
        stress = -at.volume * at.pressure
        force = integrals.scattered_gradient(at.at_start(stress[:, None, None] * np.eye(at.dim)))
        if at.radius is not None:
            force[:, :1] += integrals.scattered((stress / at.radius)[:, None])
        taken = water.initial_volume * (at.stored - water.stored_before)
        return Unknowns({DISPLACEMENT: force, PORE_PRESSURE: -integrals.scattered(taken[:, None])})

    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        water, at = self._water, self._water.last
        divergence, dim = at.divergence(), at.dim
        unit = np.zeros(1 + dim)
        unit[0] = 1.0
        by_jacobian, by_pressure = water.water.stored_derivatives(at.jacobian, at.pressure)
        stress = -at.volume * at.pressure
        # -V p (D_a D_b^T - G_b G_a^T - N_a N_b / r^2)
        geometric = np.einsum("nik,njl->nikjl", divergence, divergence)
        for i in range(dim):
            for j in range(dim):
                geometric[:, i, 1 + j, j, 1 + i] -= 1.0
        if at.radius is not None:
            geometric[:, 0, 0, 0, 0] -= at.radius**-2.0
        geometric *= stress[:, None, None, None, None]
        self._add(matrix, (DISPLACEMENT, DISPLACEMENT), at, geometric)
        coupling = np.einsum("n,nik,l->nikl", -at.volume, divergence, unit)[:, :, :, None]
        self._add(matrix, (DISPLACEMENT, PORE_PRESSURE), at, coupling)
        taken = np.einsum("n,k,njl->nkjl", -at.volume * by_jacobian, unit, divergence)[:, None]
        self._add(matrix, (PORE_PRESSURE, DISPLACEMENT), at, taken)
        if np.isfinite(water.water.bulk_modulus):
            volume = -water.initial_volume * by_pressure
            squeezed = np.einsum("n,k,l->nkl", volume, unit, unit)
            self._add(matrix, (PORE_PRESSURE, PORE_PRESSURE), at, squeezed[:, None, :, None])

    def magnitude(self, x: Unknowns) -> Mapping[str, Floats]:
        """As `AssembledTerm.magnitude`: the water taken up is a difference of whole volumes."""
        water = self._water
        volumes = water.initial_volume * (water.last.jacobian + water.stored_before)
        return {PORE_PRESSURE: water.integrals.scattered(volumes[:, None])}

    def add_schur(self, x: Unknowns, schur: Mapping[str, Floats]) -> None:
        """As `AssembledTerm.add_schur`: soil that is drained takes up V p / K_dr (fixed stress)."""
        soil, at, dim = self._water.soil, self._water.last, self._water.last.dim
        moduli = soil.elastic_moduli
        directions = 2 if soil.kind == "plane_strain" else 3
        drained = moduli.bulk - 2.0 * moduli.shear / 3.0 + 2.0 * moduli.shear / directions
        mass = np.zeros((len(at.volume), 1, 1 + dim, 1, 1 + dim))
        mass[:, 0, 0, 0, 0] = -at.volume / drained
        pair = PORE_PRESSURE, PORE_PRESSURE
        self._water.integrals.add_blocks(self._space.positions(pair), mass, schur[PORE_PRESSURE])

    def commit(self, x: Unknowns, checked: None) -> None:
        """As `AssembledTerm.commit`; water that is held while the soil is moved stays as it is."""
        field = self._space.fields[PORE_PRESSURE]
        if field.active is not None and not field.active.any():
            return
        at, water = self._water.last, self._water.before
        wet = self._water.water.wet
        stored, pressure = np.where(wet, at.stored, 0.0), np.where(wet, at.pressure, 0.0)
        if keeps_changes(water, at.dim):
            water[:, STORED_CHANGE] = stored - water[:, STORED]
            water[:, PRESSURE_CHANGE] = pressure - water[:, PRESSURE]
        water[:, STORED], water[:, PRESSURE] = stored, pressure
        conductivity, _ = self._water.water.conductivities(at.jacobian)
        flow = -conductivity[:, None] * self._water.turned(at.drive)
        water[:, VELOCITY : VELOCITY + at.dim] = flow
        self._water.keep(x[PORE_PRESSURE], field.first())


class _Seepage(_OfWater):
    role = Role.FLOW
    label = "seepage"

    def evaluate(self, x: Unknowns) -> Unknowns:
        water = self._water
        at = water.evaluate(x)
        conductivity, _ = water.water.conductivities(at.jacobian)
        flux = (water.size * at.volume * conductivity)[:, None] * water.turned(at.drive)
        flow = water.integrals.scattered_gradient(at.at_start(flux[:, None]))
        return Unknowns({PORE_PRESSURE: -flow})

    def outcome(self, x: Unknowns) -> Outcome:
        """As `AssembledTerm.outcome`: dissipated by the flow, theta h sum_p V kappa |grad p|^2."""
        work = self._water.soil.active.work(self.evaluate(x)[PORE_PRESSURE], x[PORE_PRESSURE])
        return Outcome(work=Work(seepage=-work))

    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        water, at, dim = self._water, self._water.last, self._water.last.dim
        conductivity, change = water.water.conductivities(at.jacobian)
        factor, w, ratios = -water.size * at.volume, water.turned(at.drive), water.ratios
        # w = A drive: (kappa + J kappa_J) (G_a . w) D_b - kappa (G_b . w) G_a
        # - kappa (G_a . A G_b) grad p + kappa rho_w (da/du) A G_a N_b
        by_motion = np.zeros((len(w), 1, 1 + dim, dim, 1 + dim))
        by_motion[:, 0, 1:] = np.einsum("n,nk,njl->nkjl", conductivity + change, w, at.divergence())
        for k in range(dim):
            by_motion[:, 0, 1 + k, k, 1:] -= conductivity[:, None] * w
            own = conductivity[:, None] * ratios[:, k]
            by_motion[:, 0, 1 + k, :, 1:] -= np.einsum("nl,nj->njl", own, at.gradient)
            by_motion[:, 0, 1 + k, :, 0] += own * water.inertia_by_motion
        by_motion *= factor[:, None, None, None, None]
        self._add(matrix, (PORE_PRESSURE, DISPLACEMENT), at, by_motion)
        by_pressure = np.zeros((len(w), 1, 1 + dim, 1, 1 + dim))
        for k in range(dim):
            by_pressure[:, 0, 1 + k, 0, 1:] = (factor * conductivity)[:, None] * ratios[:, k]
        self._add(matrix, (PORE_PRESSURE, PORE_PRESSURE), at, by_pressure)
