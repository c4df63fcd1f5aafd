# SPDX-License-Identifier: BSD-3-Clause
"""Implicit boundaries in the picture of the set-up: lines, sides, names, and what is in view."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import to_hex
from matplotlib.patches import PathPatch

from tilth.report.setup import Condition, Setup, Surface, draw_setup
from tilth.report.setup_view import CONDITION_COLOURS
from tilth.report.surface_lines import chains, clip_segments, clip_triangles, moved_corners

COLOUR = CONDITION_COLOURS[0]


def make_setup(*surfaces: Surface, dim: int = 2) -> Setup:
    """Soil in the box from 0 to 8, 6 (and 4) [m], cells of 1 m."""
    axes = [np.arange(0.25, end, 0.5) for end in ([8.0, 6.0] if dim == 2 else [8.0, 6.0, 4.0])]
    position = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dim)
    return Setup(
        title="Surfaces",
        dim=dim,
        length_unit="m",
        position=position,
        half_lengths=np.full_like(position, 0.25),
        body_id=np.zeros(len(position), dtype=np.int64),
        body_names=["clay"],
        cell_size=np.ones(dim),
        origin=np.zeros(dim),
        surfaces=surfaces,
    )


def path_of(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Segments along vertices, shape (k, 2), and their normals to the left."""
    corner = np.stack([vertices[:-1], vertices[1:]], axis=1)
    step = corner[:, 1] - corner[:, 0]
    step /= np.linalg.norm(step, axis=1)[:, None]
    return corner, np.column_stack([-step[:, 1], step[:, 0]])


def inclined(kind: str) -> Surface:
    """The line x + 2 y = 2, soil above it, from far away to far away."""
    x = np.linspace(-80.0, 80.0, 321)
    return Surface("base", kind, *path_of(np.column_stack([x, 1.0 - 0.5 * x])))


def circle(kind: str, lift: float = 0.0) -> Surface:
    angle = np.linspace(0.0, 2.0 * np.pi, 41)
    vertices = np.array([4.0, 3.0]) + np.column_stack([np.cos(angle), np.sin(angle)])
    corner, normal = path_of(vertices)
    moves = np.tile([0.0, lift], (40, 1)) if lift else None
    return Surface("pipe", kind, corner, -normal, moves)


def lines_of(axes: Axes, colour: str = COLOUR) -> list[np.ndarray]:
    return [line.get_xydata() for line in axes.lines if to_hex(line.get_color()) == colour]


def strokes_of(axes: Axes, colour: str = COLOUR) -> np.ndarray:
    """Ends of the strokes of hatching, shape (k, 2, 2): on the surface first."""
    own = [
        collection.get_segments()
        for collection in axes.collections
        if isinstance(collection, LineCollection) and to_hex(collection.get_colors()[0]) == colour
    ]
    return np.concatenate([np.array(part).reshape(-1, 2, 2) for part in own])


@pytest.mark.parametrize("kind", ["roller", "fixed", "tangential", "direction"])
def test_an_inclined_line_is_where_it_is_and_hatched_away_from_the_soil(kind: str) -> None:
    (axes,) = draw_setup(make_setup(inclined(kind))).axes
    (line,) = lines_of(axes)
    height = (line @ [1.0, 2.0] - 2.0) / np.sqrt(5.0)
    np.testing.assert_allclose(height, 0.0, atol=1e-12)
    assert line[:, 0].min() == pytest.approx(max(axes.get_xlim()[0], 2 - 2 * axes.get_ylim()[1]))
    assert line[:, 1].min() == pytest.approx(axes.get_ylim()[0])
    strokes = (strokes_of(axes) @ [1.0, 2.0] - 2.0) / np.sqrt(5.0)
    assert len(strokes) >= 10
    assert strokes.max() < 0.0
    assert np.all(strokes[:, 1] <= strokes[:, 0] + 1e-12)
    assert strokes.min() > -0.5


def test_hatching_of_a_hole_lies_in_the_hole() -> None:
    (axes,) = draw_setup(make_setup(circle("fixed"))).axes
    (line,) = lines_of(axes)
    radius = np.linalg.norm(line - [4.0, 3.0], axis=1)
    np.testing.assert_allclose(radius, 1.0, rtol=1e-12)
    np.testing.assert_array_equal(line[0], line[-1])
    inner = np.linalg.norm(strokes_of(axes) - [4.0, 3.0], axis=2)
    assert inner.max() < 1.0
    assert inner.min() > 0.7
    soil_inside = circle("fixed")
    turned = replace(soil_inside, normal=-soil_inside.normal)
    (axes,) = draw_setup(make_setup(turned)).axes
    assert np.linalg.norm(strokes_of(axes)[:, 1] - [4.0, 3.0], axis=1).min() > 1.0


