# SPDX-License-Identifier: BSD-3-Clause
"""The entries of a problem's declaration, and what follows from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import AfterValidator, PlainValidator

from tilth.arrays import Floats
from tilth.model.base import DeclaredFile
from tilth.model.bodies import Body
from tilth.model.boundaries import AffineBoundary, Boundary, NodeBoundary, PlaneBoundary
from tilth.model.contact_pairs import ContactPair, overlays_of_bodies
from tilth.model.fields import AXES, AsTuple, Entries, Name, Text
from tilth.model.flow import Flow, FlowBoundary, ImplicitFlowBoundary
from tilth.model.geometry import DeclaredGeometry
from tilth.model.grading import (
    GridAxis,
    Places,
    along_axes,
    first_places,
    largest,
    line_of,
    smallest,
)
from tilth.model.implicit import ImplicitBoundary
from tilth.model.initial import Initial
from tilth.model.laws import Law, state_units
from tilth.model.load_curve import LoadCurve
from tilth.model.loads import BodyForce, LineForce, Load, PointForce, SeismicLoad
from tilth.model.materials import Material, codes_of, laws_of
from tilth.model.problems import reject
from tilth.model.rigid_bodies import RigidBody
from tilth.model.schedule import Schedule
from tilth.model.settings import Analysis, Grid, Output, Units
from tilth.model.stages import Stages
from tilth.model.staging import StageOfModel, loading_stages, stage_models
from tilth.model.surface import SurfaceLoad
from tilth.model.track import Track
from tilth.model.variation import variations
from tilth.model.water import Water

if TYPE_CHECKING:
    from typing_extensions import Self

Loaded = (
    PlaneBoundary
    | NodeBoundary
    | ImplicitBoundary
    | AffineBoundary
    | RigidBody
    | BodyForce
    | SeismicLoad
    | PointForce
    | LineForce
    | SurfaceLoad
)


FORMAT = 1
"""Version of the case file's schema that this version of tilth reads."""

BAND = 1e-3
"""Default width of an implicit boundary's band as a fraction of a cell's smallest edge."""


def format_of(value: Any) -> int:
    """Returns the version of a case file's schema; refuses one that is not read."""
    if type(value) is int and value == FORMAT:
        return value
    problem = f"this version of tilth reads format {FORMAT} only"
    raise reject(problem, f"write format = {FORMAT} in the first line")


def one(value: Any) -> Any:
    """Refuses an empty list or table."""
    if not value:
        raise reject("must have at least one entry")
    return value


