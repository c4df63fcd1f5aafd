# SPDX-License-Identifier: BSD-3-Clause
"""Changed case files of the examples: `tilth check` of all, the first steps of the small ones."""

from __future__ import annotations

import math
import shutil
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from example_cases import ANALYSES, EXAMPLES

from fuzz.fewer_lines import fewest_lines
from fuzz.mutations import Tree, changed_bytes, changed_tree
from fuzz.oracle import inspect_results
from fuzz.sandbox import Job
from fuzz.special_files import file_case

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

SMALL = (
    "collapse/case", "cooks_membrane/case",
    "end_loaded_cantilever/turned", "generalized_shear/turn", "inclined_column/case",
    "oedometer/axisymmetric", "plane_strain_block/case", "plane_strain_block/three_dimensional",
    "pressure_cantilever/case", "rigid_sphere/case", "self_weight_column/von_mises",
    "submerged_block/case", "submerged_block/rising_water", "thick_cylinder/widened", "slope/case",
)  # fmt: skip
"""Case files with less than about a second for a load step."""
CHECK_SECONDS, RUN_SECONDS = 10.0, 30.0

OF_FILES = 0.2
"""Share of the checks of cases with a body from a damaged file."""


@cache
def _trees() -> dict[str, Tree]:
    """The entries of the case file of every example that is an analysis."""
    return {
        str(f.relative_to(EXAMPLES))[:-5]: tomllib.loads(f.read_text("utf-8")) for f in ANALYSES
    }


def case_jobs(command: str, seed: int, numbers: Iterable[int], work: Path) -> Iterator[Job]:
    """Yields `check` or `run` of changed case files, one for each number."""
    for number in numbers:
        name = f"{command}-{seed}-{number}"
        random = Random(f"files of {name}")
        if command == "check" and random.random() < OF_FILES:
            job = case_job(command, name, next(iter(SMALL)), b"", work)
            inputs = job.folder / "input"
            (inputs / "case.toml").write_bytes(file_case(inputs, random))
            yield job
            continue
        example, content = changed_case(command, Random(name))
        yield case_job(command, name, example, content, work)


def changed_case(command: str, random: Random) -> tuple[str, bytes]:
    """Returns an example's name, and its case file with random changes."""
    trees = _trees()
    example = random.choice(SMALL if command == "run" else list(trees))
    if random.random() < (0.05 if command == "run" else 0.15):
        return example, changed_bytes((EXAMPLES / f"{example}.toml").read_bytes(), random)
    mild = command == "run" or random.random() < 0.4
    text = changed_tree(trees[example], list(trees.values()), random, mild)
    return example, text.encode("utf-8", errors="surrogatepass")


def case_job(command: str, name: str, example: str, content: bytes, work: Path) -> Job:
    """Writes a case file and those that it names; returns the job that checks or runs it."""
    folder = work / name
    shutil.rmtree(folder, ignore_errors=True)
    inputs = folder / "input"
    inputs.mkdir(parents=True)
    for file in (EXAMPLES / example).parent.iterdir():
        if file.suffix in (".stl", ".py"):
            shutil.copy(file, inputs)
    case = inputs / "case.toml"
    case.write_bytes(content)
    if command == "check":
        arguments = ["check", str(case), "--picture", str(folder / "setup.png")]
        return Job(name, folder, arguments, CHECK_SECONDS, lambda code: [])
    out = folder / "out"
    arguments = ["run", str(case), "--out", str(out), "--threads", "1", "--quiet"]
    arguments += _until(content)

    def inspect(code: int) -> list[str]:
        return inspect_results(out) if code in (0, 1) else []

    return Job(name, folder, arguments, RUN_SECONDS, inspect)


def _until(content: bytes) -> list[str]:
    """Returns the option that stops a run after its third step, where there is one."""
    try:
        schedule = tomllib.loads(content.decode())["schedule"]
        end = float(schedule.get("end", 1.0))
        step = schedule["step_size"] if "step_size" in schedule else end / schedule["steps"]
        until = min(end, 3.0 * float(step))
    except Exception:  # a schedule that tilth refuses
        return []
    return ["--until", repr(until)] if math.isfinite(until) and until > 0.0 else []


def smaller(job: Job, still_fails: Any, work: Path, attempts: int = 120) -> bytes:
    """Returns the case file of a job without the lines that its fault does not need.

    still_fails: is called with a job, returns whether it has the same fault.
    """

    def fails(content: bytes) -> bool:
        other = case_job(job.arguments[0], "smaller", "", content, work)
        for file in (job.folder / "input").iterdir():
            if file.name != "case.toml":
                shutil.copy(file, other.folder / "input")
        return bool(still_fails(other))

    return fewest_lines((job.folder / "input/case.toml").read_bytes(), fails, attempts)
