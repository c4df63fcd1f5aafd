# SPDX-License-Identifier: BSD-3-Clause
"""An explained step as tables: for the terminal, and with a row per term for a spreadsheet."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from itertools import groupby

from tilth.analysis.explained import ExplainedStep, Iteration, Solve
from tilth.analysis.observer import Search
from tilth.model.fields import AXES
from tilth.report.fields import with_unit

Rows = Sequence[Sequence[str]]

NONE = "-"
"""Where there is no number, as in the first iteration for changes since the one before."""


ROUND_OFF = 1e-10
"""Sum of forces over their norm that is shown as 0."""


def screen_text(step: ExplainedStep) -> str:
    """Returns the tables for the terminal.

    Of every attempt the iterations of the telling one of Newton's method, and the forces after its
    telling iteration; of the others a line.
    """
    lines = [f"explanation of step {step.name}"]
    for number, attempt in enumerate(step.attempts, 1):
        end = f"failed: {attempt.failure}" if attempt.end == "failed" else attempt.end
        times = f"from time {attempt.before:.6g} to {attempt.after:.6g}"
        lines += ["", f"attempt {number}, {times}, {end}"]
        telling = attempt.telling
        for are_pseudo_steps, group in groupby(
            attempt.solves, key=lambda s: s.search is Search.CREEPING and s is not telling
        ):
            solves = list(group)
            if are_pseudo_steps:
                iterations = sum(each.iterations[-1].number for each in solves if each.iterations)
                each_of = f"{len(solves)} pseudo-steps, {iterations} iterations"
                lines.append(f"  {solves[0].method}: {each_of}")
                continue
            for solve in solves:
                lines.append(f"  {_summary(solve)}")
                if solve is telling:
                    lines += _of_solve(solve, step)
    return "\n".join(lines)


def _summary(solve: Solve) -> str:
    end = "converged" if solve.failure is None else solve.failure
    if not solve.iterations:
        return f"{solve.method}: {end}"
    first, last = solve.iterations[0], solve.iterations[-1]
    return (
        f"{solve.method}: {last.number} iterations, residual {first.relative:.1e} to "
        f"{last.relative:.1e}, {end}"
    )


def _of_solve(solve: Solve, step: ExplainedStep) -> list[str]:
    lines = _indented(_iterations(solve.iterations, step.length_unit))
    if any(each.moving for each in solve.iterations):
        lines.append("    * before the prescribed motion: forces at the start of the step")
    if any(each.contact for each in solve.iterations):
        lines += ["    points of contact", *_indented(_contact(solve.iterations))]
    assert solve.telling is not None
    told = solve.telling[0]
    head = with_unit(f"forces on the soil after iteration {told.number}", step.force_unit)
    if not told.is_balanced:
        node = ", ".join(f"{x:.4g}" for x in told.largest.node)
        head += f"; node: that at ({node}), with the largest force out of balance"
    lines += [f"    {head}", *_indented(_terms(told))]
    for label, norm in told.bodies.items():
        size = f"{norm:.3e} {step.force_unit}".rstrip()
        lines.append(f"    {label}: the body itself is out of balance by {size}")
    return lines


def _iterations(iterations: Sequence[Iteration], unit: str) -> Rows:
    where = with_unit("largest at", unit)
    rows = [["", "residual", "yield", "begin", "cease", where, "point", "body", "most from",
             "changed most"]]  # fmt: skip
    for each in iterations:
        largest = each.largest
        place = [
            f"({', '.join(f'{x:.4g}' for x in largest.node)})",
            f"{largest.point}",
            largest.body,
            largest.term,
        ]
        rows.append(
            [
                f"{each.number}{'*' if each.moving else ''}",
                f"{each.relative:.2e}",
                f"{each.yielding}",
                _change(each.began),
                _change(each.ceased),
                *([NONE] * len(place) if each.is_balanced else place),
                NONE if each.is_balanced else largest.changed or NONE,
            ]
        )
    return rows


def _contact(iterations: Sequence[Iteration]) -> Rows:
    rows = [["", "surface", "open", "stick", "slide", "opened", "closed", "began to slide",
             "began to stick"]]  # fmt: skip
    for each in iterations:
        for of in each.contact:
            changes = (of.opened, of.closed, of.slid, of.stuck)
            counts = f"{of.open}", f"{of.sticking}", f"{of.sliding}"
            rows.append([f"{each.number}", of.surface, *counts, *map(_change, changes)])
    return rows


def _terms(iteration: Iteration) -> Rows:
    axes = AXES[: len(iteration.largest.node)]
    rows = [["term", "norm", *(f"sum {a}" for a in axes)]]
    if not iteration.is_balanced:
        rows[0] += [*(f"{a} at node" for a in axes), "share"]
    size = max(each.norm for each in iteration.terms)
    for each in iteration.terms:
        if each.norm != 0.0:
            sums = [_force(x, each.norm) for x in each.resultant]
            rows.append([each.label, f"{each.norm:.4g}", *sums])
            if not iteration.is_balanced:
                rows[-1] += [*(_force(x, each.norm) for x in each.at_largest), f"{each.share:.3g}"]
    total = sum((each.resultant for each in iteration.terms), 0.0 * iteration.largest.force)
    rows.append(["out of balance", f"{iteration.norm:.4g}", *(_force(x, size) for x in total)])
    if not iteration.is_balanced:
        rows[-1] += [*(f"{x:.4g}" for x in iteration.largest.force), "1"]
    return rows


def _force(value: float, size: float) -> str:
    return f"{0.0 if abs(value) <= ROUND_OFF * size else value:.4g}"


def _change(count: int | None) -> str:
    return NONE if count is None else f"{count}"


def _indented(rows: Rows) -> list[str]:
    """Returns lines of columns: words to the left, numbers to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    words = [
        any(not _is_number(row[k]) for row in rows[1:]) or not rows[1:] for k in range(len(widths))
    ]
    return [
        "      "
        + "  ".join(
            text.ljust(width) if word else text.rjust(width)
            for text, width, word in zip(row, widths, words, strict=True)
        ).rstrip()
        for row in rows
    ]


