# SPDX-License-Identifier: BSD-3-Clause
"""Runs with contact: displacement and forces in each step, and the contact at the end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.errors import AnalysisFailed
from tilth.model import Model
from tilth.terms.outcome import ContactState
from tilth_verification.curves import Curve


@dataclass(frozen=True)
class ContactRun:
    """What a model's first tracked boundary, body or pair did; n steps, `dim` is 2 or 3.

    Attributes:
        time: at the end of each step, shape (n,).
        displacement: of the rigid body of this name [length], shape (n, dim); zero for others.
        force: of each boundary and body on the soil, of each contact pair on its second body, by
            name [force], shape (n, dim).
        contacts: their contact at the end, by name.
        area: of the first one in contact, shape (n,) [length^(dim - 1)].
        end: the soil at the end.
    """

    time: Floats
    displacement: Floats
    force: dict[str, Floats]
    contacts: dict[str, ContactState]
    area: Floats
    end: Simulation

    def curve(self, name: str, axis: int, scale: float) -> Curve:
        """Returns scale times the force along an axis against the length of the displacement."""
        way = np.linalg.norm(self.displacement, axis=1)
        return Curve(way, scale * self.force[name][:, axis])


def run_contact(model: Model, *, may_fail: bool = False) -> ContactRun:
    """Runs a model.

    may_fail: whether a run that stops before the end of its schedule is a result as well.

    Raises:
        AnalysisFailed: it stops, and this is no result.
    """
    name = model.track[0].boundary
    assert name is not None
    acting = (*model.boundaries, *model.rigid_bodies, *model.contact_pairs)
    names = [each.name for each in acting]
    rows: list[tuple[float, Floats, dict[str, Floats], float]] = []
    last: list[tuple[Simulation, StepResult]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        body = simulation.state.rigid_bodies.get(name)
        moved = np.zeros(model.dimension) if body is None else body.displacement.copy()
        forces = {each: result.resultant(each) for each in names}
        touching = result.contacts.get(name)
        rows.append((time, moved, forces, 0.0 if touching is None else touching.area))
        last[:] = [(simulation, result)]

    try:
        march(model, after_step)
    except AnalysisFailed:
        if not (may_fail and rows):
            raise
    time, moved, forces, area = zip(*rows, strict=True)
    by_name = {each: np.array([step[each] for step in forces]) for each in names}
    simulation, result = last[0]
    return ContactRun(
        np.array(time), np.array(moved), by_name, result.contacts, np.array(area), simulation
    )


def fitted_ellipse(state: ContactState, distance: Floats) -> tuple[float, float]:
    """Returns p0 [stress] and a [length] of the pressure p0 sqrt(1 - (x / a)^2) that fits best.

    By least squares of p^2 = p0^2 - (p0 / a)^2 x^2 over the points in contact, weighted by area;
    NaN if the pressure does not fall from the middle to the rim.

    Args:
        distance: of the points from the middle [length], shape (n,).
    """
    touching = state.in_contact & (state.normal_stress < 0.0)
    weight = np.sqrt(state.weight[touching])
    columns = np.column_stack([np.ones(touching.sum()), -(distance[touching] ** 2)])
    squares = state.normal_stress[touching] ** 2
    (peak, slope), *_ = np.linalg.lstsq(columns * weight[:, None], squares * weight, rcond=None)
    if not (peak > 0.0 and slope > 0.0):
        return np.nan, np.nan
    return float(np.sqrt(peak)), float(np.sqrt(peak / slope))


def spread(value: Floats, weight: Floats) -> float:
    """Returns the coefficient of variation of a quantity, weighted by area [-]."""
    mean = np.average(value, weights=weight)
    return float(np.sqrt(np.average((value - mean) ** 2, weights=weight)) / abs(mean))
