# SPDX-License-Identifier: BSD-3-Clause
"""What a user waits for: `tilth run` of the end-loaded cantilever from its start to its end.

Processor time of the command and its children, report and checkpoints included, one thread; the
same without report, and without checkpoints in addition; and of `tilth --version`. Medians of runs
in turn: `whole_run.py [REPEATS]`.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from measure import machine, median, spawn

from tilth_verification.cases import folder_of_cases

VARIANTS = {
    "tilth run, report included": "",
    "without report": "report = false\n",
    "without report and checkpoints": "report = false\ncheckpoint_every = 0\n",
}


def main() -> None:
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    print(machine(), "\n")
    case = (folder_of_cases() / "end_loaded_cantilever" / "case.toml").read_text(encoding="utf-8")
    names = [*VARIANTS, "tilth --version"]
    taken: dict[str, list[tuple[float, float]]] = {name: [] for name in names}
    with tempfile.TemporaryDirectory() as place:
        for name, more in VARIANTS.items():
            text = case.replace("[output]\n", f"[output]\n{more}")
            Path(place, f"{len(name)}.toml").write_text(text, encoding="utf-8")
        for _ in range(repeats):
            for name in taken:
                arguments = ["--version"]
                if name in VARIANTS:
                    options = ["--threads", "1", "--overwrite", "--quiet"]
                    arguments = ["run", f"{len(name)}.toml", *options]
                usage, _ = spawn([sys.executable, "-m", "tilth", *arguments], 1, Path(place))
                taken[name].append((usage.processor, usage.wall))
    print(f"{'':<34}{'processor':>11}{'wall':>9}")
    for name, times in taken.items():
        processor, wall = (median(each) for each in zip(*times, strict=True))
        print(f"{name:<34}{processor:>9.2f} s{wall:>7.2f} s")


if __name__ == "__main__":
    main()
