# SPDX-License-Identifier: BSD-3-Clause
"""The command `python tests/fuzz`: runs the random tests and tells what failed, by cause."""

from __future__ import annotations

import argparse
import io
import json
import shutil
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from random import Random

from fuzz.case_files import EXAMPLES, case_job, case_jobs, changed_case, smaller
from fuzz.oracle import faults
from fuzz.run_folders import folder_jobs, runs_in
from fuzz.sandbox import Job, Outcome, run_jobs


def _arguments(given: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python tests/fuzz", description=__doc__)
    add = parser.add_argument
    add("--seed", type=int, default=1, help="of the random changes (default 1)")
    add("--checks", type=int, default=0, help="changed case files for `tilth check`")
    add("--runs", type=int, default=0, help="changed case files for `tilth run`, three steps")
    add("--folders", type=int, default=0, help="damaged run folders for `resume` and `report`")
    add("--long", action="store_true", help="5,000 checks, 1,000 runs and 500 folders")
    add("-j", type=int, default=1, dest="processes", help="commands at a time (default 1)")
    add("--patience", type=float, default=1.0, help="factor on the limits of processor time")
    add("--replay", metavar="NAME", help="one failure again, such as check-1-17, with its output")
    add("--smaller", action="store_true", help="with --replay: the fewest lines that still fail")
    add("--keep", type=Path, default=Path("fuzz_failures"), help="folder of failures")
    options = parser.parse_args(given)
    if options.long:
        options.checks, options.runs, options.folders = 5000, 1000, 500
    return options


def main(given: list[str] | None = None) -> int:
    """Runs what the arguments ask for; returns 1 if a fault was found."""
    options = _arguments(given)
    with tempfile.TemporaryDirectory(prefix="tilth-fuzz-") as name:
        work = Path(name)
        _load(work)
        if options.replay:
            return _replay(options, work)
        return _all(options, work)


def _load(work: Path) -> None:
    """Loads every library before the first fork."""
    import tilth.analysis.run
    import tilth.report.html  # noqa: F401
    from tilth.cli import run_command

    example = "plane_strain_block/case"
    content = (EXAMPLES / f"{example}.toml").read_bytes()
    sample = case_job("check", "sample", example, content, work)
    with redirect_stdout(io.StringIO()):
        run_command(sample.arguments)
    shutil.rmtree(sample.folder)


def _jobs(options: argparse.Namespace, work: Path) -> Iterator[Job]:
    for command, count in (("check", options.checks), ("run", options.runs)):
        yield from case_jobs(command, options.seed, range(count), work)
    if options.folders:
        runs = runs_in(work / "small-runs")
        yield from folder_jobs(options.seed, range(options.folders), runs, work)


def _all(options: argparse.Namespace, work: Path) -> int:
    start, seconds, count = time.monotonic(), 0.0, 0
    causes: dict[str, list[str]] = defaultdict(list)
    codes: dict[tuple[str, int], int] = defaultdict(int)
    jobs = (replace(job, seconds=options.patience * job.seconds) for job in _jobs(options, work))
    for job, outcome in run_jobs(jobs, options.processes):
        count, seconds = count + 1, seconds + outcome.seconds
        codes[job.arguments[0], outcome.code] += 1
        found = faults(job, outcome)
        for fault in found:
            causes[fault].append(job.name)
        if found:
            _keep(options.keep / job.name, job, outcome, found)
        shutil.rmtree(job.folder)
    for (command, code), number in sorted(codes.items()):
        print(f"{number:6d} x exit code {code} of {command}")
    for cause in sorted(causes, key=lambda cause: -len(causes[cause])):
        names = causes[cause]
        print(f"{len(names)} x {cause}\n    python tests/fuzz --replay {names[0]}")
    wall = time.monotonic() - start
    print(f"{count} commands, {seconds:.0f} s of processor time, {wall:.0f} s", end="; ")
    print(f"{len(causes)} kinds of faults")
    return 1 if causes else 0


def _keep(folder: Path, job: Job, outcome: Outcome, found: list[str]) -> None:
    """Saves the input and the outcome of a command that failed."""
    folder.mkdir(parents=True, exist_ok=True)
    case = job.folder / "input/case.toml"
    if case.exists():
        shutil.copy(case, folder)
    about = {"arguments": job.arguments, "code": outcome.code, "seconds": outcome.seconds}
    if (job.folder / "out").exists() and not case.exists():
        shutil.copytree(job.folder / "out", folder / "out", dirs_exist_ok=True)
    text = [*found, job.damaged, json.dumps(about), outcome.err[:20_000], outcome.bug]
    (folder / "outcome.txt").write_text("\n".join(text), encoding="utf-8", errors="replace")


def _replay(options: argparse.Namespace, work: Path) -> int:
    kind, seed, number = options.replay.split("-")
    if kind == "folder":
        runs = runs_in(work / "small-runs")
        jobs = folder_jobs(int(seed), [int(number)], runs, work)
    else:
        jobs = case_jobs(kind, int(seed), [int(number)], work)
    ((job, outcome),) = run_jobs(jobs, 1)
    found = faults(job, outcome)
    if options.smaller and found and kind != "folder":

        def still_fails(other: Job) -> bool:
            ((_, again),) = run_jobs([other], 1)
            return bool(set(found) & set(faults(other, again)))

        print(smaller(job, still_fails, work).decode(errors="backslashreplace"))
    elif kind != "folder":
        example, _ = changed_case(kind, Random(options.replay))
        print(f"example {example}; changed case file:")
        print((job.folder / "input/case.toml").read_text("utf-8", errors="backslashreplace"))
    print(job.damaged, " ".join(["tilth", *job.arguments]), sep="\n")
    print(f"exit code {outcome.code} after {outcome.seconds:.1f} s of processor time")
    print(outcome.out, outcome.err, outcome.bug, *found, sep="\n", file=sys.stdout)
    return 1 if found else 0
