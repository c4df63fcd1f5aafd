# SPDX-License-Identifier: BSD-3-Clause
"""Problems for Newton iterations."""

from __future__ import annotations

from typing import Any

from small_problems import (
    AXES,
    WEAK,
    block_entries,
    dimension,
    material_entries,
    plane,
)

from tilth import Model
from tilth.analysis.simulation import Simulation


def leaning_block(
    kind: str, basis: str, material: str, acceleration: float, **analysis: Any
) -> Simulation:
    """A block that cuts cells, fixed at its base, pulled down and sideways in one step."""
    dim = dimension(kind)
    boundaries = [plane("base", AXES[dim - 1], 0.0, condition="fixed")]
    lower = [0.3] * (dim - 1) + [0.0]
    if kind == "axisymmetric":
        boundaries.append(plane("axis", "x", 0.0))
        lower[0] = 0.0
    pull = {"type": "body_force", "acceleration": [0.3 * acceleration] * (dim - 1)}
    pull["acceleration"].append(-acceleration)
    entries = block_entries(kind, basis, material, boundaries=boundaries, loads=[pull])
    entries["materials"]["soil"] = material_entries(material, **WEAK.get(material, {}))
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body["spacing"] = 0.3
    body["shape"] = {"type": "box", "lower": lower, "upper": [1.8] * dim}
    entries["analysis"] |= {
        "tolerance": 1e-13, "maximum_iterations": 40, "line_search": False, **analysis,
    }  # fmt: skip
    return Simulation(Model.from_dict(entries))


def pressed_block(
    kind: str, basis: str, law: str, anti_locking: str = "none", **changed: Any
) -> Simulation:
    """A block pressed by an eighth between rough plates, in one step."""
    dim = dimension(kind)
    up = AXES[dim - 1]
    plates = {"condition": "prescribed", "displacement": dict.fromkeys(AXES[:dim], 0.0)}
    boundaries = [plane("base", up, 0.0, condition="fixed"), plane("top", up, 2.0, **plates)]
    boundaries[1]["displacement"][up] = -0.25
    if kind == "axisymmetric":
        boundaries.append(plane("axis", "x", 0.0))
    entries = block_entries(kind, basis, law, boundaries=boundaries)
    entries["bodies"][0]["anti_locking"] = anti_locking
    entries["materials"]["soil"] = material_entries(law, **changed)
    entries["analysis"] |= {"tolerance": 1e-13, "maximum_iterations": 40, "line_search": False}
    return Simulation(Model.from_dict(entries))
