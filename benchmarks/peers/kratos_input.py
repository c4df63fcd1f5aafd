# SPDX-License-Identifier: BSD-3-Clause
"""Writes a tilth model as input of Kratos MPM: the same grid, points, conditions and loads.

Kratos takes two meshes, the background grid and a mesh whose elements become material points. One
element for each point, centred on it, puts Kratos' points where tilth's are.
"""

from __future__ import annotations

import itertools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tilth import Model
from tilth.arrays import Floats, Integers
from tilth.mpm.initial_points import initial_points
from tilth.terms.loads import nearest_points

GRID, BODY, MATERIALS, PARAMETERS, TASK = (
    "grid.mdpa", "body.mdpa", "materials.json", "parameters.json", "task.json",
)  # fmt: skip
"""Files that `write` leaves in its folder."""

LAWS = {
    "plane_strain": "HyperElasticNeoHookeanPlaneStrain2DLaw",
    "3d": "HyperElasticNeoHookean3DLaw",
}
"""Elastic laws of Kratos MPM by kind of analysis; it has no law of Hencky's without yielding."""

LINEAR_SOLVERS: dict[str, dict[str, Any]] = {
    "amgcl": {
        "solver_type": "amgcl", "krylov_type": "cg", "smoother_type": "spai0",
        "coarsening_type": "smoothed_aggregation", "max_iteration": 200, "tolerance": 1e-7,
        "scaling": False, "verbosity": 0,
    },
    "sparse_lu": {"solver_type": "LinearSolversApplication.sparse_lu"},
}  # fmt: skip
"""Settings of the linear solvers of Kratos by name."""


class NotTranslated(Exception):
    """The model has something that this writer does not know."""


@dataclass(frozen=True)
class Mesh:
    """A regular mesh of quadrilaterals or hexahedra.

    Attributes:
        position: of the nodes, x fastest [length], shape (nodes, dim).
        element: numbers of their nodes, from 0, shape (elements, 2^dim).
    """

    position: Floats
    element: Integers

    @classmethod
    def box(cls, lower: Floats, cell: Floats, cells: Integers) -> Mesh:
        """Returns the mesh of a box of `cells` by direction."""
        dim = len(cells)
        count = cells + 1
        place = np.stack(
            [axis.ravel(order="F") for axis in np.indices(count, dtype=np.int64)], axis=1
        )
        stride = np.concatenate([[1], np.cumprod(count[:-1])])
        first = (place[np.all(place < cells, axis=1)] * stride).sum(axis=1)
        around = [(0, 0), (1, 0), (1, 1), (0, 1)]
        corners = around if dim == 2 else [(*c, z) for z, c in itertools.product((0, 1), around)]
        return cls(lower + place * cell, first[:, None] + np.array(corners) @ stride)


def write(
    model: Model, folder: Path, lower: list[float], upper: list[float], linear_solver: str
) -> None:
    """Writes the input files of Kratos MPM into `folder`.

    Args:
        model: one box of the linear basis and of Hencky's elasticity, constrained on grid lines and
            nodes.
        lower, upper: corners of the background grid, on its lines [length].
        linear_solver: a name of `LINEAR_SOLVERS`.

    Raises:
        NotTranslated: the model has something else.
    """
    entries = model.to_dict()
    refuse_what_is_not_translated(entries)
    cell = np.array(model.cell_size, dtype=float)
    cells = np.rint((np.array(upper) - lower) / cell).astype(np.int64)
    grid = Mesh.box(np.array(lower, dtype=float), cell, cells)
    constrained = [held_nodes(boundary, grid.position, cell) for boundary in entries["boundaries"]]
    (folder / GRID).write_text(mdpa(grid, dict(zip(parts(entries), constrained, strict=True))))

    body = entries["bodies"][0]
    shape = body["shape"]
    size = cell / body["points_per_cell"]
    count = np.rint((np.array(shape["upper"]) - shape["lower"]) / size).astype(np.int64)
    points = Mesh.box(np.array(shape["lower"], dtype=float), size, count)
    (folder / BODY).write_text(mdpa(points, {}, "points"))

    (folder / MATERIALS).write_text(json.dumps(materials(entries), indent=1))
    parameters = project_parameters(entries, model.dimension, LINEAR_SOLVERS[linear_solver])
    (folder / PARAMETERS).write_text(json.dumps(parameters, indent=1))
    (folder / TASK).write_text(json.dumps(task(model, entries), indent=1))


