# SPDX-License-Identifier: BSD-3-Clause
"""Pictures have no gap between bodies that stick together, and keep that between others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilth.arrays import Floats
from tilth.output import read_results
from tilth.output.snapshot import Snapshot
from tilth.output.vtkhdf import ResultsWriter
from tilth.report.bridges import bridges_of, region_of, sticking
from tilth.report.continuous import ContinuousField
from tilth.report.domains import corners_of, corners_of_boxes

SPACING, HALF = 0.25, 0.1
"""Of points that have moved apart, and half lengths of their domains, which did not follow."""


def blocks(body_fields: tuple[int, ...] = ()) -> Snapshot:
    """Two blocks, 2 wide and high, side by side: gaps of 0.05 within and between them."""
    side = np.arange(8) * SPACING + 0.5 * SPACING
    position = np.stack(np.meshgrid(np.arange(16) * SPACING + 0.5 * SPACING, side), -1)
    position = position.reshape(-1, 2)
    body = (position[:, 0] > 2.0).astype(np.int64)
    return Snapshot(
        step=0, time=0.0, position=position, point_id=np.arange(len(position)), body_id=body,
        point_fields={
            "domain": np.full((len(position), 2), HALF), "volume": np.full(len(position), 0.04),
            "displacement": np.column_stack([np.where(body, 2.0, 1.0), position[:, 1]]),
        },
        node_position=np.zeros((4, 2)), cells=np.arange(4)[None], body_fields=body_fields,
    )  # fmt: skip


def pixels_without_soil(snapshot: Snapshot) -> Floats:
    """Places of pixels that are not soil, in the middle of the two blocks, shape (n, 2)."""
    region = region_of(snapshot, corners_of(snapshot))
    drawn = ContinuousField(
        region, snapshot.position, np.ones(len(snapshot.position)), lambda v: np.zeros((len(v), 3))
    )
    low, high = np.array([0.2, 0.2]), np.array([3.8, 1.8])
    _, there = drawn.values_image(low, high, 720, 320)
    row, column = np.nonzero(~there)
    return low + (np.stack([column, 320 - row], axis=1) + 0.5) / 200.0


def test_bodies_of_one_field_have_no_gap() -> None:
    assert len(pixels_without_soil(blocks())) == 0
    apart = pixels_without_soil(blocks((0, 1)))
    assert len(apart) > 320 * 5  # 0.05 wide
    assert (np.abs(apart[:, 0] - 2.0) < 0.03).all()


def test_what_is_between_bodies_is_narrow_and_has_no_outline() -> None:
    """It ends where its neighbours do; lines are drawn around the bodies alone."""
    snapshot = blocks()
    region = region_of(snapshot, corners_of(snapshot))
    assert len(region.bridges) == 2
    corner = np.concatenate([part.vertex[part.triangle].reshape(-1, 2) for part in region.bridges])
    assert (np.abs(corner[:, 0] - 2.0) < 0.4).all()
    assert corner[:, 1].min() == pytest.approx(0.5 * SPACING - HALF, abs=1e-9)
    assert corner[:, 1].max() == pytest.approx(2.0 - 0.5 * SPACING + HALF, abs=1e-9)
    drawn = ContinuousField(region, snapshot.position, snapshot.position[:, 0], lambda v: v)
    assert len(drawn.lines()) == 2


def test_values_along_a_line_go_on_across_the_gap() -> None:
    snapshot = blocks()
    places = np.column_stack([np.linspace(0.2, 3.8, 200), np.full(200, 1.0)])
    whole = region_of(snapshot, corners_of(snapshot)).values_in(
        snapshot.position, snapshot.position[:, 0], places
    )
    np.testing.assert_allclose(whole, places[:, 0], atol=1e-6)
    apart = region_of(blocks((0, 1)), corners_of(snapshot)).values_in(
        snapshot.position, snapshot.position[:, 0], places
    )
    assert np.isnan(apart).any()


def test_a_jump_between_bodies_stays_one() -> None:
    """Each body has its own values up to the middle between them: there is no third one."""
    snapshot = blocks()
    jump = snapshot.point_fields["displacement"][:, 0]
    x = np.setdiff1d(np.linspace(1.5, 2.5, 101), [2.0])
    places = np.column_stack([x, np.full(len(x), 1.07)])
    found = region_of(snapshot, corners_of(snapshot)).values_in(snapshot.position, jump, places)
    np.testing.assert_allclose(found, np.where(x > 2.0, 2.0, 1.0), atol=1e-6)


def test_bodies_far_apart_and_single_ones_have_nothing_between() -> None:
    snapshot = blocks()
    position = snapshot.position + np.where(snapshot.body_id[:, None] == 1, [3.0, 0.0], 0.0)
    corners = corners_of_boxes(snapshot.point_fields["domain"])
    assert bridges_of(position, corners, snapshot.body_id, {0: 0, 1: 0}) == []
    one = np.zeros(len(position), dtype=np.int64)
    assert bridges_of(position, corners, one, {0: 0}) == []


@pytest.mark.parametrize("fields", [(), (0, 1), (0, 1, 0)])
def test_the_results_know_which_bodies_stick(fields: Any, tmp_path: Path) -> None:
    writer = ResultsWriter(tmp_path / "results.vtkhdf", units={"length": "m"})
    snapshot = blocks(fields)
    writer.append(snapshot)
    found = read_results(tmp_path / "results.vtkhdf").snapshot(0)
    assert found.body_fields == fields
    assert sticking(found) == sticking(snapshot)
    again = ResultsWriter.resume(tmp_path / "results.vtkhdf", 0)
    again.append(Snapshot(**{**vars(snapshot), "step": 1, "time": 1.0}))
    assert read_results(tmp_path / "results.vtkhdf").snapshot(1).body_fields == fields
