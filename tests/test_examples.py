# SPDX-License-Identifier: BSD-3-Clause
"""Every example found by glob: its case files run, it is explained and it is verified."""

from pathlib import Path

import pytest

from tilth import load_case, run
from tilth.verification.problems import PROBLEMS

EXAMPLES = Path(__file__).parents[1] / "examples"
CASES = sorted(EXAMPLES.glob("*/*.toml"))
FOLDERS = sorted(folder for folder in EXAMPLES.iterdir() if folder.is_dir())
STEPS = 3


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.parent.name}/{case.stem}")
def test_the_first_steps_of_a_case_file_run(case: Path, tmp_path: Path) -> None:
    """As far as `until` takes it, as with `tilth run --until`; without the report."""
    model = load_case(case)
    output = model.output.model_copy(update={"report": False})
    until = model.schedule.regular_time(STEPS)
    whole = model.model_copy(update={"output": output})
    history = run(whole, tmp_path / "out", threads=1, until=until, quiet=True).history
    assert list(history["step"]) == list(range(min(STEPS, model.schedule.number_of_steps) + 1))
    assert history["time"][-1] == until
    assert (tmp_path / "out" / "results.vtkhdf").is_file()


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_example_is_complete(folder: Path) -> None:
    assert (folder / "case.toml").is_file()
    readme = (folder / "README.md").read_text(encoding="utf-8")
    for case in folder.glob("*.toml"):
        assert case.name in readme
    assert (folder / "picture.png").stat().st_size > 0
    assert "picture.png" in readme
    assert folder.name in PROBLEMS


def test_every_reference_problem_is_an_example() -> None:
    assert sorted(PROBLEMS) == [folder.name for folder in FOLDERS]
