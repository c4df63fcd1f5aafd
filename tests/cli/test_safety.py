# SPDX-License-Identifier: BSD-3-Clause
"""`tilth safety`: its files, what it prints, and its errors."""

import csv
import html
import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import tilth as library
from tilth.analysis.safety_search import Outcome as Found
from tilth.analysis.safety_search import Trial
from tilth.analysis.safety_trials import Trials
from tilth.model import SafetyOutcome
from tilth.output import read_results
from tilth.output.folder import FILES
from tilth.output.safety_files import read_safety
from tilth.studies.outcomes import value_of

from .conftest import Outcome

Case = Callable[..., Path]
Tilth = Callable[..., Outcome]

STRONGER = ("yield_stress = 2e4", "yield_stress = 1e5")
"""A column of 4 m whose weight makes 70 kPa at its base."""


@pytest.mark.slow
def test_safety_of_a_case(tilth: Tilth, case: Case, tmp_path: Path) -> None:
    file, folder = case(STRONGER), tmp_path / "column"
    done = tilth("safety", file, "--tolerance", "0.05", "--threads", "1")
    assert done.code == 0, done.err
    assert "Factor of safety" in done.out
    assert "Criterion: equilibrium: Newton's method converges to a relative residual of" in done.out
    assert "collapse: connected soil, at least 3 cells wide, moves by more than" in done.out
    assert "10 times the elastic displacement" in done.out
    with (folder / "safety.csv").open(encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    assert list(rows[0]) == [
        "factor", "largest displacement [m]", "iterations", "outcome", "reason",
    ]  # fmt: skip
    assert done.out.count(" iterations ") >= len(rows)
    stable = [float(row["factor"]) for row in rows if row["outcome"] == "equilibrium"]
    failed = [float(row["factor"]) for row in rows if row["outcome"] == "collapse"]
    assert 0.0 < min(failed) - max(stable) <= 0.05 + 1e-9
    assert f"between {max(stable):.6g} (equilibrium) and {min(failed):.6g} (collapse)" in done.out
    summary = json.loads((folder / "safety.json").read_text(encoding="utf-8"))
    assert summary["factor"] == max(stable)
    # 2 s_u / (gamma H) of a column whose lower half can fail, between those of its base and middle
    base = 2.0 * 1e5 / np.sqrt(3.0) / (1800 * 9.81 * 4.0)
    assert base <= summary["factor"] <= 2.0 * base
    mechanism = read_results(folder / "safety.vtkhdf")
    state, last = mechanism.snapshot(-1), read_results(folder / "results.vtkhdf").snapshot(-1)
    assert (mechanism.steps, mechanism.times) == ([last.step], [last.time])
    np.testing.assert_array_equal(state.position, last.position)
    moved = np.linalg.norm(state.point_fields["displacement"], axis=1).max()
    assert moved == pytest.approx(
        max(float(row["largest displacement [m]"]) for row in rows if row["outcome"] != "collapse")
    )
    assert state.point_fields["plastic_strain_increment"].max() > 0.0
    assert (folder / "safety.png").stat().st_size > 0
    assert "Factor of safety" in (folder / "report.html").read_text(encoding="utf-8")
    # the same of the finished run, bit by bit; again at another tolerance
    again = tilth("safety", folder, "--tolerance", "0.05", "--threads", "1", "--quiet")
    assert (again.code, again.out) == (0, "")
    assert json.loads((folder / "safety.json").read_text(encoding="utf-8")) == summary
    # a run that is replaced leaves nothing of it
    assert tilth("run", file, "--overwrite", "--quiet").code == 0
    assert not [name for name in FILES if name.startswith("safety") and (folder / name).exists()]


@pytest.mark.slow
def test_safety_from_python(case: Case, tmp_path: Path) -> None:
    model = library.load_case(case(STRONGER))
    unstored = model.model_copy(
        update={"output": model.output.model_copy(update={"checkpoint_every": 0, "report": False})}
    )
    found: list[float] = []
    settings = library.StrengthReduction(tolerance=0.05)
    result = library.safety(
        unstored, tmp_path / "out", settings=settings, threads=1, quiet=True,
        on_trial=lambda trial: found.append(trial.factor),
    )  # fmt: skip
    assert found == [trial.factor for trial in result.trials]
    again = library.safety(tmp_path / "out", settings=settings, threads=1)
    assert again.factor == result.factor
    np.testing.assert_array_equal(again.displacement, result.displacement)
    with pytest.raises(library.BadInput, match="out: missing"):
        library.safety(model)
    with pytest.raises(library.BadInput, match="leave it out"):
        library.safety(tmp_path / "out", tmp_path / "other")


@pytest.mark.slow
def test_safety_of_an_equivalent(tilth: Tilth, case: Case, tmp_path: Path) -> None:
    """Whose factor it is stands in all texts; soil of constant volume has the same factor."""
    folder = tmp_path / "column"
    assert tilth("safety", case(STRONGER), "--tolerance", "0.1", "--quiet").code == 0
    itself = read_safety(folder)
    done = tilth("safety", folder, "--tolerance", "0.1", "--davis", "C")
    assert done.code == 0, done.err
    equivalent = read_safety(folder)
    assert (itself.davis, equivalent.davis) == (None, "C")
    assert equivalent.factor == itself.factor
    whose = f"Factor of safety {itself.factor:.4g}, of Davis' associated equivalent, form C:"
    assert whose in done.out
    assert "; strength, of Davis' associated equivalent, form C" in done.out
    report = html.unescape((folder / "report.html").read_text(encoding="utf-8"))
    assert whose in report


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--tolerance", "0"), "StrengthReduction.tolerance = 0.0: must be greater than zero"),
        (("--tolerance", "-1"), "StrengthReduction.tolerance = -1.0: must be greater than zero"),
        (("--tolerance", "nan"), "StrengthReduction.tolerance = NaN"),
        (("--start", "0"), "StrengthReduction.start = 0.0: must be greater than zero"),
        (("--davis", "b"), "'--davis': 'b' is not one of 'A', 'B', 'C'"),
        (("--start", "0.01"), "StrengthReduction.minimum_factor = 0.1: must be at most `start`"),
    ],
)
def test_wrong_options(
    tilth: Tilth, case: Case, tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    done = tilth("safety", case(), *arguments)
    assert done.code == 2
    assert message in done.err
    assert not (tmp_path / "column").exists()


def test_what_cannot_fail_is_refused_before_the_run(
    tilth: Tilth, case: Case, tmp_path: Path
) -> None:
    elastic = 'model = "von_mises"', 'model = "hencky_elastic"'
    nothing = ("yield_stress = 2e4\n", ""), ("hardening_modulus = 0\n", "")
    done = tilth("safety", case(elastic, *nothing))
    assert done.code == 2
    assert "column.toml: materials: all materials are elastic: nothing can fail" in done.err
    assert not (tmp_path / "column").exists()


def test_too_weak_soil_ends_the_run(tilth: Tilth, case: Case) -> None:
    done = tilth("safety", case(("yield_stress = 2e4", "yield_stress = 1e3")), "--quiet")
    assert done.code == 1
    assert "failed" in done.err


def test_wrong_folders(tilth: Tilth, case: Case, tmp_path: Path) -> None:
    assert tilth("safety", tmp_path / "nothing.toml").code == 2
    done = tilth("safety", tmp_path)
    assert done.code == 2
    assert "name the folder of a tilth run" in done.err
    done = tilth("safety", tmp_path, "--overwrite")
    assert done.code == 2
    assert "leave them out for the folder of a run" in done.err
    file = case(STRONGER, ("[schedule]", "[output]\ncheckpoint_every = 0\n[schedule]"))
    assert tilth("run", file, "--quiet").code == 0
    done = tilth("safety", tmp_path / "column")
    assert done.code == 2
    assert "has no checkpoint" in done.err


@pytest.mark.long
def test_safety_after_the_last_stage(tilth: Tilth, case: Case, tmp_path: Path) -> None:
    """Without its upper half a column has at least twice the factor; points are gone then."""
    steps = "[schedule]\nsteps = 2\n"
    dug = """
[[stages]]
name = "weight"
schedule = { steps = 2 }

[[stages]]
name = "dig"
schedule = { steps = 1 }
factors = { weight = [[0.0, 1.0], [1.0, 1.0]] }

[[stages.excavate]]
body = "column"
shape = { type = "box", lower = [-1.0, 2.0], upper = [2.0, 5.0] }
"""
    named = ('type = "body_force"', 'name = "weight"\ntype = "body_force"')
    whole = case(STRONGER)
    assert tilth("safety", whole, "--quiet", "--tolerance", "0.1").code == 0
    before = json.loads((tmp_path / "column" / "safety.json").read_text(encoding="utf-8"))
    done = tilth("safety", case(STRONGER, named, (steps, dug)), "--overwrite", "--tolerance", "0.1")
    assert done.code == 0, done.err
    after = json.loads((tmp_path / "column" / "safety.json").read_text(encoding="utf-8"))
    assert after["time"] == 2.0
    assert after["factor"] > 2.0 * before["factor"]
    state = read_results(tmp_path / "column" / "safety.vtkhdf").snapshot(-1)
    assert len(state.position) < 2 * 4 * 8


def undecided(monkeypatch: pytest.MonkeyPatch, least: float, collapse: float) -> None:
    """Makes trials undecided from a factor on, and a collapse from another one on."""
    at = Trials.at

    def instead(trials: Trials, factor: float, pursues: bool) -> Trial:
        if factor < least:
            return at(trials, factor, pursues)
        if factor < collapse:
            return Trial(factor, math.nan, 30, Found.UNDECIDED, "the soil does not come to rest")
        return Trial(factor, 1.0, 30, Found.COLLAPSE, "a mechanism of 5 cells moves")

    monkeypatch.setattr(Trials, "at", instead)


@pytest.mark.slow
def test_an_undecided_factor_is_no_number(
    tilth: Tilth, case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its bracket is told, the files are written, and the exit code is 1."""
    undecided(monkeypatch, 1.05, 1.25)
    file, folder = case(STRONGER), tmp_path / "column"
    done = tilth("safety", file, "--tolerance", "0.05", "--threads", "1")
    assert done.code == 1
    summary = read_safety(folder)
    assert not summary.is_decided
    assert (summary.factor, len(summary.undecided)) == (1.0, len(set(summary.undecided)))
    assert summary.above is not None
    assert 1.25 <= summary.above < 1.5
    certain = f"between 1 (equilibrium) and {summary.above:.6g} (collapse)"
    assert f"Factor of safety undecided: {certain}" in done.out
    assert f"the factor of safety is undecided: {certain}" in done.err
    assert f"undecided trials between them: {len(summary.undecided)}" in done.err
    assert "Traceback" not in done.err
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert f"Factor of safety undecided: {certain}" in report
    assert 'aria-label="Mechanism, Displacement' in report
    with (folder / "safety.csv").open(encoding="utf-8") as table:
        outcomes = {row["outcome"] for row in csv.DictReader(table)}
    assert outcomes == {"equilibrium", "undecided", "collapse"}
    with pytest.raises(library.BadInput, match="is undecided: between 1"):
        value_of(SafetyOutcome(), folder)
    undecided(monkeypatch, 1.05, math.inf)  # no collapse at all
    assert tilth("safety", folder, "--tolerance", "0.05", "--threads", "1").code == 1
    assert read_safety(folder).above is None
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert "between 1 (equilibrium), no collapse found above it" in report


@pytest.mark.slow
def test_a_state_that_is_not_found_again_is_an_error(
    tilth: Tilth, case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A failure at factor 1, where the run has its equilibrium, is never a factor below 1."""
    undecided(monkeypatch, 0.0, math.inf)
    done = tilth("safety", case(STRONGER), "--threads", "1", "--quiet")
    assert done.code == 1
    assert "the equilibrium at the factor 1 is not found again (the soil does not" in done.err
    assert "no factor of safety follows" in done.err
    assert not (tmp_path / "column" / "safety.json").exists()


STAGES = (
    "[schedule]\nsteps = 2\n",
    '[[stages]]\nname = "load"\nschedule = { steps = 2 }\n\n'
    '[[stages]]\nname = "how safe"\ntype = "strength_reduction"\ntolerance = 0.05\n\n'
    '[[stages]]\nname = "wait"\nschedule = { steps = 1 }\n',
)


@pytest.mark.slow
def test_a_run_with_an_undecided_stage_is_complete_but_ends_with_1(
    tilth: Tilth, case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As `tilth safety`; resumed too. One that has not come so far ends with 0."""
    undecided(monkeypatch, 1.05, 1.25)
    file, folder = case(STRONGER, STAGES), tmp_path / "column"
    done = tilth("run", file, "--threads", "1")
    assert done.code == 1
    assert f"results in {folder}" in done.out
    certain = read_safety(folder, 1).bracket
    assert f"the factor of safety is undecided in the stage 'how safe': {certain}" in done.err
    assert "Traceback" not in done.err
    assert f"Factor of safety undecided: {certain}" in (folder / "report.html").read_text("utf-8")
    assert (folder / "history.csv").read_text("utf-8").splitlines()[-1].startswith("3,")
    stopped = tilth("run", file, "--overwrite", "--until", "0.5", "--quiet", "--threads", "1")
    assert (stopped.code, stopped.err) == (0, "")
    resumed = tilth("resume", folder, "--quiet", "--threads", "1")
    assert (resumed.code, resumed.out) == (1, "")
    assert certain in resumed.err
