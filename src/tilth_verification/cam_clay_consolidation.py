# SPDX-License-Identifier: BSD-3-Clause
"""Normally consolidated Cam Clay takes up a load that is raised at once, against finite volumes.

What is compared is the pressure at the sealed top, which moves, and its settlement. The stress over
the stretch is that of the law's rate equations.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tilth.arrays import Floats
from tilth.model import Model
from tilth_verification.cases import example, varied, with_basis
from tilth_verification.closed_forms.cam_clay_oedometer import CamClayOedometer
from tilth_verification.closed_forms.material_column import MaterialColumn, constant
from tilth_verification.comparison import Comparison, absolute
from tilth_verification.consolidating import conductivity, consolidate, number

PROBLEM = "cam_clay_consolidation"
HEIGHT, START = 1.0, 100.0
"""Of the clay [m], and its stress at the start [kPa]."""
CELLS = 16
TIMES = (10.0, 20.0, 50.0)
"""At which it is compared [day]."""
SOURCE = "rate equations and finite volumes in material coordinates"


def comparisons(long: bool) -> Iterator[Comparison]:
    """The stress is doubled, with some bases, and multiplied by four."""
    for basis in ("gimp", "cpdi1", "cpdi2") if long else ("gimp", "cpdi2"):
        yield from compared(2.0, basis)
    yield from compared(4.0, "gimp")


def compared(factor: float, basis: str) -> Iterator[Comparison]:
    """Pressure at the top over the rise of the load, and settlement over the final one.

    factor: of the load over that at the start [-].
    """
    end = TIMES[-1]
    changes: dict[str, Any] = {
        "loads.0.factor": [[0.0, 1.0], [1e-5 * end, factor], [end, factor]],
        "schedule": {"end": end, "steps": 100},
        "track": [],
    }
    model = with_basis(varied(example(PROBLEM), changes), basis)
    exact, rise = reference(model, factor), (factor - 1.0) * START
    found = consolidate(model, [])
    settled = found.settlement(model.cell_size[0])
    for time, now in zip(TIMES, exact.at(TIMES), strict=True):
        step = min(range(len(found.time)), key=lambda i: abs(found.time[i] - time))
        of = f"{time:g} days, load times {factor:g}, {basis}, {CELLS} cells"
        value, expected = found.top[step] / rise, now.pressure / rise
        quantity = f"pressure at the top over the rise of the load, {of}"
        yield absolute(quantity, value, expected, 0.01, SOURCE)
        value, expected = float(settled[step]) / exact.final, now.settlement / exact.final
        quantity = f"settlement over the final one, {of}"
        yield absolute(quantity, value, expected, 0.01, SOURCE)


def reference(model: Model, factor: float) -> MaterialColumn:
    """Returns the layer by finite volumes under a multiple of the load at the start."""
    compression, swelling = (
        slope / (1.0 - slope)  # for Kirchhoff stress
        for slope in (number(model, "clay", f"{of}_index") for of in ("compression", "swelling"))
    )
    slope = number(model, "clay", "critical_state_slope")
    shear = number(model, "clay", "shear_modulus")
    law = CamClayOedometer(START, slope, compression, swelling, shear)
    flow = constant(conductivity(model, "clay"))
    return MaterialColumn(HEIGHT, law.curve(), flow, (factor - 1.0) * START)


def isochrone(model: Model, time: float) -> tuple[Floats, Floats]:
    """Returns heights [m] and the excess pressure there [kPa], shape (n,) each.

    For the clay of case.toml.
    """
    (now,) = reference(model, 2.0).at([time])
    return now.place, now.profile
