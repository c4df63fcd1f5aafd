# SPDX-License-Identifier: BSD-3-Clause
"""Analyses with parameters that vary from place to place: results, checkpoints, pictures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, entries_of, run_until
from small_problems import BASES, KINDS, block_entries, material_entries, rollers, weight

from tilth import BadInput, Model, resume, run
from tilth.analysis.march import march
from tilth.analysis.memory import memory_of
from tilth.analysis.simulation import Simulation
from tilth.cli import run_command
from tilth.mpm.initial_points import initial_points
from tilth.output import read_results
from tilth.report.setup_file import read_setup

UP = {"plane_strain": "y", "axisymmetric": "y", "3d": "z"}


def with_stiffness(kind: str, basis: str, young_modulus: Any, **changed: Any) -> dict[str, Any]:
    """A block of two cells a side that sinks a little under its own weight, nu 0."""
    entries = block_entries(
        kind, basis, loads=[weight(kind, 1e-3)], boundaries=rollers(kind), **changed
    )
    entries["materials"]["soil"] = material_entries(
        "hencky_elastic", young_modulus=young_modulus, poisson_ratio=0.0
    )
    return entries


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
def test_a_constant_table_is_the_number(kind: str, basis: str) -> None:
    """To the bit, in all kinds of analysis and with all bases."""
    table = {"axis": UP[kind], "values": [[-1, 2000.0], [3, 2000.0]]}
    one, other = (
        march(Model.from_dict(with_stiffness(kind, basis, value))).state.points
        for value in (2000.0, table)
    )
    np.testing.assert_array_equal(one.stress, other.stress)
    np.testing.assert_array_equal(one.position, other.position)


def test_a_jump_in_a_table_is_two_layers() -> None:
    table = {"axis": "y", "values": [[-1, 1000.0], [1 - 1e-9, 1000.0], [1, 3000.0], [3, 3000.0]]}
    entries = with_stiffness("plane_strain", "linear", 1000.0)
    varying = with_stiffness("plane_strain", "linear", table)
    entries["materials"]["top"] = {**entries["materials"]["soil"], "young_modulus": 3000.0}
    entries["bodies"][0] |= {"layers": [{"material": "top", "bottom": 1.0}, {"material": "soil"}]}
    del entries["bodies"][0]["material"]
    layers, table_points = (march(Model.from_dict(e)).state.points for e in (entries, varying))
    first, second = (
        np.lexsort(np.round(p.position - p.displacement, 9).T) for p in (layers, table_points)
    )
    scale = np.abs(layers.stress).max()
    np.testing.assert_allclose(
        layers.stress[first], table_points.stress[second], rtol=0, atol=1e-9 * scale
    )


def test_settlement_of_a_column_whose_stiffness_grows_with_depth() -> None:
    """du/dz = rho g z / (E_0 + k z) for small strain: w = rho g [H/k - E_0/k^2 ln(1 + k H/E_0)]."""
    height, start, growth, load = 2.0, 1000.0, 1500.0, 2e-3
    table = {"depth": [[0, start], [height, start + growth * height]], "surface": height}
    entries = with_stiffness("plane_strain", "linear", table)
    exact = load * (height / growth - start / growth**2 * math.log(1.0 + growth * height / start))
    errors = []
    for cells in (8, 16):
        entries["grid"]["cell_size"] = height / cells
        entries["track"] = [
            {"name": "w", "quantity": "displacement", "at": [1.0, 2.0], "component": "y"}
        ]
        points = march(Model.from_dict(entries)).state.points
        top = points.displacement[points.position[:, 1].argmax(), 1]
        half = 0.25 * height / cells  # of the highest point below the surface; stress is 0 there
        errors.append(abs(-top - exact) / exact)
        assert half < 0.1
    assert errors[1] < 2e-3
    assert errors[1] < 0.35 * errors[0]  # second order


@pytest.mark.parametrize("distribution", ["normal", "lognormal"])
def test_a_random_strength_is_reached_but_not_exceeded(distribution: str) -> None:
    """Each point yields at its own strength, also where the points are sorted anew."""
    entries = entries_of("plane_strain", "gimp")
    entries["analysis"]["maximum_iterations"] = 20
    entries["materials"]["soil"]["yield_stress"] = random_strength(distribution)
    entries["materials"]["soil"]["hardening_modulus"] = 0.0
    model = Model.from_dict(entries)
    points = march(model).state.points
    assert (np.diff(points.point_id) < 0).any()  # they are
    own = points.varying["yield_stress"][points.point_id]
    column = points.ranges[0].law.parameters.index("yield_stress")
    np.testing.assert_array_equal(points.parameters[:, column], own)
    stress = points.stress * points.volume[:, None] / points.initial_volume[:, None]
    deviator = stress.copy()
    deviator[:, :3] -= stress[:, :3].mean(axis=1, keepdims=True)
    size = np.sqrt(1.5 * ((deviator[:, :3] ** 2).sum(1) + 2 * (deviator[:, 3:] ** 2).sum(1)))
    assert (size <= own * (1.0 + 1e-9)).all()
    assert np.ptp(own) > 0.5 * own.mean()
    flowing = points.elastic_share < 0.1
    assert flowing.sum() > 10
    np.testing.assert_allclose(size[flowing], own[flowing], rtol=1e-9)


def random_strength(distribution: str = "lognormal") -> dict[str, Any]:
    return {
        "random": {
            "mean": 25.0,
            "coefficient_of_variation": 0.2,
            "correlation_lengths": 0.3,
            "distribution": distribution,
            "model": "gaussian",
            "seed": 11,
        }
    }


def random_entries(folder: Path) -> dict[str, Any]:
    """The block of the resumed runs; strength, stiffness and ratio vary in three ways."""
    (folder / "young.csv").write_text("y,value\n-1,900\n2,1100\n", encoding="utf-8")
    (folder / "ratio.py").write_text("def nu(x):\n    return 0.3 + 0.05 * x[:, 0]\n")
    entries = entries_of()
    entries["materials"]["soil"] |= {
        "yield_stress": random_strength(),
        "young_modulus": {"file": str(folder / "young.csv")},
        "poisson_ratio": f"{folder / 'ratio.py'}:nu",
    }
    return entries


def test_resumed_runs_have_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = Model.from_dict(random_entries(tmp_path))
    run(model, tmp_path / "whole", quiet=True)
    run_until(model, tmp_path / "out", 4, monkeypatch)
    resume(tmp_path / "out", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "out")


@pytest.mark.parametrize("file", ["young.csv", "ratio.py"])
def test_a_changed_file_is_noticed(
    file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = Model.from_dict(random_entries(tmp_path))
    run_until(model, tmp_path / "out", 3, monkeypatch)
    before = (tmp_path / file).read_text(encoding="utf-8")
    changed = before.replace("1100", "1101").replace("0.05", "0.0501")
    (tmp_path / file).write_text(changed, encoding="utf-8")
    with pytest.raises(BadInput, match="'parameters' are not those of the model") as caught:
        resume(tmp_path / "out", quiet=True)
    assert "has changed" in str(caught.value)
    (tmp_path / file).write_text(before, encoding="utf-8")
    assert resume(tmp_path / "out", quiet=True).finished


def test_results_and_report_have_the_parameters(tmp_path: Path) -> None:
    entries = random_entries(tmp_path)
    entries["output"] = {"report": True}
    entries["units"] = {"stress": "kPa", "length": "m"}
    entries["schedule"] = {"steps": 4, "outputs": 2}
    model = Model.from_dict(entries)
    points = initial_points(model)
    folder = run(model, tmp_path / "out", quiet=True).folder
    results = read_results(folder / "results.vtkhdf")
    page = (folder / "report.html").read_text(encoding="utf-8")
    for name in ("yield_stress", "young_modulus", "poisson_ratio"):
        for index in (0, -1):
            stored = results.snapshot(index).point_fields[name]
            np.testing.assert_array_equal(stored, points.varying[name])
        assert f"{name.replace('_', ' ')} at the start: " in page
    expected = 900.0 + 200.0 / 3.0 * (points.position[:, 1] + 1.0)
    np.testing.assert_allclose(points.varying["young_modulus"], expected, rtol=1e-14)
    assert "hardening_modulus" not in results.snapshot(0).point_fields
    assert len(read_setup(folder / "setup.npz", results.snapshot(0)).position) == len(points)


def test_where_a_material_has_no_such_parameter_there_is_no_number() -> None:
    entries = with_stiffness(
        "plane_strain", "linear", {"axis": "x", "values": [[0, 1e3], [3, 2e3]]}
    )
    rock = {**entries["bodies"][0], "name": "rock", "material": "rock"}
    rock["shape"] = {"type": "box", "lower": [2.0, 0.0], "upper": [4.0, 2.0]}
    entries["bodies"].append(rock)
    entries["materials"]["rock"] = material_entries("hencky_elastic")
    points = initial_points(Model.from_dict(entries))
    young = points.varying["young_modulus"]
    np.testing.assert_array_equal(np.isnan(young), points.body_id == 1)


def test_check_draws_each_parameter(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "column.toml"
    file.write_text(CASE, encoding="utf-8")
    assert run_command(["check", str(file)]) == 0
    shown = capsys.readouterr().out
    for name in ("young_modulus", "layer"):
        picture = tmp_path / f"column.setup.{name}.png"
        assert picture.stat().st_size > 5_000
        assert f"{name.replace('_', ' ')} drawn in {picture}" in shown
    assert (tmp_path / "column.setup.png").is_file()
    assert "young modulus by depth 1000 to 5000 Pa" in " ".join(shown.split())


CASE = """
format = 1
[units]
stress = "Pa"
[analysis]
kind = "plane_strain"
[grid]
cell_size = 1.0
[materials.sand]
model = "hencky_elastic"
young_modulus = { depth = [[0, 1e3], [4, 5e3]], surface = 4 }
poisson_ratio = 0.3
[materials.rock]
model = "hencky_elastic"
young_modulus = 1e6
poisson_ratio = 0.3
[[bodies]]
name = "ground"
shape = { type = "box", lower = [0, 0], upper = [2, 4] }
basis = "linear"
points_per_cell = 2
[[bodies.layers]]
material = "sand"
bottom = 2
[[bodies.layers]]
material = "rock"
[[boundaries]]
name = "base"
type = "plane"
axis = "y"
at = 0
condition = "fixed"
[schedule]
steps = 1
"""


def test_stiffness_by_the_initial_stress() -> None:
    """E grows with the square root of the depth under K0 conditions, frozen at the start."""
    law = {"reference": 3e4, "reference_pressure": 10.0, "exponent": 0.5, "stress": "minor"}
    entries = with_stiffness("plane_strain", "gimp", law)
    entries["loads"] = [{**weight("plane_strain", 10.0), "factor": [[0, 1], [1, 1]]}]
    entries["initial"] = {"stress": [{"type": "k0", "body": "block", "K0": 0.4, "ground": 2.0}]}
    points = initial_points(Model.from_dict(entries))
    minor = 0.4 * 2.0 * 10.0 * (2.0 - points.position[:, 1])
    exact = 3e4 * np.sqrt(minor / 10.0)
    np.testing.assert_allclose(points.varying["young_modulus"], exact, rtol=1e-13)
    np.testing.assert_allclose(points.elastic_moduli().young, exact, rtol=1e-13)
    del entries["initial"]
    with pytest.raises(BadInput, match=r"young_modulus: depends on the initial stress"):
        initial_points(Model.from_dict(entries))


def test_relations_of_two_parameters_are_checked_at_the_points() -> None:
    sand = {
        "model": "mohr_coulomb",
        "young_modulus": 1e4,
        "poisson_ratio": 0.3,
        "cohesion": 1.0,
        "friction_angle": {"axis": "x", "values": [[0, 30.0], [2, 40.0]]},
        "dilation_angle": {"axis": "y", "values": [[0, 0.0], [2, 40.0]]},
    }
    entries = block_entries("plane_strain", "linear", materials={"soil": sand})
    with pytest.raises(BadInput, match=r"materials.soil.dilation_angle = 35.0: is greater") as one:
        initial_points(Model.from_dict(entries))
    assert "at the material point at (0.25, 1.75)" in str(one.value)
    sand["dilation_angle"] = {"axis": "y", "values": [[0, 0.0], [2, 30.0]]}
    points = initial_points(Model.from_dict(entries))
    assert points.parameters.shape == (16, len(points.ranges[0].law.parameters))


def test_results_do_not_depend_on_the_units() -> None:
    """Lengths in millimetres and stresses in kPa: the same strains."""
    strains = []
    for length, stress in ((1.0, 1.0), (1000.0, 1e-3)):
        depth = [[0.0, 1e3 * stress], [2.0 * length, 4e3 * stress]]
        entries = with_stiffness("plane_strain", "gimp", {"depth": depth, "surface": 2.0 * length})
        field = {
            "mean": 5.0 * stress,
            "coefficient_of_variation": 0.3,
            "correlation_lengths": [1.0 * length, 0.5 * length],
            "distribution": "lognormal",
            "model": "exponential",
            "seed": 5,
            "gradient": 1.0 * stress / length,
            "surface": 2.0 * length,
        }
        young = entries["materials"]["soil"]["young_modulus"]
        entries["materials"]["soil"] = material_entries("von_mises", density=2.0)
        entries["materials"]["soil"] |= {
            "young_modulus": young,
            "yield_stress": {"random": field},
            "hardening_modulus": 40.0 * stress,
            "density": 2.0 * stress / length,
        }
        entries["loads"] = [weight("plane_strain", 6.0)]
        entries["grid"]["cell_size"] = length
        entries["bodies"][0]["shape"]["upper"] = [2.0 * length] * 2
        for boundary in entries["boundaries"]:
            boundary["at"] *= length
        points = march(Model.from_dict(entries)).state.points
        assert points.plastic[:, 0].max() > 1e-3
        order = np.argsort(points.point_id)
        strains.append(points.deformation_gradient[order])
    np.testing.assert_allclose(strains[1], strains[0], atol=1e-7)


def test_the_estimate_of_memory_counts_them() -> None:
    table = {"axis": "y", "values": [[-1, 1e3], [3, 2e3]]}
    entries = [with_stiffness("plane_strain", "linear", value) for value in (1e3, table)]
    number, varying = (
        memory_of(Model.from_dict(each)).parts["the material points"] for each in entries
    )
    assert varying > number


def test_a_point_outside_a_table_is_refused_before_the_run(tmp_path: Path) -> None:
    table = {"depth": [[0, 1e3], [1, 2e3]], "surface": 2.0}
    with pytest.raises(BadInput, match=r"materials.soil.young_modulus.depth: .* outside the table"):
        Simulation(Model.from_dict(with_stiffness("plane_strain", "linear", table)))
