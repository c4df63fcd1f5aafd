# SPDX-License-Identifier: BSD-3-Clause
"""What a process of a run on several machines stores, sends and computes a step, on paper.

The formulas are those of docs/theory/many_machines.md. Without arguments it prints its tables.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from math import prod

from tilth.mpm.distribution import LAYERS

MESSAGE = 2200
"""Bytes that the messages of a step to one neighbour have besides values (names, shapes)."""

TEMPORARY = 18 * 8
"""Bytes per point of temporary arrays (src/tilth/analysis/memory.py)."""

AIJ_ENTRY = 12
"""Bytes of an entry of PETSc's matrix: value and column."""

COARSE_LEVELS = 1.5
"""Memory of the levels of algebraic multigrid, relative to the matrix; assumed."""

PRODUCTS = 6
"""Products with the finest matrix in an iteration: the Krylov method's, and those of smoothing."""

COARSE_PRODUCTS = 1.25
"""Messages of all levels of multigrid, relative to those of the finest; assumed."""


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

    def coupled_nodes(self) -> float:
        """Nodes of other processes that are coupled with its own in the matrix."""
        far = 1 + self.reach
        return prod(s + far * (a + b) for s, a, b in self._axes()) - prod(self.cells)

    def _axes(self) -> list[tuple[float, bool, bool]]:
        return list(zip(self.cells, self.lower, self.upper, strict=True))


@dataclass(frozen=True)
class Step:
    """A load step of quasi-static soil on grid planes.

    Attributes:
        part: of the process.
        iterations: of Newton.
        krylov: iterations of the linear solver a system.
        guessed: whether the step has a first guess of the displacement.
        state: bytes of a point.
    """

    part: Part
    iterations: int = 3
    krylov: int = 20
    guessed: bool = True
    state: int = state_bytes(3)

    def sent(self) -> dict[str, float]:
        """Bytes that the process sends in a step, by what they are for.

        The first three are those that `Communicator.sent` counts, on the mean over the processes.
        """
        part, dim = self.part, self.part.dim
        per_node = 2 * (8 + 8)  # keys and numbers, with and without the nodes of boundaries
        per_node += 2 * 8 * dim  # which boundary holds a node, and its motion
        per_node += 8 * dim * (self.iterations + self.guessed)
        products = self.iterations * self.krylov * PRODUCTS * COARSE_PRODUCTS
        return {
            "copies of points": part.copies * self.state,
            "nodal values": (part.nodes - part.owned_nodes) * per_node,
            "headers": float(MESSAGE * part.neighbours),
            "linear solver": products * part.coupled_nodes() * 8 * dim,
        }

    def exchanged(self) -> float:
        """Bytes of all but the linear solver."""
        found = self.sent()
        return sum(found.values()) - found["linear solver"]

    def memory(self, trial: int = 352, stencil: int = 37) -> dict[str, float]:
        """Bytes that the process stores, by what they are for; the program itself not counted.

        trial, stencil: of a point (docs/theory/engine.md); those of the linear basis in 3D.
        """
        part, dim = self.part, self.part.dim
        row = (2 * (1 + part.reach) + 1) ** dim  # blocks
        matrix = part.owned_nodes * row * dim**2 * AIJ_ENTRY
        return {
            "points": (part.points + part.copies) * (self.state + trial + stencil + TEMPORARY),
            "exchange": 2.0 * part.copies * self.state,
            "matrix": part.nodes * row * 8 * dim**2 * 1.125,
            "PETSc": matrix,
            "multigrid": COARSE_LEVELS * matrix,
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
    print("processes | points | copies | work | sent [MB]: points, nodal, solver | memory [GB]")
    for number in processes:
        step = Step(Part.inside(total / number))
        sent = {name: value / 1e6 for name, value in step.sent().items()}
        memory = sum(step.memory().values()) / 1e9
        print(
            f"{number:,} | {total / number:,.0f} | {step.part.copies:,.0f} | {step.work:.2f} | "
            f"{sent['copies of points']:.1f}, {sent['nodal values']:.1f}, "
            f"{sent['linear solver']:.1f} | {memory:.2f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=float, default=1e9)
    parser.add_argument("--processes", type=int, nargs="+", default=[1000, 2000, 8000, 64000])
    arguments = parser.parse_args()
    _table(arguments.points, arguments.processes)


if __name__ == "__main__":
    main()
