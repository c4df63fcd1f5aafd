# SPDX-License-Identifier: BSD-3-Clause
"""boundaries.csv: motion and reaction of what moves, and their curves in the report."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from implicit_problems import MODULUS, POISSON, implicit, locate_contacts
from report_pages import data_of
from small_problems import block_entries, plane, rollers
from staged_problems import staged_entries

from tilth import Model, run
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.motions import motion_columns, motion_values
from tilth.analysis.simulation import Simulation
from tilth.analysis.step import Equilibrium
from tilth.analysis.step_result import StepResult
from tilth.output import read_history
from tilth.output.history import Mark, mark_of, with_columns
from tilth.report.html import write_report
from tilth.report.motion_plots import force_charts, motion_curves

CONSTRAINED = MODULUS * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))


def pressed(kind: str = "plane_strain", **more: Any) -> dict[str, Any]:
    """A block in confined compression between rollers and a plate that moves down by 0.4 of 2.

    In one step: soil that moves away from a grid plane is no longer held there.
    """
    top = "z" if kind == "3d" else "y"
    return block_entries(
        kind, "linear", schedule={"steps": 1},
        boundaries=[*rollers(kind), plane(
            "plate", top, 2.0, condition="prescribed", displacement={top: -0.4}
        )],
        **more,
    )  # fmt: skip


@pytest.mark.parametrize(("kind", "area"), [("plane_strain", 2.0), ("axisymmetric", 4 * math.pi)])
def test_plate_in_confined_compression(kind: str, area: float, tmp_path: Path) -> None:
    """Hencky's law: the Cauchy stress is M ln(stretch) / stretch."""
    run(Model.from_dict(pressed(kind)), tmp_path / "out", quiet=True)
    table = read_history(tmp_path / "out" / "boundaries.csv")
    unit = "N/m" if kind == "plane_strain" else "N"
    np.testing.assert_allclose(table["plate displacement_y [m]"], [0, -0.4])
    stretch = 1.0 + table["plate displacement_y [m]"] / 2.0
    force = CONSTRAINED * np.log(stretch) / stretch * area
    np.testing.assert_allclose(table[f"plate force_y [{unit}]"], force, rtol=1e-6, atol=1e-9)
    (curve,) = motion_curves(table, {})
    assert curve.motion_label == "displacement of plate along -y [m]"
    np.testing.assert_allclose(curve.motion[-1], 0.4)
    np.testing.assert_allclose(curve.reaction, -force, rtol=1e-6, atol=1e-9)


def hole(kind: str, geometry: dict[str, Any], **motion: Any) -> Simulation:
    """A block with a quarter of a round hole at its corner, where the boundary touches soil."""
    entries = block_entries(kind, "gimp", cells=8)
    entries["grid"]["cell_size"] = 0.25
    entries["boundaries"] = [*rollers(kind), implicit("hole", geometry, **motion)]
    return Simulation(Model.from_dict(entries))


@pytest.mark.parametrize("soil", ["inside", "outside"])
@pytest.mark.parametrize(("kind", "type_"), [("plane_strain", "circle"), ("3d", "sphere")])
def test_pressure_of_a_uniform_traction(kind: str, type_: str, soil: str) -> None:
    """The nodal forces of a uniform pressure on the part that touches soil give it back."""
    dim = 3 if kind == "3d" else 2
    geometry = {"type": type_, "centre": [0.0] * dim, "radius": 1.0, "soil": soil}
    simulation = hole(kind, geometry, radius_change=-0.1)
    active, constraints = locate_contacts(simulation, 0.0, 0.0)
    (part,) = constraints.parts
    force = part.nodal_force(7.0 * part.pose.normal, active.nodes)
    still = np.zeros(force.shape)
    moved = Equilibrium(Unknowns({"u": still}), still, {"u": force}, force, [])
    result = StepResult(active, moved, {"hole": force}, 0.0, 0.0, constraints.areas)
    names = [name for name, _ in motion_columns(simulation.setup.model)]
    values = dict(
        zip(
            names,
            motion_values(simulation.setup.model, simulation.setup, simulation.state, result),
            strict=True,
        )
    )
    assert values["hole pressure"] == pytest.approx(7.0, rel=1e-10)
    assert values["hole radius_change"] == 0.0
    assert constraints.areas["hole"] == pytest.approx(0.5 * math.pi, rel=0.02)


def test_area_is_that_at_the_end_of_the_step() -> None:
    geometry = {"type": "circle", "centre": [0.0, 0.0], "radius": 1.0, "soil": "outside"}
    simulation = hole("plane_strain", geometry, radius_change=0.5)
    still = locate_contacts(simulation, 0.0, 0.0)[1].areas["hole"]
    moved = locate_contacts(simulation, 0.0, 1.0)[1].areas["hole"]
    assert moved == pytest.approx(1.5 * still, rel=1e-12)


