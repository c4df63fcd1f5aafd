# SPDX-License-Identifier: BSD-3-Clause
"""Strong and weak scaling over the processes of `mpiexec`: `many_machines.py [--points N] ...`.

A long block of clay, perfectly plastic below a plate at its end, in 3D. Strong: the same block by
more processes. Weak: a block as much longer as there are more processes. For each run the wall
time by phase, of the slowest process; the efficiency, which is the time that one process would
take over that of all processes together, with and without the linear solver; the largest memory
of a process after the steps, over the mean, and its peak, when it reads the whole model; the bytes
that a process sends in a step.

One process runs twice: as any serial run, and with the solver of several processes.

It needs mpi4py, petsc4py and mpiexec (docs/howto/many_machines.md). Processes should not be more
than the cores of the machine: others would only take turns.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from measure import machine, spawn
from own_process import peak_memory

import tilth
from tilth.analysis.simulation import Simulation
from tilth.comm import Communicator
from tilth.mpi import world
from tilth.solvers import PetscSolver

ACROSS = 12
"""Cells over the height and the width of the block."""

PHASES = ("basis", "boundaries", "assembly", "stress", "solve", "other")
"""Parts of the time of a step; "exchange" is a part of the others."""

MPIEXEC = ["mpiexec", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n"]


def block(cells: int) -> tilth.Model:
    """A block so many cells long, eight points in each cell, with a plate on its first cells."""
    size, wide = 1.0, ACROSS // 3
    return tilth.Model(
        title="Block on several processes",
        analysis=tilth.Analysis(kind="3d", tolerance=1e-6),
        grid=tilth.Grid(cell_size=size),
        materials={
            "clay": tilth.VonMises(
                young_modulus=1e7, poisson_ratio=0.48, yield_stress=1e5, hardening_modulus=0
            )
        },
        bodies=[
            tilth.Body(
                name="clay", material="clay", basis="linear", points_per_cell=2,
                anti_locking="f_bar",
                shape=tilth.Box(lower=[0, 0, 0], upper=[cells * size, ACROSS, ACROSS]),
            )
        ],
        boundaries=[
            *(
                tilth.PlaneBoundary(name=axis, axis=axis, at=0, condition="roller")
                for axis in "xyz"
            ),
            tilth.PlaneBoundary(name="end", axis="x", at=cells * size, condition="roller"),
            tilth.PlaneBoundary(name="side", axis="y", at=ACROSS, condition="roller"),
            tilth.PlaneBoundary(
                name="plate", axis="z", at=ACROSS, condition="prescribed",
                range={"x": [0, wide], "y": [0, wide]}, displacement={"z": -0.2},
            ),
        ],
        schedule=tilth.Schedule(steps=4, outputs=1),
        output=tilth.Output(checkpoint_every=0, report=False),
    )  # fmt: skip


class Timed:
    """A communicator that measures how long its messages take, and waiting for them.

    Attributes:
        seconds: so far.
    """

    def __init__(self, comm: Communicator) -> None:
        self._comm, self.seconds = comm, 0.0

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._comm, name)
        if not callable(found) or name == "mpi":
            return found

        def timed(*arguments: Any) -> Any:
            begin = time.perf_counter()
            result = found(*arguments)
            self.seconds += time.perf_counter() - begin
            return result

        return timed


def measured(cells: int, steps: int, petsc: bool) -> None:
    """Runs in each process; process 0 prints what was measured, as JSON.

    The first step is not counted: there memory is taken for the first time.
    """
    comm = Timed(world())
    simulation = Simulation(block(cells))
    simulation.check()
    simulation.distribute(comm)  # type: ignore[arg-type]
    if petsc:
        simulation.services.solver = PetscSolver("multigrid")
    times = [step / 4 for step in range(steps + 2)]
    simulation.advance(*times[:2])
    simulation.services.timers.wall.clear()
    comm.seconds, sent, iterations = 0.0, comm.sent, 0
    begin = time.perf_counter()
    for before, after in pairwise(times[1:]):
        iterations += simulation.advance(before, after).equilibrium.iterations
    phases = {"total": time.perf_counter() - begin, **simulation.services.timers.wall}
    phases["exchange"] = comm.seconds
    own = {
        "phases": {name: seconds / steps for name, seconds in phases.items()},
        "memory": present_memory(),
        "peak": peak_memory(),
        "sent": (comm.sent - sent) / steps,
        "points": len(simulation.state.points),
        "iterations": iterations,
        "linear": simulation.services.solver.summary,
    }
    found = comm.gathered(own)
    if comm.rank == 0:
        print(json.dumps(found))


def present_memory() -> float:
    """The memory that the process has now [byte]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024.0 * float(next(line for line in lines if line.startswith("VmRSS")).split()[1])


