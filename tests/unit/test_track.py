# SPDX-License-Identifier: BSD-3-Clause
"""Tracked quantities against what the motion or equilibrium makes them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_problems import affine, block_entries, plane, rollers, weight

from tilth import Model
from tilth.analysis.energies import Energies
from tilth.analysis.simulation import Simulation
from tilth.analysis.tracker import Tracker

GRADIENT = np.array([[1.3, 0.4], [0.1, 0.85]])


def track(
    tracked: list[dict[str, Any]], entries: dict[str, Any], steps: int = 4
) -> tuple[list[list[float]], Simulation, list[tuple[str, str]]]:
    """Values before the first step and after each one."""
    named = [{"name": f"t{i}", **item} for i, item in enumerate(tracked)]
    model = Model.from_dict({**entries, "track": named})
    simulation = Simulation(model)
    tracker = Tracker(model, simulation.state.points)
    energies = Energies.at_start(simulation.setup, simulation.state)
    rows = [tracker.values(simulation.setup, simulation.state, None, energies)]
    for k in range(steps):
        result = simulation.advance(k / steps, (k + 1) / steps)
        energies.add(result)
        rows.append(tracker.values(simulation.setup, simulation.state, result, energies))
    return rows, simulation, tracker.columns


def moved(**changed: Any) -> dict[str, Any]:
    return block_entries("plane_strain", "gimp", boundaries=[affine(GRADIENT)], **changed)


def test_displacement_of_the_nearest_point_and_its_components() -> None:
    asked = [
        {"quantity": "displacement", "at": [2.0, 2.0], "component": c}
        for c in ("x", "y", "magnitude")
    ]
    rows, _, columns = track(asked, moved())
    x, y = (GRADIENT - np.eye(2)) @ [1.75, 1.75]
    assert rows[0] == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(rows[-1], [x, y, np.hypot(x, y)], rtol=1e-12)
    assert [unit for _, unit in columns] == ["m", "m", "m"]


def test_displacement_of_equally_near_points_is_their_mean() -> None:
    asked = [{"quantity": "displacement", "at": [1.0, 1.0], "component": "x"}]
    rows, _, _ = track(asked, moved())
    assert rows[-1][0] == pytest.approx(((GRADIENT - np.eye(2)) @ [1.0, 1.0])[0], rel=1e-12)


def test_nearest_is_decided_before_the_first_step() -> None:
    """The material point is followed, not the place."""
    asked = [{"quantity": "displacement", "at": [0.25, 0.25], "component": "x"}]
    rows, _, _ = track(asked, moved(), 2)
    half = (0.5 * (GRADIENT - np.eye(2)) @ [0.25, 0.25])[0]
    np.testing.assert_allclose([row[0] for row in rows], [0.0, half, 2 * half], rtol=1e-12)


def test_stress_components_and_invariants() -> None:
    names = ["xx", "yy", "zz", "xy", "mean", "von_mises"]
    asked = [{"quantity": "stress", "at": [2.0, 0.0], "component": c} for c in names]
    rows, simulation, columns = track(asked, moved())
    xx, yy, zz, xy, _, _ = simulation.state.points.stress[0]
    mean = (xx + yy + zz) / 3
    mises = np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * xy**2)
    np.testing.assert_allclose(rows[-1], [xx, yy, zz, xy, mean, mises], rtol=1e-9)
    assert min(abs(x) for x in rows[-1]) > 1.0
    assert columns[0][1] == "Pa"


def test_out_of_plane_components_in_3d() -> None:
    end = np.array([[1.0, 0.1, 0.3], [0.0, 1.1, -0.2], [0.0, 0.0, 0.9]])
    entries = block_entries("3d", "linear", boundaries=[affine(end)])
    asked = [{"quantity": "stress", "at": [0, 0, 0], "component": c} for c in ("yz", "xz")]
    asked.append({"quantity": "displacement", "at": [2.0, 2.0, 2.0], "component": "z"})
    rows, simulation, _ = track(asked, entries, 1)
    np.testing.assert_allclose(
        rows[-1], [*simulation.state.points.stress[0, 4:], -0.1 * 1.75], rtol=1e-9
    )
    assert rows[-1][0] < -1.0 < 1.0 < rows[-1][1]


def test_reaction_carries_the_weight() -> None:
    entries = block_entries(
        "plane_strain", "linear", boundaries=rollers("plane_strain"),
        loads=[weight("plane_strain", 10.0)],
    )  # fmt: skip
    asked = [
        {"quantity": "reaction", "boundary": "low y", "component": "y"},
        {"quantity": "reaction", "boundary": "low x", "component": "x"},
        {"quantity": "reaction", "boundary": "high x", "component": "x"},
        {"quantity": "reaction", "boundary": "low y", "component": "x"},
    ]
    rows, _, columns = track(asked, entries)
    assert [row[0] for row in rows] == pytest.approx([0.0, 20.0, 40.0, 60.0, 80.0], rel=1e-7)
    assert rows[-1][1] > 1.0  # the soil pushes outwards, the wall inwards
    assert rows[-1][1] == pytest.approx(-rows[-1][2], rel=1e-9)
    assert rows[-1][3] == 0.0
    assert columns[0][1] == "N/m"


def test_heights_and_run_out_of_points_and_domains() -> None:
    asked: list[dict[str, Any]] = [
        {"quantity": "top_height", "of": "points"},
        {"quantity": "top_height", "of": "domains"},
        {"quantity": "run_out", "axis": "x", "of": "points"},
        {"quantity": "run_out", "axis": "x", "of": "domains"},
        {"quantity": "run_out", "axis": "x", "of": "points", "share": 0.7},
        {"quantity": "run_out", "axis": "x", "of": "points", "share": 0.8},
    ]
    stretch = block_entries("plane_strain", "gimp", boundaries=[affine(np.diag([1.5, 0.5]))])
    rows, _, _ = track(asked, stretch)
    np.testing.assert_allclose(rows[0], [1.75, 2.0, 1.75, 2.0, 1.25, 1.75], rtol=1e-14)
    np.testing.assert_allclose(rows[-1], [0.875, 1.0, 2.625, 3.0, 1.875, 2.625], rtol=1e-12)


def test_body_restricts_the_points() -> None:
    entries = moved()
    other = dict(entries["bodies"][0], name="other")
    other["shape"] = {"type": "box", "lower": [4.0, 4.0], "upper": [5.0, 5.0]}
    entries["bodies"].append(other)
    asked = [
        {"quantity": "top_height", "of": "points", "body": name} for name in ("block", "other")
    ]
    asked += [
        {"quantity": "displacement", "at": [9.0, 9.0], "component": "x", "body": name}
        for name in ("block", "other")
    ]
    rows, _, _ = track(asked, entries)
    assert rows[0][:2] == [1.75, 4.75]
    ends = [((GRADIENT - np.eye(2)) @ [x, x])[0] for x in (1.75, 4.75)]
    np.testing.assert_allclose(rows[-1][2:], ends, rtol=1e-12)


def test_energies_balance_in_a_squeezed_plastic_block() -> None:
    entries = block_entries(
        "plane_strain", "linear", "von_mises",
        boundaries=[
            *rollers("plane_strain", sides=False),
            plane("top", "y", 2.0, condition="prescribed", displacement={"y": -0.4}),
        ],
    )  # fmt: skip
    asked = [
        {"quantity": "energy", "kind": kind}
        for kind in ("elastic", "external_work", "plastic_dissipation")
    ]
    rows, _, columns = track(asked, entries, 1)
    assert rows[0] == [0.0, 0.0, 0.0]
    elastic, work, dissipated = rows[-1]
    assert dissipated > elastic > 0.0
    assert work > 0.0
    assert columns[0][1] == "N m/m"


def test_elastic_energy_of_a_uniform_stretch() -> None:
    entries = block_entries("3d", "linear", boundaries=[affine(np.diag([np.e**0.1, 1.0, 1.0]))])
    rows, _, columns = track([{"quantity": "energy", "kind": "elastic"}], entries, 3)
    modulus = 1000.0 * 0.7 / (1.3 * 0.4)  # uniaxial strain: M = E (1 - nu) / ((1 + nu)(1 - 2 nu))
    assert rows[-1][0] == pytest.approx(0.5 * modulus * 0.1**2 * 8.0, rel=1e-12)
    assert columns[0][1] == "N m"


def test_scale_and_unit() -> None:
    asked = [
        {"quantity": "run_out", "axis": "x", "of": "points", "scale": 100.0, "unit": "cm"},
        {"quantity": "run_out", "axis": "x", "of": "points"},
    ]
    rows, _, columns = track(asked, moved())
    for scaled, plain in rows:
        assert scaled == 100.0 * plain
    assert [unit for _, unit in columns] == ["cm", "m"]
