# SPDX-License-Identifier: BSD-3-Clause
"""Systems of several fields on several processes: PETSc's solution is that of the full matrix."""

from __future__ import annotations

from typing import Any

import pytest
from coupled_runs import BLOCKS
from mpi_runs import run_python

every_number = pytest.mark.parametrize("processes", [1, 2, 3])


def run(function: str, processes: int) -> Any:
    """What a function of `coupled_runs` returns on some processes, for each of them."""
    return run_python(
        f"import coupled_runs\nresult = comm.gathered(coupled_runs.{function}(comm))\n",
        processes,
    )


@every_number
def test_solution_is_that_of_the_full_matrix(processes: int) -> None:
    for of_process in run("solved", processes):
        summaries, errors = zip(*of_process, strict=True)
        assert max(errors) < 1e-7
        half = len(BLOCKS)
        assert summaries[:half] == ("2 by mumps",) * half
        assert all(each.startswith("2 by multigrid") for each in summaries[half:])


@every_number
def test_failures(processes: int) -> None:
    for of_process in run("failures", processes):
        assert len(of_process) == 4
        for not_numbers, singular in (of_process[:2], of_process[2:]):
            assert "not numbers" in not_numbers
            assert "singular" in singular


@every_number
def test_mumps_takes_over_for_the_rest_of_the_step(processes: int) -> None:
    for notes, error, summary, before, again in run("taken_over", processes):
        assert notes == 1
        assert error < 1e-9
        assert summary == "2 by mumps"
        assert not before
        assert again
