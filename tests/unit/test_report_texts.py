# SPDX-License-Identifier: BSD-3-Clause
"""Pictures, page and tables of a model in which every text is strange: drawn as they are."""

import io
import warnings
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text
from report_setups import make_setup, snapshot
from rich.console import Console
from small_problems import block_entries, rollers
from test_report import read_page

from tilth import Model
from tilth.analysis.memory import memory_of
from tilth.output import HistoryWriter, ResultsWriter, RunLog, SurfaceShape, read_history
from tilth.report.field_plots import draw_frames
from tilth.report.html import write_report
from tilth.report.setup import Condition, Load, Setup, Surface, draw_setup
from tilth.report.setup_file import read_setup, write_setup
from tilth.report.summary import print_summary
from tilth.report.texts import on_lines, save

pytestmark = pytest.mark.slow

FOREIGN = "\N{HEBREW LETTER ALEF}\N{ARABIC LETTER BEH} \u7c98 e" + 4 * "\N{COMBINING ACUTE ACCENT}"
STRANGE = {
    "underscore": "_$\\frac{a$ [red]b[/] \N{GRINNING FACE} </b>&amp--><",
    "mathematics": f"$x_1$ {FOREIGN} {{a}} %s :bug:\\",
}
"""Each has what mathematics, markup of terminal or page, format strings and fonts stumble over."""
UNIT = "$m$"


def strange_setup(text: str, dim: int) -> Setup:
    plain = make_setup((6, 4, 3)[:dim])
    corner = np.zeros((1, dim, dim)) + np.eye(dim)
    surface = Surface(text, "roller", corner, np.eye(dim)[-1:])
    far = Surface(text + " far", "fixed", corner + 1e3, np.eye(dim)[-1:])
    return replace(
        plain,
        title=text,
        length_unit=UNIT,
        force_unit=UNIT,
        body_names=[text],
        conditions=[replace(each, name=text) for each in plain.conditions],
        loads=[Load(f"point force on {text}", plain.loads[0].position, plain.loads[0].force)],
        surfaces=[surface, far],
        tracked=(tracked(text, dim),),
    )


def tracked(name: str, dim: int) -> SurfaceShape:
    position = 0.1 + np.eye(dim)[: 2 if dim == 2 else 3]
    fields = {"normal": np.tile(np.eye(dim)[-1], (dim, 1)), "arc_length": np.zeros(dim)}
    return SurfaceShape(name, position, np.arange(dim)[None], fields)


def texts_of(figure: Figure) -> list[str]:
    """All texts of a figure after it was drawn into SVG, which must be well formed."""
    picture = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        save(figure, picture, format="svg")
        save(figure, io.BytesIO(), format="png", dpi=40)
    ElementTree.fromstring(picture.getvalue())
    found = [text for text in figure.findobj(Text) if text.get_visible()]
    return [text.get_text() for text in found if not text.get_parse_math()]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("text", STRANGE.values(), ids=STRANGE)
def test_a_set_up_is_drawn_with_its_texts_as_they_are(text: str, dim: int) -> None:
    found = texts_of(draw_setup(strange_setup(text, dim)))
    points = 24 if dim == 2 else 72
    assert text in found  # the title
    assert f"{text}\n{points} points" in found
    for start in (f"{text}\nroller", f"{text}\nimplicit", f"{text}\ntracked"):
        assert any(each.startswith(start) for each in found)
    assert any(each.startswith(on_lines(f"point force on {text}", 40)) for each in found)
    assert any(f"{text} far lies outside" in each for each in found)
    assert f"x [{UNIT}]" in found


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("text", STRANGE.values(), ids=STRANGE)
def test_results_are_drawn_with_their_texts_as_they_are(text: str, dim: int) -> None:
    state = replace(snapshot(dim), surfaces=(tracked(text, dim),))
    found = texts_of(draw_frames([state], "displacement", {"length": text}))
    assert on_lines(f"surface: {text}", 40) in found
    assert f"x [{text}]" in found
    assert f"Displacement magnitude [{text}]" in [each.replace("\n", " ") for each in found]


@pytest.mark.parametrize("dim", [2, 3])
def test_the_longest_texts_leave_space_for_the_picture(dim: int) -> None:
    setup = strange_setup(100 * "W", dim)
    figure = draw_setup(replace(setup, title=200 * "W", length_unit=40 * "W"))
    texts_of(figure)
    for axes in figure.axes:
        assert min(axes.get_window_extent().size) > 0.1 * min(figure.bbox.size)
    state = replace(snapshot(dim), surfaces=(tracked(100 * "W", dim),))
    texts_of(draw_frames([state] * 4, "displacement", {"length": 40 * "W"}))


@pytest.mark.parametrize("dim", [2, 3])
def test_a_stored_set_up_is_drawn_as_before(dim: int, tmp_path: Path) -> None:
    setup = strange_setup(STRANGE["underscore"], dim)
    moving = replace(setup.surfaces[0], displacement=np.full((1, dim), 0.1), bounded=True)
    setup = replace(setup, surfaces=[moving, setup.surfaces[1]])
    state = snapshot(dim, 0)
    initial = replace(
        state,
        position=setup.position,
        body_id=setup.body_id,
        point_fields={"domain": setup.half_lengths},
        surfaces=tuple(setup.tracked),
    )
    write_setup(tmp_path / "setup.npz", setup)
    again = read_setup(tmp_path / "setup.npz", initial)
    assert [type(part) for part in again.conditions] == [Condition] * 3
    pictures = [io.BytesIO(), io.BytesIO()]
    for each, picture in zip((setup, again), pictures, strict=True):
        save(draw_setup(each), picture, format="png")
    assert pictures[0].getvalue() == pictures[1].getvalue()


@pytest.mark.parametrize("text", STRANGE.values(), ids=STRANGE)
def test_the_page_shows_the_texts_as_they_are(text: str, tmp_path: Path) -> None:
    units = {"length": text, "force": text, "stress": text, "mass": text, "time": text}
    results = ResultsWriter(tmp_path / "results.vtkhdf", title=text, units=units)
    results.append(replace(snapshot(2, 0), surfaces=(tracked(text, 2),)))
    history = HistoryWriter(tmp_path / "history.csv", [(text, text)])
    history.append(0, 0.0, 0, [1.0])
    log = RunLog(tmp_path / "log.txt")
    log.header(version="0.1.0", title=text, threads=2, points=24, cells=6)
    log.warning(f"the body {text}")
    log.finish(f"stopped at {text}", {}, "none")
    for file in (results, history, log):
        file.close()
    summary = {"title": text, "materials": {text: {"model": "a"}}, "bodies": [{"name": text}]}
    page = read_page(write_report(tmp_path, summary, setup=strange_setup(text, 2)))
    assert page.text.count(text) >= 7
    assert f"{text} [{text}]" in read_history(tmp_path / "history.csv")


@pytest.mark.parametrize("text", STRANGE.values(), ids=STRANGE)
def test_the_terminal_shows_the_texts_as_they_are(text: str) -> None:
    entries = block_entries("plane_strain", "gimp", boundaries=rollers("plane_strain"))
    entries["title"] = text
    entries["bodies"][0]["name"] = text
    entries["boundaries"][0]["name"] = text
    printed = io.StringIO()
    model = Model.from_dict(entries)
    screen = Console(file=printed, width=200, force_terminal=True)
    print_summary(model, make_setup((4, 4)), memory_of(model), None, screen)
    for shown in (text, f"{text}: box of soil", f"{text}: roller"):
        assert shown in printed.getvalue()
