# SPDX-License-Identifier: BSD-3-Clause
"""Runs of models in memory, and what is kept of each step."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from metamorphic.overhang import on_lines, overhang
from metamorphic.tilting import may_tilt
from metamorphic.watched import last_balance, watched
from tilth import Model
from tilth.analysis.energies import Energies
from tilth.analysis.march import march_stages
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats, Integers
from tilth.errors import TilthError

Tree = dict[str, Any]


@dataclass
class Moment:
    """The state after a step; of points those that there are, in the order of their numbers.

    Attributes:
        time: total time.
        stage: number.
        number: permanent numbers of the points, (n,).
        position, displacement: [length], (n, dim).
        cell: in which they are, (n, dim).
        overhang: how far soil reaches over the line before the node that it touches least [length].
        may_tilt: whether the patches of a base leave the soil free to tilt.
        stress: [stress], (n, 6).
        plastic_strain: [-], (n,).
        volume: relative to the initial one [-], (n,).
        velocity: [length/time], (n, dim); no columns without inertia.
        load: sum of the external forces and of those of the aids of the solution [force], (dim,).
        load_moment: its moment about the origin of the coordinates [force length], (3,).
        forces, moments: of boundaries and bodies on the soil, by name, about the same origin.
        between: names of contacts between two bodies of soil, which are in neither sum.
        size: of the forces of the step, as the relative residual takes it [force].
        arm: largest distance of a node from that origin [length].
        nodes: number of grid nodes.
        residual: relative, that Newton's iteration left [-].
        iterations: of Newton.
        energies: all kinds [force length].
        spring_work: work on weak springs in the step [force length].
        kinetic_change: of the kinetic energy of the grid in the step [force length].
        force_units: powers of length, stress and time in a unit of force.
        bodies: displacements of the centres of the rigid bodies [length], (dim,), by name.
    """

    time: float
    stage: int
    number: Integers
    position: Floats
    displacement: Floats
    cell: Integers
    overhang: float
    may_tilt: bool
    stress: Floats
    plastic_strain: Floats
    volume: Floats
    velocity: Floats
    load: Floats
    load_moment: Floats
    forces: dict[str, Floats]
    moments: dict[str, Floats]
    between: frozenset[str]
    size: float
    arm: float
    nodes: int
    residual: float
    iterations: int
    energies: dict[str, float]
    spring_work: float
    kinetic_change: float
    force_units: tuple[float, float, float]
    bodies: dict[str, Floats] = field(default_factory=dict)


@dataclass
class Run:
    """A run in memory: steps up to its end or to what ended it.

    Attributes:
        initial: places of all points at the start, in the order of their numbers.
        body: names of their bodies.
        moments: the state after each step.
        error: message of what ended the run before its end; empty if nothing did.
        exit_code: of the command that would run it.
        warnings: of the set-up and of the steps.
        cell: shortest edge of a cell [length].
        on_lines: whether points with linear functions begin on lines of the grid.
        model: what was run; None if it is no valid model.
    """

    model: Model | None = None
    initial: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    body: list[str] = field(default_factory=list)
    moments: list[Moment] = field(default_factory=list)
    error: str = ""
    exit_code: int = 0
    warnings: list[str] = field(default_factory=list)
    cell: float = 0.0
    on_lines: bool = False

    def at_regular_times(self, of: Run | None = None) -> Run:
        """The same with the moments at the regular times of a run only, its own if not given."""
        times = {round(m.time, 9) for m in (of or self).moments}
        return replace(self, moments=[m for m in self.moments if round(m.time, 9) in times])


class Listener:
    """Takes down what a run does."""

    def __init__(self, run: Run) -> None:
        self.run, self._energies = run, Energies()

    def at_start(self, analysis: StagedAnalysis) -> None:
        """Keeps the places of the points at the start of the first stage."""
        if analysis.number > 0:
            return
        points, run = analysis.soil, self.run
        order = np.argsort(points.point_id)
        run.initial = points.position[order] - points.displacement[order]
        run.body = [analysis.model.bodies[k].name for k in points.body_id[order]]
        run.cell = float(np.min(analysis.simulation.state.grid.cell_size))
        run.on_lines = on_lines(analysis.simulation)
        self._energies = Energies.at_start(analysis.simulation.setup, analysis.simulation.state)

    def after_step(self, analysis: StagedAnalysis, result: StepResult) -> None:
        """Keeps the state after a step."""
        self._energies.add(result)
        simulation = analysis.simulation
        self.run.moments.append(_moment(analysis, simulation, result, self._energies))
        self.run.warnings += simulation.services.warnings.texts
        simulation.services.warnings.texts.clear()


def run_in_memory(entries: Tree) -> Run:
    """Runs a model; other exceptions than those of wrong input and failed analyses pass on."""
    run = Run()
    listener = Listener(run)
    try:
        run.model = Model.from_dict(entries)
        with watched():
            march_stages(run.model, listener.after_step, listener.at_start)
    except TilthError as error:
        run.error, run.exit_code = error.message, error.exit_code
    return run


def _moment(
    analysis: StagedAnalysis, simulation: Simulation, result: StepResult, energies: Energies
) -> Moment:
    points, active, found = simulation.state.points, result.active, result.equilibrium
    order = np.argsort(points.point_id)
    arm = active.position + found.displacement
    three = ((0, 0), (0, 3 - arm.shape[1]))
    balance = last_balance()
    load = found.load + balance.aids
    size = max(
        balance.size,
        *(
            float(np.linalg.norm(force))
            for force in (load, found.reaction, *result.forces.values())
        ),
    )
    return Moment(
        time=analysis.time,
        stage=analysis.number,
        number=points.point_id[order],
        position=points.position[order],
        displacement=points.displacement[order],
        cell=np.floor(simulation.state.grid.in_cells(points.position[order])).astype(np.int64),
        overhang=overhang(simulation),
        may_tilt=may_tilt(balance),
        stress=points.stress[order],
        plastic_strain=points.plastic[order, 0],
        volume=np.linalg.det(points.deformation_gradient[order]),
        velocity=points.motion[order, 0] if points.motion.shape[1] else points.position[:, :0],
        load=load.sum(axis=0),
        load_moment=np.cross(np.pad(arm, three), np.pad(load, three)).sum(axis=0),
        forces={name: result.resultant(name) for name in result.forces},
        moments={name: result.moment(name, np.zeros(arm.shape[1])) for name in result.forces},
        between=result.between_bodies,
        size=size,
        arm=float(np.linalg.norm(arm, axis=1).max()),
        nodes=active.nodes,
        residual=found.residuals[-1],
        iterations=found.iterations,
        energies=energies.values(simulation.setup, simulation.state, result.time),
        spring_work=balance.spring_work,
        kinetic_change=balance.kinetic_change,
        force_units=(1 if simulation.setup.kind == "plane_strain" else 2, 1, 0),
        bodies={body.name: np.asarray(body.place_now()[0]) for body in simulation.state.bodies},
    )
