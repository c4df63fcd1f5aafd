# SPDX-License-Identifier: BSD-3-Clause
"""Whole runs on graded grids: resumed ones, stages that change the grid, a grid that follows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, entries_of, run_until
from small_problems import BASES, KINDS
from staged_problems import staged_entries

from tilth import Model, resume, run
from tilth.analysis.dynamics import WITHIN
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.mpm.points import MaterialPoints
from tilth.output import read_results
from tilth.report.setup_file import read_setup
from tilth_verification.cases import example, varied

pytestmark = pytest.mark.slow

UP = {"plane_strain": "y", "axisymmetric": "y", "3d": "z"}
FINE_BELOW = [[0.0, 0.1], [0.3, 0.1], [1.0, 0.3]]
"""Lines at 0, 0.1, 0.2, 0.3 and, with growing distances, up to 1."""


def squeezed(kind: str, basis: str = "gimp", **grid: Any) -> Model:
    """The block of `entries_of` on a grid that is fine at its base."""
    entries = entries_of(kind, basis)
    size: dict[str, Any] = dict.fromkeys("xyz"[: 3 if kind == "3d" else 2], 0.5)
    entries["grid"]["cell_size"] = {**size, UP[kind]: FINE_BELOW, **grid}
    return Model.from_dict(entries)


@pytest.mark.parametrize(
    ("kind", "basis"), [*((kind, "gimp") for kind in KINDS), *(("plane_strain", b) for b in BASES)]
)
def test_a_resumed_run_ends_in_the_same_bits(
    kind: str, basis: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = squeezed(kind, basis)
    run(model, tmp_path / "whole", quiet=True)
    run_until(model, tmp_path / "out", 5, monkeypatch)
    resume(tmp_path / "out", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "out")


@pytest.mark.parametrize("kind", KINDS)
def test_equal_cells_given_by_places_are_a_uniform_grid(kind: str) -> None:
    uniform, places = (
        march(squeezed(kind, **{UP[kind]: rows})) for rows in (0.25, [[0.0, 0.25], [0.75, 0.25]])
    )
    for name in ("position", "stress"):
        one, other = (getattr(each.state.points, name) for each in (uniform, places))
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-8 * np.abs(one).max())


def graded_stages(kind: str) -> dict[str, Any]:
    """The problem of `staged_entries`; its last grid is graded, and so is the first one in 3D."""
    entries = staged_entries(kind)
    size: dict[str, Any] = dict.fromkeys("xyz"[: 3 if kind == "3d" else 2], 0.5)
    stage = entries["stages"][-1]
    rows = [[0.0, 0.5], [1.0, 0.25], [2.0, 0.25]]
    stage["grid"] = {"cell_size": {**size, "x": 0.25, UP[kind]: rows}}
    return entries


@pytest.mark.parametrize("kind", KINDS)
def test_a_stage_goes_on_with_a_graded_grid(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also after a stop within this stage; the set-up and its lines are stored."""
    model = Model.from_dict(graded_stages(kind))
    result = run(model, tmp_path / "whole", quiet=True)
    assert result.finished
    run_until(model, tmp_path / "out", 9, monkeypatch)
    resume(tmp_path / "out", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "out")


def test_the_stored_set_up_has_the_lines(tmp_path: Path) -> None:
    model = squeezed("plane_strain")
    folder = run(model, tmp_path / "out", quiet=True).folder
    setup = read_setup(folder / "setup.npz", read_results(folder / "results.vtkhdf").snapshot(0))
    np.testing.assert_array_equal(setup.lines[1], model.lines[1])
    assert setup.occupied_cells() == 2 * (len(model.lines[1]) - 1)


def pressed() -> dict[str, Any]:
    """Elastic ground, pressed by a plate that the fine cells follow."""
    shape = {"type": "box", "lower": [0.0, 0.0], "upper": [1.0, 2.0]}
    sides = [
        {"type": "plane", "name": name, "axis": "x", "at": at, "condition": "roller"}
        for name, at in (("left", 0.0), ("right", 1.0))
    ]
    planes = (("base", 0.0, 1.0, 0.0), ("plate", 2.0, -1.0, -0.3))
    implicit = [
        {
            "name": name, "type": "implicit", "condition": "roller", "displacement": {"y": moved},
            "geometry": {"type": "plane", "point": [0.0, at], "normal": [0.0, normal]},
        }
        for name, at, normal, moved in planes
    ]  # fmt: skip
    return {
        "format": 1,
        "analysis": {"kind": "plane_strain"},
        "grid": {
            "cell_size": {"x": 0.25, "y": [[-1.5, 0.4], [-0.5, 0.1], [0.0, 0.1], [0.2, 0.1]]},
            "follow": {"boundary": "plate", "place": [0.0, 2.0], "axes": ["y"]},
        },
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": 1e3, "poisson_ratio": 0.2}
        },
        "bodies": [
            {
                "name": "ground", "material": "soil", "shape": shape, "basis": "gimp",
                "points_per_cell": 2,
            }
        ],
        "boundaries": [*sides, *implicit],
        "schedule": {"steps": 6},
        "output": {"report": False},
    }  # fmt: skip


