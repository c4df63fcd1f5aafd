# SPDX-License-Identifier: BSD-3-Clause
"""The list of mutants fits the source: CONTRIBUTING.md, "Do the tests notice mistakes"."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from mutant_list import Mutant, mistakes, packages, read_list
from mutants import LIVES_NEAR, Outcome, is_known, mark_of, read_outcomes, table, write_outcomes

MUTANTS = read_list()
FIRST = MUTANTS[0]


def test_each_can_be_applied_and_names_its_tests() -> None:
    assert mistakes(MUTANTS) == []


def test_there_are_enough_in_every_folder_of_source() -> None:
    assert len(MUTANTS) >= 60
    changed = {Path(each.file).parent.as_posix() for each in MUTANTS}
    assert packages() - changed == set()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (replace(FIRST, line="no such line"), "0 places in"),
        (replace(FIRST, line=" "), "places in"),
        (replace(FIRST, change=FIRST.line), "changes nothing"),
        (replace(FIRST, change="one\ntwo"), "more than one line"),
        (replace(FIRST, file="src/tilth/nothing.py"), "there is no file"),
        (replace(FIRST, tests=("tests/unit/test_nothing.py",)), "there is no file"),
        (replace(FIRST, tests=("tests/unit/test_mutants.py::test_nothing",)), "has no test"),
        (replace(FIRST, tests=()), "names no test"),
        (replace(FIRST, guards=""), "does not say"),
    ],
)
def test_a_list_that_does_not_fit_is_refused(wrong: Mutant, message: str) -> None:
    assert message in "\n".join(mistakes([wrong]))


def test_outcomes_are_read_as_written(tmp_path: Path) -> None:
    outcomes = {
        "one": Outcome("one", "killed", "tests/unit/test_a.py::test_b[c - d]", 1.5, "text"),
        "two": Outcome("two", "lives", "", 2.5, "text"),
    }
    write_outcomes(tmp_path / "found.json", outcomes)
    assert read_outcomes(tmp_path / "found.json") == outcomes
    assert read_outcomes(tmp_path / "none.json") == {}


def test_the_table_counts_the_living() -> None:
    outcomes = [
        Outcome("one", "killed", "tests/unit/test_a.py::test_b", 1.0, ""),
        Outcome("two", "hangs", "", 300.0, ""),
        Outcome("three", "lives in the nearest tests", "", 2.0, ""),
        Outcome("four", "not run: needs processes", "", 0.0, ""),
    ]
    lines = table(outcomes).splitlines()
    assert "| one | killed | tests/unit/test_a.py::test_b | 1 |" in lines
    assert "2 of 3 mutants killed (67 %), 1 not run; 303 s" in lines[-1]


def test_outcomes_hold_as_long_as_the_mutant_is_the_same() -> None:
    killed = Outcome(FIRST.name, "killed", "tests/unit/test_a.py::test_b", 1.0, mark_of(FIRST))
    lives = replace(killed, result=LIVES_NEAR)
    other_tests, other_change = replace(FIRST, tests=()), replace(FIRST, change="other")
    assert is_known(killed, FIRST, nearest=False)
    assert is_known(killed, other_tests, nearest=True)
    assert is_known(lives, FIRST, nearest=True)
    assert not is_known(lives, FIRST, nearest=False)
    assert not is_known(lives, other_tests, nearest=True)
    assert not is_known(killed, other_change, nearest=True)
    assert not is_known(replace(killed, result="not run: needs processes"), FIRST, nearest=True)
    assert not is_known(None, FIRST, nearest=True)
