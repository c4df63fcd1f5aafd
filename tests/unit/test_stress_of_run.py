# SPDX-License-Identifier: BSD-3-Clause
"""Stress at the start by tables and from another run; what a run writes of its equilibrium."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, run_until
from small_problems import block_entries, material_entries, plane, rollers, weight

from tilth import BadInput, Model, load_case, resume, run
from tilth.arrays import Floats
from tilth.mpm.initial_points import initial_points
from tilth.output import read_results

FACTOR = [[0.0, 1.0], [1.0, 1.0]]


def block(law: str = "mohr_coulomb", **changed: Any) -> dict[str, Any]:
    """A block of two cells between rollers, pressed by a plate, with its weight."""
    entries = block_entries(
        "plane_strain", "gimp", law, loads=[weight("plane_strain", 5.0) | {"factor": FACTOR}],
        boundaries=[*rollers("plane_strain", sides=False), plane(
            "top", "y", 2.0, condition="prescribed", displacement={"y": -0.1}
        )],
        schedule={"steps": 4, "output_times": [0.5]},
    )  # fmt: skip
    entries["materials"]["soil"] = material_entries(law, **changed)
    entries["output"] = {"report": False}
    return entries


def with_stress(entries: dict[str, Any], **entry: Any) -> dict[str, Any]:
    return {**entries, "initial": {"stress": [{"body": "block", **entry}]}}


@pytest.fixture(scope="module")
def earlier(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("earlier") / "out"
    entries = block(cohesion=8.0)
    entries["initial"] = {"stress": [{"type": "k0", "body": "block", "K0": 0.6}]}
    result = run(Model.from_dict(entries), folder, quiet=True)
    assert result.points.plastic[:, 0].min() > 1e-3
    return folder


def at_ends(folder: Path) -> tuple[Floats, Floats, Floats]:
    output = read_results(folder / "results.vtkhdf").snapshot(-1)
    return output.position, output.point_fields["cauchy_stress"], output.point_fields[
        "plastic_strain"
    ]  # fmt: skip


def polygon_of(position: Floats) -> dict[str, Any]:
    """The block as it was pressed: a box whose points are not those of the other run."""
    half = 0.125
    lower, upper = position.min(axis=0), position.max(axis=0)
    return {"type": "box", "lower": list(lower - half), "upper": list(upper + half)}


def test_points_at_the_same_place_have_the_same_state(earlier: Path) -> None:
    """The same body at time 0.5 of the run, whose points moved: the first state at time 0."""
    entries = with_stress(block(cohesion=8.0), type="run", folder=str(earlier), time=0.0)
    points = initial_points(Model.from_dict(entries))
    first = read_results(earlier / "results.vtkhdf").snapshot(0)
    np.testing.assert_allclose(
        points.stress, first.point_fields["cauchy_stress"], rtol=1e-9, atol=1e-12
    )
    np.testing.assert_array_equal(points.position, first.position)


def test_state_between_the_points_of_the_other_run(earlier: Path) -> None:
    """A field that is linear in the places is reproduced between the points."""
    position, stress, plastic = at_ends(earlier)
    entries = block(cohesion=8.0)
    entries["bodies"][0]["shape"] = polygon_of(position)
    entries["boundaries"][2]["at"] = 3.0
    model = Model.from_dict(with_stress(entries, type="run", folder=str(earlier)))
    points = initial_points(model)
    assert points.stress.min() >= stress.min() - 1e-9
    assert points.stress.max() <= stress.max() + 1e-9
    assert plastic.min() <= points.plastic[:, 0].min() <= points.plastic[:, 0].max()
    assert points.plastic[:, 0].max() <= plastic.max()
    mean = points.volume @ points.stress[:, 1] / points.volume.sum()
    assert mean == pytest.approx(stress[:, 1].mean(), rel=0.05)


def test_state_variables_come_with_the_stress(tmp_path: Path) -> None:
    entries = with_stress(
        block("modified_cam_clay"), type="given", stress=[-100.0, -100.0, -100.0, 0.0]
    )
    run(Model.from_dict(entries), tmp_path / "clay", quiet=True)
    last = read_results(tmp_path / "clay" / "results.vtkhdf").snapshot(-1)
    entries["bodies"][0]["shape"] = polygon_of(last.position)
    entries["initial"]["stress"] = [
        {"type": "run", "body": "block", "folder": str(tmp_path / "clay")}
    ]
    points = initial_points(Model.from_dict(entries))
    name = "preconsolidation_pressure"
    hardened, field = points.state_variable(name), last.point_fields[name]
    assert np.ptp(field) > 0.5
    assert abs(field.mean() - 150.0) > 1.0  # it began with 150
    assert field.min() - 1e-9 <= hardened.min() <= hardened.max() <= field.max() + 1e-9
    assert hardened.mean() == pytest.approx(field.mean(), rel=0.02)


def test_stress_by_tables(tmp_path: Path) -> None:
    file = tmp_path / "lateral.csv"
    file.write_text("x,y,value\n0,0,30\n0,2,5\n2,0,20\n2,2,5\n")
    vertical = {"depth": [[0.0, 0.0], [1.0, 12.0], [2.0, 20.0]], "surface": 2.0}
    entries = with_stress(
        block(), type="table", vertical_pressure=vertical, horizontal_pressure={"file": str(file)}
    )
    points = initial_points(Model.from_dict(entries))
    x, y = points.position.T
    depth = 2.0 - y
    np.testing.assert_allclose(
        points.stress[:, 1], -np.interp(depth, [0.0, 1.0, 2.0], [0.0, 12.0, 20.0]), rtol=1e-13
    )
    lateral = 5.0 + 0.5 * depth * (25.0 - 5.0 * x)
    np.testing.assert_allclose(points.stress[:, 0], -lateral, rtol=1e-13)
    np.testing.assert_array_equal(points.stress[:, 0], points.stress[:, 2])
    elevation = {"axis": "y", "values": [[0.0, 0.5], [2.0, 1.0]]}
    entries = with_stress(block(), type="table", vertical_pressure=10.0, K0=elevation)
    points = initial_points(Model.from_dict(entries))
    np.testing.assert_allclose(points.stress[:, 0], -5.0 - 2.5 * points.position[:, 1], rtol=1e-13)


def stressed_by_gravity() -> dict[str, Any]:
    entries = with_stress(block(), type="gravity", steps=2)
    entries["boundaries"][2] = plane("top", "x", 2.0)  # a wall: the top is free
    return entries


@pytest.mark.slow
def test_the_report_of_a_run_says_how_it_began(tmp_path: Path) -> None:
    entries = stressed_by_gravity() | {"output": {"report": True}}
    run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    assert "equilibrium found in" in (tmp_path / "out" / "report.html").read_text()


def test_a_run_logs_its_equilibrium_and_starts_with_its_reactions(tmp_path: Path) -> None:
    entries = stressed_by_gravity()
    entries["track"] = [
        {"name": "base", "quantity": "reaction", "boundary": "low y", "component": "y"}
    ]
    result = run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    base = result.history["base [N/m]"]
    np.testing.assert_allclose(base, 5.0 * 2.0 * 4.0, rtol=1e-7)
    log = (tmp_path / "out" / "log.txt").read_text()
    sentence = "at the start: equilibrium found in "
    assert sentence in log
    assert "2 parts: relative residual" in log
    assert not result.points.displacement.max() > 1e-8


def test_a_run_from_an_equilibrium_is_resumed_to_the_last_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entries = with_stress(block(cohesion=8.0), type="k0", K0=0.6)
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True)
    run_until(model, tmp_path / "part", 1, monkeypatch)
    resume(tmp_path / "part", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "part")


def test_without_equilibrium_the_declared_stress_stays(tmp_path: Path) -> None:
    entries = with_stress(block(), type="given", stress=[-10.0, -10.0, -10.0, 0.0])
    entries["initial"]["equilibrium"] = False
    run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    first = read_results(tmp_path / "out" / "results.vtkhdf").snapshot(0)
    np.testing.assert_array_equal(first.point_fields["cauchy_stress"][:, :3], -10.0)
    assert "at the start" not in (tmp_path / "out" / "log.txt").read_text()


def below(entries: dict[str, Any]) -> dict[str, Any]:
    entries["bodies"][0]["shape"]["lower"] = [0.0, -2.0]
    return entries


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": 0.3}, r"time = 0.3: that run has no output at this time, only at 0, 0.5, 1"),
        ({"source": "rock"}, r"source = .rock.: there is no body .* in that run"),
        ({"folder": "/nowhere"}, r"folder = ./nowhere.: is not the folder of a finished run"),
    ],
)
def test_wrong_runs(earlier: Path, change: dict[str, Any], message: str) -> None:
    entry = {"type": "run", "folder": str(earlier), **change}
    with pytest.raises(BadInput, match=message):
        initial_points(Model.from_dict(with_stress(block(), **entry)))


def test_a_body_outside_the_soil_of_the_run(earlier: Path) -> None:
    entries = below(with_stress(block(), type="run", folder=str(earlier)))
    message = r"the point at \(.*\) lies outside the soil of that run"
    with pytest.raises(BadInput, match=message):
        initial_points(Model.from_dict(entries))


def test_a_run_of_another_kind(earlier: Path) -> None:
    entries = with_stress(block(), type="run", folder=str(earlier))
    entries["analysis"]["kind"] = "axisymmetric"
    with pytest.raises(BadInput, match="is a run of the kind 'plane_strain'"):
        initial_points(Model.from_dict(entries))


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"vertical_pressure": 10.0}, "K0: missing"),
        ({"vertical_pressure": 9.0, "K0": 1.0, "horizontal_pressure": 3.0}, "given together with"),
        ({"vertical_pressure": -1.0, "K0": 1.0}, "must not be negative"),
        (
            {"vertical_pressure": {"depth": [[0, 1], [1, 2]], "surface": 2.0}, "K0": 1.0},
            "is outside the table: its depth is",
        ),
    ],
)
def test_wrong_tables(entry: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        initial_points(Model.from_dict(with_stress(block(), type="table", **entry)))


CASE = """
format = 1
[analysis]
kind = "plane_strain"
[grid]
cell_size = 1.0
[materials.soil]
model = "hencky_elastic"
young_modulus = 1e3
poisson_ratio = 0.3
[[bodies]]
name = "block"
material = "soil"
shape = { type = "box", lower = [0.0, 0.0], upper = [2.0, 2.0] }
basis = "gimp"
points_per_cell = 2
[[boundaries]]
name = "base"
type = "plane"
axis = "y"
at = 0.0
condition = "fixed"
[[initial.stress]]
body = "block"
type = "run"
folder = "earlier/out"
[schedule]
steps = 1
"""


def test_the_folder_is_relative_to_the_case_file(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(CASE)
    with pytest.raises(BadInput, match=r"initial.stress\[0\].folder.*there is no such folder"):
        load_case(case)
    (tmp_path / "earlier" / "out").mkdir(parents=True)
    entry = load_case(case).initial.stress[0]
    assert getattr(entry, "folder", "") == str(tmp_path / "earlier" / "out")
