# SPDX-License-Identifier: BSD-3-Clause
"""Material points of a Gmsh mesh: every element is subdivided, with a point in each part."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.bodies.block import Block
from tilth.bodies.elements import ELEMENTS
from tilth.bodies.gmsh_file import FLATNESS_TOLERANCE, group_names, group_tags, read_gmsh
from tilth.bodies.overlapping_elements import require_elements_apart
from tilth.bodies.request import BodyPoints, Request
from tilth.bodies.tiling import spacing_of, tile_points
from tilth.errors import BadInput
from tilth.model.shape_base import Bounds

# Elements with a volume below this fraction of their longest extent to the power d are degenerate.
DEGENERACY_TOLERANCE = 1e-9
# Largest number of pairs of repeated elements that a message lists.
MAXIMUM_LISTED = 5


@dataclass(frozen=True)
class Elements:
    """The elements of a mesh, as they are in its file.

    Attributes:
        file: its path.
        blocks: the elements.
    """

    file: str
    blocks: list[Block]

    def bounds(self) -> Bounds:
        """Returns the bounding box."""
        every = [block.corners.reshape(-1, block.corners.shape[2]) for block in self.blocks]
        lower = np.min([own.min(axis=0) for own in every], axis=0)
        upper = np.max([own.max(axis=0) for own in every], axis=0)
        return tuple(lower.tolist()), tuple(upper.tolist())

    def of_group(self, name: str) -> Elements:
        """Returns those of a physical group; perhaps none."""
        own = [block.of(block.group == name) for block in self.blocks]
        return Elements(self.file, [block for block in own if len(block.corners)])


def mesh_points(form: Elements, request: Request) -> BodyPoints:
    """Returns the points of a mesh of triangles and quadrilaterals, or tetrahedra and hexahedra.

    An element is divided into k parts along each edge, k at least 1 and such that its pieces have
    about the volume of the requested spacing, the least within the element. Each piece gives a
    point at its centroid with its exact volume, and a square or cubic domain of that volume. Points
    are in the order of the elements. Elements of lower dimension (the mesh of the outline) are not
    used. Domains with corners tile the elements instead, see `tile_points`.
    Raises BadInput for a file that cannot be read or contains no such elements, and for degenerate,
    inverted, repeated or overlapping elements.
    """
    dimension = len(request.cell_size)
    blocks, measures = measured_blocks(form, request)
    if request.has_corners:
        tiles = tile_points(blocks, measures, request)
        require_elements_apart(blocks, form.file, request)  # after refusals of single elements
        return tiles
    require_elements_apart(blocks, form.file, request)
    spacings = [spacing_of(block, request) for block in blocks]
    cuts = [
        np.maximum(np.rint((m / spacing.prod(axis=1)) ** (1.0 / dimension)), 1.0)
        for m, spacing in zip(measures, spacings, strict=True)
    ]
    request.check_number(float(sum((cut**dimension).sum() for cut in cuts)))
    pieces = [_cut(block, cut.astype(np.int64)) for block, cut in zip(blocks, cuts, strict=True)]
    position = np.concatenate([centroid for centroid, _ in pieces])
    measure = np.concatenate([piece for _, piece in pieces])
    half_length = np.empty_like(position)
    half_length[:] = 0.5 * measure[:, None] ** (1.0 / dimension)
    number = [(cut**dimension).astype(np.int64) for cut in cuts]
    group = np.concatenate([np.repeat(b.group, own) for b, own in zip(blocks, number, strict=True)])
    volume = measure * request.circumference(position)
    return BodyPoints(position, volume, half_length, group=group)


def measured_blocks(form: Elements, request: Request) -> tuple[list[Block], list[Floats]]:
    """Returns the blocks of a mesh and their elements' areas or volumes, shape (n,), > 0.

    Raises BadInput as `mesh_points`.
    """
    blocks = form.blocks
    _check_repeated(blocks, request)
    request.check_radius(min(b.corners[..., 0].min() for b in blocks), f"mesh {form.file}")
    measures = [_measure(block, request) for block in blocks]
    if sum(measure.sum() for measure in measures) < 0.0:  # all have reversed orientation
        blocks = [b.mirrored() for b in blocks]
        measures = [-measure for measure in measures]
    for block, measure in zip(blocks, measures, strict=True):
        _check_orientation(block, measure, request)
    return blocks, measures


def _cut(block: Block, cuts: npt.NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Returns centroids (n, d) and volumes (n,) of all pieces; `cuts`: parts per edge."""
    dimension = block.corners.shape[2]
    number = cuts**dimension
    first = np.cumsum(number) - number
    centroid = np.empty((int(number.sum()), dimension))
    measure = np.empty(len(centroid))
    for k in np.unique(cuts):
        chosen = np.flatnonzero(cuts == k)
        for batch in np.array_split(chosen, math.ceil(len(chosen) * k**dimension / 250_000)):
            where = first[batch][:, None] + np.arange(k**dimension)
            centroid[where], measure[where] = block.element.pieces(block.corners[batch], int(k))
    return centroid, measure


