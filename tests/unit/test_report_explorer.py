# SPDX-License-Identifier: BSD-3-Clause
"""The interactive part of the report: its numbers, and what a real browser makes of them."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_browser import complaints, opened
from report_pages import data_of
from report_setups import UNITS, make_setup, snapshot

from tilth.output import HistoryWriter, ResultsWriter, RunLog, read_results
from tilth.report.explorer import body as body_module
from tilth.report.explorer import curves as curves_module
from tilth.report.explorer.body import pack_body
from tilth.report.explorer.curves import pack_curves
from tilth.report.explorer.packing import Blobs
from tilth.report.fields import field_values
from tilth.report.html import write_report

pytestmark = pytest.mark.slow
MODEL = {"title": "A run", "analysis": {"kind": "plane_strain"}, "output": {}}


def write_run(folder: Path, dim: int, outputs: int = 5) -> None:
    results = ResultsWriter(folder / "results.vtkhdf", title="A <run>", units=UNITS)
    history = HistoryWriter(folder / "history.csv", [("settlement", "m")])
    log = RunLog(folder / "log.txt")
    for step in range(outputs):
        results.append(snapshot(dim, step))
        history.append(step, 0.25 * step, 3 * (step > 0), [0.5 * step])
    log.finish("", {}, "none")
    for file in (results, history, log):
        file.close()


def write_random_results(folder: Path, points: int, outputs: int = 5) -> None:
    results = ResultsWriter(folder / "results.vtkhdf", title="Random", units=UNITS)
    numbers = np.random.default_rng(2)
    for step in range(outputs):
        small = snapshot(2, step)
        fields = {
            name: numbers.uniform(0.5, 1.0, size=(points, *values.shape[1:]))
            for name, values in small.point_fields.items()
        }
        place = numbers.uniform(size=(points, 2))
        ids, bodies = np.arange(points), np.zeros(points, dtype=np.int64)
        results.append(
            replace(small, position=place, point_id=ids, body_id=bodies, point_fields=fields)
        )
    results.close()


def restored(blobs: Blobs, stored: dict[str, Any]) -> np.ndarray[Any, Any]:
    """Returns the numbers of a blob: decoded by the rule, not by the program's own functions."""
    content = np.frombuffer(zlib.decompress(base64.b64decode(blobs.texts[stored["blob"]])), "u1")
    low, high = content.reshape(2, -1).astype(float)
    place = low + 256.0 * high
    values = stored["low"] + place / 65534.0 * (stored["high"] - stored["low"])
    return np.where(place == 65535, np.nan, values)


def test_numbers_in_the_page_are_those_of_the_results_to_half_a_step() -> None:
    values = np.append(np.random.default_rng(1).normal(size=999), np.nan)
    blobs = Blobs()
    found = restored(blobs, blobs.rounded(values))
    assert np.isnan(found[-1])
    step = (np.nanmax(values) - np.nanmin(values)) / 65534.0
    assert np.nanmax(np.abs(found - values)) <= 0.5001 * step
    assert (restored(blobs, blobs.rounded(np.full(7, 3.25))) == 3.25).all()
    assert blobs.rounded(values)["blob"] == 0, "equal numbers are stored once"


def packed_or_not(
    folder: Path, budget: int, boundaries: Sequence[dict[str, Any]] = ()
) -> tuple[dict[str, Any], Blobs] | None:
    results = read_results(folder / "results.vtkhdf")
    return pack_body(
        results, "displacement", budget, axis_names="xyz",
        stage_at=lambda time: "", boundaries=lambda step: list(boundaries),
    )  # fmt: skip


def packed(folder: Path, budget: int, **more: Any) -> tuple[dict[str, Any], Blobs]:
    found = packed_or_not(folder, budget, **more)
    assert found
    assert found[1].size + len(json.dumps(found[0]["frames"], separators=(",", ":"))) <= budget
    return found


