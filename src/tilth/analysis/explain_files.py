# SPDX-License-Identifier: BSD-3-Clause
"""Writes and tells the explanation of a step, also where the run ends in this step."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tilth import __version__
from tilth.analysis.explain import Explanation
from tilth.analysis.explain_tables import screen_text, spreadsheet
from tilth.analysis.explained import ExplainedStep
from tilth.errors import TilthError
from tilth.output.disk import writing
from tilth.output.files import write_durably, written_whole
from tilth.output.folder import explanation_files
from tilth.plot.residual_forces import residual_figure
from tilth.report.texts import save

RESOLUTION = 160
"""Of the picture [pixels per inch]."""


@contextmanager
def told(
    explanation: Explanation | None, folder: Path, say: Callable[[str], None]
) -> Iterator[Callable[[], None]]:
    """Gives a function to call after each step, which tells the explanation once it is complete.

    If the run ends before, by a failure or an interruption, in this step or after it, what is known
    of it is told then.

    Args:
        explanation: of a step; nothing is told if None.
        folder: of the run, into which it is written.
        say: prints a text.

    Raises:
        AnalysisFailed: a file cannot be written; where the run ends by another error, that is only
            said, and so is whatever else keeps the explanation from being told.
    """
    is_told = False

    def incomplete(problem: Exception) -> None:
        why = str(problem) or type(problem).__name__
        say(f"the explanation of the step could not be completed: {why}")

    def tell() -> None:
        nonlocal is_told
        if explanation is None or is_told or not explanation.complete:
            return
        assert explanation.step is not None
        is_told = True
        try:
            _tell(explanation.step, folder, say)
        except TilthError:
            raise
        except Exception as problem:  # it is not to end a run that can go on
            incomplete(problem)

    try:
        yield tell
    except BaseException:
        if explanation is not None and not is_told:
            if explanation.step is not None:
                try:
                    _tell(explanation.step, folder, say)
                except Exception as problem:  # it is not to hide why the run ends
                    incomplete(problem)
            elif explanation.last:
                say(
                    f"step {explanation.asked} to explain was not among the steps taken; the last "
                    f"one tried is {explanation.last}"
                )
        raise


def _tell(step: ExplainedStep, folder: Path, say: Callable[[str], None]) -> None:
    files = ", ".join(write_explanation(step, folder))
    say(f"{screen_text(step)}\n\nwritten to {folder}: {files}")


def write_explanation(step: ExplainedStep, folder: Path) -> list[str]:
    """Writes all numbers, a table and a picture of a step into the folder of a run.

    Without an iteration there is no picture; an earlier one of this step is removed.

    Returns:
        The names of the files that are written.

    Raises:
        AnalysisFailed: one cannot be written.
    """
    names = explanation_files(step.number)
    content = {"tilth": __version__} | step.to_dict()
    texts = {names.whole: json.dumps(content, indent=1), names.table: spreadsheet(step)}
    for name, text in texts.items():
        with writing(folder / name):
            write_durably(folder / name, text.encode())
    if step.shown is None:
        with writing(folder / names.picture):
            (folder / names.picture).unlink(missing_ok=True)
        return [names.whole, names.table]
    number, solve = step.shown
    assert solve.telling is not None
    iteration, residuals = solve.telling
    attempt = step.attempts[number - 1]
    title = (
        f"forces out of balance in step {step.name}\nattempt {number} ({attempt.end}), "
        f"iteration {iteration.number}: {iteration.relative:.2e} of the forces"
    )
    mark = f"largest, near point {iteration.largest.point} of {iteration.largest.body!r}"
    mark = "" if iteration.is_balanced else mark
    figure = residual_figure(residuals, title, mark, step.length_unit, step.force_unit)
    with writing(folder / names.picture), written_whole(folder / names.picture) as new:
        save(figure, new, dpi=RESOLUTION)
    return list(names)
