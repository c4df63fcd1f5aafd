# SPDX-License-Identifier: BSD-3-Clause
"""The active nodes of the background grid, and the stencils of the material points on it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats, Integers, Shorts
from tilth.comm import SERIAL, Communicator
from tilth.errors import StepFailed
from tilth.grid.background import Grid, cell_corners
from tilth.grid.keys import LARGEST_INDEX, find_keys, lattice_keys, overlay_shift, places_of_keys
from tilth.grid.overlay import Overlay, overlay_of_grid
from tilth.grid.shared_nodes import Number, SharedNodes
from tilth.mpm.groups import Groups, group
from tilth.mpm.pattern import Elements, Pattern
from tilth.mpm.points import MaterialPoints
from tilth.mpm.stencil import Stencil


class Buffers:
    """Memory and matrix patterns that steps reuse.

    Arrays taken for one step are overwritten by the next.
    """

    def __init__(self) -> None:
        self._arrays: dict[str, Floats] = {}
        self._patterns: dict[str, Pattern] = {}

    def take(self, name: str, size: int) -> Floats:
        """Returns an array of this size, its entries undefined."""
        array = self._arrays.get(name)
        if array is None or len(array) < size:
            array = self._arrays[name] = np.empty(size + size // 8)
        return array[:size]

    def pattern(
        self,
        key: Integers,
        groups: list[tuple[Integers, Shorts]],
        couplings: list[tuple[Integers, Shorts]],
        overlays: int,
        of: str = "",
    ) -> Pattern:
        """Returns the pattern of these nodes, groups and couplings; the last step's if equal.

        of: what it is the pattern of.
        """
        kept = self._patterns.get(of)
        if kept is None or not kept.matches(key, groups, couplings):
            kept = self._patterns[of] = Pattern(key, groups, couplings, overlays)
        return kept


@dataclass(frozen=True)
class ActiveGrid:
    """Nodes and cells of the grid in the points' supports in one step; discarded after the step.

    Bodies of different overlays have nodes and cells of their own at the same places,
    those of one overlay after those of the other (`grid/keys.py`).

    Attributes:
        grid: its lines.
        key: sorted keys of the active nodes, shape (nodes,); overlay after overlay, x fastest.
        stencils: one per range of points, in their order.
        points: the points that are located.
        cell_keys: sorted keys of the cells in the points' supports; the key of a cell is that of
            its lowest node.
        buffers: memory that the steps reuse.
        couplings: further nodes that the matrix couples: see `with_couplings`.
        shared: the nodes that other processes have, too; None in a serial run.
        overlays: their number.
    """

    grid: Grid
    key: Integers
    stencils: list[Stencil]
    points: MaterialPoints
    cell_keys: Integers
    buffers: Buffers
    couplings: Sequence[tuple[Integers, Shorts]] = ()
    shared: SharedNodes | None = None
    overlays: int = 1

    @property
    def nodes(self) -> int:
        """Number of active nodes."""
        return len(self.key)

    @property
    def count(self) -> int:
        """The same, as `Nodes.count`."""
        return len(self.key)

    @property
    def comm(self) -> Communicator:
        """The processes that share the grid."""
        return SERIAL if self.shared is None else self.shared.comm

    @property
    def owned(self) -> slice | Integers:
        """The nodes that this process owns: each node has one owner."""
        return slice(0, self.nodes) if self.shared is None else self.shared.owned

    @property
    def owned_nodes(self) -> int:
        """Number of nodes that this process owns."""
        return self.nodes if self.shared is None else len(self.shared.owned)

    @property
    def owned_cells(self) -> int:
        """Number of active cells that this process owns."""
        if self.shared is None:
            return len(self.cell_keys)
        return int(self.shared.owns(self.cell_keys).sum())

    def updated(self, nodal: npt.NDArray[Number]) -> npt.NDArray[Number]:
        """Returns nodal values (nodes, ...), those of other processes' nodes as they are there.

        All processes call it; without others the array itself is returned.
        """
        return nodal if self.shared is None else self.shared.updated(nodal)

    def work(self, force: Floats, displacement: Floats) -> float:
        """Returns the work of nodal forces over all nodes of all processes [force length].

        force, displacement: shape (nodes, dim); those of other processes' nodes do not matter.
        """
        own = self.owned
        return self.comm.sum(float((force[own] * displacement[own]).sum()))

    def norm(self, nodal: Floats) -> float:
        """Returns the norm of nodal values over all nodes of all processes, shape (nodes, dim)."""
        own = nodal[self.owned].ravel()
        return math.sqrt(self.comm.sum(float(own @ own)))

    @property
    def lattice(self) -> Integers:
        """Lattice indices of the active nodes, shape (nodes, 3)."""
        return self._places[0]

    @property
    def overlay(self) -> Integers:
        """Overlay of the active nodes, shape (nodes,)."""
        return self._places[1]

    @cached_property
    def _places(self) -> tuple[Integers, Integers]:
        return places_of_keys(self.key, self.overlays)

    def of_overlay(self, number: int) -> Overlay:
        """Returns the nodes and cells of an overlay."""
        if self.overlays == 1:
            return Overlay(0, 0, self.key, self.cell_keys)
        return overlay_of_grid(self.key, self.cell_keys, number, self.overlays)

    @cached_property
    def position(self) -> Floats:
        """Positions of the active nodes [length], shape (nodes, dim)."""
        return self.grid.position(self.lattice[:, : self.grid.dim].astype(float))

    @cached_property
    def occupied(self) -> Integers:
        """Sorted keys of the cells that contain a material point of their overlay.

        It must be evaluated before the points move.
        """
        cell = np.floor(self.grid.in_cells(self.points.position))
        overlay = self.points.overlays_of(np.arange(len(self.points)))
        return np.unique(lattice_keys(cell.astype(np.int64), overlay))

    def find(self, lattice: Integers, overlay: Integers | int = 0) -> Integers:
        """Returns the numbers of the nodes at lattice indices (n, 3); -1 where none is active.

        overlay: of the nodes, one number or shape (n,).
        """
        keys = np.asarray(_core.node_keys(lattice))
        return find_keys(self.key, keys if self.overlays == 1 else keys + overlay_shift(overlay))

    def with_couplings(self, couplings: Sequence[tuple[Integers, Shorts]]) -> ActiveGrid:
        """Returns the same grid whose matrix also couples the nodes of further elements.

        couplings: first entry of each element, shape (elements + 1,), among node numbers, shape
            (entries,).
        """
        return replace(self, couplings=couplings)

    def with_nodes(self, key: Integers) -> ActiveGrid:
        """Returns the same grid with further nodes of other processes, by their keys.

        Terms couple them with nodes of this process. Without other processes they are there.
        """
        if self.shared is None:
            return self
        missing = np.setdiff1d(key, self.key)
        new = np.union1d(self.key, missing)
        number = np.searchsorted(new, self.key).astype(np.int32)
        stencils = [replace(each, node=number[each.node]) for each in self.stencils]
        extra = np.searchsorted(new, missing)
        shared = SharedNodes(self.comm, self.shared.boxes, new, self.overlays, extra)
        return replace(self, key=new, stencils=stencils, shared=shared)

    @property
    def coupling_distance(self) -> int:
        """Largest number of cells between two nodes that the matrix couples."""
        in_groups = max(int(stencil.count.max()) for stencil in self.stencils) - 1
        of_elements = [elements.coupling_distance for elements in self._pattern.elements]
        return max([in_groups, *of_elements])

    @cached_property
    def _pattern(self) -> Pattern:
        groups = [(stencil.node_start, stencil.node) for stencil in self.stencils]
        couplings = list(self.couplings)
        if self.shared is not None:  # each node has a diagonal block
            extra = self.shared.extra.astype(np.int32)
            couplings.append((np.arange(len(extra) + 1), extra))
        return self.buffers.pattern(self.key, groups, couplings, self.overlays)

    @property
    def row_start(self) -> Integers:
        """First block of each row of the node-block matrix, shape (nodes + 1,)."""
        return self._pattern.row_start

    @property
    def column(self) -> Shorts:
        """Column of each block, sorted within a row."""
        return self._pattern.column

    @property
    def block_positions(self) -> list[tuple[Integers, Shorts]]:
        """Per range, positions of the blocks of its groups in the pattern: start, position."""
        return self._pattern.block_positions

    @property
    def diagonal(self) -> Integers:
        """Position of each node's diagonal block in the matrix, shape (nodes,)."""
        return self._pattern.diagonal

    @property
    def elements(self) -> list[Elements]:
        """The elements of each of `couplings`, with their blocks' positions in the pattern."""
        return self._pattern.elements

    def cells(self) -> Integers:
        """Returns the nodes of every cell in the points' supports, shape (cells, 2^dim).

        Node order is VTK's of a quadrilateral or hexahedron.
        """
        vtk = [0, 1, 3, 2] if self.grid.dim == 2 else [0, 1, 3, 2, 4, 5, 7, 6]
        return self.corners(np.asarray(_core.lattice(self.cell_keys)))[:, vtk].astype(np.int64)

    def corners(self, lattice: Integers) -> Shorts:
        """Returns the nodes of cells at lattice indices (n, 3), x fastest, shape (n, 2^dim).

        The indices are those that the cells' keys have in their overlays.

        Raises AssertionError if a cell has a node that is not active.
        """
        corner = cell_corners(self.grid.dim)
        node = self.find((lattice[:, None] + corner).reshape(-1, 3)).reshape(
            len(lattice), len(corner)
        )
        assert (node >= 0).all(), "a requested cell is not active"
        return node.astype(np.int32)


