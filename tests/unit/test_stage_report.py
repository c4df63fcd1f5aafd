# SPDX-License-Identifier: BSD-3-Clause
"""Stages by name: pictures of the set-up, report, warnings, memory, progress."""

from __future__ import annotations

import io
import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from readings import long
from report_pages import html_of
from report_setups import UNITS, snapshot
from rich.console import Console
from staged_problems import KINDS, staged_entries

import tilth.analysis.setup_picture
from tilth import Model, check
from tilth.analysis.memory import UNDEFORMED, memory_of
from tilth.analysis.run import resume, run
from tilth.analysis.setup_picture import setup_figures, setup_of, write_report
from tilth.errors import BadInput
from tilth.output import Progress, read_history, read_log, read_results
from tilth.output.log import LogContents
from tilth.output.snapshot import SurfaceShape
from tilth.report.field_plots import draw_frames
from tilth.report.history_plots import history_charts, newton_charts
from tilth.report.setup_file import read_setup, read_staged_setup, write_setup
from tilth.report.stage_marks import MOST_NAMES, outputs_of_stages, spans_of_steps, stage_table
from tilth.report.stage_pages import PANELS, draw_stages
from tilth.report.stage_setups import StagedSetup
from tilth.report.stage_texts import stage_rows
from tilth.report.texts import save

NAMES = ["weight", "dig", "fill", "press", "wall away"]


def model_of(kind: str = "plane_strain", report: bool = False, **more: Any) -> Model:
    return Model.from_dict({**staged_entries(kind), "output": {"report": report}, **more})


