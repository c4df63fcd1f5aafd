# SPDX-License-Identifier: BSD-3-Clause
"""Pictures and the report page: what they are given is what they show."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection, PolyCollection
from mpl_toolkits.mplot3d.proj3d import proj_transform
from report_pages import chart, data_of, html_of
from report_setups import UNITS, lattice, make_setup, snapshot
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from tilth.bodies.elements import simplex_tiles
from tilth.errors import BadInput
from tilth.output import HistoryWriter, ResultsWriter, RunLog
from tilth.report.domains import corners_of_boxes, sides_towards
from tilth.report.field_plots import draw_frames
from tilth.report.fields import field_values
from tilth.report.html import write_report
from tilth.report.setup import Load, draw_setup
from tilth.report.tables import model_tables
from tilth.report.visible_points import exterior_points, points_with_free_sides

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("counts", [(8, 6), (2, 100), (100, 2), (5, 4, 6), (2, 2, 60)])
def test_setup_picture_names_everything(counts: tuple[int, ...], tmp_path: Path) -> None:
    setup = make_setup(counts)
    figure = draw_setup(setup)
    figure.savefig(tmp_path / "setup.png", dpi=50)
    assert (tmp_path / "setup.png").read_bytes().startswith(b"\x89PNG")
    (legend,) = figure.legends
    texts = [text.get_text().replace("\n", " ") for text in legend.get_texts()]
    up = "y" if len(counts) == 2 else "z"
    everything = " | ".join(texts)
    assert f"clay {np.prod(counts)} points" in everything
    assert f"base roller, {up} constrained" in everything
    assert "corner fixed" in everything
    assert f"plate prescribed in {up}, up to 0.2 m" in everything
    assert "pull 7 kN in total" in everything
    assert "acceleration 9.81" in everything
    labels = {axes.get_xlabel() for axes in figure.axes}
    assert labels <= {"x [m]", "y [m]"}
    drawn = legend.get_window_extent()
    assert drawn.x0 >= 0.0
    assert drawn.x1 <= figure.bbox.x1 + 1.0
    for axes in figure.axes:
        box = axes.get_window_extent()
        assert box.x1 <= drawn.x0, "the legend covers the drawing"
        assert box.width > 3.0
        assert box.height > 10.0
    if len(counts) == 2:
        assert all(axes.get_aspect() == 1.0 for axes in figure.axes)


@pytest.mark.parametrize("counts", [(8, 6), (120, 90), (300, 200), (5, 4, 6)])
def test_bodies_are_filled_and_points_drawn_where_they_can_be_seen(counts: tuple[int, ...]) -> None:
    setup = make_setup(counts, 2.0 / counts[0])
    figure = draw_setup(setup)
    axes = figure.axes[0]
    (filled,) = (c for c in axes.collections if type(c) is PolyCollection)
    boxes = np.array([path.vertices[:4] for path in filled.get_paths()])
    sides = np.ptp(boxes, axis=1)
    extent = np.ptp(setup.position, axis=0)[[0, -1]] + 2.0 / counts[0]
    assert sides.prod(axis=1).sum() == pytest.approx(extent.prod(), rel=0.02)
    assert len(boxes) <= 40_401
    few = len(setup.position) < 1000
    assert any(isinstance(c, EllipseCollection) for c in axes.collections) == few
    assert ("too small" in figure.get_supxlabel()) == (not few)


@pytest.mark.parametrize("dim", [2, 3])
def test_body_force_is_drawn_at_the_middle_of_the_body_and_a_zero_one_not(dim: int) -> None:
    setup = replace(make_setup((6, 4, 5)[:dim]), loads=[], conditions=[])
    arrows = [c for axes in draw_setup(setup).axes for c in axes.collections if hasattr(c, "U")]
    assert len(arrows) == 1 if dim == 2 else 2  # the plan looks along it
    np.testing.assert_allclose(arrows[0].get_offsets(), [setup.position.mean(axis=0)[[0, -1]]])
    assert arrows[0].U[0] == 0.0
    assert arrows[0].V[0] < 0.0
    figure = draw_setup(replace(setup, body_force=np.zeros(dim)))
    assert not [c for axes in figure.axes for c in axes.collections if hasattr(c, "U")]
    assert "body force" not in " ".join(text.get_text() for text in figure.legends[0].get_texts())


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("dim", [2, 3])
def test_vectors_that_vanish_draw_without_warnings(dim: int, tmp_path: Path) -> None:
    setup = make_setup((6, 4, 5)[:dim])
    ends, couple = setup.position[[0, -1]], np.eye(dim)[[1, 1]] * [[1.0], [-1.0]]
    loads = [
        Load("nothing", ends, np.zeros((2, dim))),
        Load("couple", ends, couple),
        Load("along y", ends, np.abs(couple)),
    ]
    still = replace(setup.conditions[2], displacement=np.zeros((3, dim)))
    given = replace(setup, loads=loads, conditions=[still], body_force=np.zeros(dim))
    figure = draw_setup(given)
    figure.savefig(tmp_path / "setup.png", dpi=50)
    texts = [text.get_text().replace("\n", " ") for text in figure.legends[0].get_texts()]
    assert "nothing 0 kN in total" in texts
    assert "along y 2 kN in total" in texts


def test_field_values_have_their_definitions() -> None:
    state = snapshot()
    stress = state.point_fields["cauchy_stress"]
    values, label = field_values(state, "cauchy_stress_yy", UNITS)
    np.testing.assert_array_equal(values, stress[:, 1])
    assert label == "Cauchy stress yy [kPa]"
    values, _ = field_values(state, "cauchy_stress_mean", UNITS)
    np.testing.assert_allclose(values, stress[:, 1] / 3.0)
    values, label = field_values(state, "cauchy_stress_von_mises", UNITS)
    np.testing.assert_allclose(values, np.sqrt(stress[:, 1] ** 2 + 3.0 * stress[:, 3] ** 2))
    assert label == "Cauchy stress von Mises [kPa]"
    values, label = field_values(state, "displacement", UNITS)
    np.testing.assert_allclose(
        values, np.sqrt((state.point_fields["displacement"] ** 2).sum(axis=1))
    )
    assert label == "Displacement magnitude [m]"
    values, label = field_values(state, "plastic_strain", UNITS)
    assert label == "Equivalent plastic strain [-]"
    values, _ = field_values(state, "deformation_gradient_yy", UNITS)
    np.testing.assert_array_equal(values, 1.1)
    for wrong in ("stress", "cauchy_stress", "displacement_z", "plastic_strain_x"):
        with pytest.raises(BadInput, match="colour_by"):
            field_values(state, wrong, UNITS)


@pytest.mark.parametrize("dim", [2, 3])
def test_frames_share_axes_and_colours(dim: int) -> None:
    frames = [snapshot(dim, step) for step in range(4)]
    figure = draw_frames(frames, "cauchy_stress_yy", UNITS)
    panels, bar = figure.axes[:-1], figure.axes[-1]
    assert [axes.get_title() for axes in panels] == [
        f"step {k}, time {0.25 * k:.4g}" for k in range(4)
    ]
    assert bar.get_ylabel() == "Cauchy stress yy [kPa]"
    assert bar.get_ylim() == pytest.approx((-30.0 * 4.5, 0.0))
    assert len({(axes.get_xlim(), axes.get_ylim()) for axes in panels}) == 1
    assert panels[0].get_xlim()[1] >= frames[-1].position[:, 0].max() + 0.5


def test_colours_diverge_about_zero_only_where_both_signs_occur() -> None:
    frames = [snapshot(2, 2)]
    bar = draw_frames(frames, "cauchy_stress_xy", UNITS).axes[-1]
    low, high = bar.get_ylim()
    assert low == -high
    bar = draw_frames(frames, "plastic_strain", UNITS).axes[-1]
    assert bar.get_ylim()[0] == 0.0


def test_domains_in_space_close_the_surface_that_is_seen() -> None:
    state = snapshot(3)
    (panel, _) = draw_frames([state], "displacement", UNITS).axes
    (solids,) = panel.collections
    faces = np.array(solids._faces)
    sides = np.ptp(faces, axis=1)
    normal = np.argmin(sides, axis=1)
    np.testing.assert_allclose(np.sort(sides, axis=1), np.tile([0.0, 1.0, 1.0], (len(sides), 1)))
    shell = len(exterior_points(state.position, state.point_fields["domain"]))
    assert np.bincount(normal).tolist() == [shell] * 3
    # the outermost side of each kind is the surface of the body that faces the viewer
    domain = state.point_fields["domain"]
    assert faces[normal == 0, 0, 0].max() == (state.position + domain)[:, 0].max()
    assert faces[normal == 1, 0, 1].min() == (state.position - domain)[:, 1].min()
    assert faces[normal == 2, 0, 2].max() == (state.position + domain)[:, 2].max()


@pytest.mark.parametrize("few", [True, False])
def test_domains_with_corners_are_drawn_as_they_are(
    few: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    random = np.random.default_rng(4)
    if not few:
        monkeypatch.setattr("tilth.report.setup_view.MAXIMUM_DRAWN_DOMAINS", 10)
    state, setup = snapshot(2), replace(make_setup((6, 4)), conditions=[], loads=[])
    corners = random.uniform(0.2, 0.3, (24, 4, 2)) * [[-1, -1], [1, -1], [-1, 1], [1, 1]]
    expected = corners[:, [0, 1, 3, 2]]
    state = replace(state, point_fields={**state.point_fields, "domain_corners": corners})
    axes = draw_frames([state], "displacement", UNITS, show="domains").axes[0]
    (filled,) = (c for c in axes.collections if type(c) is PolyCollection)
    drawn = np.array([path.vertices[:4] for path in filled.get_paths()])
    np.testing.assert_array_equal(drawn, state.position[:, None] + expected)
    axes = draw_setup(replace(setup, corners=corners)).axes[0]
    (filled,) = (c for c in axes.collections if type(c) is PolyCollection)
    drawn = np.array([path.vertices[:4] for path in filled.get_paths()])
    if few:
        np.testing.assert_array_equal(drawn, setup.position[:, None] + expected)
    else:  # rectangles that cover many points
        assert len(np.unique(np.ptp(drawn, axis=1).round(9), axis=0)) == 1


def test_sides_of_domains_in_space_that_face_the_viewer_are_what_is_seen() -> None:
    """Their projected areas sum to that of the convex domain's outline, in any position."""
    random = np.random.default_rng(5)
    box = corners_of_boxes(np.array([[0.5, 0.3, 0.2]]))[0]
    part = simplex_tiles(3, 1)[0] @ np.eye(4)[:, 1:]  # a quarter of a tetrahedron
    viewer = np.array([0.6, -0.48, 0.64])
    across = np.linalg.svd(viewer[None])[2][1:].T
    found = []
    for shape in (box, part - part.mean(axis=0)):
        corners = shape @ Rotation.random(20, random_state=random).as_matrix()
        position = random.uniform(-1.0, 1.0, (20, 3))
        sides, normals, number = sides_towards(position, corners, viewer)
        around = np.cross(sides[:, 2] - sides[:, 0], sides[:, 3] - sides[:, 1])
        np.testing.assert_allclose(np.cross(around, normals), 0.0, atol=1e-14)
        towards = 0.5 * around @ viewer
        assert (towards > 0.0).all()
        outline = [ConvexHull(place @ across).volume for place in corners]
        np.testing.assert_allclose(np.bincount(number, towards), outline, rtol=1e-12)
        places = position[number, None] + corners[number]
        apart = np.linalg.norm(sides[:, :, None] - places[:, None], axis=3)
        np.testing.assert_allclose(apart.min(axis=2), 0.0, atol=1e-15)
        found.append(set(np.bincount(number)))
    assert found[0] == {3}
    assert {2, 4} < found[1]


