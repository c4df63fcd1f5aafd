# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surfaces in the pictures of the report: where they are, which they are, and the start."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from report_pages import data_of
from report_setups import UNITS, make_setup, snapshot
from tracked_shapes import circle, line, octahedron

from tilth.output import HistoryWriter, ResultsWriter, RunLog, Snapshot, SurfaceShape
from tilth.report.field_plots import draw_frames
from tilth.report.html import write_report
from tilth.report.setup import draw_setup
from tilth.report.tracked_surfaces import TRACKED_COLOURS, colour_of


def frame(step: int) -> Snapshot:
    """A block with a line on it and a hole, both of which move with it."""
    stretch = 1.0 + 0.1 * step
    top = line("top", stretch * np.linspace([6.0, 4.0], [0.0, 4.0], 9))
    hole = circle("hole", 12)
    hole = replace(hole, position=stretch * (hole.position + np.array([3.0, 2.0])))
    return replace(snapshot(2, step), surfaces=(top, hole))


def lines(axes: Any, dashed: bool) -> list[Any]:
    return [drawn for drawn in axes.lines if (drawn.get_linestyle() == "--") == dashed]


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_lines_are_where_the_surfaces_are_and_were() -> None:
    frames = [frame(step) for step in (0, 2, 4)]
    figure = draw_frames(frames, "displacement", UNITS, initial=frames[0])
    for axes, state in zip(figure.axes[:-1], frames, strict=True):
        top, hole = lines(axes, dashed=False)
        np.testing.assert_array_equal(top.get_xydata(), state.surfaces[0].position)
        np.testing.assert_array_equal(hole.get_xydata()[:-1], state.surfaces[1].position)
        np.testing.assert_array_equal(hole.get_xydata()[-1], hole.get_xydata()[0])
        before = lines(axes, dashed=True)
        assert len(before) == (0 if state.step == 0 else 2)
        for now, then, shape in zip((top, hole), before, frames[0].surfaces, strict=False):
            assert then.get_color() == now.get_color()
            assert then.get_linewidth() < now.get_linewidth()
            np.testing.assert_array_equal(then.get_xydata()[: len(shape.position)], shape.position)
        assert to_hex(top.get_color()) != to_hex(hole.get_color())
    assert texts(figure) == ["surface: top", "surface: hole", "surfaces at the start"]


@pytest.mark.slow
def test_the_start_is_named_where_it_is_drawn() -> None:
    first, last = (replace(frame(step), surfaces=frame(step).surfaces[:1]) for step in (0, 4))
    assert texts(draw_frames([last], "displacement", UNITS, initial=first)) == [
        "surface: top",
        "surface at the start",
    ]
    assert texts(draw_frames([first], "displacement", UNITS, initial=first)) == ["surface: top"]
    assert texts(draw_frames([first, last], "displacement", UNITS)) == ["surface: top"]


@pytest.mark.slow
@pytest.mark.parametrize("dim", [2, 3])
def test_without_surfaces_the_pictures_stay_as_they_are(dim: int) -> None:
    first, last = snapshot(dim, 0), snapshot(dim, 4)
    plain = draw_frames([last], "displacement", UNITS)
    figure = draw_frames([last], "displacement", UNITS, initial=first)
    assert figure.legends == []
    assert figure.get_size_inches().tolist() == plain.get_size_inches().tolist()
    assert figure.axes[0].get_xlim() == plain.axes[0].get_xlim()


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 4])
def test_long_names_stay_inside_the_picture(count: int) -> None:
    shapes = [
        replace(frame(1).surfaces[0], name=f"the surface of the embankment, part {k} of several")
        for k in range(7)
    ]
    frames = [replace(frame(step), surfaces=tuple(shapes)) for step in range(count)]
    figure = draw_frames(frames, "displacement", UNITS)
    figure.canvas.draw()
    box = figure.legends[0].get_window_extent()
    assert box.x0 >= 0.0
    assert box.x1 <= figure.bbox.x1
    assert box.y1 <= figure.bbox.y1
    for axes in figure.axes[:-1]:
        assert axes.get_tightbbox().y1 <= box.y0, "the legend covers a panel"
        assert axes.get_window_extent().height > 60.0
    assert colour_of(0) == colour_of(len(TRACKED_COLOURS))


def test_a_surface_beside_the_points_is_seen_whole() -> None:
    far = replace(
        frame(1), surfaces=(line("water", np.array([[20.0, -5.0], [0.0, -5.0], [-9.0, -5.0]])),)
    )
    axes = draw_frames([far], "displacement", UNITS).axes[0]
    assert axes.get_xlim()[0] < -9.0
    assert axes.get_xlim()[1] > 20.0
    assert axes.get_ylim()[0] < -5.0


