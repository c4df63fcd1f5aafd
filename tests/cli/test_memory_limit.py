# SPDX-License-Identifier: BSD-3-Clause
"""Runs in a process with too little memory: one message, and a resumed run with the same bits."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from readings import long, some_of

from tilth.analysis import run as analysis
from tilth.analysis.memory import memory_of, require_memory_to_check
from tilth.analysis.simulation import Simulation
from tilth.available_memory import AvailableMemory
from tilth.case import load_case
from tilth.errors import BadInput
from tilth.mpm.soil import Soil
from tilth.output import ResultsWriter, read_checkpoint
from tilth.output.folder import CHECKPOINT, HISTORY
from tilth.solvers.banded import BandedLU

from .conftest import Outcome

pytest.importorskip("resource", reason="only some systems limit the memory of a process")

LIMITED = """
import resource, sys
limit = int(sys.argv[1]) * 2**20
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
from tilth.cli import run_command
sys.exit(run_command(sys.argv[2:]))
"""

FINE = (
    ("cell_size = 0.5", "cell_size = 0.03125"),
    ("points_per_cell = 2", "points_per_cell = 3"),
    ("steps = 2", "steps = 3"),
    ("yield_stress = 2e4", "yield_stress = 2e5"),
    ("[[loads]]", "[output]\nreport = false\n\n[[loads]]"),
)
"""36,864 points."""


def limited(megabytes: int, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Runs `tilth ARGUMENTS` with so much address space."""
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, "-c", LIMITED, str(megabytes), *map(str, arguments)],
        capture_output=True, text=True, env=environment, timeout=500, check=False,
    )  # fmt: skip


def message_of(done: subprocess.CompletedProcess[str]) -> str:
    """The message of a run that failed for lack of memory, and nothing else."""
    text = done.stderr
    assert done.returncode in (1, 2), text
    assert "Traceback" not in text
    assert "bug" not in text
    assert "memory" in text
    *of_superlu, what, remedy = text.strip().splitlines()
    assert "memory" in what
    assert remedy.startswith("  ")
    known = r"Not enough memory|[Mm]alloc fails|Can't expand MemType|Storage for"
    assert all(re.match(known, line) for line in of_superlu)
    return text


def test_what_does_not_fit_is_refused_before_the_run(case: Callable[..., Path]) -> None:
    file = case(*FINE)
    done = limited(320, "run", file)
    assert done.returncode == 2
    text = message_of(done)
    assert "RLIMIT_AS of the process (`ulimit -v`)" in text
    assert "unknowns" in text
    assert "--memory-limit" in text
    assert not file.with_suffix("").exists()


def test_limit_too_low_for_the_program_is_refused(case: Callable[..., Path]) -> None:
    done = limited(120, "run", case())
    assert done.returncode == 2
    assert "RLIMIT_AS" in message_of(done)


def test_run_out_of_memory_in_a_step_is_resumed(case: Callable[..., Path], tmp_path: Path) -> None:
    run_limited_and_resume(case(*FINE), tmp_path, 345)


def fail_at(monkeypatch: pytest.MonkeyPatch, place: str, error: Exception) -> None:
    """Lets a part of the run fail once."""
    owner, name, calls_before = PLACES[place]
    method, calls = getattr(owner, name), iter(range(1000))

    def failing(*arguments: Any, **options: Any) -> Any:
        if next(calls) == calls_before:
            raise error
        return method(*arguments, **options)

    monkeypatch.setattr(owner, name, failing)


PLACES: dict[str, tuple[Any, str, int]] = {
    "set-up": (Simulation, "check", 0),
    "first output": (ResultsWriter, "append", 0),
    "first step": (Soil, "update", 0),
    "solver": (BandedLU, "setup", 4),
    "commit": (Soil, "advance", 1),
    "output": (ResultsWriter, "append", 2),
    "report": (analysis, "write_report", 0),
}
"""Method that fails, and after how many calls."""


ERRORS: dict[str, Exception] = {
    "numpy": MemoryError("Unable to allocate 7.45 GiB for an array with shape (1000000000,)"),
    "hdf5": RuntimeError("Unable to create dataset (memory allocation failed for raw data chunk)"),
}
"""Library -> what it raises."""


