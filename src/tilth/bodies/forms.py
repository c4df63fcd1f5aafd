# SPDX-License-Identifier: BSD-3-Clause
"""Forms of bodies: what a declared shape is once its file, if it has one, is read.

A shape with a closed form is its own form. All that is computed of a shape (points, size, which
positions are inside, thickness, outline) has one function for each form.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tilth.bodies.mesh import Elements, read_mesh
from tilth.bodies.outline_file import outline_of
from tilth.bodies.polyhedron import polyhedron_of
from tilth.bodies.request import Request
from tilth.bodies.terrain import terrain_of
from tilth.errors import BadInput
from tilth.model import Mesh, Outline, Stl, Terrain
from tilth.model.magnitudes import MOST_CELLS
from tilth.model.problems import unknown_name
from tilth.model.shape_base import Bounds, DeclaredShape

Form = Any
"""A declared shape with a closed form, or what a reader below returns."""


@dataclass(frozen=True)
class WithHoles:
    """A form in space less the holes in it.

    Attributes:
        whole: the form with the holes filled.
        holes: forms of the holes, which are inside it and do not overlap.
    """

    whole: Form
    holes: tuple[Form, ...]

    def bounds(self) -> Bounds:
        """Returns the bounding box."""
        bounds: Bounds = self.whole.bounds()
        return bounds

    def measure(self) -> float:
        """Returns the volume [length^3]."""
        return float(self.whole.measure() - sum(hole.measure() for hole in self.holes))


def form_of(shape: DeclaredShape, request: Request) -> Form:
    """Returns the form of a shape.

    Raises:
        BadInput: its file cannot be read; `request` names the body.
    """
    reader = READERS.get(type(shape))
    if reader is None:
        whole: Form = shape
    else:
        whole = reader(shape, request)
        _require_near(whole.bounds(), request)
    if request.grid.dim != 3 or not shape.cavities():
        return whole
    whole = shape.model_copy(update={"holes": ()}) if reader is None else whole
    return WithHoles(whole, tuple(_hole(shape, i, request) for i in range(len(shape.cavities()))))


def _hole(shape: DeclaredShape, number: int, request: Request) -> Form:
    """Returns the form of a hole; refuses it with its own key."""
    try:
        return form_of(shape.cavities()[number], request)
    except BadInput as error:
        own = f"{request.key}.shape"
        key = f"{own}.holes[{number}]{error.key.removeprefix(own)}"
        raise BadInput(error.problem, error.remedy, key=key, value=error.value) from None


def _require_near(bounds: Bounds, request: Request) -> None:
    """Refuses a form too far from the grid's origin, as map coordinates often are."""
    for corner in bounds:
        cells = np.abs(request.grid.in_cells(np.array(corner)))
        if cells.max() > MOST_CELLS:
            axis = "xyz"[int(cells.argmax())]
            raise request.refused(
                f"reaches to {axis} = {corner[int(cells.argmax())]:.9g}, {cells.max():.3g} cells "
                "from the origin of the grid",
                f"at most {MOST_CELLS:,} are possible: move the file's coordinates, or give "
                "`grid.origin` near them",
            )


def _mesh(shape: Mesh, request: Request) -> Elements:
    whole = Elements(shape.file, read_mesh(Path(shape.file), request.grid.dim, request))
    if shape.group is None:
        return whole
    group = whole.of_group(shape.group)
    if not group.blocks:
        names = sorted({str(name) for block in whole.blocks for name in block.group} - {""})
        problem, remedy = unknown_name("physical group with elements", shape.group, names)
        raise request.refused(problem, remedy, "shape.group", shape.group)
    return group


READERS: dict[type[DeclaredShape], Callable[[Any, Request], Form]] = {
    Mesh: _mesh,
    Outline: outline_of,
    Terrain: terrain_of,
    Stl: polyhedron_of,
}
"""One line per shape that a file knows: the function that reads it."""
