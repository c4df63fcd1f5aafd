# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of pages: ticks, colours, images of polygons, layout, and no matplotlib."""

from __future__ import annotations

import io
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib import colormaps
from PIL import Image
from report_setups import make_setup, snapshot
from scipy.spatial import ConvexHull
from svg_pictures import image_pixels, panels, texts_of_svg
from test_report import UNITS, write_run

from tilth.output import SurfaceShape
from tilth.report.colour_scale import ColourScale
from tilth.report.field_plots import draw_frames
from tilth.report.raster import draw_polygons, png
from tilth.report.setup import draw_setup, page_setup
from tilth.report.svg_axes import SvgAxes
from tilth.report.svg_figure import SvgFigure
from tilth.report.ticks import decades, linear_labels, linear_ticks


@pytest.mark.parametrize("power", [-12, -3, 0, 1, 7])
def test_ticks_are_round_numbers_within_the_limits(power: int) -> None:
    random = np.random.default_rng(power + 20)
    for _ in range(200):
        low, size = random.normal(), random.uniform(0.1, 3.0)
        limits = np.array([low, low + size]) * 10.0**power
        ticks = linear_ticks(*limits, 6)
        assert 2 <= len(ticks) <= 7
        slack = 1e-8 * size * 10.0**power
        assert limits[0] - slack <= ticks[0] < ticks[-1] <= limits[1] + slack
        texts, factor = linear_labels(ticks)
        assert len(set(texts)) == len(texts)
        plain = [float(text.replace("\N{MINUS SIGN}", "-")) for text in texts]
        scale = ticks[np.abs(ticks).argmax()] / plain[int(np.abs(ticks).argmax())]
        np.testing.assert_allclose(np.array(plain) * scale, ticks, atol=1e-9 * np.ptp(ticks))
        assert (factor == "") == bool(abs(scale - 1.0) < 1e-9)


def test_labels() -> None:
    assert linear_labels(np.array([-0.5, 0.0, 0.5])) == (["−0.5", "0.0", "0.5"], "")
    assert linear_labels(np.array([0.0, 1e5, 2e5])) == (["0", "1", "2"], "× 10⁵")
    assert linear_labels(np.array([0.0, 2.5e-4])) == (["0.0", "2.5"], "× 10⁻⁴")
    assert linear_ticks(0.5, 3.4, 6, whole=True).tolist() == [1.0, 2.0, 3.0]
    assert decades(1e-16, 3e-2, 6)[1] == ["10⁻¹⁵", "10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³"]
    assert len(linear_ticks(1.0, 1.0, 6)) == 1


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


def test_png_is_read_back() -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (7, 11, 4), dtype=np.uint8)
    np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(png(pixels)))), pixels)


