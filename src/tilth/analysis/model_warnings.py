# SPDX-License-Identifier: BSD-3-Clause
"""Warnings of what can be computed in a model, and is probably not meant.

Each begins with its key in the case file and ends with a remedy; docs/reference/warnings.md lists
them all.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

import numpy as np

from tilth.analysis.contact_warnings import contact_warnings, rigid_overlaps
from tilth.analysis.end_warnings import end_warnings
from tilth.analysis.flow_warnings import drives_water, flow_warnings
from tilth.analysis.overlaps import overlapping_bodies
from tilth.analysis.prepare import locate, soil_on
from tilth.analysis.run_warnings import RunWarnings
from tilth.analysis.services import Services
from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.analysis.table_warnings import table_warnings
from tilth.analysis.unit_warnings import unit_warnings
from tilth.arrays import Floats
from tilth.boundaries.contact.thin import thin_warnings
from tilth.boundaries.implicit.passage import border_warning, points_behind, surface_behind
from tilth.grid.background import Grid
from tilth.model import (
    AffineBoundary,
    BodyForce,
    ImplicitBoundary,
    LineForce,
    Model,
    PointForce,
    SeismicLoad,
    SurfaceLoad,
)
from tilth.model.boundaries import Boundary
from tilth.model.geometry_base import DeclaredGeometry
from tilth.model.loads import Load
from tilth.model.rigid_bodies import RigidBody
from tilth.model.staging import StageOfModel
from tilth.mpm.points import MaterialPoints
from tilth.mpm.shear_strength import shear_strength
from tilth.surface.protocol import BodySurface
from tilth.terms.loads import nearest_points

NEARLY_INCOMPRESSIBLE = 0.45 - 1e-9
"""Poisson's ratio from which on elements without F-bar lock: K / G is 10 there."""

LEAST_STIFFNESS = 10.0
"""Young's modulus over the shear strength below which the two are probably in different units:
soil has 50 to 2000, and at 10 it yields at a shear strain of about 0.3."""

LEAST_RADIUS = 4.0
"""Least radius of a curved boundary, in cells, for which results were compared with others
(examples/buried_pipe, examples/rigid_sphere)."""

LARGEST_TURN = 20.0
"""Turn of what holds soil [degrees] up to which the boxes of GIMP stand for its domains."""

_STAGE = re.compile(r": in the stage '[^']*': ")

ROUND_OFF = 1e-9
"""Share of a cell that does not count."""


def warnings_of(
    setup: Setup, state: State, services: Services, in_advance: bool = False
) -> Iterator[tuple[str, str]]:
    """Yields the warnings of a model before its first step: what each is about, and its text.

    Those of a stage name it; they are of the soil as it was declared. The first step must have
    been prepared.

    in_advance: see `check_first_step`.

    Raises:
        BadInput: the mesh of a body cannot be read.
    """
    stage = setup.model.stage.name
    for key, text in _warnings_of(setup, state, services, in_advance):
        place, _, rest = text.partition(": ")
        yield key, f"{place}: in the stage {stage!r}: {rest}" if stage else text


def _warnings_of(
    setup: Setup, state: State, services: Services, in_advance: bool
) -> Iterator[tuple[str, str]]:
    model, points, grid = setup.model, state.undeformed(), state.grid
    if not model.stage.follows:  # others begin with stresses
        yield from _no_cause(model)
        yield from unit_warnings(model, points)
    yield from _overlaps(model, points)
    yield from _behind(model.stage, state, services.warnings, in_advance)
    yield from _far_positions(model, points, grid)
    yield from _long_parts(state.surfaces)
    yield from _locking(model, points)
    yield from _soft(model, points)
    yield from contact_warnings(model)
    yield from rigid_overlaps(model, points)
    yield from thin_warnings(state.contact_surfaces, model.stage.begins, points, grid)
    yield from _small_radii(model, points, grid)
    yield from _turned_boxes(model)
    yield from end_warnings(state.implicit, points, grid)
    yield from _thin_or_sparse(points, grid)
    yield from _one_step(model)
    yield from _jumps(model)
    yield from table_warnings(model)
    yield from _water(setup, state.points)
    yield from flow_warnings(setup, state)
    if state.waves:
        active = locate(setup, state, services, 0.0)
        yield from state.waves.warnings(model, soil_on(active, setup, state, services))


