# SPDX-License-Identifier: BSD-3-Clause
"""Small problems that have all terms and boundaries, for tests on several processes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from implicit_blocks import flat, implicit
from small_problems import material_entries

from tilth import Model

Case = Callable[[], tuple[Model, list[float]]]


def plane(basis: str = "gimp", **body: Any) -> tuple[Model, list[float]]:
    """A block on an oblique boundary beside a wall, with every load and water."""
    square = {"type": "polygon", "vertices": [[0.0, 0.0], [4.0, 0.0], [4.0, 2.03], [0.0, 2.03]]}
    soil = material_entries("von_mises")
    soil["saturated_density"] = 1.5 * soil["density"]
    entries: dict[str, Any] = {
        "analysis": {"kind": "plane_strain", "ghost_stabilisation": 0.005, "tolerance": 1e-12},
        "grid": {"cell_size": 0.5, "origin": [-0.2, 0.0]},
        "materials": {"soil": soil},
        "bodies": [
            {"name": "block", "material": "soil", "shape": square, "basis": basis,
             "spacing": 0.125, "surface": {}, **body}
        ],
        "boundaries": [
            implicit("base", flat([0.0, 0.12], [-0.1, 1.0]), "fixed", displacement={"y": 0.04}),
            implicit("wall", flat([0.0, 0.0], [1.0, 0.0]), "roller"),
        ],
        "loads": [
            {"type": "body_force", "acceleration": [0.0, -0.02]},
            {"type": "surface", "body": "block", "pressure": 0.05,
             "start": [4.0, 2.03], "end": [0.0, 2.03]},
            {"type": "seismic", "coefficient": [0.3, -0.1], "factor": [[0.0, 1.0], [1.0, 1.0]]},
            {"type": "point_force", "body": "block", "at": [1.9, 2.03], "force": [0.002, -0.005]},
        ],
        "water": {"level": [[-1.0, 1.1], [0.9, 1.3], [4.0, 0.9]], "unit_weight": 0.03,
                  "factor": [[0.0, 0.0], [1.0, 1.0]]},
        "schedule": {"steps": 4},
    }  # fmt: skip
    return Model.from_dict(entries), [0.0, 0.25, 0.5, 0.75, 1.0]


def ring(basis: str = "gimp") -> tuple[Model, list[float]]:
    """A cylinder of soil beside the axis of symmetry, which is between two columns of nodes."""
    entries = plane(basis)[0].to_dict()
    entries["analysis"]["kind"] = "axisymmetric"
    entries["boundaries"] = entries["boundaries"][:1]
    entries["loads"] = entries["loads"][:2]
    return Model.from_dict(entries), plane(basis)[1]


def graded() -> tuple[Model, list[float]]:
    """The block of `plane` on a graded grid, on nodes and between walls, one of which is a band."""
    entries = plane("linear", anti_locking="f_bar")[0].to_dict()
    entries["grid"] = {
        "cell_size": {"x": [[0.0, 0.4], [1.0, 0.2], [4.0, 0.6]], "y": [[0.0, 0.25], [2.0, 0.5]]}
    }
    del entries["bodies"][0]["spacing"]
    entries["bodies"][0]["points_per_cell"] = 2
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [0.0, 0.0], "upper": [4.0, 2.03]}
    entries["boundaries"][0] = {
        "name": "base",
        "type": "plane",
        "axis": "y",
        "at": 0.0,
        "condition": "fixed",
    }
    entries["boundaries"][1]["form"] = "band"
    return Model.from_dict(entries), plane()[1]


def space(basis: str = "linear", **body: Any) -> tuple[Model, list[float]]:
    """A cube of two layers pressed by a plane that is turned in the grid, on an oblique base."""
    cube = {"type": "box", "lower": [0.0, 0.0, 0.0], "upper": [2.0, 1.5, 1.5]}
    entries: dict[str, Any] = {
        "analysis": {"kind": "3d", "tolerance": 1e-12},
        "grid": {"cell_size": 0.5, "origin": [0.1, -0.05, 0.13]},
        "materials": {"soil": material_entries("mohr_coulomb")},
        "bodies": [{"name": "cube", "material": "soil", "shape": cube, "basis": basis,
                    "points_per_cell": 2, **body}],
        "boundaries": [
            implicit("base", flat([0.0, 0.0, 0.11], [0.1, -0.05, 1.0]), "fixed"),
            implicit("lid", flat([0.0, 0.0, 1.42], [0.05, 0.1, -1.0]), "roller",
                     displacement={"z": -0.05}),
        ],
        "loads": [{"type": "body_force", "acceleration": [0.0, 0.0, -0.02]}],
        "schedule": {"steps": 4},
    }  # fmt: skip
    return Model.from_dict(entries), [0.0, 0.25, 0.5]


CASES: dict[str, Case] = {
    "plane strain, gimp": plane,
    "plane strain, linear, F-bar": lambda: plane("linear", anti_locking="f_bar"),
    "plane strain, gimp, F-bar": lambda: plane("gimp", anti_locking="f_bar"),
    "plane strain, cpdi1": lambda: plane("cpdi1"),
    "plane strain, cpdi2": lambda: plane("cpdi2"),
    "axisymmetric, gimp": ring,
    "axisymmetric, linear": lambda: ring("linear"),
    "graded grid, band": graded,
    "space, linear, F-bar": lambda: space("linear", anti_locking="f_bar"),
    "space, gimp": lambda: space("gimp"),
}
"""The models of each problem, by its name, and the times of its first steps."""
