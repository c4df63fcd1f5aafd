# SPDX-License-Identifier: BSD-3-Clause
"""Newton's iteration with contact: quadratic where no multiplier changes its branch any more."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from contact_terms import DRIVEN, FREE, YOUNG, pressed, states
from small_problems import KINDS, dimension

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries.contact.forces import AssembledContact

CONSTANT = {2: 30.0, 3: 300.0}
"""By dimension: in the plane as in the other tests of quadratic convergence. In space the shear
traction turns with the slip, the faster the smaller the slip is."""

ROUND_OFF = 3e-10
"""Relative residual that round-off leaves: contact is a thousand times as stiff as the soil."""


def soft(kind: str, law: str, way: str) -> Simulation:
    """Elastic soil that is compressed by a tenth and more, so that its tangent changes."""
    entries = pressed(kind, law, way).setup.model.to_dict()
    entries["materials"]["soil"] = {
        "model": "hencky_elastic", "young_modulus": 0.1 * YOUNG, "poisson_ratio": 0.3,
        "density": 1.0,
    }  # fmt: skip
    entries["analysis"] |= {"tolerance": 1e-12, "predictor": False}
    return Simulation(Model.from_dict(entries))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", ["smooth", "friction", "adhesion", "held friction", "glued"])
@pytest.mark.parametrize("way", [FREE, DRIVEN])
def test_quadratic_with_the_active_set_fixed(
    kind: str, law: str, way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulation = soft(kind, law, way)
    seen: list[tuple[float, Any]] = []
    last = [np.inf]
    add = AssembledContact.add_stiffness

    def watched(self: AssembledContact, displacement: Floats, blocks: Floats) -> None:
        fixed = [
            np.concatenate([each.active, each.added.ravel(), each.first_gap])
            for each in self._patches
        ]
        seen.append((last[0], (states(self), np.concatenate(fixed).tolist())))
        add(self, displacement, blocks)

    def note(iteration: int, relative: float) -> None:
        last[0] = relative

    monkeypatch.setattr(AssembledContact, "add_stiffness", watched)
    pairs = []
    # a larger step of this one has no equilibrium that the iteration finds
    size = 0.025 if (way, law, kind) == (FREE, "adhesion", "3d") else 0.05
    for step in range(8):
        seen.clear()
        simulation.advance(size * step, size * (step + 1), note)
        seen.append((last[0], seen[-1][1]))
        for (before, branches), (after, others) in pairwise(seen):
            if branches == others and before < 2e-3:
                pairs.append((before, after))
    assert len([before for before, _ in pairs if before > 1e-8]) >= 2, "there is something to see"
    for before, after in pairs:
        assert after <= max(CONSTANT[dimension(kind)] * before**2, ROUND_OFF), (before, after)
