# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies and contact surfaces in checkpoints, and runs that are stopped and resumed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from contact_terms import DRIVEN, FREE, pressed
from resumed_runs import assert_same_results, restored, run_until

from tilth import Model, resume, run
from tilth.analysis.simulation import Simulation
from tilth.boundaries.contact.surface import NUMBERS

every_way = pytest.mark.parametrize("way", [FREE, DRIVEN])


def model_of(kind: str, law: str, way: str) -> Model:
    entries = pressed(kind, law, way, steps=8).setup.model.to_dict()
    entries["analysis"]["tolerance"] = 1e-8
    entries["output"] = {"report": False}
    entries["track"] = [{"name": "F", "quantity": "reaction", "boundary": "body", "component": "y"}]
    return Model.from_dict(entries)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric", "3d"])
@every_way
def test_a_stopped_run_ends_in_the_same_bits(
    kind: str, way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = model_of(kind, "friction", way)
    run(model, tmp_path / "whole", quiet=True)
    run_until(model, tmp_path / "stopped", 4, monkeypatch)
    resume(tmp_path / "stopped", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "stopped")


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@every_way
def test_states_are_restored(kind: str, way: str) -> None:
    """Place, motion and forces of the body; tractions and contact of its surfaces."""
    simulation = Simulation(model_of(kind, "friction", way))
    for step in range(2):
        simulation.advance(0.125 * step, 0.125 * (step + 1))
    again = restored(simulation)
    (body,), (other,) = simulation.state.bodies, again.state.bodies
    assert body.displacement.any()
    assert body.force.any()
    for time in (0.25, 0.3):
        for one, two in zip(body.place(time), other.place(time), strict=True):
            np.testing.assert_array_equal(one, two)
    surfaces = [each.state.contact_surfaces for each in (simulation, again)]
    assert any((each.carried[:, -NUMBERS] == 1.0).any() for each in surfaces[0]), "there is contact"
    for one, two in zip(*surfaces, strict=True):
        np.testing.assert_array_equal(one.carried, two.carried)


def test_states_of_another_body_are_refused() -> None:
    plane, space = (Simulation(model_of(kind, "smooth", FREE)) for kind in ("plane_strain", "3d"))
    with pytest.raises(ValueError, match="another shape"):
        plane.state.bodies[0].restore(space.state.bodies[0].state())
