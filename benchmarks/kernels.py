# SPDX-License-Identifier: BSD-3-Clause
"""Kernels alone, stress update to point matrices: operations, bytes and time per point."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt
from measure import machine, machine_rates
from problems import block, cantilever

from tilth import _core
from tilth.analysis.simulation import Simulation
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.mpm.stencil import Stencil
from tilth_verification.cases import varied

BASES = ("linear", "gimp", "cpdi1")  # the kernels see no difference between cpdi1 and cpdi2
CALLS = 25
Action = Callable[[], object]

SHIFT = 0.3
"""Share of a cell by which the points are moved: grid lines cut their domains, as in a flow."""


def simulations() -> Iterator[tuple[str, Simulation]]:
    """The cantilever on a fine grid and the elastic block, each with every basis.

    In 3D also with domains that grid lines cut at random.
    """
    for basis in BASES:
        model = varied(cantilever("linear"), {"grid.cell_size": 0.125, "bodies.0.basis": basis})
        yield f"2D, {basis}", Simulation(model)
    for basis in BASES:
        yield f"3D, {basis}", Simulation(varied(block(16), {"bodies.0.basis": basis}))
    for basis in BASES[1:]:
        simulation = Simulation(varied(block(16), {"bodies.0.basis": basis}))
        disarrange(simulation.state.points, simulation.state.grid.cell_size)
        yield f"3D, {basis}, at random", simulation


def disarrange(points: MaterialPoints, cell: npt.NDArray[np.float64]) -> None:
    """Moves points by up to a quarter of a cell and deforms their domains, as a flow does.

    Half lengths change by up to a fifth; corners take a gradient of a tenth.
    """
    random = np.random.default_rng(0)
    points.position += cell * random.uniform(-0.25, 0.25, points.position.shape)
    points.half_length *= random.uniform(0.8, 1.2, points.half_length.shape)
    gradient = np.eye(len(cell)) + 0.1 * random.standard_normal((len(points), *2 * (len(cell),)))
    points.corner[:] = np.einsum("pij,pcj->pci", gradient, points.corner)


def work(stencil: Stencil) -> dict[str, tuple[float, float]]:
    """Operations and bytes of memory traffic per point; what is written is read first.

    Spectral decompositions count as 4 sweeps of Jacobi rotations in 3D and one rotation in 2D,
    3 logarithms as 60 operations; the tangent is symmetric.
    """
    dim, points = stencil.dim, np.diff(stencil.start)
    nodes = np.diff(stencil.node_start)
    n, square = (float(np.average(count, weights=points)) for count in (nodes, nodes**2))
    kept = float(np.average(np.diff(stencil.value_start) / points, weights=points))
    response = 36 if dim == 3 else 23
    products = n * (dim + 1) if stencil.boxed else 0.0
    gradient = products + 2 * dim * dim * n
    rotations = 4 * 3 * 40 if dim == 3 else 40
    columns = 2 * dim * dim * n + 5 * dim**4 + dim**3 * (dim + 1) * n
    return {
        "stress": (gradient + 330 + rotations, 8 * (kept + 8 + 2 * (8 + response))),
        "force": (gradient + 3 * dim**3, 8 * (kept + response + 1)),
        "stiffness": (
            products + columns + dim**2 * (dim + 1) * square,
            8 * (kept + response + 1),
        ),
        "blocks": (
            products + 2 * dim**2 * (1 + dim) * ((1 + dim) * n + square),
            8 * (kept + (dim * (1 + dim)) ** 2),
        ),
    }


def shortest(action: Action) -> float:
    """Processor time of one call [s], the least of some."""
    times = []
    for _ in range(CALLS):
        start = time.process_time()
        action()
        times.append(time.process_time() - start)
    return min(times)


def assembly(soil: Soil, active: ActiveGrid) -> dict[str, Action]:
    """What sets the matrix to the soil's stiffness, and to the blocks of full point matrices."""
    dim = active.grid.dim
    blocks = np.empty((len(active.column), dim, dim))
    shape = (len(soil.points), dim, 1 + dim, dim, 1 + dim)
    matrices = np.random.default_rng(0).standard_normal(shape)

    def stiffness() -> None:
        blocks.fill(0.0)
        soil.add_stiffness(active, blocks)

    def point_blocks() -> None:
        blocks.fill(0.0)
        soil.integrals.add_blocks(active.block_positions, matrices, blocks)

    return {"stiffness": stiffness, "blocks": point_blocks}


def main() -> None:
    """Prints the table, one thread."""
    _core.set_threads(1)
    print(machine())
    flops, bandwidth = machine_rates()
    print(f"matrix product {flops:.0f} Gflop/s, triad {bandwidth:.1f} GB/s, one thread\n")
    print("| | nodes | flops | bytes | microseconds | limit | share |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for name, simulation in simulations():
        simulation.state.points.position += SHIFT * simulation.state.grid.cell_size
        active = locate(simulation.state.points, simulation.state.grid, Buffers())
        soil = simulation.soil_on(active)
        displacement = 1e-4 * active.position
        calls: dict[str, Action] = {
            "stress": lambda soil=soil, u=displacement: soil.update(u),
            "force": soil.internal_force,
            **assembly(soil, active),
        }
        (stencil,) = active.stencils
        nodes = np.average(np.diff(stencil.node_start), weights=np.diff(stencil.start))
        for kernel, (operations, traffic) in work(stencil).items():
            measured = 1e6 * shortest(calls[kernel]) / len(soil.points)
            by = {"arithmetic": operations / flops, "memory": traffic / bandwidth}
            limit = max(by, key=lambda each: by[each])
            print(
                f"| {name}, {kernel} | {nodes:.1f} | {operations:,.0f} | {traffic:,.0f} | "
                f"{measured:.3f} | {1e-3 * by[limit]:.3f}, {limit} | "
                f"{1e-3 * by[limit] / measured:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
