# SPDX-License-Identifier: BSD-3-Clause
"""Several processes find the serial run's result: surfaces, loads, axis, starting state."""

from __future__ import annotations

from typing import Any

import pytest
from mpi_runs import assert_as_serial
from small_problems import block_entries, dimension, material_entries, off_lines, plane, rollers
from small_problems import weight as weight_of

from tilth import Model

pytestmark = pytest.mark.slow
several = pytest.mark.parametrize("processes", [2, 3])


def on_clay(kind: str, basis: str = "gimp", **changed: Any) -> dict[str, Any]:
    """A block of von Mises clay, 6 by 3 cells, between rollers, with weight."""
    entries = block_entries(kind, basis, boundaries=rollers(kind, 6.0, sides=False), **changed)
    dim = dimension(kind)
    entries["analysis"]["solver"] = "auto"
    body = entries["bodies"][0]
    body["shape"]["upper"] = [6.0, 3.0] if dim == 2 else [6.0, 2.0, 2.0]
    entries["materials"]["soil"] = material_entries("von_mises")
    entries["boundaries"][dim - 1]["condition"] = "fixed"
    entries["loads"] = [weight_of(kind, 2.0)]
    entries["schedule"] = {"steps": 3}
    return entries


@several
@pytest.mark.parametrize("points", ["extra", "outer_layer"])
def test_a_pressure_that_follows_the_surface(points: str, processes: int) -> None:
    """It acts on a part across the cells of all processes, and the surface is refined."""
    entries = on_clay("plane_strain")
    entries["bodies"][0]["surface"] = {"spacing": 0.4, "points": points}
    entries["loads"].append({
        "type": "surface", "body": "block", "pressure": 60.0, "shear": 5.0,
        "start": [5.2, 3.0], "end": [0.7, 3.0],
    })  # fmt: skip
    entries["loads"].append({
        "type": "surface", "body": "block",
        "hydrostatic": {"level": 3.0, "unit_weight": 10.0}, "start": [6.0, 0.0], "end": [6.0, 3.0],
    })  # fmt: skip
    assert_as_serial(Model.from_dict(entries), processes)


@several
def test_a_pressure_on_a_region_in_space(processes: int) -> None:
    entries = on_clay("3d", "linear")
    entries["bodies"][0]["surface"] = {"spacing": 1.0}
    entries["loads"].append({
        "type": "surface", "body": "block", "pressure": 40.0, "part": "z+",
        "within": {"lower": [0.6, 0.3], "upper": [4.7, 1.6]},
    })  # fmt: skip
    assert_as_serial(Model.from_dict(entries), processes)


@several
def test_forces_at_points_of_several_processes(processes: int) -> None:
    entries = on_clay("3d", "linear")
    entries["loads"] += [
        {"type": "point_force", "body": "block", "at": [3.05, 1.0, 2.0], "force": [0.0, 4.0, -9.0]},
        {
            "type": "line_force", "body": "block", "start": [0.3, 0.5, 2.0], "end": [5.6, 1.5, 2.0],
            "force": [0.0, 0.0, -5.0],
        },
    ]  # fmt: skip
    assert_as_serial(Model.from_dict(entries), processes)


@several
@pytest.mark.parametrize("shift", [0.0, 0.37])
def test_the_axis_of_symmetry(shift: float, processes: int) -> None:
    """On a grid line and between two, under a footing, in a column higher than wide."""
    entries = off_lines(on_clay("axisymmetric"), shift)
    entries["bodies"][0]["shape"]["upper"] = [3.0, 6.0]
    entries["boundaries"] = [
        plane("base", "y", 0.0),
        plane(
            "press",
            "y",
            6.0,
            condition="prescribed",
            displacement={"y": -0.3},
            range={"x": [0.0, 1.7]},
        ),
    ]
    assert_as_serial(Model.from_dict(entries), processes)


@several
@pytest.mark.parametrize(
    "stress", [{"type": "k0", "K0": 0.7}, {"type": "gravity", "steps": 2}], ids=["k0", "gravity"]
)
def test_the_equilibrium_of_the_starting_state(stress: dict[str, Any], processes: int) -> None:
    """Of a bench, whose declared stress is not in equilibrium; the material yields in places."""
    entries = on_clay("plane_strain")
    entries["materials"]["soil"] = material_entries("mohr_coulomb", cohesion=4.0)
    low, high = dict(entries["bodies"][0]), entries["bodies"][0]
    low |= {"name": "low", "shape": {"type": "box", "lower": [3.0, 0.0], "upper": [6.0, 1.0]}}
    high["shape"]["upper"] = [3.0, 3.0]
    entries["bodies"].append(low)
    entries["loads"][0]["factor"] = [[0.0, 1.0], [1.0, 1.5]]
    entries["boundaries"].append(plane("far", "x", 6.0))
    entries["initial"] = {"stress": [{**stress, "body": name} for name in ("block", "low")]}
    assert_as_serial(Model.from_dict(entries), processes)
