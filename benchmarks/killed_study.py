# SPDX-License-Identifier: BSD-3-Clause
"""Kills a study again and again, and compares its table with that of one that ran through.

`python benchmarks/killed_study.py [STUDY.toml] [--kills 2] [--processes 2] [--out DIR]`
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

EXAMPLE = Path(__file__).parents[1] / "examples/random_field_slope/studies/monte_carlo.toml"


def complete(folder: Path) -> int:
    """The number of samples that are complete."""
    return len(list(folder.glob("samples/*/outcome.json")))


def started(study: Path, folder: Path, processes: int) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "tilth", "study", str(study), "--out", str(folder)]
    return subprocess.Popen([*command, "--processes", str(processes), "--quiet"])


def kill_at(study: Path, folder: Path, processes: int, samples: int) -> int:
    """Runs a study until so many samples are complete, and kills it; returns how many then are."""
    process = started(study, folder, processes)
    while complete(folder) < samples and process.poll() is None:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    return complete(folder)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", nargs="?", type=Path, default=EXAMPLE)
    parser.add_argument("--kills", type=int, default=2)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    out = given.out or Path(tempfile.mkdtemp(prefix="killed_study_"))
    whole, killed = out / "whole", out / "killed"
    began = time.perf_counter()
    code = started(given.study, whole, given.processes).wait()
    count = complete(whole)
    print(f"{count} samples, exit code {code}, {time.perf_counter() - began:.0f} s")
    for kill in range(1, given.kills + 1):
        done = kill_at(given.study, killed, given.processes, kill * count // (given.kills + 1))
        print(f"killed with {done} of {count} samples complete")
    code = started(given.study, killed, given.processes).wait()
    same = (whole / "study.csv").read_bytes() == (killed / "study.csv").read_bytes()
    print(f"exit code {code}, tables {'identical' if same else 'DIFFERENT'}")
    sys.exit(0 if same else 1)


if __name__ == "__main__":
    main()
