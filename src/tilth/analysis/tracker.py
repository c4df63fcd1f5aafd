# SPDX-License-Identifier: BSD-3-Clause
"""Tracked quantities: what a column of the history is after each step.

What is not there in a stage, such as the displacement of soil that is placed later, is "not a
number"; the reaction of a boundary that does not act is 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tilth.analysis.embedment import Embedment
from tilth.analysis.energies import Energies
from tilth.analysis.motions import area_unit, force_unit, moment_unit
from tilth.analysis.rigid_shapes import placed
from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats, Integers
from tilth.model import Model, Track
from tilth.model.fields import AXES
from tilth.model.track import OF_RELAXATION
from tilth.mpm.domains import upper_edges
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import STORED
from tilth.mpm.water import PhreaticSurface
from tilth.mpm.wet_mass import (
    effective_stress,
    excess_pore_pressure,
    pore_pressure,
    total_stress,
)
from tilth.terms.loads import nearest_points

TENSOR = ("xx", "yy", "zz", "xy", "yz", "xz")

OF_STRESS = ("stress", "effective_stress", "pore_pressure", "excess_pore_pressure")
"""Quantities with the unit of stress."""


class Tracker:
    """Evaluates the tracked quantities of a model.

    Args:
        model: the declared problem.
        initial: its points before the first step, for the nearest point to a given position.

    Attributes:
        columns: (name, unit label) of each quantity.
    """

    def __init__(self, model: Model, initial: MaterialPoints) -> None:
        self._model = model
        self.columns = tracked_columns(model)
        self._evaluate = [self._evaluation(track, initial) for track in model.track]

    def values(
        self,
        setup: Setup,
        state: State,
        result: StepResult | None,
        energies: Energies,
    ) -> list[float]:
        """Returns the quantities after a step (`result` None: before the first one)."""
        values = [
            track.scale * evaluate(setup, state, result, energies)
            for track, evaluate in zip(self._model.track, self._evaluate, strict=True)
        ]
        if self._model.analysis.beyond_limit == "stop":
            return values
        relaxing = None if result is None else result.relaxing
        if relaxing is None:
            return [*values, 0.0, 0.0, 0.0]
        return [*values, relaxing.number, relaxing.energy, relaxing.work]

    def _evaluation(
        self, track: Track, initial: MaterialPoints
    ) -> Callable[[Setup, State, StepResult | None, Energies], float]:
        if track.quantity == "reaction":
            return lambda setup, state, result, energies: _reaction(track, state, result)
        if track.quantity == "moment":
            return lambda setup, state, result, energies: _moment(track, self._model, state, result)
        if track.quantity in ("rigid_displacement", "rigid_rotation"):
            return lambda setup, state, result, energies: _rigid(track, setup.model, state)
        if track.quantity == "contact_area":
            return lambda setup, state, result, energies: _contact_area(track, result)
        if track.quantity == "embedment":
            embedment = Embedment(track, self._model, initial)
            return lambda setup, state, result, energies: embedment.depth(setup, state, result)
        if track.quantity == "penetration":
            return lambda setup, state, result, energies: _penetration(track, state, result)
        if track.quantity in ("discharge", "drained_volume"):
            return lambda setup, state, result, energies: _flow(track, state, result)
        if track.quantity == "stored_water":
            return lambda setup, state, result, energies: _stored_water(track, state)
        if track.at is not None:
            ids = nearest_points(initial, track.at, self._model.cell_size, track.body)
            if track.quantity == "state":
                return lambda setup, state, result, energies: _state(track, state, ids)

            def of_points(
                setup: Setup, state: State, result: StepResult | None, energies: Energies
            ) -> float:
                time = 0.0 if result is None else result.time
                values = _values(track, state.points, setup.water, time)
                there = _there(state, ids, values)
                if len(there) == 0:
                    return math.nan
                mean = there.mean(axis=0)
                return _component(mean, track.component) if track.component else float(mean)

            return of_points
        if track.quantity == "enclosed":
            name = track.body or ""
            return lambda setup, state, result, energies: _enclosed(state, name)
        if track.quantity in ("top_height", "run_out"):
            axis = self._model.dimension - 1 if track.axis is None else AXES.index(track.axis)
            return lambda setup, state, result, energies: _extent(track, state, axis)
        kind = track.kind or ""
        return lambda setup, state, result, energies: energies.value(
            kind, setup, state, 0.0 if result is None else result.time
        )


def tracked_columns(model: Model) -> list[tuple[str, str]]:
    """Returns name and unit label of each tracked quantity, and of what tells of relaxations."""
    energy = moment_unit(model)
    tracked = [(track.name, unit_of(track, model)) for track in model.track]
    if model.analysis.beyond_limit == "stop":
        return tracked
    return [*tracked, *zip(OF_RELAXATION, ("", energy, energy), strict=True)]


def unit_of(track: Track, model: Model) -> str:
    """Returns the label of a tracked quantity's unit."""
    units = model.units
    if track.unit is not None:
        return track.unit
    if track.quantity == "reaction":
        return force_unit(model)
    if track.quantity == "rigid_rotation":
        return "degrees"
    if track.quantity == "contact_area":
        return area_unit(model)
    if track.quantity in OF_STRESS:
        return units.stress
    if track.quantity in ("velocity", "acceleration"):
        return rate_unit(model, 1 if track.quantity == "velocity" else 2)
    if track.quantity == "state":
        return units.stress if model.state_units()[track.variable or ""] == "stress" else ""
    if track.quantity == "enclosed":
        return f"{units.length}^{model.dimension}"
    if track.quantity in ("discharge", "drained_volume", "stored_water"):
        return water_unit(model, per_time=track.quantity == "discharge")
    if track.quantity in ("energy", "moment"):
        return moment_unit(model)
    return units.length