def many_points(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a unit square and their colours: red on the left, blue on the right."""
    axis = (np.arange(count) + 0.5) / count
    centre = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    corner = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * 0.5 / count
    colour = np.where(centre[:, :1] < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
    return centre[:, None, :] + corner, colour


@pytest.mark.parametrize("count", [10, 40])
def test_few_polygons_are_shapes_and_many_are_an_image(count: int) -> None:
    from tilth.report.svg_parts import PolyCollection

    figure = SvgFigure((5.0, 4.0))
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_xlim(-0.5, 1.5)
    axes.set_ylim(-0.5, 1.5)
    area, colour = many_points(count)
    axes.add_collection(PolyCollection(area, colour, colour, 0.3))
    (panel,) = panels(figure)
    shapes = [p for p in panel.element.iter() if p.attrib.get("fill") in ("#ff0000", "#0000ff")]
    if count == 10:
        assert "".join(shape.attrib["d"] for shape in shapes).count("Z") == 100
        return
    assert shapes == []
    pixels = image_pixels(panel.element)
    filled = pixels[..., 3] > 0
    across = filled.any(axis=0).sum()
    assert abs(across - 2.0 * 0.5 * panel.width) <= 3  # twice the pixels of the page
    assert filled[:, filled.any(axis=0)].any(axis=1).sum() == pytest.approx(panel.height, abs=3)
    half = pixels.shape[1] // 2
    assert (pixels[:, : half - 3][filled[:, : half - 3]][:, :3] == [255, 0, 0]).all()
    assert (pixels[:, half + 3 :][filled[:, half + 3 :]][:, :3] == [0, 0, 255]).all()


def test_limits_fit_the_data_with_a_margin_and_gaps_stay() -> None:
    figure = SvgFigure((5.0, 4.0))
    axes = figure.add_subplot()
    y = np.array([1.0, np.nan, 3.0, 4.0])
    axes.plot(np.arange(4.0), y, "o-", color="k")
    (panel,) = panels(figure)
    np.testing.assert_allclose(axes.x.limits, [-0.15, 3.15])
    np.testing.assert_allclose(axes.y.limits, [0.85, 4.15])
    line = next(p.attrib["d"] for p in panel.element.iter() if p.attrib.get("fill") == "none"
                and "stroke-linejoin" in p.attrib)  # fmt: skip
    assert (line.count("M"), line.count("L")) == (2, 1)
    assert "nan" not in figure.svg()


@pytest.mark.parametrize("counts", [(6, 4), (60, 4), (4, 60)])
def test_a_set_up_for_a_page_has_the_texts_of_that_of_matplotlib(counts: tuple[int, int]) -> None:
    setup = make_setup(counts)
    figure = draw_setup(setup)
    expected = {text.get_text() for text in figure.legends[0].get_texts()}
    expected |= {axes.get_title() for axes in figure.axes} | {
        axes.get_xlabel() for axes in figure.axes
    }
    page = page_setup(setup)
    assert isinstance(page, SvgFigure)
    assert len(page.axes) == len(figure.axes)
    assert expected - {""} <= set(texts_of_svg(page))
    for axes, other in zip(page.axes, figure.axes, strict=True):
        assert axes.get_xlim() == pytest.approx(other.get_xlim())
        assert axes.get_ylim() == pytest.approx(other.get_ylim())
    for panel in panels(page):
        (x0, x1), (y0, y1) = panel.axes.get_xlim(), panel.axes.get_ylim()
        assert panel.width / panel.height == pytest.approx((x1 - x0) / (y1 - y0), rel=0.01)
        assert panel.width > 20.0


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 4, 6])
def test_panels_of_a_page_lie_side_by_side_within_the_picture(count: int) -> None:
    frames = [snapshot(2, step) for step in range(count)]
    figure = draw_frames(frames, "displacement", UNITS, page=True)
    root = ElementTree.fromstring(figure.svg())
    size = float(root.attrib["width"]), float(root.attrib["height"])
    boxes = []
    for panel in panels(figure):
        place = panel.element.attrib["transform"][10:-1].split()
        boxes.append((float(place[0]), float(place[1]), panel.width, panel.height))
    assert len(boxes) == count
    for x, y, width, height in boxes:
        assert x > 0.0
        assert y > 0.0
        assert x + width < size[0]
        assert y + height < size[1]
    for i, (x, y, width, height) in enumerate(boxes):
        for left, top, wide, high in boxes[i + 1 :]:
            assert x + width < left or left + wide < x or y + height < top or top + high < y
    titles = [text for text in texts_of_svg(figure) if text.startswith("step")]
    assert titles == [f"step {frame.step}, time {frame.time:.4g}" for frame in frames]


def test_a_surface_has_a_line_with_a_halo_and_a_legend() -> None:
    line = np.array([[0.0, 0.1], [0.5, 0.2], [1.0, 0.1]])
    cells = np.array([[0, 1], [1, 2]])
    shape = SurfaceShape("top", line, cells, {"normal": np.zeros((3, 2))})
    frames = [replace(snapshot(2, step), surfaces=(shape,)) for step in (0, 1)]
    figure = draw_frames(frames, "displacement", UNITS, initial=frames[0], page=True)
    assert {"surface: top", "surface at the start"} <= set(texts_of_svg(figure))
    first, second = panels(figure)
    assert first.dashed() == []
    assert len(second.dashed()) == 1
    halos = [p for p in second.element.iter() if p.attrib.get("stroke") == "white"]
    assert len(halos) == 2


def test_texts_of_the_user_are_no_markup() -> None:
    figure = SvgFigure((4.0, 3.0))
    axes: SvgAxes = figure.add_subplot()
    axes.set_title("</text><script>&amp;")
    axes.set_xlabel("a\nb")
    assert {"</text><script>&amp;", "a\nb"} <= set(texts_of_svg(figure))
    assert "<script" not in figure.svg()


@pytest.mark.slow
def test_the_report_of_a_plane_run_does_not_load_matplotlib(tmp_path: Path) -> None:
    write_run(tmp_path)
    (tmp_path / "model.json").write_text('{"analysis": {"kind": "plane_strain"}}')
    code = (
        "import sys; from tilth.report.html import write_report; "
        f"write_report({str(tmp_path)!r}); print('matplotlib' in sys.modules)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.split() == ["False"], result.stderr
