# SPDX-License-Identifier: BSD-3-Clause
"""Elements of one type in a mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.bodies.pieces import Element
from tilth.bodies.request import Request
from tilth.errors import BadInput


@dataclass(frozen=True)
class Block:
    """n elements of one type.

    corners: coordinates, shape (n, corners, d).
    nodes: numbers of the nodes in the mesh, shape (n, corners).
    first: how many elements of this type come before these in the mesh.
    """

    element: Element
    corners: Floats
    nodes: npt.NDArray[np.int64]
    first: int

    def element_name(self, number: int) -> str:
        """The element of this row, counted from 1 among those of its type in the mesh."""
        return f"{self.element.name} {self.first + number + 1}"

    def mirrored(self) -> Block:
        """The same elements numbered the other way round, so that their volumes change sign."""
        mirror = self.element.mirror
        return replace(self, corners=self.corners[:, mirror], nodes=self.nodes[:, mirror])

    def refused(self, number: int, problem: str, request: Request) -> BadInput:
        """The error to raise for the element of this row: what is wrong with it."""
        place = ", ".join(f"{c:.6g}" for c in self.corners[number].mean(axis=0))
        return request.refused(
            f"{self.element_name(number)} of the mesh (near {place}) {problem}",
            "repair the mesh (in Gmsh `ReverseMesh Surface{...};` turns elements over), "
            "save it again",
            "shape.file",
        )
