# SPDX-License-Identifier: BSD-3-Clause
"""What all benchmarks measure with: processes, the machine and its rates, medians of repeats."""

from __future__ import annotations

import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

RUN_CASE = Path(__file__).with_name("run_case.py")
ONE_THREAD_LIBRARIES = ("MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")


class Failed(Exception):
    """A process that was to be measured ended with an error."""


@dataclass(frozen=True)
class Usage:
    """What a finished process took.

    Attributes:
        user, system: processor time of all its threads [s].
        wall: wall-clock time [s].
    """

    user: float
    system: float
    wall: float

    @property
    def processor(self) -> float:
        """User and system time [s]."""
        return self.user + self.system


def spawn(
    command: Sequence[str], threads: int | None = None, folder: Path | None = None
) -> tuple[Usage, str]:
    """Runs a command in `folder`; returns what it took and what it printed.

    Args:
        threads: for OpenMP and the numerical libraries; as the environment says if None.

    Raises:
        Failed: it did not end with exit code 0; carries the end of what it wrote.
    """
    # as tilth itself has it
    environment = dict(os.environ, OMP_WAIT_POLICY="passive", GOMP_SPINCOUNT="10000")
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # it would make each run compile its sources
    if threads is not None:
        environment |= dict.fromkeys(("OMP_NUM_THREADS", *ONE_THREAD_LIBRARIES), str(threads))
    begin = time.perf_counter()
    with tempfile.TemporaryFile("w+", encoding="utf-8") as errors:
        process = subprocess.Popen(
            list(command), stdout=subprocess.PIPE, stderr=errors, text=True, cwd=folder,
            env=environment,
        )  # fmt: skip
        assert process.stdout is not None
        printed = process.stdout.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        process.stdout.close()
        if process.returncode:
            errors.seek(0)
            end = (printed + errors.read()).strip()[-2000:]
            raise Failed(f"{' '.join(command)} ended with exit code {process.returncode}:\n{end}")
    return Usage(used.ru_utime, used.ru_stime, time.perf_counter() - begin), printed


@dataclass(frozen=True)
class CaseRun:
    """A run of tilth in a process of its own.

    Attributes:
        usage: of the whole process.
        done: what run_case.py printed; see there.
    """

    usage: Usage
    done: dict[str, Any]


def run_case(model: Any, threads: int) -> CaseRun:
    """Runs a model of tilth in a process of its own, output as the model says."""
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "model.json"
        case.write_text(json.dumps(model.to_dict()))
        command = [sys.executable, str(RUN_CASE), str(case), str(threads)]
        usage, printed = spawn(command, threads)
    return CaseRun(usage, json.loads(printed.splitlines()[-1]))


def start_up(repeats: int) -> list[Usage]:
    """Runs `tilth --version`: what any run takes before it reads a case."""
    return [spawn([sys.executable, "-m", "tilth", "--version"], 1)[0] for _ in range(repeats)]


def median(values: Sequence[float]) -> float:
    return statistics.median(values)


def machine() -> str:
    """Processor, cores, memory, system and versions, one line each."""
    import numpy
    import scipy

    import tilth

    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    load = os.getloadavg()[0]
    return "\n".join(
        [
            f"{processor()}, {cores} cores, {memory:.0f} GB, load {load:.1f} at the start",
            f"{platform.platform()}, Python {platform.python_version()}",
            f"tilth {tilth.__version__}, NumPy {numpy.__version__}, SciPy {scipy.__version__}",
        ]
    )


def processor() -> str:
    """The processor's name as the system gives it."""
    listing = Path("/proc/cpuinfo")
    if listing.exists():
        for line in listing.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def machine_rates() -> tuple[float, float]:
    """Rate of a matrix product [Gflop/s] and of a triad [GB/s] on one thread."""
    command = [sys.executable, "-c", "import measure; print(measure.product_rate())"]
    _, printed = spawn(command, threads=1, folder=RUN_CASE.parent)
    return float(printed), triad_rate(1)


def product_rate() -> float:
    """Rate of a matrix product on as many threads as the environment says [Gflop/s]."""
    import numpy as np

    a = np.random.default_rng(0).random((1200, 1200))
    return 2e-9 * 1200**3 / min(timed(lambda: a @ a) for _ in range(5))


def triad_rate(threads: int) -> float:
    """Rate of a triad on so many threads [GB/s], the best of five."""
    import numpy as np

    x, y, z = (np.ones(20_000_000) for _ in range(3))

    def triad(part: slice) -> None:
        np.multiply(y[part], 3.0, out=x[part])
        np.add(x[part], z[part], out=x[part])

    bounds = np.linspace(0, len(x), threads + 1).astype(int).tolist()
    parts = [slice(*pair) for pair in pairwise(bounds)]
    with ThreadPoolExecutor(threads) as pool:
        passes = min(timed(lambda: list(pool.map(triad, parts))) for _ in range(5))
    return 5 * 8e-9 * len(x) / passes


def timed(action: Callable[[], object]) -> float:
    """Wall-clock time of one call [s]."""
    start = time.perf_counter()
    action()
    return time.perf_counter() - start