def test_less_room_leaves_out_points_then_fields_then_outputs_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_random_results(tmp_path, points=3000)
    whole, blobs = packed(tmp_path, 10**7)
    assert whole["notes"] == []
    assert [frame["count"] for frame in whole["frames"]] == [3000] * 5
    monkeypatch.setattr(body_module, "FEWEST_POINTS", 1000)
    fewer, small = packed(tmp_path, blobs.size // 2)
    assert small.size <= blobs.size // 2
    assert 1000 <= fewer["frames"][0]["count"] < 2000
    assert len({frame["id"] for frame in fewer["frames"]}) == 1, "the same points at all outputs"
    assert (len(fewer["frames"]), len(fewer["fields"])) == (5, len(whole["fields"]))
    assert len(fewer["notes"]) == 1
    least, smallest = packed(tmp_path, blobs.size // 12)
    assert smallest.size <= blobs.size // 12
    assert least["frames"][0]["count"] == pytest.approx(1000, abs=100)
    assert len(least["fields"]) < len(whole["fields"])
    assert [least["frames"][k]["step"] for k in (0, -1)] == [0, 4]
    assert len(least["notes"]) == 3


def test_outputs_are_left_out_evenly_whatever_surrounds_the_soil_and_what_cannot_fit_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_random_results(tmp_path, points=300, outputs=13)
    monkeypatch.setattr(body_module, "FEWEST_POINTS", 200)
    some, _ = packed(tmp_path, 40_000)
    steps = [frame["step"] for frame in some["frames"]]
    assert (steps[0], steps[-1]) == (0, 12)
    assert 2 < len(steps) < 13
    assert max(np.diff(steps)) - min(np.diff(steps)) <= 1
    assert all(frame["count"] >= 200 for frame in some["frames"])
    assert f"{len(steps)} of 13 outputs are shown" in " ".join(some["notes"])
    # Numbers that cannot be made smaller, many times the budget.
    wall = {
        "name": "wall",
        "kind": "boundary",
        "position": np.random.default_rng(3).uniform(size=(40_000, 2, 2)),
    }
    least, _ = packed(tmp_path, 40_000, boundaries=[wall])
    assert [len(least["frames"]), len(least["fields"])] == [2, 1]
    assert all(frame["count"] >= 200 for frame in least["frames"])
    assert "boundaries are not in this page" in " ".join(least["notes"])
    for budget in (1000, -1000):
        assert packed_or_not(tmp_path, budget) is None


@pytest.mark.long
def test_the_page_keeps_its_size_and_says_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_run(tmp_path, 2)
    (tmp_path / "results.vtkhdf").unlink()
    write_random_results(tmp_path, points=21_000)
    monkeypatch.setattr("tilth.report.explorer.page._MARGIN", 50_000)
    monkeypatch.setattr("tilth.report.html.LARGEST_PAGE", 4_500_000)
    page = write_report(tmp_path, MODEL)
    assert page.stat().st_size <= 4_500_000
    assert re.search(r"[2-4] of 5 outputs are shown", page.read_text())
    monkeypatch.setattr("tilth.report.html.LARGEST_PAGE", 2_800_000)
    page = write_report(tmp_path, MODEL)
    assert page.stat().st_size <= 2_800_000
    assert "The body at all outputs is not in this page" in page.read_text()
    with opened(page) as driver:
        hidden = "return ['body', 'curves'].map((n) => Tilth.element(`explore-${n}`).hidden)"
        assert driver.execute_script(hidden) == [True, False]
        assert complaints(driver) == []


def test_curves_of_very_many_steps_have_fewer_rows_with_the_first_and_last(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(curves_module, "LARGEST_CURVES", 5_000)
    table = {
        "step": np.arange(3001.0),
        "time": np.arange(3001.0) / 8.0,
        "load": np.random.default_rng(4).uniform(size=3001),
    }
    blobs = Blobs()
    packed_curves = pack_curves([table], [], [], "s", blobs)
    assert blobs.size <= 5_000
    assert packed_curves["steps"] == 3001
    content = zlib.decompress(base64.b64decode(blobs.texts[packed_curves["columns"][0]]))
    steps = np.frombuffer(content)
    assert len(steps) == packed_curves["rows"]
    assert (steps[0], steps[-1]) == (0.0, 3000.0)
    assert len(np.unique(np.diff(steps[:-1]))) == 1


@pytest.mark.parametrize("dim", [2, 3])
def test_a_browser_opens_slides_switches_picks_and_turns(tmp_path: Path, dim: int) -> None:
    write_run(tmp_path, dim)
    page = write_report(tmp_path, MODEL, setup=make_setup((6, 4, 3)[:dim]))
    results = read_results(tmp_path / "results.vtkhdf")
    with opened(page) as driver:
        run = driver.execute_script
        assert run("return document.getElementById('explorer-failure').hidden")
        names = run("return Tilth.data.body.fields.map(f => f.name)")
        for index in (4, 1):
            run(f"const t = Tilth.view.time; t.value = {index}; t.oninput()")
            for name in ("displacement", names[-1]):
                run(
                    f"Tilth.view.field.value = {names.index(name)};"
                    "return Tilth.view.show(Tilth.view.index || 0)"
                )
                run(f"return Tilth.view.show({index})")
                shown = np.array(run("return Array.from(Tilth.view.scene.values)"))
                values = field_values(results.snapshot(index), name, results.units)[0]
                np.testing.assert_allclose(
                    shown, values, rtol=1e-4, atol=1e-4 * np.abs(values).max()
                )
        assert f"step {results.steps[1]}" in run(
            "return document.getElementById('body-when').textContent"
        )
        before = driver.get_screenshot_as_png()
        if dim == 3:
            drag = [("mousePressed", 500), ("mouseMoved", 560), ("mouseReleased", 620)]
            run("document.getElementById('body-canvas').scrollIntoView({block: 'start'})")
            before_turn = run("return Tilth.view.scene.camera.position.toArray()")
            for kind, x in drag:
                event = {"type": kind, "x": x, "y": 200, "button": "left", "buttons": 1}
                driver.execute_cdp_cmd("Input.dispatchMouseEvent", event)
            after_turn = run("return Tilth.view.scene.camera.position.toArray()")
            assert np.abs(np.subtract(before_turn, after_turn)).max() > 1e-3
            assert driver.get_screenshot_as_png() != before
            run("const s = document.getElementById('body-cut-x'); s.value = '1'; s.onchange()")
        run("Tilth.view.scene.setSection(0, 0, 0)")
        where = run(
            "const s = Tilth.view.scene, p = new THREE.Vector3().fromArray(s.soil.centre, 0)"
            ".project(s.camera), b = s.canvas.getBoundingClientRect();"
            "return [(p.x + 1) / 2 * b.width, (1 - p.y) / 2 * b.height]"
        )
        run("return Tilth.view.pick(arguments[0], arguments[1])", *where)
        told = run("return document.getElementById('body-picked').textContent")
        assert re.match(r"point\d", told)
        assert "Displacement magnitude" in told
        csv = run("return Tilth.curves.csv()").splitlines()
        assert csv[0] == f"step,time [{UNITS['time']}],iterations,settlement [m]"
        assert [float(row.split(",")[-1]) for row in csv[1:]] == [0.0, 0.5, 1.0, 1.5, 2.0]
        assert complaints(driver) == []


def test_a_failure_of_the_interactive_part_leaves_the_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_run(tmp_path, 2)

    def fails(*_: Any, **__: Any) -> None:
        raise RuntimeError("no <room>")

    monkeypatch.setattr("tilth.report.explorer.page.pack_body", fails)
    text = write_report(tmp_path, MODEL).read_text()
    assert "could not be made: no &lt;room&gt;" in text
    assert "Tracked quantities" in text
    with opened(tmp_path / "report.html") as driver:
        assert driver.execute_script("return Tilth.charts.length") == 2
        assert complaints(driver) == []


def test_text_of_the_run_cannot_end_the_data(tmp_path: Path) -> None:
    write_run(tmp_path, 2)
    assert data_of(write_report(tmp_path, MODEL))["body"]["dim"] == 2


@pytest.mark.parametrize("dim", [2, 3])
def test_slow_movement_has_fewer_pixels_and_all_of_them_once_it_has_ended(
    tmp_path: Path, dim: int
) -> None:
    write_run(tmp_path, dim)
    with opened(write_report(tmp_path, MODEL)) as driver:
        ratios = driver.execute_script(
            "Tilth.Scene.slow = -1; Tilth.Scene.still = 800;"
            "const scene = Tilth.view.scene, found = [];"
            "const ratio = () => found.push(scene.ratio);"
            "ratio();"
            "for (let k = 0; k < 6; k++)"
            "{ scene.move(); await new Promise(requestAnimationFrame); }"
            "ratio();"
            "await new Promise((done) => setTimeout(done, Tilth.Scene.still + 300));"
            "ratio(); scene.move(); ratio();"
            "await new Promise((done) => setTimeout(done, Tilth.Scene.still + 300));"
            "const frames = scene.frames;"
            "await new Promise((done) => setTimeout(done, 300));"
            "found.push(scene.frames - frames);"
            "return found"
        )
    assert ratios == [2, 1, 2, 1, 0], "the last: pictures without a change"


def test_points_that_others_hide_are_not_drawn_unless_a_section_opens_the_body(
    tmp_path: Path,
) -> None:
    write_run(tmp_path, 3)
    with opened(write_report(tmp_path, MODEL)) as driver:
        sides = driver.execute_script(
            # A block of 8 x 8 x 8 cubes, 2 wide, and one away from them.
            "const n = 513, columns = () => [0, 1, 2].map(() => new Float32Array(n));"
            "const position = columns(), edges = columns();"
            "for (let i = 0; i < 512; i++) [i % 8, (i >> 3) % 8, i >> 6]"
            ".forEach((place, k) => { position[k][i] = 2 * place; });"
            "position.forEach((column) => { column[512] = 40; });"
            "edges.forEach((column) => column.fill(1));"
            "const soil = new Tilth.Soil({ count: n, enlarged: 1, position, edges }, 3, [0, 0, 0]);"
            "const planes = [0, 1, 2].map(() => new THREE.Vector4(0, 0, 0, 1));"
            "const count = () => { const rows = soil.seen(planes);"
            "return [rows.length, soil.sides(rows).map((sides) => sides.length)]; };"
            "const whole = count(); planes[0].set(1, 0, 0, 7); const half = count();"
            "return [whole, half]"
        )
    outer = 6 * 8**2
    assert sides[0][0] < 513
    assert sum(sides[0][1]) == outer + 6
    assert sides[0][1] == [65] * 6
    assert sum(sides[1][1]) == 2 * 64 + 4 * 32, "half of the block, without the cube away from it"
