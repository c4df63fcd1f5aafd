# SPDX-License-Identifier: BSD-3-Clause
"""Newton's iteration with loads that follow the soil's surface: quadratic convergence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_problems import BASES, material_entries, plane

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.surface.loads import SurfaceLoads

every_kind = pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
every_basis = pytest.mark.parametrize("basis", BASES)

SIZE = {"plane_strain": 15.0, "axisymmetric": 250.0}
"""Of the loads below: they move its edge by 0.2 to 0.7 m; a ring is stiffer than a pillar."""


def loads(size: float) -> dict[str, dict[str, Any]]:
    """Loads on the right side that follow it, of about the same resultant."""
    return {
        "pressure": {"pressure": size},
        "shear": {"shear": -size},
        "water": {"hydrostatic": {"level": 2.0, "unit_weight": size}},
        "along": {"pressure_along": [[0.0, 0.0], [2.2, 1.5 * size]]},
    }


def pillar(kind: str, basis: str, load: dict[str, Any]) -> Simulation:
    """A pillar, a ring in axisymmetry, fixed at its base and loaded on its right side."""
    side = {"type": "surface", "body": "pillar", "start": [1.7, 0.0], "end": [1.7, 2.2]}
    model = Model.from_dict(
        {
            "analysis": {
                "kind": kind,
                "solver": "superlu",
                "tolerance": 1e-13,
                "maximum_iterations": 60,
            },
            "grid": {"cell_size": 0.5},
            "materials": {"soil": material_entries("hencky_elastic")},
            "bodies": [
                {
                    "name": "pillar",
                    "material": "soil",
                    "shape": {"type": "box", "lower": [0.6, 0.0], "upper": [1.7, 2.2]},
                    "basis": basis,
                    "spacing": 0.15,
                    "surface": {},
                }
            ],
            "boundaries": [plane("base", "y", 0.0, condition="fixed")],
            "loads": [side | load],
            "schedule": {"steps": 1},
        }
    )
    return Simulation(model)


def residuals_of_one_step(kind: str, basis: str, load: str) -> Floats:
    simulation = pillar(kind, basis, loads(SIZE[kind])[load])
    residuals = np.array(simulation.advance(0.0, 1.0).equilibrium.residuals)
    assert np.abs(simulation.state.points.displacement).max() > 0.15
    return residuals


@every_kind
@every_basis
@pytest.mark.parametrize("load", loads(1.0))
def test_newton_converges_quadratically_with_a_load_that_follows(
    kind: str, basis: str, load: str
) -> None:
    """r_(k+1) <= C r_k^2 over many decades: the load's derivative is exact in the stiffness."""
    residuals = residuals_of_one_step(kind, basis, load)
    tail = residuals[residuals < 0.05]
    clean = tail[tail > 1e-12]  # below that stands round-off
    assert len(clean) >= 2
    assert clean[0] / tail[-1] > 1e8
    following = tail[1 : len(clean) + 1]
    constant = following / clean[: len(following)] ** 2
    assert constant[following > 1e-12].max() < 30.0


@every_kind
def test_newton_is_linear_without_the_derivative_of_the_load(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The control of the test above: the same load, its derivative left out."""
    monkeypatch.setattr(SurfaceLoads, "subtract_derivative", lambda *arguments: None)
    residuals = residuals_of_one_step(kind, "linear", "water")
    tail = residuals[(residuals < 0.05) & (residuals > 1e-12)]
    ratio = tail[1:] / tail[:-1]
    assert len(tail) >= 6
    assert (ratio[2:] > 1e-3).all()  # a constant number of digits for each iteration
