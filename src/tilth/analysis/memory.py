# SPDX-License-Identifier: BSD-3-Clause
"""Estimate of the memory that a run needs (docs/theory/memory.md)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.available_memory import PROGRAM, AvailableMemory, available_memory, parse_size, size_text
from tilth.bodies.size import BodySize, body_size
from tilth.errors import BadInput
from tilth.grid.background import Grid, background_grid
from tilth.memory_estimate import UNDEFORMED, MemoryEstimate
from tilth.model import Body, Model
from tilth.model.variation import variations
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.output.checkpoint_thread import LARGEST_COPY
from tilth.solvers import MULTIGRID_FROM_UNKNOWNS, SOLVERS, THREADED_FROM_POINTS
from tilth.solvers.fill import factor_blocks
from tilth.solvers.linear import LARGEST_HALF_BANDWIDTH

REPORT = 70e6
"""Libraries of the report's pictures [byte]; measured."""

COPIES_OF_POINTS = 18
"""Numbers per point of temporary arrays, such as those of an output; measured."""

GROUP = 90
"""Bytes of a group of points besides its lists of nodes and blocks."""

NODE_VECTORS = {"multigrid": 70}
"""Vectors per unknown of the Newton iteration and of multigrid's Krylov method (GMRES)."""

BYTES_PER_ENTRY = 28
"""Of the scalar matrix of a direct solver: value, row, where it is among the blocks, copy."""

BYTES_PER_FACTOR = {"superlu": 12.0, "pardiso": 9.0, "mumps": 16.0}
"""Of an entry of the factors with its share of indices; superlu: measured; mumps: with its stack,
not measured."""

PETSC_PER_ENTRY = 36.0
"""Bytes of PETSc's matrix (12 an entry, and as much while it is filled) and of the levels of its
multigrid for each entry of the matrix; not measured."""

MULTIGRID_PER_ENTRY = 8.5
"""Bytes of all levels for each entry of the matrix; measured."""


def memory_of(
    model: Model, points: MaterialPoints | None = None, active: ActiveGrid | None = None
) -> MemoryEstimate:
    """Returns the estimate for a model: without points and grid from its shapes alone, in no time.

    With stages it is that of the stage that needs most, and of the undeformed points of all.

    Args:
        model: the declared problem.
        points, active: its points and the grid of its first step, if they exist already.

    Raises:
        BadInput: a mesh that cannot be used, or a number of points that can only be an error.
    """
    if not model.stages:
        size = partial(body_size, kind=model.analysis.kind, grid=background_grid(model))
        return _of_stage(model, model.bodies, points, active, size)
    first = model.of_stages[0]
    before = first.initial_model
    assert before is not None
    models = (before, *model.of_stages) if first.stage.follows else model.of_stages
    first_grid = background_grid(before)
    sizes = {body.name: body_size(body, model.analysis.kind, first_grid) for body in first.bodies}
    estimates: dict[Any, MemoryEstimate] = {}
    for stage in models:
        present = stage.present_bodies
        stage_grid = background_grid(stage)
        kind = (frozenset(body.name for body in present), str(stage.grid.cell_size))

        def size_of(body: Body, grid: Grid = stage_grid) -> BodySize:
            """Returns its size on the grid of the stage; its points are those of the first."""
            size = sizes[body.name]
            ends = first_grid.position(np.stack([size.lower, size.upper]))
            lower, upper = grid.in_cells(ends)
            refined = ((upper - lower) / np.maximum(size.upper - size.lower, 1.0)).prod()
            return BodySize(size.points, float(size.cells * refined), lower, upper)

        if not estimates and points is not None:
            estimates[kind] = _of_stage(stage, present, points, active, size_of)
        elif kind not in estimates:
            estimates[kind] = _of_stage(stage, present, None, None, size_of)
    largest = max(estimates.values(), key=lambda estimate: estimate.total)
    pairs = pairwise(models)
    copies = 1 + sum(one.bodies != other.bodies for one, other in pairs)
    number = sum(sizes[body.name].points * _of_state(model, body) for body in first.bodies)
    return replace(largest, parts={**largest.parts, UNDEFORMED: 8.0 * copies * number})


