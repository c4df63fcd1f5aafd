# SPDX-License-Identifier: BSD-3-Clause
"""Copies of a plane model turned against the grid: the same problem with other cut cells."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.boundaries.surfaces.motion import rotation_matrix
from tilth.model import Box, ImplicitBoundary, Model, NodeBoundary, PlaneBoundary
from tilth_verification.cases import example, varied

ANGLE = 30.0
"""Angle of the files `turned.toml` against the `case.toml` in the same folder [degrees]."""
ANGLES = (17.0, 30.0, 45.0)
"""Angles at which the reference problems are solved [degrees]."""
GRID_SHIFT = 0.37
"""Shift of the grid along both axes, in cells, for copies that are not turned."""
HINGE_WIDTH = 0.02
"""Width of the short boundary that replaces the condition on a node [length]."""
ALIGNED = "the same along the grid"

POSITION_KEYS = ("point", "centre", "place", "at", "start", "end")
DIRECTION_KEYS = ("normal", "direction", "acceleration", "force")
MODIFICATIONS: dict[str, dict[str, Any]] = {
    "strip_footing": {
        "bodies.0.basis": "gimp",
        "grid.follow": {"boundary": "footing", "place": [0.5, 5.0], "axes": ["x", "y"]},
    }
}
"""Problem -> further changes of its `case.toml`: the footing's edge inside a cell."""


def aligned(problem: str, cell_size: float | None = None) -> Model:
    """Returns the problem of an example with implicit boundaries on its grid lines.

    cell_size: [length]; that of its `case.toml` if not given. The origin keeps its position
    in the cell.
    """
    model = example(problem)
    changes = {}
    if cell_size is not None:
        origin = np.array(model.origin) * (cell_size / model.cell_size[0])
        changes = {"grid.cell_size": cell_size, "grid.origin": origin.tolist()}
    return varied(implicit(varied(model, changes)), MODIFICATIONS.get(problem, {}))


def shifted(model: Model) -> Model:
    """Returns a model whose grid is moved by `GRID_SHIFT` cells along each axis."""
    origin = np.add(model.origin, GRID_SHIFT * np.array(model.cell_size))
    return varied(model, {"grid.origin": origin.tolist()})


def implicit(model: Model) -> Model:
    """Returns a plane model with implicit boundaries for its conditions on grid lines and nodes.

    The soil is on the side of the first body. A condition on a part of a line, which must begin on
    a line of symmetry, is that of a footing. A node becomes a hinge: a footing of width
    `HINGE_WIDTH` that constrains the motion along its face; its roller constrains the normal
    motion. Tracked quantities are left out.
    """
    box = model.bodies[0].shape
    assert isinstance(box, Box)
    centre = 0.5 * np.add(box.lower, box.upper)
    boundaries = []
    declared = zip(model.boundaries, model.to_dict()["boundaries"], strict=True)
    for boundary, entries in declared:
        if isinstance(boundary, PlaneBoundary):
            constrained = _on_plane(boundary, centre)
        elif isinstance(boundary, NodeBoundary):
            assert boundary.components is None, boundary.name
            inwards = centre - boundary.at
            normal = np.where(np.abs(inwards) == np.abs(inwards).max(), np.sign(inwards), 0.0)
            geometry = {"type": "footing", "centre": list(boundary.at), "normal": normal.tolist()}
            constrained = {"geometry": geometry | {"width": HINGE_WIDTH}, "condition": "tangential"}
        else:
            assert isinstance(boundary, ImplicitBoundary), boundary.name
            constrained = entries
        boundaries.append({**constrained, "name": boundary.name, "type": "implicit"})
    return varied(model, {"boundaries": boundaries, "track": []})


def _on_plane(boundary: PlaneBoundary, centre: Floats) -> dict[str, Any]:
    axis = "xy".index(boundary.axis)
    point, normal = np.zeros(2), np.zeros(2)
    point[axis], normal[axis] = boundary.at, np.sign(centre[axis] - boundary.at)
    entries: dict[str, Any] = {"condition": "roller"}
    geometry: dict[str, Any]
    if boundary.range is None:
        assert boundary.condition == "roller", boundary.name
        geometry = {"type": "plane", "point": point.tolist()}
    else:
        assert boundary.displacement is not None
        assert set(boundary.displacement) == {boundary.axis}, boundary.name
        ((along, (lower, upper)),) = boundary.range.items()
        point["xy".index(along)] = lower
        geometry = {"type": "footing", "centre": point.tolist()}
        geometry["width"] = 2.0 * (upper - lower)
        entries |= {"displacement": dict(boundary.displacement), "factor": boundary.factor}
    return {**entries, "geometry": {**geometry, "normal": normal.tolist()}}


def turned(model: Model, angle: float) -> Model:
    """Returns a plane model whose soil, boundaries and loads are turned about (0, 0).

    The grid is not turned, except the point that it follows. Supported are bodies that are boxes,
    implicit boundaries on planes and footings, fixed or displaced, body forces and point forces.

    angle: [degrees], anticlockwise.
    """
    turn = rotation_matrix(angle, None, 2)
    entries = model.to_dict()
    for body, declared in zip(entries["bodies"], model.bodies, strict=True):
        shape = declared.shape
        assert isinstance(shape, Box)
        lower = turn @ shape.lower
        side = np.subtract(shape.upper, shape.lower)
        whole = {"lower": lower.tolist(), "upper": (lower + side).tolist()}
        body["shape"] |= whole | {"angle": shape.angle + angle}
    for boundary in entries["boundaries"]:
        assert boundary["type"] == "implicit", boundary["type"]
        _turn(boundary["geometry"], turn)
        _turn(boundary, turn)
        if (moved := boundary.get("displacement")) is not None:
            displacement = turn @ [moved.get(axis, 0.0) for axis in "xy"]
            boundary["displacement"] = dict(zip("xy", displacement.tolist(), strict=True))
    for load in entries["loads"]:
        _turn(load, turn)
    if (follow := entries["grid"].get("follow")) is not None:
        _turn(follow, turn)
    return Model.from_dict(entries)


def copies(model: Model) -> Iterator[tuple[str, float, Model]]:
    """Yields the copies that a plane model is compared with: label, angle [degrees], model.

    Those turned by `ANGLES`, then the one that is not turned, on a shifted grid.
    """
    for angle in ANGLES:
        yield f"turned by {angle:g} degrees", angle, turned(model, angle)
    yield f"grid shifted by {GRID_SHIFT:g} cells", 0.0, shifted(model)


def _turn(table: dict[str, Any], turn: Floats) -> None:
    for key in (*POSITION_KEYS, *DIRECTION_KEYS):
        if table.get(key) is not None:
            table[key] = (turn @ table[key]).tolist()


def reactions(model: Model, angle: float = 0.0) -> Floats:
    """Runs a copy to its end; returns the forces of its boundaries on the soil, turned back.

    angle: by which the copy is turned [degrees]. Returns [force/length], shape (boundaries, 2).
    """
    forces: list[list[Floats]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        forces.append([result.resultant(boundary.name) for boundary in model.boundaries])

    march(model, after_step)
    return np.asarray(np.array(forces[-1]) @ rotation_matrix(angle, None, 2))


def reaction_difference(found: Floats, reference: Floats) -> float:
    """Returns the largest difference of `reactions`, over the last boundary's force [-]."""
    return float(np.abs(found - reference).max() / np.abs(reference[-1]).max())