def rate_unit(model: Model, order: int) -> str:
    """Returns the label of a velocity (order 1) or an acceleration (2); empty without labels."""
    length, time = model.units.length, model.units.time
    if not (length and time):
        return ""
    return f"{length}/{time}" if order == 1 else f"{length}/{time}^2"


def water_unit(model: Model, per_time: bool) -> str:
    """Returns the label of a volume of water, per length in plane strain; without labels none."""
    length, time = model.units.length, model.units.time
    if not (length and time):
        return ""
    volume = f"{length}^3/{length}" if model.analysis.kind == "plane_strain" else f"{length}^3"
    return f"{volume}/{time}" if per_time else volume


def _reaction(track: Track, state: State, result: StepResult | None) -> float:
    name, component = track.boundary or "", AXES.index(track.component)
    if result is None:
        return 0.0
    if name in state.rigid_bodies:
        return 0.0 - float(state.rigid_bodies[name].force[component])
    return float(result.resultant(name)[component]) if name in result.forces else 0.0


def _moment(track: Track, model: Model, state: State, result: StepResult | None) -> float:
    name, component = track.boundary or "", AXES.index(track.component)
    if result is None:
        return 0.0
    if name in state.rigid_bodies:
        body = state.rigid_bodies[name]
        moment = body.moment
        if track.about is not None:
            declared = next(each for each in model.rigid_bodies if each.name == name)
            arm = np.array(declared.centre) + body.displacement - np.array(track.about)
            three = (0, 3 - len(arm))
            moment = moment + np.cross(np.pad(arm, three), np.pad(body.force, three))
        return 0.0 - float(moment[component])
    if name not in result.forces:
        return 0.0
    return float(result.moment(name, np.array(track.about))[component])


def _rigid(track: Track, model: Model, state: State) -> float:
    if all(body.name != track.boundary for body in model.rigid_bodies):
        return math.nan
    displacement, rotation = placed(state, track.boundary or "")
    if track.quantity == "rigid_rotation":
        return math.degrees(rotation[AXES.index(track.component)])
    return _component(displacement, track.component or "")


