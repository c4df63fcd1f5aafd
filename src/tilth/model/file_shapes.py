# SPDX-License-Identifier: BSD-3-Clause
"""Shapes of bodies that only a file knows; it is read where points are made."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from tilth.errors import Problem
from tilth.model.fields import FileName, Name, Positive, Vector
from tilth.model.shape_base import DeclaredShape


class FileShape(DeclaredShape):
    """A shape whose bounds and size are known once its file is read: all subclasses are such."""


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
    group: Name | None = None
    """Name of the physical group whose elements are the body; all elements if not given."""


class Outline(FileShape):
    """Closed outline drawn in a DXF file, or a polygon of a GeoJSON file (2D), with its holes.

    DXF: the lines, polylines, arcs, circles, ellipses and splines of one layer, whose ends meet;
    curves become chords that leave them by at most 1e-4 of their extent. GeoJSON: one polygon, in
    plane coordinates; longitude and latitude in degrees are refused. The outline of the largest
    area is that of the body, those in it are holes.
    """

    dimensions = (2,)

    type: Literal["outline"] = "outline"
    file: FileName
    """Path of the .dxf, .geojson or .json file, relative to the case file."""
    layer: Name | None = None
    """Layer of the DXF drawing, or value of the property "name" of a GeoJSON feature; may be left
    out if there is only one with outlines.
    """
    scale: Positive
    """Length in the case for one unit of the file: 1 for the same unit, 0.001 for a drawing in mm
    and a case in m.
    """
    origin: Vector = (0.0, 0.0)
    """Place in the file that is at x = y = 0 in the case [unit of the file], shape (2,)."""

    def size_problems(self, dimension: int) -> Iterator[Problem]:
        """As `DeclaredShape.size_problems`."""
        yield from _ending(self.file, (".dxf", ".geojson", ".json"))
        if len(self.origin) != 2:
            yield Problem("origin", "must have two coordinates", "such as [0, 0]", self.origin)


def _ending(file: str, known: tuple[str, ...]) -> Iterator[Problem]:
    """Yields the problem of a file of another kind."""
    if not file.lower().endswith(known):
        yield Problem("file", "is of another kind", f"give a file {' or '.join(known)}", file)
