# SPDX-License-Identifier: BSD-3-Clause
"""The same problems by Kratos MPM and by tilth in one run; see benchmarks/README.md."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from measure import Failed, Usage, machine, median, run_case, spawn, start_up  # noqa: E402
from problems import block, cantilever  # noqa: E402

from peers import ample, kratos_input  # noqa: E402
from peers.environment import (  # noqa: E402
    IMPORTS,
    KratosEnvironment,
    NoPeer,
    kratos_environment,
)

ENVIRONMENT = HERE.parents[1] / "build" / "kratos"


@dataclass(frozen=True)
class Problem:
    """A problem that both codes solve.

    Attributes:
        model: of tilth, from which Kratos' input is written.
        lower, upper: Kratos' background grid [m]; tilth's has no bounds.
        linear_solver: Kratos' linear solver, a name in kratos_input.py.
        tolerance: greatest relative difference of the two answers. The elastic laws differ (Hencky
            in tilth, neo-Hooke in Kratos), by the square of the strain: 1e-4 in the block, 0.2 at
            the root of the cantilever.
    """

    model: Any
    lower: list[float]
    upper: list[float]
    linear_solver: str
    tolerance: float


def cantilever_problem() -> Problem:
    return Problem(cantilever("linear"), [0.0, -8.5], [10.25, 1.25], "sparse_lu", 0.01)


def block_problem(cells: int, linear_solver: str) -> Problem:
    size = [5.0] * 3
    return Problem(block(cells), [0.0] * 3, size, linear_solver, 0.001)


@dataclass(frozen=True)
class Run:
    """One run of one code."""

    usage: Usage
    steps: int
    iterations: int
    points: int
    user_in_steps: float
    peak: int
    answer: float


def run_kratos(problem: Problem, threads: int, environment: KratosEnvironment, folder: Path) -> Run:
    """Runs Kratos on the input files in `folder`.

    Raises:
        Failed: it ended with an error, or did not converge.
    """
    command = [str(environment.python), str(HERE / "kratos_run.py")]
    usage, printed = spawn(command, threads, folder)
    done = json.loads(next(line for line in printed.splitlines() if line.startswith("{")))
    if not done["converged"]:
        raise Failed(f"Kratos does not converge in step {done['steps']}")
    names = ("steps", "iterations", "points", "user_in_steps", "peak", "answer")
    return Run(usage, **{name: done[name] for name in names})


def run_tilth(problem: Problem, threads: int) -> Run:
    case = run_case(problem.model, threads)
    done = case.done
    name = problem.model.track[0].name
    answer = next(v for column, v in done["last"].items() if column.startswith(f"{name} ["))
    names = ("steps", "iterations", "points", "user_in_steps", "peak")
    return Run(case.usage, **{name: done[name] for name in names}, answer=answer)


def compare(
    name: str, problem: Problem, environment: KratosEnvironment, arguments: argparse.Namespace,
    first: dict[str, float],
) -> bool:  # fmt: skip
    """Prints the rows of one problem; returns whether the answers agree."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        kratos_input.write(
            problem.model, folder, problem.lower, problem.upper, problem.linear_solver
        )
        codes: dict[str, Callable[[int], Run]] = {
            f"Kratos ({problem.linear_solver})": lambda threads: run_kratos(
                problem, threads, environment, folder
            ),
            "tilth": lambda threads: run_tilth(problem, threads),
        }
        answers = {}
        for threads in arguments.threads:
            runs: dict[str, list[Run]] = {code: [] for code in codes}
            for _ in range(arguments.repeats):  # in turn: what disturbs one disturbs the other
                for code, run in codes.items():
                    runs[code].append(run(threads))
            for code, found in runs.items():
                print(row(name, code, threads, found, first[code.split()[0]]), flush=True)
                answers[code] = found[0].answer
    theirs, ours = answers.values()
    difference = abs(theirs - ours) / abs(ours)
    agree = difference <= problem.tolerance
    print(
        f"{name}: answers {theirs:.6g} and {ours:.6g} differ by {difference:.1e}, "
        f"allowed {problem.tolerance:g}{'' if agree else ': NOT THE SAME PROBLEM'}\n"
    )
    return agree


def row(name: str, code: str, threads: int, runs: list[Run], first: float) -> str:
    one = runs[0]
    in_steps = median([run.user_in_steps for run in runs])
    cells = [
        str(threads),
        str(one.iterations),
        f"{in_steps / one.iterations:.3f}",
        f"{1e6 * in_steps / one.iterations / one.points:.2f}",
        f"{median([run.usage.user for run in runs]) - first:.2f}",
        f"{median([run.usage.wall for run in runs]):.1f}",
        f"{median([run.peak for run in runs]) / 1e6:.0f}",
    ]
    return f"{name:<12}{code:<20}" + "".join(f"{cell:>11}" for cell in cells)


HEADS = ("threads", "iterations", "s per it.", "us/it./pt", "run [s]", "wall [s]", "peak [MB]")


def arguments_of(line: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--cells", type=int, default=25, help="of the block, along each edge")
    parser.add_argument("--direct", action="store_true", help="block also by Kratos' direct solver")
    parser.add_argument("--only", choices=["cantilever", "block"])
    parser.add_argument("--version", help="of Kratos; the newest on PyPI if not given")
    parser.add_argument("--python", default=sys.executable, help="for the environment of Kratos")
    parser.add_argument("--environment", type=Path, default=ENVIRONMENT, help="its folder")
    return parser.parse_args(line)


def main() -> None:
    arguments = arguments_of()
    try:
        environment = kratos_environment(arguments.environment, arguments.version, arguments.python)
    except NoPeer as reason:
        sys.exit(f"No comparison with Kratos: {reason}")
    print(f"{machine()}\nKratos MPM {environment.version} (PyPI)")
    kratos_start = [
        spawn([str(environment.python), "-c", IMPORTS], 1)[0] for _ in range(arguments.repeats)
    ]
    first = {
        "tilth": median([usage.user for usage in start_up(arguments.repeats)]),
        "Kratos": median([usage.user for usage in kratos_start]),
    }
    print(
        f"user time of the start-up: tilth --version {first['tilth']:.2f} s, "
        f"import of Kratos {first['Kratos']:.2f} s\n"
        f"medians of {arguments.repeats}; user time: s per it. and us per iteration and point in "
        "the load steps,\nrun = whole run less start-up\n"
    )
    print(f"{'problem':<12}{'code':<20}" + "".join(f"{head:>11}" for head in HEADS))
    problems = {"cantilever": [cantilever_problem()]}
    problems["block"] = [block_problem(arguments.cells, "amgcl")]
    if arguments.direct:
        problems["block"].append(block_problem(arguments.cells, "sparse_lu"))
    agree = True
    for name, variants in problems.items():
        for problem in variants:
            if arguments.only in (None, name):
                try:
                    agree &= compare(name, problem, environment, arguments, first)
                except Failed as failure:
                    agree = False
                    print(f"{name}: {failure}\n")
    print(ample.citation())
    sys.exit(0 if agree else 1)


if __name__ == "__main__":
    main()
