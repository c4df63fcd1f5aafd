# SPDX-License-Identifier: BSD-3-Clause
"""The named errors of tilth: what went wrong, how to put it right, and the exit code of each."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Final

ISSUE_TRACKER: Final = "the project's issue tracker"
"""Where an exit code 4 asks the user to report a bug."""

EXIT_DONE: Final = 0
EXIT_ANALYSIS_FAILED: Final = 1
EXIT_BAD_INPUT: Final = 2
EXIT_INTERRUPTED: Final = 3
EXIT_BUG: Final = 4


MOST_SHOWN: Final = 20
"""Wrong entries that one message lists, at most."""


LONGEST_KEY: Final = 200
"""Characters of a key that a message shows, at most."""


class _NotGiven:
    """Type of the marker for 'no value was given', since `None` can be a value."""

    def __repr__(self) -> str:
        return "NOT_GIVEN"


NOT_GIVEN: Final = _NotGiven()


def visible(text: str) -> str:
    """Returns `text` with all that is not printable, except line breaks, as escapes.

    What tilth shows can come from elsewhere, such as the name of a file or the exception of a
    user's function. On a terminal, control characters in it could hide or imitate other text.
    """
    if text.replace("\n", "").isprintable():
        return text
    return "".join(c if c == "\n" or c.isprintable() else ascii(c)[1:-1] for c in text)


class TilthError(Exception):
    """Base of every error that tilth raises on purpose.

    `message`: what is wrong; `remedy` (may be empty): what the user can do about it.
    """

    exit_code: ClassVar[int] = EXIT_BUG

    def __init__(self, message: str, remedy: str = "") -> None:
        super().__init__(message, remedy)
        self.message = message
        self.remedy = remedy

    def __str__(self) -> str:
        return visible(f"{self.message}\n  {self.remedy}" if self.remedy else self.message)


class AnalysisFailed(TilthError):
    """The analysis could not be finished; the results so far are on disk."""

    exit_code = EXIT_ANALYSIS_FAILED


class Interrupted(TilthError):
    """The user stopped the run; the last complete step is on disk and can be resumed."""

    exit_code = EXIT_INTERRUPTED


@dataclass(frozen=True)
class Problem:
    """One wrong entry of the input.

    `key` is the dotted key as it stands in the case file (`bodies[0].shape.lower`; empty where
    the input as a whole is meant), `value` what was given there (`NOT_GIVEN` if nothing was).
    """

    key: str
    problem: str
    remedy: str = ""
    value: Any = NOT_GIVEN

    def __str__(self) -> str:
        key = self.key.replace("\n", "\\n")
        subject = key if len(key) <= LONGEST_KEY else f"{key[: LONGEST_KEY - 4]} ..."
        if self.key and self.value is not NOT_GIVEN:
            subject = f"{subject} = {shown(self.value)}"
        text = f"{subject}: {self.problem}" if subject else self.problem
        return visible(f"{text}\n  {self.remedy}" if self.remedy else text)


class BadInput(TilthError):
    """The input is wrong: file, key, given value and remedy.

    `problems` holds every wrong entry found; `key`, `value`, `problem` and `remedy` are those of
    the first one.
    """

    exit_code = EXIT_BAD_INPUT

    def __init__(
        self,
        problem: str,
        remedy: str = "",
        *,
        key: str = "",
        value: Any = NOT_GIVEN,
        file: str | Path | None = None,
        further: Sequence[Problem] = (),
    ) -> None:
        super().__init__(problem, remedy)
        self.problem = problem
        self.key = key
        self.value = value
        self.file = None if file is None else str(file)
        self.problems = (Problem(key, problem, remedy, value), *further)

    @classmethod
    def of(cls, problems: Sequence[Problem], file: str | Path | None = None) -> BadInput:
        """Returns one error that reports all `problems` (at least one)."""
        first = problems[0]
        return cls(
            first.problem,
            first.remedy,
            key=first.key,
            value=first.value,
            file=file,
            further=problems[1:],
        )

    def in_file(self, file: str | Path) -> BadInput:
        """Returns the same error with the file that contains the mistake."""
        return BadInput.of(self.problems, file)

    def during(self, when: str) -> BadInput:
        """Returns the same error with the moment of the analysis at which it appeared."""
        at = [replace(each, problem=f"{each.problem} ({when})") for each in self.problems]
        return BadInput.of(at, self.file)

    def __reduce__(self) -> tuple[Any, ...]:
        return BadInput.of, (self.problems, self.file)

    def __str__(self) -> str:
        head = visible(f"{self.file}: ") if self.file else ""
        if len(self.problems) == 1:
            return f"{head}{self.problems[0]}"
        first = [str(p).replace("\n", "\n  ") for p in self.problems[:MOST_SHOWN]]
        lines = [f"{head}{len(self.problems)} entries are wrong", *(f"  {each}" for each in first)]
        if len(self.problems) > MOST_SHOWN:
            lines.append(f"  ... and {len(self.problems) - MOST_SHOWN} more")
        return "\n".join(lines)


def shown(value: Any, width: int = 80) -> str:
    """Returns `value` as a case file would write it, on one line, shortened to `width`.

    Of a text the middle is left out: a path ends with the name of the file.
    """
    try:
        text = json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError):
        try:
            text = " ".join(repr(value).split())
        except (ValueError, RecursionError):  # too many digits, or too many levels
            text = "..."
    if len(text) <= width:
        return text
    if isinstance(value, str):
        return f"{text[: (width + 1) // 2 - 5]} ... {text[-(width // 2) :]}"
    return text[: width - 4] + " ..."


class StepFailed(TilthError):
    """A load step that found no equilibrium and is to be undone: why, and at which point.

    `remedy` (may be empty) is what helps where smaller steps do not, `residuals` holds the relative
    residual after each Newton iteration, `point` is the permanent number of the point that failed
    (None if no point is to blame), `share` the part of the step that is known to be possible.
    """

    exit_code = EXIT_ANALYSIS_FAILED

    def __init__(
        self,
        reason: str,
        remedy: str = "",
        *,
        point: int | None = None,
        residuals: Sequence[float] = (),
        share: float | None = None,
    ) -> None:
        super().__init__(reason, remedy)
        self.reason = reason
        self.point = point
        self.share = share
        self.residuals = list(residuals)
