# SPDX-License-Identifier: BSD-3-Clause
"""The state of an analysis: the points, and all else that a later step reads."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from tilth.analysis.dynamics import Dynamics
from tilth.analysis.grid_motion import GridMotion
from tilth.analysis.kept_contact import KeptContact, KeptForce
from tilth.analysis.owners import DECLARED_POSITION, Stateful, state_of
from tilth.analysis.predictor import Predictor, load_curves
from tilth.analysis.relaxation import Relaxation
from tilth.analysis.wave_boundaries import WaveBoundaries
from tilth.arrays import Floats
from tilth.boundaries import make_bodies, make_body_contacts, make_boundaries, make_implicit
from tilth.boundaries.contact.state import RigidBodyState
from tilth.boundaries.contact.surface import ContactSurface
from tilth.boundaries.implicit.passage import PassageCheck
from tilth.boundaries.step.axis import Axis
from tilth.comm import SERIAL, Communicator
from tilth.grid.background import Grid
from tilth.model import Model
from tilth.model.load_curve import LoadCurve
from tilth.mpm.distribution import Distribution, KeyedRows
from tilth.mpm.points import MaterialPoints
from tilth.output.snapshot import SurfaceShape
from tilth.surface.make import make_surfaces
from tilth.terms.edge_support import EdgeSupport
from tilth.terms.ghost import Ghost
from tilth.terms.inertia import TimeStep
from tilth.terms.released import ReleasedForces

if TYPE_CHECKING:
    from tilth.analysis.pore_pressure import PorePressure


def _pore_pressure(model: Model) -> PorePressure | None:
    """Returns the owner of the pore pressure; None if no water flows."""
    if model.flow is None:
        return None
    from tilth.analysis.pore_pressure import PorePressure  # loads the terms of water

    return PorePressure(model)


class State:
    """The state of an analysis between two steps. It changes where a step is committed.

    Points move between processes, and the grid follows its boundary, at the start of a step.

    Args:
        model: the declared problem.
        points: the present points.
        initial: the undeformed points of all bodies of all stages, in the order of their numbers.
        acceleration: all body forces per mass at a time [acceleration], shape (dim,).

    Attributes:
        points: the material points.
        grid: the background grid.
        distribution: which points this process owns, of those of all processes.
        boundaries: those that act by elimination.
        implicit: those that act by forces, surfaces of rigid bodies among them.
        contact_surfaces: those of them that soil can separate from.
        bodies: rigid bodies.
        surfaces: tracked surfaces, by the bodies' names.
        body_contacts: surfaces of soil bodies in contact with other soil bodies.
        waves: bases that move and boundaries that absorb waves.
        axis: of symmetry.
        ghost, edge_support: stabilisation of the edge of the soil.
        released: forces that a stage releases.
        predictor: knows the last step.
        declared_dynamics: the inertia of the analysis; None if it is quasi-static.
        relaxation: of soil beyond a limit load; None if the analysis ends there.
        pore_pressure: of water that flows; None without.
        kept_contact, kept_ghost: forces of contact and ghost stabilisation after the last step.
        passage: remembers where soil was in front of the boundaries in a refused step.
        declared_position: where all points were declared [length], (all points, dim); None in an
            analysis without stages, where their displacements tell it.
        owners: objects with variables that persist from step to step, by the names that they have
            in a checkpoint. Boundaries and surfaces have numbers, not the names of the user.
    """

    def __init__(
        self,
        model: Model,
        points: MaterialPoints,
        initial: MaterialPoints,
        acceleration: Callable[[float], Floats],
    ) -> None:
        self.declared_dynamics = Dynamics.of(model)
        self.relaxation = Relaxation.of(model)
        self.pore_pressure = _pore_pressure(model)
        self.kept_contact = KeptContact(model.dimension)
        self.kept_ghost = KeptForce(model.dimension)
        self.boundaries = make_boundaries(model, self.time_step)
        self.implicit = make_implicit(model)
        self.bodies, surfaces = make_bodies(model, acceleration)
        self.implicit += surfaces
        self.contact_surfaces = [s for s in self.implicit if isinstance(s, ContactSurface)]
        self.points = points
        self.declared_position = initial.position if model.stage.name else None
        self.waves = WaveBoundaries(model, self.boundaries, points.position)
        self.axis = Axis(model, initial)
        self.surfaces = make_surfaces(model, initial)
        self.body_contacts = make_body_contacts(model, self.surfaces)
        self.ghost = Ghost(model.analysis.ghost_stabilisation, model.dimension)
        self.edge_support = EdgeSupport(model.dimension)
        self.passage = PassageCheck()
        self.predictor = Predictor(model.dimension, load_curves(model))
        stage = model.stage.declared
        release = (None if stage is None else stage.release) or ((0, 0), (model.schedule.end, 1))
        self.released = ReleasedForces(model.dimension, LoadCurve(release))
        self.grid: Grid = GridMotion(model, self.implicit).at(0.0)
        self.distribution = Distribution(SERIAL, points, self.grid)
        self.owners = self._owners(model.stage.releases)

    def _owners(self, releases: bool) -> dict[str, Stateful]:
        """Returns what `owners` has; releases: whether the stage releases forces."""
        owners: dict[str, Stateful] = {
            "ghost": self.ghost,
            "edge support": self.edge_support,
            "last step": self.predictor,
            "axis": self.axis,
        }
        if releases:
            owners["released"] = self.released
        moving = (
            self.declared_dynamics, self.relaxation, self.kept_contact, self.kept_ghost,
            self.pore_pressure,
        )  # fmt: skip
        names = "dynamics", "relaxation", "contact force", "ghost force", "pore pressure"
        named = zip(names, moving, strict=True)
        owners |= {name: each for name, each in named if each is not None}
        owners |= {f"boundary {number}": each for number, each in enumerate(self.implicit)}
        owners |= {f"rigid body {i}": each for i, each in enumerate(self.bodies)}
        owners |= {f"contact pair {i}": each for i, each in enumerate(self.body_contacts)}
        owners |= {f"surface {i}": each for i, each in enumerate(self.surfaces.values())}
        return owners | self.waves.owners()

    @property
    def fields(self) -> Sequence[PorePressure]:
        """The fields that the model has besides the displacement."""
        return [] if self.pore_pressure is None else [self.pore_pressure]

    def distribute(self, comm: Communicator) -> None:
        """Leaves this process its part of the points; all processes have them all before.

        Raises:
            BadInput: there are too many processes.
        """
        self.distribution = Distribution(comm, self.points, self.grid, self._keyed)
        self.points = self.distribution.owned(self.points)

    def _keyed(self) -> list[KeyedRows]:
        """Returns the owners whose variables belong to nodes or cells."""
        return [each for each in self.owners.values() if isinstance(each, KeyedRows)]

    def with_points(self, points: MaterialPoints, distribution: Distribution) -> State:
        """Returns a state with other points, which shares all owners with this one."""
        other = copy(self)
        other.points, other.distribution = points, distribution
        return other

    def time_step(self, before: float, after: float) -> TimeStep | None:
        """Returns the step of the equations of motion, None if it has no inertia."""
        own = self.declared_dynamics
        return None if own is None else own.step(before, after)

    @property
    def comm(self) -> Communicator:
        """The processes that share the points."""
        return self.distribution.comm

    @property
    def owned_points(self) -> MaterialPoints:
        """The points of this process without the copies of other processes' points."""
        return self.distribution.owned(self.points)

    @property
    def relaxes(self) -> bool:
        """Whether soil moves beyond a limit load."""
        return self.relaxation is not None and self.relaxation.active

    @property
    def dynamics(self) -> Dynamics | Relaxation | None:
        """The inertia that acts now; None in equilibrium."""
        return self.relaxation if self.relaxes else self.declared_dynamics

    @property
    def is_forced(self) -> bool:
        """Whether rigid bodies move freely."""
        return any(body.free.any() for body in self.bodies)

    @property
    def rigid_bodies(self) -> dict[str, RigidBodyState]:
        """Motion of the rigid bodies and forces on them, by their names."""
        return {body.name: body.result() for body in self.bodies}

    def undeformed(self) -> MaterialPoints:
        """Returns the points where they were declared; in a model without stages as they are."""
        if self.declared_position is None:
            return self.points
        changed = {
            "position": self.declared_position[self.points.point_id],
            "half_length": self.points.initial_half_length,
        }
        return MaterialPoints(
            **{**self.points.arrays(), **changed},  # type: ignore[arg-type]
            ranges=self.points.ranges,
            varying=self.points.varying,
        )

    def surface_shapes(self) -> tuple[SurfaceShape, ...]:
        """Returns the tracked surfaces of the bodies as they are now."""
        return tuple(surface.shape() for surface in self.surfaces.values())

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Returns all arrays that a later step reads: points and state variables of the owners."""
        return self.with_start(self.points.arrays()) | state_of(self.owners)

    def with_start(self, arrays: Mapping[str, npt.NDArray[Any]]) -> dict[str, npt.NDArray[Any]]:
        """Returns arrays of points with where these were declared, which a stage may forget."""
        if self.declared_position is None:
            return dict(arrays)
        return {**arrays, DECLARED_POSITION: self.declared_position[arrays["point_id"]]}

    def go_on_from(self, last: State, same_grid: bool, exchanges: bool) -> None:
        """Takes over from the last stage what persists besides points, boundaries and surfaces.

        same_grid: whether the background grid is that of the last stage. exchanges: whether the
        stage exchanges materials.
        """
        if last.declared_dynamics is not None:
            self.waves.go_on_from(last.waves)
        if self.relaxation is not None and last.relaxation is not None:
            self.relaxation.number = last.relaxation.number
        if self.pore_pressure is not None and last.pore_pressure is not None:
            self.pore_pressure.go_on_from(last.pore_pressure, same_grid)
        if same_grid:
            self.ghost.restore(last.ghost.state())
            self.edge_support.restore(last.edge_support.state())
            if exchanges:
                self.ghost.keep_forces()
            self.axis.restore(last.axis.state())
