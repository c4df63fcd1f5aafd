# SPDX-License-Identifier: BSD-3-Clause
"""The short form of the metamorphic tests, and the parts that they are made of."""

from __future__ import annotations

import copy
from collections import Counter
from functools import cache

import numpy as np
import pytest

from metamorphic import commands as commands_module
from metamorphic.balances import faults as faults_of_balance
from metamorphic.bounds import OF_COMMON_NODES, OF_PATCHES, of_patches, of_stress
from metamorphic.build import entries_of
from metamorphic.choices import PLAIN, Choice
from metamorphic.command import found_faults, main, refused
from metamorphic.compare import difference
from metamorphic.covering import Covering
from metamorphic.frames import Frame, turns
from metamorphic.held import while_held
from metamorphic.known import is_known
from metamorphic.smaller import smaller
from metamorphic.subject import Subject
from metamorphic.tilting import is_without_arm
from metamorphic.transformed import transformed

MODELS, PARTS, SEED = 300, 2, 1


@cache
def _models() -> tuple[Covering, list[tuple[str, Choice]]]:
    covering = Covering(SEED, refused)
    return covering, list(covering.choices(MODELS))


@pytest.mark.slow
@pytest.mark.parametrize("part", range(PARTS))
def test_no_relation_fails(part: int) -> None:
    for number, (name, choice) in enumerate(_models()[1]):
        if number % PARTS == part:
            found = found_faults(Subject(entries_of(choice, name), choice, name))
            assert not [text for text in found if not is_known(choice, text)], (name, choice)


@pytest.mark.slow
def test_every_pair_of_values_occurs_or_is_refused() -> None:
    covering, _ = _models()
    assert not covering.missing
    assert all(covering.left_out.values())


def test_choices_go_on_once_all_pairs_have_occurred() -> None:
    """A choice that is refused then is drawn anew."""
    tries: Counter[str] = Counter()

    def refused_at_first(choice: Choice, name: str) -> str:
        tries[name] += 1
        return "refused" if tries[name] == 1 else ""

    covering = Covering(SEED, refused_at_first)
    covering.missing.clear()
    assert [name for name, _ in covering.choices(3)] == ["1-0", "1-1", "1-2"]


def _plain(**values: str) -> Subject:
    choice = {**PLAIN, **values}
    return Subject(entries_of(choice, "plain"), choice, "plain")


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_a_frame_and_its_inverse(kind: str) -> None:
    subject = _plain(kind=kind, driver="footing", load="pressure", places="irregular")
    dim = subject.dim
    for turn in turns(dim):
        shift = np.arange(1.0, dim + 1.0)
        there = Frame(turn, shift, 4.0, 16.0, 0.25)
        back = Frame(turn.T, -turn.T @ shift / 4.0, 0.25, 0.0625, 4.0)
        again = transformed(transformed(subject.entries, there, kind), back, kind)
        other = Subject(again, subject.choice, "plain")
        assert difference(subject.run, other.run)[0] < 1e-9


def test_wrong_forces_are_noticed() -> None:
    subject = _plain(load="pressure")
    assert not list(faults_of_balance(subject))
    subject.run.moments[0].forces["base"] *= 1.0 + 1e-8
    subject.run.moments[-1].moments["base"] *= 1.0 + 1e-8
    found = [text.split()[0] for text in faults_of_balance(subject)]
    assert found == ["force", "moment"]


def test_lost_energy_is_noticed() -> None:
    subject = _plain()
    subject.run.moments[-1].energies["friction_dissipation"] = -1.0
    subject.run.moments[-1].energies["numerical_dissipation"] += 10.0
    found = [text.split()[0] for text in faults_of_balance(subject)]
    assert found == ["friction_dissipation", "energy"]


def test_other_results_are_noticed() -> None:
    one, other = _plain().run, _plain().run
    assert difference(one, other)[0] == 0.0
    changed = copy.deepcopy(other)
    changed.moments[-1].stress[3, 1] *= 1.0 + 1e-6
    assert 0.0 < difference(one, changed)[0] < 1e-5
    changed.moments.pop()
    assert difference(one, changed)[0] == np.inf


def test_soil_without_weight_is_compared_while_it_is_held() -> None:
    subject = _plain(base="contact", contact="smooth", stages="loads")
    one, other = while_held(subject, subject.run, subject.run)
    assert len(one.moments) == len(other.moments) < len(subject.run.moments)
    assert all(moment.forces["base"].any() for moment in one.moments)
    held = _plain(stages="loads")
    assert while_held(held, held.run, held.run)[0] is held.run


@pytest.mark.parametrize(
    ("basis", "expected"), [("linear", 0.5 * 0.75 * 0.75), ("gimp", 0.03), ("cpdi2", 0.03)]
)
def test_how_far_soil_hangs_over_a_line(basis: str, expected: float) -> None:
    """Soil that ends 0.03 over a line; points of a linear basis do not come near one."""
    choice = {**PLAIN, "basis": basis}
    entries = entries_of(choice, "plain")
    if basis != "linear":
        entries["bodies"][0]["shape"]["upper"][1] = 1.03
    del entries["loads"]
    run = Subject(entries, choice, "plain").run
    assert run.moments[0].overhang == pytest.approx(expected)


def test_surfaces_less_than_two_cells_apart_have_nodes_in_common() -> None:
    subject = _plain(base="implicit_fixed", driver="footing")
    assert of_patches(subject) == OF_PATCHES[2]
    subject.entries["boundaries"][-1]["geometry"]["centre"][1] = 0.9
    assert of_patches(subject) == OF_COMMON_NODES


def test_stresses_may_differ_by_their_change_within_a_cell() -> None:
    subject = _plain(base="implicit_fixed")
    assert of_stress(subject, 1e-6) == 1e-6
    assert 0.25 < of_stress(subject, 0.25) < 1.0


def test_wrong_exit_codes_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    codes = {"check": 4, "run": 0}
    monkeypatch.setattr(commands_module, "run_command", lambda words: codes[words[0]])
    found = list(commands_module.commands(_plain()))
    assert len(found) == 1
    assert found[0].startswith("check has exit code 4")


def test_the_lines_of_a_fault_are_left() -> None:
    entries = _plain(load="pressure").entries
    text = smaller(entries, lambda other: "pressure" in str(other))
    assert [line.split(" = ")[0] for line in text.splitlines() if " = " in line] == ["pressure"]


def test_the_command_runs_one_model_again(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--seed", "5", "--models", "3", "--replay", "5-1"]) == 0
    assert "1 models" in capsys.readouterr().out


def test_patches_of_which_one_is_around_the_other_have_no_arm() -> None:
    x, y = np.meshgrid([0.125, 0.5, 0.875], [0.125, 0.375])
    position = np.stack([x.ravel(), y.ravel(), np.zeros(6)], axis=1)
    weight = np.ones(6)
    assert is_without_arm(np.array([0, 1, 0, 0, 0, 0]), position, weight)
    assert not is_without_arm(np.array([0, 1, 2, 0, 1, 3]), position, weight)
