# SPDX-License-Identifier: BSD-3-Clause
"""A layer that settles by up to three tenths of its height, against finite volumes.

Drained at its base, which is on a line of the grid; what is compared is the pressure at the sealed
top, which moves, and its settlement.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from tilth.arrays import Floats
from tilth.model import HenckyElastic, Model
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.closed_forms import Moduli
from tilth_verification.closed_forms.material_column import (
    MaterialColumn,
    constant,
    hencky,
    kozeny_carman,
)
from tilth_verification.comparison import Comparison, absolute
from tilth_verification.consolidating import conductivity, consolidate, number

PROBLEM = "large_consolidation"
HEIGHT, LOAD = 4.0, 50.0
"""Of the mud [m], and on its top [kPa]."""
CELLS = 16
SOURCE = "finite volumes in material coordinates"


@dataclass(frozen=True)
class Mud:
    """A case: load on the mud [kPa], how its conductivity changes, times over H^2/c [-]."""

    load: float
    permeability: str
    times: tuple[float, ...]

    @property
    def name(self) -> str:
        """For the rows."""
        return f"q/M {self.load / 100.0:g}, {self.permeability.replace('_', '-')}"


MUDS = (
    Mud(10.0, "constant", (0.1, 0.2, 0.5)),
    Mud(50.0, "constant", (0.1, 0.2, 0.5)),
    Mud(50.0, "kozeny_carman", (0.1, 0.2, 0.5)),
)


def comparisons(long: bool) -> Iterator[Comparison]:
    """Loads and conductivities with GIMP; the other bases for the largest strain."""
    for mud in MUDS:
        yield from compared(mud, "gimp")
    for basis in BASES if long else ("cpdi2",):
        if basis != "gimp":
            yield from compared(MUDS[1], basis)


def compared(mud: Mud, basis: str, cells: int = CELLS) -> Iterator[Comparison]:
    """Pressure at the top over the load, and settlement over the final one, at some times."""
    model = with_basis(column(mud, cells), basis)
    exact, unit = reference(model, mud.load)
    found = consolidate(model, [])
    settled = found.settlement(HEIGHT / cells)
    for time, now in zip(mud.times, exact.at([unit * each for each in mud.times]), strict=True):
        step = min(range(len(found.time)), key=lambda i: abs(found.time[i] - unit * time))
        of = f"T = {time:g}, {mud.name}, {basis}, {cells} cells"
        value, expected = found.top[step] / mud.load, now.pressure / mud.load
        yield absolute(f"pressure at the top over the load, {of}", value, expected, 0.01, SOURCE)
        value, expected = float(settled[step]) / exact.final, now.settlement / exact.final
        quantity = f"settlement over the final one, {of}"
        yield absolute(quantity, value, expected, 0.01, SOURCE)


def column(mud: Mud, cells: int) -> Model:
    """Returns the mud of case.toml with another load and conductivity, on a number of cells."""
    size = HEIGHT / cells
    model = example(PROBLEM)
    _, unit = reference(model, mud.load)
    end = unit * mud.times[-1]
    changes: dict[str, Any] = {
        "materials.mud.permeability": mud.permeability,
        "grid.cell_size": size,
        "bodies.0.shape.upper": [size, HEIGHT],
        "boundaries.1.at": size,
        "loads.0.start": [size, HEIGHT],
        "loads.0.pressure": mud.load,
        "loads.0.factor": [[0.0, 1.0], [end, 1.0]],
        "schedule": {"end": end, "steps": 100},
        "track": [],
    }
    return varied(model, changes)


def reference(model: Model, load: float, weight: float = 0.0) -> tuple[MaterialColumn, float]:
    """Returns the layer of a model by finite volumes, and H^2/c of its start [day].

    load: on it [kPa]. weight: under water at the start [kN/m^3], as in `MaterialColumn`.
    """
    mud = model.materials["mud"]
    assert isinstance(mud, HenckyElastic)
    modulus, start = Moduli.of(mud).constrained, conductivity(model, "mud")
    law = constant(start)
    if mud.permeability == "kozeny_carman":
        law = kozeny_carman(start, number(model, "mud", "porosity"))
    column = MaterialColumn(HEIGHT, hencky(modulus), law, load, weight)
    return column, HEIGHT**2 / (start * modulus)


def isochrone(model: Model, time: float) -> tuple[Floats, Floats]:
    """Returns heights [m] and the excess pressure there [kPa], shape (n,) each.

    For the mud of case.toml.
    """
    (now,) = reference(model, LOAD)[0].at([time])
    return now.place, now.profile
