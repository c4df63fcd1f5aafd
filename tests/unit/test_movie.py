# SPDX-License-Identifier: BSD-3-Clause
"""Movies: frames, limits and colours over all outputs, and what is refused."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from readings import long
from report_setups import UNITS, make_setup, snapshot

from tilth.errors import BadInput
from tilth.output import HistoryWriter, ResultsWriter
from tilth.plot.field import field_figure
from tilth.plot.movie import write_movie
from tilth.plot.picture import FieldPicture, Scene
from tilth.plot.run import PlottedRun
from tilth.plot.views import PlaneView
from tilth.report.setup_data import Surface


def run_at(folder: Path, dim: int = 2, outputs: int = 3) -> Path:
    folder.mkdir()
    writer = ResultsWriter(folder / "results.vtkhdf", title="block", units=UNITS)
    history = HistoryWriter(folder / "history.csv", [("load", "N")])
    for step in range(outputs):
        writer.append(snapshot(dim, step))
        history.append(step, 0.25 * step, 1, [10.0 * step])
    writer.close()
    history.close()
    return folder


@pytest.mark.parametrize("ending", ["gif", long("webp")])
def test_a_movie_has_one_frame_for_each_output(tmp_path: Path, ending: str) -> None:
    from PIL import Image

    done: list[tuple[int, int]] = []
    run, path = run_at(tmp_path / "run"), tmp_path / f"x.{ending}"
    count = write_movie(
        run,
        "displacement",
        path,
        fps=5.0,
        history="load",
        progress=lambda *each: done.append(each),
    )
    assert count == 3
    assert done == [(1, 3), (2, 3), (3, 3)]
    with Image.open(path) as movie:
        assert movie.n_frames == 3  # type: ignore[attr-defined]
        frames = []
        for number in range(3):
            movie.seek(number)
            movie.load()
            assert movie.info["duration"] == 200
            frames.append(np.asarray(movie.convert("RGB"), dtype=int))
    assert np.abs(frames[2] - frames[0]).max() > 100


def test_a_run_in_space_and_a_section_of_it_are_drawn(tmp_path: Path) -> None:
    run = run_at(tmp_path / "run", dim=3, outputs=2)
    assert write_movie(run, "displacement", tmp_path / "x.gif") == 2
    figure = field_figure(run, "displacement_x", section="x=1.5")
    axes, bar = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("y [m]", "z [m]")
    assert axes.get_title() == "x = 1.5 m, time 0.25 d"
    assert bar.get_ylabel() == "Displacement x [m]"
    with pytest.raises(BadInput, match="cuts no soil") as error:
        field_figure(run, "displacement_x", section="x=99")
    assert error.value.remedy == "the points are at x from 0.55 to 6.05"


@pytest.mark.slow
def test_an_mp4_file_has_all_frames(tmp_path: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "x.mp4"
    write_movie(run_at(tmp_path / "run"), "displacement", path, fps=5.0)
    assert ffmpeg.count_frames_and_secs(str(path))[0] == 3


@pytest.mark.slow
def test_limits_and_colours_are_those_of_all_outputs(tmp_path: Path) -> None:
    run = PlottedRun.of(run_at(tmp_path / "run"))
    view = PlaneView(run, "field")
    scene = Scene.of(run, view, "displacement_x", range(3))
    picture = FieldPicture(run, view, "displacement_x", scene)
    last = snapshot(2, 2)
    assert scene.scale.low == pytest.approx(0.0)
    assert scene.scale.high == pytest.approx(last.point_fields["displacement"][:, 0].max())
    for step in range(3):
        picture.draw(run.results.snapshot(step))
        assert picture.axes.get_xlim()[0] <= 0.0
        assert picture.axes.get_xlim()[1] >= last.position[:, 0].max() + 0.5
        assert picture.axes.get_title() == f"time {0.25 * step:g} d"
    width, height = picture.axes.get_position().bounds[2:]
    low, high = scene.limits
    size = picture.figure.get_size_inches()
    assert height * size[1] / (width * size[0]) == pytest.approx((high - low)[1] / (high - low)[0])


def test_a_long_body_is_to_scale_with_the_colour_bar_below(tmp_path: Path) -> None:
    (folder := tmp_path / "run").mkdir()
    writer = ResultsWriter(folder / "results.vtkhdf", title="slope", units=UNITS)
    long = snapshot(2, 0)
    grown = long.position * [16.0, 1.0]
    writer.append(replace(long, position=grown, point_fields={**long.point_fields}))
    writer.close()
    run = PlottedRun.of(folder)
    view = PlaneView(run, "points")
    scene = Scene.of(run, view, "cauchy_stress_yy", [0])
    picture = FieldPicture(run, view, "cauchy_stress_yy", scene)
    picture.draw(run.results.snapshot(0))
    picture.finish()
    body, bar = (axes.get_position().bounds for axes in picture.figure.axes)
    size = picture.figure.get_size_inches()
    low, high = scene.limits
    ratio = (high - low)[1] / (high - low)[0]
    assert ratio < 0.06
    assert body[3] * size[1] / (body[2] * size[0]) == pytest.approx(ratio, rel=1e-6)
    assert bar[1] + bar[3] < body[1]
    assert body[2] * size[0] > 6.5


@pytest.mark.slow
def test_boundaries_are_where_they_are_at_that_time(tmp_path: Path) -> None:
    plate = Surface(
        name="plate",
        kind="contact",
        corner=np.array([[[1.0, 4.0], [2.0, 4.0]]]),
        normal=np.array([[0.0, -1.0]]),
        displacement=np.array([[0.0, -0.4]]),
        bounded=True,
    )
    run = replace(
        PlottedRun.of(run_at(tmp_path / "run")),
        setup=replace(make_setup((6, 4)), surfaces=[plate]),
        moving={"plate displacement_y [m]": np.array([0.0, -0.1, -0.4])},
        declared={
            "boundaries": [
                {"name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "fixed"}
            ]
        },
    )
    view = PlaneView(run, "field")
    scene = Scene.of(run, view, "displacement", range(3))
    picture = FieldPicture(run, view, "displacement", scene)
    (low, high) = scene.limits
    for step, height in enumerate((4.0, 3.9, 3.6)):
        picture.draw(run.results.snapshot(step))
        lines = [each for each in picture.axes.collections if isinstance(each, LineCollection)]
        drawn = np.concatenate([np.array(line.get_segments()) for line in lines])
        np.testing.assert_allclose(
            drawn, [[[1.0, height], [2.0, height]], [[low[0], 0.0], [high[0], 0.0]]]
        )
    (legend,) = picture.figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["boundaries: plate, base"]
    picture.finish()
    soil = picture.axes.get_window_extent()
    assert legend.get_window_extent().y0 > soil.y1


def test_what_cannot_be_drawn_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = run_at(tmp_path / "run", outputs=1)
    for ask, remedy in (
        ({"path": "x.avi"}, ".mp4, .gif, .webp"),
        ({"path": "x.gif", "field": "displacements"}, "did you mean displacement"),
        ({"path": "x.gif", "fps": 0.0}, "from 0.01 to 60"),
        ({"path": "x.gif", "history": "loads"}, "did you mean load"),
        ({"path": "x.gif", "section": "x=1"}, "leave out"),
        ({"path": "x.gif", "scale": "frame", "values": (0.0, 1.0)}, "leave out"),
    ):
        options = {"field": "displacement", **ask, "path": tmp_path / str(ask["path"])}
        with pytest.raises(BadInput) as error:
            write_movie(run, **options)  # type: ignore[arg-type]
        assert remedy in error.value.remedy
    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(BadInput, match="needs the program ffmpeg") as error:
        write_movie(run, "displacement", tmp_path / "x.mp4")
    assert "imageio-ffmpeg" in error.value.remedy
    assert not list(tmp_path.glob("x.*"))
