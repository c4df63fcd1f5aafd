# SPDX-License-Identifier: BSD-3-Clause
"""An analysis with stages whose first one begins with stressed ground."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, run_in_pieces
from staged_problems import KINDS, staged_entries

from tilth import Model, run
from tilth.mpm.initial_points import initial_points


def stressed(kind: str = "plane_strain") -> dict[str, Any]:
    """Ground with a pit to be dug; its weight is 10 per volume."""
    entries = staged_entries(kind)
    entries["loads"][0]["factor"] = [[0.0, 1.0], [1.0, 1.0]]
    entries["initial"] = {
        "stress": [
            {"type": "k0", "body": name, "K0": 0.8} for name in ("ground", "pit", "bank")
        ]
    }  # fmt: skip
    return entries


@pytest.mark.parametrize("kind", KINDS)
def test_soil_that_is_placed_later_has_no_weight(kind: str) -> None:
    """The fill will lie where the pit is dug; only the pit's soil weighs on the ground at first."""
    model = Model.from_dict(stressed(kind)).of_stages[0]
    points = initial_points(model)
    up = model.dimension - 1
    expected = np.where(points.body_id == 3, 0.0, -10.0 * (2.0 - points.position[:, up]))
    np.testing.assert_allclose(points.stress[:, up], expected, rtol=1e-13)


def test_a_staged_run_begins_in_equilibrium(tmp_path: Path) -> None:
    result = run(Model.from_dict(stressed()), tmp_path / "out", quiet=True)
    base = result.history["base [N/m]"]
    assert base[0] == pytest.approx(10.0 * 3.0 * 2.0, rel=1e-9)
    assert base[1] == pytest.approx(base[0], rel=1e-8)
    log = (tmp_path / "out" / "log.txt").read_text()
    assert log.count("at the start: ") == 1


@pytest.mark.slow
def test_a_staged_run_from_an_equilibrium_is_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = Model.from_dict(stressed())
    run(model, tmp_path / "whole", quiet=True)
    run_in_pieces(model, tmp_path / "part", [1, 2, 3], monkeypatch)
    assert_same_results(tmp_path / "whole", tmp_path / "part")
