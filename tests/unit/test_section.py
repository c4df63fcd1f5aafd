# SPDX-License-Identifier: BSD-3-Clause
"""Sections of runs in space: areas in closed form, linear fields, bodies beside each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from report_setups import lattice, snapshot

from tilth.bodies.corners import corner_signs
from tilth.errors import BadInput
from tilth.output import Snapshot
from tilth.plot.plane import Plane, cut_triangles
from tilth.plot.section import Section

ROTATION = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]


def state(position: np.ndarray, half: np.ndarray, body_id: np.ndarray | None = None) -> Snapshot:
    """Points with boxes, in a turned system of axes."""
    n = len(position)
    corners = np.tile(corner_signs(3) * half, (n, 1, 1)) @ ROTATION.T
    return replace(
        snapshot(3, 0),
        position=position @ ROTATION.T,
        point_id=np.arange(n),
        body_id=np.zeros(n, dtype=np.int64) if body_id is None else body_id,
        point_fields={"domain_corners": corners},
    )


def plane_at(point: np.ndarray, normal: np.ndarray) -> Plane:
    """The plane of a point and a normal in the turned system."""
    ends = (ROTATION @ np.asarray(each, dtype=float) for each in (point, normal))
    return Plane.of(":".join(",".join(repr(float(x)) for x in end) for end in ends))


def area_of(polygon: np.ndarray) -> float:
    x, y = np.moveaxis(polygon, -1, 0)
    twice = x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y
    return float(0.5 * np.abs(twice.sum(axis=1)).sum())


def test_sections_of_a_turned_cube_have_the_areas_of_square_and_hexagon() -> None:
    cube = state(lattice((8, 8, 8), 0.125), np.full(3, 0.0625))
    for normal, point, area in (
        ((1, 0, 0), (0.31, 0.0, 0.0), 1.0),
        ((1, 0, 0), (0.0, 0.0, 0.0), 1.0),  # its end
        ((1, 0, 0), (0.5, 0.0, 0.0), 1.0),  # where two layers meet
        ((1, 1, 0), (0.5, 0.5, 0.5), np.sqrt(2.0)),
        ((1, 1, 1), (0.5, 0.5, 0.5), 0.75 * np.sqrt(3.0)),
    ):
        section = Section.of(plane_at(np.array(point), np.array(normal)), cube)
        assert area_of(section.polygon) == pytest.approx(area, rel=1e-9)
        assert section.region.area == pytest.approx(area, rel=4e-3)


def test_sections_of_a_sphere_have_the_areas_of_circles() -> None:
    spacing = 0.1
    position = lattice((20, 20, 20), spacing) - 1.0
    ball = state(position[np.linalg.norm(position, axis=1) < 1.0], np.full(3, 0.5 * spacing))
    for height in (0.0, 0.33):
        for normal in ((0, 0, 1), (1, 2, 3)):
            axis = np.array(normal) / np.linalg.norm(normal)
            section = Section.of(plane_at(height * axis, axis), ball)
            circle = np.pi * (1.0 - height**2)
            # The boxes of ten points along the radius; the region closes their steps.
            assert area_of(section.polygon) == pytest.approx(circle, rel=0.02)
            assert area_of(section.polygon) < section.region.area < 1.08 * circle


def test_a_linear_field_is_reproduced_on_the_plane_and_each_body_keeps_its_values() -> None:
    position = lattice((6, 6, 6), 0.2)
    left = position[:, 0] < 0.6
    two = state(position, np.full(3, 0.1), left.astype(np.int64))
    plane = plane_at(np.array([0.6, 0.6, 0.6]), np.array([0.3, -0.2, 1.0]))
    section = Section.of(plane, two)
    across = np.linspace(-0.5, 0.5, 41)
    flat = np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 2)
    slope = np.array([1.0, -2.0, 3.0])
    found = section.values_in(two, two.position @ slope, flat)
    assert np.isfinite(found).mean() > 0.9
    known = np.isfinite(found)
    np.testing.assert_allclose(found[known], (plane.space(flat) @ slope)[known], atol=1e-6)

    constant = section.values_in(two, np.where(left, 1.0, 5.0), flat)
    inside = plane.space(flat) @ ROTATION  # in the axes of the block
    assert np.unique(np.round(constant[known], 9)).tolist() == [1.0, 5.0]
    near = np.abs(inside[:, 0] - 0.6) > 1e-6
    expected = np.where(inside[:, 0] < 0.6, 1.0, 5.0)
    np.testing.assert_allclose(constant[known & near], expected[known & near])


def test_a_plane_cuts_triangles_into_segments() -> None:
    corner = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]]])
    (segment,) = cut_triangles(Plane.of("z=1"), corner)
    assert sorted(segment.tolist()) == [[0.0, 0.0], [1.0, 0.0]]
    assert len(cut_triangles(Plane.of("z=3"), corner)) == 0
    turned = [np.roll(corner, turn, axis=1) for turn in range(3)]
    for height in (0.5, 1.5):  # the sides meet it at unequal distances from their ends
        for each in turned:
            (segment,) = cut_triangles(Plane.of(f"z={height}"), each)
            assert sorted(segment.tolist()) == [[0.0, 0.0], [2.0 - height, 0.0]]


@pytest.mark.parametrize("text", ["q=1", "x=nan", "x", "0,0:1,0,0", "0,0,0:0,0,0", "0,0,0:1,1"])
def test_what_is_no_plane_is_refused(text: str) -> None:
    with pytest.raises(BadInput, match="is not a plane"):
        Plane.of(text)
