# SPDX-License-Identifier: BSD-3-Clause
"""A column of soil under a rigid plate on springs: one settlement that belongs to no node."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from small_problems import dimension, plane

from tilth import Model
from tilth.algebra.border import Border
from tilth.analysis.residual import Newton
from tilth.analysis.simulation import Simulation
from tilth.analysis.step import Equilibrium, solve_step
from tilth.arrays import Floats
from tilth.boundaries import Conditions
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.pattern import Elements
from tilth.solvers import LinearSolver
from tilth.terms.balance import Balance
from tilth.terms.protocol import AssembledTerm, GlobalUnknowns, Term
from tilth.terms.soil_forces import SoilForces
from tilth.terms.space import Space, displacement_of

E, NU = 1000.0, 0.3
CONSTRAINED_MODULUS = E * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))
HEIGHT, WIDTH = 2.0, 1.2
CELL = {2: [0.4, 0.25], 3: [0.4, 0.6, 0.25]}


class Plate(Term, GlobalUnknowns):
    """Springs k (d + (d/l)^2 d) of shortening d between nodes and a plate that settles by w / unit.

    Args:
        active: the grid; the plate stands on its uppermost nodes.
        modulus: k over the area [stress/length].
        hardening: l [length]; infinite for linear springs.
        force: on the plate, downwards [force].
        unit: of the settlement: how many of them are a length of one.
    """

    def __init__(
        self, active: ActiveGrid, modulus: float, hardening: float, force: float, unit: float = 1.0
    ) -> None:
        place = active.position
        top = place[:, -1] > place[:, -1].max() - 0.5 * active.grid.cell_size[-1]
        area = np.where(top, np.prod(active.grid.cell_size[:-1]), 0.0)
        for k in range(active.grid.dim - 1):
            for side in (place[:, k].min(), place[:, k].max()):
                area[np.abs(place[:, k] - side) < 1e-6 * active.grid.cell_size[k]] *= 0.5
        self._stiffness, self._diagonal = modulus * area, active.diagonal
        self._hardening, self._force, self._unit = hardening, force, unit
        self.scale = np.array([1.0 / unit])

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        self._diagonal = space.active.diagonal
        return self

    def _shortening(self, displacement: Floats, unknowns: Floats) -> Floats:
        return displacement[:, -1] - unknowns[0] / self._unit

    def _tangent(self, displacement: Floats, unknowns: Floats) -> Floats:
        d = self._shortening(displacement, unknowns)
        return self._stiffness * (1.0 + 3.0 * (d / self._hardening) ** 2)

    def forces(self, displacement: Floats, unknowns: Floats) -> tuple[Floats, Floats]:
        d = self._shortening(displacement, unknowns)
        self._at = (displacement, unknowns)
        nodal = np.zeros_like(displacement)
        nodal[:, -1] = self._stiffness * (1.0 + (d / self._hardening) ** 2) * d
        return nodal, np.array([(self._force - nodal[:, -1].sum()) / self._unit])

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        blocks[self._diagonal, -1, -1] += self._tangent(*self._at)

    def border(self, displacement: Floats, unknowns: Floats) -> Border:
        column = np.zeros((1, *displacement.shape))
        tangent = self._tangent(displacement, unknowns)
        column[0, :, -1] = -tangent / self._unit
        corner = np.array([[tangent.sum() / self._unit**2]])
        return Border(column, column.copy(), corner, self.scale)


def column(kind: str, length: float = 1.0, stress: float = 1.0) -> Simulation:
    """A column that cannot widen, on a fixed base, of cells that are not cubes."""
    dim = dimension(kind)
    axes = "xyz"[:dim]
    upper = [WIDTH * length] * (dim - 1) + [HEIGHT * length]
    sides = [
        plane(f"{end} {axis}", axis, at * WIDTH * length)
        for axis in axes[:-1]
        for end, at in (("low", 0.0), ("high", 1.0))
    ]
    entries: dict[str, Any] = {
        "analysis": {"kind": kind},
        "grid": {"cell_size": [length * side for side in CELL[dim]]},
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": E * stress, "poisson_ratio": NU,
                     "density": 1.0}
        },
        "bodies": [
            {"name": "column", "material": "soil", "basis": "linear", "points_per_cell": 2,
             "shape": {"type": "box", "lower": [0.0] * dim, "upper": upper}}
        ],
        "boundaries": [*sides, plane("base", axes[-1], 0.0)],
        "schedule": {"steps": 1},
    }  # fmt: skip
    return Simulation(Model.from_dict(entries))


def conditions(simulation: Simulation, active: ActiveGrid) -> Conditions:
    return Conditions.gather(simulation.state.boundaries, active, 0.0, 1.0)


def plate_balance(simulation: Simulation, *plate: float) -> Balance:
    """The balance of the column and its plate, `plate` as the arguments of `Plate`."""
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    terms = [SoilForces(simulation.soil_on(active)), Plate(active, *plate)]
    return Balance(active, terms, [displacement_of(active, conditions(simulation, active))])


def equilibrium(simulation: Simulation, balance: Balance, solver: LinearSolver) -> Equilibrium:
    newton = Newton(1e-11, 30, line_search=False, round_off={})
    return solve_step(balance, replace(simulation.services, solver=solver), newton)
