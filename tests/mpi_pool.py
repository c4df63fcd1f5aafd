# SPDX-License-Identifier: BSD-3-Clause
"""Processes that `mpiexec` starts once and that then run one Python text after the other.

Starting Python, MPI and PETSc takes most of the time of a small run. Processes without work look
for the next text every few milliseconds, so that they leave the cores to others; each text has a
namespace of its own. A text that fails ends all processes, and the next one starts them anew.
"""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
import time
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import cost

PAUSE = 0.004
"""Between two looks for the next text [s]."""


class Pool:
    """Some processes that run texts together.

    Args:
        command: that starts them, without the script.
        environment: all variables of theirs.
    """

    def __init__(self, command: list[str], environment: dict[str, str]) -> None:
        self._folder = TemporaryDirectory()
        self._done = 0
        self._output = (self.folder / "output").open("w+", encoding="utf-8")
        self._processes = subprocess.Popen(
            [*command, __file__, str(self.folder)], env=environment, stdin=subprocess.DEVNULL,
            stdout=self._output, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip

    @property
    def folder(self) -> Path:
        """Where texts and answers are."""
        return Path(self._folder.name)

    @property
    def alive(self) -> bool:
        """Whether the processes wait for a text."""
        return self._processes.poll() is None

    def run(self, source: str, limit: float) -> str:
        """Runs a text in all processes; returns what it wrote to the file that it is given.

        It is run in a new folder.

        Raises:
            AssertionError: with all that the processes printed, if the text failed in one of them,
                or did not end within `limit` seconds.
        """
        answer = self.folder / f"{self._done}.json"
        written = self.folder / "written"
        written.write_text(source, encoding="utf-8")
        written.rename(self.folder / f"{self._done}.py")
        self._done += 1
        end = time.monotonic() + limit
        while not answer.exists():
            if not self.alive or time.monotonic() > end:
                why = "failed" if not self.alive else f"not done after {limit:g} s"
                raise AssertionError(f"{why}\n{self.close()}")
            time.sleep(PAUSE)
        spent, _, text = answer.read_text(encoding="utf-8").partition("\n")
        cost.charge(float(spent))
        return text

    def close(self) -> str:
        """Ends the processes; returns what they printed."""
        self._processes.terminate()
        self._processes.wait()
        self._output.seek(0)
        printed = self._output.read()
        self._output.close()
        self._folder.cleanup()
        return printed


_POOLS: dict[int, Pool] = {}


def pool_of(processes: int, python: str, environment: dict[str, str]) -> Pool:
    """The pool of so many processes, which is started if there is none."""
    pool = _POOLS.get(processes)
    if pool is None or not pool.alive:
        launcher = ["mpiexec", "-n", str(processes)] if processes > 1 else []
        pool = _POOLS[processes] = Pool([*launcher, python], os.environ | environment)
        _end_at_exit()
    return pool


@cache
def _end_at_exit() -> None:
    atexit.register(lambda: [pool.close() for pool in _POOLS.values() if pool.alive])


def serve(folder: Path) -> None:
    """Runs the texts of a folder, one after the other, for as long as `mpiexec` lives.

    The answer, after the processor seconds of all processes, is there when all of them are done.
    """
    from tilth.mpi import world

    parent, number, before = os.getppid(), 0, 0.0
    while True:
        script = folder / f"{number}.py"
        while not script.exists():
            if os.getppid() != parent:
                return
            time.sleep(PAUSE)
        answer, part = folder / f"{number}.json", folder / f"{number}.part"
        sys.argv = [str(script), str(part)]
        text = script.read_text(encoding="utf-8")
        place = folder / str(number)
        place.mkdir(exist_ok=True)
        os.chdir(place)
        exec(compile(text, str(script), "exec"), {"__name__": "__main__"})
        now = time.process_time()
        spent = sum(world().gathered(now - before))
        if world().rank == 0:
            part.write_text(f"{spent}\n{part.read_text(encoding='utf-8')}", encoding="utf-8")
            part.rename(answer)
        number, before = number + 1, now


if __name__ == "__main__":
    serve(Path(sys.argv[1]))
