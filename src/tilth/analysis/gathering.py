# SPDX-License-Identifier: BSD-3-Clause
"""What several processes have of a run, brought together in process 0, which writes the files."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.owners import state_of
from tilth.analysis.simulation import Simulation
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.comm import SERIAL, Communicator
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.distribution import Distribution, KeyedRows
from tilth.output.snapshot import Snapshot


def gathered_state(state: State) -> dict[str, npt.NDArray[Any]]:
    """Returns what a later step reads, as `State.arrays` of a serial run, in process 0.

    All processes call it; the others get an empty dictionary.
    """
    distribution, comm = state.distribution, state.comm
    if distribution.serial:
        return state.arrays()
    found = distribution.gathered(state.points)
    if comm.rank == 0:
        found = state.with_start(found)
    for owner, each in state.owners.items():
        own_state = state_of({owner: each})
        if isinstance(each, KeyedRows):
            key, names = each.rows()
            own = distribution.owns(key)
            parts = [_joined(comm, own_state[f"{owner}.{name}"][own]) for name in names]
            if comm.rank == 0:
                order = np.argsort(parts[0], kind="stable")
                own_state |= {
                    f"{owner}.{n}": part[order] for n, part in zip(names, parts, strict=True)
                }
        if comm.rank == 0:
            found |= own_state
    return found


def gathered_snapshot(own: Snapshot, active: ActiveGrid) -> Snapshot:
    """Returns the output of all processes in process 0, that of the process itself in the others.

    own: the points that this process owns, in the order of their numbers, and all its nodes.
    active: the grid of the step.
    """
    comm, shared = active.comm, active.shared
    if shared is None:
        return own
    number = _joined(comm, own.point_id)
    order = np.argsort(number)
    names = {name: _joined(comm, own.point_fields[name]) for name in own.point_fields}
    position, body = _joined(comm, own.position), _joined(comm, own.body_id)
    key = _joined(comm, active.key[shared.owned])
    by_key = np.argsort(key)
    nodal = {name: _joined(comm, each[shared.owned]) for name, each in own.node_fields.items()}
    cell_keys = _joined(comm, active.cell_keys[shared.owns(active.cell_keys)])
    if comm.rank > 0:
        return own
    whole = replace(active, key=key[by_key], cell_keys=np.sort(cell_keys), shared=None)
    return replace(
        own,
        position=position[order],
        point_id=number[order],
        body_id=body[order],
        point_fields={name: each[order] for name, each in names.items()},
        node_position=whole.position,
        cells=whole.cells(),
        node_fields={name: each[by_key] for name, each in nodal.items()},
    )


def whole_state(state: State) -> State:
    """Returns a state that has the points of all processes, in each of them, for a look at it.

    The state itself in a serial run.
    """
    if state.distribution.serial:
        return state
    points = state.distribution.whole(state.points)
    return state.with_points(points, Distribution(SERIAL, points, state.grid))


def whole_simulation(simulation: Simulation) -> Simulation:
    """Returns a simulation with the whole state, see `whole_state`."""
    whole = copy(simulation)
    whole.state = whole_state(simulation.state)
    return whole


def collected(simulation: Simulation) -> Simulation:
    """Returns a simulation with the points and the state of all processes, in each of them.

    The simulation itself in a serial run; otherwise it must not be used afterwards.
    """
    distribution, comm = simulation.state.distribution, simulation.state.comm
    if distribution.serial:
        return simulation
    for each in simulation.state.owners.values():
        if isinstance(each, KeyedRows):
            (key, names), arrays = each.rows(), each.state()
            own = distribution.owns(key)
            parts = zip(*comm.gathered([arrays[name][own] for name in names]), strict=True)
            joined = [np.concatenate(part) for part in parts]
            order = np.argsort(joined[0], kind="stable")
            each.restore(arrays | {n: a[order] for n, a in zip(names, joined, strict=True)})
    return whole_simulation(simulation)


def whole_result(result: StepResult) -> StepResult:
    """Returns the result of a step with the nodes of all processes, in each of them.

    The result itself in a serial run.
    """
    active, shared = result.active, result.active.shared
    if shared is None:
        return result
    key = np.concatenate(active.comm.gathered(active.key[shared.owned]))
    order = np.argsort(key)
    cells = np.concatenate(active.comm.gathered(active.cell_keys[shared.owns(active.cell_keys)]))

    def nodal(own: Floats) -> Floats:
        return np.concatenate(active.comm.gathered(own[shared.owned]))[order]

    found = result.equilibrium
    equilibrium = replace(
        found,
        x=Unknowns({DISPLACEMENT: nodal(found.displacement)}, found.x.globals),
        load=nodal(found.load),
        reactions={DISPLACEMENT: nodal(found.reaction)},
        initial_reaction=nodal(found.initial_reaction),
    )
    return replace(
        result,
        active=replace(active, key=key[order], cell_keys=np.sort(cells), shared=None),
        equilibrium=equilibrium,
        forces={name: nodal(force) for name, force in result.forces.items()},
    )


def _joined(comm: Communicator, own: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Returns the rows of all processes, in the order of these, in process 0, else the own ones."""
    parts = comm.gathered_first(np.ascontiguousarray(own))
    return np.concatenate(parts) if parts else own


def processes_text(state: State) -> str:
    """Returns what a step's line in the log says of the processes; empty for a serial run."""
    distribution, comm = state.distribution, state.comm
    if distribution.serial:
        return ""
    own = distribution.own
    counts = comm.gathered(int(own.sum()))
    mass = comm.sum(float(state.points.mass[own].sum()))
    volume = comm.sum(float(state.points.initial_volume[own].sum()))
    moved = int(comm.sum(float(distribution.moved)))
    return (
        f"processes have {min(counts):,} to {max(counts):,} of {sum(counts):,} points, "
        f"initial volume {volume:.12g}, mass {mass:.12g}, {moved:,} handed over so far"
    )
