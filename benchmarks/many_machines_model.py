# SPDX-License-Identifier: BSD-3-Clause
"""What a process of a run on several machines stores, sends and computes a step, on paper.

The formulas are those of docs/theory/many_machines.md. Without arguments it prints its tables.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, prod

from tilth.mpm.distribution import LAYERS
from tilth.solvers.coarse_correction import LARGEST_COARSE_NODES

MESSAGE = 2200
"""Bytes that the messages of a step to one neighbour have besides values (names, shapes)."""

TEMPORARY = 18 * 8
"""Bytes per point of temporary arrays (src/tilth/analysis/memory.py)."""

LEVELS = 8.5 / 8
"""Memory of the levels of multigrid, relative to the matrix (src/tilth/analysis/memory.py)."""


def state_bytes(
    dim: int, variables: int = 0, inertia: bool = False, cpdi: int = 0, varying: int = 0
) -> int:
    """Bytes of the state of a material point: the arrays of `MaterialPoints`.

    variables: state variables of the law. cpdi: 1 or 2 for CPDI1 or CPDI2. varying: parameters of
    the law, if they vary from point to point.
    """
    numbers = 27 + 5 * dim + dim**2 + variables + varying
    numbers += 3 * dim if inertia else 0
    numbers += 2**dim * dim if cpdi else 0
    numbers += dim**2 if cpdi == 1 else 0
    return 8 * numbers


@dataclass(frozen=True)
class Part:
    """The box of cells of one process, full of soil.

    Attributes:
        cells: along each axis.
        lower, upper: whether there is another process at either end of each axis.
        per_cell: points in a cell.
        reach: cells that the domains of points reach beyond their own; 0 with the linear basis.
    """

    cells: tuple[float, ...]
    lower: tuple[bool, ...]
    upper: tuple[bool, ...]
    per_cell: float = 8.0
    reach: int = 0

    @classmethod
    def inside(cls, points: float, per_cell: float = 8.0, dim: int = 3, reach: int = 0) -> Part:
        """A cube with so many points and neighbours on all sides."""
        side = (points / per_cell) ** (1.0 / dim)
        return cls((side,) * dim, (True,) * dim, (True,) * dim, per_cell, reach)

    @property
    def dim(self) -> int:
        return len(self.cells)

    @property
    def points(self) -> float:
        return self.per_cell * prod(self.cells)

    @property
    def copies(self) -> float:
        """Points of other processes that it has copies of."""
        layers = LAYERS + self.reach
        sides = [s + layers * (a + b) for s, a, b in self._axes()]
        return self.per_cell * (prod(sides) - prod(self.cells))

    @property
    def owned_nodes(self) -> float:
        return prod(s + (0 if above else 1) for s, _, above in self._axes())

    @property
    def nodes(self) -> float:
        """Nodes that it has, those of other processes included."""
        layers = LAYERS + self.reach
        return prod(s + layers * (a + b) + 1 + self.reach * (a + b) for s, a, b in self._axes())

    @property
    def neighbours(self) -> int:
        return prod(1 + a + b for _, a, b in self._axes()) - 1

    def coarse_nodes(self, width: int) -> float:
        """Coarse nodes, so many cells apart, that its nodes depend on; the mean over all places."""
        layers = LAYERS + 2 * self.reach
        return prod(_coarse(s + layers * (a + b), width, a) for s, a, b in self._axes())

    def coarse_entries(self, width: int) -> float:
        """Blocks of the coarse matrix that the rows of its own nodes contribute to.

        Without `reach`, in which nodes are coupled with their neighbours alone.
        """
        return prod(
            3 * _coarse(s - (1 if b else 0), width, a) - 2 + (a + b) / width
            for s, a, b in self._axes()
        )

    def _axes(self) -> list[tuple[float, bool, bool]]:
        return list(zip(self.cells, self.lower, self.upper, strict=True))


def _coarse(length: float, width: int, anywhere: bool) -> float:
    """Coarse nodes of a line of nodes over so many cells, which begins anywhere or at a node."""
    return length / width + (width - 1) / width + 1 if anywhere else ceil(length / width) + 1


def coarse_width(cells: float, dim: int = 3) -> tuple[int, int]:
    """Cells between two coarse nodes, and the number of these, in a block so many cells long."""
    width = 2
    while (nodes := (ceil(cells / width) + 1) ** dim) > LARGEST_COARSE_NODES:
        width *= 2
    return width, nodes


@dataclass(frozen=True)
class Step:
    """A load step of quasi-static soil on grid planes.

    Attributes:
        part: of the process.
        iterations: of Newton.
        krylov: iterations of the linear solver a system, in the mean.
        fills: matrices of which new levels of multigrid are made.
        processes: of the run.
        width: cells between two nodes of the coarse grid that all processes have.
        guessed: whether the step has a first guess of the displacement.
        state: bytes of a point.
    """

    part: Part
    iterations: int = 3
    krylov: float = 20
    fills: int = 3
    processes: int = 1000
    width: int = 32
    guessed: bool = True
    state: int = state_bytes(3)

    def sent(self) -> dict[str, float]:
        """Bytes that the process sends in a step, by what they are for.

        They are those that `Communicator.sent` counts, in the mean over the processes.
        """
        part, dim = self.part, self.part.dim
        copied = part.nodes - part.owned_nodes
        per_node = 2 * (8 + 8)  # keys and numbers, with and without the nodes of boundaries
        per_node += 2 * 8 * dim  # which boundary holds a node, and its motion
        per_node += 8 * dim * (self.iterations + self.guessed)
        return {
            "copies of points": part.copies * self.state,
            "nodal values": copied * per_node,
            "headers": float(MESSAGE * part.neighbours),
            "linear solver": copied * (8 + 8 * dim * (2 * self._corrections + self.iterations)),
            "coarse residuals": self._corrections * self._to_all(part.coarse_nodes, dim),
            "coarse matrices": self.fills * self._to_all(part.coarse_entries, dim**2),
        }

    @property
    def _corrections(self) -> float:
        return self.iterations * self.krylov

    def _to_all(self, count: Callable[[int], float], numbers: int) -> float:
        return 8 * numbers * count(self.width) * (self.processes - 1)

    @property
    def messages(self) -> float:
        """Messages from the process to each of the others for the coarse grid."""
        return self._corrections + self.fills

    def memory(self, trial: int = 352, stencil: int = 37) -> dict[str, float]:
        """Bytes that the process stores, by what they are for; the program itself not counted.

        trial, stencil: of a point (docs/theory/engine.md); those of the linear basis in 3D.
        """
        part, dim = self.part, self.part.dim
        row = (2 * (1 + part.reach) + 1) ** dim  # blocks
        matrix = part.nodes * row * 8 * dim**2
        return {
            "points": (part.points + part.copies) * (self.state + trial + stencil + TEMPORARY),
            "exchange": 2.0 * part.copies * self.state,
            "matrix": 1.125 * matrix,
            "multigrid": LEVELS * matrix,
            "Krylov method": (2 * self.krylov + 3) * part.owned_nodes * 8 * dim,
            "coarse matrices": self._to_all(part.coarse_entries, dim**2),
        }

    @property
    def work(self) -> float:
        """Points whose stress and stiffness it computes, relative to those that it owns."""
        return 1.0 + self.part.copies / self.part.points


def boundary_bytes(points: float, dim: int = 3) -> float:
    """Bytes that each process receives in a step of a boundary with so many points near soil."""
    return points * 8 * (7 + dim)


def _table(total: float, processes: list[int]) -> None:
    print(f"{total:.0e} points, 8 a cell, linear basis, 3 Newton and 20 Krylov iterations")
    width, nodes = coarse_width((total / 8.0) ** (1 / 3))
    print(f"coarse grid of all: cells {width} times as large, {nodes:,} nodes")
    print(
        "processes | points | copies | work | sent [MB]: points, nodal, solver, coarse residuals, "
        "coarse matrices | messages | memory [GB]"
    )
    for number in processes:
        step = Step(Part.inside(total / number), processes=number, width=width)
        sent = {name: value / 1e6 for name, value in step.sent().items() if name != "headers"}
        print(
            f"{number:,} | {total / number:,.0f} | {step.part.copies:,.0f} | {step.work:.2f} | "
            + ", ".join(f"{value:.1f}" for value in sent.values())
            + f" | {step.messages * (number - 1):,.0f} | {sum(step.memory().values()) / 1e9:.2f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=float, default=1e9)
    parser.add_argument("--processes", type=int, nargs="+", default=[1000, 2000, 8000, 64000])
    arguments = parser.parse_args()
    _table(arguments.points, arguments.processes)


if __name__ == "__main__":
    main()
