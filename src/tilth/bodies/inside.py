# SPDX-License-Identifier: BSD-3-Clause
"""Which positions are inside the declared shape of a body: exact, in 2D and 3D."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.bodies.block import Block, simplices
from tilth.bodies.forms import Form, WithHoles
from tilth.bodies.mesh import Elements
from tilth.bodies.polyhedron import Polyhedron
from tilth.bodies.terrain import HeightField
from tilth.model import Box, Circle, Cylinder, Polygon, Sphere
from tilth.model.crossings import in_polygon
from tilth.model.shapes import DeclaredShape, side_signs

Inside = Callable[[Floats], Flags]
"""Tells of positions [length], shape (n, d), which are inside, shape (n,)."""


def inside_of(form: Form) -> Inside:
    """Returns the test for a form."""
    tests: dict[type, Callable[[Any], Inside]] = {
        Box: lambda form: partial(_in_box, form),
        Polygon: lambda form: partial(in_polygon, np.asarray(form.vertices, dtype=float)),
        Circle: lambda form: partial(_in_circle, form),
        Cylinder: lambda form: partial(_in_cylinder, form),
        Sphere: lambda form: partial(_in_sphere, form),
        Elements: lambda form: inside_mesh(form.blocks),
        HeightField: lambda form: form.inside,
        Polyhedron: lambda form: form.inside,
        WithHoles: lambda form: _outside(inside_of(form.whole), form.holes),
    }
    whole = tests[type(form)](form)
    if not (isinstance(form, DeclaredShape) and form.cavities()):
        return whole
    return _outside(whole, form.cavities())


def _outside(whole: Inside, forms: tuple[Form, ...]) -> Inside:
    """Returns the test for what is inside, and in none of some forms."""
    holes = [inside_of(form) for form in forms]
    return lambda position: whole(position) & ~np.any([hole(position) for hole in holes], axis=0)


def inside_mesh(blocks: list[Block]) -> Inside:
    """Returns the test for the elements of a mesh.

    Quadrilaterals and hexahedra count as triangles and tetrahedra with the same corners, which is
    exact in 2D and for plane faces.
    """
    return partial(_in_simplices, np.concatenate([simplices(block) for block in blocks]))


def _in_box(shape: Box, position: Floats) -> Flags:
    own = (position - np.asarray(shape.lower)) @ np.array(shape.axes).T
    side = np.asarray(shape.upper) - np.asarray(shape.lower)
    return np.asarray(((own >= 0.0) & (own <= side)).all(axis=1))


def _in_circle(shape: Circle, position: Floats) -> Flags:
    return np.asarray(np.linalg.norm(position - np.asarray(shape.centre), axis=1) <= shape.radius)


def _in_cylinder(shape: Cylinder, position: Floats) -> Flags:
    along = "xyz".index(shape.axis)
    offset = position - np.asarray(shape.centre)
    height = offset[:, along].copy()
    offset[:, along] = 0.0
    return np.asarray((height >= 0.0) & (height <= shape.height) & _in_ring(shape, offset))


def _in_sphere(shape: Sphere, position: Floats) -> Flags:
    return _in_ring(shape, position - np.asarray(shape.centre))


def _in_ring(shape: Cylinder | Sphere, offset: Floats) -> Flags:
    """Which offsets from the centre are between the radii, on the declared sides."""
    radius = np.linalg.norm(offset, axis=1)
    signs = np.asarray(side_signs(shape.sides))
    on_sides = (offset * signs >= 0.0).all(axis=1)
    return np.asarray((radius <= shape.radius) & (radius >= (shape.inner_radius or 0.0)) & on_sides)


def _in_simplices(simplices: Floats, position: Floats) -> Flags:
    """Finds each position's simplices through a lattice of boxes of about their size."""
    inside = np.zeros(len(position), dtype=bool)
    lower, upper = simplices.min(axis=1), simplices.max(axis=1)
    size, origin = upper - lower, lower.min(axis=0)
    edge = np.maximum(size.mean(axis=0), size.max(axis=0) / 8.0)
    box, simplex = _boxes(np.floor((lower - origin) / edge), np.floor((upper - origin) / edge))
    shape = box.max(axis=0) + 1
    of_position = np.floor((position - origin) / edge).astype(np.int64)
    within = np.flatnonzero(((of_position >= 0) & (of_position < shape)).all(axis=1))
    key = np.ravel_multi_index(tuple(box.T), tuple(shape))
    order = np.argsort(key, kind="stable")
    wanted = np.ravel_multi_index(tuple(of_position[within].T), tuple(shape))
    first = np.searchsorted(key[order], wanted, side="left")
    count = np.searchsorted(key[order], wanted, side="right") - first
    edges = np.linalg.inv(np.swapaxes(simplices[:, 1:] - simplices[:, :1], 1, 2))
    for turn in range(int(count.max(initial=0))):
        chosen = np.flatnonzero(count > turn)
        candidate = simplex[order[first[chosen] + turn]]
        offset = position[within[chosen]] - simplices[candidate, 0]
        share = np.einsum("nij,nj->ni", edges[candidate], offset)
        hit = (share >= 0.0).all(axis=1) & (share.sum(axis=1) <= 1.0)
        inside[within[chosen[hit]]] = True
    return inside


def _boxes(first: Floats, last: Floats) -> tuple[Integers, Integers]:
    """Returns all lattice boxes from `first` to `last` (n, d): their indices, and which row."""
    size = (last - first + 1).astype(np.int64)
    count = size.prod(axis=1)
    row = np.repeat(np.arange(len(first)), count)
    rest = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    index = np.empty((len(row), first.shape[1]), dtype=np.int64)
    for k in range(first.shape[1]):
        rest, index[:, k] = np.divmod(rest, size[row, k])
    return index + first[row].astype(np.int64), row