def _jumps(model: Model) -> Iterator[tuple[str, str]]:
    """Loads whose table in a stage does not begin where the last stage ended."""
    for name, last, first in model.stage.jumps:
        yield (
            f"jump of {name} in {model.stage.name}",
            f"{model.stage.key}.factors: the load {name!r} begins with the factor {first:g}, but "
            f"the last stage ended with {last:g}; the difference is released over the stage; begin "
            f"the table with [0, {last:g}] unless this is meant",
        )


def without_stage(text: str) -> str:
    """Returns a warning without the stage that it names: what is warned of once."""
    return _STAGE.sub(": ", text, count=1)


def at(position: Floats) -> str:
    """Returns a position as a message writes it."""
    return "(" + ", ".join(f"{x:.4g}" for x in position) + ")"


def _no_cause(model: Model) -> Iterator[tuple[str, str]]:
    """Nothing loads or moves the soil."""
    loaded = any(acts(load, model) for _, load in model.acting_loads())
    loaded = loaded or model.water is not None or bool(model.initial.velocity)
    loaded = loaded or drives_water(model)
    moved = any(
        _moves(boundary, model) or getattr(boundary, "acceleration", None) is not None
        for boundary in model.boundaries
    )
    if not loaded and not moved and not model.rigid_bodies:
        yield (
            "no cause",
            "loads: no load other than zero acts and no boundary moves, so all displacements and "
            "stresses stay zero; add [[loads]], or a boundary with a displacement, and check the "
            "values and the tables `factor`",
        )


def acts(load: Load, model: Model) -> bool:
    """Returns whether a load is other than zero at some time."""
    if not any(factor for _, factor in model.load_curve(load).table):
        return False
    if isinstance(load, BodyForce):
        used = {material for body in model.bodies for material in body.materials}
        mass = any(model.materials[name].density for name in used)
        return mass and any(load.acceleration)
    if isinstance(load, SeismicLoad):
        weights = [each for _, each in model.acting_loads() if isinstance(each, BodyForce)]
        return any(load.coefficient) and any(acts(each, model) for each in weights)
    if isinstance(load, PointForce | LineForce):
        return any(load.force)
    assert isinstance(load, SurfaceLoad)
    profile = any(pressure for _, pressure in load.pressure_along or ())
    constant = bool(load.pressure or load.shear or load.hydrostatic)
    return constant or profile or any(load.traction or ())


def _moves(boundary: Boundary, model: Model) -> bool:
    """Whether a boundary moves at some time."""
    if not any(factor for _, factor in model.load_curve(boundary).table):
        return False
    if isinstance(boundary, AffineBoundary):
        gradient = np.array(boundary.deformation_gradient)
        return not np.array_equal(gradient, np.eye(len(gradient)))
    if any((boundary.displacement or {}).values()):
        return True
    if not isinstance(boundary, ImplicitBoundary):
        return False
    turns = boundary.rotation is not None and boundary.rotation.angle != 0.0
    wider = bool(boundary.radius_change or boundary.volume_loss)
    return turns or wider or boundary.motion is not None


