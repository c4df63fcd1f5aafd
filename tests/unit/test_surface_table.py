# SPDX-License-Identifier: BSD-3-Clause
"""surface.csv: the tracked surfaces at the last output, with all digits."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from result_snapshots import make_snapshot
from small_problems import block_entries, rollers, weight
from tracked_shapes import circle, line, octahedron, with_surfaces

from tilth import BadInput, Model, resume, run
from tilth.analysis.recorder import Recorder
from tilth.analysis.state import State
from tilth.output import SurfaceShape, prepare_output_folder, read_results, read_surface
from tilth.output import write_surfaces as write


def test_chains_are_written_along_the_curve(tmp_path: Path) -> None:
    path = tmp_path / "surface.csv"
    slope = line("slope, left", np.array([[0.0, 1.0], [0.1, 1.0], [1.0 / 3.0, 1.0]]))
    write(path, replace(make_snapshot(2), surfaces=(slope, circle("hole", 4, 0.3))), "m")
    rows = path.read_text().splitlines()
    assert rows[0] == (
        "step,time,surface,chain,closed,point,x [m],y [m],arc_length [m],normal_x,normal_y"
    )
    assert rows[3] == (
        '2,0.2,"slope, left",0,0,2,0.3333333333333333,1.0,0.3333333333333333,-0.0,1.0'
    )
    table = read_surface(path)
    assert table["surface"].tolist() == ["slope, left"] * 3 + ["hole"] * 4
    assert table["closed"].tolist() == [0] * 3 + [1] * 4
    assert table["point"].tolist() == [0, 1, 2, 0, 1, 2, 3]
    hole = circle("hole", 4, 0.3)
    for heading, values in (
        ("x [m]", hole.position[:, 0]),
        ("y [m]", hole.position[:, 1]),
        ("arc_length [m]", hole.fields["arc_length"]),
        ("normal_x", hole.fields["normal"][:, 0]),
        ("normal_y", hole.fields["normal"][:, 1]),
    ):
        np.testing.assert_array_equal(table[heading][3:], values, strict=True)


def test_pieces_of_a_surface_are_chains_of_their_own(tmp_path: Path) -> None:
    parts = circle("ring", 8)
    cells = np.array([[4, 5], [5, 6], [0, 1], [1, 2], [2, 0]])
    surface = SurfaceShape("parts", parts.position, cells, parts.fields)
    write(tmp_path / "surface.csv", replace(make_snapshot(1), surfaces=(surface,)), "")
    table = read_surface(tmp_path / "surface.csv")
    assert "x" in table
    assert "arc_length" in table
    assert table["chain"].tolist() == [0, 0, 0, 1, 1, 1]
    assert table["closed"].tolist() == [0, 0, 0, 1, 1, 1]
    assert table["point"].tolist() == [4, 5, 6, 0, 1, 2]
    np.testing.assert_array_equal(table["x"], parts.position[[4, 5, 6, 0, 1, 2], 0])


def test_vertices_in_space_keep_their_numbers(tmp_path: Path) -> None:
    shape = octahedron("ball", 2, 1.0 / 3.0)
    write(tmp_path / "surface.csv", replace(make_snapshot(1, 3), surfaces=(shape,)), "ft")
    table = read_surface(tmp_path / "surface.csv")
    assert list(table) == [
        "step", "time", "surface", "point", "x [ft]", "y [ft]", "z [ft]",
        "normal_x", "normal_y", "normal_z",
    ]  # fmt: skip
    assert table["point"].tolist() == list(range(12))
    position = np.column_stack([table[f"{axis} [ft]"] for axis in "xyz"])
    np.testing.assert_array_equal(position, shape.position)
    normal = np.column_stack([table[f"normal_{axis}"] for axis in "xyz"])
    np.testing.assert_array_equal(normal, shape.fields["normal"])


@pytest.mark.parametrize("dim", [2, 3])
def test_a_later_state_replaces_the_earlier(tmp_path: Path, dim: int) -> None:
    for step in (3, 5, 1, 0):
        write(tmp_path / "surface.csv", with_surfaces(make_snapshot(step, dim)), "m")
        table = read_surface(tmp_path / "surface.csv")
        assert set(table["step"].tolist()) <= {step}
        assert (len(table["step"]) > 0) == (step > 0 or dim == 2)
    assert [file.name for file in tmp_path.iterdir()] == ["surface.csv"]


def test_the_documented_lines_read_a_profile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = Path(__file__).parents[2] / "docs" / "howto" / "read_results.md"
    blocks = re.findall(r"^```py\n(.*?)^```$", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    (block,) = (block for block in blocks if "read_surface" in block)
    slope = line("slope", np.linspace([0.0, 1.0], [1.0 / 3.0, 2.0], 5))
    (tmp_path / "run").mkdir()
    shapes = (circle("pipe", 8), slope)
    write(tmp_path / "run/surface.csv", replace(make_snapshot(2), surfaces=shapes), "m")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(compile(block, str(page), "exec"), names)
    np.testing.assert_array_equal(names["profile"], slope.position)


def test_another_file_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="cannot be read"):
        read_surface(tmp_path / "surface.csv")
    for text in ("", "step,time\n1,2\n"):
        (tmp_path / "surface.csv").write_text(text)
        with pytest.raises(BadInput, match="not the surface"):
            read_surface(tmp_path / "surface.csv")
    for row in ("1,0.5", "1,0.5,top,one"):
        (tmp_path / "surface.csv").write_text(f"step,time,surface,point\n{row}\n")
        with pytest.raises(BadInput, match="not a table of surfaces"):
            read_surface(tmp_path / "surface.csv")


def entries(steps: int = 4) -> dict[str, Any]:
    """A block under its weight."""
    given = block_entries(
        "plane_strain", "linear", cells=1, loads=[weight("plane_strain", 2.0)],
        boundaries=rollers("plane_strain"),
        schedule={"steps": steps, "output_times": [0.5]},
    )  # fmt: skip
    given["output"] = {"report": False}
    return given


def top_of_points(state: State) -> tuple[SurfaceShape, ...]:
    """A line through the uppermost points: it moves with the soil."""
    place = state.points.position
    top = place[place[:, 1] > place[:, 1].max() - 1e-9]
    return (line("top", top[np.argsort(-top[:, 0])]),)


def test_a_run_writes_its_surfaces_at_every_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def note(path: Path, snapshot: Any, unit: str) -> None:
        write(path, snapshot, unit)
        seen.append((snapshot.step, read_surface(path)["step"][0]))

    monkeypatch.setattr(State, "surface_shapes", top_of_points)
    monkeypatch.setattr("tilth.analysis.recorder.write_surfaces", note)
    run(Model.from_dict(entries()), tmp_path / "out", quiet=True)
    assert seen == [(0, 0), (2, 2), (4, 4)]
    results = read_results(tmp_path / "out/results.vtkhdf")
    assert results.surfaces == ("top",)
    tops = [snapshot.surfaces[0].position for snapshot in results]
    assert tops[0][0, 1] > tops[1][0, 1] > tops[2][0, 1]
    table = read_surface(tmp_path / "out/surface.csv")
    (height,) = (heading for heading in table if heading.split(" ")[0] == "y")
    np.testing.assert_array_equal(table[height], tops[-1][:, 1])
    prepare_output_folder(tmp_path / "out", overwrite=True)
    assert list((tmp_path / "out").iterdir()) == []


def test_a_run_without_surfaces_writes_no_table(tmp_path: Path) -> None:
    run(Model.from_dict(entries(1)), tmp_path, quiet=True)
    assert not (tmp_path / "surface.csv").exists()


def test_a_resumed_run_goes_on_with_the_table_of_its_last_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(State, "surface_shapes", top_of_points)
    run(Model.from_dict(entries()), tmp_path / "whole", quiet=True)
    checkpoint = Recorder._checkpoint

    def stop(self: Recorder, clock: Any) -> None:
        checkpoint(self, clock)
        if clock.step == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr(Recorder, "_checkpoint", stop)
    with pytest.raises(KeyboardInterrupt):
        run(Model.from_dict(entries()), tmp_path / "part", quiet=True)
    monkeypatch.setattr(Recorder, "_checkpoint", checkpoint)
    table = tmp_path / "part" / "surface.csv"
    assert read_surface(table)["step"][0] == 2
    table.unlink()  # a kill between the two files leaves the table behind the results
    start = Recorder.resume

    def look(*arguments: Any) -> Recorder:
        recorder = start(*arguments)
        assert read_surface(table)["step"][0] == 2
        return recorder

    monkeypatch.setattr(Recorder, "resume", look)
    resume(tmp_path / "part", quiet=True)
    assert table.read_bytes() == (tmp_path / "whole" / "surface.csv").read_bytes()
