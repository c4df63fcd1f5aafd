# SPDX-License-Identifier: BSD-3-Clause
"""A step that fails is undone completely; smaller steps rescue it, or the analysis says why not."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from small_problems import (
    BASES,
    KINDS,
    STEP_MATERIALS,
    WEAK,
    assert_same_bits,
    block_entries,
    by_number,
    material_entries,
    plane,
    rollers,
    weight,
)

from tilth import AnalysisFailed, Model, run
from tilth.analysis.simulation import Simulation
from tilth.cli import run_command
from tilth.errors import StepFailed
from tilth.output import read_history, read_results


def heavy(kind: str, basis: str, material: str, load: float, **changed: Any) -> dict[str, Any]:
    """A block that stands on its base between no side walls, under gravity."""
    entries = block_entries(
        kind, basis, material, boundaries=rollers(kind, sides=False), loads=[weight(kind, load)]
    )
    entries["materials"]["soil"] = material_entries(material, **WEAK.get(material, {}))
    if material == "von_mises":
        entries["materials"]["soil"]["hardening_modulus"] = 0.0
    return {**entries, **changed}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("material", STEP_MATERIALS)
def test_failed_step_leaves_no_trace(kind: str, basis: str, material: str) -> None:
    simulation = Simulation(Model.from_dict(heavy(kind, basis, material, 1e4)))
    simulation.advance(0.0, 2e-4)
    simulation.advance(2e-4, 4e-4)
    before = by_number(simulation.state.points)
    with pytest.raises(StepFailed):
        simulation.advance(4e-4, 1.0)
    after = by_number(simulation.state.points)
    for name, array in before.items():
        assert array.tobytes() == after[name].tobytes(), f"{name} was changed by a failed step"


@pytest.mark.parametrize("basis", BASES)
def test_step_after_a_failed_one_is_the_same_as_without_it(basis: str) -> None:
    """Undo is complete: also nothing hidden outside the points remembers the failure."""
    entries = heavy("plane_strain", basis, "von_mises", 1e4)
    clean, troubled = (Simulation(Model.from_dict(entries)) for _ in range(2))
    for simulation in (clean, troubled):
        simulation.advance(0.0, 2e-4)
    with pytest.raises(StepFailed):
        troubled.advance(2e-4, 1.0)
    one = clean.advance(2e-4, 4e-4)
    other = troubled.advance(2e-4, 4e-4)
    assert_same_bits(clean.state.points, troubled.state.points)
    assert one.equilibrium.residuals == other.equilibrium.residuals


def test_point_that_leaves_the_grid_fails_the_step() -> None:
    entries = heavy("plane_strain", "linear", "hencky_elastic", 190.0)
    entries["grid"]["limits"] = {"lower": [0.0, 0.0], "upper": [2.0, 2.0]}
    simulation = Simulation(Model.from_dict(entries))
    with pytest.raises(StepFailed, match="left the limits of the grid") as failure:
        for k in range(20):  # it swells sideways
            simulation.advance(k / 20, (k + 1) / 20)
    assert simulation.state.points.position[:, 0].max() <= 2.0
    index = simulation.state.points.index_of(np.array([failure.value.point]))[0]
    assert simulation.state.points.position[index, 0] > 1.6


@pytest.fixture
def too_large_a_step() -> dict[str, Any]:
    """An elastic block whose whole weight in one step is too much for plain Newton."""
    entries = heavy("plane_strain", "linear", "hencky_elastic", 700.0)
    entries["boundaries"] = rollers("plane_strain")
    entries["analysis"]["line_search"] = False
    entries["track"] = [
        {"name": "base", "quantity": "reaction", "boundary": "low y", "component": "y"}
    ]
    entries["output"] = {"report": False}
    return entries


def test_adaptive_steps_rescue_a_step_that_is_too_large(
    too_large_a_step: dict[str, Any], tmp_path: Path
) -> None:
    rigid = too_large_a_step | {"schedule": {"steps": 1, "outputs": 1, "adaptive": False}}
    with pytest.raises(AnalysisFailed):
        run(Model.from_dict(rigid), tmp_path / "rigid", quiet=True)
    adaptive = too_large_a_step | {"schedule": {"steps": 1, "outputs": 1}}
    result = run(Model.from_dict(adaptive), tmp_path / "adaptive", quiet=True)
    assert result.steps > 1
    assert result.history["time"][-1] == 1.0
    total = 700.0 * result.points.mass.sum()
    assert result.history["base [N/m]"][-1] == pytest.approx(total, rel=1e-7)
    log = (tmp_path / "adaptive" / "log.txt").read_text()
    assert "inverted" in log or "no equilibrium" in log


@pytest.fixture
def beyond_the_limit_load() -> dict[str, Any]:
    """A perfectly plastic block pulled by forces beyond what it can carry.

    Frictionless base, plane strain: the limit stress is 2/sqrt(3) of the yield stress, 20.
    """
    entries = heavy("plane_strain", "linear", "von_mises", 0.0)
    entries["grid"]["cell_size"] = 2.0  # one cell: three quarters of the force act on its top
    del entries["materials"]["soil"]["density"]
    entries["boundaries"] = [plane("base", "y", 0.0), plane("middle", "x", 0.0)]
    entries["loads"] = [
        {"type": "point_force", "body": "block", "at": [x, 1.5], "force": [0.0, 40.0]}
        for x in (0.5, 1.5)
    ]
    entries["schedule"] = {"steps": 10, "minimum_step": 0.05, "output_every": 1}
    entries["track"] = [
        {"name": "base", "quantity": "reaction", "boundary": "base", "component": "y"}
    ]
    return entries


def test_limit_load_ends_the_analysis_with_all_that_is_needed(
    beyond_the_limit_load: dict[str, Any], tmp_path: Path
) -> None:
    with pytest.raises(AnalysisFailed) as failure:
        run(Model.from_dict(beyond_the_limit_load), tmp_path / "out", quiet=True)
    text = str(failure.value)
    history = read_history(tmp_path / "out" / "history.csv")
    last = int(history["step"][-1])
    assert last >= 2
    assert f"step {last + 1} to time" in text
    shown = text.split("relative residuals: ")[1].split(";")[0].split()
    residuals = [float(value) for value in shown if value != "..."]
    assert len(residuals) == 7
    assert min(residuals) > 1e-4  # it is not round-off that is left
    assert "worst point: number " in text
    # everything up to then is there and balanced
    reached = -80.0 * history["time"]
    np.testing.assert_allclose(history["base [N/m]"], reached, rtol=1e-6, atol=1e-9)
    # and the load it stopped at is the limit load
    limit = 2.0 * 20.0 * 2.0 / np.sqrt(3.0) / 0.75
    assert 0.95 * limit < -reached[-1] < limit
    with h5py.File(tmp_path / "out" / "results.vtkhdf") as results:
        assert len(results["VTKHDF"]["points"]["Steps"]["Values"]) >= 3
    assert text.splitlines()[0] in (tmp_path / "out" / "log.txt").read_text() or (
        failure.value.message in (tmp_path / "out" / "log.txt").read_text()
    )


def test_the_last_equilibrium_of_a_failed_analysis_is_shown(
    beyond_the_limit_load: dict[str, Any], tmp_path: Path
) -> None:
    beyond_the_limit_load["schedule"] = {"steps": 10, "minimum_step": 0.5, "outputs": 1}
    with pytest.raises(AnalysisFailed):
        run(Model.from_dict(beyond_the_limit_load), tmp_path / "out", quiet=True)
    last = int(read_history(tmp_path / "out" / "history.csv")["step"][-1])
    assert last >= 2
    assert list(read_results(tmp_path / "out" / "results.vtkhdf").steps) == [0, last]
    assert "failed" in (tmp_path / "out" / "report.html").read_text()


def test_limit_load_gives_exit_code_one(
    beyond_the_limit_load: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "squeezed.toml"
    case.write_text(as_toml(Model.from_dict(beyond_the_limit_load).to_dict()), encoding="utf-8")
    assert run_command(["run", str(case), "--quiet", "--out", str(tmp_path / "out")]) == 1
    assert "failed: " in capsys.readouterr().err
    assert (tmp_path / "out" / "history.csv").exists()


def as_toml(entries: dict[str, Any]) -> str:
    """A case file of a model's dictionary: inline tables throughout."""

    def value(item: Any) -> str:
        if isinstance(item, dict):
            return "{" + ", ".join(f"{json.dumps(k)} = {value(v)}" for k, v in item.items()) + "}"
        if isinstance(item, list):
            return "[" + ", ".join(map(value, item)) + "]"
        return json.dumps(item)

    return "\n".join(f"{key} = {value(item)}" for key, item in entries.items()) + "\n"
