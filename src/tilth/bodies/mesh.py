# SPDX-License-Identifier: BSD-3-Clause
"""Points of a Gmsh mesh: every element is cut into pieces, a point at the centroid of each."""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.bodies.pieces import ELEMENTS, Element
from tilth.bodies.request import BodyPoints, FloatArray, Request
from tilth.model import Mesh

# Elements smaller than this fraction of their longest extent to the power d are degenerate.
DEGENERATE = 1e-9


@dataclass(frozen=True)
class Block:
    """Elements of one type: corner coordinates, shape (n, corners, d)."""

    element: Element
    corners: FloatArray


def mesh_points(shape: Mesh, request: Request) -> BodyPoints:
    """Points of a mesh: triangles and quadrilaterals in 2D, tetrahedra and hexahedra in 3D.

    An element is cut k times along each edge, k chosen so that its pieces have about the volume
    of the wanted spacing, at least 1. Each piece gives a point at its centroid with its exact
    volume, and a square or cubic domain of that volume. Points are in the order of the elements.
    Elements of lower dimension (the mesh of the outline) are not used.
    Raises BadInput for a file that cannot be read or holds no such elements, and for degenerate or
    inverted elements.
    """
    dimension = len(request.cell_size)
    blocks = _read(Path(shape.file), dimension, request)
    request.check_radius(min(b.corners[..., 0].min() for b in blocks), f"mesh {shape.file}")
    measures = [_measure(block, request) for block in blocks]
    if sum(measure.sum() for measure in measures) < 0.0:  # all numbered the other way round
        blocks = [Block(b.element, b.corners[:, b.element.mirror]) for b in blocks]
        measures = [-measure for measure in measures]
    for block, measure in zip(blocks, measures, strict=True):
        _check_orientation(block, measure, request)
    wanted = float(np.prod(request.wanted_spacing()))
    cuts = [np.maximum(np.rint((m / wanted) ** (1.0 / dimension)), 1.0) for m in measures]
    request.check_number(float(sum((cut**dimension).sum() for cut in cuts)))
    pieces = [_cut(block, cut.astype(np.int64)) for block, cut in zip(blocks, cuts, strict=True)]
    position = np.concatenate([centroid for centroid, _ in pieces])
    measure = np.concatenate([piece for _, piece in pieces])
    half_length = np.empty_like(position)
    half_length[:] = 0.5 * measure[:, None] ** (1.0 / dimension)
    return BodyPoints(position, measure * request.circumference(position), half_length)


def _cut(block: Block, cuts: npt.NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
    """Centroids (n, d) and volumes (n,) of all pieces, elements in order; `cuts` per element."""
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


def _measure(block: Block, request: Request) -> FloatArray:
    """Signed areas or volumes of the elements, shape (n,); refuses degenerate elements."""
    dimension = block.corners.shape[2]
    jacobian = block.element.corner_jacobians(block.corners)
    _, pieces = block.element.pieces(block.corners, 1)
    extent = np.ptp(block.corners, axis=1).max(axis=1) ** dimension
    turned = np.abs(np.sign(jacobian).sum(axis=1)) != jacobian.shape[1]
    bad = np.flatnonzero((np.abs(pieces[:, 0]) <= DEGENERATE * extent) | turned)
    if len(bad):
        raise _bad_element(
            block, int(bad[0]), "is degenerate (flat, not convex or folded)", request
        )
    return pieces[:, 0]


def _check_orientation(block: Block, measure: FloatArray, request: Request) -> None:
    inverted = np.flatnonzero(measure < 0.0)
    if len(inverted):
        raise _bad_element(block, int(inverted[0]), "is inverted against most of the mesh", request)


def _bad_element(block: Block, number: int, problem: str, request: Request) -> Exception:
    place = ", ".join(f"{c:.6g}" for c in block.corners[number].mean(axis=0))
    return request.refused(
        f"{block.element.name} {number + 1} of the mesh (near {place}) {problem}",
        "repair the mesh (in Gmsh `ReverseMesh Surface{...};` turns elements over), save it again",
    )


def _read(file: Path, dimension: int, request: Request) -> list[Block]:
    """The blocks of elements of the given dimension in a Gmsh file."""
    meshio = _meshio(request)
    if not file.is_file():
        raise request.refused(f"there is no mesh file {file}", "check the name and the folder")
    try:
        mesh = meshio.gmsh.read(file)
    except (meshio.ReadError, ValueError, KeyError, IndexError, EOFError, AssertionError) as error:
        raise request.refused(
            f"cannot read {file} as a Gmsh mesh ({error})", "save it from Gmsh as a .msh file"
        ) from error
    higher = [c.type for c in mesh.cells if c.dim == dimension and c.type not in ELEMENTS]
    if higher or any(c.dim > dimension for c in mesh.cells):
        found = higher or sorted({c.type for c in mesh.cells if c.dim > dimension})
        raise request.refused(
            f"mesh {file} has elements of type {', '.join(dict.fromkeys(found))}",
            f"in {dimension} dimensions use {_usable(dimension)} of first order",
        )
    cells = [c for c in mesh.cells if c.dim == dimension and len(c.data)]
    if not cells:
        kinds = ", ".join(dict.fromkeys(c.type for c in mesh.cells)) or "no elements"
        raise request.refused(
            f"mesh {file} holds no {_usable(dimension)}, only {kinds}",
            f"mesh the body itself, not its outline (`gmsh -{dimension}`), and save all elements",
        )
    points = np.asarray(mesh.points, dtype=float)
    if dimension == 2 and points.shape[1] == 3:
        height = points[np.unique(np.concatenate([c.data.ravel() for c in cells])), 2]
        if np.ptp(height) > DEGENERATE * np.ptp(points[:, :2]):
            raise request.refused(
                f"mesh {file} is not flat: z runs from {height.min():.6g} to {height.max():.6g}",
                "draw a two-dimensional body in the x-y plane",
            )
    return [Block(ELEMENTS[c.type], points[:, :dimension][c.data]) for c in cells]


def _usable(dimension: int) -> str:
    return {2: "triangles or quadrilaterals", 3: "tetrahedra or hexahedra"}[dimension]


def _meshio(request: Request) -> Any:
    try:
        return importlib.import_module("meshio")
    except ModuleNotFoundError as error:
        raise request.refused(
            "a mesh needs the package meshio, which is not installed",
            "install it with `pip install tilth[mesh]`",
        ) from error
