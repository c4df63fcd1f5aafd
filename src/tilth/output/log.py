# SPDX-License-Identifier: BSD-3-Clause
"""``log.txt``: the record of a run, and its contents for the report."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from tilth.errors import BadInput, visible
from tilth.input_files import require_file
from tilth.output.disk import writing

START = "at the start: "
WARNING, CUT, FINISHED, STOPPED = "warning: ", "step cut: ", "finished: ", "stopped: "
STAGE = "stage: "
_STAGE_LINE = re.compile(r"stage: (?P<name>[^,]+), from time \S+; forces released in it: (.+)")
_RESIDUALS_PER_LINE = 6
_INDENT = " " * 34
_DURATION = re.compile(r"  time taken:\s+(\d+\.\d+) s")


class RunLog:
    """Writes the log line by line; each line is flushed to the file.

    ``warnings`` contains the text of all warnings of this run so far. With ``resume`` the log of
    the stopped run is continued and its warnings are included; ``seconds`` is the time [s] that its
    parts took. All methods raise ``AnalysisFailed`` if the file cannot be written.
    """

    def __init__(self, path: Path | str, resume: bool = False, seconds: float = 0.0) -> None:
        """Starts a new log, or continues the one at ``path``."""
        self.path = Path(path)
        self.warnings: list[str] = []
        self._cuts = 0
        self._steps = 0
        self._iterations = 0
        self._start = time.perf_counter() - seconds
        with writing(self.path):
            if resume:
                _remove_incomplete_line(self.path)
                earlier = read_log(self.path)
                self.warnings += earlier.warnings
                self._cuts = len(earlier.cuts)
            self._file = self.path.open("a" if resume else "w", encoding="utf-8")

    @property
    def file_number(self) -> int:
        """File descriptor of the log."""
        return self._file.fileno()

    @property
    def seconds(self) -> float:
        """Wall-clock time of all parts of the run so far [s]."""
        return time.perf_counter() - self._start

    def header(
        self,
        *,
        version: str,
        title: str,
        threads: int,
        points: int,
        cells: int,
        last_step: int = 0,
        processes: int = 1,
    ) -> None:
        """Writes version, case, date and sizes; ``last_step`` > 0 means that a run is resumed."""
        rows = [
            ("case", _one_line(title) or "(no title)"),
            ("date", datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")),
            *([("processes", str(processes))] if processes > 1 else []),
            ("threads", str(threads)),
            ("points", f"{points:,}"),
            ("active cells", f"{cells:,}"),
        ]
        if last_step:
            rows.append(("resumed", f"after step {last_step}"))
        self._write(f"tilth {version}")
        for name, value in rows:
            self._write(f"  {name + ':':<14}{value}")
        self._write("")
        self._write(f"{'step':>6}  {'time':>12}  {'step size':>10}  relative residual of Newton")

    def stage(self, name: str, time: float, released: str) -> None:
        """Writes that a stage begins at a total time; ``released``: resultant, empty for none."""
        forces = f"; forces released in it: {released}" if released else ""
        self._write(f"{STAGE}{name}, from time {time:.6g}{forces}")

    def reduction(self, name: str, time: float, text: str) -> None:
        """Writes the result of a stage of strength reduction at a total time."""
        self._write(f"strength reduction: {name}, at time {time:.6g}: {text}")

    def relaxation(self, text: str) -> None:
        """Writes that soil has come to rest."""
        self._write(text)

    def change(self, text: str) -> None:
        """Writes that the program changed a load between two steps."""
        self._write(f"load changed: {text}")

    def goes_on(self, text: str) -> None:
        """Writes that the run goes on with another model than that with which it began."""
        self._write(f"goes on with a changed model: {text}")

    def step(self, step: int, time: float, step_size: float, residuals: Sequence[float]) -> None:
        """Writes one converged step and its relative residuals, that of the predictor first."""
        start = f"{step:>6}  {time:>12.6g}  {step_size:>10.3e}  "
        numbers = [f"{residual:.2e}" for residual in residuals]
        for first in range(0, max(len(numbers), 1), _RESIDUALS_PER_LINE):
            self._write((start + "  ".join(numbers[first : first + _RESIDUALS_PER_LINE])).rstrip())
            start = _INDENT
        self._steps += 1
        self._iterations += max(len(residuals) - 1, 0)

    def processes(self, text: str) -> None:
        """Writes how several processes share the points after a step; nothing for no text."""
        if text:
            self._write(f"        {text}")

    def start(self, text: str) -> None:
        """Writes how the equilibrium of the initial state was found; it is in the report, too."""
        self._write(f"{START}{_one_line(text)}")

    def warning(self, text: str) -> None:
        """Writes a warning; it also appears in the report."""
        self.warnings.append(_one_line(text))
        self._write(f"{WARNING}{self.warnings[-1]}")

    def cut(self, step: int, time: float, step_size: float, reason: str) -> None:
        """Writes that ``step`` to ``time`` was undone and is repeated with ``step_size``."""
        self._cuts += 1
        self._write(
            f"{CUT}step {step} to time {time:.6g} undone ({_one_line(reason)}); "
            f"new step size {step_size:.3e}"
        )

    def finish(self, failure: str | None, parts: Mapping[str, float], solved: str) -> None:
        """Writes the summary; ``failure`` is the reason if the run ended before its schedule.

        ``parts`` is the wall-clock time [s] of each part of the computation, ``solved`` the number
        of linear systems by solver. The times are those of all parts of a run that was resumed.
        """
        rows = [
            ("steps", str(self._steps)),
            ("iterations", str(self._iterations)),
            ("systems", solved),
            ("step cuts", str(self._cuts)),
            ("warnings", str(len(self.warnings))),
            ("time taken", f"{self.seconds:.2f} s"),
            *((f"  {name}", f"{duration:.2f} s") for name, duration in parts.items()),
        ]
        self._write("")
        end = "the end of the schedule is reached"
        self._write(f"{FINISHED}{end}" if failure is None else f"{STOPPED}{_one_line(failure)}")
        for name, value in rows:
            self._write(f"  {name + ':':<14}{value}")

    def close(self) -> None:
        """Closes the file."""
        with writing(self.path):
            self._file.close()

    def _write(self, line: str) -> None:
        with writing(self.path):
            self._file.write(line + "\n")
            self._file.flush()


@dataclass
class LogContents:
    """Contents of a log that the report uses."""

    warnings: list[str] = field(default_factory=list)
    cuts: list[str] = field(default_factory=list)
    """One sentence per undone step."""
    start: str = ""
    """How the equilibrium of the initial state was found."""
    last_residuals: list[float] = field(default_factory=list)
    """Relative residuals of the last converged step, that of the predictor first."""
    last_step: int = 0
    finished: bool = False
    failure: str | None = None
    """Why the run stopped; None if it is running, was killed or finished."""
    seconds: float | None = None
    """Wall-clock time [s] of the run up to its last end, a resumed one's earlier parts included;
    None where it has not ended yet."""
    released: dict[str, str] = field(default_factory=dict)
    """Resultant of the forces released in each stage, by its name, where there are any."""
    facts: dict[str, str] = field(default_factory=dict)
    """The header of the (last part of the) run: version, date, threads, points, active cells."""


def read_log(path: Path | str) -> LogContents:
    """Reads what :class:`RunLog` wrote; damaged lines are left out.

    Raises ``BadInput`` where the file is missing.
    """
    path = Path(path)
    try:
        require_file(path)
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror}") from error
    lines = text.removesuffix("\n").split("\n")
    if text and not text.endswith("\n"):
        lines.pop()
    log = LogContents()
    in_step = False
    for line in lines:
        was_step, in_step = in_step, False
        words = line.split()
        if line.startswith("tilth ") and len(words) > 1:
            log.facts = {"tilth": words[1]}
            log.finished, log.failure = False, None
        elif line.startswith(WARNING):
            log.warnings.append(line.removeprefix(WARNING))
        elif line.startswith(START):
            log.start = line.removeprefix(START)
        elif line.startswith(CUT):
            log.cuts.append(line.removeprefix(CUT))
        elif match := _STAGE_LINE.fullmatch(line):
            log.released[match["name"]] = match[2]
        elif line.startswith(FINISHED):
            log.finished = True
        elif line.startswith(STOPPED):
            log.failure = line.removeprefix(STOPPED)
        elif match := _DURATION.fullmatch(line):
            log.seconds = float(match[1])
        elif line.startswith("  ") and words and words[0].isdecimal():
            if (residuals := _numbers(words[3:])) is not None:
                log.last_step, log.last_residuals = int(words[0]), residuals
                in_step = True
        elif was_step and line.startswith(_INDENT):
            log.last_residuals += _numbers(words) or []
            in_step = True
        elif line.startswith("  ") and ": " in line:
            name, value = line.strip().split(":", 1)
            log.facts.setdefault(name, value.strip())
    # a step that is repeated after a kill may write the same lines twice
    log.warnings = list(dict.fromkeys(log.warnings))
    log.cuts = list(dict.fromkeys(log.cuts))
    return log


def _remove_incomplete_line(path: Path) -> None:
    """Removes an incomplete last line of a killed run."""
    if path.exists():
        content = path.read_bytes()
        os.truncate(path, content.rfind(b"\n") + 1)
    else:
        path.touch()


def _numbers(words: Sequence[str]) -> list[float] | None:
    """Returns the words as numbers; None if one is none."""
    try:
        return [float(word) for word in words]
    except ValueError:
        return None


def _one_line(text: str) -> str:
    return visible(" ".join(text.split()))
