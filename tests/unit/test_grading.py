# SPDX-License-Identifier: BSD-3-Clause
"""Cell sizes that vary along an axis: the declared places and sizes, and the grid lines."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import tilth
from tilth import BadInput, Model
from tilth.grid.background import background_grid
from tilth.model import ImplicitBoundary
from tilth.model.grading import LARGEST_RATIO, line_of
from tilth_verification.cases import varied

ROWS = [[0.0, 0.05], [1.0, 0.05], [5.0, 0.5]]
SOIL = {"model": "hencky_elastic", "young_modulus": 1e6, "poisson_ratio": 0.2}


def entries(grid: dict[str, Any], kind: str = "plane_strain", **sections: Any) -> dict[str, Any]:
    """A block of unit size on a fixed base."""
    dim = 3 if kind == "3d" else 2
    shape = {"type": "box", "lower": [0.0] * dim, "upper": [1.0] * dim}
    up = "xyz"[dim - 1]
    base = {"type": "plane", "name": "base", "axis": up, "at": 0.0, "condition": "fixed"}
    body = {
        "name": "block", "material": "soil", "shape": shape, "basis": "gimp",
        "points_per_cell": 2,
    }  # fmt: skip
    return {
        "format": 1,
        "analysis": {"kind": kind},
        "grid": grid,
        "materials": {"soil": SOIL},
        "bodies": [body],
        "boundaries": [base],
        "schedule": {"steps": 1},
        **sections,
    }


def refused(grid: dict[str, Any], kind: str = "plane_strain", **sections: Any) -> BadInput:
    with pytest.raises(BadInput) as caught:
        Model.from_dict(entries(grid, kind, **sections))
    return caught.value


@pytest.mark.parametrize(
    "rows",
    [
        ROWS,
        [[-7.0, 2.0], [-1.0, 0.25], [1.0, 0.25], [2.0, 0.4], [9.0, 0.1]],
        [[0.0, 0.1], [1.0, 0.1]],
        [[100.0, 1.0], [100.9, 1.0], [103.7, 1.3]],
    ],
)
def test_a_line_passes_through_each_place_and_sizes_grow_evenly_between(rows: list[Any]) -> None:
    line = line_of(tuple(map(tuple, rows))) + rows[0][0]
    size = np.diff(line)
    for (start, first), (end, last) in pairwise(rows):
        own = np.flatnonzero((line > start - 1e-12) & (line < end + 1e-12))
        assert line[own[[0, -1]]] == pytest.approx([start, end], abs=1e-12)
        ratio = size[own[1:-1]] / size[own[:-2]]
        np.testing.assert_allclose(ratio, (last / first) ** (1.0 / (len(own) - 1)), rtol=1e-10)
        if first == last:
            number = (end - start) / first
        else:
            number = (end - start) * math.log(last / first) / (last - first)
        assert len(own) - 1 == round(number)
        # Half a step of the progression is between a place and the middle of the cell beside it.
        half = math.sqrt(last / first) ** (1.0 / (len(own) - 1))
        made = size[own[0]] / half, size[own[-2]] * half
        assert made == pytest.approx((first, last), rel=abs(number / round(number) - 1.0) + 0.01)
    assert max((size[1:] / size[:-1]).max(), (size[:-1] / size[1:]).max()) <= LARGEST_RATIO


def test_the_grid_of_a_model() -> None:
    model = Model.from_dict(entries({"cell_size": {"x": ROWS, "y": 0.1}, "origin": [0.0, 0.5]}))
    grid = background_grid(model)
    assert grid.graded == [0]
    assert grid.cell_size == pytest.approx([0.05, 0.1])
    assert model.cell_size == tuple(grid.cell_size)
    assert model.largest_cell == pytest.approx((np.diff(grid.lines[0]).max(), 0.1))
    assert model.origin == (0.0, 0.5)
    assert grid.in_cells(np.array([[1.0, 0.7], [5.0, 0.4]])) == pytest.approx(
        np.array([[20.0, 2.0], [len(grid.lines[0]) - 1.0, -1.0]])
    )
    beyond = grid.sizes_at(np.array([[-3.0, 0.0], [50.0, 0.0]]))[:, 0]
    assert beyond == pytest.approx([0.05, model.largest_cell[0]])


def test_the_origin_is_the_first_place() -> None:
    rows = [[-2.0, 0.4], [0.0, 0.1], [1.0, 0.1]]
    model = Model.from_dict(entries({"cell_size": {"x": 0.1, "y": rows}}))
    assert model.origin == (0.0, -2.0)
    assert Model.from_dict(
        entries({"cell_size": {"x": 0.1, "y": rows}, "origin": [0.3, -2.0]})
    ).origin == (0.3, -2.0)


def test_uniform_grids_in_all_forms_have_no_lines() -> None:
    for size in (0.25, [0.25, 0.25], {"x": 0.25, "y": 0.25}):
        model = Model.from_dict(entries({"cell_size": size}))
        assert model.cell_size == model.largest_cell == (0.25, 0.25)
        assert background_grid(model).lines == ()


def test_a_model_comes_back_from_json() -> None:
    model = Model.from_dict(entries({"cell_size": {"y": ROWS, "x": 0.1}}))
    stored = json.loads(json.dumps(model.to_dict()))
    assert stored["grid"] == {"cell_size": {"x": 0.1, "y": ROWS}}
    assert Model.from_dict(stored) == model
    grid = tilth.Grid(cell_size={"x": 0.1, "y": np.array(ROWS)})
    assert grid == model.grid


def test_a_variation_of_the_sizes() -> None:
    model = Model.from_dict(entries({"cell_size": 0.25}))
    graded = varied(model, {"grid.cell_size": {"x": ROWS, "y": 0.1}})
    assert len(graded.lines[0]) == 41
    finer = varied(graded, {"grid.cell_size.x.0.1": 0.025, "grid.cell_size.x.1.1": 0.025})
    assert len(finer.lines[0]) > 60


WRONG: dict[str, tuple[Any, str, list[str]]] = {
    "one row": ({"x": [[0, 1]], "y": 1}, "grid.cell_size.x", ["at least two rows"]),
    "no rows": ({"x": [], "y": 1}, "grid.cell_size.x", ["at least two rows"]),
    "three numbers": ({"x": [[0, 1, 2], [3, 1, 2]], "y": 1}, "grid.cell_size.x", ["(place, size)"]),
    "a list of numbers": ({"x": [1, 2], "y": 1}, "grid.cell_size.x", ["(place, size)"]),
    "not ascending": (
        {"x": [[0, 1], [5, 1], [4, 1]], "y": 1},
        "grid.cell_size.x",
        ["must increase", "4 follows 5", "sort"],
    ),
    "twice": ({"x": [[2, 1], [2, 1]], "y": 1}, "grid.cell_size.x", ["2 follows 2"]),
    "not positive": ({"x": [[0, 1], [5, 0]], "y": 1}, "grid.cell_size.x[1]", ["greater than zero"]),
    "text": ({"x": [["0", 1], [5, 1]], "y": 1}, "grid.cell_size.x[0]", ["without quotes"]),
    "unknown axis": ({"x": 1, "y": 1, "r": 1}, "grid.cell_size.r", ["names no axis", '"x"']),
    "missing": ({"x": ROWS}, "grid.cell_size.y", ["missing", "rows (place, size)"]),
    "empty": ({}, "grid.cell_size.x", ["missing"]),
    "z in 2D": ({"x": 1, "y": 1, "z": 1}, "grid.cell_size", ["names the z direction"]),
    "no whole number": (
        {"x": [[0, 1], [1.45, 1]], "y": 1},
        "grid.cell_size.x",
        ["between the places 0 and 1.45", "room for 1.4 cells", "more than a third", "move"],
    ),
    "too steep": (
        {"x": [[0, 0.1], [1, 0.1], [1.3, 0.3], [4, 0.3]], "y": 1},
        "grid.cell_size.x",
        ["at 1.10981 a cell of 0.1098 is beside one of 0.1902", "1.5", "more distance"],
    ),
    "steep at a place": (
        {"y": [[0, 1], [5, 1], [5.6, 0.4], [10, 0.4]], "x": 1},
        "grid.cell_size.y",
        ["at 5 a cell of 1 is beside one of 0.6", "closer"],
    ),
    "too small": ({"x": [[0, 1], [9, 1], [12, 1e-25]], "y": 1}, "grid.cell_size.x", ["too small"]),
    "too many": ({"x": [[0, 1e-3], [1e3, 1e-3]], "y": 1}, "grid.cell_size.x", ["1e+06 cells"]),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_sizes(name: str) -> None:
    size, key, parts = WRONG[name]
    error = refused({"cell_size": size})
    assert error.key == key
    for part in parts:
        assert part in str(error)


def test_sizes_of_a_third_axis_are_needed_in_3d() -> None:
    assert refused({"cell_size": {"x": ROWS, "y": 1}}, "3d").key == "grid.cell_size.z"
    model = Model.from_dict(entries({"cell_size": {"x": ROWS, "y": 0.1, "z": ROWS}}, "3d"))
    assert background_grid(model).graded == [0, 2]


def test_an_origin_along_a_graded_axis() -> None:
    error = refused({"cell_size": {"x": ROWS, "y": 0.1}, "origin": [0.5, 0.0]})
    assert error.key == "grid.origin"
    assert "along x the origin is the first place of grid.cell_size, 0" in str(error)


def test_all_wrong_sizes_are_named_together() -> None:
    text = str(refused({"cell_size": {"x": [[0, 1]], "y": -1}}))
    assert "grid.cell_size.x" in text
    assert "grid.cell_size.y" in text


def test_a_condition_between_graded_lines() -> None:
    wall = {"type": "plane", "name": "wall", "axis": "x", "condition": "roller"}
    base = entries({"cell_size": 0.1})["boundaries"][0]
    grid = {"cell_size": {"x": ROWS, "y": 0.1}}
    line = line_of(tuple(map(tuple, ROWS)))
    Model.from_dict(entries(grid, boundaries=[base, {**wall, "at": float(line[25])}]))
    error = refused(grid, boundaries=[base, {**wall, "at": 3.0}])
    above = int(np.searchsorted(line, 3.0))
    assert error.key == "boundaries[1].at"
    assert f"x = {line[above - 1]:.9g} and {line[above]:.9g}" in str(error)


def test_places_far_from_zero_are_refused() -> None:
    rows = [[1e12, 0.5], [1e12 + 2.0, 0.5]]
    assert refused({"cell_size": {"x": rows, "y": 0.5}}).key == "grid.cell_size.x"


def test_cells_too_elongated_anywhere_are_refused() -> None:
    error = refused({"cell_size": {"x": [[0, 1e-3], [1, 1e-3], [400, 100]], "y": 0.1}})
    assert error.key == "grid.cell_size"
    assert "more than 10000" in str(error)


def footing(grid: dict[str, Any]) -> Model:
    """A boundary that moves by (0.5, -0.25), and a grid that may follow it."""
    plate = {
        "name": "plate", "type": "implicit", "condition": "fixed",
        "geometry": {"type": "plane", "point": [0.0, 1.0], "normal": [0.0, -1.0]},
        "displacement": {"x": 0.5, "y": -0.25},
    }  # fmt: skip
    return Model.from_dict(entries(grid, boundaries=[plate]))


def test_a_long_spline_may_lie_in_large_cells() -> None:
    """It passes through 300 cells; in cells of the smallest size they would be 20,000."""
    vertices = [[float(x), 0.0] for x in range(0, 1001, 100)]
    line = {"type": "spline", "vertices": vertices, "soil": "left"}
    bed = {"name": "bed", "type": "implicit", "geometry": line, "condition": "fixed"}
    rows = [[0, 0.05], [1, 0.05], [100, 5.0], [1000, 5.0]]
    Model.from_dict(entries({"cell_size": {"x": rows, "y": 0.1}}, boundaries=[bed]))
    error = refused({"cell_size": {"x": 0.05, "y": 0.1}}, boundaries=[bed])
    assert "passes through about 2e+04 cells" in str(error)


FOLLOWED = [[-1.0, 0.4], [-0.2, 0.1], [0.0, 0.1], [0.5, 0.1]]


def test_graded_lines_follow_a_point_of_a_boundary() -> None:
    from tilth.analysis.grid_motion import GridMotion
    from tilth.boundaries import make_implicit

    follow = {"boundary": "plate", "place": [0.3, 1.0], "axes": ["y"]}
    model = footing({"cell_size": {"x": ROWS, "y": FOLLOWED}, "follow": follow})
    assert model.origin == (0.0, 0.0)
    assert isinstance(model.boundaries[0], ImplicitBoundary)
    motion = GridMotion(model, make_implicit(model))
    for time in (0.0, 0.4, 1.0):
        grid = motion.at(time)
        assert grid.origin == pytest.approx([0.0, 1.0 - 1.0 - 0.25 * time], abs=1e-15)
        place = grid.in_cells(np.array([0.3, 1.0 - 0.25 * time]))[1]
        assert place == pytest.approx(round(place), abs=1e-12)
        assert grid.lines == background_grid(model).lines
        assert grid.position(np.array([0.0, place])) == pytest.approx([0.0, 1.0 - 0.25 * time])


def test_a_line_must_pass_through_the_point_that_is_followed() -> None:
    follow = {"boundary": "plate", "place": [0.3, 1.0], "axes": ["x"]}
    with pytest.raises(BadInput, match="relative to the point") as caught:
        footing({"cell_size": {"x": [[-1.0, 0.1], [0.5, 0.1]], "y": 0.1}, "follow": follow})
    assert caught.value.key == "grid.cell_size.x"


def test_the_grid_of_a_stage() -> None:
    stages = [
        {"name": "one", "schedule": {"steps": 1}},
        {"name": "two", "schedule": {"steps": 1}, "grid": {"cell_size": {"x": ROWS, "y": 0.1}}},
    ]
    given = {k: v for k, v in entries({"cell_size": 0.25}).items() if k != "schedule"}
    model = Model.from_dict({**given, "stages": stages})
    first, second = (background_grid(each) for each in model.of_stages)
    assert first.lines == ()
    assert second.graded == [0]
    assert Model.from_dict(json.loads(json.dumps(model.to_dict()))) == model
    back = {"name": "three", "schedule": {"steps": 1}, "grid": {"cell_size": 0.25}}
    shifted = [[-0.4, 0.1], [1.0, 0.1]]
    stages[1]["grid"] = {"cell_size": {"x": shifted, "y": 0.1}}
    of_stages = Model.from_dict({**given, "stages": [*stages, back]}).of_stages
    assert [each.origin for each in of_stages] == [(0.0, 0.0), (-0.4, 0.0), (-0.4, 0.0)]
    stages[1]["grid"] = {"cell_size": {"x": ROWS}, "origin": [1.0, 0.0]}
    with pytest.raises(BadInput) as caught:
        Model.from_dict({**given, "stages": stages})
    assert "stages[1].grid.cell_size.y" in str(caught.value)
    assert "stages[1].grid.origin" in str(caught.value)
