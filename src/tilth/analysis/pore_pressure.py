# SPDX-License-Identifier: BSD-3-Clause
"""The excess pore pressure from step to step, and the terms of the water that flows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tilth.algebra.field import Field, GivenChange
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.flow_error import FlowError
from tilth.analysis.step_result import StepResult, outflow_of
from tilth.arrays import Flags, Floats, Integers, require_table
from tilth.boundaries.flow import FlowBoundaries
from tilth.grid.keys import find_keys
from tilth.model import Model
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import PRESSURE, PRESSURE_CHANGE, PoreWater
from tilth.terms.backward_difference import BackwardDifference
from tilth.terms.balance import Balance
from tilth.terms.ghost import Faces
from tilth.terms.inertia import Inertia
from tilth.terms.pore_water import PORE_PRESSURE, WATER, Seepage, StoredWater, WaterInStep
from tilth.terms.protocol import Term
from tilth.terms.water_stabilisation import GhostPressure, Projection, TiedPressure

if TYPE_CHECKING:
    from tilth.analysis.setup import InStep

SMALLEST_SHARE = 1e-12
"""Volume of soil at a node over the largest one, below which no soil is there."""


class PorePressure:
    """Has the excess pore pressure of the nodes; see `FieldOwner`.

    With a scheme of order 2 it also has what changed in the last step.

    Args:
        model: with flowing water.

    Attributes:
        name: of the field.
        key: of the nodes of the last step, shape (nodes,).
        value: their excess pore pressures [stress], shape (nodes, 1).
        change: of these in that step, shape (nodes, 1); (0, 1) if the scheme does not need it.
        drained: water that has left through each of all flow boundaries since the start
            [length^dim], in axisymmetry of the full circle, shape (boundaries,).
    """

    name = PORE_PRESSURE

    def __init__(self, model: Model) -> None:
        assert model.flow is not None
        self._flows = model.water_flows
        self._bulk_modulus = model.flow.bulk_modulus or np.inf
        self._density = model.flow.density or 0.0
        self._boundaries = FlowBoundaries(model)
        self._names = [each.name for each in model.all_flow_boundaries()]
        self.drained: Floats = np.zeros(len(self._names))
        self.key: Integers = np.zeros(0, dtype=np.int64)
        self.value: Floats = np.zeros((0, 1))
        self._second_order = model.flow.scheme == "bdf2"
        most = model.flow.largest_error
        self._error = None if most is None else FlowError(most)
        self._in_step: WaterInStep | None = None  # of the step that is prepared
        self.change: Floats = np.zeros((0, 1))
        self._last_size = 0.0  # 0: in this stage there was no step
        self._last_outflow: Floats = np.zeros(len(self._names))
        self._last_seepage = 0.0

    def in_step(self, of: InStep) -> Field:
        """As `FieldOwner.in_step`."""
        active, water = of.step.active, self._pores(of)
        nodal = of.soil.scatter((of.soil.points.volume * water.wet)[:, None])[:, 0]
        wet = nodal > SMALLEST_SHARE * active.comm.max(float(nodal.max(initial=0.0)))
        stabilised = self._stabilised(of, water)  # also nodes without soil
        wet |= stabilised
        wet = active.updated(wet)
        start = active.updated(self._at_nodes(self.value, PRESSURE, of, water, nodal))
        given = GivenChange(np.zeros(start.shape, dtype=bool), np.zeros(start.shape))
        if self._flows:
            held, value = self._boundaries.on_nodes(active, of.step.after, stabilised)
            given = GivenChange(held, np.where(held, value - start, 0.0))
        return Field(PORE_PRESSURE, active, 1, WATER, None, wet, start, given)

    def terms(self, of: InStep, inertia: Inertia | None = None) -> Sequence[Term]:
        """Returns the terms of the water in a step; inertia: of the soil, None without."""
        formula = self._formula(of.step.after - of.step.before)
        water, active = self._pores(of), of.step.active
        change: Floats | float = 0.0
        if formula.ratio > 0.0:
            nodal = of.soil.scatter((of.soil.points.volume * water.wet)[:, None])[:, 0]
            found = self._at_nodes(self.change, PRESSURE_CHANGE, of, water, nodal)
            change = active.updated(found)

        def keep(pressure: Floats, before: Floats) -> None:
            self.key, self.value = active.key.copy(), pressure.copy()
            if self._second_order:
                self.change = pressure - before
            if self._error is not None:
                self._error.commit()

        here = WaterInStep(of.soil, water, formula, keep, change, inertia, self._density)
        self._in_step = here
        terms: list[Term] = [
            StoredWater(here), Seepage(here), Projection(here),
            GhostPressure(here, self._faces(of, water)),
            TiedPressure(here, self._stabilised(of, water)),
        ]  # fmt: skip
        if self._flows:
            surfaces = of.state.surfaces
            terms += self._boundaries.terms(here, surfaces, of.step.before, of.step.after)
        return terms

    def possible_size(self, balance: Balance, x: Unknowns) -> float:
        """As `FlowError.possible_size`, of the step that is prepared."""
        if self._error is None:
            return math.inf
        assert self._in_step is not None
        return self._error.possible_size(self._in_step, balance, x, self.key)

    def with_discharge(self, result: StepResult, size: float) -> StepResult:
        """Returns the result of a step with what flows out through the planes; adds up all flow.

        With order 2 what flows and what it dissipates in a step have w times that of the last one,
        as the water that the pores take up.

        All processes call it after the step of this size [time] has converged.
        """
        outflow = dict(result.outflow)
        if self._flows:
            reaction = result.equilibrium.reactions[PORE_PRESSURE]
            for name, nodal in self._boundaries.outflow_of_nodes(reaction).items():
                outflow[name] = outflow_of(result.active, nodal)
        seepage = result.seepage_work
        if (carried := self._formula(size).of_last_change) > 0.0:
            for name, last in zip(self._names, self._last_outflow, strict=True):
                outflow[name] = outflow.get(name, 0.0) + carried * float(last)
            seepage += carried * self._last_seepage
        self._last_outflow = np.array([outflow.get(name, 0.0) for name in self._names])
        self._last_seepage, self._last_size = seepage, size
        self.drained = self.drained + self._last_outflow
        return replace(result, outflow=outflow, size=size, seepage_work=seepage)

    def drained_through(self, name: str) -> float:
        """Returns the water that has left through a flow boundary since the start."""
        return float(self.drained[self._names.index(name)])

    def require_soil(self, points: MaterialPoints, active: ActiveGrid) -> None:
        """As `FlowBoundaries.require_soil`."""
        if self._flows:
            self._boundaries.require_soil(points, active)

    def go_on_from(self, last: PorePressure, same_grid: bool) -> None:
        """Takes over from the last stage; the nodes' pressures if they are the same nodes."""
        self.drained = last.drained
        if same_grid:
            self.key, self.value = last.key, last.value
            if self._second_order:
                self.change = np.zeros_like(self.value)
            if self._error is not None:
                self._error.rate = np.zeros_like(self.value)

    def _formula(self, size: float) -> BackwardDifference:
        """Returns that of a step of a size [time] after the last one."""
        return BackwardDifference.after(self._last_size if self._second_order else 0.0, size)

    def _pores(self, of: InStep) -> PoreWater:
        points = of.soil.points
        return PoreWater.of(points, points.water, self._bulk_modulus, self._flows)

    def _faces(self, of: InStep, water: PoreWater) -> Sequence[Faces]:
        """Returns the faces with the ghost term: those beside wet soil."""
        faces, active = of.state.ghost.faces, of.step.active
        if active.comm.max(float(not water.wet.all())) == 0.0:
            return faces
        nodal = of.soil.scatter(water.wet.astype(float)[:, None])[:, 0]
        wet = active.updated(nodal) > 0.0
        corners = 2**active.grid.dim  # a whole cell beside the face has wet soil
        return [each.of(wet[each.node].sum(axis=1) >= corners) for each in faces]

    def _stabilised(self, of: InStep, water: PoreWater) -> Flags:
        """Returns which nodes the ghost term holds, shape (nodes,); all processes call it."""
        active = of.step.active
        stabilised = np.zeros(active.nodes, dtype=bool)
        for faces in self._faces(of, water):
            stabilised[faces.node] = True
        return active.updated(stabilised)

    def _at_nodes(
        self, kept: Floats, column: int, of: InStep, water: PoreWater, volume: Floats
    ) -> Floats:
        """Returns what the nodes keep of the last step at those of this one, shape (nodes, 1).

        Nodes that are new have the mean of the points around, those without soil that of the other
        nodes of their faces.

        kept: of the nodes of the last step. column: of the water of the points, with the same.
        volume: of wet soil at the nodes, shape (nodes,).
        """
        active, points = of.step.active, of.soil.points
        weight = points.volume * water.wet * points.water[:, column]
        start = of.soil.scatter(weight[:, None]) / np.maximum(volume, 1e-300)[:, None]
        found = find_keys(self.key, active.key)
        known = found >= 0
        start[known] = kept[found[known]]
        known |= volume > 0.0
        for faces in self._faces(of, water):
            missing = ~known[faces.node]
            rows = np.flatnonzero(missing.any(axis=1) & ~missing.all(axis=1))
            node, unknown = faces.node[rows], missing[rows]
            share = (~unknown) / (~unknown).sum(axis=1, keepdims=True)
            mean = (share * start[node, 0]).sum(axis=1)
            start[node[unknown], 0] = np.broadcast_to(mean[:, None], node.shape)[unknown]
        return np.asarray(start)

    def rows(self) -> tuple[Integers, list[str]]:
        """As `KeyedRows.rows`."""
        names = ["key", "value"]
        if self._second_order:
            names.append("change")
        if self._error is not None:
            names.append("rate")
        return self.key, names

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """As `Stateful.state`."""
        found = {"key": self.key, "value": self.value, "drained": self.drained}
        if self._second_order:
            found["change"], found["last_outflow"] = self.change, self._last_outflow
            found["last_size"] = np.array([self._last_size])
            found["last_seepage"] = np.array([self._last_seepage])
        if self._error is not None:
            found["rate"] = self._error.rate
        return found

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """As `Stateful.restore`."""
        for name, array in state.items():
            if name in ("drained", "last_outflow") and array.shape != self.drained.shape:
                raise ValueError(f"{name!r} is not of the declared flow boundaries")
            if name in ("last_size", "last_seepage") and array.shape != (1,):
                raise ValueError(f"{name!r} is not a single number")
        _, rows = self.rows()
        require_table({name: state[name] for name in rows}, increasing="key")
        self.key, self.value = state["key"], state["value"]
        self.drained = state["drained"]
        if self._second_order:
            self.change, self._last_outflow = state["change"], state["last_outflow"]
            self._last_size = float(state["last_size"][0])
            self._last_seepage = float(state["last_seepage"][0])
        if self._error is not None:
            self._error.rate = state["rate"]