def locate(
    points: MaterialPoints, grid: Grid, buffers: Buffers, overlays: int | None = None
) -> ActiveGrid:
    """Sorts the points by support and returns the active grid with all basis values.

    The basis values are in `buffers` and valid until these are used again.

    overlays: their number; that of the points if not given.

    Raises:
        StepFailed: if a point is beyond the limits of the grid or the range of its keys, or its
            domain extends over too many cells.
    """
    grid.require_inside(points.position, points.point_id)
    found = [group(points, range_, grid) for range_ in points.ranges]
    overlay = [range_.overlay for range_ in points.ranges]
    overlays = max(overlay) + 1 if overlays is None else overlays
    if overlays > 1 and max(groups.index_range() for groups in found) >= LARGEST_INDEX:
        raise StepFailed(
            f"a point is more than {LARGEST_INDEX:,} cells from the grid's origin along z, beyond "
            "which there is no contact between soil bodies"
        )
    nodes = [groups.active_nodes(number) for groups, number in zip(found, overlay, strict=True)]
    cells = [groups.active_cells(number) for groups, number in zip(found, overlay, strict=True)]
    key, cell_keys = _union(nodes), _union(cells)
    own = [
        Overlay(0, 0, key, cell_keys)
        if overlays == 1
        else overlay_of_grid(key, cell_keys, number, overlays)
        for number in overlay
    ]
    stencils = [
        _stencil(points, i, grid, of_overlay, buffers, groups)
        for i, (groups, of_overlay) in enumerate(zip(found, own, strict=True))
    ]
    return ActiveGrid(
        grid=grid,
        key=key,
        stencils=stencils,
        points=points,
        cell_keys=cell_keys,
        buffers=buffers,
        overlays=overlays,
    )