def _of_stage(
    model: Model,
    bodies: Sequence[Body],
    points: MaterialPoints | None,
    active: ActiveGrid | None,
    size_of: Callable[[Body], BodySize],
) -> MemoryEstimate:
    """Returns the estimate for some of the bodies."""
    if points is None or active is None:
        of_bodies = [size_of(body) for body in bodies]
        number = [size.points for size in of_bodies]
        lower = np.min([size.lower for size in of_bodies], axis=0)
        upper = np.max([size.upper for size in of_bodies], axis=0)
        cells = min(sum(size.cells for size in of_bodies), float(np.prod(upper - lower)))
        shares = np.array([size.cells for size in of_bodies])
        sides = (upper - lower) * (cells / np.prod(upper - lower)) ** (1.0 / len(lower)) + 1.0
        nodes = float(np.prod(sides))
    else:
        counts = np.bincount(points.body_id, minlength=len(model.bodies)).astype(float).tolist()
        names = {body.name for body in bodies}
        number = [n for body, n in zip(model.bodies, counts, strict=True) if body.name in names]
        cells, nodes = float(len(active.cell_keys)), float(active.nodes)
        shares = np.array(number)
        sides = np.ptp(active.lattice[:, : model.dimension], axis=0) + 1.0
        sides *= (nodes / float(np.prod(sides))) ** (1.0 / model.dimension)
    cells_of = cells * shares / max(float(shares.sum()), 1.0)
    distance = max(_reach(body) for body in bodies)
    solver = _solver(model, sum(number), sides, distance)
    blocks = float(np.prod(np.maximum(sides * (2 * distance + 1) - distance * (distance + 1), 1.0)))
    parts = {"the program": PROGRAM + (REPORT if model.output.report else 0.0)}
    parts["the material points"] = sum(
        _of_points(model, body, *own)
        for body, *own in zip(bodies, number, cells_of.tolist(), strict=True)
    )
    parts["the grid"] = nodes * model.dimension * 8 * NODE_VECTORS.get(solver, 20) + 200 * cells
    parts["the matrix"] = blocks * (8 * model.dimension**2 + 4)
    parts[f"the linear solver {solver}"] = _of_solver(model, solver, sides, blocks, distance)
    own = zip(bodies, number, strict=True)
    copy = 8.0 * sum(points * _of_state(model, body) for body, points in own)
    if model.output.checkpoint_every and copy <= LARGEST_COPY:
        parts["the checkpoint"] = 2.0 * copy
    return MemoryEstimate(sum(number), cells, nodes, nodes * model.dimension, solver, parts)


def require_memory(estimate: MemoryEstimate, limit: float | str | None = None) -> None:
    """Refuses a run that needs more memory than there is.

    Args:
        estimate: of the run.
        limit: what it may use instead of what is available: [byte], or with a unit ("64GB").

    Raises:
        BadInput: it does not fit, or `limit` is not a size.
    """
    if limit is None:
        found = available_memory()
        if found is not None and estimate.total > found.available:
            raise _refusal(estimate, f"only {found} is available")
    elif estimate.total > (allowed := parse_size(limit)):
        raise _refusal(estimate, f"the memory limit given is {size_text(allowed)}")


def _refusal(estimate: MemoryEstimate, there: str) -> BadInput:
    return BadInput(
        f"not enough memory: the run needs {estimate} ({estimate.size}), but {there}",
        "use a coarser grid, fewer points, another analysis.solver or a machine with more memory; "
        "to run it nevertheless, say how much memory it may need "
        f"(--memory-limit {_rounded_up(estimate.total)}; in Python memory_limit)",
    )


def require_memory_to_check(
    estimate: MemoryEstimate, available: AvailableMemory | None
) -> str | None:
    """Returns a warning if the memory does not suffice to run a model; None if it does.

    Raises:
        BadInput: it does not even suffice for the material points.
    """
    if available is None or estimate.total <= available.available:
        return None
    if estimate.of_set_up > available.available:
        raise _refusal(estimate, f"only {available} is available")
    return f"the run needs {estimate}, but only {available} is available here: it would be refused"


