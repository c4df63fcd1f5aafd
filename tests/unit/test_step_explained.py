# SPDX-License-Identifier: BSD-3-Clause
"""A step that is explained: forces against the residual, changes against counts, same results."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contact_terms import DRIVEN, FREE, pressed
from resumed_runs import assert_same_results, entries_of
from script_module import module_of
from small_problems import material_entries
from staged_problems import staged_entries

from tilth import AnalysisFailed, BadInput, Model, resume, run
from tilth.analysis.asked_step import AskedStep
from tilth.analysis.explain import Explanation
from tilth.analysis.explain_files import write_explanation
from tilth.analysis.explained import (
    HELD,
    ExplainedStep,
)
from tilth.analysis.from_stage import stored_stage
from tilth.analysis.residual import Iterate
from tilth.analysis.simulation import Simulation
from tilth.boundaries.contact.forces import AssembledContact
from tilth.comm import SERIAL

DOCS = Path(__file__).parents[2] / "docs"

CUT = 2
"""The first step of `cut_entries` that is cut."""


def cut_entries(**schedule: Any) -> dict[str, Any]:
    """The block of `entries_of` without a line search, so that some steps fail."""
    entries = entries_of()
    entries["analysis"]["line_search"] = False
    entries["schedule"] |= schedule
    return entries


class Recounted(Explanation):
    """Counts for itself, from the soil and the law of contact, what changes in each iteration."""

    def __init__(self, simulation: Simulation, asked: int) -> None:
        super().__init__(AskedStep(asked))
        self._simulation = simulation
        self._sets: list[dict[str, set[int]]] = []
        self.seen = 0

    def iteration(self, number: int, state: Iterate, moving: bool) -> None:
        super().iteration(number, state, moving)
        if self._watched is None:  # a step that is not explained
            return
        assert self.step is not None
        balance = self._watched.balance
        own = self.step.attempts[-1].solves[-1].iterations
        if len(own) == 1:
            self._sets = []
        told = own[-1]
        soil = self._simulation.soil_on(balance.active)
        soil.update(state.x.u)
        more = soil._trial.plastic[:, 0] > soil.points.plastic[:, 0]
        sets = {"yield": set(np.flatnonzero(more).tolist())}
        for term in balance.terms:
            if isinstance(term, AssembledContact):
                sets |= by_the_law(term)
        self._compare(told, sets)
        self._sets.append(sets)
        self.seen += 1
        free = np.where(balance.fields["u"].constrained, 0.0, state.residual.u)
        assert told.norm == pytest.approx(np.linalg.norm(free))
        assert told.relative == state.relative
        place = balance.active.position[np.linalg.norm(free, axis=1).argmax()]
        np.testing.assert_array_equal(told.largest.node, place)

    def _compare(self, told: Any, sets: dict[str, set[int]]) -> None:
        assert told.yielding == len(sets["yield"])
        before = self._sets[-1] if self._sets else None
        if before is None:
            assert (told.began, told.ceased) == (None, None)
        else:
            assert told.began == len(sets["yield"] - before["yield"])
            assert told.ceased == len(before["yield"] - sets["yield"])
        for each in told.contact:
            closed, slides = (sets[f"{each.surface} {key}"] for key in ("closed", "slides"))
            assert (each.sticking, each.sliding) == (len(closed - slides), len(slides))
            if before is None:
                assert each.opened is each.closed is each.slid is each.stuck is None
                continue
            was, slid = (before[f"{each.surface} {key}"] for key in ("closed", "slides"))
            assert (each.opened, each.closed) == (len(was - closed), len(closed - was))
            both = was & closed
            assert each.slid == len((slides - slid) & both)
            assert each.stuck == len((slid - slides) & both)


def by_the_law(term: AssembledContact) -> dict[str, set[int]]:
    """Points of a surface in contact and sliding, counted one by one."""
    closed, slides, number = set(), set(), 0
    for patch, _, found in term._each():
        for point, multiplier in enumerate(patch.part.multiplier):
            if found.response.closed[multiplier] and patch.active[point]:
                closed.add(number)
                if found.response.sliding[multiplier]:
                    slides.add(number)
            number += 1
    return {f"{term.name} closed": closed, f"{term.name} slides": slides}


def watched(simulation: Simulation, steps: int, size: float) -> Recounted:
    """Takes steps of one size, the last of which is explained."""
    explanation = Recounted(simulation, steps)
    simulation.services.observer = explanation
    for number in range(steps):
        with explanation.attempt(
            simulation.setup.model, number + 1, number * size, (number + 1) * size
        ):
            simulation.advance(number * size, (number + 1) * size)
    assert explanation.complete
    return explanation


def assert_sums(step: ExplainedStep) -> None:
    """The forces of all terms and of what holds nodes sum to what is out of balance."""
    for attempt in step.attempts:
        for solve in attempt.solves:
            for each in solve.iterations:
                assert each.terms[-1].label == HELD
                assert len({term.label for term in each.terms}) == len(each.terms)
                size = sum(term.norm for term in each.terms)
                at_largest = sum(term.at_largest for term in each.terms)
                bound = 1e-13 * size
                np.testing.assert_allclose(at_largest, each.largest.force, rtol=0, atol=bound)
                if each.norm > 1e-8 * size:
                    assert sum(term.share for term in each.terms) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize(("way", "steps"), [(DRIVEN, 3), (FREE, 1)])
def test_changes_of_contact_and_yield_are_those_counted_one_by_one(way: str, steps: int) -> None:
    explanation = watched(pressed("plane_strain", "limited", way), steps, 0.25)
    assert explanation.step is not None
    solves = explanation.step.attempts[-1].solves
    assert explanation.seen == sum(len(solve.iterations) for solve in solves)
    iterations = solves[-1].iterations
    contact = [each.contact[0] for each in iterations[1:]]
    assert any(each.stuck for each in contact)
    assert any(each.slid for each in contact)
    if way == FREE:
        assert any(each.opened for each in contact)
        assert any(each.closed for each in contact)
        assert iterations[-1].bodies.keys() == {"contact with 'body'"}
    else:
        assert any(each.began for each in iterations[1:])
        assert any(each.ceased for each in iterations[1:])
    assert_sums(explanation.step)
    names = {each.label for each in iterations[0].terms}
    assert "" not in names
    assert names >= {"soil", "loads on points", "weak springs", "contact with 'body'", HELD}


def test_the_same_in_space_and_its_picture_has_two_views(tmp_path: Path) -> None:
    explanation = watched(pressed("3d", "limited", DRIVEN), 1, 0.25)
    assert explanation.step is not None
    assert_sums(explanation.step)
    write_explanation(explanation.step, tmp_path)
    assert (tmp_path / "explain_1.png").read_bytes().startswith(b"\x89PNG")


@pytest.fixture(scope="module")
def model() -> Model:
    return Model.from_dict(cut_entries())


@pytest.fixture(scope="module")
def plain(model: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plain") / "run"
    run(model, folder, quiet=True)
    return folder


def read(folder: Path, step: int) -> Any:
    return json.loads((folder / f"explain_{step}.json").read_text())


def test_results_are_the_same_bits_and_all_attempts_are_told(
    model: Model, plain: Path, tmp_path: Path
) -> None:
    run(model, tmp_path / "run", quiet=True, explain=CUT)
    assert_same_results(plain, tmp_path / "run")
    told = read(tmp_path / "run", CUT)
    failed, accepted = told["attempts"][0], told["attempts"][-1]
    assert not failed["accepted"]
    assert "no equilibrium after 3" in failed["failure"]
    assert accepted["accepted"]
    assert accepted["failure"] is None
    relative = [i["relative_residual"] for i in accepted["solves"][-1]["iterations"]]
    log = (plain / "log.txt").read_text().splitlines()
    (line,) = [each for each in log if each.split()[:1] == [f"{CUT}"]]
    assert f"{relative[-1]:.2e}" in line
    table = (tmp_path / "run" / f"explain_{CUT}.csv").read_text()
    rows = list(csv.DictReader(table.splitlines()))
    whole = [
        term
        for attempt in told["attempts"]
        for solve in attempt["solves"]
        for iteration in solve["iterations"]
        for term in iteration["terms"]
    ]
    assert [row["term"] for row in rows] == [term["term"] for term in whole]
    norm = next(key for key in rows[0] if key.startswith("norm"))
    assert [float(row[norm]) for row in rows] == [term["norm"] for term in whole]


@pytest.mark.slow
def test_results_with_contact_are_the_same_bits(tmp_path: Path) -> None:
    entries = pressed("plane_strain", "limited", DRIVEN, steps=2).setup.model.to_dict()
    model = Model.from_dict(entries | {"output": {"report": False}})
    run(model, tmp_path / "plain", quiet=True)
    run(model, tmp_path / "told", quiet=True, explain=2)
    assert_same_results(tmp_path / "plain", tmp_path / "told")
    assert read(tmp_path / "told", 2)["attempts"][-1]["accepted"]


def test_a_step_that_ends_the_run_is_explained(tmp_path: Path) -> None:
    with pytest.raises(AnalysisFailed, match=f"step {CUT} "):
        model = Model.from_dict(cut_entries(adaptive=False))
        run(model, tmp_path, quiet=True, explain=CUT)
    told = read(tmp_path, CUT)
    assert [each["accepted"] for each in told["attempts"]] == [False]
    assert told["attempts"][0]["solves"][-1]["iterations"]
    assert (tmp_path / f"explain_{CUT}.png").exists()


@pytest.mark.slow
def test_a_step_of_a_stage_is_counted_from_its_start(tmp_path: Path) -> None:
    """Also in a run that goes on in the midst of this stage."""
    entries = staged_entries()
    entries["output"] = {"report": False}
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True, explain="dig:2", until=3.0)
    told = read(tmp_path / "whole", 4)
    assert (told["step"], told["stage"]) == (4, "dig")
    assert [path.name for path in (tmp_path / "whole").glob("explain_*.json")] == ["explain_4.json"]
    run(model, tmp_path / "parts", quiet=True, until=1.0 + 1e-3)
    for given in (3, "dig:1", "weight:1"):
        with pytest.raises(BadInput, match="comes before the state"):
            resume(tmp_path / "parts", quiet=True, explain=given)
    with pytest.raises(BadInput, match="is of a stage that is over"):
        resume(tmp_path / "parts", quiet=True, explain="weight:9")
    resume(tmp_path / "parts", quiet=True, explain="dig:2", until=3.0)
    assert read(tmp_path / "parts", 4) == told
    assert_same_results(tmp_path / "whole", tmp_path / "parts")
    start = tmp_path / "whole", "dig"
    with pytest.raises(BadInput, match=r"is of a stage that is over .* that after step 4"):
        run(model, tmp_path / "from", quiet=True, explain="dig:9", from_stage=start)
    assert not (tmp_path / "from").exists()
    longer = staged_entries()
    longer["stages"][1]["schedule"] |= {"steps": 4, "end": 3.0}
    AskedStep(9, "dig").require_after(stored_stage(model, *start), Model.from_dict(longer))


@pytest.mark.parametrize("given", ["", "five", "0", "-1", "2.5", ":3", "dig:", "1e3", True, "٣"])
def test_what_is_no_step_is_refused(given: Any) -> None:
    with pytest.raises(BadInput, match="is not the number of a step") as error:
        AskedStep.of(given, Model.from_dict(staged_entries()), SERIAL)
    assert "history.csv" in error.value.remedy
    assert "STAGE:STEP" in error.value.remedy


def test_names_of_stages_are_checked(model: Model, tmp_path: Path) -> None:
    staged = Model.from_dict(staged_entries())
    assert AskedStep.of("wall away:2", staged, SERIAL) == AskedStep(2, "wall away")
    with pytest.raises(BadInput, match="no stage of this name") as error:
        AskedStep.of("digg:1", staged, SERIAL)
    assert "`dig`" in error.value.remedy
    with pytest.raises(BadInput, match="the model has no stages"):
        run(model, tmp_path / "run", quiet=True, explain="dig:1")
    assert not (tmp_path / "run").exists()


def test_a_step_that_the_run_does_not_have_is_an_error_after_it(tmp_path: Path) -> None:
    entries = entries_of()
    entries["materials"]["soil"] = material_entries("hencky_elastic")
    entries["schedule"] = {"steps": 1}
    with pytest.raises(BadInput, match="ended with step 1 and had no such step") as error:
        run(Model.from_dict(entries), tmp_path, quiet=True, explain=2)
    assert "--out ANOTHER_DIR" in error.value.remedy
    assert (tmp_path / "checkpoint.npz").exists()
    assert not list(tmp_path.glob("explain_*"))
    with pytest.raises(BadInput, match="ended with step 1 and had no such step"):
        resume(tmp_path, quiet=True, explain=99)


def test_several_processes_are_refused() -> None:
    class Two:
        size = 2

    with pytest.raises(BadInput, match="by one process only") as error:
        AskedStep.of(1, Model.from_dict(entries_of()), Two())  # type: ignore[arg-type]
    assert "tilth resume" in error.value.remedy


@pytest.mark.slow
def test_the_how_to_shows_what_is_printed(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """First iterations and all forces of the last attempt; how the method goes on may differ."""
    script = module_of(DOCS / "generate_explained_step.py")
    with pytest.raises(AnalysisFailed, match=f"step {script.STEP} "):
        run(script.model(), tmp_path, explain=script.STEP)
    printed = capfd.readouterr().err.splitlines()
    page = (DOCS / "howto" / "explain_a_step.md").read_text().splitlines()
    first = next(i for i, line in enumerate(page) if "largest at [m]" in line)
    last = next(i for i, line in enumerate(page) if line.strip().startswith("out of balance"))
    shown = [line for line in page[first : last + 1] if line.strip() != "..."]
    assert len(shown) == 12
    for line in shown:
        assert line in printed
    told = read(tmp_path, script.STEP)
    assert len(told["attempts"]) == 4
    crept = told["attempts"][-1]["solves"][-1]
    assert crept["method"].startswith("soil creeps against a drag")
    norms = {each["term"]: each["norm"] for each in crept["iterations"][-1]["terms"]}
    assert norms["drag"] > 0.0


def test_a_disk_that_is_full_does_not_hide_why_the_run_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def full(*_: Any) -> None:
        raise AnalysisFailed("no room for it")

    monkeypatch.setattr("tilth.analysis.explain_files.write_explanation", full)
    entries = cut_entries(adaptive=False)
    with pytest.raises(AnalysisFailed, match=f"step {CUT} "):
        run(Model.from_dict(entries), tmp_path, explain=CUT)
    assert "could not be completed: no room for it" in capfd.readouterr().err


def test_a_picture_that_cannot_be_drawn_does_not_end_a_run(
    model: Model,
    plain: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    def unable(*_: Any) -> None:
        raise ValueError("no font")

    monkeypatch.setattr("tilth.analysis.explain_files.residual_figure", unable)
    run(model, tmp_path / "run", explain=CUT)
    assert_same_results(plain, tmp_path / "run")
    assert "could not be completed: no font" in capfd.readouterr().err
    assert (tmp_path / "run" / f"explain_{CUT}.json").exists()
