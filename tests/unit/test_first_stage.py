# SPDX-License-Identifier: BSD-3-Clause
"""What the first stage changes is a change of the initial state, as that of any later stage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, run_in_pieces
from small_problems import material_entries
from staged_problems import box, roller

from tilth import BadInput, Model, check, run
from tilth.analysis.setup_picture import setup_of
from tilth.analysis.staged import StagedAnalysis
from tilth.report.setup_file import read_staged_setup, write_setup
from tilth.report.stage_setups import StagedSetup

PIT = {"type": "box", "lower": [0.0, 1.0], "upper": [1.0, 1.5]}
PLATE = {
    "name": "plate", "type": "implicit", "condition": "roller",
    "geometry": {"type": "plane", "point": [0.0, 2.0], "normal": [0.0, -1.0]},
}  # fmt: skip
PRESS = {
    "name": "press", "type": "surface", "body": "bank", "pressure": 5.0,
    "start": [2.0, 1.5], "end": [1.0, 1.5],
}  # fmt: skip
WHOLE = [[0.0, 1.0], [1.0, 1.0]]

CHANGES: dict[str, dict[str, Any]] = {
    "exchange": {"materials": {"sand": "concrete"}},
    "removed body": {"deactivate": ["pit"]},
    "removed region": {"excavate": [{"body": "ground", "shape": PIT | {"lower": [0.0, 0.5]}}]},
    "placed body": {"activate": ["fill"]},
    "removed boundary": {"deactivate": ["side"]},
    "new boundary": {"activate": ["plate"], "materials": {"sand": "concrete"}},
    "removed load": {"deactivate": ["press"]},
    "new load": {"activate": ["push"], "factors": {"push": WHOLE}},
    "water": {"water": {"level": 1.2, "unit_weight": 9.81}},
    "other grid": {"grid": {"cell_size": 0.25}, "deactivate": ["pit"]},
}
"""What the stage changes, each in a way that puts forces out of balance."""


def entries(change: dict[str, Any], *, first: bool) -> dict[str, Any]:
    """Ground with a pit and a bank at rest under K0 = "1-sin_phi", which one stage changes."""
    stage = {"name": "change", "schedule": {"steps": 2}, **change}
    rest = {"name": "rest", "schedule": {"steps": 1}}
    sand = material_entries("mohr_coulomb", density=1.8) | {"saturated_density": 2.0}
    own = "fill" in change.get("activate", ())
    return {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 0.5},
        "materials": {
            "sand": sand,
            "concrete": material_entries("hencky_elastic", density=2.4) | {"watertight": True},
        },
        "bodies": [
            box("ground", [0.0, 0.0], [2.0, 1.0], 2, material="sand"),
            box("pit", [0.0, 1.0], [1.0, 1.5], 2, material="sand"),
            box("bank", [1.0, 1.0], [2.0, 1.5], 2, material="sand", surface={}),
            *([box("fill", [0.0, 1.5], [2.0, 2.0], 2, material="concrete")] * own),
        ],
        "boundaries": [
            {"name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "fixed"},
            roller("x", 0.0, "left"), roller("x", 2.0, "side"),
            *([PLATE] * ("plate" in change.get("activate", ()))),
        ],
        "loads": [
            {"name": "gravity", "type": "body_force", "acceleration": [0, -9.81], "factor": WHOLE},
            *([PRESS | {"factor": WHOLE}] * ("press" in change.get("deactivate", ()))),
            *([PRESS | {"name": "push"}] * ("push" in change.get("activate", ()))),
        ],
        "initial": {
            "stress": [
                {"type": "k0", "body": name, "K0": "1-sin_phi"}
                for name in ("ground", "pit", "bank")
            ]
        },
        "stages": [stage] if first else [rest, stage],
        "output": {"report": False},
        "track": [
            {"name": "settlement", "quantity": "displacement", "at": [1.5, 1.5], "component": "y"},
            {"name": "syy", "quantity": "stress", "at": [0.25, 0.1], "component": "yy"},
            {"name": "sxx", "quantity": "stress", "at": [1.75, 0.6], "component": "xx"},
            {"name": "base", "quantity": "reaction", "boundary": "base", "component": "y"},
        ],
    }  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_in_the_first_stage_is_that_after_a_stage_of_rest(
    name: str, tmp_path: Path
) -> None:
    columns = []
    for first in (True, False):
        model = Model.from_dict(entries(CHANGES[name], first=first))
        result = run(model, tmp_path / str(first), quiet=True)
        assert "forces released in it" in (tmp_path / str(first) / "log.txt").read_text()
        columns.append(result.history)
    changed = 0.0
    for heading in (each for each in columns[0] if "[" in each):  # the tracked ones
        found, expected = (each[heading] for each in columns)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(found[-2:], expected[-2:], rtol=0, atol=1e-7 * scale)
        if name == "exchange" and "base" not in heading:  # fixed nodes bear the change at once
            assert found[0] == pytest.approx(expected[1], rel=1e-6, abs=1e-7 * scale)
        changed = max(changed, np.ptp(expected[1:]) / scale)
    assert changed > 0.01, "the change changes nothing"


def test_the_initial_state_has_the_weight_and_the_material_before_the_change() -> None:
    """The pit and its weight are there, K0 is that of the sand, and nothing is stiff yet."""
    change = {"deactivate": ["pit"], "materials": {"sand": "concrete"}}
    model = Model.from_dict(entries(change, first=True))
    analysis = StagedAnalysis(model)
    points = analysis.simulation.state.points
    assert analysis.is_before_first
    vertical = -9.81 * 1.8 * (1.5 - points.position[:, 1])
    np.testing.assert_allclose(points.stress[:, 1], vertical, rtol=1e-12)
    lateral = 1.0 - np.sin(np.radians(model.materials["sand"].friction_angle))  # type: ignore[union-attr]
    np.testing.assert_allclose(points.stress[:, 0], lateral * vertical, rtol=1e-12)
    analysis.check()
    analysis.begin()
    assert not analysis.is_before_first
    after = analysis.simulation.state.points
    assert len(after) < len(points)
    kept = points.stress[np.isin(points.point_id, after.point_id)]
    np.testing.assert_allclose(after.stress, kept, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_a_run_whose_first_stage_changes_soil_is_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    change = {"deactivate": ["pit"], "materials": {"sand": "concrete"}}
    given = entries(change, first=True)
    given["stages"].append({"name": "more", "schedule": {"steps": 2}})
    model = Model.from_dict(given)
    run(model, tmp_path / "whole", quiet=True)
    run_in_pieces(model, tmp_path / "part", [1, 3], monkeypatch)
    assert_same_results(tmp_path / "whole", tmp_path / "part")
    run(model, tmp_path / "from", from_stage=(tmp_path / "whole", "change"), quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "from")


def test_a_run_does_not_go_on_from_another_initial_state(tmp_path: Path) -> None:
    """The sand is in no stage any more, but the initial stress is its own."""
    given = entries({"materials": {"sand": "concrete"}}, first=True)
    given["stages"].append({"name": "more", "schedule": {"steps": 1}})
    run(Model.from_dict(given), tmp_path / "whole", quiet=True)
    given["materials"]["sand"]["density"] = 1.9
    with pytest.raises(BadInput, match="not as in the run"):
        other = Model.from_dict(given)
        run(other, tmp_path / "from", from_stage=(tmp_path / "whole", "change"), quiet=True)


def test_the_set_up_of_the_first_stage_shows_what_it_removes_and_places(tmp_path: Path) -> None:
    given = entries({"deactivate": ["pit"], "activate": ["fill"]}, first=True)
    model = Model.from_dict(given)
    assert check(model).points == 48 - 8 + 16
    for setup in (setup_of(model), None):
        if setup is None:
            setup = read_staged_setup(tmp_path / "setup.npz")
        assert isinstance(setup, StagedSetup)
        first = setup.at(0)
        assert first.removed is not None
        assert first.is_new is not None
        assert len(first.removed.position) == 8
        assert first.is_new.sum() == 16
        write_setup(tmp_path / "setup.npz", setup)


def refusal(given: dict[str, Any]) -> str:
    with pytest.raises(BadInput) as caught:
        Model.from_dict(given)
    return str(caught.value)


def test_what_the_initial_state_lacks_is_refused() -> None:
    """Each message names the entry and what to do."""
    given = entries({"activate": ["gravity"]}, first=True)
    assert "stages[0].activate = \"gravity\": 'gravity' does not act yet in" in refusal(given)
    given = entries({"activate": ["base"]}, first=True)
    assert "move freely along y, in the initial state, before this stage" in refusal(given)
    given = entries({"deactivate": ["press"]}, first=True)
    del given["loads"][1]["factor"]
    assert "is removed before it has acted" in refusal(given)
    given = entries({"activate": ["fill"]}, first=True)
    given["initial"]["stress"].append({"type": "k0", "body": "fill", "K0": 0.5})
    assert "is placed by a stage, without stress" in refusal(given)
    given = entries({"activate": ["fill"]}, first=False)
    given["materials"]["clay"] = material_entries("modified_cam_clay")
    given["bodies"][-1]["material"] = "clay"
    assert "cannot be without stress, but a stage places this body" in refusal(given)


def test_exchanged_cam_clay_needs_a_preconsolidation() -> None:
    """The overconsolidation ratio of the entry k0, of the sand, is that of the clay too."""
    given = entries({"materials": {"sand": "clay"}}, first=False)
    given["materials"]["clay"] = material_entries("modified_cam_clay")
    for key in ("overconsolidation_ratio", "preconsolidation_pressure"):
        given["materials"]["clay"].pop(key, None)
    assert "'clay', which stands for 'sand' here, has no preconsolidation" in refusal(given)
    for each in given["initial"]["stress"]:
        each["overconsolidation_ratio"] = 2.0
    StagedAnalysis(Model.from_dict(given))


def test_forces_of_the_first_stage_are_released_by_a_table() -> None:
    given = entries({"materials": {"sand": "concrete"}, "release": [[0, 0], [0.5, 1]]}, first=True)
    assert Model.from_dict(given).stages
    del given["stages"][0]["materials"]
    assert "stages[0].release: has no meaning in the first stage" in refusal(given)


def test_points_per_cell_are_those_of_the_declared_grid() -> None:
    """Also where the first stage has another grid, with and without a stress at the start."""
    given = entries({"grid": {"cell_size": 0.25}}, first=True)
    assert check(Model.from_dict(given)).points == 48
    del given["initial"]
    assert check(Model.from_dict(given)).points == 48


def test_soil_without_stress_is_excavated_in_the_first_stage() -> None:
    given = entries(CHANGES["removed region"], first=True)
    del given["initial"]
    given["stages"].append({"name": "more", "schedule": {"steps": 1}})
    analysis = StagedAnalysis(Model.from_dict(given))
    before = len(analysis.simulation.state.points)
    next(iter(analysis.steps()))
    assert len(analysis.simulation.state.points) == before - 8
