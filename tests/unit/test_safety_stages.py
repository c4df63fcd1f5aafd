# SPDX-License-Identifier: BSD-3-Clause
"""Strength reductions as stages of an analysis."""

from __future__ import annotations

import html
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, run_in_pieces

from tilth import AnalysisFailed, BadInput, Model, StrengthReduction, resume, run, safety
from tilth.analysis.safety_search import Outcome, Trial
from tilth.analysis.safety_trials import Trials
from tilth.analysis.staged import StagedAnalysis
from tilth.output.folder import SETUP
from tilth.output.safety_files import read_safety
from tilth.report.setup_file import read_staged_setup
from tilth.report.stage_marks import first_outputs
from tilth.report.stage_pages import draw_stages
from tilth.report.stage_texts import stage_rows

pytestmark = pytest.mark.slow

PRESSURE = 20.0
STRENGTH = 14.0
EXACT = 2.0 * STRENGTH / PRESSURE
"""A block of clay between smooth plates, free at one side, fails at the pressure 2 s_u."""

NO_REPORT = {"report": False}


def entries(**changes: Any) -> dict[str, Any]:
    """That block under its pressure, which a later stage lowers; a strength reduction at each."""
    return {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 0.5},
        "materials": {
            "soil": {
                "model": "tresca", "young_modulus": 1e4, "poisson_ratio": 0.3, "density": 1.0,
                "undrained_shear_strength": STRENGTH,
            },
        },
        "bodies": [
            {
                "name": "block", "material": "soil", "basis": "gimp", "points_per_cell": 2,
                "shape": {"type": "box", "lower": [0.0, 0.0], "upper": [1.0, 1.0]}, "surface": {},
            }
        ],
        "boundaries": [
            {"name": name, "type": "plane", "axis": axis, "at": 0.0, "condition": "roller"}
            for name, axis in (("left", "x"), ("below", "y"))
        ],
        "loads": [
            {
                "name": "plate", "type": "surface", "body": "block", "start": [1.0, 1.0],
                "end": [0.0, 1.0], "pressure": PRESSURE,
            }
        ],
        "stages": [
            {"name": "load", "schedule": {"steps": 2}},
            {"name": "safety", "type": "strength_reduction", "tolerance": 0.05},
            {
                "name": "unload", "schedule": {"steps": 2},
                "factors": {"plate": [[0.0, 1.0], [1.0, 0.8]]},
            },
            {"name": "safety again", "type": "strength_reduction", "tolerance": 0.1},
        ],
        **changes,
    }  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("safety") / "out"
    run(Model.from_dict(entries()), out, quiet=True)
    return out


def test_each_stage_has_its_factor_of_safety(folder: Path) -> None:
    first, second = read_safety(folder, 1), read_safety(folder, 3)
    assert first.factor <= EXACT * 1.01
    assert first.above >= EXACT * 0.99
    assert second.factor <= EXACT / 0.8 * 1.01
    assert second.above >= EXACT / 0.8 * 0.99
    assert first.above - first.factor <= 0.05 * (1.0 + 1e-9)
    assert (first.time, second.time) == (1.0, 2.0)


def test_the_state_does_not_change(folder: Path, tmp_path: Path) -> None:
    without = entries()
    without["stages"] = [stage for stage in without["stages"] if "schedule" in stage]
    run(Model.from_dict(without), tmp_path / "out", quiet=True)
    history = (folder / "history.csv").read_bytes()
    assert history == (tmp_path / "out" / "history.csv").read_bytes()


def test_log_and_report_name_the_stages(folder: Path) -> None:
    log, report = (folder / "log.txt").read_text(), (folder / "report.html").read_text()
    assert "strength reduction: safety, at time 1: factor of safety 1.4" in log
    for name in ("safety", "safety again"):
        assert f"<h2>Factor of safety: {name}</h2>" in report


