# SPDX-License-Identifier: BSD-3-Clause
"""Likely causes of failed steps: each named in a small model that has this very cause."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from small_problems import block_entries, material_entries, plane, rollers, weight

from tilth import AnalysisFailed, Model, run
from tilth.analysis.clock import Clock
from tilth.analysis.likely_causes import likely_causes
from tilth.analysis.simulation import Simulation
from tilth.errors import StepFailed
from tilth.output import read_history

FAILURE = StepFailed("no equilibrium after 15 Newton iterations", point=0)


def clay_block(load: float, **changed: Any) -> dict[str, Any]:
    """A perfectly plastic block of strength 20 on its base, free at one side, under gravity."""
    entries = block_entries("plane_strain", "gimp", "von_mises", cells=4)
    entries["materials"]["soil"] = material_entries(
        "von_mises", yield_stress=20.0, hardening_modulus=0.0
    )
    entries["boundaries"] = rollers("plane_strain", sides=False)
    entries["loads"] = [weight("plane_strain", load)]
    entries["output"] = {"report": False}
    return {**entries, **changed}


def causes_of(entries: dict[str, Any], until: float = 0.0, failure: StepFailed = FAILURE) -> str:
    """What is said of a model after the equilibrium at time `until`, reached in one step."""
    model = Model.from_dict(entries)
    simulation, clock = Simulation(model), Clock(model.schedule)
    simulation.check()
    if until:
        simulation.advance(0.0, until)
        clock.accept(until)
    return "; ".join(
        likely_causes(simulation.setup, simulation.state, simulation.services, clock, failure)
    )


def test_weight_beyond_collapse_names_the_limit_load(tmp_path: Path) -> None:
    """A vertical cut of cohesion c and height H stands at least up to gamma H = 2 c."""
    entries = clay_block(80.0, schedule={"steps": 20, "minimum_step": 0.1, "outputs": 1})
    with pytest.raises(AnalysisFailed) as failure:
        run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    assert "the limit load is probably reached: " in failure.value.remedy
    assert "prescribe a displacement" in failure.value.remedy
    reached = 160.0 * 4.0 * read_history(tmp_path / "out" / "history.csv")["time"][-1]
    assert reached >= 2.0 * 20.0 / np.sqrt(3.0)
    log = (tmp_path / "out" / "log.txt").read_text()
    assert "times in a row; likely causes: the limit load is probably reached" in log


def test_displacement_control_has_no_limit_load() -> None:
    top = plane("top", "y", 4.0, condition="prescribed", displacement={"y": -0.5})
    entries = clay_block(0.0, boundaries=[*rollers("plane_strain", sides=False), top])
    text = causes_of(entries, until=0.5)
    assert "limit load" not in text
    assert "flows plastically, at constant volume or nearly so, without a remedy against" in text


def test_a_first_step_that_is_too_large_is_named(tmp_path: Path) -> None:
    """As when a load is given in Pa and the stiffness in kPa: a thousand times too much."""
    schedule = {"steps": 2, "minimum_step": 0.5, "outputs": 1}
    entries = clay_block(1e6, schedule=schedule)
    with pytest.raises(AnalysisFailed) as failure:
        run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    assert "already the first step (0.5 in the schedule, tried down to" in failure.value.remedy
    assert "limit load" not in failure.value.remedy


def test_soil_that_leaves_the_grid_is_named(tmp_path: Path) -> None:
    entries = clay_block(60.0, schedule={"steps": 20, "minimum_step": 0.5, "outputs": 1})
    entries["materials"]["soil"] = material_entries("hencky_elastic")
    entries["grid"]["limits"] = {"lower": [0.0, 0.0], "upper": [4.0, 4.0]}
    with pytest.raises(AnalysisFailed, match=r"likely causes: soil moves out of the grid's limits"):
        run(Model.from_dict(entries), tmp_path / "out", quiet=True)


def test_a_motion_that_nothing_holds_any_more_is_named() -> None:
    """The block slides off the only boundary that held it vertically."""
    base = plane("base", "y", 0.0, range={"x": [0.0, 4.0]})
    entries = clay_block(0.1, boundaries=[base, plane("side", "x", 0.0)])
    model = Model.from_dict(entries)
    simulation, clock = Simulation(model), Clock(model.schedule)
    simulation.check()
    assert "not constrained" not in "; ".join(
        likely_causes(simulation.setup, simulation.state, simulation.services, clock, FAILURE)
    )
    simulation.state.points.position[:, 1] += 3.0
    text = "; ".join(
        likely_causes(simulation.setup, simulation.state, simulation.services, clock, FAILURE)
    )
    assert "is not constrained against translation along y" in text
    assert "lost the boundaries that held it" in text


def test_what_only_contact_holds_is_named() -> None:
    """A block on its smooth base, under a ball that is pushed to the side."""
    base = {
        "name": "base", "type": "implicit",
        "geometry": {"type": "plane", "point": [0.0, 0.0], "normal": [0.0, 1.0]},
        "contact": {"normal": "unilateral", "tangential": "friction", "friction": 0.1},
    }  # fmt: skip
    ball = {
        "name": "ball", "centre": [2.0, 4.5], "displacement": {"y": -0.01},
        "geometry": {"type": "circle", "centre": [2.0, 4.5], "radius": 0.5, "soil": "outside"},
        "contact": {"normal": "unilateral", "tangential": "rough"},
        "force": {"x": 1.0}, "springs": {"rotation": 1.0},
    }  # fmt: skip
    text = causes_of(clay_block(1.0, boundaries=[base], rigid_bodies=[ball]))
    assert "only contact holds the rigid body 'ball' in x: " in text
    assert "only contact holds some of the soil" in text
    assert "or more friction" in text
    base["contact"] = ball["contact"] = {"normal": "unilateral", "tangential": "rough"}
    rough = causes_of(clay_block(1.0, boundaries=[base], rigid_bodies=[ball]))
    assert "or more friction" not in rough
    held = causes_of(clay_block(1.0))
    assert "contact" not in held


def test_sand_that_was_just_placed_has_no_strength() -> None:
    """Without stress and cohesion; a little cohesion gives it some."""
    for cohesion, named in ((0.0, True), (1.0, False)):
        entries = clay_block(1.0)
        entries["materials"]["soil"] = material_entries("mohr_coulomb", cohesion=cohesion)
        text = causes_of(entries)
        assert ("neither pressure nor cohesion and so no strength at all" in text) == named
        assert "already the first step" in text


def test_soil_behind_a_boundary_is_named() -> None:
    wall = implicit("wall", flat([1.0, 0.0], [1.0, 0.0]), "roller")
    entries = clay_block(0.1, boundaries=[plane("base", "y", 0.0), wall])
    text = causes_of(entries)
    # of the block 4 wide with 8 columns and rows of points, the wall at 1 has 2 columns behind it
    assert "16 material points are behind the boundary 'wall' (boundaries[1]), up to 0.75" in text


@pytest.mark.parametrize(
    ("basis", "size"), [("gimp", "grown to the size of a cell"), ("cpdi1", "wider than 2 cells")]
)
def test_domains_that_grew_are_named(basis: str, size: str) -> None:
    entries = clay_block(0.1)
    entries["bodies"][0]["basis"] = basis
    model = Model.from_dict(entries)
    simulation, clock = Simulation(model), Clock(model.schedule)
    assert "domains" not in "; ".join(
        likely_causes(simulation.setup, simulation.state, simulation.services, clock, FAILURE)
    )
    points = simulation.state.points
    points.half_length[:7] = 1.1 if basis == "cpdi1" else 0.5
    text = "; ".join(
        likely_causes(simulation.setup, simulation.state, simulation.services, clock, FAILURE)
    )
    assert f"the domains of 7 of {len(points)} points of the body 'block' are {size}" in text
    assert ("domain_update" in text) == (basis == "gimp")


def test_nearly_incompressible_soil_without_f_bar_is_named() -> None:
    entries = clay_block(0.1)
    entries["materials"]["soil"]["poisson_ratio"] = 0.49
    assert "nearly incompressible (Poisson's ratio 0.49)" in causes_of(entries)
    entries["bodies"][0]["anti_locking"] = "f_bar"
    assert "incompressible" not in causes_of(entries)


@pytest.mark.parametrize(
    ("changed", "f_bar", "said"),
    [
        ({"dilation_angle": 0.0}, False, "without a remedy against locking"),
        ({"dilation_angle": 0.0}, True, None),
        ({"dilation_angle": 10.0}, False, None),
        ({"dilation_angle": 10.0}, True, 'compare a run with bodies[0].anti_locking = "none"'),
        ({"dilation_angle": 10.0, "pore_fluid_bulk_modulus": 1e4}, True, None),
    ],
)
def test_f_bar_is_advised_where_soil_keeps_its_volume_only(
    changed: dict[str, Any], f_bar: bool, said: str | None
) -> None:
    """And against where it dilates: never both in turn for one soil."""
    entries = clay_block(0.0)
    entries["materials"]["soil"] = material_entries(
        "mohr_coulomb", cohesion=1.0, friction_angle=30.0, poisson_ratio=0.3, **changed
    )
    if f_bar:
        entries["bodies"][0]["anti_locking"] = "f_bar"
    simulation = Simulation(Model.from_dict(entries))
    simulation.state.points.elastic_share[:20] = 0.1
    text = "; ".join(
        likely_causes(
            simulation.setup,
            simulation.state,
            simulation.services,
            Clock(simulation.setup.model.schedule),
            FAILURE,
        )
    )
    assert "anti_locking" not in text if said is None else said in text
    assert text.count("anti_locking") <= 1


@pytest.mark.parametrize("f_bar", [True, False])
def test_layers_of_a_body_are_told_apart(f_bar: bool) -> None:
    """Sand over clay: with F-bar and without the advice is to make two bodies of them."""
    entries = clay_block(0.0)
    entries["materials"]["sand"] = material_entries("mohr_coulomb", dilation_angle=5.0)
    body = entries["bodies"][0]
    del body["material"]
    body |= {"layers": [{"material": "sand", "bottom": 2.0}, {"material": "soil"}]}
    body["anti_locking"] = "f_bar" if f_bar else "none"
    simulation = Simulation(Model.from_dict(entries))
    simulation.state.points.elastic_share[:] = 0.1
    text = "; ".join(
        likely_causes(
            simulation.setup,
            simulation.state,
            simulation.services,
            Clock(simulation.setup.model.schedule),
            FAILURE,
        )
    )
    if not f_bar:
        assert '"f_bar", with sand as a body of its own without it' in text
        return
    assert "flows with a change of volume in sand, which does not lock" in text
    assert "with the other layers, which may need it, as a body of their own" in text


def test_soil_that_has_come_apart_is_named() -> None:
    entries = clay_block(0.0)
    simulation = Simulation(Model.from_dict(entries))
    clock = Clock(simulation.setup.model.schedule)
    assert "torn off" not in "; ".join(
        likely_causes(simulation.setup, simulation.state, simulation.services, clock, FAILURE)
    )
    simulation.state.points.deformation_gradient[5] *= 1.3
    worst = simulation.state.points.point_id[5]
    text = "; ".join(
        likely_causes(simulation.setup, simulation.state, simulation.services, clock, FAILURE)
    )
    assert f"1 points have more than 1.5 times their volume, most of all {worst} at (" in text


def test_naming_causes_changes_no_result() -> None:
    entries = clay_block(10.0)
    model = Model.from_dict(entries)
    plain, asked = Simulation(model), Simulation(model)
    for simulation in (plain, asked):
        simulation.advance(0.0, 0.5)
    clock = Clock(model.schedule)
    clock.accept(0.5)
    likely_causes(asked.setup, asked.state, asked.services, clock, FAILURE)
    for simulation in (plain, asked):
        simulation.advance(0.5, 1.0)
    assert np.array_equal(plain.state.points.stress, asked.state.points.stress)
    assert np.array_equal(plain.state.points.position, asked.state.points.position)