@pytest.mark.slow
@some_of(1, place=list(PLACES), library=list(ERRORS))
def test_every_place_that_runs_out_of_memory_leaves_the_last_step(
    tilth: Callable[..., Outcome],
    case: Callable[..., Path],
    tmp_path: Path,
    place: str,
    library: str,
) -> None:
    error = ERRORS[library]
    file = case(("steps = 2", "steps = 3"), ("yield_stress = 2e4", "yield_stress = 2e5"))
    folder, whole = tmp_path / "failed", tmp_path / "whole"
    with pytest.MonkeyPatch.context() as patched:
        fail_at(patched, place, error)
        outcome = tilth("run", file, "--out", folder, "--quiet")
    assert outcome.code == 1
    assert "bug" not in outcome.err
    assert len(outcome.err.strip().splitlines()) == 2
    wanted = " for another 7.45 GiB" if isinstance(error, MemoryError) else ""
    problem = f"there is not enough memory{wanted}"
    if place == "report":
        assert f"the results are in {folder}, but not the report: {problem}\n" in outcome.err
        assert f"tilth report {folder}" in outcome.err
    else:
        assert f"{problem} (64 points, 54 unknowns" in outcome.err
    if place in ("set-up", "first output", "first step"):
        assert "no step is complete" in outcome.err
        return
    assert place == "report" or f"tilth resume {folder}" in outcome.err
    assert tilth("resume", folder, "--quiet").code == 0
    assert tilth("run", file, "--out", whole, "--quiet").code == 0
    require_same(folder, whole)


def require_same(folder: Path, other: Path) -> None:
    """Requires the same state and history of two runs, to the last bit."""
    (resumed, _), (expected, _) = (read_checkpoint(f / CHECKPOINT) for f in (folder, other))
    assert resumed.keys() == expected.keys()
    for name, array in expected.items():
        np.testing.assert_array_equal(resumed[name], array, err_msg=name)
    assert (folder / HISTORY).read_bytes() == (other / HISTORY).read_bytes()


def test_check_warns_of_what_does_not_fit(case: Callable[..., Path]) -> None:
    estimate = memory_of(load_case(case(*FINE)))
    for share in (1.1, 0.9, 0.1):
        available = AvailableMemory(share * estimate.total, 1e12, "memory of the machine")
        if share < 0.5:  # not even the points fit
            with pytest.raises(BadInput, match=r"needs about .* is available"):
                require_memory_to_check(estimate, available)
            continue
        text = require_memory_to_check(estimate, available)
        assert (text is None) == (share > 1.0)
        assert text is None or "unknown" not in text


@pytest.mark.slow
@pytest.mark.parametrize(
    "megabytes", [*map(long, (120, 285, 300, 310, 320, 330, 340, 350, 370, 380, 400)), 360]
)
def test_run_out_of_memory_is_resumed_with_the_same_bits(
    case: Callable[..., Path], tmp_path: Path, megabytes: int
) -> None:
    run_limited_and_resume(case(*FINE), tmp_path, megabytes)


def run_limited_and_resume(file: Path, tmp_path: Path, megabytes: int) -> None:
    folder = tmp_path / "limited"
    done = limited(
        megabytes, "run", file, "--out", folder, "--threads", "1", "--quiet",
        "--memory-limit", "1TB",
    )  # fmt: skip
    if done.returncode == 0:
        return
    text = message_of(done)
    if not (folder / CHECKPOINT).exists():
        return
    assert f"tilth resume {folder}" in text
    assert limited(100_000, "resume", folder, "--quiet").returncode == 0
    whole = tmp_path / "whole"
    assert limited(100_000, "run", file, "--out", whole, "--quiet").returncode == 0
    require_same(folder, whole)


IN_PARALLEL = """
import re, resource
from pathlib import Path
import numpy as np
from tilth import _core
_core.set_threads(2)
_core.set_parallel_from(0)
nodes = 1_000_000
start = np.arange(0, nodes + 1, 8)
node = ((np.arange(nodes) * 7919) % nodes).astype(np.int32)
_core.block_pattern(nodes, start, node)  # starts the threads
for megabytes in range(1, 80, 6):
    size = int(re.search(r"VmSize:\\s+(\\d+)", Path("/proc/self/status").read_text()).group(1))
    limit = size * 1024 + megabytes * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
    try:
        _core.block_pattern(nodes, start, node)
    except MemoryError:
        print("MemoryError")
"""
"""The fewest megabytes fail before the parallel loop, more of them in a thread of it."""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs Linux' list of sizes")
def test_failed_allocation_in_a_parallel_loop_is_a_memory_error() -> None:
    done = subprocess.run(
        [sys.executable, "-c", IN_PARALLEL],
        capture_output=True, text=True, check=False, timeout=100,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines().count("MemoryError") > 3
