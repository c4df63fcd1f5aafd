# SPDX-License-Identifier: BSD-3-Clause
"""Share of the report in what a user waits for: processor time of a run and of its report.

    python benchmarks/report_time.py [CASE.toml[:UNTIL] ...]

Each case is run in a process of its own with one thread, from the import of tilth to the end of
the run, up to the time UNTIL of its schedule if it is given.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from measure import machine

CASES = ("seabed_pipe/case.toml:0.05", "self_weight_column/case.toml", "embankment/case.toml:2.0")
RUN = """
import sys, time
from pathlib import Path
import tilth.analysis.run as module
from tilth.case import load_case

taken, write = [], module.write_report

def timed(folder):
    begin = time.process_time()
    found = write(folder)
    taken.append(time.process_time() - begin)
    return found

module.write_report = timed
case, until, folder = sys.argv[1:]
module.run(load_case(case), folder, quiet=True, until=float(until) if until else None)
print(time.process_time(), taken[0], (Path(folder) / "report.html").stat().st_size)
"""


def main() -> None:
    print(machine(), "\n")
    examples = Path(__file__).parents[1] / "examples"
    print(f"{'':<36}{'run':>9}{'report':>10}{'share':>8}{'page':>10}")
    for given in sys.argv[1:] or [str(examples / case) for case in CASES]:
        case, _, until = given.partition(":")
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-c", RUN, case, until, f"{folder}/out"]
            told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        whole, report, size = (float(word) for word in told.split()[-3:])
        name = "/".join(Path(case).parts[-2:])
        share = f"{100.0 * report / whole:.0f} %"
        print(f"{name:<36}{whole:>7.2f} s{report:>8.2f} s{share:>8}{size / 1e6:>7.2f} MB")


if __name__ == "__main__":
    main()