def test_markers_of_many_points_are_as_large_as_their_domains(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("tilth.report.points_3d.MAXIMUM_DRAWN_DOMAINS", 10)
    (panel, _) = draw_frames([snapshot(3)], "displacement", UNITS).axes
    (markers,) = panel.collections
    figure = panel.figure
    figure.canvas.draw()
    corners = np.array([[3.0, 2.0, 1.0], [4.0, 2.0, 1.0], [3.0, 3.0, 1.0], [3.0, 2.0, 2.0]])
    seen = np.array([proj_transform(*corner, panel.get_proj())[:2] for corner in corners])
    pixels = panel.transData.transform(seen)
    longest = np.linalg.norm(pixels[1:] - pixels[0], axis=1).max()
    diameter = np.sqrt(markers.get_sizes()[0]) * figure.dpi / 72.0
    assert longest < diameter < 2.5 * longest


def test_outer_points_are_the_shell() -> None:
    position = lattice((6, 7, 8), 0.1)
    index = np.round(position / 0.1 - 0.5).astype(int)
    shell = np.any((index == 0) | (index == np.array([5, 6, 7])), axis=1)
    seen = exterior_points(position, np.full_like(position, 0.05))
    assert set(np.flatnonzero(shell)) <= set(seen.tolist())
    assert len(seen) < len(position)


MODEL: dict[str, Any] = {
    "format": 1,
    "analysis": {"kind": "plane_strain", "line_search": False, "tolerance": 1e-9},
    "materials": {"clay": {"model": "hencky_elastic", "young_modulus": 1.2e7}},
    "bodies": [
        {
            "name": "beam <1>",
            "shape": {"type": "box", "upper": [10.0, 1.0], "angle": None, "holes": []},
        },
        {"name": "second", "spacing": 0.25},
    ],
    "initial": {"stress": [], "equilibrium": True},
    "output": {"colour_by": "cauchy_stress_yy"},
}


def test_model_becomes_tables() -> None:
    page = html_of(model_tables(MODEL))
    assert "<th>young modulus</th>" in page
    assert "<td>12,000,000</td>" in page
    assert "beam &lt;1&gt;" in page
    assert "box: upper (10, 1)" in page
    assert "<th>line search</th><td>no</td>" in page
    assert "<th>equilibrium</th><td>yes</td>" in page
    assert "None" not in page
    assert "()" not in page
    assert "holes" not in page


def write_run(
    folder: Path, *, dim: int = 2, failure: str | None = None, closed: bool = True
) -> None:
    results = ResultsWriter(folder / "results.vtkhdf", title="A <run>", units=UNITS)
    history = HistoryWriter(folder / "history.csv", [("tip", "m")])
    log = RunLog(folder / "log.txt")
    log.header(version="0.1.0", title="A <run>", threads=2, points=24, cells=6)
    for step in range(9):
        results.append(snapshot(dim, step))
        history.append(step, 0.25 * step, 3 * (step > 0), [0.5 * step])
        if step:
            log.step(step, 0.25 * step, 0.25, [1.0, 1e-4, 1e-9])
    log.warning("sand & clay")
    if closed:
        log.finish(failure, {}, "none")
    for file in (results, history, log):
        file.close()


class Checker(HTMLParser):
    """Collects what a page refers to and checks that its elements are closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.references: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "img", "input"):
            self.open.append(tag)
        self.references += [
            v or "" for k, v in attrs if k in ("src", "href") and not (v or "").startswith("#")
        ]
        assert tag not in ("link", "iframe")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "script":
            self.text += data


def read_page(path: Path) -> Checker:
    page = Checker()
    page.feed(path.read_text(encoding="utf-8"))
    assert page.open == []
    return page


@pytest.mark.parametrize("dim", [2, 3])
def test_report_is_one_self_contained_page(tmp_path: Path, dim: int) -> None:
    write_run(tmp_path, dim=dim)
    setup = make_setup((6, 4, 3)[:dim])
    path = write_report(tmp_path, MODEL, setup=setup)
    page = read_page(path)
    assert page.references == []
    assert "http" not in page.text
    assert "url(" not in page.text
    assert "A <run>" in page.text
    assert "The run reached the end of its schedule." in page.text
    assert "sand & clay" in page.text
    assert "6 of 9 outputs" in page.text
    assert "8 steps, 24 Newton iterations" in page.text
    assert re.search(r"ParaView", page.text)
    tip = chart(path, "tip [m] over time")
    np.testing.assert_array_equal(tip["lines"][0]["y"], 0.5 * np.arange(9.0))
    np.testing.assert_array_equal(tip["lines"][0]["x"], 0.25 * np.arange(9.0))
    drawn = data_of(path)["views"]
    assert [view.get("steps") for view in drawn] == [None, [0, 2, 3, 5, 6, 8]]
    assert len(drawn[0]["panels"]) == (1 if dim == 2 else 4)
    assert drawn[0]["frames"][0]["count"] == len(setup.position)
    kinds = {mark["kind"] for mark in drawn[0]["panels"][0]["marks"]}
    assert kinds == {"support", "arrows"}


@pytest.mark.parametrize("closed", [True, False])
def test_report_of_an_unfinished_run_says_so(tmp_path: Path, closed: bool) -> None:
    write_run(tmp_path, failure="step 9 found no equilibrium", closed=closed)
    (tmp_path / "model.json").write_text('{"analysis": {"kind": "axisymmetric"}}')
    page = read_page(write_report(tmp_path))
    assert "This run is incomplete." in page.text
    assert ("step 9 found no equilibrium" in page.text) == closed
    assert "axisymmetric" in page.text


@pytest.mark.parametrize("part", ["field_values", "history_charts", "newton_charts", "setup_view"])
def test_a_picture_that_fails_leaves_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    def fails(*arguments: Any, **keywords: Any) -> None:
        raise ValueError("no <colours>")

    write_run(tmp_path)
    monkeypatch.setattr(f"tilth.report.sections.{part}", fails)
    path = write_report(tmp_path, MODEL, setup=make_setup((6, 4)))
    assert "could not be drawn (ValueError: no <colours>)" in read_page(path).text
    found = data_of(path)
    expected = {"field_values": 4, "history_charts": 4, "newton_charts": 3, "setup_view": 4}
    assert len(found["charts"]) + len(found["views"]) == expected[part]


def test_report_of_nothing_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="tilth run"):
        write_report(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("dim", [2, 3])
def test_the_report_of_a_run_does_not_load_matplotlib(tmp_path: Path, dim: int) -> None:
    write_run(tmp_path, dim=dim)
    (tmp_path / "model.json").write_text('{"analysis": {"kind": "plane_strain"}}')
    code = (
        "import sys; from tilth.report.html import write_report; "
        f"write_report({str(tmp_path)!r}); print('matplotlib' in sys.modules)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.split() == ["False"], result.stderr


def test_import_of_the_report_is_light() -> None:
    code = "import sys, tilth.report; print('matplotlib' in sys.modules, 'h5py' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.split() == ["False", "False"], result.stderr


def test_points_with_a_free_side_are_the_shell_of_a_body_that_leans_and_is_strained() -> None:
    counts = (6, 7, 8)
    place = lattice(counts, 0.1)
    index = np.round(place / 0.1 - 0.5).astype(int)
    shell = np.any((index == 0) | (index == np.array(counts) - 1), axis=1)
    gradient = np.array([[1.3, 0.5, 0.0], [0.0, 0.8, -0.2], [0.6, 0.0, 0.4]])
    corners = corners_of_boxes(np.full_like(place, 0.05)) @ gradient.T
    found = points_with_free_sides(place @ gradient.T, corners)
    np.testing.assert_array_equal(found, np.flatnonzero(shell))
