# SPDX-License-Identifier: BSD-3-Clause
"""Strength reductions of soil with a rigid body on it: trials keep the body's motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tilth import Model, StrengthReduction
from tilth.analysis.march import march
from tilth.analysis.safety import SafetyResult, strength_reduction
from tilth.analysis.safety_trials import Trials
from tilth.analysis.simulation import Simulation

STRENGTH, FORCE = 10.0, 25.0
EXACT = (2.0 + math.pi) * STRENGTH / FORCE
"""Of half a footing of width 2 on weightless clay."""


def footing() -> Model:
    """A rigid footing with friction under a force, free to settle; at its middle a smooth wall."""
    entries: dict[str, Any] = {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 0.5},
        "materials": {
            "soil": {
                "model": "tresca", "young_modulus": 1e4, "poisson_ratio": 0.3, "density": 1.0,
                "undrained_shear_strength": STRENGTH,
            },
        },
        "bodies": [
            {
                "name": "ground", "material": "soil", "basis": "gimp", "points_per_cell": 2,
                "anti_locking": "f_bar",
                "shape": {"type": "box", "lower": [0.0, 0.0], "upper": [6.0, 3.0]},
            },
        ],
        "boundaries": [
            {"name": name, "type": "plane", "axis": axis, "at": at, "condition": condition}
            for name, axis, at, condition in (
                ("left", "x", 0.0, "roller"), ("right", "x", 6.0, "roller"),
                ("base", "y", 0.0, "fixed"),
            )
        ],
        "rigid_bodies": [
            {
                "name": "footing", "centre": [0.0, 3.5], "displacement": {"x": 0.0},
                "rotation": 0.0, "force": {"y": -FORCE},
                "geometry": {
                    "type": "box", "lower": [-2.0, 3.0], "upper": [1.0, 4.0], "soil": "outside",
                },
                "contact": {"normal": "unilateral", "tangential": "friction", "friction": 0.5},
            },
        ],
        "loads": [{"type": "body_force", "acceleration": [0.0, -1.0]}],
        "schedule": {"steps": 4},
    }  # fmt: skip
    return Model.from_dict(entries)


@pytest.fixture(scope="module")
def loaded() -> Simulation:
    return march(footing())


@pytest.fixture(scope="module")
def result(loaded: Simulation) -> SafetyResult:
    return strength_reduction(loaded, 1.0, StrengthReduction(tolerance=0.02))


def test_a_rigid_footing_on_clay(result: SafetyResult) -> None:
    """Two cells under half a footing are too strong by some percent."""
    assert result.is_decided
    assert pytest.approx(EXACT, rel=0.1) == result.factor
    assert result.factor > EXACT
    assert result.displacement[:, 1].min() < -0.5 * np.abs(result.displacement).max()


def test_the_state_of_the_run_is_found_again(result: SafetyResult) -> None:
    first = result.trials[0]
    assert (first.factor, first.in_equilibrium, first.crept) == (1.0, True, False)
    assert first.displacement < 0.3 * result.elastic_displacement


def test_a_trial_begins_where_the_body_is_in_the_last_one(loaded: Simulation) -> None:
    """With the body left behind, the first residual is many times the forces."""
    first = []

    def note(iteration: int, residual: float) -> None:
        if iteration == 0:
            first.append(residual)

    trials = Trials(loaded, 1.0, StrengthReduction(), note)
    found = [trials.at(factor, pursues=False) for factor in (1.0, 1.8, 1.8)]
    assert all(each.in_equilibrium for each in found)
    assert found[2].displacement == pytest.approx(found[1].displacement, rel=1e-3)
    assert max(first[1:]) < 1.0
    assert trials._last is not None
    trials._last.x.globals[:] = 0.0
    trials.at(1.8, pursues=False)
    assert first[-1] > 10.0 * first[-2]


def test_the_state_does_not_change(loaded: Simulation, result: SafetyResult) -> None:
    """Nor do the forces of the ghost stabilisation, which trials keep."""
    before = {name: each.copy() for name, each in loaded.state.arrays().items()}
    strength_reduction(loaded, 1.0, StrengthReduction(tolerance=0.5))
    after = loaded.state.arrays()
    for name, each in before.items():
        np.testing.assert_array_equal(after[name], each, err_msg=name)


def test_an_interrupt_leaves_the_state_as_it_was(loaded: Simulation) -> None:
    before = {name: each.copy() for name, each in loaded.state.arrays().items()}

    def interrupt(iteration: int, residual: float) -> None:
        if iteration == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        strength_reduction(loaded, 1.0, on_iteration=interrupt)
    for name, each in loaded.state.arrays().items():
        np.testing.assert_array_equal(each, before[name], err_msg=name)
