# SPDX-License-Identifier: BSD-3-Clause
"""Several processes find the serial run's motion: inertia, relaxation, bases, absorbing sides."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from mpi_runs import assert_as_serial
from small_problems import block_entries, dimension, material_entries, plane, weight

from tilth import Model

pytestmark = pytest.mark.slow
several = pytest.mark.parametrize("processes", [2, 3])
NEWMARK: dict[str, Any] = {"scheme": "newmark"}


def moving(kind: str, inertia: dict[str, Any], **changed: Any) -> dict[str, Any]:
    """A block of elastic soil, 6 by 2 cells, with inertia."""
    entries = block_entries(kind, "gimp", boundaries=[], **changed)
    entries["analysis"] |= {"inertia": inertia, "tolerance": 1e-11, "solver": "auto"}
    dim = dimension(kind)
    entries["bodies"][0]["shape"]["upper"] = [6.0, 2.0] if dim == 2 else [5.0, 1.0, 1.0]
    entries["schedule"] = {"end": 0.3, "steps": 3}
    entries["units"] = {"time": "s"}
    return entries


@several
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_a_block_thrown_across_the_cells(kind: str, processes: int) -> None:
    """It turns and crosses 2 cells; its points go from process to process."""
    entries, dim = moving(kind, NEWMARK), dimension(kind)
    entries["grid"]["origin"] = [-0.3, -0.2, -0.1][:dim]
    turn = 0.4 if dim == 2 else [0.1, 0.2, 0.4]
    thrown = {"body": "block", "x": 7.0, "y": 2.0, "angular_velocity": turn}
    thrown["centre"] = [2.7, 0.8, 0.4][:dim]
    entries["initial"] = {"velocity": [thrown]}
    entries["loads"] = [weight(kind, 10.0)]
    assert_as_serial(Model.from_dict(entries), processes)


@several
def test_damped_clay_in_steps_of_limited_error(processes: int) -> None:
    """It falls on its base; the steps follow from the motion of all points."""
    inertia = {
        "scheme": "generalised_alpha", "spectral_radius": 0.7, "largest_error": 2e-3,
        "largest_motion": 0.1, "damping": {"mass": 0.5, "stiffness": 1e-3},
    }  # fmt: skip
    entries = moving("plane_strain", inertia)
    entries["materials"]["soil"] = material_entries("von_mises")
    entries["boundaries"] = [plane("base", "y", 0.0, condition="fixed"), plane("side", "x", 0.0)]
    entries["initial"] = {"velocity": [{"body": "block", "y": -0.7}]}
    entries["loads"] = [weight("plane_strain", 5.0)]
    entries["schedule"] = {"end": 0.3, "steps": 2}
    assert_as_serial(Model.from_dict(entries), processes, steps=6)


@several
def test_a_cut_that_collapses_and_comes_to_rest(processes: int) -> None:
    entries = block_entries("plane_strain", "gimp", "von_mises", cells=3)
    entries["analysis"] |= {"beyond_limit": "relax", "solver": "auto"}
    entries["grid"]["cell_size"] = 0.5
    entries["bodies"][0]["anti_locking"] = "f_bar"
    entries["materials"]["soil"] = material_entries(
        "von_mises", yield_stress=20.0, hardening_modulus=0.0, young_modulus=5e3,
        poisson_ratio=0.45,
    )  # fmt: skip
    entries["boundaries"] = [plane("base", "y", 0.0, condition="fixed"), plane("side", "x", 0.0)]
    entries["loads"] = [weight("plane_strain", 10.0)]
    entries["schedule"] = {"steps": 2, "minimum_step": 0.5}
    assert_as_serial(Model.from_dict(entries), processes, steps=8, share=1e-6)


def absorbing(name: str, axis: str, at: float, **more: Any) -> dict[str, Any]:
    return plane(name, axis, at, condition="absorbing", **more)


def record(path: Path) -> dict[str, str]:
    path.write_text("time,x,y\n0,0,0\n0.1,3,-1\n0.2,-5,2\n0.3,1,0.5\n", encoding="utf-8")
    return {"file": str(path)}


@several
def test_a_base_that_moves_and_a_side_across_the_cells(processes: int, tmp_path: Path) -> None:
    entries = moving("plane_strain", NEWMARK)
    geometry = {"type": "plane", "point": [5.6, 1.0], "normal": [-0.9, 0.3]}
    shaken = {"condition": "base_motion", "acceleration": record(tmp_path / "record.csv")}
    entries["boundaries"] = [
        plane("base", "y", 0.0, **shaken),
        {"name": "side", "type": "implicit", "geometry": geometry, "condition": "absorbing"},
    ]
    entries["loads"] = [weight("plane_strain", 2.0)]
    assert_as_serial(Model.from_dict(entries), processes)


@several
def test_absorbing_sides_keep_the_forces_of_the_stage_before(
    processes: int, tmp_path: Path
) -> None:
    """Two of them share the node of the corner, and a wave comes in through the base."""
    entries = moving("plane_strain", NEWMARK)
    rollers = [plane("floor", "y", 0.0, condition="fixed"), plane("wall", "x", 6.0)]
    wave = {"acceleration": record(tmp_path / "record.csv")}
    sides = [absorbing("base", "y", 0.0, **wave), absorbing("side", "x", 6.0)]
    entries["boundaries"] = rollers + sides
    entries["loads"] = [weight("plane_strain", 2.0)]
    del entries["schedule"]
    entries["stages"] = [
        {"name": "rest", "inertia": False, "schedule": {"end": 1.0, "steps": 1}},
        {"name": "wave", "schedule": {"end": 0.3, "steps": 3}, "activate": ["base", "side"],
         "deactivate": ["floor", "wall"]},
    ]  # fmt: skip
    assert_as_serial(Model.from_dict(entries), processes)
