# SPDX-License-Identifier: BSD-3-Clause
"""The data for the picture of the set-up, and the report of a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tilth.analysis.flow_picture import flow_conditions
from tilth.analysis.rigid_shapes import placed, rigid_shapes
from tilth.analysis.setup import Setup as Declared
from tilth.analysis.snapshots import snapshot, units_of
from tilth.analysis.staged import StagedAnalysis
from tilth.analysis.state import State
from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries import Boundary
from tilth.boundaries.base_motion import BaseMotion
from tilth.boundaries.contact.surface import ContactSurface
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.model import (
    AffineBoundary,
    BodyForce,
    ImplicitBoundary,
    Model,
    PointForce,
    RigidBody,
    SeismicLoad,
)
from tilth.model.fields import AXES
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.output.folder import SETUP, load_model
from tilth.output.snapshot import Snapshot
from tilth.report.contact_texts import laws_text, motion_texts
from tilth.report.fields import parameter_fields
from tilth.report.setup_data import Condition, Load, Setup, Soil, Surface
from tilth.report.stage_setups import StagedSetup, StageSetup
from tilth.report.stage_texts import boundary_names, brings_soil, changes
from tilth.surface.loads import SurfaceLoads, declared_loads
from tilth.surface.make import make_surfaces

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_report(folder: Path) -> Path:
    """Writes report.html into the folder of a run, finished or not; returns its path.

    No function of the user is run. For a folder of a version of tilth that did not store the
    set-up, its picture is computed from the model, and left out if that would run such a function.

    Raises:
        BadInput: `folder` is not that of a run.
    """
    from tilth.report.html import write_report as write

    model = load_model(folder)
    stored = (folder / SETUP).exists()
    return write(
        folder, model.to_dict(), setup=None if stored or model.functions else setup_of(model)
    )


def setup_of(model: Model) -> Setup | StagedSetup:
    """Returns the data for the picture of a model's set-up; runs the functions that it names.

    Raises:
        BadInput: the model cannot be computed (see `StagedAnalysis.starts`).
    """
    return checked_setup(StagedAnalysis(model))[1]


def checked_setup(
    analysis: StagedAnalysis, on_start: Callable[[Declared, State, ActiveGrid], None] | None = None
) -> tuple[ActiveGrid, Setup | StagedSetup]:
    """Checks an analysis; returns the grid of its first step and the data for the picture.

    on_start: is called at the start of each stage, with what is declared of it and its state and
        grid.

    Raises:
        BadInput: the model cannot be computed (see `StagedAnalysis.starts`).
    """
    first: tuple[ActiveGrid, Setup] | None = None
    stages: list[StageSetup] = []
    model = analysis.model
    for simulation, active in analysis.starts():
        declared, state, services = simulation.setup, simulation.state, simulation.services
        setup = initial_setup(declared, state, services.warnings.texts, active)
        first = first or (active, setup)
        if model.stages:
            present = _present(state.points, analysis.soil)
            stages.append(_stage(model, declared.model, present, setup))
        if on_start is not None:
            on_start(declared, state, active)
    assert first is not None
    if not stages:
        return first
    before = None
    if analysis.is_before_first:
        before = _present(analysis.state.points, analysis.soil)
    return first[0], _staged(model, analysis.soil, stages, before)


def _present(points: MaterialPoints, initial: MaterialPoints) -> Flags:
    """Returns which points of all stages there are, shape (n,)."""
    present = np.zeros(len(initial), dtype=bool)
    present[points.point_id] = True
    return present


def _stage(model: Model, of_stage: Model, present: Flags, setup: Setup) -> StageSetup:
    """Returns what acts in a stage, without the soil."""
    nothing = np.zeros((0, model.dimension))
    return StageSetup(
        name=of_stage.stage.name,
        number=of_stage.stage.index + 1,
        start=of_stage.stage.start,
        end=of_stage.stage.start + of_stage.schedule.end,
        changes=changes(of_stage),
        present=present,
        setup=replace(
            setup,
            position=nothing,
            half_lengths=nothing,
            corners=None,
            body_id=np.zeros(0, dtype=np.int64),
            tracked=(),
            loads=[load for load in setup.loads if load.force.any()],
            boundary_names=boundary_names(model),
        ),
    )


def _staged(
    model: Model, initial: MaterialPoints, stages: list[StageSetup], before: Flags | None
) -> StagedSetup:
    """Returns the set-up of all stages with the undeformed soil."""
    soil = Soil(initial.position, initial.half_length, initial.all_corners(), initial.body_id)
    surfaces = [surface.shape() for surface in make_surfaces(model, initial).values()]
    return StagedSetup(soil, surfaces, stages, before)


def setup_figures(model: Model) -> tuple[Setup | StagedSetup, dict[str, Figure]]:
    """Returns the set-up of a model and its figures by name.

    They are "" for the picture of the set-up, "page_2" and so on for further pages of one with many
    stages, and the name of each parameter that varies from place to place and of the layers. Runs
    the functions that the model names.

    Raises:
        BadInput: the model cannot be computed (see `StagedAnalysis.starts`).
    """
    from tilth.report.field_plots import draw_frames
    from tilth.report.setup import draw_setup
    from tilth.report.stage_pages import draw_stages

    analysis = StagedAnalysis(model)
    starts: dict[str, Snapshot] = {}

    def keep(declared: Declared, now: State, active: ActiveGrid) -> None:
        stage = declared.model.stage
        state = snapshot(declared, now, active, None, 0, stage.start, analysis.point_fields)
        names = parameter_fields(state)
        if names and brings_soil(declared.model):
            fields = {name: state.point_fields[name] for name in ("domain", *names)}
            corners = state.point_fields.get("domain_corners")
            fields |= {} if corners is None else {"domain_corners": corners}
            starts[stage.name] = replace(state, point_fields=fields)

    _, setup = checked_setup(analysis, keep)
    units = units_of(model)
    axisymmetric = model.analysis.kind == "axisymmetric"
    names = dict.fromkeys(name for state in starts.values() for name in parameter_fields(state))
    figures = {"": draw_setup(setup)} if isinstance(setup, Setup) else {}
    if isinstance(setup, StagedSetup):
        pages = enumerate(draw_stages(setup), start=1)
        figures = {f"page_{page}" if page > 1 else "": figure for page, figure in pages}
    titles = [*starts] if model.stages else None
    return setup, figures | {
        name: draw_frames([*starts.values()], name, units, axisymmetric=axisymmetric, titles=titles)
        for name in names
    }


def initial_setup(
    setup: Declared, state: State, warnings: Sequence[str], active: ActiveGrid
) -> Setup:
    """Returns the data for the picture of the set-up before the first step.

    warnings: texts, of it. active: the grid of that step.
    """
    model, points = setup.model, state.points
    return Setup(
        title=model.title,
        dim=model.dimension,
        length_unit=model.units.length,
        position=points.position,
        half_lengths=points.half_length,
        corners=points.all_corners(),
        body_id=points.body_id,
        body_names=[body.name for body in model.bodies],
        cell_size=state.grid.cell_size,
        origin=state.grid.origin,
        lines=[line.tolist() for line in state.grid.lines],
        conditions=[
            *(_condition(setup, state, boundary, active) for boundary in state.boundaries),
            *flow_conditions(model, state, active),
        ],
        surfaces=[
            *(_surface(setup, state, each) for each in state.implicit if _declared_alone(each)),
            *(_absorbing(setup, state, boundary) for boundary in state.waves.surfaces()),
            *_rigid_bodies(setup, state),
        ],
        tracked=state.surface_shapes(),
        loads=[*_loads(setup, state), *_surface_loads(setup, state, active)],
        body_force=_body_force(model),
        force_unit=model.units.force,
        kind=model.analysis.kind,
        warnings=tuple(warnings),
        water=_water(setup, state),
        water_times=model.stage.start + np.array([0.0, model.schedule.end]),
    )


def _water(setup: Declared, state: State) -> Floats | None:
    """The surface of the water in the plane at the start and the end of a stage, beyond all soil.

    Shape (2, vertices, 2).
    """
    position, water = state.points.position, setup.water
    if water is None or position.shape[1] == 3:
        return None
    wide = 10.0 * float(np.ptp(position, axis=0).max())
    x = {float(position[:, 0].min()) - wide, float(position[:, 0].max()) + wide, *water.vertices}
    place = np.column_stack([sorted(x), np.zeros(len(x))])
    heights = [water.level(place, time) for time in (0.0, setup.model.schedule.end)]
    return np.stack([np.column_stack([place[:, 0], height]) for height in heights])


FLAT_FACETS = 12
"""Facets of a plane over the longest side of the soil, about."""


def _declared_alone(boundary: Implicit) -> bool:
    """Whether a boundary is not the surface of a rigid body, which is drawn with its motion."""
    return not isinstance(boundary, ContactSurface) or boundary.body is None


def _surface(setup: Declared, state: State, boundary: Implicit) -> Surface:
    points, grid = state.points, state.grid
    lower, upper = points.position.min(axis=0), points.position.max(axis=0)
    lower, upper = lower - 2 * grid.sizes_at(lower), upper + 2 * grid.sizes_at(upper)
    size = float(grid.cell_size.max())
    if boundary.geometry.flat:
        size = max(size, float((upper - lower).max()) / FLAT_FACETS)
    facets = boundary.geometry.facets(lower, upper, size)
    centre = facets.corner.mean(axis=1)
    end = boundary.motion.position(centre, boundary.factor(setup.model.schedule.end)) - centre
    declared, stress = boundary.declared, setup.model.units.stress
    law = declared.contact
    return Surface(
        name=boundary.name,
        kind=boundary.declared.kind,
        corner=facets.corner,
        normal=facets.normal,
        displacement=end if boundary.declared.is_moving else None,
        bounded=boundary.geometry.bounded,
        words="" if law is None else "\n".join(laws_text(law, declared.contact_with, stress)),
    )


def _absorbing(setup: Declared, state: State, boundary: Implicit) -> Surface:
    """An absorbing boundary, on a plane of the grid as far as the soil is."""
    return replace(_surface(setup, state, boundary), kind="absorbing")


def _rigid_bodies(setup: Declared, state: State) -> list[Surface]:
    """The rigid bodies at the start, with the prescribed part of their motion at the end."""
    model = setup.model
    end, found = model.schedule.end, []
    for body in model.rigid_bodies:
        shape = rigid_shapes(model, state.undeformed())[body.name]
        components = RigidBody.components(model.dimension, model.analysis.kind)
        moved, turned = np.zeros(model.dimension), np.zeros(3)
        for component in components:
            amount = body.prescribed(component, end, end) or 0.0
            if component in AXES:
                moved[AXES.index(component)] = amount
            else:
                axis = component.removeprefix("rotation_")
                turned[2 if axis == "rotation" else AXES.index(axis)] = amount
        before, after = shape.at(*placed(state, body.name)), shape.at(moved, turned)
        corner = before.position[before.cells]
        motion = (after.position - before.position)[before.cells].mean(axis=1)
        laws = laws_text(body.contact, body.contact_with, model.units.stress)
        found.append(
            Surface(
                name=body.name,
                kind="rigid body",
                corner=corner,
                normal=_normals(corner),
                displacement=motion if motion.any() else None,
                bounded=True,
                words="\n".join([*motion_texts(body, model), *laws]),
            )
        )
    return found


def _normals(corner: Floats) -> Floats:
    """Returns the unit normals of facets on the left, in space by the right-hand rule, (n, dim)."""
    first = corner[:, 1] - corner[:, 0]
    if corner.shape[2] == 2:
        normal = np.column_stack([-first[:, 1], first[:, 0]])
    else:
        normal = np.cross(first, corner[:, 2] - corner[:, 0])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None])


def _condition(setup: Declared, state: State, boundary: Boundary, active: ActiveGrid) -> Condition:
    declared = next(b for b in setup.model.boundaries if b.name == boundary.name)
    assert not isinstance(declared, ImplicitBoundary)
    prescribed = boundary.prescribe(active, 0.0, setup.model.schedule.end)
    nodes = prescribed.constrained.any(axis=1)
    moving = bool(prescribed.increment.any()) and not isinstance(boundary, BaseMotion)
    return Condition(
        name=boundary.name,
        kind="affine" if isinstance(declared, AffineBoundary) else declared.condition,
        position=active.position[nodes],
        constrained=prescribed.constrained[nodes],
        displacement=prescribed.increment[nodes] if moving else None,
    )


ARROWS = 40
"""Arrows of a load on a surface, about."""


def _surface_loads(setup: Declared, state: State, active: ActiveGrid) -> list[Load]:
    """The loads on surfaces at the end of the schedule, on the initial surface."""
    model = setup.model
    end = model.schedule.end
    loads = SurfaceLoads(
        declared_loads(model), model.analysis.kind, state.surfaces, active, end, end
    )
    found = []
    for declared, place, force in loads.at_points(np.zeros((active.nodes, model.dimension))):
        group = _groups(np.linalg.norm(force, axis=1))
        count = np.bincount(group)[:, None]
        position, total = (
            np.stack([np.bincount(group, column) for column in of_points.T], axis=1, dtype=float)
            for of_points in (place, force)
        )
        found.append(
            Load(
                name=declared.name or f"load on the surface of {declared.body}",
                position=position / count,
                force=total,
            )
        )
    return found


def _groups(size: Floats) -> Integers:
    """Returns the arrow of each point of a load, (n,): groups of neighbours of about equal forces.

    size: magnitudes of the points' forces [force], shape (n,).
    """
    if not size.any():
        size = np.ones_like(size)
    share = (np.cumsum(size) - 0.5 * size) / size.sum()
    group = np.floor(share * min(ARROWS, len(size))).astype(np.int64)
    return np.asarray(np.unique(group, return_inverse=True)[1])


def _loads(setup: Declared, state: State) -> list[Load]:
    """Point forces and line forces at the end of the schedule, where they act at the start."""
    loads = []
    for each in setup.loads.on_points:
        declared, end = each.load, setup.model.schedule.end
        what = "point force" if isinstance(declared, PointForce) else "line force"
        force = np.array(declared.force) * each.curve.factor(end)
        group = _groups(each.weight)
        first = np.unique(group, return_index=True)[1]
        weight = np.bincount(group, each.weight)
        loads.append(
            Load(
                name=declared.name or f"{what} on {declared.body}",
                position=each.place[first],
                force=np.outer(weight, force),
            )
        )
    return loads


def _body_force(model: Model) -> Floats | None:
    """Returns all forces per mass [acceleration], shape (dim,); None without any.

    At factor 1, in a stage at the factors of its end.
    """
    acting = [
        (load, model.load_curve(load).factor(model.schedule.end) if model.stage.name else 1.0)
        for _, load in model.acting_loads()
    ]
    gravity = [f * np.array(load.acceleration) for load, f in acting if isinstance(load, BodyForce)]
    if not gravity:
        return None
    total = np.sum(gravity, axis=0)
    magnitude = np.linalg.norm(total)
    seismic = [
        f * magnitude * np.array(load.coefficient)
        for load, f in acting
        if isinstance(load, SeismicLoad)
    ]
    return np.asarray(np.sum([total, *seismic], axis=0))
