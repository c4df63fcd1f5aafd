# SPDX-License-Identifier: BSD-3-Clause
"""`tilth verify`: runs reference problems and reports computed and reference numbers."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from tilth.errors import EXIT_ANALYSIS_FAILED, EXIT_DONE, AnalysisFailed, BadInput
from tilth.model.problems import suggestion
from tilth_verification.comparison import Comparison, at_least


@dataclass(frozen=True)
class Row:
    """A comparison with the name of its problem and the time that it took [s]."""

    problem: str
    comparison: Comparison
    seconds: float

    def as_dict(self) -> dict[str, Any]:
        """Returns the entries for `tilth verify --json`; None for numbers that are not finite."""
        entries = {"problem": self.problem, **asdict(self.comparison)}
        entries |= {"passed": self.comparison.passed, "seconds": round(self.seconds, 3)}
        return {
            key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in entries.items()
        }


def run_verification(names: Iterable[str], *, long: bool, as_json: bool) -> int:
    """Runs the named problems, all if none is named, and prints their rows; returns an exit code.

    Args:
        names: of examples; an unknown one raises BadInput before anything runs.
        long: whether fine grids that take minutes are included.
        as_json: whether a list of objects is printed instead of a table.
    """
    rows = verified(_checked(list(names)), long)
    done = _print_json(rows) if as_json else _print_table(rows)
    return EXIT_DONE if all(row.comparison.passed for row in done) else EXIT_ANALYSIS_FAILED


def verified(names: Iterable[str], long: bool) -> Iterator[Row]:
    """Runs problems one after the other and yields each row as soon as it is computed.

    If the analysis of a problem fails, its last row gives the reason and has not passed.
    """
    from tilth_verification.problems import PROBLEMS

    for name in names:
        start = time.perf_counter()
        try:
            for comparison in PROBLEMS[name](long):
                now = time.perf_counter()
                yield Row(name, comparison, now - start)
                start = time.perf_counter()
        except AnalysisFailed as error:
            failed = at_least("finished: " + error.message, 0.0, 1.0, 0.0, "all analyses finish")
            yield Row(name, failed, time.perf_counter() - start)


def _checked(names: list[str]) -> list[str]:
    from tilth_verification.problems import PROBLEMS

    for name in names:
        if name not in PROBLEMS:
            likely = suggestion(name, list(PROBLEMS))
            available = f"reference problems: {', '.join(PROBLEMS)}"
            remedy = f"did you mean {likely}?" if likely else available
            raise BadInput(f"there is no reference problem {name!r}", remedy)
    return names or list(PROBLEMS)


def _print_json(rows: Iterator[Row]) -> list[Row]:
    done = list(rows)
    print(json.dumps([row.as_dict() for row in done], indent=1, allow_nan=False))
    return done


def _print_table(rows: Iterator[Row]) -> list[Row]:
    """Prints each row at once on a terminal, else the whole table at the end."""
    table = Table(show_edge=False, pad_edge=False)
    for heading in ("problem", "quantity"):
        table.add_column(heading, overflow="fold")
    for heading in ("computed", "reference", "error", "tolerance", "", "s"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("source", overflow="fold")
    console = Console() if Console().is_terminal else Console(width=160)
    done: list[Row] = []
    with Live(table, console=console, auto_refresh=False, vertical_overflow="visible") as live:
        for row in rows:
            table.add_row(*_cells(row, first=not done or done[-1].problem != row.problem))
            done.append(row)
            live.refresh()
    failed = sum(not row.comparison.passed for row in done)
    seconds = sum(row.seconds for row in done)
    console.print(f"\n{len(done) - failed} of {len(done)} passed, {seconds:.0f} s")
    return done


def _cells(row: Row, first: bool) -> list[str]:
    c = row.comparison
    unit = f" {c.unit}" if c.unit else ""
    return [
        row.problem if first else "",
        escape(c.quantity),
        f"{c.computed:.5g}{unit}",
        f"{c.reference:.5g}{unit}",
        f"{c.error:.2g}",
        f"{c.tolerance:.2g}",
        "[green]passed[/]" if c.passed else "[bold red]FAILED[/]",
        f"{row.seconds:.1f}",
        escape(c.source),
    ]
