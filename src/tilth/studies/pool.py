# SPDX-License-Identifier: BSD-3-Clause
"""Processes that run the samples of a study."""

from __future__ import annotations

import os
import selectors
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import tilth
from tilth.environment import SIZES, set_environment

ATTEMPTS = 2
"""Processes that a sample may lose, before it counts as failed."""


class Worker:
    """A process that runs one sample at a time."""

    def __init__(self, folder: Path) -> None:
        environment = {k: v for k, v in os.environ.items() if k not in SIZES}
        environment["OMP_NUM_THREADS"] = "1"
        environment["OPENBLAS_NUM_THREADS"] = "1"
        package = str(Path(tilth.__file__).parents[1])
        before = environment.get("PYTHONPATH")
        environment["PYTHONPATH"] = os.pathsep.join([package, *([before] if before else [])])
        set_environment(environment)
        self.own = Path()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tilth.studies.worker", str(folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            start_new_session=True,
        )

    def start(self, own: Path) -> None:
        """Starts the sample in a folder."""
        self.own = own
        assert self.process.stdin is not None
        with suppress(OSError):  # it has ended: `finished` tells
            self.process.stdin.write(f"{own}\n".encode())
            self.process.stdin.flush()

    def finished(self) -> bool:
        """Returns whether its sample is complete; False if the process has ended instead."""
        assert self.process.stdout is not None
        return self.process.stdout.readline().endswith(b"\n")

    def end(self) -> int:
        """Ends the process and what it has started; returns how it ended, as `Popen`."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid, signal.SIGKILL)
        code = self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            with suppress(OSError):
                if pipe is not None:
                    pipe.close()
        return code


def run_all(
    folder: Path,
    samples: Iterable[Path],
    processes: int,
    on_done: Callable[[Path], None],
    on_lost: Callable[[Path, str], None],
) -> None:
    """Runs the samples in processes of their own, which end with this function however it ends.

    Args:
        folder: of the study.
        samples: folders, absolute; they are asked for when a process is free.
        on_done: is called when `outcome.json` of a sample is complete.
        on_lost: is called, with how it ended, when `ATTEMPTS` processes were lost with a sample.
    """
    waiting = iter(samples)
    again: list[Path] = []
    lost: dict[Path, int] = {}
    with _ended() as workers, selectors.DefaultSelector() as selector:

        def give(worker: Worker) -> None:
            own = again.pop() if again else next(waiting, None)
            if own is None:
                workers.remove(worker)
                worker.end()
                return
            assert worker.process.stdout is not None
            selector.register(worker.process.stdout, selectors.EVENT_READ, worker)
            worker.start(own)

        def new() -> None:
            workers.append(Worker(folder))
            give(workers[-1])

        for _ in range(processes):
            new()
        while selector.get_map():
            for key, _ in selector.select():
                worker: Worker = key.data
                selector.unregister(key.fileobj)
                if worker.finished():
                    on_done(worker.own)
                    give(worker)
                    continue
                own = worker.own
                code = worker.process.wait()
                workers.remove(worker)
                worker.end()
                lost[own] = lost.get(own, 0) + 1
                if lost[own] < ATTEMPTS:
                    again.append(own)
                else:
                    on_lost(own, _how(code))
                new()


@contextmanager
def _ended() -> Iterator[list[Worker]]:
    """Gives a list of processes; those that are in it are ended at the end."""
    workers: list[Worker] = []
    try:
        yield workers
    finally:
        for worker in workers:
            worker.end()


def _how(code: int) -> str:
    """Returns how a process ended, in words."""
    if code < 0:
        with suppress(ValueError):
            return f"by the signal {signal.Signals(-code).name}"
    return f"with the exit code {abs(code)}"