def _union(keys: list[Integers]) -> Integers:
    return keys[0] if len(keys) == 1 else np.unique(np.concatenate(keys))


def _stencil(
    points: MaterialPoints,
    number: int,
    grid: Grid,
    of_overlay: Overlay,
    buffers: Buffers,
    groups: Groups,
) -> Stencil:
    start, first, count = groups.start, groups.first, groups.count
    if groups.boxed:
        node_start = np.concatenate([[0], np.cumsum(count.prod(axis=1, dtype=np.int64))])
        node = np.asarray(_core.group_nodes(first, count, of_overlay.key, node_start))
    else:
        node_start = groups.node_start
        node = np.searchsorted(of_overlay.key, groups.node_key).astype(np.int32)
    if of_overlay.first_node:
        node = node + np.int32(of_overlay.first_node)
    basis, hat_slope = points.ranges[number].basis, np.zeros(0)
    if basis == "linear":
        of_point = np.full(len(first), grid.dim)
        size = grid.sizes(first[:, : grid.dim]) if grid.graded else grid.cell_size
        hat_slope = 1.0 / size
    elif groups.boxed:
        of_point = 2 * count[:, : grid.dim].sum(axis=1, dtype=np.int64)
    else:
        of_point = (1 + grid.dim) * np.diff(node_start)
    value_start = np.concatenate([[0], np.cumsum(of_point * np.diff(start))])
    value = buffers.take(f"value {number}", int(value_start[-1]))
    part = points.part(points.ranges[number])
    if groups.boxed:
        _core.basis_factors(
            basis, start, first, count, value_start, part.position, part.half_length,
            grid, value,
        )  # fmt: skip
    else:
        _core.corner_basis_values(
            start, node_start, groups.node_key, value_start, part.position, part.corner,
            grid, value,
        )  # fmt: skip
    colour_start, slab_start, order = _core.colour_groups(first, count)
    return Stencil(
        start=start,
        first=first,
        count=count,
        cell_start=groups.cell_start,
        cell=groups.cell,
        node_key=groups.node_key,
        node_start=node_start,
        node=node,
        value_start=value_start,
        value=value,
        hat_slope=hat_slope,
        dim=grid.dim,
        colour_start=colour_start,
        slab_start=slab_start,
        order=order,
    )
