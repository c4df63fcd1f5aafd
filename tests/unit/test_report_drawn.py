# SPDX-License-Identifier: BSD-3-Clause
"""What a real browser makes of a report: curves, pictures, paper, no JavaScript, strange names."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_browser import complaints, opened
from report_setups import UNITS, make_setup, snapshot

from tilth.output import HistoryWriter, ResultsWriter, RunLog, read_history
from tilth.report.html import write_report
from tilth.report.setup_view import FILLS

pytestmark = pytest.mark.slow
MODEL = {"title": "A run", "analysis": {"kind": "plane_strain"}, "output": {}}
HOSTILE = "<script>window.hacked = true</script><img src=x onerror=hacked()>"

PIXEL = """
const pixel = (canvas, x, y) => {
  const { width, height } = canvas.getBoundingClientRect();
  const at = [x * canvas.width / width, y * canvas.height / height].map(Math.round);
  return Array.from(canvas.getContext("2d").getImageData(...at, 1, 1).data).slice(0, 3);
};
const middle = (scene) => {
  const mark = new Tilth.Marks(scene.canvas.getContext("2d"), scene);
  return pixel(scene.canvas, ...mark.at(...arguments[0]));
};
"""


def write_run(folder: Path, dim: int = 2, name: str = "settlement") -> None:
    results = ResultsWriter(folder / "results.vtkhdf", title=f"A {name}", units=UNITS)
    history = HistoryWriter(folder / "history.csv", [(name, "m")])
    log = RunLog(folder / "log.txt")
    for step in range(5):
        results.append(snapshot(dim, step))
        history.append(step, 0.25 * step, 3 * (step > 0), [0.5 * step**2])
        if step:
            log.step(step, 0.25 * step, 0.25, [1.0, 1e-4, 1e-9])
    log.warning(f"sand & {name}")
    log.finish("", {}, "none")
    for file in (results, history, log):
        file.close()


def near(colour: Sequence[float], expected: Sequence[float]) -> bool:
    return bool(np.abs(np.subtract(colour, expected)).max() <= 3)


@pytest.mark.parametrize("dark", [False, True])
def test_curves_are_drawn_with_the_numbers_of_the_history(tmp_path: Path, dark: bool) -> None:
    write_run(tmp_path)
    page = write_report(tmp_path, MODEL)
    table = read_history(tmp_path / "history.csv")
    with opened(page, dark=dark) as driver:
        found = driver.execute_script(
            "const { chart, plot, place } = Tilth.charts[0], [line] = chart.lines;"
            "const canvas = place.querySelector('canvas'), context = canvas.getContext('2d');"
            "const colours = Array.from(line.x, (x, i) => context.getImageData("
            "  plot.valToPos(x, 'x', true), plot.valToPos(line.y[i], 'y', true), 1, 1).data)"
            "  .map((each) => Array.from(each));"
            "const between = 0.5 * (plot.valToPos(line.x[0], 'x', true)"
            "  + plot.valToPos(line.x[1], 'x', true));"
            "const away = Array.from(context.getImageData(between, plot.bbox.top + 3, 1, 1).data);"
            "return { x: Array.from(line.x), y: Array.from(line.y), colours, away,"
            "  sharp: canvas.width / canvas.clientWidth,"
            "  labels: Array.from(place.parentElement.querySelectorAll('.label'),"
            "    (each) => each.textContent), named: place.getAttribute('aria-label') }"
        )
        driver.execute_script(
            "const { plot } = Tilth.charts[0];"
            "plot.setCursor({ left: plot.valToPos(0.5, 'x'), top: plot.valToPos(2.0, 'y') });"
        )
        tip = driver.execute_script("return Tilth.charts[0].tip.textContent")
        assert complaints(driver) == []
    assert found["x"] == list(table["time"])
    assert found["y"] == list(table["settlement [m]"])
    curve = [142, 197, 255, 255] if dark else [29, 53, 87, 255]
    assert found["colours"] == [curve] * 5
    assert found["away"][3] < 255
    assert found["labels"] == ["settlement [m]", "time [d]"]
    assert found["named"] == "settlement [m] over time"
    assert found["sharp"] == pytest.approx(2.0, rel=0.01)
    assert tip == "0.5, 2"


@pytest.mark.parametrize("dim", [2, 3])
def test_set_up_and_states_are_drawn_where_the_soil_is(tmp_path: Path, dim: int) -> None:
    write_run(tmp_path, dim)
    setup = replace(make_setup((6, 4, 3)[:dim]), loads=[], conditions=[], body_force=None)
    page = write_report(tmp_path, MODEL, setup=setup)
    inside = [*(0.5 * np.ptp(setup.position, axis=0) + 0.05)]
    with opened(page) as driver:
        run = driver.execute_script
        assert run("return Tilth.views[0].scenes.length") == (1 if dim == 2 else 4)
        drawn = run(f"{PIXEL} Tilth.views[0].scenes[0].dots = false;"
                    "Tilth.views[0].scenes[0].grid = []; Tilth.views[0].redraw();"
                    "return middle(Tilth.views[0].scenes[0])", inside)  # fmt: skip
        sky = run(f"{PIXEL} const {{ canvas }} = Tilth.views[0].scenes[0];"
                  "return pixel(canvas, canvas.clientWidth - 3, 3)", inside)  # fmt: skip
        shades = run(
            f"{PIXEL} const found = [];"
            "for (const index of [0, 4]) { await Tilth.view.show(index);"
            "Tilth.view.scene.render(); found.push(middle(Tilth.view.scene)); }"
            "return found", inside if dim == 2 else [1.0, 0.1, 1.0],
        )  # fmt: skip
        told = run("return Tilth.element('view-0').querySelector('canvas').ariaLabel")
        assert complaints(driver) == []
    if dim == 2:
        assert near(drawn, 255.0 * FILLS[0])
    else:
        assert not near(drawn, [255, 255, 255])
    assert near(sky, [255, 255, 255])
    assert not near(shades[0], shades[1]), "the colours are those of the displacement"
    assert told.startswith("Set-up")


def test_on_paper_all_is_drawn_light_and_without_controls(tmp_path: Path) -> None:
    write_run(tmp_path)
    page = write_report(tmp_path, MODEL, setup=make_setup((6, 4)))
    with opened(page, (1200, 900), dark=True) as driver:
        run = driver.execute_script
        before = run("return Tilth.charts[0].place.querySelector('canvas').width")
        run("dispatchEvent(new Event('beforeprint'))")
        media = [{"name": "prefers-color-scheme", "value": "dark"}]
        size = {"width": 680, "height": 1009, "deviceScaleFactor": 1, "mobile": False}
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print", "features": media})
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        seen: dict[str, Any] = run(
            "const all = Array.from(document.body.querySelectorAll('*'), (element) => [element,"
            "getComputedStyle(element), element.getBoundingClientRect()])"
            ".filter(([, , box]) => box.width > 0 && box.height > 0);"
            "const light = (text) => { const [r, g, b, a = 1] = text.match(/[\\d.]+/g).map(Number);"
            "return a === 0 || Math.min(r, g, b) > 200; };"
            "const controls = 'button, select, input, nav, details';"
            "const pictures = Array.from(document.querySelectorAll('.paper .picture'));"
            "const filled = (canvas) => { const { width, height } = canvas;"
            "const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);"
            "let count = 0; for (let at = 0; at < data.length; at += 4)"
            "count += data[at] + data[at + 1] + data[at + 2] < 500;"
            "return count / (width * height); };"
            "const { plot, chart } = Tilth.charts[0], [line] = chart.lines;"
            "const ink = Tilth.charts[0].place.querySelector('canvas').getContext('2d')"
            ".getImageData(plot.valToPos(line.x[2], 'x', true),"
            "plot.valToPos(line.y[2], 'y', true), 1, 1).data;"
            "return { controls: all.filter(([e]) => e.matches(controls)).map(([e]) => e.outerHTML),"
            "dark: all.filter(([, style]) => !light(style.backgroundColor))"
            ".map(([e]) => e.outerHTML), ink: Array.from(ink), shares: pictures.map(filled),"
            "canvases: all.filter(([e]) => e.tagName === 'CANVAS')"
            ".map(([, , box]) => [box.left, box.right, box.height]),"
            "alone: all.filter(([e, style]) => /^H\\d$/.test(e.tagName)"
            "&& style.breakAfter !== 'avoid').length,"
            "wide: document.documentElement.scrollWidth }"
        )
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": media})
        size |= {"width": 1200, "height": 900}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        run("dispatchEvent(new Event('afterprint'))")
        after = run("return Tilth.charts[0].place.querySelector('canvas').width")
        pdf = base64.b64decode(driver.execute_cdp_cmd("Page.printToPDF", {})["data"])
        assert complaints(driver) == []
    assert seen["controls"] == []
    assert seen["dark"] == []
    assert seen["ink"] == [29, 53, 87, 255]
    assert len(seen["shares"]) == 5, "the outputs"
    assert min(seen["shares"]) > 0.1, "soil is there in all of them"
    for left, right, height in seen["canvases"]:
        assert left >= 0
        assert right <= 680
        assert height <= 1009
    assert seen["alone"] == 0
    assert seen["wide"] <= 680
    assert after == before
    assert pdf.startswith(b"%PDF")
    # What the browser's own event draws: set-up and five outputs; charts are no images there.
    assert pdf.count(b"/Subtype /Image") >= 6


def test_without_javascript_there_are_the_tables(tmp_path: Path) -> None:
    write_run(tmp_path)
    page = write_report(tmp_path, MODEL, setup=make_setup((6, 4)))
    with opened(page) as driver:
        do = driver.execute_cdp_cmd
        do("Emulation.setScriptExecutionDisabled", {"value": True})
        do("Page.navigate", {"url": page.resolve().as_uri()})
        root = do("DOM.getDocument", {"depth": 1})["root"]["nodeId"]

        def boxes(selector: str) -> list[bool]:
            found = do("DOM.querySelectorAll", {"nodeId": root, "selector": selector})["nodeIds"]
            seen = []
            for node in found:
                try:
                    box = do("DOM.getBoxModel", {"nodeId": node})["model"]
                    seen.append(box["height"] > 0)
                except Exception:  # it has no layout
                    seen.append(False)
            return seen

        assert boxes("canvas, .figures") == [False] * len(boxes("canvas, .figures"))
        tables = boxes("details.numbers table")
        assert len(tables) == 4
        assert all(tables)
        assert any(boxes("noscript p"))
        text = page.read_text(encoding="utf-8")
    assert "<td>0.5</td><td>2</td>" in text, "a row of the tracked quantities"
    assert "<td>step 2, time 0.5</td>" in text
    assert "corner" in text


def test_strange_names_are_text_everywhere(tmp_path: Path) -> None:
    write_run(tmp_path, name=HOSTILE)
    setup = make_setup((6, 4))
    named = replace(
        setup,
        body_names=[HOSTILE],
        conditions=[replace(each, name=HOSTILE) for each in setup.conditions],
    )
    page = write_report(tmp_path, {**MODEL, "bodies": [{"name": HOSTILE}]}, setup=named)
    text = page.read_text(encoding="utf-8")
    assert HOSTILE not in text
    assert "<script>window" not in text
    with opened(page) as driver:
        seen = driver.execute_script("return document.body.innerText")
        assert driver.execute_script("return window.hacked === undefined")
        assert driver.execute_script("return document.images.length") == 0
        assert complaints(driver) == []
    assert seen.count(HOSTILE) >= 5