def _contact_area(track: Track, result: StepResult | None) -> float:
    name = track.boundary or ""
    if result is None:
        return 0.0
    return result.contacts[name].area if name in result.contacts else result.areas.get(name, 0.0)


def _penetration(track: Track, state: State, result: StepResult | None) -> float:
    boundary = next((b for b in state.implicit if b.name == track.boundary), None)
    if boundary is None:
        return math.nan
    time = 0.0 if result is None else result.time
    return state.comm.max(boundary.penetration(state.points.position, time))


def _state(track: Track, state: State, ids: Integers) -> float:
    values = state.points.state_variable(track.variable or "")
    there = _there(state, ids, values)
    return float(there.mean()) if len(there) else math.nan


def _there(state: State, ids: Integers, values: Floats) -> Floats:
    """Returns the values (n, ...) at those of the points that are there, of all processes."""
    index = state.points.index_of(ids)
    index = index[index >= 0]
    index = index[state.distribution.own[index]]
    found = state.comm.gathered((state.points.point_id[index], values[index]))
    order = np.argsort(np.concatenate([number for number, _ in found]), kind="stable")
    return np.concatenate([each for _, each in found])[order]


def _flow(track: Track, state: State, result: StepResult | None) -> float:
    name = track.boundary or ""
    if track.quantity == "discharge":
        return 0.0 if result is None else result.discharge(name)
    assert state.pore_pressure is not None
    return state.pore_pressure.drained_through(name)


def _stored_water(track: Track, state: State) -> float:
    points = state.owned_points
    stored = points.initial_volume * points.water[:, STORED]
    own = slice(None) if track.body is None else points.of_body(track.body)
    return state.comm.sum(float(stored[own].sum()))


def _enclosed(state: State, name: str) -> float:
    if name not in state.surfaces:
        return math.nan
    return state.surfaces[name].enclosed()


def _values(
    track: Track, points: MaterialPoints, water: PhreaticSurface | None, time: float
) -> Floats:
    """Returns the quantity that is tracked at points, of all points, (n, k) or (n,)."""
    if track.quantity == "displacement":
        return points.displacement
    if track.quantity in ("velocity", "acceleration"):
        return points.motion[:, ("velocity", "acceleration").index(track.quantity)]
    if track.quantity == "effective_stress":
        return effective_stress(points)
    if track.quantity == "pore_pressure":
        return pore_pressure(points, water, time)
    if track.quantity == "excess_pore_pressure":
        return excess_pore_pressure(points)
    return total_stress(points, water, time)


def _component(value: Floats, name: str) -> float:
    """Component of a vector, or of a symmetric tensor in six components."""
    if name == "magnitude":
        return float(np.linalg.norm(value))
    if name == "mean":
        return float(value[:3].mean())
    if name == "von_mises":
        deviator = value.copy()
        deviator[:3] -= value[:3].mean()
        return float(np.sqrt(1.5 * (deviator[:3] ** 2).sum() + 3.0 * (deviator[3:] ** 2).sum()))
    return float(value[(AXES if len(value) < 6 else TENSOR).index(name)])


def _extent(track: Track, state: State, axis: int) -> float:
    points, comm = state.points, state.comm
    chosen = np.arange(len(points))
    if track.body is not None:
        chosen = chosen[points.of_body(track.body)]
    chosen = chosen[state.distribution.own[chosen]]
    upper = (upper_edges(points) if track.of == "domains" else points.position)[chosen, axis]
    if track.share is None:
        most = comm.max(float(upper.max(initial=-math.inf)))
        return most if math.isfinite(most) else math.nan
    found = comm.gathered((upper, points.initial_volume[chosen]))
    upper, each = (np.concatenate(parts) for parts in zip(*found, strict=True))
    if len(upper) == 0:
        return math.nan
    order = np.argsort(upper)
    volume = np.cumsum(each[order])
    return float(upper[order][np.searchsorted(volume, track.share * volume[-1])])
