# SPDX-License-Identifier: BSD-3-Clause
"""Numbers in wrong units and tables that nobody reads to their end are named."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console
from small_problems import block_entries, material_entries, rollers, weight

import tilth
from tilth import AnalysisFailed, Model, run
from tilth.analysis.memory import memory_of
from tilth.analysis.setup_picture import setup_of
from tilth.report.setup import legend_handles
from tilth.report.summary import print_summary

PIPE = {
    "name": "pipe",
    "geometry": {"type": "circle", "centre": [1.0, 2.6], "radius": 0.5, "soil": "outside"},
    "contact": {"normal": "unilateral", "tangential": "smooth"},
    "centre": [1.0, 2.6],
    "displacement": {"x": 0.0, "y": -0.1},
    "rotation": 0.0,
}


def entries(**changed: Any) -> dict[str, Any]:
    given = block_entries("plane_strain", "gimp", boundaries=rollers("plane_strain"))
    given["loads"] = [weight("plane_strain", 0.1)]
    return {**given, **changed}


def warnings_of(given: dict[str, Any]) -> list[str]:
    return tilth.check(Model.from_dict(given)).warnings


def with_pipe(**changed: Any) -> dict[str, Any]:
    return entries(rigid_bodies=[{**PIPE, **changed}])


@pytest.mark.parametrize(
    ("rows", "end", "named"),
    [
        ([[0, 0], [1, -0.1], [2, -0.2]], 1.0, True),
        ([[0, 0], [1, -0.1], [2, -0.2]], 2.0, False),
        ([[0, 0], [1, -0.1], [2, -0.1]], 1.0, False),  # it does not change there
    ],
)
def test_a_path_that_goes_on_after_the_end_is_named(rows: Any, end: float, named: bool) -> None:
    given = with_pipe(displacement={"x": 0.0, "y": rows})
    given["schedule"] = {"steps": 4, "end": end}
    found = [text for text in warnings_of(given) if "the schedule ends" in text]
    assert len(found) == named
    if named:
        assert found[0].startswith("rigid_bodies[0].displacement.y: the rows go on to time 2")
        assert "the value is -0.1 and not yet -0.2; give schedule.end = 2" in found[0]


def test_a_load_that_goes_on_after_the_end_is_named() -> None:
    load = {**weight("plane_strain", 0.1), "factor": [[0, 0], [3, 1]]}
    found = [text for text in warnings_of(entries(loads=[load])) if "the rows go on" in text]
    assert len(found) == 1
    assert found[0].startswith("loads[0].factor: the rows go on to time 3")


@pytest.mark.parametrize(("stiffness", "named"), [(2.0, True), (2000.0, False)])
def test_a_stiffness_in_other_units_than_the_strength_is_named(
    stiffness: float, named: bool
) -> None:
    """As 2 MPa written among kPa."""
    soil = material_entries("tresca", young_modulus=stiffness, undrained_shear_strength=10.0)
    every = warnings_of(entries(materials={"soil": soil}))
    found = [text for text in every if "check the units of both" in text]
    assert len(found) == named
    if named:
        assert found[0].startswith("materials.soil.young_modulus: Young's modulus 2 is only 0.2")


def test_the_summary_has_the_unit_weights_and_the_picture_one_pipe() -> None:
    soil = material_entries("tresca", density=1.6)
    load = {"type": "body_force", "acceleration": [0.0, -9.81]}
    units = {"length": "m", "force": "kN", "stress": "kPa", "mass": "t"}
    given = {**with_pipe(), "materials": {"soil": soil}, "loads": [load], "units": units}
    model, written = Model.from_dict(given), io.StringIO()
    setup = setup_of(model)
    console = Console(file=written, width=200)
    print_summary(model, setup, memory_of(model), None, console)
    assert "unit weights soil 15.7 kN/m^3" in " ".join(written.getvalue().split())
    labels = [handle.label.split("\n")[0] for handle in legend_handles(setup)]
    assert labels.count("pipe") == 1


@pytest.mark.slow
def test_a_free_body_is_named_where_the_start_has_no_equilibrium(
    tmp_path: Path,
) -> None:
    """The pipe touches clay that cannot bear its own weight between free sides."""
    soil = material_entries("tresca", density=0.1, undrained_shear_strength=0.001)
    given = with_pipe(displacement={"x": 0.0}, force={"y": [[0, -0.1], [1, -0.1]]})
    given["rigid_bodies"][0].update(
        geometry={**PIPE["geometry"], "centre": [1.0, 2.5]}, centre=[1.0, 2.5]
    )
    load = {**weight("plane_strain", 10.0), "factor": [[0, 1], [1, 1]]}
    initial = {"stress": [{"type": "gravity", "body": "block"}]}
    given = {**given, "materials": {"soil": soil}, "loads": [load], "initial": initial}
    given["boundaries"] = rollers("plane_strain", sides=False)
    with pytest.raises(AnalysisFailed) as failure:
        run(Model.from_dict({**given, "output": {"report": False}}), tmp_path / "out", quiet=True)
    assert "weight of the free rigid body 'pipe'" in failure.value.remedy