def test_the_fine_cells_follow_the_plate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A line is on the plate in every step; soil is compressed evenly; a resumed run is equal."""
    model = Model.from_dict(pressed())
    simulation = Simulation(model)
    for time in (0.0, 0.5, 1.0):
        grid = simulation.locate(time).grid
        on_plate = grid.in_cells(np.array([0.0, 2.0 - 0.3 * time]))[1]
        assert on_plate == pytest.approx(round(on_plate), abs=1e-9)
        assert grid.sizes_at(np.array([0.0, 2.0 - 0.3 * time - 0.01]))[1] == pytest.approx(0.1)
    result = run(model, tmp_path / "whole", quiet=True)
    final = result.points
    vertical = np.log(1.7 / 2.0)
    modulus = 1e3 * (1.0 - 0.2) / (1.2 * 0.6)
    np.testing.assert_allclose(final.stress[:, 1] * 0.85, modulus * vertical, rtol=1e-3)
    run_until(model, tmp_path / "out", 3, monkeypatch)
    resume(tmp_path / "out", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "out")


@pytest.mark.parametrize("size", [0.25, {"x": 0.25, "y": FINE_BELOW}])
def test_dynamic_steps_keep_the_limits_of_the_cells_of_each_point(size: Any) -> None:
    """A block whose top is pushed down, on a uniform and on a graded grid."""
    entries = entries_of()
    entries["grid"]["cell_size"] = size
    entries["units"] = {"time": "s"}
    limits = {"largest_motion": 0.01, "largest_error": 1e-3}
    entries["analysis"]["inertia"] = {"scheme": "newmark", **limits}
    entries["schedule"] = {"steps": 2, "end": 0.05}
    simulation = march(Model.from_dict(entries))
    points = simulation.state.points
    moved = np.abs(points.last_displacement / simulation.state.grid.sizes_at(points.position)).max()
    assert 0.0 < moved < 1.1 * limits["largest_motion"] / WITHIN


def footing(length: float = 1.0, force: float = 1.0, steps: int = 6) -> Model:
    """The graded strip footing with larger cells; length, force: units in m and N."""

    def rows(*given: list[float]) -> list[list[float]]:
        return [[value / length for value in row] for row in given]

    stress = force / length**2
    changes: dict[str, Any] = {
        "grid.cell_size.x": rows([0.0, 0.1], [0.5, 0.05], [1.0, 0.1], [5.0, 0.6]),
        "grid.cell_size.y": rows([0.0, 0.6], [4.0, 0.1], [5.0, 0.05]),
        "materials.clay.young_modulus": 1e10 / stress,
        "materials.clay.yield_stress": 848.7e3 / stress,
        "bodies.0.shape.upper": [5.0 / length] * 2,
        "boundaries.1.at": 5.0 / length,
        "boundaries.3.at": 5.0 / length,
        "boundaries.3.range": {"x": [0.0, 0.5 / length]},
        "boundaries.3.displacement": {"y": -0.002 / length},
        "boundaries.3.factor": None,
        "schedule.steps": steps,
        "schedule.outputs": 1,
    }
    return varied(example("strip_footing", "graded.toml"), changes)


def pressed_in(model: Model) -> tuple[MaterialPoints, float]:
    """The final points and the last load per length of the half footing."""
    loads: list[float] = []
    simulation = march(
        model, lambda _, result, __: loads.append(-float(result.resultant("footing")[1]))
    )
    return simulation.state.points, loads[-1]


def test_results_do_not_depend_on_the_units() -> None:
    """In mm and kN, in steps that Newton's iteration takes without a line search."""
    found = []
    for length, force in ((1.0, 1.0), (1e-3, 1e3)):
        changes = {
            "boundaries.3.displacement": {"y": -0.0006 / length},
            "analysis.tolerance": 1e-10,
        }
        found.append(pressed_in(varied(footing(length, force, steps=12), changes)))
    (points, load), (other, in_kilonewton_per_mm) = found
    assert load > 0.9 * 5.14 * 245e3  # most of the soil under the footing yields
    np.testing.assert_allclose(1e-3 * other.position, points.position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(1e9 * other.stress, points.stress, rtol=0, atol=1e-8 * 848.7e3)
    assert in_kilonewton_per_mm * 1e6 == pytest.approx(load, rel=1e-9)


def test_one_step_reaches_the_limit_load_of_many() -> None:
    loads = [pressed_in(footing(steps=steps))[1] for steps in (1, 12)]
    assert loads[0] == pytest.approx(loads[1], rel=0.02)
