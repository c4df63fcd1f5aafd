# SPDX-License-Identifier: BSD-3-Clause
"""Runs in a process with too little memory: one message, and a resumed run with the same bits."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tilth.analysis.available_memory import AvailableMemory
from tilth.analysis.memory import memory_of, require_memory_to_check
from tilth.case import load_case
from tilth.errors import BadInput
from tilth.output import read_checkpoint
from tilth.output.folder import CHECKPOINT, HISTORY

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
    assert len(text.strip().splitlines()) == 2  # what happened, and the remedy
    return text


def test_what_does_not_fit_is_refused_before_the_run(case: Callable[..., Path]) -> None:
    file = case(*FINE)
    done = limited(300, "run", file)
    assert done.returncode == 2
    text = message_of(done)
    assert "RLIMIT_AS of the process (`ulimit -v`)" in text
    assert "unknowns" in text
    assert "--memory-limit" in text
    assert not file.with_suffix("").exists()


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
@pytest.mark.parametrize("megabytes", [150, 250, 350, 400, 425, 450, 475, 500, 525, 550, 575, 600])
def test_run_out_of_memory_is_resumed_with_the_same_bits(
    case: Callable[..., Path], tmp_path: Path, megabytes: int
) -> None:
    file, folder = case(*FINE), tmp_path / "limited"
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
    (resumed, _), (expected, _) = (read_checkpoint(f / CHECKPOINT) for f in (folder, whole))
    assert resumed.keys() == expected.keys()
    for name, array in expected.items():
        np.testing.assert_array_equal(resumed[name], array, err_msg=name)
    assert (folder / HISTORY).read_bytes() == (whole / HISTORY).read_bytes()
