# SPDX-License-Identifier: BSD-3-Clause
"""The stress of the material points at the start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.errors import BadInput
from tilth.model import Model
from tilth.model.initial import AtRest, GivenStress, StressOfRun, TableStress
from tilth.model.laws import EXCESS_PORE_PRESSURE, PLASTIC_STRAIN
from tilth.mpm.points import MaterialPoints
from tilth.mpm.stress_at_rest import stress_at_rest
from tilth.mpm.stress_of_run import state_of_run
from tilth.variation.evaluate import parameter_values
from tilth.variation.tables import place_text

WITHIN_YIELD = 1e-9
"""Plastic flow of a starting stress, at most, over its elastic strain [-]."""


@dataclass(frozen=True)
class Start:
    """The state in which points start.

    Attributes:
        stress: effective Cauchy stress, tension positive, shape (n, 6).
        parameters: material parameters that belong to it, by their keys, shape (n,) each.
        variables: state variables by name, shape (n,) each, NaN where the law gives the first one.
        returned: whether a stress outside the yield surface is returned to it, as one is that was
            interpolated between states on a surface that is not convex or not the same everywhere.
    """

    stress: Floats
    parameters: Mapping[str, Floats] = field(default_factory=dict)
    variables: Mapping[str, Floats] = field(default_factory=dict)
    returned: bool = False


def declared_start(
    model: Model, number: int, position: Floats, counts: Sequence[int], materials: Sequence[str]
) -> list[Start] | None:
    """Returns the state at the start of each layer of a body; None without a declared stress.

    Args:
        model: the declared problem, in a model with stages that of the initial state.
        number: of the body in it.
        position: of its points [length], layer by layer, shape (n, dim).
        counts: number of points of each layer.
        materials: of the layers for which the parameters are: those of the body, or others that a
            stage exchanges for them.

    Raises:
        BadInput: a point lies above the declared ground or outside a table or the soil of another
            run, or no weight balances the stress.
    """
    body = model.bodies[number]
    if (found := model.initial.of(body.name)) is None:
        return None
    key, entry = found
    ends = np.cumsum([0, *counts])
    layers = [position[first:last] for first, last in pairwise(ends)]
    if isinstance(entry, AtRest):
        starts = []
        for name, other, own in zip(body.materials, materials, layers, strict=True):
            layer = stress_at_rest(model, key, entry, number, (name, other), own)
            pressure = layer.preconsolidation
            given = {} if pressure is None else {"preconsolidation_pressure": pressure}
            starts.append(Start(layer.stress, given))
        return starts
    if isinstance(entry, StressOfRun):
        return [
            _of_run(model, key, entry, name, own)
            for name, own in zip(body.materials, layers, strict=True)
        ]
    if isinstance(entry, TableStress):
        return [Start(_tabulated(model, key, entry, own)) for own in layers]
    stresses = [np.zeros((count, 6)) for count in counts]
    if isinstance(entry, GivenStress):
        for stress in stresses:
            stress[:, : len(entry.stress)] = entry.stress
    return [Start(stress) for stress in stresses]


def _of_run(model: Model, key: str, entry: StressOfRun, material: str, position: Floats) -> Start:
    state = state_of_run(model, key, entry, position)
    excess = state.variables.get(EXCESS_PORE_PRESSURE)
    drained = EXCESS_PORE_PRESSURE not in model.laws[material].state_variables
    if drained and excess is not None:
        state.stress[:, :3] += np.nan_to_num(excess)[:, None]
    return Start(state.stress, {}, state.variables, True)


def _tabulated(model: Model, key: str, entry: TableStress, position: Floats) -> Floats:
    varying = parameter_values(entry, position, key)

    def values(name: str) -> Floats:
        return varying.get(name, np.full(len(position), getattr(entry, name)))

    vertical = values("vertical_pressure")
    lateral = values("K0") * vertical if entry.K0 is not None else values("horizontal_pressure")
    stress = np.zeros((len(position), 6))
    stress[:, :3] = -lateral[:, None]
    stress[:, model.dimension - 1] = -vertical
    return stress


def start_with_stress(points: MaterialPoints, model: Model, starts: Mapping[int, Start]) -> None:
    """Gives undeformed points their initial stress, and the state variables that belong to it.

    starts: of the ranges of `points` that have one, by number.

    Raises:
        BadInput: a law cannot have its stress, or the stress lies outside the yield surface.
    """
    for number, start in starts.items():
        range_ = points.ranges[number]
        part, found = points.part(range_), model.initial.of(range_.name)
        assert found is not None, "a start is declared"
        failed = part.start_with(start.stress, start.variables)
        if failed >= 0:
            raise _refused(part, failed, found[0], "is not possible with this law")
        if PLASTIC_STRAIN in start.variables:
            part.plastic[:, 0] = start.variables[PLASTIC_STRAIN]
        require_within_yield(part, found[0], start.returned)


def require_within_yield(part: MaterialPoints, key: str, returned: bool = False) -> None:
    """Checks that the points of one range would not flow without deformation.

    key: of what gave them their stress, for messages. returned: whether stresses outside the yield
    surface are returned to it instead.

    Raises:
        BadInput: a stress lies outside the yield surface.
    """
    outside, admissible = _outside_yield(part, returned)
    wrong = np.flatnonzero(~admissible if returned else outside)
    if len(wrong):
        raise _refused(part, int(wrong[0]), key, "lies outside the yield surface")


def _outside_yield(part: MaterialPoints, returned: bool) -> tuple[Flags, Flags]:
    """Returns which points of a body would flow without deformation, and which have a stress.

    returned: whether the former get the stress to which they would flow.
    """
    range_ = part.ranges[0]
    elastic, plastic, state = (
        np.empty_like(each) for each in (part.elastic_deformation, part.plastic, part.state)
    )
    kirchhoff, admissible = np.empty_like(part.stress), np.empty(len(part), dtype=bool)
    _core.return_to_law(
        part.tensors, range_.law.core, part.parameters_of(range_), part.elastic_deformation,
        part.plastic, part.state, elastic, plastic, state, kirchhoff, admissible,
    )  # fmt: skip
    change = np.abs(elastic - part.elastic_deformation).max(axis=1)
    size = np.abs(part.elastic_deformation).max(axis=1)
    outside = np.asarray(~admissible | (change > WITHIN_YIELD * size))
    if returned and (some := outside & admissible).any():
        part.elastic_deformation[some], part.stress[some] = elastic[some], kirchhoff[some]
    return outside, admissible


def _refused(part: MaterialPoints, point: int, key: str, problem: str) -> BadInput:
    range_ = part.ranges[0]
    stress = ", ".join(f"{value:.4g}" for value in part.stress[point])
    return BadInput(
        f"the starting stress {problem} ({range_.law.name}) at {place_text(part.position[point])}: "
        f"[{stress}], xx yy zz xy yz xz",
        "change the stress or the strength, or check their units, also that of the density: weight "
        "is density times acceleration; tension is positive",
        key=key,
    )
