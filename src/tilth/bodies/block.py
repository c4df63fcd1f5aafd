# SPDX-License-Identifier: BSD-3-Clause
"""Block of elements of one type in a mesh."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.bodies.elements import Brick, Element
from tilth.bodies.request import Request
from tilth.errors import BadInput


@dataclass(frozen=True)
class Block:
    """n elements of one type.

    element: the type.
    corners: coordinates [length], shape (n, corners, d).
    nodes: numbers of the nodes in the mesh, shape (n, corners).
    first: number of elements of this type in earlier blocks of the mesh.
    group: name of the elements' physical group, shape (n,); "" for none.
    """

    element: Element
    corners: Floats
    nodes: npt.NDArray[np.int64]
    first: int
    group: npt.NDArray[np.str_]

    def of(self, chosen: npt.NDArray[np.bool_]) -> Block:
        """Returns some of the elements; chosen: shape (n,)."""
        return Block(
            self.element,
            self.corners[chosen],
            self.nodes[chosen],
            self.first,
            self.group[chosen],
        )

    def element_name(self, number: int) -> str:
        """Returns the name of the element of this row, numbered from 1 among those of its type."""
        return f"{self.element.name} {self.first + number + 1}"

    def mirrored(self) -> Block:
        """Returns the elements with reversed orientation, so that their volumes change sign."""
        mirror = self.element.mirror
        return replace(self, corners=self.corners[:, mirror], nodes=self.nodes[:, mirror])

    def refused(self, number: int, problem: str, request: Request) -> BadInput:
        """Returns the error to raise for the element of this row."""
        centre = ", ".join(f"{c:.6g}" for c in self.corners[number].mean(axis=0))
        return request.refused(
            f"{self.element_name(number)} of the mesh (near {centre}) {problem}",
            "repair the mesh (in Gmsh `ReverseMesh Surface{...};` turns elements over), "
            "save it again",
            "shape.file",
        )


def simplices(block: Block) -> Floats:
    """Returns the corners of the triangles or tetrahedra of a block, shape (n, d + 1, d)."""
    dimension = block.corners.shape[2]
    if not isinstance(block.element, Brick):
        return block.corners
    number = {tuple(corner): i for i, corner in enumerate(block.element.corner.tolist())}
    found = []
    for order in itertools.permutations(range(dimension)):
        corner = [-1] * dimension
        chosen = [number[tuple(corner)]]
        for axis in order:
            corner[axis] = 1
            chosen.append(number[tuple(corner)])
        found.append(block.corners[:, chosen])
    return np.concatenate(found)
