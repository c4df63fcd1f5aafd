# SPDX-License-Identifier: BSD-3-Clause
"""Colours of fields and images of polygons."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import colormaps
from scipy.spatial import ConvexHull

from tilth.report.colour_scale import ColourScale
from tilth.report.raster import draw_polygons


@pytest.mark.parametrize(("low", "high", "name"), [(0.0, 2.0, "viridis"), (-2.0, 1.0, "coolwarm")])
def test_colours_are_those_of_matplotlib(low: float, high: float, name: str) -> None:
    values = np.append(np.linspace(low, high, 101), np.nan)
    scale = ColourScale.of([values])
    assert scale.name == name
    found, expected = scale.colours(values), scale.matplotlib().to_rgba(values)[:, :3]
    np.testing.assert_allclose(found, expected, atol=5.0 / 255.0)
    assert found[-1].tolist() == [0.75] * 3
    exact = colormaps[name]((values[:-1] - scale.low) / (scale.high - scale.low))
    np.testing.assert_allclose(expected[:-1], exact[:, :3])


def test_pixels_in_polygons_have_their_number() -> None:
    """Small and large convex quadrilaterals of both directions, also across the edge."""
    random = np.random.default_rng(2)
    corner = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    area = np.stack(
        [
            random.uniform(-5.0, 105.0, 2) + corner[:: random.choice([-1, 1])] * size
            @ (np.eye(2) + random.uniform(-0.3, 0.3, (2, 2)))
            for size in [50.0, *random.uniform(0.5, 12.0, 60)]
        ]
    )  # fmt: skip
    number = draw_polygons(area, 100, 80)
    y, x = np.mgrid[:80, :100] + 0.5
    centres = np.stack([x.ravel(), y.ravel()], axis=1)
    wide, narrow = np.full(8000, -1), np.full(8000, -1)
    for each in range(len(area)):
        equations = ConvexHull(area[each]).equations
        beyond = (centres @ equations[:, :2].T + equations[:, 2]).max(axis=1)
        for found, room in ((wide, 0.6), (narrow, 0.2)):
            found[beyond <= room] = each
    inner = narrow == wide
    assert inner.mean() > 0.9
    np.testing.assert_array_equal(number.ravel()[inner], wide[inner])


def test_neighbours_leave_no_seam_and_nothing_is_drawn_beside_them() -> None:
    low = np.stack(np.meshgrid(np.arange(30.0), np.arange(20.0)), axis=-1).reshape(-1, 2)
    area = 10.3 + 2.37 * (low[:, None, :] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]]))
    number = draw_polygons(area, 120, 90)
    rows, columns = np.nonzero(number >= 0)
    assert len(rows) == (np.ptp(rows) + 1) * (np.ptp(columns) + 1)
    for place, count in ((columns, 30), (rows, 20)):
        assert place.min() + 0.0 >= 10.3 - 0.91
        assert place.max() + 1.0 <= 10.3 + 2.37 * count + 0.91
    assert draw_polygons(area + 500.0, 120, 90).max() == -1
