# SPDX-License-Identifier: BSD-3-Clause
"""Mud without stress settles under its own weight, against finite volumes.

Sealed at its base and drained at its surface, which falls through the grid by up to 27 % of the
mud's height. What is compared is the pressure at the base and the settlement of the surface.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import lambertw

from tilth.arrays import Floats
from tilth.model import Model
from tilth_verification.cases import example, varied, with_basis
from tilth_verification.closed_forms.material_column import MaterialColumn
from tilth_verification.comparison import Comparison, absolute, relative
from tilth_verification.consolidating import consolidate
from tilth_verification.large_consolidation import HEIGHT
from tilth_verification.large_consolidation import reference as layer

PROBLEM = "slurry"
WEIGHT = 3.3
"""Unit weight of the mud under water at the start [kN/m^3]."""
CELLS, STEPS, FIRST = 16, 100, 1e-4
"""In the height, to the last time, and the first of them over H^2/c [-]."""
SOURCE = "finite volumes in material coordinates"


@dataclass(frozen=True)
class Mud:
    """A case: weight of the mud over its modulus, how its conductivity changes, times over H^2/c.

    All dimensionless.
    """

    softness: float
    permeability: str
    times: tuple[float, ...]

    @property
    def name(self) -> str:
        """For the rows."""
        return f"w H/M {self.softness:g}, {self.permeability.replace('_', '-')}"


MUDS = (
    Mud(0.2, "constant", (0.1, 0.2, 0.5)),
    Mud(1.0, "constant", (0.1, 0.2, 0.5)),
    Mud(1.0, "kozeny_carman", (0.1, 0.2, 0.5)),
)


def comparisons(long: bool) -> Iterator[Comparison]:
    """The conductivity falls; softness, other bases and the final settlement as well.

    Not the linear basis: points cross cells, and then it is 19 % of the settlement off.
    """
    yield from compared(MUDS[-1], "gimp")
    if not long:
        return
    for mud in MUDS[:-1]:
        yield from compared(mud, "gimp")
    for basis in ("cpdi1", "cpdi2"):
        yield from compared(MUDS[1], basis)
    yield settled_at_last()


def compared(mud: Mud, basis: str) -> Iterator[Comparison]:
    """Pressure at the base over the weight, and settlement over the final one, at some times."""
    model = with_basis(column(mud, mud.times), basis)
    exact, unit = reference(model)
    found = consolidate(model, [[0.0, 0.0]])
    settled = found.settlement(HEIGHT / CELLS)
    for time, now in zip(mud.times, exact.at([unit * each for each in mud.times]), strict=True):
        step = min(range(len(found.time)), key=lambda i: abs(found.time[i] - unit * time))
        of = f"T = {time:g}, {mud.name}, {basis}, {CELLS} cells"
        value = float(found.pressure[step][0]) / (WEIGHT * HEIGHT)
        expected = now.pressure / (WEIGHT * HEIGHT)
        quantity = f"pressure at the base over the weight, {of}"
        yield absolute(quantity, value, expected, 0.01, SOURCE)
        value, expected = float(settled[step]) / exact.final, now.settlement / exact.final
        quantity = f"settlement over the final one, {of}"
        yield absolute(quantity, value, expected, 0.01, SOURCE)


def column(mud: Mud, times: tuple[float, ...]) -> Model:
    """Returns the mud of case.toml with another stiffness and conductivity, up to some times."""
    model = varied(
        example(PROBLEM),
        {
            "materials.mud.young_modulus": WEIGHT * HEIGHT / mud.softness,
            "materials.mud.permeability": mud.permeability,
        },
    )
    _, unit = reference(model)
    end = unit * times[-1]
    changes: dict[str, Any] = {
        "loads.0.factor": [[0.0, 1.0], [end, 1.0]],
        "schedule": {
            "end": end, "steps": STEPS, "first_step_size": unit * FIRST,
            "output_times": [unit * each for each in times],
        },
        "track": [],
    }  # fmt: skip
    return varied(model, changes)


def reference(model: Model) -> tuple[MaterialColumn, float]:
    """Returns the layer of a model by finite volumes, and H^2/c of its start [day]."""
    return layer(model, 0.0, WEIGHT)


def settled_at_last() -> Comparison:
    """The settlement in the end, by W + W^2/2 = w h/M with Lambert's W of w H/M."""
    mud = MUDS[1]
    model = column(mud, (5.0,))
    settlement = float(consolidate(model, []).settlement(HEIGHT / CELLS)[-1])
    w = float(lambertw(mud.softness).real)
    expected = HEIGHT * (1.0 - (w + 0.5 * w**2) / mud.softness)
    quantity = f"settlement at T = 5, {mud.name}, gimp, {CELLS} cells"
    return relative(quantity, settlement, expected, 0.005, "closed form", "m")


def isochrone(model: Model, time: float) -> tuple[Floats, Floats]:
    """Returns heights [m] and the excess pressure there [kPa], shape (n,) each.

    For the mud of case.toml.
    """
    (now,) = reference(model)[0].at([time])
    top = HEIGHT - now.settlement
    return np.asarray(top - now.place), now.profile
