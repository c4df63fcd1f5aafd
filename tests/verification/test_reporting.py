# SPDX-License-Identifier: BSD-3-Clause
"""What `tilth verify` prints and returns, and what counts as passed."""

import json
import math
import sys

import pytest

from tilth.cli import run_command
from tilth.errors import AnalysisFailed
from tilth_verification import problems
from tilth_verification.cases import example, folder_of_cases, varied
from tilth_verification.comparison import (
    absolute,
    at_least,
    relative,
    vanishing,
    within_factor,
)

KEYS = [
    "problem", "quantity", "unit", "computed", "reference", "error", "tolerance", "source",
    "passed", "seconds",
]  # fmt: skip


@pytest.fixture
def listed(monkeypatch):
    """Replaces the list of problems by functions that need no analysis."""

    def good(long):
        yield relative("pressure", 101.0, 100.0, 0.02, "paper", "Pa")
        if long:
            yield vanishing("distance", 0.001, 0.01, "paper", "m")

    def wrong(long):
        yield relative("pressure", 103.0, 100.0, 0.02, "paper", "Pa")
        yield vanishing("distance", math.nan, 0.01, "paper", "m")

    def failing(long):
        yield vanishing("distance", 0.0, 0.01, "paper", "m")
        raise AnalysisFailed("time 0.5: no equilibrium")

    listed = {"good": good, "wrong": wrong, "failing": failing}
    monkeypatch.setattr(problems, "PROBLEMS", listed)
    return listed


def test_json_is_a_list_of_rows_and_nothing_else(listed, capsys):
    assert run_command(["verify", "good", "--json"]) == 0
    output = capsys.readouterr()
    (row,) = json.loads(output.out)
    assert sorted(row) == sorted(KEYS)
    assert row["problem"] == "good"
    assert row["computed"] == 101.0
    assert row["error"] == pytest.approx(0.01)
    assert row["passed"] is True
    assert output.err == ""


def test_long_adds_rows(listed, capsys):
    assert run_command(["verify", "good", "--json", "--long"]) == 0
    assert len(json.loads(capsys.readouterr().out)) == 2


def test_a_row_out_of_its_tolerance_gives_exit_code_1(listed, capsys):
    assert run_command(["verify", "wrong", "--json"]) == 1
    rows = json.loads(capsys.readouterr().out)
    assert [row["passed"] for row in rows] == [False, False]
    assert rows[1]["computed"] is None  # not a number


def test_an_analysis_that_fails_is_a_row_that_did_not_pass(listed, capsys):
    assert run_command(["verify", "--json"]) == 1
    rows = json.loads(capsys.readouterr().out)
    assert [row["problem"] for row in rows] == ["good", "wrong", "wrong", "failing", "failing"]
    assert "no equilibrium" in rows[-1]["quantity"]
    assert rows[-1]["passed"] is False


def test_table_names_what_failed(listed, capsys):
    assert run_command(["verify", "wrong"]) == 1
    output = capsys.readouterr().out
    assert "FAILED" in output
    assert "0 of 2 passed" in output


def test_unknown_problem_is_refused_before_anything_runs(listed, capsys):
    assert run_command(["verify", "good", "faling", "--json"]) == 2
    output = capsys.readouterr()
    assert "did you mean failing?" in output.err
    assert output.out == ""


def test_without_the_package_of_the_problems_one_message_says_so(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "tilth_verification", None)
    assert run_command(["verify"]) == 2
    assert "there is no package tilth_verification" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("comparison", "passed"),
    [
        (relative("q", -99.0, -100.0, 0.02, ""), True),
        (relative("q", -97.0, -100.0, 0.02, ""), False),
        (absolute("q", 2.1, 2.0, 0.2, ""), True),
        (absolute("q", 1.7, 2.0, 0.2, ""), False),
        (vanishing("q", -0.1, 0.2, ""), True),
        (vanishing("q", -0.3, 0.2, ""), False),
        (vanishing("q", math.nan, 0.2, ""), False),
        (within_factor("q", 1.4, 1.0, 1.5, ""), True),
        (within_factor("q", 1.0, 1.4, 1.5, ""), True),
        (within_factor("q", 1.6, 1.0, 1.5, ""), False),
        (within_factor("q", 1.0, 1.6, 1.5, ""), False),
        (at_least("q", 2.5, 2.0, 0.1, ""), True),
        (at_least("q", 1.95, 2.0, 0.1, ""), True),
        (at_least("q", 1.8, 2.0, 0.1, ""), False),
        (at_least("q", math.nan, 2.0, 0.1, ""), False),
    ],
)
def test_ways_of_comparing(comparison, passed):
    assert comparison.passed is passed
    assert not comparison.error < 0.0


def test_varied_changes_one_key_and_leaves_the_original():
    model = example("self_weight_column")
    other = varied(model, {"bodies.0.basis": "linear", "bodies.0.domain_update": None})
    assert other.bodies[0].basis == "linear"
    assert model.bodies[0].basis == "gimp"
    assert varied(other, {"bodies.0.basis": "gimp"}) == model


def test_case_files_are_found():
    assert (folder_of_cases() / "self_weight_column" / "case.toml").is_file()
