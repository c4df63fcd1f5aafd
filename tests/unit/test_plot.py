# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of runs: columns, names and times that are there or refused, lines through the soil."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from report_setups import UNITS, snapshot

from tilth.errors import BadInput
from tilth.output import HistoryWriter, ResultsWriter, read_results
from tilth.plot.curves import curve_figure
from tilth.plot.field import field_figure
from tilth.plot.files import save_figure
from tilth.plot.path import path_figure, values_along


def run_at(folder: Path, dim: int) -> Path:
    folder.mkdir()
    writer = ResultsWriter(folder / "results.vtkhdf", title="block", units=UNITS)
    for step in (0, 1):
        writer.append(snapshot(dim, step))
    writer.close()
    history = HistoryWriter(folder / "history.csv", [("load", "N"), ("settlement", "m")])
    for step in range(3):
        history.append(step, 0.5 * step, 1, [10.0 * step, 0.1 * step])
    history.close()
    return folder


@pytest.mark.slow
def test_a_field_and_curves_are_written(tmp_path: Path) -> None:
    run = run_at(tmp_path / "a", 2)
    figure = field_figure(run, "displacement_y", values=(-1.0, 1.0))
    for ending in ("svg", "pdf", "png"):
        save_figure(figure, tmp_path / f"x.{ending}")
        assert (tmp_path / f"x.{ending}").stat().st_size > 1000


def test_curves_have_their_columns_and_names(tmp_path: Path) -> None:
    runs = [run_at(tmp_path / name, 2) for name in "ab"]
    axes = curve_figure(runs, "settlement", "load [N]").axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("settlement [m]", "load [N]")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["a", "b"]
    np.testing.assert_array_equal(axes.lines[1].get_ydata(), [0.0, 10.0, 20.0])
    alone = curve_figure(runs[0], "settlement", "load [N]").axes[0]
    assert (alone.get_xlabel(), alone.get_ylabel()) == ("settlement [m]", "load [N]")
    np.testing.assert_array_equal(alone.lines[0].get_xdata(), [0.0, 0.1, 0.2])


def test_histories_over_logarithms_and_roots(tmp_path: Path) -> None:
    run = run_at(tmp_path / "a", 2)
    axes = curve_figure(run, "time", "load", scale="log").axes[0]
    assert axes.get_xscale() == "log"
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), [0.5, 1.0])
    axes = curve_figure(run, "time", "load", scale="root").axes[0]
    placed = axes.transData.transform([[0.0, 0.0], [0.25, 0.0], [1.0, 0.0]])[:, 0]
    assert placed[1] - placed[0] == pytest.approx(0.5 * (placed[2] - placed[0]))
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), [0.0, 0.5, 1.0])


def test_a_line_at_several_times(tmp_path: Path) -> None:
    run = run_at(tmp_path / "a", 2)
    results = read_results(run / "results.vtkhdf")
    middle = results.snapshot(0).position.mean(axis=0)
    ends = middle - 0.1, middle + 0.1
    times = results.times[:2]
    axes = path_figure(run, "displacement_y", *ends, times=times).axes[0]
    assert len(axes.lines) == 2
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == [f"time {time:.4g} {UNITS['time']}" for time in times]
    for line, time in zip(axes.lines, times, strict=True):
        alone = path_figure(run, "displacement_y", *ends, time=time).axes[0]
        np.testing.assert_array_equal(line.get_ydata(), alone.lines[0].get_ydata())
        assert f"time {time:.4g}" in alone.get_title()


def test_what_is_not_there_is_refused_with_what_is_near(tmp_path: Path) -> None:
    run = run_at(tmp_path / "a", 2)
    for ask, remedy in (
        (lambda: field_figure(run, "displacements"), "did you mean displacement"),
        (lambda: field_figure(run, "displacement", time=77.0), "choose from 0"),
        (lambda: curve_figure(run, "time", "loads"), "did you mean load"),
        (lambda: save_figure(field_figure(run, "displacement"), tmp_path / "x.doc"), ".svg"),
    ):
        with pytest.raises(BadInput) as error:
            ask()
        assert remedy in error.value.remedy


def test_a_line_has_the_values_of_a_linear_field() -> None:
    state = snapshot(3, 0)
    centre = state.position.mean(axis=0)
    linear = state.position @ [1.0, 2.0, 3.0]
    ends = np.stack([centre, centre + 100.0])
    found = values_along(replace(state, surfaces=()), linear, ends)
    assert found[0] == pytest.approx(centre @ [1.0, 2.0, 3.0], abs=1e-6)
    assert np.isnan(found[1])