class Declaration(DeclaredFile):
    """The entries of a problem, each valid by itself; whether they fit together `Model` checks."""

    format: Annotated[int, PlainValidator(format_of)] = FORMAT
    """Version of the case file's schema."""
    title: Text = ""
    """Title, shown in the report."""
    units: Units = Units()
    """Labels of the units."""
    analysis: Analysis
    """a section [analysis] with the kind of analysis."""
    grid: Grid
    """a section [grid] with the background grid's cell_size."""
    materials: Annotated[Mapping[Name, Material], AfterValidator(one)]
    """a section [materials.NAME] for each material."""
    bodies: Annotated[Sequence[Body], Entries, AsTuple, AfterValidator(one)]
    """a section [[bodies]] for each body."""
    boundaries: Annotated[Sequence[Boundary], Entries, AsTuple] = ()
    """Dirichlet boundary conditions, at least one."""
    rigid_bodies: Annotated[Sequence[RigidBody], Entries, AsTuple] = ()
    """Rigid bodies in contact with soil."""
    contact_pairs: Annotated[Sequence[ContactPair], Entries, AsTuple] = ()
    """Contact between soil bodies; without it they stick together where they meet."""
    loads: Annotated[Sequence[Load], Entries, AsTuple] = ()
    """Body forces, seismic loads, point and line forces, and loads on surfaces."""
    water: Water | None = None
    """Water at rest in the soil and above it; none if not given."""
    flow: Flow | None = None
    """Water that flows through the pores; it does not flow if not given."""
    initial: Initial = Initial()
    """State at the start."""
    schedule: Schedule = Schedule(steps=1)
    """a section [schedule] with the number of steps or the step_size; not with `stages`, each of
    which has its own.
    """
    stages: Stages = ()
    """Stages, in the order in which they follow each other; none if the analysis has one only."""
    track: Annotated[Sequence[Track], Entries, AsTuple] = ()
    """Tracked quantities, one column of history.csv each."""
    output: Output = Output()
    """Additional output."""

    @classmethod
    def required_keys(cls, given: Mapping[str, Any]) -> set[str]:
        """As `Declared.required_keys`: a schedule, unless there are stages."""
        keys = super().required_keys(given)
        return keys if given.get("stages") else keys | {"schedule"}

    @property
    def dimension(self) -> int:
        """Number of grid directions: 2 in plane strain and axisymmetry, 3 in 3D."""
        return 3 if self.analysis.kind == "3d" else 2

    @property
    def cell_size(self) -> tuple[float, ...]:
        """Size of the smallest grid cell along each axis [length], shape (dimension,).

        That of all cells where the grid is uniform.
        """
        return tuple(smallest(size) for size in self._cell_sizes)

    @property
    def largest_cell(self) -> tuple[float, ...]:
        """Size of the largest grid cell along each axis [length], shape (dimension,)."""
        return tuple(largest(size) for size in self._cell_sizes)

    @property
    def lines(self) -> tuple[Floats, ...]:
        """Distances of each axis' grid lines from the origin [length] (`tilth/grid_lines.py`).

        Empty along a uniform axis.
        """
        none = np.zeros(0)
        return tuple(line_of(s) if isinstance(s, tuple) else none for s in self._cell_sizes)

    @property
    def origin(self) -> tuple[float, ...]:
        """Coordinates of the grid's node with the lattice index 0 at the start [length].

        Shape (dimension,). Along a graded axis it is the first place, and along those that the grid
        follows it is relative to the point that is followed: no declared origin counts there.
        """
        size, follow = self.grid.cell_size, self.grid.follow
        origin = first_places(self.grid.origin, size, self.dimension)
        if follow is None:
            return tuple(origin)
        relative = first_places(None, size, self.dimension)
        return tuple(
            follow.place[k] + relative[k] if AXES[k] in follow.axes else origin[k]
            for k in range(self.dimension)
        )

    def grid_axis(self, k: int) -> GridAxis:
        """Returns the grid lines of an axis at the start."""
        return GridAxis(self.origin[k], self.cell_size[k], self.lines[k])

    @property
    def _cell_sizes(self) -> tuple[float | Places, ...]:
        return along_axes(self.grid.cell_size, self.dimension)

    @property
    def functions(self) -> tuple[str, ...]:
        """Code of the user that the model names, as "file:name", each once.

        A simulation of the model runs these files; see `user_laws` for those of materials.
        """
        motions = [b.motion for b in self.boundaries if isinstance(b, ImplicitBoundary)]
        shapes = [getattr(geometry, "function", None) for _, geometry in self.geometries()]
        varying = [v for material in self.materials.values() for v in variations(material).values()]
        parameters = [getattr(each, "function", None) for each in varying]
        names = (*motions, *shapes, *parameters, *self.initial.functions(), *self.user_laws)
        return tuple(dict.fromkeys(name for name in names if name))

    @property
    def user_laws(self) -> tuple[str, ...]:
        """Laws of the user that the model names, as "file:name", each once."""
        return codes_of(self.materials)

    @cached_property
    def laws(self) -> dict[str, Law]:
        """The laws of the materials by their names; runs the code of the user.

        Raises:
            BadInput: a law of the user cannot be loaded.
        """
        return laws_of(self.materials)

    def state_units(self) -> dict[str, str]:
        """Returns the units ("stress" or "-") of all state variables by name; runs user's code."""
        units = state_units()
        for law in self.laws.values():
            units |= law.state_variables
        return units

    def load_curve(self, item: Loaded) -> LoadCurve:
        """Returns how a boundary's motion or a load grows.

        Without a table the factor increases linearly from 0 to 1 over the schedule.
        """
        ramp = ((0.0, 0.0), (self.schedule.end, 1.0))
        return LoadCurve(getattr(item, "factor", None) or ramp)

    @property
    def of_stages(self) -> tuple[Self, ...]:
        """The model of each stage (see `staging`); this one alone if it has no stages."""
        return self._compiled_stages if self.stages else (self,)

    @cached_property
    def _compiled_stages(self) -> tuple[Self, ...]:
        return stage_models(self)

    @cached_property
    def stage(self) -> StageOfModel:
        """Which stage this is the model of; `stage_models` sets it."""
        return StageOfModel()

    @property
    def has_water(self) -> bool:
        """Whether there is water in any stage."""
        return self.water is not None or any(
            stage.water is not None for _, stage in loading_stages(self)
        )

    def present(self, body: str) -> bool:
        """Returns whether a body is there in this stage."""
        return body not in self.stage.absent_bodies

    @property
    def present_bodies(self) -> list[Body]:
        """The bodies that are there in this stage."""
        return [body for body in self.bodies if self.present(body.name)]

    def overlays(self) -> dict[str, int]:
        """Returns the number of the overlay of each body, by name.

        All bodies have the overlay 0 if there are no contact pairs. A body has the same overlay in
        all stages.
        """
        return overlays_of_bodies(self.bodies, self.contact_pairs)

    @property
    def acting_pairs(self) -> list[tuple[str, ContactPair]]:
        """The contact pairs both of whose bodies are there in this stage, with their keys."""
        return [
            (f"contact_pairs[{i}]", pair)
            for i, pair in enumerate(self.contact_pairs)
            if all(self.present(name) for name in pair.bodies)
        ]

    def acting_loads(self) -> Iterator[tuple[int, Load]]:
        """Yields the loads that act in this stage, with their numbers."""
        absent = self.stage.absent_loads
        return ((i, load) for i, load in enumerate(self.loads) if i not in absent)

    def boundary_keys(self) -> dict[str, str]:
        """Returns where each boundary stands in the case file, such as `boundaries[0]`, by name."""
        if self.stage.boundary_keys is not None:
            return dict(self.stage.boundary_keys)
        return {each.name: f"boundaries[{i}]" for i, each in enumerate(self.boundaries)}

    def rigid_body_keys(self) -> dict[str, str]:
        """Returns where each rigid body stands in the case file, `rigid_bodies[0]`, by name."""
        if self.stage.rigid_body_keys is not None:
            return dict(self.stage.rigid_body_keys)
        return {each.name: f"rigid_bodies[{i}]" for i, each in enumerate(self.rigid_bodies)}

    def all_flow_boundaries(self) -> Sequence[FlowBoundary]:
        """Returns the flow boundaries of all stages as declared; `flow` has those that act."""
        if self.stage.flow_boundaries is not None:
            return self.stage.flow_boundaries
        return () if self.flow is None else self.flow.boundaries

    def flow_boundary_keys(self) -> dict[str, str]:
        """Returns where each flow boundary stands in the case file, by name."""
        declared = enumerate(self.all_flow_boundaries())
        return {each.name: f"flow.boundaries[{i}]" for i, each in declared}

    def shapes_of(self, body: RigidBody) -> list[tuple[str, DeclaredGeometry]]:
        """Returns the shapes of a rigid body with their places in the case file."""
        key = self.rigid_body_keys()[body.name]
        if body.geometry is not None:
            return [(f"{key}.geometry", body.geometry)]
        return [(f"{key}.geometries[{i}]", shape) for i, shape in enumerate(body.shapes)]

    def geometries(self) -> Iterator[tuple[str, DeclaredGeometry]]:
        """Yields every geometry of boundaries and rigid bodies with its place in the case file."""
        keys = self.boundary_keys()
        for boundary in self.boundaries:
            if isinstance(boundary, ImplicitBoundary):
                yield f"{keys[boundary.name]}.geometry", boundary.geometry
        for body in self.rigid_bodies:
            yield from self.shapes_of(body)
        if self.flow is not None:
            keys = self.flow_boundary_keys()
            for each in self.flow.boundaries:
                if isinstance(each, ImplicitFlowBoundary):
                    yield f"{keys[each.name]}.geometry", each.geometry

    @property
    def water_flows(self) -> bool:
        """Whether water flows through the pores in this stage; its pores are wet in any case."""
        declared = self.stage.declared
        return self.flow is not None and (declared is None or declared.flow)

    def delta(self, boundary: ImplicitBoundary) -> float:
        """Returns the width of an implicit boundary's band [length]."""
        return BAND * min(self.cell_size) if boundary.delta is None else boundary.delta

    def to_dict(self) -> dict[str, Any]:
        """Returns the model as a dictionary that JSON stores without loss; see `from_dict`."""
        without = {"schedule"} if self.stages else {"stages"}
        return self.model_dump(mode="json", exclude_none=True, by_alias=True, exclude=without)
