# SPDX-License-Identifier: BSD-3-Clause
"""Runs a case with this source tree and with another one in turn: `paired_run.py OTHER`.

OTHER is the folder `src` of another commit, with its compiled core in `tilth`. Prints wall-clock
and processor time of each run of `tilth run`, Newton iterations, the tracked quantities at the end,
and the medians of the ratios of the pairs.
"""

from __future__ import annotations

import argparse
import csv
import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "square_footing" / "case.toml"


@dataclass(frozen=True)
class Run:
    """One run of a case.

    Attributes:
        wall, processor: time of the whole command [s].
        iterations: Newton iterations of all steps.
        last: tracked quantities at the end, by the names of their columns.
    """

    wall: float
    processor: float
    iterations: int
    last: dict[str, float]


def run(source: Path, case: Path, threads: int) -> Run:
    """Runs a case with the package in `source`."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "tilth", "run", str(case), "--out", folder, "--overwrite"]
        command += ["--quiet", "--threads", str(threads)]
        began = time.perf_counter()
        process = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": str(source)})
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - began
        if status:
            sys.exit(f"the run with {source} failed")
        rows = list(csv.DictReader((Path(folder) / "history.csv").read_text().splitlines()))
    tracked = {name: float(rows[-1][name]) for name in rows[-1] if name.endswith("]")}
    iterations = sum(int(row["iterations"]) for row in rows)
    return Run(wall, usage.ru_utime + usage.ru_stime, iterations, tracked)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("other", type=Path)
    parser.add_argument("--case", type=Path, default=CASE)
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--pairs", type=int, default=3)
    given = parser.parse_args()
    ratios = []
    for _ in range(given.pairs):
        pair = [run(tree, given.case, given.threads) for tree in (ROOT / "src", given.other)]
        for name, each in zip(("this", "other"), pair, strict=True):
            tracked = ", ".join(f"{key} {value:.6g}" for key, value in each.last.items())
            print(
                f"{name:6} {each.wall:8.1f} s, processor {each.processor:8.1f} s, "
                f"{each.iterations} iterations; {tracked}"
            )
        ratios.append((pair[0].wall / pair[1].wall, pair[0].processor / pair[1].processor))
    wall, processor = (statistics.median(each) for each in zip(*ratios, strict=True))
    print(f"this over other: wall {wall:.2f}, processor {processor:.2f}")


if __name__ == "__main__":
    main()
