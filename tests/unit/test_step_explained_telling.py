# SPDX-License-Identifier: BSD-3-Clause
"""What is told of an explained step: which iterations, how an attempt ended, what files say."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from resumed_runs import entries_of
from sand_footings import small_footing

from tilth import BadInput, Model, run
from tilth.analysis.asked_step import AskedStep
from tilth.analysis.explain import Explanation
from tilth.analysis.explain_files import write_explanation
from tilth.analysis.explain_tables import screen_text, spreadsheet
from tilth.analysis.explained import (
    SMALL,
    ExplainedStep,
    Iteration,
    Largest,
    Solve,
    TermForces,
    TriedStep,
)
from tilth.analysis.observer import Search
from tilth.analysis.residual import nearest_point
from tilth.plot.residual_forces import OutOfBalance


def iterated(solve: Solve, *iterations: tuple[int, float], force: float = 1.0) -> Solve:
    """Adds iterations of these numbers and residuals, in which a term has a force."""
    place = np.array([[4.0, 2.5]])
    for number, relative in iterations:
        out = np.array([relative * force, 0.0])
        terms = [TermForces("soil", force, out, 1.0, out)]
        largest = Largest(place[0], out, 528, place[0], "block", "soil", "soil")
        own = Iteration(number, relative, relative, False, terms, {}, largest, [], 0, None, None)
        out_of_balance = OutOfBalance(place, place, place[:, 0] < 0, place, out[None, :])
        solve.add(own, out_of_balance)
    return solve


def test_what_is_shown_is_from_where_newtons_method_went_astray() -> None:
    """Of a solution that failed the closest iteration after the first, else the last one."""
    place = np.zeros((1, 2))
    none = Largest(place[0], place[0], 0, place[0], "block", "soil", "")
    for failure, told in (("none", 2), (None, 4)):
        solve = Solve("Newton's method", failure=failure)
        assert solve.telling is None
        for number, relative in enumerate((0.01, 0.3, 0.02, 0.9, 0.8)):
            iteration = Iteration(number, relative, 1.0, False, [], {}, none, [], 0, None, None)
            solve.add(iteration, OutOfBalance(place, place, place[:, 0] > 0, place, place + number))
        assert solve.telling is not None
        iteration, residuals = solve.telling
        assert iteration.number == residuals.force[0, 0] == told
    plain, creeping = Solve("a", failure="x"), Solve("b", Search.CREEPING, failure="y")
    for each in (plain, creeping):
        each.add(iteration, residuals)
    failed = TriedStep(0.0, 1.0, [plain, creeping], failure="z")
    accepted = TriedStep(0.0, 0.5, [plain, creeping])
    assert (failed.telling, accepted.telling) == (plain, creeping)
    assert ExplainedStep(1, "", "", "", [failed, accepted]).shown == (1, plain)
    assert ExplainedStep(1, "", "", "", [accepted]).shown == (1, creeping)
    assert ExplainedStep(1, "", "", "", [TriedStep(0.0, 1.0)]).shown is None


def test_an_equilibrium_that_is_left_again_is_not_told() -> None:
    """Contact is revised at an equilibrium; the iteration that goes on from there fails."""
    solve = Solve("Newton's method", failure="no equilibrium")
    iterated(solve, (0, 0.01), (1, 1e-9), (1, 0.3), (2, 0.1), (3, 0.2))
    assert solve.telling is not None
    assert solve.telling[0].relative == 0.1


def test_a_refused_equilibrium_is_told_and_not_what_failed_before_it() -> None:
    failed = iterated(Solve("plain", failure="x"), (0, 0.1), (1, 0.2))
    search = iterated(Solve("with a line search"), (0, 0.1), (1, 1e-9))
    crept = iterated(Solve("creeps", Search.CREEPING), (0, 0.1), (1, 1e-9))
    assert TriedStep(0.0, 1.0, [failed, search], "it passes through").telling is search
    assert TriedStep(0.0, 1.0, [failed, crept], "no equilibrium").telling is failed
    assert TriedStep(0.0, 1.0, [failed, Solve("begun")], "interrupted").telling is failed


def test_pseudo_steps_are_one_line_and_searches_for_rest_have_their_own() -> None:
    failed = iterated(Solve("plain", failure="x"), (0, 0.1), (1, 0.2))
    pseudo = [Solve("creeps", Search.CREEPING) for _ in range(2)]
    iterated(pseudo[0], (0, 0.1), (1, 1e-9), (1, 0.2), (2, 1e-9))
    iterated(pseudo[1], (0, 0.1), (1, 1e-9))
    rest = iterated(Solve("from where the soil has crept", Search.REST), (0, 0.1), (1, 1e-9))
    attempt = TriedStep(0.0, 1.0, [failed, *pseudo, rest], "refused")
    lines = screen_text(ExplainedStep(1, "", "", "", [attempt])).splitlines()
    assert attempt.telling is failed
    assert "  creeps: 2 pseudo-steps, 3 iterations" in lines
    assert any(line.startswith("  from where the soil has crept: 1 iterations") for line in lines)


def test_an_attempt_that_the_user_stops_has_not_failed() -> None:
    explanation = Explanation(AskedStep(1))
    model = Model.from_dict(entries_of())
    with pytest.raises(KeyboardInterrupt), explanation.attempt(model, 1, 0.0, 0.5):
        raise KeyboardInterrupt("SIGTERM")
    assert explanation.step is not None
    assert "attempt 1, from time 0 to 0.5, interrupted" in screen_text(explanation.step)
    assert "failed" not in screen_text(explanation.step)
    assert not explanation.complete


@pytest.mark.parametrize("ratio", [0.0, 0.9, 1.1])
def test_no_place_and_no_share_is_told_at_an_equilibrium(ratio: float) -> None:
    solve = iterated(Solve("Newton's method"), (0, ratio * SMALL))
    step = ExplainedStep(4, "dig", "m", "N", [TriedStep(0.0, 1.0, [solve])])
    told: Any = step.to_dict()["attempts"][0]["solves"][0]["iterations"][0]
    (row,) = csv.DictReader(spreadsheet(step).splitlines())
    shown = screen_text(step)
    assert shown.startswith("explanation of step 4, in the stage 'dig'")
    is_told = ratio > 1.0
    assert ("(4, 2.5)" in shown) == ("528" in shown) == is_told
    assert ("share" in shown) == ("x at node" in shown) == is_told
    assert (told["largest"] is not None) == is_told
    assert (told["terms"][0]["share"] is not None) == is_told
    assert (told["terms"][0]["at_largest"] is not None) == is_told
    for key in ("largest_at_x [m]", "point", "body", "share", "force_at_largest_y [N]"):
        assert (row[key] != "") == is_told
    assert row["norm [N]"] == "1.0"


@pytest.mark.parametrize(
    ("asked", "stage", "done", "expected"),
    [
        ("9", "dig", False, "stopped after step 4, before this step"),
        ("dig:9", "dig", False, "stopped after step 4, before this step"),
        ("dig:9", "dig", True, "beyond this stage, after step 4"),
        ("weight:9", "dig", False, "beyond this stage, after step 4"),
        ("wall away:1", "dig", True, "stopped after step 4, before this step"),
    ],
)
def test_a_run_that_stopped_as_asked_says_how_to_go_on(
    asked: str, stage: str, done: bool, expected: str
) -> None:
    name, _, number = asked.rpartition(":")
    explanation = Explanation(AskedStep(int(number), name), {"weight": 0, "dig": 2})
    with pytest.raises(BadInput, match=expected) as error:
        explanation.require_reached(Path("out"), 4, stage, done, False)
    given = f"'{asked}'" if " " in asked else asked
    is_to_come = "stopped" in expected
    assert (f"tilth resume out --explain {given}" in error.value.remedy) == is_to_come


def test_an_old_picture_does_not_stay_beside_new_numbers(tmp_path: Path) -> None:
    old = tmp_path / "explain_1.png"
    old.write_bytes(b"old")
    step = ExplainedStep(1, "", "", "", [TriedStep(0.0, 1.0)])
    assert write_explanation(step, tmp_path) == ["explain_1.json", "explain_1.csv"]
    assert not old.exists()


def test_only_the_telling_residual_is_kept_after_an_attempt() -> None:
    failed = iterated(Solve("plain", failure="x"), (0, 0.1), (1, 0.2))
    crept = iterated(Solve("creeps", Search.CREEPING), (0, 0.1), (1, 1e-9))
    attempt = TriedStep(0.0, 1.0, [failed, crept], "no equilibrium")
    attempt.drop_all_but_telling()
    assert attempt.telling is failed
    assert failed.telling is not None
    assert crept.telling is None


def test_the_nearest_point_is_of_the_nodes_overlay() -> None:
    """Of bodies that may part, the point of the other one may be nearer to a node."""

    class Points(SimpleNamespace):
        def __len__(self) -> int:
            return len(self.position)

    place = np.array([[0.1, 0.0], [0.3, 0.0]])
    points = Points(position=place, overlays_of=lambda chosen: np.array([0, 1])[chosen])
    nodes = {"points": points, "position": np.zeros((2, 2)), "overlay": np.array([0, 1])}
    for overlays, nearest in ((1, [0, 0]), (2, [0, 1])):
        active: Any = SimpleNamespace(overlays=overlays, **nodes)
        assert [nearest_point(active, node) for node in (0, 1)] == nearest


@pytest.mark.slow
def test_soil_that_creeps_to_rest_is_told_from_where_it_has_crept(tmp_path: Path) -> None:
    """A footing in sand: the equilibrium that ends the creep is the telling one."""
    run(small_footing(10), tmp_path, quiet=True, until=0.4, explain=4)
    told = json.loads((tmp_path / "explain_4.json").read_text())
    solves = told["attempts"][-1]["solves"]
    methods = [each["method"] for each in solves]
    assert methods[-1].startswith("Newton's method, from where the soil has crept")
    crept = [each.startswith("soil creeps against a drag") for each in methods]
    assert any(crept)
    assert not any(crept[:2])
    last = solves[-1]["iterations"][-1]
    assert (solves[-1]["failure"], last["largest"]) == (None, None)
    assert {each["share"] for each in last["terms"]} == {None}
