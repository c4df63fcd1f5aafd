# SPDX-License-Identifier: BSD-3-Clause
"""What every command promises, whatever its input: the faults of an outcome, named by cause."""

from __future__ import annotations

import re
import signal
import unicodedata
from pathlib import Path

import h5py
import numpy as np

from fuzz.sandbox import BUGS, ERR, FOUND, OUT, Job, Outcome

CODES = {"check": {0, 2}, "run": {0, 1, 2}, "resume": {0, 1, 2}, "report": {0, 2}}
LONGEST = 20_000
"""Characters of a message that a user might still read."""


STEPS_IN_TIME, POINTS_IN_TIME = 3, 50_000
"""Load steps and material points for which a run has its time."""


def _has_work(job: Job) -> bool:
    """Whether a run has done more load steps, as steps were cut, or has more points than that."""
    history, log = (job.folder / "out" / name for name in ("history.csv", "log.txt"))
    steps = len(history.read_bytes().splitlines()) - 1 if history.exists() else 0
    found = re.search(r"points: +([\d,]+)", log.read_text("utf-8")) if log.exists() else None
    points = int(found[1].replace(",", "")) if found else 0
    return steps > STEPS_IN_TIME or points > POINTS_IN_TIME


def faults(job: Job, outcome: Outcome) -> list[str]:
    """Returns the broken promises of a command, each as one line that names its cause."""
    where = f"damaged {job.damaged.partition(':')[0]}: " if job.damaged else ""
    return [where + fault for fault in _broken_promises(job, outcome)]


def _broken_promises(job: Job, outcome: Outcome) -> list[str]:
    command, err = job.arguments[0], outcome.err
    if outcome.code < 0:
        name = signal.Signals(-outcome.code).name
        ended = "too slow" if name in ("SIGXCPU", "SIGKILL") else f"crash by {name}"
        if ended == "too slow" and command == "run" and _has_work(job):
            return []
        return [f"{ended} in {_deepest(err)}"]
    found = list(outcome.found)
    if outcome.code == 4:
        errors = re.findall(r"^([\w.]+)(?::|$)", outcome.bug, re.MULTILINE)
        found.append(f"bug: {errors[-1] if errors else err[:60]} in {_deepest(outcome.bug)}")
    elif outcome.code not in CODES[command]:
        found.append(f"exit code {outcome.code} in {_deepest(err)}")
    elif "Traceback (most recent" in err:
        found.append(f"traceback in {_deepest(err)}")
    found += [f"library's warning: {text}" for text in _warnings(err)]
    heads = [line for line in err.splitlines() if line[:1].strip() and "Warning: " not in line]
    messages = [line for line in heads if not line.startswith("warning: ")]
    if outcome.code in (1, 2) and len(messages) != 1 and "Traceback" not in err:
        found.append(f"{len(messages)} messages instead of one")
    if outcome.code == 0 and messages:
        found.append(f"exit code 0 with a message: {messages[0][:60]}")
    if len(err) > LONGEST:
        found.append("message longer than 20,000 characters")
    if strange := sorted({_control(c) for c in err + outcome.out} - {""}):
        found.append(f"unprintable characters on the terminal: {', '.join(strange)}")
    found += _strays(job, outcome)
    return found


def _deepest(trace: str) -> str:
    """Returns the innermost place in tilth that a traceback or stack names."""
    places = re.findall(r'File "[^"]*/src/tilth/([^"]*)", line \d+,? in (\S+)', trace)
    places += re.findall(r'File "[^"]*/site-packages/tilth/([^"]*)", line \d+,? in (\S+)', trace)
    if not places:
        return "an unknown place"
    # a stack of faulthandler begins with the innermost call, a traceback ends with it
    file, function = places[0] if "most recent call first" in trace else places[-1]
    return f"{file}:{function}"


def _warnings(err: str) -> list[str]:
    found = re.findall(r"([\w./-]*?):\d+: (\w*Warning: .{0,60})", err)
    return sorted({f"{'/'.join(Path(file).parts[-2:])}: {text}" for file, text in found})


def _control(character: str) -> str:
    if character in "\n" or unicodedata.category(character) not in ("Cc", "Cf"):
        return ""
    return f"U+{ord(character):04X}"


def _strays(job: Job, outcome: Outcome) -> list[str]:
    """Files that the command should not have left behind."""
    own = {OUT, ERR, FOUND, BUGS, "input", "out"}
    pictures = {file.name for file in job.folder.glob("setup.*")} if outcome.code == 0 else set()
    strays = sorted({file.name for file in job.folder.iterdir()} - own - pictures)
    found = [f"file left outside the output folder: {name}" for name in strays]
    if job.arguments[0] == "run" and outcome.code == 2 and (job.folder / "out").exists():
        found.append("a refused run leaves its output folder")
    return found


def inspect_results(folder: Path) -> list[str]:
    """Returns the faults of the results of a run: numbers that are not finite."""
    found = []
    history = folder / "history.csv"
    if history.exists():
        rows = history.read_text(encoding="utf-8").splitlines()[1:]
        if any(re.search(r"\b(nan|inf)\b", row) for row in rows):
            found.append("a number in history.csv is not finite")
    results = folder / "results.vtkhdf"
    if results.exists():
        with h5py.File(results) as file:
            names: list[str] = []
            file.visititems(lambda name, item: _note(name, item, names))
        found += [f"results.vtkhdf: {name} is not finite" for name in names]
    return found


def _note(name: str, item: object, names: list[str]) -> None:
    if (
        isinstance(item, h5py.Dataset)
        and item.dtype.kind == "f"
        and not np.isfinite(item[()]).all()
    ):
        names.append(name)
