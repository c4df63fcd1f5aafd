# SPDX-License-Identifier: BSD-3-Clause
"""Small problems with implicit boundaries, for tests."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from small_problems import AXES, block_entries, dimension

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.boundaries import ImplicitConstraints
from tilth.boundaries.implicit.band import BandConstraint
from tilth.boundaries.implicit.constraint import ImplicitConstraint, SurfaceConstraint
from tilth.boundaries.surfaces.multipliers import multiplier_coupling
from tilth.grid.background import background_grid
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.terms.ghost import FaceCoupling
from tilth.terms.linear import Coupling

MODULUS, POISSON = 1000.0, 0.3
"""Young's modulus [stress] and Poisson's ratio [-] of the soil in `small_problems`."""


def implicit(name: str, geometry: dict[str, Any], **more: Any) -> dict[str, Any]:
    """An implicit boundary as a case file would declare it, a roller unless told otherwise."""
    entries = {"type": "implicit", "name": name, "condition": "roller", "geometry": geometry}
    return {**entries, **more}


def line(point: Floats, normal: Floats) -> dict[str, Any]:
    """An infinite line or plane with its normal into the soil."""
    return {"type": "plane", "point": list(map(float, point)), "normal": list(map(float, normal))}


def rotation(angle: float) -> Floats:
    """Rotation by an angle [degrees] in the plane; its columns are a turned body's axes."""
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[cosine, -sine], [sine, cosine]])


def locate_contacts(
    simulation: Simulation, before: float = 0.0, after: float = 1.0
) -> tuple[ActiveGrid, ImplicitConstraints]:
    """The grid of a step, and what the implicit boundaries do on it."""
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    return active, ImplicitConstraints.gather(
        simulation.state.implicit,
        simulation.state.points,
        active,
        simulation.setup.kind,
        before,
        after,
    )


def dense(coupling: Coupling, nodes: int) -> Floats:
    """The matrix of a coupling with all unknowns, node by node."""
    dim = coupling.matrix.shape[-1]
    whole = np.zeros((nodes, dim, nodes, dim))
    for node, block in zip(coupling.node, coupling.matrix, strict=True):
        np.add.at(whole, np.ix_(node, range(dim), node, range(dim)), block.transpose(0, 2, 1, 3))
    return whole.reshape(nodes * dim, nodes * dim)


def of_part(part: ImplicitConstraint, nodes: int) -> tuple[Floats, Floats]:
    """The matrix of one boundary and its force at zero displacement, (nodes, dim)."""
    constant = part.nodal_force(part.before, nodes)
    if isinstance(part, BandConstraint):
        coupling = part.coupling()
        np.add.at(constant, coupling.node, coupling.force)
        return dense(coupling, nodes), constant
    assert isinstance(part, SurfaceConstraint)
    assert part.multipliers is not None
    rows = multiplier_coupling([part.multipliers], [part.initial_slip()])
    np.add.at(constant, rows.node, rows.force)
    whole = np.zeros((nodes * constant.shape[1],) * 2)
    for low, high in pairwise(rows.node_start):
        row = np.zeros_like(constant)
        row[rows.node[low:high]] = rows.row[low:high]
        whole += np.outer(row, row)
    return whole, constant


def ghost_force(faces: FaceCoupling, displacement: Floats) -> Floats:
    """The nodal force of ghost stabilisation at a nodal displacement, (nodes, dim)."""
    moved = np.where(faces.free, displacement[faces.node], 0.0)
    scale = faces.stiffness[:, None, None] * faces.free
    force = np.zeros_like(displacement)
    unit = faces.unit[faces.which]
    np.add.at(force, faces.node, faces.force + scale * np.einsum("eab,ebi->eai", unit, moved))
    return force


def take_steps(simulation: Simulation) -> list[StepResult]:
    """All steps of the schedule, none of them cut."""
    steps = simulation.setup.model.schedule.steps
    simulation.check()
    return [simulation.advance(a, b) for a, b in pairwise(np.linspace(0.0, 1.0, steps + 1))]


AROUND_ONE = {
    "x": [[0.0, 1.3], [2.0, 0.8], [6.0, 1.4]],
    "y": [[-1.0, 0.8], [3.0, 1.4], [6.0, 0.9]],
    "z": [[-1.0, 1.3], [4.0, 0.8]],
}
"""Cell sizes at places along the axes."""

BETWEEN_DOMAINS = [[0.0, 1.0], [1.0, 1.0], [2.5, 1.5], [3.5, 1.0], [5.0, 1.5]]
"""The same with lines at multiples of 0.5."""


