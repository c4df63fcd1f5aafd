# SPDX-License-Identifier: BSD-3-Clause
"""Soil that conducts water better along one direction than along another."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from consolidating import with_flow
from small_problems import block_entries, dimension, rollers
from test_flow_boundaries import OFF, consolidated, implicit, pressures, terzaghi
from test_flow_boundaries import column as cut_column
from test_flow_planes import through

from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.pore_water import CONDUCTIVITY, PRESSURE

FLUX = 1e-3
TENSORS: dict[str, Any] = {
    "plane_strain": [[6.0, 2.0], [2.0, 1.0]],
    "3d": [[6.0, 2.0, 1.0], [2.0, 3.0, 0.5], [1.0, 0.5, 1.0]],
}


def block(kind: str, basis: str) -> Any:
    """A stiff block of four cells along each axis."""
    entries: dict[str, Any] = block_entries(kind, basis, cells=4)
    entries["materials"]["soil"] |= {"young_modulus": 1e6, "poisson_ratio": 0.0}
    entries["bodies"][0] |= {"surface": {}, "anti_locking": "none"}
    entries["boundaries"] = rollers(kind, 4.0)
    entries["schedule"] = {"steps": 1, "end": 1e9}
    return entries


def gradient_of(simulation: Simulation) -> tuple[Floats, float]:
    """Gradient of the pressure of the points, and its greatest distance from a plane."""
    points = simulation.state.points
    place = np.column_stack([points.position, np.ones(len(points))])
    pressure = points.water[:, PRESSURE]
    found = np.linalg.lstsq(place, pressure, rcond=None)[0]
    return found[:-1], float(np.abs(place @ found - pressure).max())


@pytest.mark.parametrize("kind", TENSORS)
@pytest.mark.parametrize("basis", ["linear", "gimp"])
def test_water_that_flows_down_has_a_gradient_across(kind: str, basis: str) -> None:
    """q = k A grad p with q downwards through sealed sides; exact, as it is linear.

    The velocity of the flow is that of the flux at all points.
    """
    dim, tensor = dimension(kind), TENSORS[kind]
    up = "xyz"[dim - 1]
    flow = [
        through("top", up, 4.0, condition="flux", flux=FLUX),
        through("base", up, 0.0, condition="flux", flux=-FLUX),
    ]
    simulation = Simulation(with_flow(block(kind, basis), flow, conductivity_ratios=tensor))
    for step in range(3):  # the first one is 1e5 times the time of consolidation
        simulation.advance(step, step + 1.0)
    expected = np.linalg.solve(np.array(tensor), FLUX * np.eye(dim)[-1])
    gradient, bent = gradient_of(simulation)
    scale = 4.0 * float(np.abs(expected).max())
    np.testing.assert_allclose(gradient, expected, rtol=0, atol=1e-5 * scale)
    assert bent < 1e-5 * scale
    velocity = simulation.state.points.water[:, -dim:]
    still = np.broadcast_to(-FLUX * np.eye(dim)[-1], velocity.shape)
    np.testing.assert_allclose(velocity, still, rtol=0, atol=1e-5 * FLUX)


@pytest.mark.parametrize("ratios", [[30.0, 1.0], [0.1, 4.0], [[20.0, 3.0], [3.0, 2.0]]])
def test_a_drain_off_the_lines_of_the_grid(ratios: Any) -> None:
    """A column consolidates by its vertical conductivity; errors over the load.

    Where the principal directions are inclined it is k_yy - k_xy^2 / k_xx: nothing flows across the
    column, whose sides are sealed.
    """
    entries = cut_column(top=8.0)
    load = {"type": "surface", "body": "block", "start": [1.0, 8.0], "end": [0.0, 8.0]}
    entries["loads"] = [{**load, "pressure": 1e-2, "factor": [[0, 1], [1e9, 1]]}]
    matrix = np.array(ratios) if np.ndim(ratios) == 2 else np.diag(ratios)
    down = float(matrix[1, 1] - matrix[0, 1] ** 2 / matrix[0, 0])
    water = {"hydraulic_conductivity": 1.0 / down, "conductivity_ratios": ratios}
    simulation = consolidated(entries, [implicit("drain", 1, OFF, 1.0, 2)], 8.0 - OFF, **water)
    height, pressure = pressures(simulation)
    expected = terzaghi((height - OFF) / (8.0 - OFF), 0.2)
    np.testing.assert_allclose(pressure / 1e-2, expected, rtol=0, atol=0.015)


def test_only_the_product_counts() -> None:
    """Of the conductivity and the ratios; points have the least conductivity of all directions."""
    found = []
    for k, ratios in ((2.0, [3.0, 0.5]), (1.0, [6.0, 1.0]), (6.0, [[1.0, 0.0], [0.0, 1.0 / 6.0]])):
        flow = [through("side", "x", 4.0), through("top", "y", 4.0, condition="flux", flux=FLUX)]
        water = {"hydraulic_conductivity": k, "conductivity_ratios": ratios}
        simulation = Simulation(with_flow(block("plane_strain", "gimp"), flow, **water))
        simulation.advance(0.0, 1e-4)
        np.testing.assert_allclose(simulation.state.points.water[:, CONDUCTIVITY], 1.0, rtol=1e-14)
        found.append(simulation.state.points.water[:, PRESSURE].copy())
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)
    np.testing.assert_allclose(found[2], found[0], rtol=1e-9)
