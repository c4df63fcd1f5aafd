# SPDX-License-Identifier: BSD-3-Clause
"""Graded grids in the picture of the set-up, in summaries and in warnings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_setups import make_setup, snapshot

from tilth import Model
from tilth.analysis.memory import memory_of
from tilth.analysis.model_warnings import _far_positions, _small_radii, _thin_or_sparse
from tilth.analysis.run_warnings import RunWarnings
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries.surfaces.grid_properties import grid_properties
from tilth.grid.background import background_grid
from tilth.model.grading import line_of
from tilth.mpm.initial_points import initial_points
from tilth.report.amounts import cells_text
from tilth.report.setup import draw_setup
from tilth.report.setup_data import Setup
from tilth.report.setup_file import read_setup, write_setup
from tilth.report.setup_view import _rectangles
from tilth.report.stage_texts import changes
from tilth.report.visible_points import exterior_points
from tilth_verification.cases import example, varied

X = line_of(((0.0, 0.5), (1.0, 0.5), (3.0, 1.2)))
ROWS = [[0.0, 0.1], [1.0, 0.1], [5.0, 1.0]]


def graded_setup() -> Setup:
    """Six by four points of 0.5 m, from cells of 0.5 m on."""
    return replace(
        make_setup((6, 4)), cell_size=np.array([0.5, 1.0]), lines=[X.tolist(), []],
        origin=np.array([0.25, 0.0]),
    )  # fmt: skip


def vertical_lines(figure: Any) -> Floats:
    """The x of the grid lines in the first axes of a figure."""
    from matplotlib.collections import LineCollection

    (lines,) = [c for c in figure.axes[0].collections if isinstance(c, LineCollection)][:1]
    segments = np.array(lines.get_segments())
    return np.sort(segments[segments[:, 0, 0] == segments[:, 1, 0], 0, 0])


def test_the_picture_shows_the_graded_lines() -> None:
    setup = graded_setup()
    figure = draw_setup(setup)
    found = vertical_lines(figure)
    lower, upper = setup.bounds()
    size = np.diff(X)
    every = 0.25 + np.concatenate(
        [-size[0] * np.arange(9.0, 0.0, -1.0), X, X[-1] + size[-1] * np.arange(1, 9)]
    )
    expected = every[(every >= lower[0]) & (every <= upper[0])]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    legends = [*figure.legends, *filter(None, (axes.get_legend() for axes in figure.axes))]
    words = " ".join(text.get_text() for legend in legends for text in legend.get_texts())
    assert f"cells of\n0.5 to {size.max():.3g} x 1 m" in words


def test_points_are_counted_in_the_cells_that_they_are_in() -> None:
    setup = graded_setup()
    cells = {
        (int(np.searchsorted(X, x - 0.25, side="right")) if x >= 0.25 else 0, int(np.floor(y)))
        for x, y in setup.position
    }
    assert setup.occupied_cells() == len(cells)
    assert make_setup((6, 4)).occupied_cells() == 3 * 2


def test_a_setup_is_read_as_it_was_written(tmp_path: Path) -> None:
    setup = graded_setup()
    write_setup(tmp_path / "setup.npz", setup)
    initial = snapshot()
    initial.point_fields["domain"] = np.zeros_like(initial.position)
    again = read_setup(tmp_path / "setup.npz", initial)
    assert again.lines == setup.lines
    np.testing.assert_array_equal(again.cell_size, setup.cell_size)


def test_sizes_in_words() -> None:
    assert cells_text([(0.05, 0.5), (0.1, 0.1)], "m") == "cells of 0.05 to 0.5 x 0.1 m"
    assert cells_text([(0.25, 0.25 + 1e-15)] * 2, "") == "cells of 0.25 x 0.25"


def test_uneven_domains_are_drawn_where_they_are() -> None:
    """In space those on the outside; in few rectangles they leave no gaps."""
    axes = 0.5 * (X[1:] + X[:-1])
    place = np.stack(np.meshgrid(axes, axes, axes, indexing="ij"), axis=-1).reshape(-1, 3)
    half = np.stack(np.meshgrid(*3 * [0.5 * np.diff(X)], indexing="ij"), axis=-1).reshape(-1, 3)
    outside = ((place == axes[0]) | (place == axes[-1])).any(axis=1)
    np.testing.assert_array_equal(exterior_points(place, half), np.flatnonzero(outside))
    flat = np.unique(place[:, :2], axis=0)
    sizes = np.stack([np.interp(x, axes, 0.5 * np.diff(X)) for x in flat.T], axis=1)
    centre, drawn, _ = _rectangles(flat, sizes, np.zeros(len(flat), dtype=np.int64))
    inner = np.random.default_rng(1).uniform(0.0, X[-1], (500, 2))
    covered = (np.abs(inner[:, None] - centre) <= drawn + 1e-12).all(axis=2).any(axis=1)
    assert covered.all()


def model(**sections: Any) -> Model:
    """Ground of 5 m by 2 m with fine cells at x below 1."""
    shape = {"type": "box", "lower": [0.0, 0.0], "upper": [5.0, 2.0]}
    base = {"type": "plane", "name": "base", "axis": "y", "at": 0.0, "condition": "fixed"}
    entries: dict[str, Any] = {
        "format": 1,
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": {"x": ROWS, "y": 0.25}},
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": 1e6, "poisson_ratio": 0.2}
        },
        "bodies": [
            {
                "name": "ground", "material": "soil", "shape": shape, "basis": "linear",
                "points_per_cell": 2,
            }
        ],
        "boundaries": [base],
        "schedule": {"steps": 1},
    }  # fmt: skip
    return Model.from_dict(entries | sections)


def test_a_stage_tells_the_sizes_of_its_grid() -> None:
    stages = [
        {"name": "one", "schedule": {"steps": 1}},
        {"name": "two", "schedule": {"steps": 1}, "grid": {"cell_size": {"x": ROWS, "y": 0.1}}},
    ]
    given = model().to_dict()
    del given["schedule"]
    staged = Model.from_dict({**given, "grid": {"cell_size": 0.25}, "stages": stages})
    largest = staged.of_stages[1].largest_cell[0]
    assert changes(staged.of_stages[1]) == [f"grid: cells of 0.1 to {largest:.3g} x 0.1 m"]


def test_the_memory_is_that_of_the_graded_cells() -> None:
    graded, uniform = memory_of(model()), memory_of(model(grid={"cell_size": [0.1, 0.25]}))
    points = initial_points(model())
    assert graded.points == len(points)
    assert graded.cells < 0.5 * uniform.cells
    cells = np.floor(background_grid(model()).in_cells(points.position))
    assert graded.cells == pytest.approx(len(np.unique(cells, axis=0)))


def test_no_warning_of_a_body_that_follows_its_grid() -> None:
    declared = model()
    points, grid = initial_points(declared), background_grid(declared)
    assert list(_thin_or_sparse(points, grid)) == []
    warnings = RunWarnings()
    warnings.few_points(points, grid, "stages[1].grid.cell_size")
    assert warnings.texts == []


def test_points_sparse_in_the_fine_cells_are_warned_of() -> None:
    sparse = model(grid={"cell_size": [0.2, 0.25]})
    points, grid = initial_points(sparse), background_grid(model())
    points.half_length[:, 0] = points.initial_half_length[:, 0] = 0.06
    (warned,) = (text for _, text in _thin_or_sparse(points, grid))
    assert "1.2 cells apart along x" in warned
    points.half_length[:] = points.initial_half_length
    warnings = RunWarnings()
    fine = background_grid(model(grid={"cell_size": {"x": [[0, 0.1], [9, 0.1]], "y": 0.25}}))
    warnings.few_points(points, fine, "stages[1].grid.cell_size")
    assert len(warnings.texts) == 1


def test_a_place_is_far_in_the_cells_that_are_there() -> None:
    """0.5 m beyond the soil is far for cells of 0.1 m and near for cells of 0.9 m."""
    track = {
        "name": "u", "quantity": "displacement", "body": "ground", "component": "x",
    }  # fmt: skip
    for x, far in (-0.5, True), (5.5, False):
        declared = model(track=[{**track, "at": [x, 1.0]}])
        found = list(_far_positions(declared, initial_points(declared), background_grid(declared)))
        assert bool(found) == far


def test_a_radius_is_compared_with_the_cells_around_it() -> None:
    def pipe(x: float) -> dict[str, Any]:
        circle = {"type": "circle", "centre": [x, 1.0], "radius": 0.45, "soil": "outside"}
        return {"name": "pipe", "type": "implicit", "geometry": circle, "condition": "fixed"}

    base = model().to_dict()["boundaries"][0]
    finer = {"cell_size": {"x": ROWS, "y": 0.1}}
    for x, warned in (0.5, False), (4.0, True):
        declared = model(boundaries=[base, pipe(x)], grid=finer)
        grid = background_grid(declared)
        assert bool(list(_small_radii(declared, initial_points(declared), grid))) == warned


@pytest.mark.parametrize(("axis", "moves"), [("z", False), ("x", True)])
def test_a_grid_moves_only_along_the_axes_that_follow(axis: str, moves: bool) -> None:
    changes = {"boundaries.5.displacement": {axis: -0.002}}
    model = varied(example("square_footing", "graded.toml"), changes)
    assert grid_properties(model).grid_moves == moves


def test_walls_of_a_grid_that_does_not_move_take_its_cells() -> None:
    """Far from the footing the walls' quadrature points are as far apart as the cells."""
    simulation = Simulation(example("square_footing", "graded.toml"))
    simulation.prepare(0.0, 1.0)
    for wall in simulation.state.implicit:
        assert wall.quadrature is not None
        # the thin cells under the footing are no reason for more points on it
        assert len(wall.quadrature.weight) < (10_000 if wall.name == "footing" else 40_000)
