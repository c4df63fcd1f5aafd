# SPDX-License-Identifier: BSD-3-Clause
"""The first steps of every example give the same bits for any number of threads."""

from __future__ import annotations

from pathlib import Path

import pytest
from example_cases import ANALYSES
from resumed_runs import datasets

from tilth import load_case, run

CASES = {f"{case.parent.name}/{case.stem}": case for case in ANALYSES}
FEW = ("cone_penetration/case", "rigid_sphere/case", "submerged_block/case")
"""Those of the short form: F-bar, implicit boundaries, axisymmetry and plane strain."""
STEPS = 2

pytestmark = pytest.mark.usefixtures("every_loop_in_parallel")


def first_steps(case: Path, folder: Path, threads: int) -> dict[str, bytes]:
    """Every byte of the history and every data set of the results."""
    model = load_case(case)
    output = model.output.model_copy(update={"report": False})
    until = model.schedule.regular_time(STEPS)
    run(
        model.model_copy(update={"output": output}),
        folder,
        threads=threads,
        until=until,
        quiet=True,
    )
    return {
        "history": (folder / "history.csv").read_bytes(),
        **datasets(folder / "results.vtkhdf"),
    }


def compare(case: Path, place: Path) -> None:
    one = first_steps(case, place / "1", 1)
    for threads in (2, 3, 5):
        other = first_steps(case, place / str(threads), threads)
        assert one.keys() == other.keys()
        assert [name for name in one if one[name] != other[name]] == [], f"{threads} threads"


@pytest.mark.slow
@pytest.mark.parametrize("name", FEW)
def test_same_bits_for_any_number_of_threads(name: str, tmp_path: Path) -> None:
    compare(CASES[name], tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("name", [name for name in CASES if name not in FEW])
def test_same_bits_for_any_number_of_threads_in_every_example(name: str, tmp_path: Path) -> None:
    compare(CASES[name], tmp_path)
