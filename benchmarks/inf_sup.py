# SPDX-License-Identifier: BSD-3-Clause
"""Inf-sup constant of the implicit boundaries' multipliers, over random planes and refinements.

A cube of elastic soil of side 1, turned and shifted at random, stands with one face on a plane.
With B the rows of the multipliers, integrated over their patches of area A_k, and K the energy norm
of the displacement (stiffness of the soil with ghost stabilisation, and a small mass), the constant
beta is the least with

    mu . B K^-1 B^T mu >= beta^2 sum_k h_k A_k mu_k^2 / E    for all mu,

h_k = min(h, A_k^(1/(dim - 1))), the size of the patch, at most the cell's. Prints the least and the
median over the planes, the same with h for h_k, and in 2D that of a multiplier at each quadrature
point; with --figure, draws docs/theory/inf_sup.png. Run it with `python benchmarks/inf_sup.py`
(six minutes on one thread, nearly all for the cubes of 12 cells a side).
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from matplotlib.figure import Figure
from scipy.linalg import cholesky_banded, solve_triangular

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries import ImplicitConstraints
from tilth.boundaries.implicit.constraint import SurfaceConstraint
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.terms.balance import Balance
from tilth.terms.ghost import Ghost
from tilth.terms.linear import LinearForces
from tilth.terms.soil_forces import SoilForces
from tilth.terms.weak_springs import WeakSprings

MODULUS, POISSON = 1000.0, 0.3
"""Young's modulus [stress] and Poisson's ratio [-] of the soil."""
SEED = 1
REFINEMENTS = {2: (4, 8, 16, 32), 3: (3, 6, 12)}
"""Cells along a side of the cube."""
VANISHING = 1e-12
"""Singular values below are round-off."""

LEAST_SHOWN = 1e-17
"""The figure shows what vanishes here or above."""
MEANS, POINTS = "#1f4e79", "#d1495b"


@dataclass(frozen=True)
class Constants:
    """What is measured for one plane, each an inf-sup constant [-].

    Attributes:
        patches: of the means over patches, with the patches' size in the norm.
        cell: the same with the cell's size.
        points: of one multiplier at each quadrature point; NaN if not asked for.
        vanishing: share of the singular values of these that vanish, NaN if not asked for.
    """

    patches: float
    cell: float
    points: float = np.nan
    vanishing: float = np.nan


def random_axes(random: np.random.Generator, dim: int) -> Floats:
    """Returns a random rotation, (dim, dim): the cube's axes as rows, the plane's normal last."""
    axes, upper = np.linalg.qr(random.normal(size=(dim, dim)))
    axes = axes * np.sign(np.diag(upper))
    axes[0] *= np.sign(np.linalg.det(axes))
    return np.asarray(axes)


def block_on_plane(axes: Floats, corner: Floats, cells: int, condition: str) -> Simulation:
    """A cube of side 1 with these axes, from `corner` on; its lower face stands on a plane."""
    plane = {"type": "plane", "point": corner.tolist(), "normal": axes[-1].tolist()}
    soil = {"model": "hencky_elastic", "young_modulus": MODULUS, "poisson_ratio": POISSON}
    cube = {"type": "box", "lower": corner.tolist(), "upper": (corner + 1.0).tolist()}
    dim = len(axes)
    model = Model.from_dict(
        {
            "analysis": {"kind": "3d" if dim == 3 else "plane_strain"},
            "grid": {"cell_size": 1.0 / cells},
            "materials": {"soil": {**soil, "density": 1.0}},
            "bodies": [
                {
                    "name": "cube",
                    "material": "soil",
                    "shape": cube,
                    "basis": "gimp",
                    "points": [2 * cells] * dim,
                }
            ],
            "boundaries": [
                {"type": "implicit", "name": "plane", "condition": condition, "geometry": plane}
            ],
            "schedule": {"steps": 1},
        }
    )
    points = initial_points(model)
    turned = MaterialPoints.undeformed(
        points.ranges,
        corner + (points.position - corner) @ axes,
        points.volume,
        points.half_length,
    )
    return Simulation(model, turned)


def energy_norm(
    simulation: Simulation, active: ActiveGrid, constraints: ImplicitConstraints
) -> Any:
    """The matrix of a step without its boundaries, and a mass of modulus / side^2, sparse."""
    soil, gamma = simulation.soil_on(active), simulation.setup.model.analysis.ghost_stabilisation
    nodes, dim = active.position.shape
    nothing_held = np.zeros((nodes, dim), dtype=bool)
    ghost = Ghost(gamma, dim)
    faces = ghost.couplings(soil, nothing_held, constraints.exterior_nodes())
    springs = WeakSprings.of(
        soil, constraints.coupled_nodes() | ghost.held_nodes(active, nothing_held)
    )
    balance = Balance(active, [SoilForces(soil), springs, LinearForces(faces)])
    active, still = balance.active, np.zeros((nodes, dim))
    x, matrix_of = balance.at(still), balance.space.matrix()
    balance.evaluate(x)
    balance.linearise(x, matrix_of)
    size = nodes * dim
    blocks = matrix_of["u", "u"].values
    matrix = sp.bsr_matrix((blocks, active.column, active.row_start), shape=(size, size))
    return (matrix + sp.diags(np.repeat(MODULUS * soil.nodal_volume, dim))).tocsr()


def mean_rows(part: SurfaceConstraint, nodes: int) -> tuple[Floats, Floats]:
    """Rows of the means, (multipliers, nodes, dim), and the area of their patches."""
    space = part.multipliers
    assert space is not None
    rows = np.zeros((len(space.area), nodes, space.row.shape[1]))
    owner = np.repeat(np.arange(len(rows)), np.diff(space.node_start))
    np.add.at(rows, (owner, space.node), space.row)
    return rows, space.area


def point_rows(part: SurfaceConstraint, nodes: int) -> tuple[Floats, Floats]:
    """Rows of a multiplier at each quadrature point along each direction, and the weights."""
    directions, weight = part.constrained_directions, part.pose.weight
    rank, count, dim = directions.shape
    rows = np.zeros((rank, count, nodes, dim))
    node, value = part.at.node[part.at.cell], weight[:, None] * part.at.value
    number = np.arange(count)[:, None]
    for row, direction in zip(rows, directions, strict=True):
        np.add.at(row, (number, node), value[..., None] * direction[:, None])
    return rows.reshape(rank * count, nodes, dim), np.tile(weight, rank)


class InverseRoot:
    """L^-1 of the norm's Cholesky factor, K = L L^T, for rows that reach nodes beside a plane only.

    The nodes are numbered from the farthest to the plane, so that the matrix is banded and the
    last block of L alone is needed.

    Args:
        matrix: K, sparse.
        height: of the nodes over the plane, shape (nodes,).
        reached: the nodes that rows reach, shape (nodes,).
    """

    def __init__(self, matrix: Any, height: Floats, reached: npt.NDArray[np.bool_]) -> None:
        dim = matrix.shape[0] // len(height)
        order = np.argsort(-height)
        lowest = np.flatnonzero(reached[order])[0]
        self.nodes = order[lowest:]
        unknowns = (dim * order[:, None] + np.arange(dim)).ravel()
        lower = sp.tril(matrix[unknowns][:, unknowns]).tocoo()
        band = np.zeros(((lower.row - lower.col).max() + 1, len(unknowns)))
        band[lower.row - lower.col, lower.col] = lower.data
        factor = cholesky_banded(band, lower=True, overwrite_ab=True)[:, dim * lowest :]
        size = factor.shape[1]
        self.last = np.zeros((size, size))
        for below, entries in enumerate(factor[:size]):
            kept = np.arange(size - below)
            self.last[kept + below, kept] = entries[: len(kept)]

    def times(self, rows: Floats) -> Floats:
        """Returns L^-1 B^T of rows B (rows, nodes, dim)."""
        right = rows[:, self.nodes].reshape(len(rows), -1).T
        return np.asarray(solve_triangular(self.last, right, lower=True))


def spectrum(root: Floats, weight: Floats) -> Floats:
    """Returns square roots of the eigenvalues of W^-1/2 B K^-1 B^T W^-1/2, rising, W = weight / E.

    root: L^-1 B^T. weight: of the square of each multiplier [length^dim].
    """
    scaled = root / np.sqrt(weight / MODULUS)
    values = np.linalg.svd(scaled, compute_uv=False)[::-1]
    return np.concatenate([np.zeros(scaled.shape[1] - len(values)), values])


def spectra(
    axes: Floats, offset: Floats, cells: int, condition: str = "fixed", points: bool = False
) -> list[Floats]:
    """The spectra that `Constants` names the least of; the last one if `points` are asked for.

    offset: of the cube's corner from a node, in cells, shape (dim,).
    """
    h, dim = 1.0 / cells, len(axes)
    simulation = block_on_plane(axes, h * offset, cells, condition)
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    constraints = ImplicitConstraints.gather(
        simulation.state.implicit, simulation.state.points, active, simulation.setup.kind, 0.0, 1.0
    )
    (part,) = constraints.parts
    assert isinstance(part, SurfaceConstraint)
    rows, area = mean_rows(part, active.nodes)
    sets = [(rows, np.minimum(h, area ** (1.0 / (dim - 1))) * area), (rows, h * area)]
    if points:
        rows, area = point_rows(part, active.nodes)
        sets.append((rows, h * area))
    height = (active.position - h * offset) @ axes[-1]
    norm = InverseRoot(
        energy_norm(simulation, active, constraints), height, constraints.coupled_nodes()
    )
    return [spectrum(norm.times(rows), weight) for rows, weight in sets]


def random_planes(dim: int, planes: int) -> list[tuple[Floats, Floats]]:
    """Returns axes and offsets, see `spectra`; the first planes are the same for any number."""
    random = np.random.default_rng(SEED)
    return [(random_axes(random, dim), random.uniform(0.0, 1.0, dim)) for _ in range(planes)]


def constants(
    dim: int, cells: int, planes: int, condition: str = "fixed", points: bool = False
) -> list[Constants]:
    """The constants of random planes; the same planes for each number of cells."""
    found = []
    for axes, offset in random_planes(dim, planes):
        patches, cell, *point = spectra(axes, offset, cells, condition, points)
        of_points = [float(point[0][0]), float((point[0] < VANISHING).mean())] if points else []
        found.append(Constants(float(patches[0]), float(cell[0]), *of_points))
    return found


def print_table(measured: dict[tuple[int, int], list[Constants]]) -> None:
    """One row for each dimension and refinement."""
    print("| | cells | means: least | median | with h: least | median | points: largest | vanish |")
    print("|" + " --- |" * 8)
    for (dim, cells), found in measured.items():
        columns = []
        for name in ("patches", "cell"):
            values = [getattr(each, name) for each in found]
            columns += [f"{min(values):.3f}", f"{np.median(values):.3f}"]
        if not np.isnan(found[0].points):
            columns.append(f"{max(each.points for each in found):.1g}")
            columns.append(f"{min(each.vanishing for each in found):.2f} and more")
        else:
            columns += ["", ""]
        print(f"| {dim}D | {cells} | {' | '.join(columns)} |", flush=True)


def draw(path: Path, measured: dict[tuple[int, int], list[Constants]], condition: str) -> None:
    """All constants over the refinement, and the whole spectra of one plane."""
    figure = Figure(figsize=(10.4, 4.0), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    scatter = np.random.default_rng(0)
    for axes, dim in ((left, 2), (middle, 3)):
        grids = [cells for of_dim, cells in measured if of_dim == dim]
        for place, cells in enumerate(grids):
            found = measured[dim, cells]
            across = place + scatter.uniform(-0.18, 0.18, len(found))
            values = np.array([each.patches for each in found])
            axes.plot(across, values, "o", color=MEANS, markersize=3.6, alpha=0.55, zorder=2)
            axes.plot([place - 0.3, place + 0.3], [np.median(values)] * 2, color="0.15", zorder=3)
            axes.annotate(
                f"{values.min():.2f}", (place, values.min()), (0, -13), textcoords="offset points",
                ha="center", fontsize=8.5, color=MEANS,
            )  # fmt: skip
            if dim == 2:
                constrained = [each.points for each in found]
                axes.plot(
                    across, constrained, "x", color=POINTS, markersize=4.5, clip_on=False, zorder=4
                )
        axes.set_title(f"{'plane strain' if dim == 2 else '3D'}, {len(found)} planes", fontsize=10)
        axes.set_xticks(range(len(grids)), [f"1/{cells}" for cells in grids])
        axes.set_xlim(-0.5, len(grids) - 0.5)
        axes.set_ylim(0.0, 0.55)
        axes.set_xlabel("cell size over side of the cube")
    left.set_ylabel(r"inf-sup constant $\beta$ [-]")
    left.annotate(
        "a multiplier at each point: 0", (0.5, 0.0), (0.5, 0.05), color=POINTS, fontsize=8.5,
        ha="center", xycoords=("axes fraction", "data"),
    )  # fmt: skip
    left.annotate("line: median", (0.97, 0.95), xycoords="axes fraction", ha="right", fontsize=8.5)
    cells = 16
    means, _, points = spectra(*random_planes(2, 1)[0], cells, condition, True)
    for values, colour, marker, label in (
        (means, MEANS, "o", f"means over patches ({len(means)})"),
        (points, POINTS, "x", f"a multiplier at each point ({len(points)})"),
    ):
        share = (np.arange(len(values)) + 0.5) / len(values)
        right.semilogy(
            share,
            np.maximum(values, LEAST_SHOWN),
            marker,
            color=colour,
            markersize=3.6,
            label=label,
        )
    right.set_ylim(0.3 * LEAST_SHOWN, 10.0)
    right.axhspan(0.3 * LEAST_SHOWN, VANISHING, color="0.93", zorder=0)
    right.annotate("round-off", (0.97, 1e-13), ha="right", fontsize=8.5, color="0.4")
    right.set_title(f"all singular values of one plane, h = 1/{cells}", fontsize=10)
    right.set_xlabel("share of the multipliers")
    right.legend(loc="center", bbox_to_anchor=(0.47, 0.5), fontsize=8.5, frameon=False)
    for axes in (left, middle, right):
        axes.grid(axis="y", color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Prints the table and draws the figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--planes", type=int, default=50)
    parser.add_argument("--condition", default="fixed", choices=("fixed", "roller", "tangential"))
    parser.add_argument("--figure", type=Path, help="where to save the figure")
    arguments = parser.parse_args()
    _core.set_threads(1)
    measured = {
        (dim, cells): constants(dim, cells, arguments.planes, arguments.condition, dim == 2)
        for dim, grids in REFINEMENTS.items()
        for cells in grids
    }
    print_table(measured)
    if arguments.figure:
        draw(arguments.figure, measured, arguments.condition)


if __name__ == "__main__":
    main()