def staged_setup(kind: str = "plane_strain") -> StagedSetup:
    setup = setup_of(model_of(kind))
    assert isinstance(setup, StagedSetup)
    return setup


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a complete run."""
    folder = tmp_path_factory.mktemp("finished")
    run(model_of(report=True), folder, quiet=True)
    return folder


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=pytest.mark.slow if kind == "3d" else ()) for kind in KINDS]
)
def test_each_stage_has_its_panel(kind: str, tmp_path: Path) -> None:
    setup, figures = setup_figures(model_of(kind))
    assert isinstance(setup, StagedSetup)
    assert list(figures) == [""]
    titles = [axes.get_title(loc="left") for axes in figures[""].axes]
    heads = [title.split("\n")[0] for title in titles if title]
    times = ["0 to 1", "1 to 3", "3 to 4", "4 to 5", "5 to 6"]
    expected = [f"{i + 1}  {NAMES[i]}  (time {times[i]})" for i in range(5)]
    assert heads == expected
    legend = [text.get_text() for text in figures[""].legends[0].get_texts()]
    assert sum(text.startswith("plate") for text in legend) == 1
    assert any("new in the stage" in text for text in legend)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        save(figures[""], tmp_path / "page.png")


def test_new_and_removed_soil_are_those_of_the_stage() -> None:
    setup = staged_setup()
    dig, fill, press = (setup.at(number) for number in (1, 2, 3))
    assert dig.removed is not None
    assert fill.is_new is not None
    pit, new = dig.removed, fill.position[fill.is_new]
    # the pit and the fill are the box from (0, 1.5) to (1, 2)
    for centre, half in ((pit.position, pit.half_lengths), (new, 0.125)):
        assert (centre - half).min(axis=0) == pytest.approx([0.0, 1.5])
        assert (centre + half).max(axis=0) == pytest.approx([1.0, 2.0])
    assert 4.0 * np.prod(pit.half_lengths, axis=1).sum() == pytest.approx(0.5)
    assert press.is_new is not None
    assert not press.is_new.any()
    (hatched,) = [each for each in _collections(setup, 1) if each.get_hatch()]
    assert len(hatched.get_paths()) == len(pit.position) == 8
    assert not [each for each in _collections(setup, 2) if each.get_hatch()]


def _collections(setup: StagedSetup, number: int) -> list[Any]:
    (figure,) = draw_stages(setup)
    return list(figure.axes[number].collections)


def test_what_acts_is_that_of_the_stage() -> None:
    setups = [stage.setup for stage in staged_setup().stages]
    acting = [[c.name for c in [*s.conditions, *s.surfaces]] for s in setups]
    assert acting == [["base", "side", "left"]] * 3 + [
        ["base", "side", "left", "plate"],
        ["base", "left"],
    ]
    assert [[load.name for load in s.loads] for s in setups] == [[], [], [], ["footing"], []]
    # 4 N/m^2 on 1 m, downwards
    assert setups[3].loads[0].force.sum(axis=0) == pytest.approx([0.0, -4.0])
    assert [s.cell_size.tolist() for s in setups] == [[0.5, 0.5]] * 4 + [[0.25, 0.25]]
    colours = {setup.colour_of("left", 99) for setup in setups}
    assert colours == {2}


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_the_file_keeps_all_stages(kind: str, tmp_path: Path) -> None:
    setup = staged_setup(kind)
    write_setup(tmp_path / "setup.npz", setup)
    again = read_staged_setup(tmp_path / "setup.npz")
    assert again is not None
    for number in range(5):
        one, other = setup.at(number), again.at(number)
        assert vars(one).keys() == vars(other).keys()
        for name in ("position", "half_lengths", "corners", "body_id", "is_new", "body_force"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        for name in ("conditions", "surfaces", "loads"):
            for a, b in zip(getattr(one, name), getattr(other, name), strict=True):
                for key, value in vars(a).items():
                    np.testing.assert_array_equal(value, getattr(b, key), key)
        assert [len(shape.cells) for shape in one.tracked] == [
            len(shape.cells) for shape in other.tracked
        ]
        assert (len(one.tracked[0].cells) > 0) == (number >= 2)


def test_without_stages_the_file_has_none(tmp_path: Path) -> None:
    entries = staged_entries()
    entries["bodies"].pop()
    entries |= {"stages": [], "schedule": {"steps": 1}}
    entries["loads"].pop()
    entries["track"].pop(2)
    setup = setup_of(Model.from_dict(entries))
    assert not isinstance(setup, StagedSetup)
    write_setup(tmp_path / "setup.npz", setup)
    assert read_staged_setup(tmp_path / "setup.npz") is None


def test_many_stages_are_on_several_pages() -> None:
    setup = staged_setup()
    many = replace(setup, stages=[*setup.stages] * 3)
    pages = [*draw_stages(many)]
    assert [len(page.axes) for page in pages] == [PANELS, 15 - PANELS]
    assert pages[1].get_suptitle() == "stages (2 of 2)"


@pytest.mark.slow
def test_the_report_shows_the_stages(finished: Path) -> None:
    page = (finished / "report.html").read_text()
    table = page[page.index("<h2>Stages</h2>") : page.index("<h2>Deformed states</h2>")]
    rows = [re.findall("<td>(.*?)</td>", row) for row in table.split("<tr>")[2:]]
    assert [row[1] for row in rows] == NAMES
    assert [row[2] for row in rows] == ["0 to 1", "1 to 3", "3 to 4", "4 to 5", "5 to 6"]
    assert [row[3] for row in rows] == ["2"] * 5
    history = read_history(finished / "history.csv")
    assert sum(int(row[4]) for row in rows) == history["iterations"].sum()
    assert [row[5] for row in rows][1:] == [*read_log(finished / "log.txt").released.values()]
    assert "2 dig (time 1 to 3); " in page
    assert read_setup(finished / "setup.npz", read_results(finished / "results.vtkhdf").snapshot(0))


@pytest.mark.parametrize(
    "until", [1.0, pytest.param(3.5, marks=pytest.mark.slow), *map(long, (0.5, 2.0, 4.0))]
)
def test_a_stopped_run_has_its_report(
    until: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(model_of(), tmp_path, quiet=True, until=until)
    monkeypatch.setattr(tilth.analysis.setup_picture, "setup_of", None)  # nothing is computed
    page = write_report(tmp_path).read_text()
    assert page.count("not reached") == 5 - sum(start < until for start in (0, 1, 3, 4, 5))
    assert "This run is incomplete" in page


def test_the_ends_of_all_stages_are_among_the_pictures() -> None:
    times = np.linspace(0.0, 10.0, 41)
    spans = [("one", 0.0, 0.5), ("two", 0.5, 7.25), ("three", 7.25, 10.0)]
    chosen = outputs_of_stages(times, spans, 6)
    assert len(chosen) == 6
    assert {0.0, 0.5, 7.25, 10.0} <= set(times[chosen])
    many = [(f"{i}", i / 4, (i + 1) / 4) for i in range(40)]
    chosen = outputs_of_stages(times, many, 6)
    assert len(chosen) <= MOST_NAMES
    assert (chosen[0], chosen[-1]) == (0, 40)
    assert outputs_of_stages(times[:2], [("one", 0.0, 0.25)], 6) == [0, 1]


@pytest.mark.parametrize("count", [1, 2, 5, 12, 13])
def test_plots_mark_the_stages(count: int) -> None:
    ends = np.concatenate([[0.0, 50.0], 50.0 + np.arange(1.0, count)])[: count + 1]
    spans = [(f"stage {i}", ends[i], ends[i + 1]) for i in range(count)]
    time = np.linspace(0.0, ends[-1], 9)
    history = {"step": np.arange(9.0), "time": time, "base [N]": time, "top [m]": time * np.nan}
    history["half [m]"] = np.where(time > 20.0, time, np.nan)
    charts = history_charts(history, "d", spans)
    assert [chart.y for chart in charts] == ["base [N]", "top [m]", "half [m]"]
    for chart in charts:
        assert chart.stages == spans
        assert chart.x == "time [d]"
        np.testing.assert_array_equal(chart.lines[0].y, history[chart.y])


def test_steps_of_stages_lie_between_their_marks() -> None:
    history = {"step": np.arange(5.0), "time": np.array([0.0, 1.0, 2.0, 2.5, 3.0])}
    history["iterations"] = np.array([0.0, 3.0, 4.0, 5.0, 6.0])
    spans = [("one", 0.0, 2.0), ("two", 2.0, 3.0)]
    assert spans_of_steps(history, spans) == [("one", 0.5, 2.5), ("two", 2.5, 4.5)]
    left, _ = newton_charts(
        history["step"][1:], history["iterations"][1:], [1.0], 4, spans_of_steps(history, spans)
    )
    assert left.stages == spans_of_steps(history, spans)
    table = stage_table(
        [{"name": "one"}, {"name": "two"}, {"name": "<b>"}], history, spans, LogContents()
    )
    assert table.rows[0] == ["1", "one", "0 to 2", "2", "7"]
    assert table.rows[1] == ["2", "two", "2 to 3", "2", "11"]
    assert "<td>&lt;b&gt;</td><td>not reached</td>" in html_of([table])


@pytest.mark.parametrize("dim", [2, 3])
def test_soil_without_a_value_is_grey(dim: int, tmp_path: Path) -> None:
    first, second = snapshot(dim, 0), snapshot(dim, 1)
    half = len(second.position) // 2
    nothing = {"suction": np.full(len(first.position), np.nan)}
    some = {"suction": np.where(np.arange(len(second.position)) < half, 3.0, np.nan)}
    empty = (SurfaceShape.empty("top", dim),)
    frames = [
        replace(first, point_fields={**first.point_fields, **nothing}, surfaces=empty),
        replace(second, point_fields={**second.point_fields, **some}, surfaces=empty),
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = draw_frames(
            frames, "suction", UNITS, titles=["one", "two"], initial=frames[0], show="domains"
        )
        save(figure, tmp_path / "frames.png")
    assert [axes.get_title() for axes in figure.axes[:2]] == ["one", "two"]
    assert figure.get_supxlabel() == "grey: no value for this soil"
    assert not figure.legends
    if dim == 2:
        colours = figure.axes[1].collections[0].get_facecolor()
        np.testing.assert_allclose(colours[half:], [[0.75, 0.75, 0.75, 1.0]] * half)
        assert (np.ptp(colours[:half, :3], axis=1) > 0.1).all()


def thin_fill(**more: Any) -> Model:
    """A model whose fill, which comes in the third stage, is thinner than a cell."""
    entries = staged_entries()
    entries["bodies"][3]["shape"]["upper"] = [1.0, 1.9]
    entries["loads"].pop()
    del entries["bodies"][3]["surface"]
    entries["stages"][3]["activate"].remove("footing")
    entries["stages"][4]["deactivate"].remove("footing")
    return Model.from_dict({**entries, **more})


def test_a_warning_names_its_stage_and_comes_once(tmp_path: Path) -> None:
    model = thin_fill()
    (text,) = [each for each in check(model).warnings if "thick" in each]
    assert text.startswith("bodies[3].shape: in the stage 'fill': the body 'fill' is only 0.8 of")
    run(model, tmp_path, quiet=True, until=4.5)
    resume(tmp_path, quiet=True)
    lines = (tmp_path / "log.txt").read_text().splitlines()
    assert [line for line in lines if "thick" in line] == [f"warning: {text}"]


@pytest.mark.parametrize("dim", [2, 3])
def test_rigid_bodies_are_drawn_in_each_stage(dim: int) -> None:
    """One is there in all stages, another one comes; both have one entry in the legend."""
    entries = staged_entries("3d" if dim == 3 else "plane_strain")
    up = "z" if dim == 3 else "y"
    across = [[0.0, 0.5]] * (dim - 2)
    entries["rigid_bodies"] = [
        {
            "name": name, "centre": [x, *(0.25 for _ in across), 2.5],
            "geometry": {
                "type": "box", "lower": [x - 0.3, *(a for a, _ in across), 2.1],
                "upper": [x + 0.3, *(b for _, b in across), 2.9], "soil": "outside",
            },
            "contact": {"normal": "unilateral", "tangential": "smooth"},
            "displacement": dict.fromkeys("xyz"[:dim], 0.0) | {up: -0.05},
            "rotation": dict.fromkeys("xyz", 0.0) if dim == 3 else 0.0,
        }
        for name, x in (("raft", 2.0), ("late", 2.7))
    ]  # fmt: skip
    entries["stages"] = entries["stages"][:2]
    entries["stages"][1]["activate"] = ["late"]
    entries["boundaries"] = entries["boundaries"][:-1]
    entries["loads"], entries["bodies"] = entries["loads"][:1], entries["bodies"][:3]
    entries["track"] = entries["track"][:2]
    setup, figures = setup_figures(Model.from_dict(entries))
    assert isinstance(setup, StagedSetup)
    assert [[s.name for s in each.setup.surfaces] for each in setup.stages] == [
        ["raft"], ["raft", "late"],
    ]  # fmt: skip
    texts = [text.get_text() for legend in figures[""].legends for text in legend.get_texts()]
    assert [sum(name in text for text in texts) for name in ("raft", "late")] == [1, 1]


def test_check_lists_the_stages() -> None:
    entries = staged_entries()
    entries["stages"][3]["release"] = [[0, 0], [0.5, 1]]
    entries["stages"][3]["factors"] = {"footing": [[0, 0], [0.5, 2], [1, 1]]}
    rows = [*stage_rows(Model.from_dict(entries))]
    assert [heading for heading, text in rows if "steps from" in text] == [
        f"stage {number}" for number in range(1, 6)
    ]
    text = dict.fromkeys(text for _, text in rows)
    for line in (
        "dig: 2 steps from time 1 to 3, adaptive; 2 outputs",
        "deactivates the body pit",
        "resets displacement to 0",
        "activates the boundary plate, the load footing",
        "exchanges the material soil for firm",
        "factors: gravity 1; footing 0 at 0, 2 at 0.5, 1 at 1; plate 0 to 1",
        "releases forces that are out of balance by the shares 0 at 0, 1 at 0.5",
        "factors: gravity 1; footing 1 to 0",
        "has a grid with cells of 0.25 m",
    ):
        assert line in text


def test_check_goes_through_all_stages() -> None:
    result = check(model_of(units={"force": "kN", "stress": "kPa", "mass": "t"}))
    assert result.points == 96
    # its last grid has one point in a cell
    assert [text[: text.index(" are")] for text in result.warnings] == [
        f"stages[4].grid.cell_size: the points of {name!r}" for name in ("ground", "bank", "fill")
    ]
    entries = staged_entries()
    box = {"type": "box", "lower": [7.0, 0.0], "upper": [8.0, 1.0]}
    entries["stages"][3]["excavate"] = [{"body": "ground", "shape": box}]
    with pytest.raises(BadInput, match="no soil of 'ground' is in this region"):
        check(Model.from_dict(entries))


def test_removed_soil_needs_no_memory_later() -> None:
    entries = staged_entries()
    both = memory_of(Model.from_dict(entries))
    # with the fill instead of the pit there are as many points as at the start
    assert both.points == pytest.approx(96)
    del entries["stages"][1]["deactivate"]
    entries["bodies"][3]["shape"] = {"type": "box", "lower": [0.0, 2.0], "upper": [1.0, 2.5]}
    entries["loads"].pop()
    for stage in entries["stages"][3:]:
        names = stage["activate" if "activate" in stage else "deactivate"]
        names.remove("footing")
    stacked = memory_of(Model.from_dict(entries))
    assert stacked.points == pytest.approx(104)
    assert stacked.parts["the material points"] > both.parts["the material points"]
    # the undeformed points of all bodies, twice: one stage exchanges materials
    assert stacked.parts[UNDEFORMED] == pytest.approx(both.parts[UNDEFORMED])
    assert 2 * 104 * 8 * 40 < both.parts[UNDEFORMED] < 2 * 104 * 8 * 60


def test_progress_names_the_stage() -> None:
    text = io.StringIO()
    console = Console(file=text, force_terminal=True, width=140, legacy_windows=False)
    progress = Progress(2.0, 100, console=console)
    progress.stage("dig [1]", 1, 2, 100)
    with progress:
        progress.step_done(1, 1.0, 4)
        progress.stage("fill", 2, 2, 1250)
        progress.step_done(2, 2.0, 4)
    for words in ("stage 1/2 dig [1]", "stage 2/2 fill", "1,250 points"):
        assert words in text.getvalue()
    plain = io.StringIO()
    progress = Progress(2.0, 100, console=Console(file=plain))
    progress.stage("dig", 1, 2, 100)
    with progress:
        progress.step_done(2, 2.0, 4)
    assert plain.getvalue().startswith("stage 1/2 dig, step 2, time 2/2, 4 Newton iterations")
