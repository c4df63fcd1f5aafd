# SPDX-License-Identifier: BSD-3-Clause
"""`--explain` of `tilth run` and `tilth resume`: what it prints, writes and refuses."""

from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Outcome

FAILS = (
    ("steps = 2", "steps = 2\nadaptive = false"),
    ("acceleration = [0, -9.81]", "acceleration = [0, -98.1]"),
    ('kind = "plane_strain"', 'kind = "plane_strain"\nmaximum_iterations = 4'),
)
"""A column that its weight crushes in the first step."""


def test_a_step_that_fails_is_told_on_the_screen_and_written(
    tilth: Callable[..., Outcome], case: Callable[..., Path], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    found = tilth("run", case(*FAILS), "--out", folder, "--explain", "1")
    assert found.code == 1
    assert "Traceback" not in found.err
    lines = found.err.splitlines()
    assert "explanation of step 1" in lines
    assert any(line.startswith("attempt 1, from time 0 to 0.5, failed: ") for line in lines)
    head = next(line.split() for line in lines if "most from" in line)
    assert head[:4] == ["residual", "yield", "begin", "cease"]
    for label in ("soil", "loads on points", "held nodes", "out of balance"):
        assert any(line.strip().startswith(label) for line in lines)
    assert f"written to {folder}: explain_1.json, explain_1.csv, explain_1.png" in lines
    assert {path.name for path in folder.glob("explain_*")} == {
        f"explain_1.{ending}" for ending in ("json", "csv", "png")
    }
    again = tilth("run", case(*FAILS), "--out", folder, "--overwrite", "--quiet")
    assert again.code == 1
    assert not list(folder.glob("explain_*"))


@pytest.mark.slow
def test_a_resumed_run_explains_what_is_to_come(
    tilth: Callable[..., Outcome], case: Callable[..., Path], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    assert tilth("run", case(), "--out", folder, "--until", "0.5", "--quiet").code == 0
    refused = tilth("resume", folder, "--explain", "1")
    assert refused.code == 2
    assert "comes before the state from which the run goes on" in refused.err
    assert "begin a new run" in refused.err
    told = tilth("resume", folder, "--explain", "2")
    assert told.code == 0
    assert "explanation of step 2" in told.err
    assert (folder / "explain_2.png").exists()


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("two", 'explain = "two": is not the number of a step'),
        ("0", "give the number of a load step from 1 on"),
        ("dig:1", "the model has no stages"),
    ],
)
def test_wrong_steps_are_refused_before_the_run(
    tilth: Callable[..., Outcome],
    case: Callable[..., Path],
    tmp_path: Path,
    given: str,
    expected: str,
) -> None:
    found = tilth("run", case(), "--out", tmp_path / "out", "--explain", given)
    assert found.code == 2
    assert expected in found.err
    assert not (tmp_path / "out").exists()


def test_a_step_that_is_not_there_is_an_error_after_the_run(
    tilth: Callable[..., Outcome], case: Callable[..., Path], tmp_path: Path
) -> None:
    elastic = ("steps = 2", "steps = 1"), ('model = "von_mises"', 'model = "hencky_elastic"')
    plastic = ("yield_stress = 2e4\n", ""), ("hardening_modulus = 0\n", "")
    report = ("[[track]]", "[output]\nreport = false\n\n[[track]]")
    file = case(*elastic, *plastic, report)
    found = tilth("run", file, "--out", tmp_path / "out", "--explain", "7", "--quiet")
    assert found.code == 2
    assert "the run ended with step 1 and had no such step" in found.err
    assert "name a step that log.txt has, in a new run" in found.err
    assert (tmp_path / "out" / "results.vtkhdf").exists()


def test_a_run_that_fails_before_the_step_says_where(
    tilth: Callable[..., Outcome], case: Callable[..., Path], tmp_path: Path
) -> None:
    found = tilth("run", case(*FAILS), "--out", tmp_path / "out", "--explain", "2")
    assert found.code == 1
    assert "step 2 to explain was not among the steps taken; the last one tried is 1" in found.err
    assert not list((tmp_path / "out").glob("explain_*"))


def test_a_run_that_stops_before_the_step_says_how_to_go_on(
    tilth: Callable[..., Outcome], case: Callable[..., Path], tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    found = tilth("run", case(), "--out", folder, "--until", "0.5", "--explain", "2", "--quiet")
    assert found.code == 2
    assert "the run stopped after step 1, before this step" in found.err
    assert f"tilth resume {folder} --explain 2" in found.err
    assert "had no such step" not in found.err