def refuse_what_is_not_translated(entries: dict[str, Any]) -> None:
    """Raises NotTranslated unless Kratos MPM can be given the same problem."""
    bodies, boundaries = entries["bodies"], entries.get("boundaries", [])
    known = {
        "one body": len(bodies) == 1,
        "a box along the axes": bodies[0]["shape"]["type"] == "box"
        and not np.any(bodies[0]["shape"].get("angle", 0.0)),
        "the linear basis": bodies[0]["basis"] == "linear",
        "no F-bar": bodies[0]["anti_locking"] == "none",
        "elasticity": {material["model"] for material in entries["materials"].values()}
        == {"hencky_elastic"},
        "plane strain or 3D": entries["analysis"]["kind"] in LAWS,
        "boundaries on grid lines": {b["type"] for b in boundaries} <= {"plane", "node"},
        "point forces": {load["type"] for load in entries.get("loads", [])} <= {"point_force"},
        "one tracked quantity": len(entries.get("track", [])) == 1,
    }
    for what, met in known.items():
        if not met:
            raise NotTranslated(f"only models with {what} can be written for Kratos")


def parts(entries: dict[str, Any]) -> list[str]:
    """Names of the parts of the grid that boundaries hold; Kratos takes no blank in a name."""
    return [f"held_{boundary['name'].replace(' ', '_')}" for boundary in entries["boundaries"]]


def held_nodes(boundary: dict[str, Any], position: Floats, cell: Floats) -> Integers:
    """Numbers of the nodes, from 0, that a boundary holds."""
    near = 1e-6 * cell
    if boundary["type"] == "node":
        on = np.all(np.abs(position - boundary["at"]) < near, axis=1)
    else:
        axis = "xyz".index(boundary["axis"])
        on = np.abs(position[:, axis] - boundary["at"]) < near[axis]
        for name, (least, greatest) in boundary.get("range", {}).items():
            along = "xyz".index(name)
            place = position[:, along]
            on &= (place > least - near[along]) & (place < greatest + near[along])
    return np.flatnonzero(on)


def mdpa(mesh: Mesh, node_parts: dict[str, Integers], element_part: str | None = None) -> str:
    """Returns a mesh in Kratos' format; numbers there begin with 1.

    Args:
        node_parts: nodes by the name of their part.
        element_part: name of the part of all elements; none if None.
    """
    count, dim = mesh.position.shape
    number = np.arange(1, count + 1)
    three = np.pad(mesh.position, ((0, 0), (0, 3 - dim)))
    lines = ["Begin Properties 0", "End Properties", "Begin Nodes"]
    lines += [f"{n} {x:.17g} {y:.17g} {z:.17g}" for n, (x, y, z) in zip(number, three, strict=True)]
    lines += ["End Nodes", f"Begin Elements Element{dim}D{2**dim}N"]
    lines += [
        f"{n} 0 {' '.join(map(str, nodes))}"
        for n, nodes in enumerate((mesh.element + 1).tolist(), 1)
    ]
    lines.append("End Elements")
    for name, nodes in node_parts.items():
        lines += _part(name, {"Nodes": (nodes + 1).tolist()})
    if element_part is not None:
        elements = range(1, len(mesh.element) + 1)
        lines += _part(element_part, {"Nodes": number.tolist(), "Elements": list(elements)})
    return "\n".join(lines) + "\n"


def _part(name: str, numbers: dict[str, list[int]]) -> list[str]:
    lines = [f"Begin SubModelPart {name}"]
    for kind, members in numbers.items():
        lines += [f"Begin SubModelPart{kind}", *map(str, members), f"End SubModelPart{kind}"]
    return [*lines, "End SubModelPart"]


