# SPDX-License-Identifier: BSD-3-Clause
"""A scalar coupled to the displacement, as a second field for tests: Biot's linear consolidation.

    -div(s - s0 p 1) = 0,   d(storage p + s0 tr strain)/dt - div(k (1 + b p) grad p) = source

The scalar p is kept at the nodes. Rows of p are minus the balance of volume, so that the matrix is
symmetric for b = 0. `b` makes the flow depend on p; it is no physics.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.algebra.block_matrix import BlockMatrix, Pair
from tilth.algebra.field import Field, GivenChange
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.setup import InStep, Maker
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_terms import TERMS
from tilth.arrays import Flags, Floats, Integers
from tilth.grid.keys import find_keys
from tilth.model import Model
from tilth.mpm.pattern import Elements
from tilth.mpm.point_integrals import PointIntegrals
from tilth.terms.protocol import AssembledTerm, Role, Term
from tilth.terms.space import Space
from tilth.terms.weak_springs import covered_nodes

NAME = "p"


@dataclass
class Scalar:
    """Values of the scalar at nodes from step to step, and its parameters.

    Attributes:
        conductivity: k [length^4/(force time)].
        storage: volume per scalar [1/stress].
        coupling: s0 [-].
        nonlinear: b [1/stress].
        source: volume per volume and time at points, for their positions.
        drained: which nodes have a given value, for their positions.
        given: that value [stress].
        wet: on which nodes the scalar is there, for their positions; everywhere if None.
        unit: a stress in the unit of the scalar [-].
        bulk: drained constrained modulus [stress], for the preconditioner.
    """

    conductivity: float
    storage: float = 0.0
    coupling: float = 1.0
    nonlinear: float = 0.0
    source: float = 0.0
    drained: Callable[[Floats], Flags] = lambda x: np.zeros(len(x), dtype=bool)
    given: float = 0.0
    wet: Callable[[Floats], Flags] | None = None
    unit: float = 1.0
    bulk: float = np.inf
    name: str = NAME
    key: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    value: Floats = field(default_factory=lambda: np.zeros((0, 1)))

    def in_step(self, of: InStep) -> Field:
        """As `FieldOwner.in_step`; 0 at nodes that are new, and that hardly any soil reaches."""
        active = of.step.active
        start, found = np.zeros((active.nodes, 1)), find_keys(self.key, active.key)
        start[found >= 0] = self.value[found[found >= 0]]
        start = active.updated(start)
        held = self.drained(active.position)[:, None]
        given = GivenChange(held, np.where(held, self.given - start, 0.0))
        wet = active.updated(covered_nodes(of.soil))
        if self.wet is not None:
            wet = wet & self.wet(active.position)
        scale = np.array([1.0 / self.unit])
        return Field(self.name, active, 1, "volume", scale, wet, start, given)

    def rows(self) -> tuple[Integers, list[str]]:
        """As `KeyedRows.rows`."""
        return self.key, ["key", "value"]

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """As `Stateful.state`."""
        return {"key": self.key, "value": self.value}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """As `Stateful.restore`."""
        self.key, self.value = state["key"], state["value"]

    def terms(self) -> Maker:
        """A maker of both terms."""
        return lambda of: [Stored(self, of), Flow(self, of)]


class _OfScalar(Term):
    def __init__(self, scalar: Scalar, of: InStep) -> None:
        self.scalar, self.of = scalar, of

    @property
    def pairs_at_points(self) -> Sequence[Pair]:
        return [("u", NAME), (NAME, NAME)]


class Stored(_OfScalar):
    """Volume that the soil takes up, and the force of the scalar on the soil."""

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        return _Stored(self.scalar, self.of, space)


class Flow(_OfScalar):
    """What flows through the soil, and its sources."""

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        return _Flow(self.scalar, self.of, space)


class _Assembled(AssembledTerm):
    def __init__(self, scalar: Scalar, of: InStep, space: Space) -> None:
        self.scalar, self.space, self.size = scalar, space, of.step.size
        self.points = PointIntegrals(of.step.active)
        self.dim = of.step.active.grid.dim
        self.volume = of.soil.points.volume
        self.start = space.fields[NAME].first()

    def add(self, matrix: BlockMatrix, pair: Pair, of_points: Floats) -> None:
        positions, block = self.space.positions(pair), matrix[pair]
        self.points.add_blocks(positions, of_points, block.values)

    def of_points(self, rows: int, columns: int) -> Floats:
        return np.zeros((len(self.volume), rows, 1 + self.dim, columns, 1 + self.dim))


class _Stored(_Assembled):
    role = Role.STORAGE

    def evaluate(self, x: Unknowns) -> Unknowns:
        scalar, unit = self.scalar, self.scalar.unit
        p = self.points.interpolated(x[NAME])[:, 0] / unit
        before = self.points.interpolated(self.start)[:, 0] / unit
        stress = -scalar.coupling * self.volume * p
        force = self.points.scattered_gradient(stress[:, None, None] * np.eye(self.dim))
        strain = np.trace(self.points.gradient(x.u), axis1=1, axis2=2)
        taken = self.volume * (scalar.storage * (p - before) + scalar.coupling * strain)
        return Unknowns({"u": force, NAME: -self.points.scattered(taken[:, None]) / unit})

    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        scalar, unit = self.scalar, self.scalar.unit
        coupled, stored = self.of_points(self.dim, 1), self.of_points(1, 1)
        for k in range(self.dim):
            coupled[:, k, 1 + k, 0, 0] = -scalar.coupling * self.volume / unit
        stored[:, 0, 0, 0, 0] = -scalar.storage * self.volume / unit**2
        self.add(matrix, ("u", NAME), coupled)
        self.add(matrix, (NAME, "u"), np.ascontiguousarray(coupled.transpose(0, 3, 4, 1, 2)))
        self.add(matrix, (NAME, NAME), stored)

    def add_schur(self, x: Unknowns, schur: Mapping[str, Floats]) -> None:
        mass = self.of_points(1, 1)
        scalar = self.scalar
        mass[:, 0, 0, 0, 0] = -(scalar.coupling**2) / scalar.bulk * self.volume / scalar.unit**2
        self.points.add_blocks(self.space.positions((NAME, NAME)), mass, schur[NAME])

    def commit(self, x: Unknowns, checked: None) -> None:
        self.scalar.key = self.space.active.key.copy()
        self.scalar.value = x[NAME].copy()


class _Flow(_Assembled):
    role = Role.FLOW

    def _at(self, x: Unknowns) -> tuple[Floats, Floats]:
        unit = self.scalar.unit
        p = self.points.interpolated(x[NAME])[:, 0] / unit
        return p, self.points.gradient(x[NAME])[:, 0] / unit

    def evaluate(self, x: Unknowns) -> Unknowns:
        scalar = self.scalar
        p, gradient = self._at(x)
        conductivity = self.size * scalar.conductivity * (1.0 + scalar.nonlinear * p)
        flux = (self.volume * conductivity)[:, None, None] * gradient[:, None]
        source = np.full((len(p), 1), self.size * scalar.source) * self.volume[:, None]
        flow = self.points.scattered_gradient(flux) - self.points.scattered(source)
        return Unknowns({NAME: -flow / scalar.unit})

    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        scalar = self.scalar
        p, gradient = self._at(x)
        factor = self.size * scalar.conductivity * self.volume / scalar.unit**2
        of_points = self.of_points(1, 1)
        for k in range(self.dim):
            of_points[:, 0, 1 + k, 0, 1 + k] = -factor * (1.0 + scalar.nonlinear * p)
            of_points[:, 0, 1 + k, 0, 0] = -factor * scalar.nonlinear * gradient[:, k]
        self.add(matrix, (NAME, NAME), of_points)


def with_scalar(model: Model, scalar: Scalar, **arguments: Any) -> Simulation:
    """A simulation with the scalar."""
    return Simulation(model, terms=[*TERMS, scalar.terms()], fields=[scalar], **arguments)
