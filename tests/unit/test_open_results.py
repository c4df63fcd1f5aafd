# SPDX-License-Identifier: BSD-3-Clause
"""`tilth.open`: the values are those of the files; what is not there is refused."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from result_snapshots import UNITS, make_snapshot

import tilth
from tilth.output import ResultsWriter, read_history, read_results

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def unfinished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that was stopped at half of its time."""
    folder = tmp_path_factory.mktemp("open") / "run"
    case = tilth.load_case(ROOT / "examples" / "self_weight_column" / "case.toml")
    result = tilth.run(case, folder, until=0.5, quiet=True)
    assert not result.finished
    assert len(repr(result)) < 200 + len(str(folder))
    assert "stopped before its end" in repr(result)
    assert "<td>stopped before its end</td>" in result._repr_html_()
    assert result.results.times[-1] == 0.5
    assert len(result.plot("volume", show="points").axes) >= 2
    assert str(case) == repr(case)
    assert repr(case).startswith("<Model 'Self-weight column")
    assert len(repr(case)) < 200
    return folder


def test_values_are_those_of_the_files(unfinished: Path) -> None:
    run, stored = tilth.open(unfinished), read_results(unfinished / "results.vtkhdf")
    assert run.times.tolist() == stored.times
    assert run.times[-1] == 0.5
    for index, snapshot in enumerate(stored):
        time = stored.times[index]
        np.testing.assert_array_equal(run.points(time), snapshot.position)
        assert set(run.fields) == set(snapshot.point_fields)
        for name, values in snapshot.point_fields.items():
            np.testing.assert_array_equal(run.field(name, index=index), values, strict=True)
    last = stored.snapshot(-1).point_fields
    np.testing.assert_array_equal(run.field("cauchy_stress_yy"), last["cauchy_stress"][:, 1])
    assert run.fields["cauchy_stress"] == run.units["stress"]
    columns = read_history(unfinished / "history.csv")
    assert list(run.history) == list(columns)
    for name, column in columns.items():
        np.testing.assert_array_equal(run.history[name.split(" [")[0]], column)
    assert "time" in run.history
    assert "tide" not in run.history
    assert run.model.title == run.title
    assert run.stages == {}


def test_a_caller_who_changes_an_array_does_not_change_the_results(unfinished: Path) -> None:
    run = tilth.open(unfinished)
    for read in (run.points, lambda: run.field("displacement"), lambda: run.field("volume")):
        before = read().copy()
        read()[:] = 7.0
        np.testing.assert_array_equal(read(), before)


def test_what_is_not_there_is_refused(unfinished: Path, tmp_path: Path) -> None:
    run = tilth.open(unfinished)
    count = len(run.times)
    (tmp_path / "file").write_text("")
    for ask, said in (
        (lambda: tilth.open(tmp_path), "there is no results.vtkhdf"),
        (lambda: tilth.open(tmp_path / "nowhere"), "there is no such folder"),
        (lambda: tilth.open(tmp_path / "file"), "is a file"),
        (lambda: run.points(0.123), "choose from 0, "),
        (lambda: run.points(index=99), "give a number from 0 to"),
        (lambda: run.points(index=count), f"give a number from 0 to {count - 1}"),
        (lambda: run.points(index=-count - 1), f"give a number from 0 to {count - 1}"),
        (lambda: run.points(0.5, index=0), "give one of them"),
        (lambda: run.field("cauchy_stres"), "did you mean cauchy_stress"),
        (lambda: run.history["heights"], "did you mean height"),
    ):
        with pytest.raises(tilth.BadInput) as error:
            ask()
        assert said in str(error.value)
    np.testing.assert_array_equal(run.points(index=-count), run.points(index=0))
    np.testing.assert_array_equal(run.points(index=count - 1), run.points(index=-1))


def test_tables_and_pictures(unfinished: Path) -> None:
    pytest.importorskip("pandas")
    run = tilth.open(unfinished)
    table = run.history.to_pandas()
    assert list(table.columns) == list(run.history)
    np.testing.assert_array_equal(table["time"].to_numpy(), run.history["time"])
    assert len(repr(run)) < 200 + len(str(unfinished))
    assert "Self-weight" in run._repr_html_()
    assert len(run.plot("displacement_y", show="points").axes) >= 2
    line = run.plot_history("time", "height").axes[0].lines[0]
    np.testing.assert_array_equal(line.get_ydata(), run.history["height"])


@pytest.mark.parametrize("name", ["pandas", "pyvista"])
def test_a_missing_extra_is_named(
    unfinished: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, name, None)
    run = tilth.open(unfinished)
    with pytest.raises(tilth.BadInput, match=rf"tilth\[{name}\]"):
        run.history.to_pandas() if name == "pandas" else run.to_pyvista()


@pytest.mark.parametrize("dim", [2, 3])
def test_meshes_have_the_fields_and_cells(tmp_path: Path, dim: int) -> None:
    pytest.importorskip("pyvista")
    writer = ResultsWriter(tmp_path / "results.vtkhdf", title="", units=UNITS)
    state = make_snapshot(2, dim, surfaces=True)
    writer.append(state)
    writer.close()
    run = tilth.open(tmp_path)
    blocks = run.to_pyvista()
    np.testing.assert_array_equal(blocks["points"].points[:, :dim], state.position)
    for name, values in state.point_fields.items():
        flat = values.reshape(len(values), -1)
        found = blocks["points"].point_data[name].reshape(len(values), -1)
        np.testing.assert_array_equal(found[:, : flat.shape[1]], flat)
        assert not found[:, flat.shape[1] :].any()
    assert list(blocks.keys()) == ["points", "grid", "surfaces", "rigid_bodies"]
    assert blocks["grid"].n_cells == len(state.cells)
    size = blocks["grid"].compute_cell_sizes()
    measure = size.cell_data["Area" if dim == 2 else "Volume"]
    np.testing.assert_allclose(measure, 1.0, rtol=1e-12)  # unit cells, not twisted
    assert list(run.surfaces()) == [shape.name for shape in state.surfaces]
    for shape in state.surfaces:
        mesh = blocks["surfaces"][shape.name]
        if len(shape.cells) == 0:
            assert mesh.n_cells == 0
            continue
        np.testing.assert_array_equal(mesh.points[:, :dim], shape.position)
        rows = mesh.lines if dim == 2 else mesh.faces
        np.testing.assert_array_equal(rows.reshape(-1, dim + 1)[:, 1:], shape.cells)


def test_a_model_and_a_run_show_themselves(unfinished: Path) -> None:
    model = tilth.load_case(ROOT / "examples" / "self_weight_column" / "case.toml")
    table = model._repr_html_()
    for said in ("<th>analysis</th><td>plane strain</td>", model.title, "hencky_elastic", "base"):
        assert said in table
    assert len(model.plot().axes) >= 1
    with pytest.raises(tilth.BadInput, match="there is no figure or parameter"):
        model.plot("cohesion")