def patch_model(
    kind: str,
    stretch: Floats,
    *,
    basis: str = "gimp",
    angle: float = 0.0,
    shift: Floats | None = None,
    size: float = 4.0,
    points: int = 2,
    delta: float = 1e-3,
    form: str = "surface",
    spacing: str = "uniform",
) -> Model:
    """A block of soil that smooth platens on all its sides stretch homogeneously.

    Cells have the size 1, or sizes around 1 where the spacing is "graded". Each side has a roller
    exactly as long as the side. The sides that the axes start from stay, the others move by size
    times (stretch - 1). In axisymmetry the block stands on the axis, which needs no condition.

    shift: place of the lowest corner, about which the block is turned by `angle` in 2D.
    """
    dim = dimension(kind)
    lower = np.zeros(dim) if shift is None else np.asarray(shift, dtype=float)
    axes = np.eye(dim)
    if dim == 2:
        axes = rotation(angle).T
    sides = []
    for k in range(dim):
        for end in (0.0, 1.0):
            if kind == "axisymmetric" and k == 0 and end == 0.0:
                continue
            others = np.delete(np.arange(dim), k)
            platen: dict[str, Any] = {
                "type": "footing",
                "centre": (lower + size * (end * axes[k] + 0.5 * axes[others].sum(0))).tolist(),
                "normal": ((1.0 - 2.0 * end) * axes[k]).tolist(),
                "width": size if dim == 2 else [size] * 2,
            }
            if dim == 3:
                platen["along"] = axes[others[0]].tolist()
            move = end * size * (stretch[k] - 1.0) * axes[k]
            sides.append(
                implicit(
                    f"side {k} {end:g}", platen, delta=delta, form=form,
                    displacement=dict(zip("xyz", move.tolist(), strict=False)),
                )
            )  # fmt: skip
    entries = block_entries(kind, basis, boundaries=sides)
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body["points"] = [round(points * size)] * dim
    body["shape"] = {
        "type": "box", "lower": lower.tolist(), "upper": (lower + size).tolist(),
    }  # fmt: skip
    if angle:
        body["shape"]["angle"] = angle
    entries["analysis"]["tolerance"] = 1e-11
    if spacing == "graded":
        entries["grid"]["cell_size"] = {axis: AROUND_ONE[axis] for axis in AXES[:dim]}
        if kind == "axisymmetric":
            entries["grid"]["cell_size"]["x"] = BETWEEN_DOMAINS
    return Model.from_dict(entries)


def stress_error(model: Model, stretch: Floats, angle: float, points: MaterialPoints) -> Floats:
    """Deviation of each point's stress from the homogeneous one, over the norm of that."""
    simulation = Simulation(model, points)
    take_steps(simulation)
    dim = len(stretch)
    strain = np.zeros(3)
    strain[:dim] = np.log(stretch)
    if simulation.setup.kind == "axisymmetric":
        strain[2] = strain[0]
    lame = MODULUS * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    principal = lame * strain.sum() + MODULUS / (1.0 + POISSON) * strain
    exact = np.diag(principal / np.exp(strain.sum()))
    if dim == 2:
        exact[:2, :2] = rotation(angle) @ exact[:2, :2] @ rotation(angle).T
    place = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
    difference = simulation.state.points.stress[:, place] - exact
    return np.asarray(np.linalg.norm(difference, axis=(1, 2)) / np.linalg.norm(exact))


def cut_cell_points(model: Model, corners: Floats) -> MaterialPoints:
    """Points of a convex polygon's cut cells: Gauss's points with exact weights.

    Each cell's part of the polygon is divided into triangles around its centre with three points
    each, exact to degree 2; the shape functions' gradients have degree 1.
    """
    grid = background_grid(model)
    in_cells = grid.in_cells(corners)
    low, high = np.floor(in_cells.min(axis=0)), np.ceil(in_cells.max(axis=0))
    places, areas = [], []
    for i in np.arange(low[0], high[0]):
        for j in np.arange(low[1], high[1]):
            part = corners
            lower, upper = grid.position(np.array([[i, j], [i + 1.0, j + 1.0]]))
            for axis in range(2):
                part = _clipped(part, axis, lower[axis], 1.0)
                part = _clipped(part, axis, upper[axis], -1.0)
            if len(part) < 3:
                continue
            centre = part.mean(axis=0)
            for one, two in zip(part, np.roll(part, -1, axis=0), strict=True):
                (a, b), (c, d) = one - centre, two - centre
                area = 0.5 * (a * d - b * c)
                if area > 1e-12:
                    triangle = np.array([centre, one, two])
                    places.append((np.ones((3, 3)) + 3.0 * np.eye(3)) / 6.0 @ triangle)
                    areas.append(np.full(3, area / 3.0))
    ranges = initial_points(model).ranges
    position, volume = np.concatenate(places), np.concatenate(areas)
    return MaterialPoints.undeformed(
        [replace(ranges[0], stop=len(position))], position, volume,
        np.full(position.shape, 0.5),
    )  # fmt: skip


def _clipped(polygon: Floats, axis: int, at: float, side: float) -> Floats:
    """The part of a convex polygon (n, 2) with side (x_axis - at) >= 0."""
    kept: list[Floats] = []
    for one, two in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        a, b = side * (one[axis] - at), side * (two[axis] - at)
        if a >= 0.0:
            kept.append(one)
        if a * b < 0.0:
            kept.append(one + a / (a - b) * (two - one))
    return np.array(kept).reshape(-1, 2)