def test_resumed(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_in_pieces(Model.from_dict(entries()), tmp_path / "out", [1, 2, 3], monkeypatch)
    assert_same_results(folder, tmp_path / "out")
    for index in (1, 3):
        assert read_safety(folder, index) == read_safety(tmp_path / "out", index)


@pytest.mark.long
def test_a_run_from_a_stage_finds_the_factors_after_it(folder: Path, tmp_path: Path) -> None:
    """Of the stored stage too: its strength reduction may have changed."""
    changed = entries(output=NO_REPORT)
    changed["stages"][1]["tolerance"] = 0.02
    model = Model.from_dict(changed)
    run(model, tmp_path / "new", from_stage=(folder, "load"), quiet=True)
    first = read_safety(tmp_path / "new", 1)
    assert first.above - first.factor <= 0.02 * (1.0 + 1e-9)
    assert read_safety(tmp_path / "new", 3) == read_safety(folder, 3)
    run(model, tmp_path / "last", from_stage=(tmp_path / "new", "unload"), quiet=True)
    assert read_safety(tmp_path / "last", 1) == first


def test_an_undecided_factor_does_not_end_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing depends on it; log, warnings and report say what is certain."""
    at = Trials.at

    def instead(trials: Trials, factor: float, pursues: bool) -> Trial:
        if 1.2 < factor < 1.3:
            return Trial(factor, math.nan, 30, Outcome.UNDECIDED, "the soil does not come to rest")
        return at(trials, factor, pursues)

    monkeypatch.setattr(Trials, "at", instead)
    declared = entries()
    declared["stages"] = declared["stages"][:3]
    declared["stages"][1]["maximum_factor"] = 1.25
    result = run(Model.from_dict(declared), tmp_path / "out", quiet=True)
    found = read_safety(tmp_path / "out", 1)
    assert (result.finished, result.undecided) == (True, {"safety": found.bracket})
    assert (found.is_decided, found.factor, found.above) == (False, 1.2, None)
    certain = f"factor of safety undecided: {found.bracket}"
    log = (tmp_path / "out" / "log.txt").read_text()
    assert f"strength reduction: safety, at time 1: {certain}" in log
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert f"stage 'safety': {certain}" in html.unescape(report)


def test_stages_are_numbered_as_in_the_case_file(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    run(Model.from_dict(entries(output=NO_REPORT)), tmp_path / "out")
    assert "stage 3/4 unload, step 4" in capfd.readouterr().err
    kept = sorted(file.name for file in folder.glob("checkpoint_stage_*"))
    assert kept == ["checkpoint_stage_01.npz", "checkpoint_stage_03.npz"]
    setup = read_staged_setup(folder / SETUP)
    assert setup is not None
    titles = [axes.get_title(loc="left") for axes in next(draw_stages(setup)).axes]
    assert [title.partition("  (")[0] for title in titles] == ["1  load", "3  unload"]


def test_a_run_from_a_stage_may_have_other_reductions_before_it(
    folder: Path, tmp_path: Path
) -> None:
    """The checkpoints of its folder then have the numbers of its own stages."""
    declared = entries(output=NO_REPORT)
    del declared["stages"][1]
    run(Model.from_dict(declared), tmp_path / "new", from_stage=(folder, "unload"), quiet=True)
    kept = sorted(file.name for file in (tmp_path / "new").glob("*_stage_*"))
    assert kept[:2] == ["checkpoint_stage_01.npz", "checkpoint_stage_02.npz"]
    assert all(name.startswith("safety_stage_03.") for name in kept[2:])
    assert read_safety(tmp_path / "new", 2) == read_safety(folder, 3)


def test_new_soil_after_a_reduction_is_found() -> None:
    """Outputs of a parameter are drawn for stages that bring soil, whatever stands between."""
    declared = {
        "bodies": [{"name": "ground"}, {"name": "fill"}],
        "stages": [
            {"name": "weight"},
            {"name": "safety", "type": "strength_reduction", "tolerance": 0.05},
            {"name": "wait"},
            {"name": "fill", "activate": ["fill"]},
        ],
    }
    spans = [("weight", 0.0, 1.0), ("wait", 1.0, 2.0), ("fill", 2.0, 3.0)]
    times = np.array([0.0, 1.0, 1.5, 2.0, 2.5, 3.0])
    assert first_outputs(times, spans, declared) == {"fill": 4}


def first_of_all(declared: dict[str, Any]) -> None:
    declared["stages"] = declared["stages"][1:]


def with_schedule(declared: dict[str, Any]) -> None:
    declared["stages"][1]["schedule"] = {"steps": 1}


def too_fine(declared: dict[str, Any]) -> None:
    declared["stages"][1]["tolerance"] = 1e-6


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (first_of_all, "stages[0].type", "cannot be the first stage"),
        (with_schedule, "stages[1].schedule", "unknown key"),
        (too_fine, "stages[1].tolerance", "at least 0.0001"),
    ],
)
def test_wrong_stages(change: Any, key: str, words: str) -> None:
    declared = entries()
    change(declared)
    with pytest.raises(BadInput) as caught:
        Model.from_dict(declared)
    problem = caught.value.problems[0]
    assert problem.key == key
    assert words in problem.problem


def test_elastic_soil_is_refused_before_the_run(tmp_path: Path) -> None:
    elastic = {"model": "hencky_elastic", "young_modulus": 1e4, "poisson_ratio": 0.3}
    model = Model.from_dict(entries(materials={"soil": elastic}))
    with pytest.raises(BadInput, match=r"nothing can fail .in the stage 'safety'."):
        StagedAnalysis(model).check()
    with pytest.raises(BadInput):
        run(model, tmp_path / "out", quiet=True)
    assert not (tmp_path / "out").exists()


def test_a_factor_that_is_not_found_ends_the_run_and_names_the_stage(tmp_path: Path) -> None:
    declared = entries()
    declared["stages"][1] |= {"maximum_factor": 1.2}
    with pytest.raises(AnalysisFailed, match="stage 'safety': "):
        run(Model.from_dict(declared), tmp_path / "out", quiet=True)


def test_a_run_does_not_go_on_from_a_strength_reduction(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="name the stage before it") as caught:
        run(Model.from_dict(entries()), tmp_path / "new", from_stage=(folder, "safety"), quiet=True)
    assert caught.value.problems[0].key == "from"
    assert not (tmp_path / "new").exists()


@pytest.mark.long
def test_a_factor_within_a_stage_tells_what_is_still_held(tmp_path: Path) -> None:
    """Forces that a stage has not released yet take part in the equilibrium."""
    case = entries()
    case["bodies"].append(
        {
            **case["bodies"][0], "name": "toe",
            "shape": {"type": "box", "lower": [1.0, 0.0], "upper": [1.5, 1.0]},
        }
    )  # fmt: skip
    case["stages"] = [case["stages"][0], digging := {"name": "dig", "schedule": {"steps": 4}}]
    digging["deactivate"] = ["toe"]
    model = Model.from_dict(case)
    run(model, tmp_path / "out", until=1.5, quiet=True)
    safety(tmp_path / "out", settings=StrengthReduction(tolerance=0.2))
    words = "the stage 'dig' is not finished: 50 % of the forces"
    assert words in read_safety(tmp_path / "out").criterion
    resume(tmp_path / "out", quiet=True)
    safety(tmp_path / "out", settings=StrengthReduction(tolerance=0.2))
    assert "not finished" not in read_safety(tmp_path / "out").criterion


def test_a_stage_with_davis_equivalent(tmp_path: Path) -> None:
    """The soil, then its equivalent: log, report and summary say whose factor it is."""
    case = entries(output={"report": True})
    case["materials"]["soil"] = {
        "model": "mohr_coulomb", "young_modulus": 1e4, "poisson_ratio": 0.3, "density": 1.0,
        "cohesion": 9.0, "friction_angle": 30.0, "dilation_angle": 0.0,
    }  # fmt: skip
    load, itself = case["stages"][:2]
    case["stages"] = [load, itself, {**itself, "name": "davis", "davis": "B"}]
    whose = ", of Davis' associated equivalent, form B"
    model = Model.from_dict(case)
    rows = [text for _, text in stage_rows(model)]
    assert f"davis: factor of safety by strength reduction, to 0.05{whose}" in rows
    run(model, tmp_path / "out", quiet=True)
    own, equivalent = (read_safety(tmp_path / "out", index) for index in (1, 2))
    assert (own.davis, equivalent.davis) == (None, "B")
    assert equivalent.above is not None
    assert equivalent.above < own.factor
    lines = (tmp_path / "out" / "log.txt").read_text().splitlines()
    assert [whose in line for line in lines if "factor of safety 1" in line] == [False, True]
    report = html.unescape((tmp_path / "out" / "report.html").read_text())
    assert f"Factor of safety {equivalent.factor:.4g}{whose}: between" in report
