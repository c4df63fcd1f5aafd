# SPDX-License-Identifier: BSD-3-Clause
"""Contact of soil with both sides of a thin plate in it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tilth import Model
from tilth.analysis.simulation import Simulation

STRENGTH, ADHESION, DEPTH = 1e4, 0.4, 0.5
TRACTION = ADHESION * STRENGTH


def simulation(normal: str, cell: float = 0.25, tangential: str = "adhesion", **motion: Any) -> Any:
    """Returns clay in which a thin skirt stands to DEPTH, at x = 0 (a grid line with 0.25)."""
    planes = {"base": ("y", -1.0), "left": ("x", -1.0), "right": ("x", 1.0)}
    factor = {"adhesion_factor": ADHESION} if tangential == "adhesion" else {}
    return Simulation(
        Model.from_dict(
            {
                "title": "skirt",
                "analysis": {"kind": "plane_strain"},
                "grid": {"cell_size": cell},
                "materials": {
                    "clay": {
                        "model": "tresca", "young_modulus": 1e7, "poisson_ratio": 0.3,
                        "undrained_shear_strength": STRENGTH,
                    }
                },
                "bodies": [
                    {
                        "name": "clay", "material": "clay", "basis": "gimp", "points_per_cell": 2,
                        "shape": {"type": "box", "lower": [-1.0, -1.0], "upper": [1.0, 0.0]},
                    }
                ],
                "boundaries": [
                    {"name": n, "type": "plane", "axis": a, "at": at, "condition": "fixed"}
                    for n, (a, at) in planes.items()
                ],
                "rigid_bodies": [
                    {
                        "name": "skirt", "centre": [0.0, 0.0], "rotation": 0.0,
                        "geometry": {
                            "type": "polyline", "vertices": [[0.0, 0.25], [0.0, -DEPTH]],
                            "soil": "both",
                        },
                        "contact": {"normal": normal, "tangential": tangential, **factor},
                        "displacement": {"x": 0.0, "y": 0.0, **motion},
                    }
                ],
                "schedule": {"steps": 1},
            }
        )
    )  # fmt: skip


@pytest.mark.parametrize("cell", [0.25, 0.2])
def test_a_skirt_in_intact_clay_has_adhesion_on_both_sides(cell: float) -> None:
    moved = simulation("bilateral", cell, y=-0.05)
    moved.advance(0.0, 1.0)
    force = moved.rigid_bodies["skirt"].force
    exact = 2.0 * TRACTION * DEPTH
    # the part of a quadrature point at the surface is measured to a 16th
    np.testing.assert_allclose(force, [0.0, exact], atol=0.01 * exact)


def test_a_skirt_that_is_pushed_aside_is_pressed_on_one_side() -> None:
    moved = simulation("unilateral", tangential="smooth", x=1e-4)
    result = moved.advance(0.0, 1.0)
    state = result.contacts["skirt"]
    pressure = -(state.weight * state.normal_stress)
    front = state.normal[:, 0] > 0.0
    assert pressure[front].sum() > 100.0
    np.testing.assert_allclose(pressure[~front].sum(), 0.0, atol=1e-3 * pressure.sum())
    force = moved.rigid_bodies["skirt"].force
    np.testing.assert_allclose(force, [-pressure.sum(), 0.0], rtol=1e-9, atol=1e-6)


def test_each_side_takes_over_its_own_tractions_on_another_grid() -> None:
    last, finer = (simulation("bilateral", cell, y=-0.05) for cell in (0.25, 0.125))
    last.advance(0.0, 1.0)
    before, after = last.contact_surfaces[0], finer.contact_surfaces[0]
    above = before.quadrature.surface[:, 1] > -0.2
    before.carried[above] *= np.sign(before.quadrature.normal[above, :1])
    after.carry_from(before)
    place, side = after.quadrature.surface[:, 1], np.sign(after.quadrature.normal[:, 0])
    along = after.carried[:, 1]
    chosen = (place > -0.1) & (place < -0.02)
    np.testing.assert_allclose(np.abs(along[chosen]), TRACTION, rtol=1e-9)
    np.testing.assert_array_equal(np.sign(along[chosen]), side[chosen])
