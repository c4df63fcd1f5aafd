# SPDX-License-Identifier: BSD-3-Clause
"""The time that `tilth check` estimates over that of the steps: `run_time.py [EXAMPLE]...`.

Both are processor times on one thread.
"""

from __future__ import annotations

import sys
import time

from measure import machine

from tilth.analysis.run import set_threads
from tilth.analysis.run_time import run_time_of
from tilth.analysis.staged import StagedAnalysis
from tilth_verification.cases import example

EXAMPLES = (
    "end_loaded_cantilever", "strip_footing", "slope", "cone_penetration", "excavation",
    "seabed_pipe", "square_footing",
)  # fmt: skip


def main() -> None:
    set_threads(1)
    print(machine(), "\n")
    print(f"{'example':<24}{'steps':>6}{'measured':>10}{'estimate':>11}{'actual':>11}{'ratio':>8}")
    for name in sys.argv[1:] or EXAMPLES:
        model = example(name)
        estimate = run_time_of(model, time.process_time)
        assert estimate is not None
        analysis = StagedAnalysis(model)
        analysis.begin()
        begin = time.process_time()
        steps = sum(1 for _ in analysis.steps())
        actual = time.process_time() - begin
        print(
            f"{name:<24}{steps:>6}{estimate.measured:>10}{estimate.seconds:>9.2f} s{actual:>9.2f} s"
            f"{estimate.seconds / actual:>8.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
