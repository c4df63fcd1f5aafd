# SPDX-License-Identifier: BSD-3-Clause
"""Contact between bodies in checkpoints, in the next stage, and in runs that are resumed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from body_contacts import simulation_of, two_blocks
from resumed_runs import assert_same_results, restored, run_until

from tilth import Model, resume, run
from tilth.analysis.simulation import Simulation
from tilth.analysis.stage_change import next_stage, points_of_stages
from tilth.boundaries.contact.surface import NUMBERS


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric", "3d"])
def test_a_stopped_run_ends_in_the_same_bits(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entries = two_blocks(kind, "friction", steps=8)
    entries["analysis"]["tolerance"] = 1e-8
    track = [
        {"name": "N", "quantity": "reaction", "boundary": "pair", "component": "y"},
        {"name": "A", "quantity": "contact_area", "boundary": "pair"},
    ]
    model = Model.from_dict(entries | {"output": {"report": False}, "track": track})
    run(model, tmp_path / "whole", quiet=True)
    run_until(model, tmp_path / "stopped", 4, monkeypatch)
    resume(tmp_path / "stopped", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "stopped")


def test_states_are_restored() -> None:
    simulation = simulation_of(two_blocks("plane_strain", "friction"))
    for step in range(2):
        simulation.advance(0.25 * step, 0.25 * (step + 1))
    again = restored(simulation)
    (pair,), (other,) = simulation.state.body_contacts, again.state.body_contacts
    assert (pair.carried[:, -NUMBERS] == 1.0).any(), "there is contact"
    assert pair.touches_nearly is other.touches_nearly is False


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric", "3d"])
def test_the_next_stage_begins_with_what_the_surface_carries(kind: str) -> None:
    entries = two_blocks(kind, "friction")
    schedule = entries.pop("schedule")
    entries["stages"] = [{"name": name, "schedule": schedule} for name in ("one", "two")]
    models = Model.from_dict(entries).of_stages
    initial = points_of_stages(models)
    last = Simulation(models[0])
    (before,) = last.state.body_contacts
    place = before.quadrature().initial_position
    before.carried[:] = np.random.default_rng(1).normal(size=before.carried.shape)
    before.begin()
    (after,) = next_stage(last, models[1], initial[1]).state.body_contacts
    np.testing.assert_array_equal(after.quadrature().initial_position, place)
    np.testing.assert_array_equal(after.carried, before.carried)
    assert not after.touches_nearly