def drawn_in_space(shape: SurfaceShape) -> tuple[set[Any], set[Any]]:
    """Strong and thin edges as pairs of vertices."""
    figure = draw_frames([replace(snapshot(3), surfaces=(shape,))], "displacement", UNITS)
    assert texts(figure) == [f"surface: {shape.name}"]
    panel = figure.axes[0]
    assert not panel.computed_zorder
    found: dict[float, set[Any]] = {1.2: set(), 0.35: set()}
    for lines_of in panel.collections:
        if isinstance(lines_of, Line3DCollection):
            others = [c for c in panel.collections if not isinstance(c, Line3DCollection)]
            assert lines_of.zorder > max(c.zorder for c in others)
            for segment in lines_of._segments3d:
                ends = [int(np.flatnonzero((shape.position == p).all(axis=1))[0]) for p in segment]
                found[lines_of.get_linewidth()[0]].add(tuple(sorted(ends)))
    return found[1.2], found[0.35]


def test_what_faces_the_viewer_is_drawn_in_space() -> None:
    # seen from +x, -y and a little above; vertices are +x -x +y -y +z -z
    strong, thin = drawn_in_space(octahedron("ball", 1))
    assert thin == set()  # all its edges are creases: cosine 1/3
    assert (0, 3) in strong
    assert (1, 2) not in strong


def test_edges_between_triangles_of_one_plane_are_thin() -> None:
    position = np.array([[0.0, 0.0, 4.0], [3.0, 0.0, 4.0], [3.0, 3.0, 4.0], [0.0, 3.0, 4.0]])
    down = np.array([[0, 2, 1], [0, 3, 2]])
    normal = np.tile([0.0, 0.0, -1.0], (4, 1))
    strong, thin = drawn_in_space(SurfaceShape("top", position, down, {"normal": normal}))
    assert strong == {(0, 1), (1, 2), (2, 3), (0, 3)}
    assert thin == {(0, 2)}
    from_below = SurfaceShape("top", position, down[:, ::-1], {"normal": -normal})
    assert drawn_in_space(from_below) == (set(), set())


def test_the_setup_shows_the_surfaces_at_the_start() -> None:
    top = line("top of the soil", np.linspace([9.0, 6.0], [0.0, 7.0], 5))
    plain = make_setup((8, 6), 1.0)
    figure = draw_setup(replace(plain, tracked=(top, circle("pipe", 8))))
    (axes,) = figure.axes
    drawn = [item for item in axes.lines if item.get_color() in TRACKED_COLOURS]
    assert [item.get_color() for item in drawn] == [colour_of(0), colour_of(1)]
    np.testing.assert_array_equal(drawn[0].get_xydata(), top.position)
    assert axes.get_xlim()[0] < -1.0  # the circle reaches out of the soil
    assert axes.get_xlim()[1] > 9.0
    assert axes.get_ylim()[1] > 7.0
    assert {"top of the soil\ntracked surface", "pipe\ntracked surface"} <= set(texts(figure))
    assert not [text for text in texts(draw_setup(plain)) if "surface" in text]


def test_the_setup_in_space_shows_the_surfaces_at_the_start() -> None:
    shape = octahedron("ball", 1, 2.0)
    figure = draw_setup(replace(make_setup((6, 5, 4), 1.0), tracked=(shape,)))
    assert "ball\ntracked surface" in texts(figure)
    (space,) = (axes for axes in figure.axes if axes.name == "3d")
    assert [c for c in space.collections if isinstance(c, Line3DCollection)]
    assert space.get_xlim()[0] < -2.0


@pytest.mark.slow
def test_the_report_of_a_folder_has_its_surfaces(tmp_path: Path) -> None:
    for name, bare in (("with", False), ("without", True)):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "model.json").write_text(json.dumps({"analysis": {"kind": "plane_strain"}}))
        results = ResultsWriter(folder / "results.vtkhdf", units=UNITS)
        history = HistoryWriter(folder / "history.csv", [])
        log = RunLog(folder / "log.txt")
        log.header(version="0.1.0", title="", threads=1, points=24, cells=6)
        for step in range(3):
            results.append(replace(frame(step), surfaces=()) if bare else frame(step))
            history.append(step, 0.25 * step, 3, [])
        log.finish(None, {}, "none")
        for file in (results, history, log):
            file.close()
        page = write_report(folder)
        assert ("surface.csv" in page.read_text(encoding="utf-8")) == (not bare)
        drawn = [
            [part["name"] for part in each["lines"] if part["kind"] == "tracked"]
            for each in data_of(page)["body"]["frames"]
        ]
        assert drawn == [[] if bare else ["top", "hole"]] * 3
