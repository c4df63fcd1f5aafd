# SPDX-License-Identifier: BSD-3-Clause
"""Whether a change of the code leaves all results as they are, to the bit.

    python benchmarks/same_bits.py record FOLDER
    python benchmarks/same_bits.py compare FOLDER

`record`, before the change, stores digests of this source tree's results in FOLDER; `compare`,
after it, computes them again, prints which differ, and exits with 1 if any does. Each result is

* a row of `tilth verify` without `--long`: the computed value as text;
* `history.csv`, `boundaries.csv` and each data set of `results.vtkhdf` of the first two steps of an
  example;
* the same of the examples `PROCESSES` on two processes, where TILTH_MPI_PYTHON names a Python with
  mpi4py and petsc4py.

Each program has one thread; `--jobs` of them run at a time. `--only PART...` takes some of the
parts, `--matching TEXT` the problems and examples with this text in their names. For the time of a
change see `paired_run.py`.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np

from tilth_verification.problems import PROBLEMS

ROOT = Path(__file__).resolve().parent.parent
STEPS = 2
PROCESSES = ("rigid_sphere/three_dimensional", "square_footing/case", "buried_pipe/case")
TABLES = ("history.csv", "boundaries.csv")
PARTS = ("verify", "examples", "processes")
FIRST_STEPS = """
import sys
from tilth import load_case, run
model = load_case(sys.argv[1])
output = model.output.model_copy(update={"report": False})
until = model.schedule.regular_time(int(sys.argv[3]))
run(model.model_copy(update={"output": output}), sys.argv[2], threads=1, until=until, quiet=True)
"""
"""Arguments: case file, folder, number of steps."""

Digests = dict[str, str]


def examples() -> dict[str, Path]:
    """Case files of analyses, by folder and name."""
    cases = sorted((ROOT / "examples").glob("*/*.toml"))
    analyses = [each for each in cases if "[[tests]]" not in each.read_text(encoding="utf-8")]
    return {f"{each.parent.name}/{each.stem}": each for each in analyses}


def output_of(command: list[str], python: str = sys.executable) -> tuple[str, str]:
    """Returns what a program of this source tree printed; its last line of errors if it failed."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(ROOT / "src"),
        "OMP_NUM_THREADS": "1",
        "OMP_WAIT_POLICY": "passive",
    }
    launcher = ["mpiexec", "-n", "2"] if python != sys.executable else []
    done = subprocess.run(
        [*launcher, python, *command], env=environment, capture_output=True, text=True, check=False
    )
    errors = done.stderr.strip().splitlines() or [""]
    return done.stdout, errors[-1] if done.returncode else ""


def verified(problem: str) -> Digests:
    """Returns the computed values of a problem's rows; that a row misses its tolerance is none."""
    printed, error = output_of(["-m", "tilth", "verify", problem, "--json"])
    if not printed:
        return {f"verify: {problem}: error": error}
    rows = json.loads(printed)
    return {f"verify: {problem}: {row['quantity']}": repr(row["computed"]) for row in rows}


def first_steps(name: str, case: Path, python: str = sys.executable) -> Digests:
    """Returns the digests of the results of an example's first steps."""
    part = "examples" if python == sys.executable else "processes"
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "out"
        _, error = output_of(["-c", FIRST_STEPS, str(case), str(folder), str(STEPS)], python)
        found = {"error": error} if error else {}
        for table in TABLES:
            if (folder / table).exists():
                found[table] = digest((folder / table).read_bytes())
        if (folder / "results.vtkhdf").exists():
            found |= dict(datasets(folder / "results.vtkhdf"))
    return {f"{part}: {name}: {result}": value for result, value in found.items()}


def datasets(file: Path) -> Iterator[tuple[str, str]]:
    """Yields name and digest of each data set of a results file."""
    names: list[str] = []
    with h5py.File(file) as results:
        results.visit(names.append)
        for name in names:
            if isinstance(results[name], h5py.Dataset):
                yield name, digest(np.asarray(results[name][()]).tobytes())


def digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def tasks(parts: list[str], matching: str) -> Iterator[Callable[[], Digests]]:
    """Yields what computes the digests of one problem or example."""
    if "verify" in parts:
        for problem in PROBLEMS:
            if matching in problem:
                yield lambda problem=problem: verified(problem)
    cases = {name: case for name, case in examples().items() if matching in name}
    python = os.environ.get("TILTH_MPI_PYTHON")
    if "processes" in parts and python:
        for name in PROCESSES:
            if name in cases:
                yield lambda name=name: first_steps(name, cases[name], python)
    if "examples" in parts:
        for name, case in cases.items():
            yield lambda name=name, case=case: first_steps(name, case)


def computed(parts: list[str], matching: str, jobs: int) -> Digests:
    """Returns the digests of all results, by part, problem or example, and result."""
    found: Digests = {}
    with ThreadPoolExecutor(jobs) as pool:
        for number, each in enumerate(pool.map(lambda task: task(), tasks(parts, matching)), 1):
            found |= each
            progress = f"\r{number} problems and examples, {len(found)} results"
            print(progress, end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("action", choices=("record", "compare"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--matching", default="")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    given = parser.parse_args()
    if "processes" in given.only and "TILTH_MPI_PYTHON" not in os.environ:
        print("without several processes: TILTH_MPI_PYTHON is not set")
    file = given.folder / "digests.json"
    if given.action == "compare" and not file.exists():
        sys.exit(f"{file} does not exist: run `record` before the change")
    now = computed(given.only, given.matching, given.jobs)
    if given.action == "record":
        given.folder.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(now, indent=0))
        return
    recorded: Digests = json.loads(file.read_text())
    before = {name: value for name, value in recorded.items() if same_part(name, given)}
    differing = [name for name in before | now if before.get(name) != now.get(name)]
    for name in differing:
        print(f"{name}: {before.get(name, 'not there')[:30]} -> {now.get(name, 'not there')[:30]}")
    print(f"{len(now)} results, {len(differing)} differ")
    sys.exit(bool(differing))


def same_part(name: str, given: argparse.Namespace) -> bool:
    """Whether a recorded result is among those that the options select."""
    part, of, _ = name.split(": ", 2)
    return part in given.only and given.matching in of


if __name__ == "__main__":
    main()