def materials(entries: dict[str, Any]) -> dict[str, Any]:
    """Returns the contents of Kratos' file of materials."""
    soil = entries["materials"][entries["bodies"][0]["material"]]
    variables = {
        "THICKNESS": 1.0,
        "MATERIAL_POINTS_PER_ELEMENT": 1,
        "DENSITY": soil.get("density", 1.0),
        "YOUNG_MODULUS": soil["young_modulus"],
        "POISSON_RATIO": soil["poisson_ratio"],
    }
    law = {"name": LAWS[entries["analysis"]["kind"]]}
    return {
        "properties": [
            {
                "model_part_name": "Initial_MPM_Material.points",
                "properties_id": 1,
                "Material": {"constitutive_law": law, "Variables": variables, "Tables": {}},
            }
        ]
    }


def project_parameters(
    entries: dict[str, Any], dim: int, linear_solver: dict[str, Any]
) -> dict[str, Any]:
    """Returns the contents of Kratos' file of parameters."""
    schedule, tolerance = entries["schedule"], entries["analysis"]["tolerance"]
    step = schedule["end"] / schedule["steps"]
    return {
        "problem_data": {
            "problem_name": "peer", "parallel_type": "OpenMP", "echo_level": 0,
            "start_time": 0.0, "end_time": schedule["end"] - 0.5 * step,
        },
        "solver_settings": {
            "solver_type": "quasi_static", "model_part_name": "MPM_Material", "domain_size": dim,
            "echo_level": 0, "analysis_type": "non_linear",
            "grid_model_import_settings": {
                "input_type": "mdpa", "input_filename": Path(GRID).stem,
            },
            "model_import_settings": {"input_type": "mdpa", "input_filename": Path(BODY).stem},
            "material_import_settings": {"materials_filename": MATERIALS},
            "time_stepping": {"time_step": step},
            "compute_reactions": True,
            "convergence_criterion": "residual_criterion",
            "residual_relative_tolerance": tolerance,
            "residual_absolute_tolerance": 1e-30,
            "max_iteration": entries["analysis"]["maximum_iterations"],
            "linear_solver_settings": linear_solver,
        },
        "processes": {
            "constraints_process_list": [
                condition(boundary, part, step / schedule["end"], dim)
                for boundary, part in zip(entries["boundaries"], parts(entries), strict=True)
            ],
        },
        "output_processes": {},
    }  # fmt: skip


def condition(boundary: dict[str, Any], part: str, share: float, dim: int) -> dict[str, Any]:
    """Returns Kratos' process for a boundary; its displacement is that of one step, a `share`."""
    constrained: list[bool] = [False] * 3
    value: list[float | None] = [None] * 3
    if boundary["condition"] == "fixed":
        moves = dict.fromkeys("xyz"[:dim], 0.0)
    elif boundary["condition"] == "roller":
        moves = {boundary["axis"]: 0.0}
    else:
        moves = boundary["displacement"]
    for axis, move in moves.items():
        constrained["xyz".index(axis)] = True
        value["xyz".index(axis)] = share * move
    return {
        "python_module": "assign_vector_variable_process",
        "kratos_module": "KratosMultiphysics",
        "Parameters": {
            "model_part_name": f"Background_Grid.{part}", "variable_name": "DISPLACEMENT",
            "constrained": constrained, "value": value, "interval": [0.0, "End"],
        },
    }  # fmt: skip


def task(model: Model, entries: dict[str, Any]) -> dict[str, Any]:
    """Returns what kratos_run.py adds: forces on points, and the quantity to compare.

    Kratos' points are in the order of `body.mdpa`; both codes' are found by their places.
    """
    points = initial_points(model)

    def places(at: list[float]) -> list[list[float]]:
        numbers = nearest_points(points, at, model.cell_size, None)
        found: list[list[float]] = points.position[points.index_of(numbers)].tolist()
        return found

    forces = [
        {"places": places(load["at"]), "force": load["force"]} for load in entries.get("loads", [])
    ]
    track = entries["track"][0]
    answer = {"quantity": track["quantity"], "component": track["component"]}
    answer["scale"] = track.get("scale", 1.0)
    if track["quantity"] == "displacement":
        answer["places"] = places(track["at"])
    else:
        names = [boundary["name"] for boundary in entries["boundaries"]]
        answer["part"] = parts(entries)[names.index(track["boundary"])]
    return {"end": entries["schedule"]["end"], "forces": forces, "answer": answer}
