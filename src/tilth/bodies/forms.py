# SPDX-License-Identifier: BSD-3-Clause
"""Forms of bodies: what a declared shape is once its file, if it has one, is read.

A shape with a closed form is its own form. All that is computed of a shape (points, size, which
positions are inside, thickness, outline) has one function for each form.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from tilth.bodies.mesh import Elements, read_mesh
from tilth.bodies.request import Request
from tilth.model import Mesh
from tilth.model.shapes import DeclaredShape

Form = Any
"""A declared shape with a closed form, or what a reader below returns."""


def form_of(shape: DeclaredShape, request: Request) -> Form:
    """Returns the form of a shape.

    Raises:
        BadInput: its file cannot be read; `request` names the body.
    """
    reader = READERS.get(type(shape))
    return shape if reader is None else reader(shape, request)


def _mesh(shape: Mesh, request: Request) -> Elements:
    return Elements(shape.file, read_mesh(Path(shape.file), request.grid.dim, request))


READERS: dict[type[DeclaredShape], Callable[[Any, Request], Form]] = {
    Mesh: _mesh,
}
"""One line per shape that a file knows: the function that reads it."""
