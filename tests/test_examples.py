# SPDX-License-Identifier: BSD-3-Clause
"""Every example found by glob: its case files run, it is explained and it is verified."""

import re
from pathlib import Path

import pytest

from tilth.case import load_case
from tilth.cli import run_command
from tilth.output import read_history
from tilth.verification.problems import PROBLEMS

EXAMPLES = Path(__file__).parents[1] / "examples"
CASES = sorted(EXAMPLES.glob("*/*.toml"))
FOLDERS = sorted(folder for folder in EXAMPLES.iterdir() if folder.is_dir())
STEPS = 3

MOVES = (
    r'^(type = "(?:body_force|point_force|surface|affine)"|condition = "prescribed"'
    r'|condition = "\w+"(?=\n(?:displacement|rotation|radius_change|motion) = ))$'
)
"""Lines of what follows a load factor; an implicit boundary's motion stands below its condition."""


def shortened(text: str) -> tuple[str, int]:
    """Returns a case file cut off after a few steps of unchanged size, and their number."""
    found = re.search(r"^steps = (\d+)$", text, re.MULTILINE)
    assert found, "an example gives its number of steps on a line of its own"
    total = int(found[1])
    kept = min(STEPS, total)
    factor = f"factor = [[0.0, 0.0], [{kept}.0, {kept / total}]]"
    text = text.replace(found[0], f"end = {kept}.0\nsteps = {kept}")
    text = re.sub(r"^factor = .*\n", "", text, flags=re.MULTILINE)
    text, changed = re.subn(MOVES, rf"\1\n{factor}", text, flags=re.MULTILINE)
    assert changed, "an example is driven by loads or displacements"
    text = re.sub(r"^outputs = \d+$", "outputs = 1", text, flags=re.MULTILINE)
    return text.replace("[output]\n", "[output]\nreport = false\n"), kept


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.parent.name}/{case.stem}")
def test_case_file_is_valid_and_its_first_steps_run(case, tmp_path):
    assert load_case(case).title
    text, steps = shortened(case.read_text(encoding="utf-8"))
    for beside in [*case.parent.glob("*.py"), *case.parent.glob("*.stl")]:
        (tmp_path / beside.name).write_bytes(beside.read_bytes())
    short = tmp_path / "short.toml"
    short.write_text(text, encoding="utf-8")
    assert run_command(["run", str(short), "--quiet", "--threads", "1"]) == 0
    history = read_history(tmp_path / "short" / "history.csv")
    assert list(history["step"]) == list(range(steps + 1))
    assert (tmp_path / "short" / "results.vtkhdf").is_file()


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_example_is_complete(folder):
    assert (folder / "case.toml").is_file()
    readme = (folder / "README.md").read_text(encoding="utf-8")
    for case in folder.glob("*.toml"):
        assert case.name in readme
    assert (folder / "picture.png").stat().st_size > 0
    assert "picture.png" in readme
    assert folder.name in PROBLEMS


def test_every_reference_problem_is_an_example():
    assert sorted(PROBLEMS) == [folder.name for folder in FOLDERS]