def test_moment_is_about_the_moving_centre() -> None:
    entries = block_entries("plane_strain", "linear", cells=4)
    geometry = {"type": "plane", "point": [0.0, 1.9], "normal": [0.0, -1.0]}
    turn = {"angle": 4.0, "centre": [0.5, 2.0]}
    lid = implicit("lid", geometry, displacement={"y": -0.1}, rotation=turn)
    entries["grid"]["cell_size"], entries["boundaries"] = 0.5, [*rollers("plane_strain"), lid]
    simulation = Simulation(Model.from_dict(entries))
    result = simulation.advance(0.0, 0.25)
    names = [name for name, _ in motion_columns(simulation.setup.model)]
    values = dict(
        zip(
            names,
            motion_values(simulation.setup.model, simulation.setup, simulation.state, result),
            strict=True,
        )
    )
    assert values["lid displacement_y"] == pytest.approx(-0.025)
    assert values["lid rotation_z"] == pytest.approx(1.0)
    force, place = result.forces["lid"], result.active.position + result.equilibrium.displacement
    arm = place - [0.5, 1.975]
    expected = float((arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum())
    assert abs(expected) > 1.0
    assert values["lid moment_z"] == pytest.approx(expected, rel=1e-12)
    assert values["lid force_y"] == pytest.approx(force[:, 1].sum(), rel=1e-12)


def test_nothing_moves(tmp_path: Path) -> None:
    entries = block_entries("plane_strain", "linear", boundaries=rollers("plane_strain"))
    run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    assert not (tmp_path / "out" / "boundaries.csv").exists()
    assert "Force and displacement" not in (tmp_path / "out" / "report.html").read_text()


def test_first_picture_of_the_report_and_of_old_folders(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    run(Model.from_dict(pressed()), folder, quiet=True)
    page = (folder / "report.html").read_text()
    headings = re.findall("<h2>(.*?)</h2>", page)
    assert headings[:3] == ["Curves", "The body at all outputs", "Force and displacement"]
    first = data_of(folder / "report.html")["charts"][0]["name"]
    assert first.startswith("force of ")
    (folder / "boundaries.csv").unlink()
    page = write_report(folder).read_text()
    assert re.findall("<h2>(.*?)</h2>", page)[2] == "Set-up"


def test_oblique_straight_path_has_one_curve_along_it() -> None:
    path = {"wall displacement_x [m]": np.array([0.0, 3.0, 1.5]),
            "wall displacement_y [m]": np.array([0.0, -4.0, -2.0]),
            "wall force_x [N]": np.array([0.0, 30.0, 5.0]),
            "wall force_y [N]": np.array([0.0, 10.0, 5.0])}  # fmt: skip
    (curve,) = motion_curves(path, {})
    np.testing.assert_allclose(curve.motion, [0.0, 5.0, 2.5])
    np.testing.assert_allclose(curve.reaction, [0.0, 10.0, -1.0], atol=1e-12)
    assert curve.motion_label == "displacement of wall along (0.6, -0.8) [m]"


def test_bent_path_has_a_curve_for_each_prescribed_component() -> None:
    path = {"pipe displacement_x [m]": np.array([0.0, 0.1, 0.5]),
            "pipe displacement_y [m]": np.array([0.0, -0.4, -0.2]),
            "pipe force_x [N]": np.array([0.0, 1.0, 2.0]),
            "pipe force_y [N]": np.array([0.0, -3.0, -4.0]),
            "pipe rotation_z [degrees]": np.array([0.0, 2.0, 3.0]),
            "pipe moment_z [N m]": np.array([0.0, 5.0, 6.0])}  # fmt: skip

    def labels(**body: Any) -> list[str]:
        curves = motion_curves(path, {"rigid_bodies": [{"name": "pipe", **body}]})
        return [curve.reaction_label for curve in curves]

    turning = "moment of pipe about z [N m]"
    assert labels(displacement={"y": -0.4}) == ["force of pipe along -y [N]", turning]
    assert labels() == ["force of pipe along x [N]", turning]
    both = labels(displacement={"x": 0.5, "y": [[0, 0]]})
    assert both == ["force of pipe along x [N]", "force of pipe along -y [N]", turning]


def test_chart_marks_the_ends_of_stages() -> None:
    (curve,) = motion_curves(
        {
            "a displacement_y": np.array([0.0, 1.0, math.nan]),
            "a force_y": np.array([0.0, 2.0, 0.0]),
        },
        {},
    )
    (chart,) = force_charts([curve], [("push", 1), ("rest", 2)])
    assert chart.words == [(1.0, 2.0, "push")]
    assert chart.x == "displacement of a along y"
    assert [line.kind for line in chart.lines] == ["line", "rings"]


def test_columns_of_a_new_boundary_in_a_history_with_stages() -> None:
    old = b"step,time,iterations,stage,stage_time,a force_x [N]\n0,0.0,0,one,0.0,1.5\n"
    new = with_columns(old, [("b force_x", "N"), ("a force_x", "N")])
    assert new.splitlines()[1] == b"0,0.0,0,one,0.0,nan,1.5"
    assert mark_of(new, 0) == Mark(len(new), mark_of(new, 5).checksum)


def test_boundary_that_does_not_act_has_no_place(tmp_path: Path) -> None:
    entries = staged_entries("plane_strain")
    entries["boundaries"].append(
        {"type": "implicit", "name": "late", "condition": "roller", "displacement": {"y": -0.01},
         "geometry": {"type": "plane", "point": [0.0, 50.0], "normal": [0.0, -1.0]}}
    )  # fmt: skip
    entries["stages"][1].setdefault("activate", []).append("late")
    run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    rows = read_history(tmp_path / "out" / "boundaries.csv")
    history = read_history(tmp_path / "out" / "history.csv")
    moved = rows["late displacement_y [m]"]
    first_stage = np.isnan(moved)
    assert first_stage[0]
    assert not first_stage[-1]
    np.testing.assert_array_equal(rows["time"], history["time"])
