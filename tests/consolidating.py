# SPDX-License-Identifier: BSD-3-Clause
"""Soil with pore water that flows, for tests of its terms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth import Model
from tilth.algebra.field import Field, GivenChange
from tilth.analysis.setup import InStep, Maker
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_terms import TERMS
from tilth.arrays import Flags, Floats, Integers
from tilth.grid.keys import find_keys
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import CONSTANT, Permeability, PoreWater
from tilth.terms.backward_difference import BackwardDifference
from tilth.terms.pore_water import PORE_PRESSURE, WATER, Seepage, StoredWater, WaterInStep
from tilth.terms.protocol import Term
from tilth.terms.water_stabilisation import GhostPressure, Projection


@dataclass
class Pores:
    """Pore water of a uniform soil, drained where its pressure is given.

    Attributes:
        porosity, conductivity, permeability, bulk_modulus: as those of `PoreWater`.
        drained: which nodes have no excess pressure, for their positions.
        stabilised: whether the pressure is projected.
        stiffness: a modulus, for the scale of the pressure [stress].
    """

    porosity: float = 0.5
    conductivity: float = 1.0
    permeability: Permeability = CONSTANT
    bulk_modulus: float = np.inf
    drained: Callable[[Floats], Flags] = lambda x: np.zeros(len(x), dtype=bool)
    stabilised: bool = True
    name: str = PORE_PRESSURE
    key: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    value: Floats = field(default_factory=lambda: np.zeros((0, 1)))

    def of(self, points: MaterialPoints) -> PoreWater:
        """Pores and water of points."""
        n = len(points)
        return PoreWater(
            np.full(n, self.porosity), np.full(n, self.conductivity),
            [(slice(None), self.permeability)], self.bulk_modulus,
        )  # fmt: skip

    def in_step(self, of: InStep) -> Field:
        """As `FieldOwner.in_step`."""
        active = of.step.active
        found = find_keys(self.key, active.key)
        start = np.zeros((active.nodes, 1))
        start[found >= 0] = self.value[found[found >= 0]]
        held = self.drained(active.position)[:, None]
        given = GivenChange(held, np.where(held, -start, 0.0))
        wet = of.soil.nodal_volume > 1e-12 * of.soil.nodal_volume.max()
        for faces in of.state.ghost.faces:  # which extend the pressure to nodes without soil
            wet[faces.node] = True
        return Field(PORE_PRESSURE, active, 1, WATER, None, wet, start, given)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """As `Stateful.state`."""
        return {"key": self.key, "value": self.value}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """As `Stateful.restore`."""
        self.key, self.value = state["key"], state["value"]

    def terms(self) -> Maker:
        """A maker of the terms of water."""

        def make(of: InStep) -> Any:
            def keep(pressure: Floats, before: Floats) -> None:
                self.key, self.value = of.step.active.key.copy(), pressure.copy()

            formula = BackwardDifference(of.step.size)
            water = WaterInStep(of.soil, self.of(of.soil.points), formula, keep)
            terms: list[Term] = [StoredWater(water), Seepage(water)]
            if self.stabilised:
                terms += [Projection(water), GhostPressure(water, of.state.ghost.faces)]
            return terms

        return make


def with_pores(model: Model, pores: Pores) -> Simulation:
    """A simulation whose points are full of water without excess pressure."""
    simulation = Simulation(model, terms=[*TERMS, pores.terms()], fields=[pores])
    points = simulation.state.points
    water = pores.of(points)
    jacobian, pressure = np.linalg.det(points.deformation_gradient), np.zeros(len(points))
    stored = water.stored(jacobian, pressure)
    at_rest = np.zeros_like(points.position)
    points.water = np.column_stack([stored, pressure, water.porosity, water.conductivity, at_rest])
    return simulation


def with_flow(
    entries: dict[str, Any],
    boundaries: list[dict[str, Any]],
    scheme: str = "backward_euler",
    density: float | None = None,
    largest_error: float | None = None,
    **water: Any,
) -> Model:
    """A model whose material has water in its pores, with the values of `Pores`, by the input.

    density, largest_error: of the flow, whose unit weight is 1.
    water: further entries of the material.
    """
    entries["flow"] = {
        "unit_weight": 1.0, "boundaries": boundaries, "scheme": scheme, "density": density,
        "largest_error": largest_error,
    }  # fmt: skip
    entries["units"] = {"time": "s", **entries.get("units", {})}
    own = {"porosity": 0.5, "hydraulic_conductivity": 1.0, **water}
    entries["materials"]["soil"] = {**entries["materials"]["soil"], **own}
    return Model.from_dict(entries)
