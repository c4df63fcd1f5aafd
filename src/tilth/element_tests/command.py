# SPDX-License-Identifier: BSD-3-Clause
"""What `tilth element` prints, and its exit codes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from tilth.element_tests.check import TOLERANCE, check_tangents
from tilth.element_tests.result import ElementResult
from tilth.element_tests.run import element
from tilth.errors import EXIT_ANALYSIS_FAILED, EXIT_DONE, AnalysisFailed
from tilth.model import ElementCase

_WIDTH = 120


def make_tests(case: ElementCase, folder: Path, *, overwrite: bool, quiet: bool) -> None:
    """Makes the tests of a case, writes their outputs and prints their results.

    Raises:
        AnalysisFailed: a test ended early; the outputs of all tests up to there are written.
        BadInput: as `element`.
    """
    results = element(case, folder, overwrite=overwrite)
    if not quiet:
        _print_results(results)
    early = [f"{each.test}, {each.material}: {each.stopped}" for each in results if each.stopped]
    if early:
        raise AnalysisFailed(
            "\n  ".join([f"{len(early)} of {len(results)} tests ended early", *early]),
            "where a stress is given, choose one below the strength, or give the strain; the "
            f"tables in {folder} end there",
        )


def print_check(case: ElementCase) -> int:
    """Compares the tangents of a case with differences, prints the table; returns an exit code."""
    table = _table(("test", "material", "law"), ("states", "no derivative", "error", "step", ""))
    passed = True
    for each in check_tangents(case):
        passed = passed and each.passed
        where = f"{each.step}, at random" if each.at_random else f"{each.step}"
        mark = "[green]passed[/]" if each.passed else "[bold red]FAILED[/]"
        if each.stopped:
            mark += escape(f" ({each.stopped})")
        table.add_row(
            escape(each.test), escape(each.material), each.law, str(each.states),
            str(each.skipped), f"{each.error:.1e}", where, mark,
        )  # fmt: skip
    console = _console()
    console.print(table)
    console.print(
        "\nerror: largest difference of the consistent tangent from central differences, over its "
        f"largest entry or that at the start of the step; at most {TOLERANCE:g}"
    )
    return EXIT_DONE if passed else EXIT_ANALYSIS_FAILED


def _print_results(results: Sequence[ElementResult]) -> None:
    unit = results[0].units["p"]
    numbers = (f"p [{unit}]", f"q [{unit}]", f"largest q [{unit}]", "axial strain", "volumetric")
    table = _table(("test", "material"), (*map(escape, numbers), "steps"))
    for each in results:
        q = each["q"]
        extreme = q[np.abs(q).argmax()]
        table.add_row(
            escape(each.test), escape(each.material), f"{each['p'][-1]:.5g}", f"{q[-1]:.5g}",
            f"{extreme:.5g}", f"{each['axial_strain'][-1]:.4g}",
            f"{each['volumetric_strain'][-1]:.4g}", str(len(q) - 1),
        )  # fmt: skip
    console = _console()
    console.print(table)
    console.print("at the end of each test; compression positive")


def _table(texts: Sequence[str], numbers: Sequence[str]) -> Table:
    table = Table(show_edge=False, pad_edge=False)
    for heading in texts:
        table.add_column(heading, overflow="fold")
    for heading in numbers:
        table.add_column(heading, justify="right")
    return table


def _console() -> Console:
    return Console() if Console().is_terminal else Console(width=_WIDTH)