@dataclass(frozen=True)
class Run:
    """What the processes of a run measured.

    Attributes:
        phases: largest seconds a step of a process by phase.
        memory: of the processes at the end of the last step [byte].
        peak: largest of a process since its start, when it reads the whole model [byte].
        sent: mean bytes that a process sends in a step.
        copies: points that processes have besides their own, over all points.
        iterations: of Newton.
        linear: summary of the linear solver.
    """

    phases: dict[str, float]
    memory: list[float]
    peak: float
    sent: float
    copies: float
    iterations: int
    linear: str

    @property
    def without_solver(self) -> float:
        """Seconds a step besides the linear solver."""
        return self.phases["total"] - self.phases["solve"]


def run(processes: int, cells: int, steps: int, petsc: bool = False) -> Run:
    """Runs so many processes with one thread each."""
    script = [sys.executable, str(Path(__file__)), "--inside", str(cells), "--steps", str(steps)]
    launch = [*MPIEXEC, str(processes)] if processes > 1 else []
    _, printed = spawn([*launch, *script, *(["--petsc"] if petsc else [])], threads=1)
    found = json.loads(printed.splitlines()[-1])
    names = ("total", "exchange", *PHASES)
    return Run(
        {name: max(each["phases"].get(name, 0.0) for each in found) for name in names},
        [each["memory"] for each in found],
        max(each["peak"] for each in found),
        sum(each["sent"] for each in found) / processes,
        sum(each["points"] for each in found) / (8.0 * cells * ACROSS**2) - 1.0,
        found[0]["iterations"],
        found[0]["linear"],
    )


def table(counts: list[int], cells: int, steps: int, weak: bool) -> None:
    """Prints the runs of one kind of scaling."""
    print(f"\n{'weak' if weak else 'strong'} scaling; seconds a step")
    print(f"{'processes':16}{'points':>10}" + "".join(f"{name:>11}" for name in PHASES)
          + f"{'total':>9}{'exchange':>10}{'eff. all':>10}{'no solve':>10}{'solve':>7}"
          + f"{'memory':>10}{'max/mean':>10}{'peak':>10}{'copies':>8}{'sent':>10}")  # fmt: skip
    first: Run | None = None
    for processes, petsc in [(1, False), *((count, True) for count in counts)]:
        long = cells * processes if weak else cells
        found = run(processes, long, steps, petsc)
        if first is None or processes == 1:
            first = found
        work = 1.0 if weak else 1.0 / processes

        def efficiency(one: float, all_: float, work: float = work) -> str:
            return f"{100 * one * work / all_:.0f} %" if all_ > 0 else "-"

        name = f"{processes}{'' if petsc else ' (serial solver)'}"
        mean = sum(found.memory) / len(found.memory)
        print(
            f"{name:16}{8 * long * ACROSS**2:>10,}"
            + "".join(f"{found.phases[phase]:>11.3f}" for phase in PHASES)
            + f"{found.phases['total']:>9.3f}{found.phases['exchange']:>10.3f}"
            + f"{efficiency(first.phases['total'], found.phases['total']):>10}"
            + f"{efficiency(first.without_solver, found.without_solver):>10}"
            + f"{efficiency(first.phases['solve'], found.phases['solve']):>7}"
            + f"{max(found.memory) / 1e6:>7.0f} MB{max(found.memory) / mean:>10.2f}"
            + f"{found.peak / 1e6:>7.0f} MB"
            + f"{100 * found.copies:>6.0f} %{found.sent / 1e6:>7.1f} MB",
            flush=True,
        )
        print(f"{'':16}{found.iterations} Newton iterations; {found.linear}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=200_000, help="of the strong scaling")
    parser.add_argument("--steps", type=int, default=2, help="that are measured, up to 3")
    parser.add_argument("--processes", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--inside", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--petsc", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.inside:
        measured(given.inside, given.steps, given.petsc)
        return
    print(f"{machine()}, {os.cpu_count()} cores")
    cells = max(2, round(given.points / (8 * ACROSS**2)))
    table(given.processes, cells, given.steps, weak=False)
    table(given.processes, max(2, cells // max(given.processes)), given.steps, weak=True)


if __name__ == "__main__":
    main()