def _reach(body: Body) -> int:
    """Returns the largest number of cells between two nodes that a body's points couple."""
    return 1 if body.basis == "linear" else 2


def _of_points(model: Model, body: Body, points: float, cells: float) -> float:
    """Returns the memory of a body's points, their trial state, basis and groups [byte]."""
    dim, nodes_per_axis = model.dimension, _reach(body) + 1
    state = _of_state(model, body)
    if model.has_water:  # derivatives of its force, twice, and inverses of the step's deformation
        state += 2 * (dim**3 + dim**2) + 10
    variables = _state_variables(model, body)
    trial = 8 + variables + _core.response_size(model.analysis.kind)
    nodes = nodes_per_axis**dim
    values = {"linear": dim, "gimp": 2 * dim * nodes_per_axis}.get(body.basis, (1 + dim) * nodes)
    shares = 6 * 2**dim if body.anti_locking == "f_bar" and body.basis != "linear" else 6
    numbers = state + trial + values + shares + COPIES_OF_POINTS
    per_axis = max((points / max(cells, 1.0)) ** (1.0 / dim), 1.0)
    groups = cells if body.basis == "linear" else min(points, cells * min(per_axis, 3.0) ** dim)
    of_group = GROUP + nodes * (4 + 4 + 4 + 8) + 4 * nodes * nodes // nodes_per_axis
    return float(8 * points * numbers + groups * of_group)


def _state_variables(model: Model, body: Body) -> int:
    return max(len(model.laws[name].state_variables) for name in body.materials)


def _of_state(model: Model, body: Body) -> float:
    """Returns the numbers of the state of each point of a body."""
    dim, used = model.dimension, body.materials
    corners = 2**dim * dim if any(b.basis.startswith("cpdi") for b in model.bodies) else 0
    edges = dim**2 if any(b.basis == "cpdi1" for b in model.bodies) else 0
    state = float(27 + 5 * dim + dim**2 + corners + edges + _state_variables(model, body))
    for name in used:  # values of varying entries, and the parameters of their laws
        if varying := variations(model.materials[name]):
            state += (len(varying) + 2 * len(model.laws[name].parameters)) / len(used)
    return state


def _solver(model: Model, points: float, sides: Floats, distance: int) -> str:
    """Returns the linear solver of a run, as `linear_solver` and `LinearSolver` choose it."""
    if (name := model.analysis.solver) != "auto":
        return name
    dim, nodes = model.dimension, float(np.prod(sides))
    section = nodes / float(sides.max())
    if dim * min(nodes, section ** (dim / (dim - 1))) >= MULTIGRID_FROM_UNKNOWNS[dim]:
        return "multigrid"
    if dim * section * (distance + 1) <= LARGEST_HALF_BANDWIDTH:
        return "banded"
    if points < THREADED_FROM_POINTS:
        return "superlu"
    return next(solver.name for solver in SOLVERS.values() if solver.available())


def _of_solver(model: Model, solver: str, sides: Floats, blocks: float, distance: int) -> float:
    """Returns the memory of a linear solver in addition to the node-block matrix [byte]."""
    dim, entries = model.dimension, blocks * model.dimension**2
    if solver == "multigrid":
        return MULTIGRID_PER_ENTRY * entries
    if solver in ("gamg", "hypre"):
        return PETSC_PER_ENTRY * entries
    if solver == "banded":
        unknowns = dim * float(np.prod(sides))
        half_band = dim * float(np.prod(sides) / sides.max()) * (distance + 1)
        return BYTES_PER_ENTRY * entries + 8 * 3 * half_band * unknowns
    whole = np.maximum(np.rint(sides), 1).astype(int).tolist()
    factors = 2 * factor_blocks(whole, distance) * dim**2
    return BYTES_PER_ENTRY * entries + BYTES_PER_FACTOR[solver] * factors


def _rounded_up(size: float) -> str:
    return f"{math.ceil(size / 1e9)}GB" if size > 2e9 else f"{math.ceil(size / 1e6)}MB"