def _overlaps(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Bodies that overlap."""
    for body, other, inside in overlapping_bodies(model, points):
        total = int((points.body_id == body).sum())
        names = f"{model.bodies[body].name!r} and {model.bodies[other].name!r}"
        yield (
            f"overlap of {body} and {other}",
            f"bodies[{body}].shape: the bodies {names} overlap: {len(inside)} of the {total} "
            f"points of the first are inside the second, such as number "
            f"{points.point_id[inside[0]]} at {at(points.position[inside[0]])}; their material "
            "counts twice, with the weight and stiffness of both; move or cut one of them",
        )


def _behind(
    stage: StageOfModel, state: State, warnings: RunWarnings, in_advance: bool
) -> Iterator[tuple[str, str]]:
    """Soil that begins behind an implicit boundary or inside a rigid shape."""
    points, grid = state.points, state.grid
    for boundary in state.implicit:
        is_rigid = boundary.body_name is not None
        if not stage.begins(boundary.body_name or boundary.name) or (is_rigid and in_advance):
            continue
        for name, surface in state.surfaces.items():
            known = surface_behind(boundary, surface.shape().position, 0.0, grid)
            warnings.known_depth(f"surface of {name}, {boundary.name}", known, grid)
        if text := border_warning(boundary, points, 0.0, grid):
            yield f"border of {boundary.name}", text
        behind, depth = points_behind(boundary, points, 0.0, grid)
        if len(behind) == 0:
            continue
        deepest = behind[int(depth.argmax())]
        warnings.known_depth(boundary.name, float(depth.max()), grid)
        yield (
            f"start behind {boundary.name}",
            f"{boundary.key}.geometry: {len(behind)} of {len(points)} material points "
            f"({100.0 * len(behind) / len(points):.2g} %) are behind the boundary "
            f"{boundary.name!r} at the start, up to {depth.max():.3g} deep (number "
            f"{points.point_id[deepest]} at {at(points.position[deepest])}); it does not push them "
            "out: move the body or the boundary, or turn its side to the soil",
        )


def _far_positions(model: Model, points: MaterialPoints, grid: Grid) -> Iterator[tuple[str, str]]:
    """Positions of tracked quantities away from the soil."""
    diagonal = float(np.sqrt(model.dimension))
    for i, track in enumerate(model.track):
        if track.at is None or (track.body is not None and not model.present(track.body)):
            continue
        if track.body is None and model.stage.absent_bodies:
            continue  # it may be in soil that is not there in this stage
        key, place = f"track[{i}].at", np.array(track.at)
        nearest = points.index_of(nearest_points(points, place, model.cell_size, track.body))[0]
        offset = points.position[nearest] - place
        cells = float(np.linalg.norm(offset / grid.sizes_at(points.position[nearest])))
        if cells > diagonal * (1.0 + ROUND_OFF):
            yield (
                f"place of {key}",
                f"{key}: no soil is at {at(place)}: {track.name!r} is that of the nearest material "
                f"point, number {points.point_id[nearest]} at {at(points.position[nearest])}, "
                f"{np.linalg.norm(offset):.3g} ({cells:.1f} cells) away; correct the position",
            )


def _long_parts(surfaces: Mapping[str, BodySurface]) -> Iterator[tuple[str, str]]:
    """Parts of more than half an outline, as where their ends are exchanged."""
    for name, surface in surfaces.items():
        for key, share in surface.long_parts().items():
            yield (
                f"length of {key}",
                f"{key}.start: it acts on {100.0 * share:.0f} % of the closed outline of "
                f"{name!r}, from `start` to `end` with the soil on the left; for the other part "
                "exchange `start` and `end`",
            )


def _locking(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Nearly incompressible bodies without F-bar."""
    if any(isinstance(each, AffineBoundary) and each.nodes == "all" for each in model.boundaries):
        return
    poisson = points.elastic_moduli().poisson
    for body, own in points.whole_bodies():
        i = body.body
        ratio = float(poisson[own].max())
        if body.anti_locking != "none" or ratio < NEARLY_INCOMPRESSIBLE:
            continue
        effect = "deformations are too small and pressures oscillate"
        if any(model.materials[name].is_plastic for name in model.bodies[i].materials):
            effect = "limit loads are too large or are never reached, and pressures oscillate"
        yield (
            f"locking of {i}",
            f"bodies[{i}].anti_locking: the body {body.name!r} is nearly incompressible (Poisson's "
            f"ratio {ratio:.3g}) and has no remedy against locking: {effect}; give "
            'anti_locking = "f_bar"',
        )


def _soft(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Materials with a strength that their stiffness reaches at large strains only."""
    young, cohesion = points.elastic_moduli().young, shear_strength(points, model)[0]
    for range_ in points.ranges:
        name = model.bodies[range_.body].materials[range_.layer]
        own, strength = young[range_.points], cohesion[range_.points]
        ratio = own / np.where(strength > 0.0, strength, np.nan)
        if not (ratio < LEAST_STIFFNESS).any():  # false also for a law without a strength
            continue
        worst = int(np.nanargmin(ratio))
        yield (
            f"stiffness of {name}",
            f"materials.{name}.young_modulus: Young's modulus {own[worst]:.4g} is only "
            f"{ratio[worst]:.2g} times the shear strength {strength[worst]:.4g}, and soil has 50 "
            "to 2000 times: check the units of both",
        )


def _small_radii(model: Model, points: MaterialPoints, grid: Grid) -> Iterator[tuple[str, str]]:
    """Curved boundaries of a few cells."""
    for i, boundary in enumerate(model.boundaries):
        radius = _least_radius(boundary, model)
        if radius is None or not isinstance(boundary, ImplicitBoundary):
            continue
        edge = _edge_near(boundary.geometry, radius, points, grid)
        if radius < LEAST_RADIUS * edge * (1.0 - ROUND_OFF):
            yield (
                f"radius of {boundary.name}",
                f"boundaries[{i}].geometry.radius: the radius of the boundary {boundary.name!r} is "
                f"only {radius / edge:.2g} cells; results were compared with others for "
                f"{LEAST_RADIUS:g} and more, where forces are already up to 4 % too large on a "
                f"smooth boundary and more on a rough one; cells of {radius / LEAST_RADIUS:.3g} or "
                "less resolve it",
            )
    for body in model.rigid_bodies:
        for key, shape in model.shapes_of(body):
            radius = shape.radius_at_rest
            if radius is None:
                continue
            edge = _edge_near(shape, radius, points, grid)
            if radius < LEAST_RADIUS * edge * (1.0 - ROUND_OFF):
                yield (
                    f"radius of {key}",
                    f"{key}.radius: the radius of the rigid body {body.name!r} is only "
                    f"{radius / edge:.2g} cells; contact averages its stresses over about a cell; "
                    f"cells of {radius / LEAST_RADIUS:.3g} or less resolve it",
                )


def _turned_boxes(model: Model) -> Iterator[tuple[str, str]]:
    """Boundaries and rigid bodies that turn soil whose domains do not turn with it."""
    names = ", ".join(repr(body.name) for body in model.bodies if body.basis == "gimp")
    for key, what, turn in _turns(model) if names else ():
        if turn > LARGEST_TURN * (1.0 + ROUND_OFF):
            yield (
                f"turn of {key}",
                f"{key}: {what} holds soil and turns by {turn:.4g} degrees, but the boxes of GIMP "
                f"(bodies {names}) do not turn with the soil: in a box that turned by 180 degrees "
                "the stress in the corners was 3 % off (docs/theory/implicit_boundaries.md); "
                'basis = "cpdi2" turns with it',
            )


def _turns(model: Model) -> Iterator[tuple[str, str, float]]:
    """Key, name and largest turn [degrees] of what holds soil and turns by a prescribed motion."""
    for i, boundary in enumerate(model.boundaries):
        if isinstance(boundary, ImplicitBoundary) and boundary.rotation is not None:
            factors = [1.0] if boundary.factor is None else [each for _, each in boundary.factor]
            turn = abs(boundary.rotation.angle) * max(map(abs, factors))
            yield f"boundaries[{i}].rotation", f"the boundary {boundary.name!r}", turn
    end = model.schedule.end
    times = np.linspace(0.0, end, 101)
    for i, body in enumerate(model.rigid_bodies):
        if body.contact.normal != "bilateral":
            continue
        components = RigidBody.components(model.dimension, model.analysis.kind)
        turns = [name for name in components if name.startswith("rotation")]
        angles = [[body.prescribed(name, time, end) or 0.0 for name in turns] for time in times]
        turn = float(np.degrees(np.linalg.norm(angles, axis=1).max(initial=0.0)))
        yield f"rigid_bodies[{i}].rotation", f"the rigid body {body.name!r}", turn


def _edge_near(
    geometry: DeclaredGeometry, radius: float, points: MaterialPoints, grid: Grid
) -> float:
    """Returns the longest edge [length] of the cells with soil around a curved geometry."""
    centre = getattr(geometry, "centre", None)
    if not grid.graded or centre is None:
        return float(grid.cell_size.max())
    near = (np.abs(points.position - np.array(centre)) <= radius).all(axis=1)
    return float(grid.sizes_at(points.position[near]).max(initial=grid.cell_size.max()))


def _least_radius(boundary: Boundary, model: Model) -> float | None:
    """Returns the least radius of a boundary in the schedule [length]; None if it has none."""
    if not isinstance(boundary, ImplicitBoundary) or boundary.geometry.radius_at_rest is None:
        return None
    factors = [0.0, *(factor for _, factor in model.load_curve(boundary).table)]
    return min(boundary.radius(factor) for factor in factors)


def _thin_or_sparse(points: MaterialPoints, grid: Grid) -> Iterator[tuple[str, str]]:
    """Bodies thinner than a cell, or with cells that may hold no point."""
    for body, own in points.whole_bodies():
        i = body.body
        position, half = points.position[own], points.initial_half_length[own]
        ends = np.stack([(position - half).min(axis=0), (position + half).max(axis=0)])
        extent = np.diff(grid.in_cells(ends), axis=0)[0]
        thin = int(extent.argmin())
        if extent[thin] < 1.0 - 1e-6:
            yield (
                f"extent of {i}",
                f"bodies[{i}].shape: the body {body.name!r} is only {extent[thin]:.2g} of a cell "
                f"thick along {'xyz'[thin]}, so the grid hardly sees what happens across it; "
                "choose smaller cells",
            )
        apart = (2.0 * half / grid.sizes_at(position)).max(axis=0)
        worst = int(apart.argmax())
        if body.basis == "linear" and apart[worst] > 1.0 + 1e-6:
            yield (
                f"spacing of {i}",
                f"bodies[{i}]: the points of the body {body.name!r} are {apart[worst]:.3g} cells "
                f"apart along {'xyz'[worst]}, so cells inside it may hold no point and carry no "
                "stress; put two or more in a cell along each direction",
            )


def _water(setup: Setup, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Water below all soil, and water that also loads a surface."""
    model, water = setup.model, setup.water
    if water is None:
        return
    lower = points.position - points.half_length[:, -1:] * np.eye(model.dimension)[-1]
    if not any(water.pore_pressure(lower, time).any() for time in (0.0, model.schedule.end)):
        depth = max(
            (water.level(lower, time) - lower[:, -1]).max() for time in (0.0, model.schedule.end)
        )
        yield (
            "dry",
            "water.level: no soil is under water at the start or the end of the schedule: the "
            f"level is at least {-depth:.3g} below all soil; correct it, or leave out [water]",
        )
    wet = water.pore_pressure(lower, 0.0).any()
    if not any(isinstance(load, BodyForce) for _, load in model.acting_loads()):
        yield (
            "weightless",
            "water.unit_weight: the water has a weight, but no body force acts, so that the soil "
            'has none and floats below the level; add a load with type = "body_force", or leave '
            "out [water]",
        )
    elif wet and not setup.loads.acceleration(0.0).any():
        yield (
            "floats",
            "water: the water is there from the start, but the body force is zero then, so that "
            "the soil below the water floats; give the body force its whole factor from the start, "
            "factor = [[0, 1], [1, 1]], with the stress at the start, or `factor` of [water] the "
            "rows of the body force",
        )
    for i, load in model.acting_loads():
        if isinstance(load, SurfaceLoad) and load.hydrostatic is not None and acts(load, model):
            yield (
                f"water twice on {i}",
                f"loads[{i}].hydrostatic: the water of [water] already loads every surface below "
                f"its level, so that on {load.body!r} water counts twice; leave out this load, or "
                "[water]",
            )


def _one_step(model: Model) -> Iterator[tuple[str, str]]:
    """The whole load on a plastic body in one step."""
    used = {name for body in model.present_bodies for name in body.materials}
    plastic = any(model.materials[name].is_plastic for name in used)
    if plastic and model.schedule.number_of_steps == 1 and _something_changes(model):
        of_stage = f"{model.stage.key}." if model.stage.name else ""
        yield (
            f"{of_stage}one step",
            f"{of_stage}schedule.steps = 1: the whole load acts in one step, but the plastic "
            "strain depends on the path; compare a run with ten steps or more",
        )


def _something_changes(model: Model) -> bool:
    """Whether the soil is not at rest: in a stage, or from a stress at the start."""
    stage = model.stage.declared
    if model.stage.number == 0 and not model.initial.stress:
        return True
    if stage is not None and model.stage.follows:
        changes = (
            stage.activate,
            stage.deactivate,
            stage.excavate,
            stage.factors,
            stage.force_factors,
        )
        if any(changes) or stage.materials or stage.water is not None or stage.grid is not None:
            return True
    tables = [model.load_curve(load).table for _, load in model.acting_loads()]
    tables += [model.load_curve(b).table for b in model.boundaries if _moves(b, model)]
    water = model.water
    if water is not None:
        tables.append(water.factor or ())
    if model.flow is not None:
        tables += [each.factor or () for each in model.flow.boundaries]
    moves = water is not None and water.initial_level not in (None, water.level)
    return moves or any(len({factor for _, factor in table}) > 1 for table in tables)
