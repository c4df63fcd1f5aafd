# SPDX-License-Identifier: BSD-3-Clause
"""Published curves and reference solutions in the package (folder `data`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from types import MappingProxyType

import numpy as np

from tilth.arrays import Floats

AMPLE_COLUMN_ERROR: Mapping[int, float] = MappingProxyType(
    {4: 4.1e-2, 8: 1.3e-2, 16: 3.7e-3, 32: 1.05e-3, 64: 4.4e-4, 128: 2.0e-4, 256: 1.0e-4}
    | {8192: 3.1e-6}
)
"""Error of the vertical stress of AMPLE's elastic self-weight column against its number of cells.

Read off the published convergence figure of AMPLE (https://wmcoombs.github.io): E 10 kPa, nu 0,
density 80, g 10, height 50 m, 40 steps, 2x2 GIMP points per cell. The measure is
`SelfWeightColumn.stress_error`.
"""


@dataclass(frozen=True)
class CantileverCurve:
    """load_fraction: share of the full load, shape (n,); displacement: x, y [m], shape (n, 2)."""

    load_fraction: Floats
    displacement: Floats


@dataclass(frozen=True)
class CollapsePoints:
    """initial_position, final_position: of the same material points [m], shape (n, 2) each."""

    initial_position: Floats
    final_position: Floats


def end_loaded_cantilever() -> CantileverCurve:
    """Returns the mid-depth tip displacement of the end-loaded cantilever by finite elements.

    10 x 1 m, plane strain, Hencky elastic E 12 MPa, nu 0.2, dead load 100 kN spread over the end
    face; 80 x 8 body-fitted nine-node elements. More is in the head of the file.
    """
    table = _table("end_loaded_cantilever_fe.csv")
    return CantileverCurve(table[:, 0], table[:, 1:])


@dataclass(frozen=True)
class FootingCurve:
    """settlement [m], shape (n,); force: of the half model over Young's modulus [m], shape (n,)."""

    settlement: Floats
    force: Floats


def rigid_footing_elastic() -> FootingCurve:
    """Returns the curve of a smooth rigid footing on an elastic square in plane strain.

    Half-width 1 m, square of 3 m, nu 0.3; 48 x 48 body-fitted nine-node elements; times 0.996 for
    the limit of fine meshes, see the head of the file. The nodes initially under the footing remain
    under it.
    """
    table = _table("rigid_footing_elastic_fe.csv")
    return FootingCurve(table[:, 0], 0.996 * table[:, 1])


@dataclass(frozen=True)
class PressureCurve:
    """settlement [m], shape (n,); pressure: over the shear strength [-], shape (n,)."""

    settlement: Floats
    pressure: Floats


def strip_footing(cell_size: float) -> PressureCurve:
    """Returns the curve of a smooth strip footing on clay: elements of 0.1, 0.05 or 0.025 m.

    Half-width 0.5 m, 5 m of clay; small strains, bilinear elements, B-bar. More is in the head of
    the file.
    """
    return _footing_on_clay("strip_footing_fe.csv", ("strip", 0.5, cell_size, "b_bar"))


def square_footing(
    half_width: float, cell_size: float, formulation: str = "b_bar"
) -> PressureCurve:
    """Returns the curve of a smooth square footing on 5 m of the same clay, quarter model.

    Edges between elements, small strains, trilinear elements, "b_bar" or "standard": half-width 0.4
    or 0.6 m on elements of 0.2 m (standard: 0.6 m), 0.5 m on elements of 0.25 m (both) or 0.125 m.
    """
    head = ("square", half_width, cell_size, formulation)
    return _footing_on_clay("square_footing_fe.csv", head)


def _footing_on_clay(file: str, head: tuple[str, float, float, str]) -> PressureCurve:
    """The curve of one shape, half-width, element size and formulation."""
    rows = [line.split(",") for line in _lines(file)]
    numbers = [row[4:] for row in rows if (row[0], float(row[1]), float(row[2]), row[3]) == head]
    table = np.array(numbers, dtype=np.float64)
    return PressureCurve(table[:, 0], table[:, 1])


def collapse_by_ample() -> CollapsePoints:
    """Returns the positions in AMPLE 1.1's own von Mises collapse problem, cells of 1 m.

    Half body 8 x 8 m, 6 x 6 GIMP points per cell; the rows of the file run over the cells, x
    fastest, and within a cell y fastest, which gives the initial positions.
    """
    cells, points = 8, 6
    cell_y, cell_x, x, y = np.indices((cells, cells, points, points)).reshape(4, -1)
    initial = np.column_stack([cell_x + (x + 0.5) / points, cell_y + (y + 0.5) / points])
    return CollapsePoints(initial, _table("collapse_ample_h1.csv"))


@dataclass(frozen=True)
class PressureCantilever:
    """Response to a follower pressure at the points (10, 1) and (10, 2) m of the end face.

    Attributes:
        load_fraction: share of the full pressure, shape (n,).
        displacement: of the two points, x and y [m], shape (n, 2, 2).
        outlines: load fraction -> points along the bottom, the end face and the top [m], (m, 2).
    """

    load_fraction: Floats
    displacement: Floats
    outlines: Mapping[float, Floats]


def pressure_cantilever(young_modulus: float) -> PressureCantilever:
    """Returns the response of a cantilever to a follower pressure, by Young's modulus [Pa].

    Cantilever 10 x 2 m, 1500 Pa normal to its top. Plane strain, Hencky elastic, nu 0.3, root face
    fixed; body-fitted nine-node elements, 40 or 80 along the beam, for the outlines 60 x 12. More
    is in the heads of the files.
    """
    kilopascal = round(young_modulus / 1e3)
    table = _table(f"pressure_cantilever_fe_E{kilopascal}kPa.csv")
    rows = _table("pressure_cantilever_fe_surfaces.csv")
    rows = rows[rows[:, 0] == kilopascal]
    outlines = {float(f): rows[rows[:, 1] == f, 4:] for f in np.unique(rows[:, 1])}
    return PressureCantilever(table[:, 0], table[:, 1:].reshape(-1, 2, 2), outlines)


def _table(name: str) -> Floats:
    """The numbers of a data file, below its comments and the line of column names."""
    return np.loadtxt(_lines(name), delimiter=",", ndmin=2)


def _lines(name: str) -> list[str]:
    """The rows of a data file, below its comments and the line of column names."""
    folder = resources.files("tilth_verification").joinpath("data")
    text = folder.joinpath(name).read_text(encoding="utf-8")
    return [line for line in text.splitlines() if not line.startswith("#")][1:]
