# SPDX-License-Identifier: BSD-3-Clause
"""Every example found by glob: its case files run, it is explained and it is verified."""

from pathlib import Path
from typing import Any

import pytest
from example_cases import ANALYSES, ELEMENT_TESTS, EXAMPLES
from readings import long

from tilth import element, load_case, load_element_case, run
from tilth.element_tests.check import check_tangents
from tilth_verification.problems import PROBLEMS

FOLDERS = sorted(folder for folder in EXAMPLES.iterdir() if folder.is_dir())
STEPS = 3
LONG = {
    "cone_penetration/three_dimensional", "hertz/cattaneo", "rigid_sphere/three_dimensional",
    "square_footing/graded", "square_footing/standard",
}  # fmt: skip
"""Case files whose first steps take long; others of their examples do the same."""


def name_of(case: Path) -> str:
    return f"{case.parent.name}/{case.stem}"


def first_steps() -> list[Any]:
    return [long(case) if name_of(case) in LONG else case for case in ANALYSES]


@pytest.mark.slow
@pytest.mark.parametrize("case", first_steps(), ids=name_of)
def test_the_first_steps_of_a_case_file_run(case: Path, tmp_path: Path) -> None:
    """As far as `until` takes it, as with `tilth run --until`; without the report."""
    model = load_case(case)
    output = model.output.model_copy(update={"report": False})
    schedule = model.of_stages[0].schedule
    steps = min(STEPS, schedule.number_of_steps)
    until = schedule.regular_time(steps)
    whole = model.model_copy(update={"output": output})
    history = run(whole, tmp_path / "out", threads=1, until=until, quiet=True).history
    assert list(history["step"]) == list(range(steps + 1))
    assert history["time"][-1] == until
    assert (tmp_path / "out" / "results.vtkhdf").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("case", ELEMENT_TESTS, ids=lambda case: case.stem)
def test_element_tests_are_made(case: Path, tmp_path: Path) -> None:
    """To their ends, with all outputs; the tangents along them are right."""
    declared = load_element_case(case)
    results = element(declared, tmp_path / "out")
    assert [each.stopped for each in results] == [""] * len(results)
    tables = sorted(file.name for file in (tmp_path / "out").glob("*.csv"))
    assert len(tables) == len(results)
    assert len(list((tmp_path / "out").glob("*.png"))) == len(declared.plots)
    assert all(each.passed for each in check_tangents(declared))


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
