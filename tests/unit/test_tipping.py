# SPDX-License-Identifier: BSD-3-Clause
"""A block on a rigid plane tips when the resultant on it leaves its base."""

from __future__ import annotations

import numpy as np
import pytest
from standing_blocks import GRAVITY, SLENDERNESS, standing_block

from tilth import Model, TilthError
from tilth.analysis.march import march


def block(cells: int, basis: str, turn: float, share: float) -> Model:
    """A stiff block of so many cells; its weight acts first, then a share of it along the base."""
    stands = standing_block(1e9, basis, turn=turn, width=1.0, cell=1.0 / cells)
    entries = stands.to_dict()
    del entries["bodies"][0]["surface"]
    along = np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
    pushes = {"type": "body_force", "acceleration": (share * GRAVITY * along).tolist()}
    entries["loads"][0]["factor"] = [[0, 0], [1, 1]]
    entries["loads"].append(pushes | {"factor": [[0, 0], [1, 0], [2, 1]]})
    entries["schedule"] = {"end": 2.0, "steps": 16, "minimum_step": 1e-2}
    return Model.from_dict(entries)


@pytest.mark.parametrize(("cells", "within"), [(2, 0.05), (4, 0.02)])
@pytest.mark.parametrize(("basis", "turn"), [("gimp", 0.0), ("cpdi2", 20.0)])
def test_a_block_tips_about_its_edge(basis: str, turn: float, cells: int, within: float) -> None:
    """Without patches of their own at the ends of its base at 0.71 and 0.81 of the exact share."""
    march(block(cells, basis, turn, (1.0 - within) / SLENDERNESS), lambda *_: None)
    with pytest.raises(TilthError):
        march(block(cells, basis, turn, (1.0 + within) / SLENDERNESS), lambda *_: None)