def _is_number(text: str) -> bool:
    try:
        float(text.rstrip("*"))
    except ValueError:
        return text == NONE
    return True


def spreadsheet(step: ExplainedStep) -> str:
    """Returns a table as CSV with a row per term and iteration of all attempts.

    Of an iteration that `is_balanced` shares, places and forces there are left empty.
    """
    attempts = step.attempts
    every = [i for attempt in attempts for solve in attempt.solves for i in solve.iterations]
    axes = AXES[: len(every[0].largest.node)] if every else AXES[:0]
    force, length = step.force_unit, step.length_unit
    head = ["attempt", "solve", "iteration", "relative_residual", "yielding"]
    head += [with_unit(f"largest_at_{a}", length) for a in axes]
    head += ["point", "body", "term", with_unit("norm", force)]
    head += [with_unit(f"sum_{a}", force) for a in axes] + ["share"]
    head += [with_unit(f"force_at_largest_{a}", force) for a in axes]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    for number, attempt in enumerate(attempts, 1):
        for solve_number, solve in enumerate(attempt.solves, 1):
            for each in solve.iterations:
                largest = each.largest
                first = [number, solve_number, each.number, each.relative, each.yielding]
                place = [*largest.node.tolist(), largest.point, largest.body]
                if each.is_balanced:
                    place = [""] * len(place)
                for term in each.terms:
                    of_largest = [term.share, *term.at_largest.tolist()]
                    if each.is_balanced:
                        of_largest = [""] * len(of_largest)
                    forces = [*term.resultant.tolist(), *of_largest]
                    writer.writerow([*first, *place, term.label, term.norm, *forces])
    return text.getvalue()
