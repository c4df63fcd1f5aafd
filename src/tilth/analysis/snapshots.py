# SPDX-License-Identifier: BSD-3-Clause
"""The state of an analysis for the results file."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.analysis.setup import Setup
from tilth.analysis.staged import PointFields
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats, Integers
from tilth.model import Model
from tilth.model.laws import EXCESS_PORE_PRESSURE
from tilth.model.settings import DARCY_VELOCITY
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.wet_mass import (
    darcy_velocity,
    effective_stress,
    excess_pore_pressure,
    pore_pressure,
    total_stress,
)
from tilth.output import Snapshot
from tilth.output.snapshot import FieldsOnDemand


def snapshot(
    setup: Setup,
    state: State,
    active: ActiveGrid,
    result: StepResult | None,
    step: int,
    time: float,
    names: PointFields | None = None,
) -> Snapshot:
    """Returns the state for the results file, points in the order of their permanent numbers.

    The point fields are computed on access: write them before the points change.

    names: what fields there are; those of the points and the water if None.
    """
    points, water = state.points, setup.water
    order = points.in_order
    order = order[state.distribution.own[order]]
    number = points.point_id[order]
    of_stage = time - setup.model.stage.start
    states, varying, wet = names or (
        points.state_variables(), list(points.varying), water is not None or points.has_flow
    )  # fmt: skip
    fields: dict[str, Callable[[], npt.NDArray[Any]]] = {
        "displacement": lambda: points.displacement[order],
        "cauchy_stress": lambda: total_stress(points, water, of_stage)[order],
        **{name: partial(lambda name: points.state_variable(name)[order], name) for name in states},
        "volume": lambda: points.volume[order],
        **{name: partial(_varying, points, name, number) for name in varying},
        "domain": lambda: points.half_length[order],
    }
    if wet:
        fields["effective_stress"] = lambda: effective_stress(points)[order]
        fields["pore_pressure"] = lambda: pore_pressure(points, water, of_stage)[order]
    if points.has_flow:
        fields[EXCESS_PORE_PRESSURE] = lambda: excess_pore_pressure(points)[order]
        fields[DARCY_VELOCITY] = lambda: darcy_velocity(points)[order]
    if setup.model.analysis.inertia is not None:
        fields["velocity"] = lambda: points.motion[order, 0]
        fields["acceleration"] = lambda: points.motion[order, 1]
    corners = points.all_corners()
    if corners is not None:
        fields["domain_corners"] = lambda: corners[order]
    if any(body.layers for body in setup.model.bodies):
        fields["layer"] = lambda: points.layer[order]
    if setup.model.output.deformation_gradient:
        fields["deformation_gradient"] = lambda: points.deformation_gradient[order]
    zero = np.zeros(active.position.shape)
    return Snapshot(
        step=step,
        time=time,
        position=points.position[order],
        point_id=number,
        body_id=points.body_id[order],
        point_fields=FieldsOnDemand(fields),
        node_position=active.position,
        cells=active.cells(),
        node_fields={
            "displacement": zero if result is None else result.equilibrium.displacement,
            "reaction": zero if result is None else result.reaction,
        },
        surfaces=state.surface_shapes(),
        body_fields=_different(tuple(setup.model.overlays().values())),
    )


def _different(overlays: tuple[int, ...]) -> tuple[int, ...]:
    """Returns numbers of overlays, or none where all are the same."""
    return overlays if any(overlays) else ()


def _varying(points: MaterialPoints, name: str, number: Integers) -> Floats:
    """Returns a varying parameter at points by their numbers, NaN where it does not vary, (n,)."""
    if name not in points.varying:
        return np.full(len(number), np.nan)
    return points.varying[name][number]


def units_of(model: Model) -> dict[str, str]:
    """Returns the labels of the units, of volumes, and of the state variables of the user's laws.

    Volumes are per unit thickness in plane strain, so that theirs is that of an area.
    """
    labels = {name: str(label) for name, label in model.units.model_dump().items()}
    of_laws = {name for law in model.laws.values() if law.source for name in law.state_variables}
    units = model.state_units()
    own = {name: labels["stress"] for name in sorted(of_laws) if units[name] == "stress"}
    plane = model.analysis.kind == "plane_strain"
    power = "\N{SUPERSCRIPT TWO}" if plane else "\N{SUPERSCRIPT THREE}"
    volume = f"{labels['length']}{power}" if labels["length"] else ""
    return labels | {"volume": volume} | own
