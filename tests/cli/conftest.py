# SPDX-License-Identifier: BSD-3-Clause
"""A valid case, variations of it, and the command line as a function."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tilth.cli import run_command

CASE = """\
format = 1
title = "Column under its own weight"

[analysis]
kind = "plane_strain"

[grid]
cell_size = 0.5
limits = { lower = [-1, 0], upper = [2, 5] }

[materials.clay]
model = "von_mises"
young_modulus = 1e6
poisson_ratio = 0.3
density = 1800
yield_stress = 2e4
hardening_modulus = 0

[[bodies]]
name = "column"
material = "clay"
shape = { type = "box", lower = [0, 0], upper = [1, 4] }
basis = "gimp"
points_per_cell = 2

[[boundaries]]
name = "base"
type = "plane"
axis = "y"
at = 0
condition = "fixed"

[[loads]]
type = "body_force"
acceleration = [0, -9.81]
factor = [[0, 0], [1, 1]]

[schedule]
steps = 2

[[track]]
name = "top"
quantity = "displacement"
at = [0.5, 4]
component = "y"
"""


@dataclass(frozen=True)
class Outcome:
    """What a command left behind: exit code and printed text."""

    code: int
    out: str
    err: str


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a small run, with its case file beside it."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "case.toml").write_text(CASE, encoding="utf-8")
    assert run_command(["run", str(folder / "case.toml"), "--quiet"]) == 0
    return folder / "case"


@pytest.fixture
def tilth(capfd: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """Runs `tilth ARGUMENTS`."""

    def run(*arguments: str | Path) -> Outcome:
        code = run_command([str(argument) for argument in arguments])
        return Outcome(code, *capfd.readouterr())

    return run


@pytest.fixture
def case(tmp_path: Path) -> Callable[..., Path]:
    """Writes the valid case, with each (old, new) piece of its text replaced, to column.toml."""

    def write(*replaced: tuple[str, str]) -> Path:
        text = CASE
        for old, new in replaced:
            assert text.count(old) == 1, f"{old!r} is not once in the case"
            text = text.replace(old, new)
        file = tmp_path / "column.toml"
        file.write_text(text, encoding="utf-8")
        return file

    return write