def test_the_hatching_of_a_box_does_not_cross_its_corners() -> None:
    vertices = np.array([[3, 2], [3, 4], [5, 4], [5, 2], [3, 2]], dtype=float)
    (axes,) = draw_setup(make_setup(Surface("block", "fixed", *path_of(vertices)))).axes
    strokes = strokes_of(axes)
    assert len(strokes) > 20
    assert strokes[..., 0].min() > 3.0
    assert strokes[..., 0].max() < 5.0
    assert strokes[..., 1].min() > 2.0
    assert strokes[..., 1].max() < 4.0


def test_kinds_differ() -> None:
    looks = set()
    for kind in ("roller", "fixed", "tangential", "direction"):
        figure = draw_setup(make_setup(inclined(kind)))
        (axes,) = figure.axes
        (line,) = (line for line in axes.lines if to_hex(line.get_color()) == COLOUR)
        ellipses = [c for c in axes.collections if isinstance(c, EllipseCollection)]
        wheels = [c for c in ellipses if len(c.get_edgecolor())]  # the points have no edge
        dashes = line._dash_pattern[1]  # matplotlib has no public way to ask for it
        looks.add((str(dashes), len(wheels)))
        if kind == "roller":
            side = wheels[0].get_offsets() @ [1.0, 2.0] - 2.0
            assert side.max() < 0.0
    assert len(looks) == 4


def test_the_legend_names_surfaces_and_colours_go_on_after_the_conditions() -> None:
    constrained = np.tile([False, True], (2, 1))
    condition = Condition("bottom", "roller", np.array([[0.0, 0.0], [1.0, 0.0]]), constrained)
    setup = replace(make_setup(inclined("roller"), circle("fixed", 0.5)), conditions=[condition])
    figure = draw_setup(setup)
    texts = [text.get_text().replace("\n", " ") for text in figure.legends[0].get_texts()]
    assert "base implicit, normal constrained" in texts
    assert "pipe implicit, all constrained, moves up to 0.5 m" in texts
    (axes,) = figure.axes
    assert len(lines_of(axes, CONDITION_COLOURS[1])) == 1  # the plane
    assert len(lines_of(axes, CONDITION_COLOURS[2])) == 2  # the pipe and where it goes
    handles = figure.legends[0].legend_handles
    assert [to_hex(h.get_color()) for h in handles[-2:]] == list(CONDITION_COLOURS[1:3])


def test_a_moving_surface_has_arrows_and_a_dashed_line_at_its_end() -> None:
    (axes,) = draw_setup(make_setup(circle("fixed", 0.5))).axes
    first, ghost = lines_of(axes)
    np.testing.assert_allclose(ghost, first + np.array([0.0, 0.5]), atol=1e-12)
    assert axes.lines[0].get_linestyle() == "-"
    assert axes.lines[1].get_linestyle() == "--"
    (arrows,) = (c for c in axes.collections if hasattr(c, "U"))
    assert 4 <= len(arrows.U) <= 10
    np.testing.assert_allclose(arrows.U, 0.0)
    assert arrows.V.min() > 0.0
    (axes,) = draw_setup(make_setup(circle("fixed"))).axes
    assert len(axes.lines) == 1
    assert not [c for c in axes.collections if hasattr(c, "U")]


@pytest.mark.parametrize("dim", [2, 3])
def test_linear_motions_of_centres_are_those_of_the_corners(dim: int) -> None:
    random = np.random.default_rng(5)
    corner = random.normal(size=(30, dim, dim))
    gradient, shift = random.normal(size=(dim, dim)), random.normal(size=dim)
    moved = moved_corners(corner, corner.mean(axis=1) @ gradient + shift)
    np.testing.assert_allclose(moved, corner + corner @ gradient + shift, atol=1e-12)
    # one flat facet can only be translated
    np.testing.assert_allclose(moved_corners(corner[:1], shift[None]), corner[:1] + shift)


def test_a_closed_line_stays_closed_under_any_motion() -> None:
    surface = circle("fixed")
    centre = surface.corner.mean(axis=1)
    moved = moved_corners(surface.corner, np.sin(3.0 * centre))
    np.testing.assert_allclose(moved[:, 1], np.roll(moved[:, 0], -1, axis=0), atol=1e-12)
    # Averages over two neighbours differ by a quarter of the second difference, at most 12 h^2.
    bound = 0.25 * 12.0 * (2.0 * np.pi / 40.0) ** 2
    np.testing.assert_allclose(moved.mean(axis=1), centre + np.sin(3.0 * centre), atol=bound)


@pytest.mark.parametrize("dim", [2, 3])
def test_bounds_stay_near_the_soil(dim: int) -> None:
    plain = make_setup(dim=dim)
    if dim == 2:
        far = inclined("fixed")
    else:
        corner = np.array([[[-500.0, -500, -1], [900, -500, -1], [0, 900, -1]]])
        far = Surface("base", "fixed", corner, np.array([[0.0, 0.0, 1.0]]))
    lower, upper = plain.bounds()
    low, high = replace(plain, surfaces=[far]).bounds()
    assert np.all(low >= lower - 1.5)
    assert np.all(high <= upper + 1.5)
    assert low[-1] < -0.6  # what is near the soil is seen


