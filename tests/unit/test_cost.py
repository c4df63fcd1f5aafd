# SPDX-License-Identifier: BSD-3-Clause
"""Tests that take longer than planned fail the run that watches the budget, with a sentence."""

import os
import subprocess
import sys
from pathlib import Path

import cost
import pytest

ROOT = Path(__file__).parents[2]
PARTS = [
    cost.Part("compiler", 30.0, pace=True),
    cost.Part("laws", 60.0, ("tests/unit/test_law*.py",)),
    cost.Part("others", 3.0, ("tests/unit/*",)),
]
SLOW = """
import time

def test_slow():
    end = time.process_time() + {seconds}
    while time.process_time() < end:
        pass
"""


def test_a_test_belongs_to_the_first_part_that_names_its_file() -> None:
    costs = {
        "tests/unit/test_laws.py::test_a": 20.0,
        "tests/unit/test_laws.py::test_b[x::y]": 30.0,
        "tests/unit/test_grid.py::test_c": 1.0,
        "tests/cli/test_run.py::test_d": 2.0,
    }
    expected = {"laws": 50.0, "others": 1.0, "tests/cli/test_run.py::test_d": 2.0}
    assert cost.sums(costs, PARTS) == expected


def test_a_half_more_is_tolerated() -> None:
    assert cost.verdicts({"laws": 89.9, "others": 3.9}, PARTS) == []
    (sentence,) = cost.verdicts({"laws": 90.1, "others": 3.9}, PARTS)
    assert sentence.startswith("laws: 90 s of processor time, 60 s are planned")
    (sentence,) = cost.verdicts({"tests/cli/test_run.py::test_d": 0.1}, PARTS)
    assert "no part of the budget has it" in sentence


def test_a_slow_machine_fails_only_what_takes_longer_than_the_programs_of_others() -> None:
    assert cost.verdicts({"compiler": 60.0, "laws": 179.0}, PARTS) == []
    (sentence,) = cost.verdicts({"compiler": 60.0, "laws": 181.0}, PARTS)
    assert sentence.startswith("laws: 181 s of processor time, 120 s are planned")
    (sentence,) = cost.verdicts({"compiler": 15.0, "laws": 91.0}, PARTS)
    assert sentence.startswith("laws: 91 s of processor time, 60 s are planned")


def test_times_of_bash_are_of_all_programs_until_then(tmp_path: Path) -> None:
    file = tmp_path / "spent"
    file.write_text("installation\t1m2.500s 0m3.500s\nwheel\t2m0.000s 0m7.000s\n", encoding="utf-8")
    assert cost.spent_before(file) == {"installation": 66.0, "wheel": 61.0}


def test_every_test_has_a_budget_and_every_pattern_a_test() -> None:
    files = {file.relative_to(ROOT).as_posix(): 1.0 for file in ROOT.glob("tests/**/test_*.py")}
    budget = [part for part in cost.parts() if part.files]
    assert set(cost.sums(files, budget)) == {part.name for part in budget}
    patterns = [pattern for part in budget for pattern in part.files]
    alone = [cost.Part(pattern, 0.0, (pattern,)) for pattern in patterns]
    assert set(cost.sums(files, alone)) == set(patterns)


@pytest.mark.parametrize(("seconds", "code"), [(0.1, 0), (1.7, 1)])
def test_a_slow_test_fails_the_run_that_watches_the_budget(
    seconds: float, code: int, tmp_path: Path
) -> None:
    (tmp_path / "test_new.py").write_text(SLOW.format(seconds=seconds), encoding="utf-8")
    budget = tmp_path / "budget.toml"
    budget.write_text(
        '[[part]]\nname = "new tests"\nseconds = 1\nfiles = ["test_new.py"]\n'
        f'[[part]]\nname = "{cost.WORKERS}"\nseconds = 100\n'
        '[[part]]\nname = "wheel"\nseconds = 10\n',
        encoding="utf-8",
    )
    (tmp_path / "spent").write_text("wheel\t0m9.500s 0m0.000s\n", encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-p", "cost", "-p", "no:cacheprovider", "-q"]
    watch = ["--budget", str(budget), "--spent", "spent", "--rootdir", str(tmp_path)]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "tests")}
    done = subprocess.run(
        [*command, *watch, str(tmp_path)], cwd=tmp_path, env=environment, check=False,
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == code, done.stdout + done.stderr
    assert "wheel                                         10" in done.stdout
    sentence = "above its budget: new tests: 2 s of processor time, 1 s are planned on this machine"
    assert (sentence in done.stdout) == bool(code)
    assert done.stdout.splitlines()[-1].startswith("1 passed")