def _measure(block: Block, request: Request) -> Floats:
    """Returns the elements' signed areas or volumes, shape (n,); refuses degenerate elements."""
    dimension = block.corners.shape[2]
    jacobian = block.element.corner_jacobians(block.corners)
    _, pieces = block.element.pieces(block.corners, 1)
    extent = np.ptp(block.corners, axis=1).max(axis=1) ** dimension
    folded = np.abs(np.sign(jacobian).sum(axis=1)) != jacobian.shape[1]
    bad = np.flatnonzero((np.abs(pieces[:, 0]) <= DEGENERACY_TOLERANCE * extent) | folded)
    if len(bad):
        raise block.refused(int(bad[0]), "is degenerate (flat, not convex or folded)", request)
    return pieces[:, 0]


def _check_orientation(block: Block, measure: Floats, request: Request) -> None:
    """Refuses elements of negative volume."""
    inverted = np.flatnonzero(measure < 0.0)
    if len(inverted):
        raise block.refused(int(inverted[0]), "is inverted against most of the mesh", request)


def _check_repeated(blocks: list[Block], request: Request) -> None:
    """Refuses elements with the same nodes, which would count their material twice."""
    for element in {block.element.name: block.element for block in blocks}.values():
        own = [block for block in blocks if block.element is element]
        nodes = np.sort(np.concatenate([block.nodes for block in own]), axis=1)
        order = np.lexsort(nodes.T)  # a stable sort: equal rows stay in the order of the mesh
        repeated = np.flatnonzero((nodes[order[1:]] == nodes[order[:-1]]).all(axis=1))
        if len(repeated):
            pairs = [f"{order[i] + 1} and {order[i + 1] + 1}" for i in repeated[:MAXIMUM_LISTED]]
            more = (
                f" and {len(repeated) - MAXIMUM_LISTED} more"
                if len(repeated) > MAXIMUM_LISTED
                else ""
            )
            raise request.refused(
                f"elements of the mesh are listed twice: {element.name}s {', '.join(pairs)}{more} "
                "have the same nodes",
                "remove one of each; two physical groups must not contain the same elements",
                "shape.file",
            )


def read_mesh(file: Path, dimension: int, request: Request) -> list[Block]:
    """Returns the blocks of elements of the given dimension in a Gmsh file.

    Raises BadInput for a file that cannot be read or contains no such elements of first order.
    """
    mesh = read_gmsh(file, lambda problem, remedy: _file_error(file, problem, remedy, request))
    higher = [c.type for c in mesh.cells if c.dim == dimension and c.type not in ELEMENTS]
    if higher or any(c.dim > dimension for c in mesh.cells):
        found = higher or sorted({c.type for c in mesh.cells if c.dim > dimension})
        kinds = ", ".join(dict.fromkeys(found))
        remedy = f"in {dimension} dimensions use {_usable(dimension)} of first order"
        raise _file_error(file, f"has elements of type {kinds}", remedy, request)
    cells = [c for c in mesh.cells if c.dim == dimension and len(c.data)]
    if not cells:
        kinds = ", ".join(dict.fromkeys(c.type for c in mesh.cells)) or "no elements"
        raise _file_error(
            file,
            f"contains no {_usable(dimension)}, only {kinds}",
            f"mesh the body itself, not its outline (`gmsh -{dimension}`), and save all elements",
            request,
        )
    points = np.asarray(mesh.points, dtype=float)
    if dimension == 2 and points.shape[1] == 3:
        height = points[np.unique(np.concatenate([c.data.ravel() for c in cells])), 2]
        if np.ptp(height) > FLATNESS_TOLERANCE * np.ptp(points[:, :2]):
            raise _file_error(
                file,
                f"is not flat: z runs from {height.min():.6g} to {height.max():.6g}",
                "draw a two-dimensional body in the x-y plane",
                request,
            )
    blocks: list[Block] = []
    names = group_names(mesh, dimension)
    for c, tag in zip(mesh.cells, group_tags(mesh), strict=True):
        if c.dim != dimension or len(c.data) == 0:
            continue
        element = ELEMENTS[c.type]
        first = sum(len(b.nodes) for b in blocks if b.element is element)
        nodes = np.asarray(c.data, dtype=np.int64)
        group = np.array([names.get(int(t), "") for t in tag], dtype=np.str_)
        blocks.append(Block(element, points[:, :dimension][nodes], nodes, first, group))
    return blocks


def _file_error(file: Path, problem: str, remedy: str, request: Request) -> BadInput:
    """Returns the error to raise for the file."""
    return request.refused(problem, remedy, "shape.file", str(file))


def _usable(dimension: int) -> str:
    """Returns the names of the supported elements."""
    return {2: "triangles or quadrilaterals", 3: "tetrahedra or hexahedra"}[dimension]