def test_a_small_bounded_surface_above_the_soil_is_seen_whole() -> None:
    vertices = np.array([[3.0, 9.0], [3.0, 6.0], [5.0, 6.0], [5.0, 9.0]])
    wall = Surface("caisson", "fixed", *path_of(vertices[::-1]), bounded=True)
    assert make_setup(wall).bounds()[1][1] > 9.0
    assert make_setup(replace(wall, bounded=False)).bounds()[1][1] < 8.0
    far = replace(wall, corner=wall.corner + 100.0)
    figure = draw_setup(make_setup(far))
    assert make_setup(far).bounds()[1][1] < 8.0
    assert "caisson lies outside the picture" in figure.get_supxlabel()
    assert "outside the picture" not in draw_setup(make_setup(wall)).get_supxlabel()


def inclined_plane() -> Surface:
    """The plane x + 2 z = 2 in triangles on a lattice, soil above it."""
    side = np.linspace(-40.0, 40.0, 41)
    x, y = np.meshgrid(side, side, indexing="ij")
    place = np.stack([x, y, 1.0 - 0.5 * x], axis=-1)
    a, b, c, d = place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]
    halves = [np.stack(three, axis=2).reshape(-1, 3, 3) for three in ((a, b, c), (a, c, d))]
    corner = np.concatenate(halves)
    normal = np.tile(np.array([1.0, 0.0, 2.0]) / np.sqrt(5.0), (len(corner), 1))
    return Surface("base", "fixed", corner, normal)


def test_a_plane_in_space_is_a_hatched_line_edge_on_and_an_area_otherwise(tmp_path: Path) -> None:
    figure = draw_setup(make_setup(inclined_plane(), dim=3))
    front, side, plan, _ = figure.axes
    (line,) = lines_of(front)
    assert len(line) == 2  # the edges of all triangles behind each other are one line
    np.testing.assert_allclose(line @ [1.0, 2.0], 2.0, atol=1e-9)
    assert (strokes_of(front) @ [1.0, 2.0]).max() < 2.0
    for axes in (side, plan):
        assert lines_of(axes) == []
        areas = [patch for patch in axes.patches if isinstance(patch, PathPatch)]
        assert len(areas) == 1
        assert to_hex(areas[0].get_facecolor()) == COLOUR
    assert len(figure.axes[3].collections) == 2  # the body and the plane
    figure.savefig(tmp_path / "setup.png", dpi=50)


def test_a_footing_in_space_has_its_outline_in_plan_and_is_hatched_on_top() -> None:
    corner = np.array(
        [[[2, 1, 4], [4, 1, 4], [4, 3, 4]], [[2, 1, 4], [4, 3, 4], [2, 3, 4]]], dtype=float
    )
    down = np.tile([0.0, 0.0, -1.0], (2, 1))
    setup = make_setup(Surface("footing", "fixed", corner, down, 0.5 * down), dim=3)
    front, side, plan, _ = draw_setup(setup).axes
    for axes, low, high in ((front, 2.0, 4.0), (side, 1.0, 3.0)):
        line, ghost = lines_of(axes)
        np.testing.assert_allclose(sorted(line[:, 0]), [low, high])
        np.testing.assert_allclose(line[:, 1], 4.0)
        np.testing.assert_allclose(ghost[:, 1], 3.5)
        assert strokes_of(axes)[..., 1].min() > 4.0
    outline = strokes_of(plan)  # the four sides and not the diagonal
    assert len(outline) == 4
    assert np.linalg.norm(outline[:, 1] - outline[:, 0], axis=1).sum() == pytest.approx(8.0)


def test_clipping_keeps_length_and_area_inside() -> None:
    lower, upper = np.zeros(2), np.ones(2)
    segment = np.array(
        [
            [[-1, -1], [2, 2]], [[0.2, 0.5], [0.4, 0.5]], [[0, 2], [1, 2]],
            [[0.5, 1], [0.6, 2]], [[0, 2], [2, 0]],  # these touch in one place
        ],
        dtype=float,
    )  # fmt: skip
    part, own = clip_segments(segment, lower, upper)
    np.testing.assert_allclose(part, [[[0, 0], [1, 1]], [[0.2, 0.5], [0.4, 0.5]]])
    np.testing.assert_array_equal(own, [0, 1])
    huge = np.array([[[-50, -50, 0.5], [90, -50, 0.5], [0, 90, 0.5]]])
    (square,), own = clip_triangles(huge, np.zeros(3), np.ones(3))
    x, y, z = square.T
    np.testing.assert_allclose(z, 0.5)
    assert 0.5 * abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) == pytest.approx(1.0)
    assert clip_triangles(huge + np.array([0, 0, 1]), np.zeros(3), np.ones(3))[0] == []


def test_chains_follow_segments_in_any_order() -> None:
    surface = circle("fixed")
    shuffled = np.random.default_rng(3).permutation(40)
    (chain,) = chains(surface.corner[shuffled])
    ordered = surface.corner[shuffled][chain]
    np.testing.assert_allclose(ordered[:-1, 1], ordered[1:, 0])
    assert len(set(chain.tolist())) == 40
