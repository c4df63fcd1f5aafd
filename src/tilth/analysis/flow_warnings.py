# SPDX-License-Identifier: BSD-3-Clause
"""Warnings of flowing water: what can be computed, and is probably not meant."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tilth.analysis.consolidation_time import ConsolidationTime, consolidation_time
from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.analysis.unit_warnings import greatest_gravity
from tilth.arrays import Flags
from tilth.model import Model
from tilth.model.fields import AXES
from tilth.model.flow import UNSCALED
from tilth.model.flow_checks import flow_planes
from tilth.model.initial import StressOfRun
from tilth.model.problems import dotted
from tilth.model.unit_labels import length_of, time_of
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import CONDUCTIVITY, POROSITY
from tilth.output.folder import read_declared

LARGEST_STEP = 0.3
"""Step over the time to 90 %, above which it hardly resolves the flow: in one step of the time
factor T backward Euler consolidates soil by sqrt(T) tanh(1/sqrt(T)), 0.48 at T = 0.25 in place of
0.56."""

SHORTEST = 1e-3
"""Schedule over the time to 90 %, below which hardly any water flows: 3 % of what will."""

CONDUCTIVITIES = (1e-13, 1.0)
"""Hydraulic conductivities of soil and fissured rock, from dense clay to gravel [m/s]."""

STEPS_OF_A_PERIOD = 10
"""Steps in a period of the fastest vibration that they resolve."""

FREE_WATER = 0.1
"""k omega rho / (n gamma_w) from which on the water's inertia relative to the soil matters: the
surface of a loaded half space is then 1 to 2 % off, at 1 by a quarter."""

GRAINS = (2.0, 3.5)
"""Density of grains over that of water; quartz has 2.65."""

ORGANIC_GRAINS = 1.2
"""The least one in peat, whose porosity is above `PEAT`."""

PEAT = 0.75
"""Porosity above which soil may be peat."""

TOO_MUCH_WATER = 1.1
"""Water of saturated soil over what fits into its pores, above which one of the two is wrong."""

ROUND_OFF = 1e-6
"""Share of a cell that does not count."""


def flow_warnings(setup: Setup, state: State) -> Iterator[tuple[str, str]]:
    """Yields the warnings of the water that flows in a stage: what each is about, and its text."""
    model, points = setup.model, state.undeformed()
    yield from _pressure_of_run(model)
    if model.flow is None:
        return
    if not model.flow_boundary_keys():
        yield (
            "sealed",
            "flow.boundaries: no pressure and no flux is given anywhere, so that no water can "
            "leave the soil: it only moves inside it; add [[flow.boundaries]], such as one of "
            'condition "drained" at the ground, unless this is meant',
        )
    yield from _conductivities(model, points)
    yield from _densities(model, points)
    yield from _above_water(setup, points)
    if not model.water_flows:
        return
    yield from _planes_without_soil(model, state)
    yield from _impermeable_pairs(model, points)
    if state.declared_dynamics is not None:
        yield from _fast_water(model, points)
        return
    found = consolidation_time(model, points, state.surfaces, state.grid)
    if found is not None and found.time is not None:
        yield from _steps(model, found, found.time)


def _pressure_of_run(model: Model) -> Iterator[tuple[str, str]]:
    """Stresses of a run with flowing water, whose excess pressure is not taken over."""
    for i, entry in enumerate(model.initial.stress):
        if isinstance(entry, StressOfRun) and read_declared(Path(entry.folder)).get("flow"):
            yield (
                f"pressure of run {i}",
                f"initial.stress[{i}].folder: water flows in this run, and its excess pore "
                f"pressure is not taken over: {entry.body!r} begins without any; name a run that "
                "has consolidated, or go on from one with `tilth run --from`",
            )


def drives_water(model: Model) -> bool:
    """Whether a flow boundary gives a head, or a pressure or flux other than zero at some time."""
    flow = model.flow
    return flow is not None and any(
        each.condition == "head"
        or (each.value and any(factor for _, factor in each.factor or UNSCALED))
        for each in flow.boundaries
    )


def _fast_water(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Water so free that its inertia relative to the soil matters, which is left out."""
    flow = model.flow
    assert flow is not None
    assert flow.density is not None
    porosity, conductivity = points.water[:, POROSITY], points.water[:, CONDUCTIVITY]
    ratios = [
        float((conductivity[own] / porosity[own]).max()) * _greatest_ratio(model, name)
        for name, own in _of_materials(model, points)
    ]
    period = STEPS_OF_A_PERIOD * model.schedule.first_step
    largest = max(ratios, default=0.0) * flow.density * 2.0 * np.pi / period
    if largest > FREE_WATER:
        yield (
            "free water",
            "analysis.inertia: water moves freely through the coarsest soil in vibrations that "
            f"the steps resolve: k omega rho / (n gamma_w) is {largest:.2g} for a period of "
            f"{period:.3g} {model.units.time}, and the inertia of the water relative to the soil "
            f"is left out, which is right below {FREE_WATER:g}; slower vibrations are not affected",
        )


