# SPDX-License-Identifier: BSD-3-Clause
"""Commands of tilth, each in a forked process of its own with limits of time and memory.

The process is forked from one that has loaded all libraries, so a command costs no start.
"""

from __future__ import annotations

import faulthandler
import json
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

MEMORY = 3 * 2**30
"""Address space of a command beyond that of the process that starts it [bytes]."""
FILE_SIZE = 300 * 2**20
"""Largest file that a command can write [bytes]."""
WAITING = 12.0
"""Wall-clock time allowed for a second of processor time: the machine may have other work."""
OUT, ERR, FOUND, BUGS = "stdout.txt", "stderr.txt", "found.json", "bugs"


@dataclass
class Job:
    """A command to be run in a folder of its own.

    seconds: processor time that it may take. inspect: is called in the same process after the
    command, with its exit code; returns the faults that it finds in the files. damaged: file of a
    run's folder that was damaged, and the array in it.
    """

    name: str
    folder: Path
    arguments: list[str]
    seconds: float
    inspect: Callable[[int], list[str]]
    damaged: str = ""


@dataclass
class Outcome:
    """What a command did; `code` is negative if a signal ended it (minus its number)."""

    code: int
    seconds: float
    out: str
    err: str
    bug: str
    """Traceback of an exit code 4."""
    found: list[str]


def run_jobs(jobs: Iterable[Job], processes: int) -> Iterator[tuple[Job, Outcome]]:
    """Runs jobs, so many at a time; yields each with its outcome as it ends."""
    waiting = iter(jobs)
    running: dict[int, tuple[Job, float]] = {}
    more = True
    while more or running:
        while more and len(running) < processes:
            job = next(waiting, None)
            more = job is not None
            if job is not None:
                running[_started(job)] = job, time.monotonic()
        for process, (job, start) in list(running.items()):
            ended, status, used = os.wait4(process, os.WNOHANG)
            if ended:
                del running[process]
                code = os.waitstatus_to_exitcode(status)
                yield job, _outcome(job, code, used.ru_utime + used.ru_stime)
            elif time.monotonic() - start > WAITING * job.seconds:
                os.kill(process, signal.SIGKILL)
        time.sleep(0.002)


def _started(job: Job) -> int:
    sys.stdout.flush()
    sys.stderr.flush()
    process = os.fork()
    if process:
        return process
    code = 70
    try:
        _limit(job)
        from tilth.cli import run_command

        code = run_command(job.arguments)
        found = job.inspect(code)
        (job.folder / FOUND).write_text(json.dumps(found), encoding="utf-8")
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _limit(job: Job) -> None:
    """Gives the forked process its folder, files, limits and a user's warnings."""
    os.setsid()
    os.chdir(job.folder)
    for number, name in ((1, OUT), (2, ERR)):
        file = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, number)
        os.close(file)
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    seconds = int(job.seconds)
    for limit, most in (
        (resource.RLIMIT_AS, used + MEMORY),
        (resource.RLIMIT_FSIZE, FILE_SIZE),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_CPU, seconds),
    ):
        resource.setrlimit(limit, (most, most + 5 if limit == resource.RLIMIT_CPU else most))
    faulthandler.enable()
    faulthandler.register(signal.SIGXCPU, chain=True)  # shows where the time goes
    (job.folder / BUGS).mkdir()
    tempfile.tempdir = str(job.folder / BUGS)
    warnings.resetwarnings()
    for kind in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
        warnings.simplefilter("ignore", kind)


def _outcome(job: Job, code: int, seconds: float) -> Outcome:
    def text(file: Path) -> str:
        return file.read_text(encoding="utf-8", errors="backslashreplace") if file.exists() else ""

    found = text(job.folder / FOUND)
    return Outcome(
        code=code,
        seconds=seconds,
        out=text(job.folder / OUT),
        err=text(job.folder / ERR),
        bug="".join(map(text, sorted(job.folder.glob(f"{BUGS}/*")))),
        found=json.loads(found) if found else [],
    )
