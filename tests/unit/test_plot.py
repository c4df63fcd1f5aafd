# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of runs: columns, names and times that are there or refused, lines through the soil."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from report_setups import UNITS, snapshot

from tilth.errors import BadInput
from tilth.output import HistoryWriter, ResultsWriter
from tilth.plot.curves import curve_figure
from tilth.plot.field import field_figure
from tilth.plot.files import save_figure
from tilth.plot.path import values_along


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