def _steps(model: Model, found: ConsolidationTime, time: float) -> Iterator[tuple[str, str]]:
    """Steps and schedules that do not fit to the time of consolidation."""
    schedule, unit = model.schedule, model.units.time
    of_stage = f"{model.stage.key}." if model.stage.name else ""
    known = f"the soil will consolidate by 90 % in about {time:.3g} {unit}"
    if schedule.first_step > LARGEST_STEP * time:
        key = "steps" if schedule.steps is not None else "step_size"
        yield (
            f"{of_stage}steps of consolidation",
            f"{of_stage}schedule.{key}: {known}, and the first step is {schedule.first_step:.3g} "
            f"{unit}: pressures and settlements on the way are not resolved, only the final ones; "
            f"give steps of {0.05 * time:.2g} {unit} or less, and a first one of about "
            f"{found.first_step:.2g}, if necessary in a stage of its own",
        )
    elif not model.stage.name and schedule.end < SHORTEST * time:
        yield (
            "end of consolidation",
            f"schedule.end = {schedule.end:g}: {known}, so that the soil is undrained up to there: "
            "check the units of time and of the hydraulic conductivity; what is meant to be "
            "undrained is a stage with flow = false",
        )


def _conductivities(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Hydraulic conductivities that no soil has."""
    assert model.flow is not None
    length, time = length_of(model.units.length), time_of(model.units.time)
    if length is None or time is None or model.stage.follows:
        return
    for name, own in _of_materials(model, points):
        k = points.water[own, CONDUCTIVITY] * model.flow.unit_weight
        least, greatest = float(k.min()), float(k.max()) * _greatest_ratio(model, name)
        for worst, wrong in ((least, least * length / time < CONDUCTIVITIES[0]),
                             (greatest, greatest * length / time > CONDUCTIVITIES[1])):  # fmt: skip
            if wrong:
                unit = f"{model.units.length}/{model.units.time}"
                yield (
                    f"conductivity of {name}",
                    f"{dotted(('materials', name, 'hydraulic_conductivity'))}: {worst:.3g} {unit} "
                    f"are {worst * length / time:.2g} m/s, and soil has {CONDUCTIVITIES[0]:g} to "
                    f"{CONDUCTIVITIES[1]:g} m/s (clay about 1e-9, sand 1e-4); "
                    f"1e-9 m/s are {1e-9 * time / length:.3g} {unit}: check the unit",
                )


def _densities(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Densities that contradict the porosity."""
    gravity = greatest_gravity(model)
    if not gravity or model.stage.follows:
        return
    assert model.flow is not None
    water = model.flow.unit_weight / gravity
    for name, own in _of_materials(model, points):
        material, porosity = model.materials[name], float(np.median(points.water[own, POROSITY]))
        wet, key = material.saturated_density, dotted(("materials", name, "saturated_density"))
        if not wet:
            continue
        pores = porosity * water
        given = f"with the porosity {porosity:.3g} and water of density {water:.4g}"
        grains = (wet - pores) / ((1.0 - porosity) * water)
        least = ORGANIC_GRAINS if porosity > PEAT else GRAINS[0]
        if material.density is not None and wet - material.density > TOO_MUCH_WATER * pores:
            yield (
                f"water in {name}",
                f"{key} = {wet:g}: this is {wet - material.density:.3g} more than the density "
                f"{material.density:g}, but {given} the pores hold {pores:.3g} at most: saturated "
                "and dry density differ by the porosity times the density of water",
            )
        elif not least <= grains <= GRAINS[1]:
            yield (
                f"grains of {name}",
                f"{key} = {wet:g}: {given} the grains would have {grains:.3g} times the density of "
                f"water, and those of soil have about 2.65: give (1 - n) 2.65 + n = "
                f"{(1.0 - porosity) * 2.65 + porosity:.3g} times that of water, "
                f"{((1.0 - porosity) * 2.65 + porosity) * water:.4g}, or correct the porosity",
            )


def _above_water(setup: Setup, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Soil in which water flows above the level of the water at rest."""
    model, water = setup.model, setup.water
    if water is None:
        return
    times = (0.0, model.schedule.end)
    lower = points.position - points.half_length[:, -1:] * np.eye(model.dimension)[-1]
    for name, own in _of_materials(model, points):
        height = np.max([lower[own, -1] - water.level(lower[own], time) for time in times], axis=0)
        above = height > ROUND_OFF * min(model.cell_size)
        if above.any():
            yield (
                f"{name} above the water",
                f"{dotted(('materials', name, 'hydraulic_conductivity'))}: {int(above.sum())} of "
                f"{len(own)} points of this material are above the level of [water], by up to "
                f"{height.max():.3g}: they count as saturated, without suction; raise the level, "
                "or divide the body in layers and leave `hydraulic_conductivity` out above it",
            )


def _planes_without_soil(model: Model, state: State) -> Iterator[tuple[str, str]]:
    """Flow boundaries on planes that no soil with flowing water touches, or no line of the grid."""
    assert model.flow is not None
    points, keys = state.points, model.flow_boundary_keys()
    wet = points.water[:, CONDUCTIVITY] > 0.0
    position = points.position[wet]
    edge = state.grid.sizes_at(position)
    for _, plane in flow_planes(model):
        place = np.zeros((1, model.dimension))
        place[0, AXES.index(plane.axis)] = plane.at
        line = float(state.grid.in_cells(place)[0, AXES.index(plane.axis)])
        if abs(line - round(line)) > ROUND_OFF:
            yield (
                f"line of {plane.name}",
                f"{keys[plane.name]}.at = {plane.at:g}: the grid of this stage has no line there, "
                f"so that {plane.name!r} does nothing: give it another grid, or the boundary the "
                'type = "implicit"',
            )
            continue
        near: Flags = np.ones(len(position), dtype=bool)
        ranges = {plane.axis: (plane.at, plane.at), **(plane.range or {})}
        for name, (low, high) in ranges.items():
            k = AXES.index(name)
            away = np.maximum(low - position[:, k], position[:, k] - high)
            near &= away < edge[:, k]
        if not near.any():
            yield (
                f"place of {plane.name}",
                f"{keys[plane.name]}.at = {plane.at:g}: no soil in which water flows is within a "
                f"cell of {plane.name!r}: correct its position or its range, or leave it out",
            )


def _impermeable_pairs(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Contact pairs of two bodies in which water flows: none passes between them."""
    wet = {each.name for each in points.ranges if points.water[each.start, CONDUCTIVITY] > 0.0}
    for key, pair in model.acting_pairs:
        if wet.issuperset(pair.bodies):
            one, other = pair.bodies
            yield (
                f"water between {one} and {other}",
                f"{key}: water flows in {one!r} and in {other!r}, but not from one to the other: "
                "contact lets no water pass; leave the pair out where they do not separate, or "
                "drain both bodies by flow boundaries of their own",
            )


def _greatest_ratio(model: Model, name: str) -> float:
    """Returns the greatest conductivity of a material over that of its points, the least one."""
    least, greatest = model.materials[name].principal_ratios
    return greatest / least


def _of_materials(
    model: Model, points: MaterialPoints
) -> Iterator[tuple[str, np.ndarray[tuple[int], np.dtype[np.int64]]]]:
    """Yields the materials in which water flows, with their points."""
    own: dict[str, list[np.ndarray[tuple[int], np.dtype[np.int64]]]] = {}
    for range_ in points.ranges:
        if points.water[range_.start, CONDUCTIVITY] > 0.0:
            name = model.bodies[range_.body].materials[range_.layer]
            own.setdefault(name, []).append(np.arange(range_.start, range_.stop))
    for name, parts in own.items():
        yield name, np.concatenate(parts)
