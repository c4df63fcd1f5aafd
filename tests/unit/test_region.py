# SPDX-License-Identifier: BSD-3-Clause
"""Fields over the region of the soil: its area, its holes and gaps, the values in it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tracked_shapes import circle

from tilth.arrays import Floats
from tilth.report.continuous import ContinuousField
from tilth.report.domains import corners_of_boxes
from tilth.report.interpolation import values_at
from tilth.report.region import Region

SPACING = 0.1


def lattice(width: float, height: float, spacing: float = SPACING) -> Floats:
    x, y = (np.arange(0.5 * spacing, size, spacing) for size in (width, height))
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def region_of(place: Floats, half: float | Floats = 0.5 * SPACING, body: int = 0) -> Region:
    boxes = np.broadcast_to(half, place.shape)
    return Region.of(place, corners_of_boxes(boxes), np.full(len(place), body))


def colours(values: Floats) -> Floats:
    return np.repeat(values[:, None], 3, axis=1)


def drawn(region: Region, place: Floats, values: Floats) -> ContinuousField:
    return ContinuousField(region, place, values, colours)


def test_a_block_has_its_outline_and_its_area() -> None:
    region = region_of(lattice(2.0, 1.0))
    assert region.area == pytest.approx(2.0, rel=1e-12)
    (line,) = region.parts[0].outline()
    assert line.min(axis=0) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert line.max(axis=0) == pytest.approx([2.0, 1.0], rel=1e-12)
    np.testing.assert_array_equal(line[0], line[-1])


@pytest.mark.parametrize("seed", range(5))
def test_the_outline_is_closed_where_points_lie_on_a_line_to_round_off(seed: int) -> None:
    """Triangles of round-off on the edges, whose corners run either way, do not cut the outline."""
    place = lattice(2.0, 1.0) + np.random.default_rng(seed).normal(0.0, 1e-14, (200, 2))
    region = region_of(place[np.abs(place - [1.0, 0.5]).max(axis=1) > 0.22])
    lines = region.parts[0].outline()
    assert len(lines) == 2
    area = 0.0  # the hole runs clockwise
    for line in lines:
        np.testing.assert_array_equal(line[0], line[-1])
        x, y = line.T
        area += 0.5 * float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum())
    assert area == pytest.approx(region.area, rel=1e-9)


@pytest.mark.parametrize("slope", [1.0, 0.5, 1.0 / 3.0, 3.0])
def test_a_slope_of_boxes_is_straight(slope: float) -> None:
    spacing = 0.05
    place = lattice(8.0, 3.0, spacing)
    place = place[place[:, 1] < 3.0 - slope * (place[:, 0] - 1.0) + 1e-9]
    region = region_of(place, 0.5 * spacing)
    assert region.area == pytest.approx(spacing**2 * len(place), rel=0.02)
    (line,) = region.parts[0].outline()
    edge = np.diff(line, axis=0)
    # Steps would go along and across; of them at the slope hardly any are left.
    middle = 0.5 * (line[1:] + line[:-1])
    away = np.abs(middle[:, 1] - (3.0 - slope * (middle[:, 0] - 1.0))) < 2.0 * spacing
    inner = away & (middle > 0.4).all(axis=1) & (middle[:, 1] < 2.6) & (middle[:, 0] < 7.6)
    angle = np.arctan2(-edge[inner, 1], edge[inner, 0]) % np.pi
    length = np.linalg.norm(edge[inner], axis=1)
    along = np.abs(angle - np.arctan(slope)) < 0.35
    assert length[along].sum() > 0.97 * length.sum()


def test_holes_and_gaps_stay_and_cracks_close() -> None:
    place = lattice(3.0, 2.0)
    radius = np.hypot(*(place - [1.5, 1.0]).T)
    ring = place[radius > 0.4]
    region = region_of(ring)
    assert len(region.parts[0].outline()) == 2
    assert region.area == pytest.approx(SPACING**2 * len(ring), rel=0.02)
    outside = region.values_in(ring, np.ones(len(ring)), np.array([[1.5, 1.0], [0.2, 0.3]]))
    np.testing.assert_array_equal(outside, [np.nan, 1.0])
    parted = place + np.array([0.06, 0.0]) * (place[:, :1] > 1.5)  # a crack of 0.6 spacings
    assert len(region_of(parted).parts[0].outline()) == 1
    assert region_of(parted).area == pytest.approx(3.06 * 2.0, rel=1e-9)
    broken = place + np.array([0.3, 0.0]) * (place[:, :1] > 1.5)
    assert len(region_of(broken).parts[0].outline()) == 2
    assert region_of(broken).area == pytest.approx(6.0, rel=1e-9)


def test_bodies_that_nearly_touch_are_not_joined() -> None:
    block = lattice(1.0, 1.0)
    place = np.concatenate([block, block + np.array([1.02, 0.0])])
    body = np.repeat([3, 7], len(block))
    region = Region.of(place, corners_of_boxes(np.full_like(place, 0.05)), body)
    assert len(region.parts) == 2
    assert region.area == pytest.approx(2.0, rel=1e-12)
    found = region.values_in(place, body.astype(float), np.array([[0.99, 0.5], [1.01, 0.5]]))
    np.testing.assert_array_equal(found, [3.0, np.nan])


@pytest.mark.parametrize("seed", [1, 2])
def test_strongly_deformed_soil_has_its_area_and_no_pixel_without_a_value(seed: int) -> None:
    place = lattice(4.0, 2.0)
    shear, stretch = 0.4 * seed, 1.6
    map_ = np.array([[stretch, shear], [0.0, 1.0 / stretch]])
    place = place @ map_.T
    corners = corners_of_boxes(np.full_like(place, 0.5 * SPACING)) @ map_.T
    region = Region.of(place, corners, np.zeros(len(place), dtype=np.int64))
    assert region.area == pytest.approx(8.0, rel=0.02)
    field = drawn(region, place, np.ones(len(place)))
    values, there = field.values_image(*bounds(region), 500, 250)
    assert np.isfinite(values[there]).all()
    from scipy.ndimage import binary_fill_holes

    np.testing.assert_array_equal(binary_fill_holes(there), there)


def bounds(region: Region) -> tuple[Floats, Floats]:
    vertex = np.concatenate([part.vertex for part in region.parts])
    return vertex.min(axis=0), vertex.max(axis=0)


def test_a_linear_field_is_reproduced_up_to_the_outline() -> None:
    random = np.random.default_rng(3)
    place = lattice(2.0, 1.0) + random.uniform(-0.02, 0.02, (200, 2))
    region = region_of(place)

    def linear(at: Floats) -> Floats:
        return np.asarray(3.0 + at @ [2.0, -5.0])

    part = region.parts[0]
    found = part.values(place, linear(place))
    np.testing.assert_allclose(found, linear(part.vertex), rtol=0.0, atol=1e-7)
    low, high = bounds(region)
    values, there = drawn(region, place, linear(place)).values_image(low, high, 800, 400)
    assert there.mean() > 0.97
    row, column = np.nonzero(there)
    size = (high - low) / [800, 400]
    at = np.stack([low[0] + size[0] * (column + 0.5), high[1] - size[1] * (row + 0.5)], axis=1)
    span = float(np.ptp(linear(place)))
    # Pixels at the outline may be outside of it by 0.4 pixel.
    assert np.abs(values[there] - linear(at)).max() < 1.5e-3 * span


def test_values_in_space_are_those_of_a_linear_field() -> None:
    random = np.random.default_rng(1)
    place = random.uniform(0.0, 1.0, (500, 3))
    inside = random.uniform(0.2, 0.8, (40, 3))
    found = values_at(place, place @ [1.0, 2.0, -3.0], inside)
    np.testing.assert_allclose(found, inside @ [1.0, 2.0, -3.0], atol=1e-7)


def test_soil_without_a_value_has_none() -> None:
    place = lattice(2.0, 1.0)
    values = np.where(place[:, 0] < 1.0, 1.0, np.nan)
    at = np.array([[0.4, 0.5], [1.6, 0.5]])
    found = region_of(place).values_in(place, values, at)
    np.testing.assert_array_equal(found, [1.0, np.nan])
    np.testing.assert_array_equal(values_at(place, values, at), [1.0, np.nan])


def test_a_tracked_surface_is_the_outline() -> None:
    place = lattice(4.0, 4.0) - 2.0
    hole = circle("hole", 60)
    hole = replace(hole, cells=hole.cells[::-1, ::-1])  # the soil outside
    radius = float(np.hypot(*hole.position.T).max())
    place = place[np.hypot(*place.T) > radius]
    corners = corners_of_boxes(np.full_like(place, 0.05))
    region = Region.of(place, corners, np.zeros(len(place), dtype=np.int64), [hole])
    polygon = 0.5 * abs(
        np.sum(
            hole.position[:, 0] * np.roll(hole.position[:, 1], -1)
            - hole.position[:, 1] * np.roll(hole.position[:, 0], -1)
        )
    )
    assert region.area == pytest.approx(16.0 - polygon, rel=2e-3)
    inner = min(region.parts[0].outline(), key=lambda line: float(np.abs(line).max()))
    assert np.hypot(*inner.T) == pytest.approx(radius, abs=0.01)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_few_points_have_the_region_of_their_domains(count: int) -> None:
    place = lattice(0.1 * count, 0.1)
    assert region_of(place).area == pytest.approx(0.01 * count, rel=1e-9)


def test_units_do_not_matter() -> None:
    place = lattice(2.0, 1.0)
    for unit in (1e-9, 1e9):
        region = region_of(unit * place, unit * 0.05)
        assert region.area == pytest.approx(2.0 * unit**2, rel=1e-9)
