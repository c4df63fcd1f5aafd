# SPDX-License-Identifier: BSD-3-Clause
"""Linear systems of several fields on blocks of cells: consolidation, members, global unknowns.

Soil of multilinear cells and its pore pressure: K_uu is that of Hooke's law, K_up = -B^T with B the
divergence, K_pp = -(storage + time step times permeability + projection of the pressure).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from lattice_fields import LAW, corners_of

from tilth import _core
from tilth.algebra.block_matrix import Block as AlgebraBlock
from tilth.algebra.block_matrix import BlockPattern
from tilth.algebra.border import Border
from tilth.algebra.field import MOMENTUM, Field
from tilth.algebra.nodes import MeshNodes
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats, Integers
from tilth.comm import SERIAL, Communicator
from tilth.grid.background import Grid
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.distribution import Distribution
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.solvers.coupled_system import CoupledSystem
from tilth.terms.space import Coupled, Space, displacement_of

YOUNG, PRESSURE = 2.0e7, "p"


@dataclass(frozen=True)
class Block:
    """A block of soil of the height 1 with cells, lower side held, upper side drained.

    Attributes:
        cells: along each direction.
        poisson: Poisson's ratio.
        step: permeability times time step times bulk modulus over the height squared.
        storage: of the water, times the bulk modulus.
        skew: how far the matrix is from a symmetric one.
        wet: share of the height that has a pressure.
        has_water, has_pile: whether there are pressure and member.
        unknowns: number of global ones.
    """

    cells: tuple[int, ...]
    poisson: float = 0.2
    step: float = 1e-3
    storage: float = 0.0
    skew: float = 0.0
    wet: float = 1.0
    has_water: bool = True
    has_pile: bool = False
    unknowns: int = 0

    @property
    def dim(self) -> int:
        return len(self.cells)

    @property
    def size(self) -> Floats:
        return np.full(self.dim, 1.0 / self.cells[-1])

    @property
    def lame(self) -> tuple[float, float]:
        nu = self.poisson
        return YOUNG * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), YOUNG / (2.0 * (1.0 + nu))

    @property
    def bulk(self) -> float:
        """Of drained soil that is held as in the plane or in space."""
        first, shear = self.lame
        return first + 2.0 * shear / self.dim


@dataclass(frozen=True)
class Cell:
    """Matrices of a cell, corners x fastest: (corners, corners) or with components."""

    stiffness: Floats
    gradient: Floats  # (corners, corners, dim, 1): K_up
    mass: Floats
    laplacian: Floats
    projection: Floats


def cell_of(block: Block) -> Cell:
    dim, size = block.dim, block.size
    corners = np.array(list(product((0, 1), repeat=dim)))[:, ::-1]
    n, volume = len(corners), size.prod()
    first, shear = block.lame
    stiffness, gradient = np.zeros((n, n, dim, dim)), np.zeros((n, n, dim, 1))
    mass, laplacian, mean = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    for place in product((0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12)), repeat=dim):
        at, weight = np.array(place), volume / 2**dim
        factors = np.where(corners == 1, at, 1.0 - at)
        shape = factors.prod(axis=1)
        slope = np.stack(
            [np.where(corners[:, k] == 1, 1.0, -1.0) / size[k]
             * np.delete(factors, k, axis=1).prod(axis=1) for k in range(dim)], axis=1,
        )  # fmt: skip
        dot = slope @ slope.T
        outer = np.einsum("ai,bj->abij", slope, slope)
        stiffness += weight * (first * outer + shear * outer.swapaxes(2, 3))
        stiffness += weight * shear * dot[:, :, None, None] * np.eye(dim)
        gradient -= weight * np.einsum("ai,b->abi", slope, shape)[..., None]
        mass += weight * np.outer(shape, shape)
        laplacian += weight * dot
        mean += weight * shape
    projection = mass - np.outer(mean, mean) / volume
    return Cell(stiffness, gradient, mass, laplacian, projection)


def grid_of(block: Block, comm: Communicator) -> ActiveGrid:
    """A process' part of the grid, a point in each cell; one corner of the block is missing."""
    place = np.stack(np.meshgrid(*map(np.arange, block.cells), indexing="ij"), axis=-1)
    place = place.reshape(-1, block.dim)
    corner = np.maximum(np.array(block.cells) - np.array(block.cells) // 4, 1)
    place = place[(place < corner).any(axis=1)]
    size, count = block.size, len(place)
    body = PointRange("body", 0, count, "linear", None, LAW, np.array([1.0, 0.0]), 1.0)
    points = MaterialPoints.undeformed(
        [body], (place + 0.5) * size, np.full(count, size.prod()), np.tile(0.5 * size, (count, 1)),
    )  # fmt: skip
    grid = Grid(np.zeros(block.dim), size)
    if comm.size == 1:
        return locate(points, grid, Buffers())
    distribution = Distribution(comm, points, grid)
    own = distribution.owned(points)
    distribution.own = distribution.own[distribution.own]
    return distribution.located(locate(distribution.arranged(own, grid), grid, Buffers()))


@dataclass(frozen=True)
class Pile:
    """A row of nodes from the top down, joined by springs, and others to the cells around."""

    block: Block

    @cached_property
    def position(self) -> Floats:
        count = max(self.block.cells[-1] // 2, 3)
        height = np.linspace(0.45, 1.0, count)
        across = np.full(
            (count, self.block.dim - 1), 0.37 * self.block.cells[0] / self.block.cells[-1]
        )
        return np.column_stack([across, height])

    def cells(self, size: Floats) -> tuple[Integers, Floats]:
        """Lattice places of the corners around each node, (nodes, corners, 3), and their shares."""
        dim = self.block.dim
        low = np.minimum(np.floor(self.position / size), np.array(self.block.cells) - 1).astype(int)
        corners = np.array(list(product((0, 1), repeat=dim)))[:, ::-1]
        at = self.position / size - low
        share = np.where(corners == 1, at[:, None], 1.0 - at[:, None]).prod(axis=2)
        place = np.zeros((*share.shape, 3), dtype=np.int64)
        place[:, :, :dim] = low[:, None] + corners
        return place, share


def system_of(block: Block, comm: Communicator = SERIAL) -> CoupledSystem:
    """The equations of a block, with what a preconditioner may know of them."""
    active = grid_of(block, comm)
    pile = Pile(block)
    place, share = pile.cells(block.size)
    if block.has_pile:  # the last process has its rows
        touched = np.unique(np.asarray(_core.node_keys(place.reshape(-1, 3))))
        active = active.with_nodes(touched[: None if comm.rank == comm.size - 1 else 0])
    node = active.find(place.reshape(-1, 3)).reshape(share.shape)
    near = (node >= 0).all(axis=1) & block.has_pile
    fields = [displacement_of(active)]
    couplings: list[Coupled] = []
    if block.has_water:
        height = active.position[:, -1]
        wet = None if block.wet >= 1.0 else height <= block.wet + 1e-9
        fields.append(Field(PRESSURE, active, 1, "mass", active=wet))
    if block.has_pile:
        scale = np.ones(block.dim)
        fields.append(
            Field("pile", MeshNodes(pile.position, comm), block.dim, MOMENTUM, scale=scale)
        )
        members = np.flatnonzero(near)
        joined = Coupled(np.arange(len(members) + 1), members.astype(np.int32), "pile")
        corner = share.shape[1]
        soil = node[members].ravel().astype(np.int32)
        couplings.append(Coupled(np.arange(len(members) + 1) * corner, soil, other=joined))
        last = len(pile.position) - 1
        links = np.column_stack([np.arange(last), np.arange(last) + 1]).ravel()
        couplings.append(Coupled(np.arange(last + 1) * 2, links.astype(np.int32), "pile"))
    space = Space(active, fields, couplings, [("u", PRESSURE)] if block.has_water else [])
    matrix = space.matrix()
    matrix.clear()
    constrained = {each.name: each.constrained for each in fields}
    height = active.position[:, -1]
    constrained["u"] |= (height < 1e-9)[:, None]
    if block.has_water:
        constrained[PRESSURE] |= (height > 1.0 - 1e-9)[:, None]
    system = CoupledSystem(active, matrix, constrained)
    _fill_soil(block, system)
    if block.has_pile:
        _fill_pile(block, system, near, node, share)
    if block.unknowns:
        matrix.border = border_of(block, active)
    return system


def _entries(pattern: BlockPattern, rows: Integers, columns: Integers, count: int) -> Integers:
    """Positions of pairs of nodes in a pattern; -1 where it has none."""
    start, column = pattern.row_start, pattern.column
    row = np.repeat(np.arange(len(start) - 1), np.diff(start))
    keys, wanted = row * count + column, rows * count + columns
    found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    return np.where(keys[found] == wanted, found, -1)


def add(
    target: AlgebraBlock, values: Floats, rows: Integers, columns: Integers, parts: Floats
) -> None:
    """Adds matrices of pairs of nodes to values of a block, (..., components, components)."""
    entry = _entries(target.pattern, rows, columns, target.column.nodes.count)
    there = entry >= 0
    parts = np.broadcast_to(parts, (*rows.shape, *parts.shape[-2:]))
    np.add.at(values, entry[there], parts[there])


def adder(system: CoupledSystem) -> Callable[[tuple[str, str], Integers, Integers, Floats], None]:
    """A function that adds matrices to the block of a pair of fields."""

    def put(pair: tuple[str, str], rows: Integers, columns: Integers, parts: Floats) -> None:
        block = system.matrix[pair]
        add(block, block.values, rows, columns, parts)

    return put


def _fill_soil(block: Block, system: CoupledSystem) -> None:
    cell, active = cell_of(block), system.displacement.active
    put = adder(system)
    corner = corners_of(active)
    rows, columns = np.broadcast_arrays(corner[:, :, None], corner[:, None, :])
    stiffness = cell.stiffness
    if block.skew:
        turn = np.zeros((block.dim, block.dim))
        turn[0, 1], turn[1, 0] = 1.0, -1.0
        stiffness = stiffness + block.skew * 0.1 * YOUNG * cell.laplacian[..., None, None] * turn
    put(("u", "u"), rows, columns, stiffness)
    if not block.has_water:
        return
    wet = system.matrix.fields[PRESSURE].active
    if wet is not None:
        corner = corner[wet[corner].all(axis=1)]
        rows, columns = np.broadcast_arrays(corner[:, :, None], corner[:, None, :])
    put(("u", PRESSURE), rows, columns, cell.gradient)
    transposed = (1.0 - 0.4 * block.skew) * cell.gradient.transpose(1, 0, 3, 2)
    put((PRESSURE, "u"), rows, columns, transposed)
    first, shear = block.lame
    stiff = first + 2.0 * shear
    height = block.size[-1]
    diffusion = block.step / block.bulk
    tau = max(0.0, max(0.5 / shear, 3.0 / stiff) - 12.0 * diffusion / height**2)
    own = (
        block.storage / block.bulk * cell.mass + diffusion * cell.laplacian + tau * cell.projection
    )
    put((PRESSURE, PRESSURE), rows, columns, -own[..., None, None])
    schur = system.matrix[PRESSURE, PRESSURE].values.copy()
    kept = system.matrix[PRESSURE, PRESSURE].values
    put((PRESSURE, PRESSURE), rows, columns, -cell.mass[..., None, None] / block.bulk)
    system.schur[PRESSURE] = kept.copy()
    kept[:] = schur


def _fill_pile(
    block: Block, system: CoupledSystem, near: Flags, node: Integers, share: Floats
) -> None:
    dim, put = block.dim, adder(system)
    skin = 30.0 * YOUNG * block.size[0] ** (dim - 2) * np.eye(dim)
    members = np.flatnonzero(near)
    soil, weight = node[members], share[members]
    pairs = np.broadcast_arrays(soil[:, :, None], soil[:, None, :])
    products = (weight[:, :, None] * weight[:, None, :])[..., None, None] * skin
    put(("u", "u"), *pairs, products)
    own = np.broadcast_to(members[:, None], soil.shape)
    put(("u", "pile"), soil, own, -weight[..., None, None] * skin)
    put(("pile", "u"), own, soil, -weight[..., None, None] * skin)
    put(("pile", "pile"), members, members, np.broadcast_to(skin, (len(members), dim, dim)))
    axial = 10.0 * YOUNG * np.eye(dim)
    low = np.arange(len(share) - 1)
    high = low + 1
    for row, column, sign in ((low, low, 1), (high, high, 1), (low, high, -1), (high, low, -1)):
        put(("pile", "pile"), row, column, sign * axial)


def border_of(block: Block, active: ActiveGrid) -> Border:
    """Columns and rows near the top, irregular, the same in all processes."""
    wave = np.arange(1, block.unknowns + 1)[:, None, None] * 2.3
    at = active.position[:, None, :] @ (1.0 + np.arange(block.dim**2).reshape(block.dim, block.dim))
    columns = YOUNG * 0.01 * np.sin(wave * at[:, 0]) * (active.position[:, -1:] > 0.7)
    rows = columns * (1.0 - 0.3 * block.skew)
    scale = 1.0 + np.arange(block.unknowns)
    return Border(columns, rows, np.diag(-0.2 * YOUNG * scale**2), scale)


def right_side(system: CoupledSystem, block: Block) -> Unknowns:
    """Irregular, but the same in all processes; pressures and forces of the sizes of a step."""
    of: dict[str, Floats] = {}
    for name, each in system.matrix.fields.items():
        at = each.nodes.position @ np.arange(1.0, block.dim + 1.0)
        size = 1e-3 if name == PRESSURE else 1e3
        wave = 17.0 + 5.0 * np.arange(each.components)
        of[name] = size * np.sin(wave * at[:, None] + 0.3)
    return Unknowns(of, 1e2 * np.cos(np.arange(block.unknowns)))


def dense_solution(system: CoupledSystem, right: Unknowns) -> Unknowns:
    """By Gaussian elimination of the full matrix of the free unknowns, in one process."""
    import scipy.sparse as sp

    matrix, fields = system.matrix, system.matrix.fields
    start = np.cumsum([0] + [each.zero().size for each in fields.values()])
    first = dict(zip(fields, start, strict=False))
    count, m = int(start[-1]), len(right.globals)
    whole, side = np.zeros((count + m, count + m)), np.zeros(count + m)
    free = np.ones(count + m, dtype=bool)
    weight = np.ones(count + m)
    for (row, column), each in matrix.blocks.items():
        shape = (fields[row].zero().size, fields[column].zero().size)
        part = sp.bsr_matrix(
            (each.values, each.pattern.column, each.pattern.row_start), shape=shape
        ).toarray()
        whole[first[row] : first[row] + shape[0], first[column] : first[column] + shape[1]] = part
    for name in fields:
        place = slice(first[name], first[name] + right.of[name].size)
        side[place] = right.of[name].ravel()
        free[place] = ~system.constrained[name].ravel()
        weight[place] = YOUNG if name == PRESSURE else 1.0
    if matrix.border is not None:
        of_u = slice(0, fields["u"].zero().size)
        whole[of_u, count:] = matrix.border.columns.reshape(m, -1).T
        whole[count:, of_u] = matrix.border.rows.reshape(m, -1)
        whole[count:, count:] = matrix.border.corner
        side[count:] = right.globals
    found, by = np.zeros(count + m), weight[free]
    scaled = whole[free][:, free] * by[:, None] * by
    found[free] = by * np.linalg.solve(scaled, by * side[free])
    of = {
        name: found[first[name] : first[name] + each.zero().size].reshape(each.shape)
        for name, each in fields.items()
    }
    return Unknowns(of, found[count:])
