# SPDX-License-Identifier: BSD-3-Clause
"""Problems for Newton iterations."""

from __future__ import annotations

from typing import Any

from small_problems import (
    AXES,
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
    entries["materials"]["soil"] = material_entries(
        material, hardening_modulus=100.0, yield_stress=20.0
    )
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body["spacing"] = 0.3
    body["shape"] = {"type": "box", "lower": lower, "upper": [1.8] * dim}
    entries["analysis"] |= {
        "tolerance": 1e-13, "maximum_iterations": 40, "line_search": False, **analysis,
    }  # fmt: skip
    return Simulation(Model.from_dict(entries))
