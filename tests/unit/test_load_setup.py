# SPDX-License-Identifier: BSD-3-Clause
"""What `tilth check` says and draws of loads before the first step."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from rich.console import Console
from small_problems import block_entries

from tilth import Model
from tilth.analysis.memory import memory_of
from tilth.analysis.setup_picture import setup_of
from tilth.report.setup import draw_setup
from tilth.report.summary import print_summary

LOADS: list[dict[str, Any]] = [
    {"type": "body_force", "name": "gravity", "acceleration": [0.0, 0.0, -10.0]},
    {"type": "seismic", "coefficient": [0.3, 0.0, 0.4]},
    {"type": "point_force", "name": "pile", "body": "block", "at": [0.6, 0.7, 2.0],
     "force": [0.0, 2.0, -5.0]},
    {"type": "line_force", "body": "block", "start": [0.0, 0.3, 2.0], "end": [2.0, 0.3, 2.0],
     "force": [0.0, 0.0, -4.0], "factor": [[0.0, 0.0], [1.0, 0.5]]},
    {"type": "surface", "name": "tank", "body": "block", "pressure": 3.0,
     "within": {"centre": [1.0, 1.2], "radius": 0.6}},
    {"type": "surface", "body": "block", "pressure": 1.0,
     "within": {"lower": [0.0, 1.5], "upper": [2.0, 2.0]}},
    {"type": "surface", "body": "block", "pressure": 1.0,
     "within": {"vertices": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]}},
]  # fmt: skip


@pytest.fixture(scope="module")
def model() -> Model:
    entries = block_entries("3d", "linear", loads=LOADS)
    entries["bodies"][0]["surface"] = {}
    return Model.from_dict(entries)


def test_arrows_are_where_and_as_large_as_the_loads(model: Model) -> None:
    setup = setup_of(model)
    total = {load.name: load.force.sum(axis=0) for load in setup.loads}
    np.testing.assert_allclose(total["pile"], [0.0, 2.0, -5.0], rtol=1e-13)
    np.testing.assert_allclose(total["line force on block"], [0.0, 0.0, -0.5 * 4.0 * 2.0])
    np.testing.assert_allclose(total["tank"], [0.0, 0.0, -3.0 * np.pi * 0.36], atol=1e-12)
    pile, line = setup.loads[:2]
    np.testing.assert_allclose(pile.position, [[0.6, 0.7, 2.0]])
    assert len(line.position) > 4
    assert np.ptp(line.position[:, 0]) > 1.5
    np.testing.assert_allclose(line.position[:, 1:], np.tile([0.3, 2.0], (len(line.position), 1)))
    np.testing.assert_allclose(setup.body_force, [3.0, 0.0, -6.0])
    texts = [text.get_text() for text in draw_setup(setup).legends[0].get_texts()]
    assert any(text.startswith("pile") for text in texts)


def test_summary_lists_the_loads(model: Model) -> None:
    written = io.StringIO()
    setup = setup_of(model)
    estimate = memory_of(model)
    print_summary(model, setup, estimate, None, Console(file=written, width=200))
    for words in (
        "gravity: body force",
        "seismic, coefficients [0.3, 0, 0.4] of the body force",
        "pile: point force [0, 2, -5]",
        "line force [0, 0, -4] N/m on block from [0, 0.3, 2] to [2, 0.3, 2], factor 0.5",
        "tank: pressure 3 Pa on the surface of block within the circle of radius 0.6 around",
        "within the rectangle from [0, 1.5] to [2, 2]",
        "within a polygon of 3 vertices",
    ):
        assert words in written.getvalue()
