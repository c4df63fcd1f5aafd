# SPDX-License-Identifier: BSD-3-Clause
"""Shapes of bodies that only a file knows; it is read where points are made."""

from __future__ import annotations

from typing import Literal

from tilth.model.fields import FileName
from tilth.model.shape_base import DeclaredShape


class FileShape(DeclaredShape):
    """A shape whose bounds and size are known once its file is read; all below are such."""


class Mesh(FileShape):
    """Body given by a Gmsh mesh: triangles or quadrilaterals (2D), tetrahedra or hexahedra (3D).

    Its elements are divided into pieces of about the wanted spacing, with one point in each. With
    "cpdi1" and "cpdi2" the pieces are the points' domains, at least three of a triangle, four of a
    tetrahedron. Those of "cpdi2" fill the body without gaps, those of "cpdi1" are parallelograms of
    the same size.
    """

    dimensions = (2, 3)
    has_groups = True

    type: Literal["mesh"] = "mesh"
    file: FileName
    """Path of the .msh file, relative to the case file."""
