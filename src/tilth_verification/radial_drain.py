# SPDX-License-Identifier: BSD-3-Clause
"""Clay around a vertical drain under a rigid plate: degrees of consolidation by series.

The load is so small that the strain is. The series take the steps of backward Euler as the analysis
does, so that the difference is the error of the grid; extrapolated to small steps the degrees are
those of the series with exact time, which Barron (1948) calls free strain.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.model import HenckyElastic, Model
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.closed_forms import Moduli
from tilth_verification.closed_forms.radial_drain import RadialDrain
from tilth_verification.comparison import Comparison, absolute, relative
from tilth_verification.consolidating import conductivity, consolidate
from tilth_verification.convergence import log_slope

PROBLEM = "radial_drain"
RADIUS = 0.1
"""Of the drain [m]."""
LOAD = 1e-3
"""Mean stress under the plate [kPa]: a strain of 1e-7."""
DECLARED = 20.0
"""That of case.toml [kPa]."""
TIMES = (0.05, 0.1, 0.2, 0.5)
"""At which degrees are compared, over 4 r_e^2 / c [-]."""
STEPS = 50
"""To the last of them."""
TOLERANCE = 0.005
"""With cells of a quarter of the drain's radius [-]."""
SERIES = "series, free strain"
DISCRETE = "the same with steps of backward Euler"


@dataclass(frozen=True)
class Found:
    """What a run has found at `TIMES`, shape (4,) each, and the series with its steps.

    degree: of consolidation [-]. pressure: at the outer wall over the load [-].
    """

    degree: Floats
    pressure: Floats
    exact_degree: Floats
    exact_pressure: Floats


def comparisons(long: bool) -> Iterator[Comparison]:
    """Degrees on some grids with some bases; other Poisson's ratios and distances of the drains."""
    cells = (4, 8, 16) if long else (4, 8)
    for basis in BASES if long else ("gimp", "linear"):
        yield from grids(basis, cells)
    for poisson_ratio in (0.0, 0.45):
        found = run(ring(5, 4, poisson_ratio=poisson_ratio))
        yield from degrees(found, f"n 5, nu {poisson_ratio:g}, gimp, h = r_w/4", TOLERANCE)
    for ratio in (5, 10):
        yield from in_time(ratio)


def ring(ratio: int, cells: int, steps: int = STEPS, poisson_ratio: float = 0.3) -> Model:
    """Returns the ring of case.toml under a small load.

    Args:
        ratio: radius of the ring's outer wall over that of the drain.
        cells: number of cells to the radius of the drain; two of them are the ring's height.
        steps: equal ones to the last of `TIMES`.
        poisson_ratio: of the clay.
    """
    size, outer = RADIUS / cells, ratio * RADIUS
    model = varied(example(PROBLEM), {"materials.clay.poisson_ratio": poisson_ratio})
    end = TIMES[-1] * unit(model, outer)
    changes: dict[str, Any] = {
        "grid.cell_size": size,
        "bodies.0.shape.upper": [outer, 2.0 * size],
        "boundaries.1.at": outer,
        "rigid_bodies.0.geometry.lower": [0.0, 2.0 * size],
        "rigid_bodies.0.geometry.upper": [outer + RADIUS, 4.0 * size],
        "rigid_bodies.0.centre": [0.0, 3.0 * size],
        "rigid_bodies.0.force": {"y": -LOAD * math.pi * (outer**2 - RADIUS**2)},
        "rigid_bodies.0.force_factor": [[0.0, 1.0], [end, 1.0]],
        "schedule": {"end": end, "steps": steps},
        "analysis.tolerance": 1e-9,
        "track": [],
    }
    return varied(model, changes)


def outer_radius(model: Model) -> float:
    """Returns that of the clay [m]."""
    upper: list[float] = model.to_dict()["bodies"][0]["shape"]["upper"]
    return upper[0]


def modulus(model: Model) -> float:
    """Returns M of the clay [kPa]."""
    clay = model.materials["clay"]
    assert isinstance(clay, HenckyElastic)
    return Moduli.of(clay).constrained


def unit(model: Model, outer: float) -> float:
    """Returns 4 r_e^2 / c [day] for an outer radius [m]."""
    return 4.0 * outer**2 / (conductivity(model, "clay") * modulus(model))


def isochrone(model: Model, time: float) -> tuple[Floats, Floats]:
    """Returns distances from the axis [m] and the excess pressure there by the series [kPa].

    For the ring of case.toml, shape (n,) each.
    """
    outer = outer_radius(model)
    exact, scaled = RadialDrain(outer / RADIUS), time / unit(model, outer)
    place = np.linspace(RADIUS, outer, 101)
    return place, DECLARED * np.array([exact.pressure(r / RADIUS, scaled) for r in place])


def equal_strain(model: Model, time: Floats) -> Floats:
    """Returns the vertical strain by Barron's equal strain [-], shape (n,), for case.toml."""
    outer = outer_radius(model)
    barron = RadialDrain(outer / RADIUS)
    degree = [barron.equal_strain(each / unit(model, outer)) for each in time]
    return DECLARED / modulus(model) * np.array(degree)


def run(model: Model) -> Found:
    """Returns what is found of a ring of `ring`."""
    outer = outer_radius(model)
    found = consolidate(model, [[outer, 0.0]])
    assert found.points is not None
    scaled = np.array(found.time) / unit(model, outer)
    sizes = [float(size) for size in np.diff([0.0, *scaled])]
    at = [int(np.abs(scaled - time).argmin()) for time in TIMES]
    whole = float(found.points.initial_volume.sum())
    strain = found.settlement(whole)[at]
    exact, ratio = RadialDrain(outer / RADIUS), outer / RADIUS
    return Found(
        degree=strain * modulus(model) / LOAD,
        pressure=np.array([found.pressure[i][0] for i in at]) / LOAD,
        exact_degree=np.array([exact.degree(scaled[i], sizes[: i + 1]) for i in at]),
        exact_pressure=np.array([exact.pressure(ratio, scaled[i], sizes[: i + 1]) for i in at]),
    )


def degrees(found: Found, of: str, tolerance: float) -> Iterator[Comparison]:
    """Degrees of consolidation at all times, and the pressure at the outer wall at T = 0.2."""
    for time, value, exact in zip(TIMES, found.degree, found.exact_degree, strict=True):
        quantity = f"degree of consolidation at T = {time:g}, {of}"
        yield relative(quantity, float(value), float(exact), tolerance, DISCRETE)
    quantity = f"pressure half way to the next drain over the load at T = 0.2, {of}"
    value, exact = float(found.pressure[2]), float(found.exact_pressure[2])
    yield relative(quantity, value, exact, tolerance, DISCRETE)


def grids(basis: str, cells: tuple[int, ...]) -> Iterator[Comparison]:
    """Degrees on some grids with a basis, and their order at T = 0.1."""
    errors = []
    for n in cells:
        found = run(with_basis(ring(5, n), basis))
        of = f"n 5, nu 0.3, {basis}, h = r_w/{n}"
        yield from degrees(found, of, TOLERANCE * (4 / n) ** 2)
        errors.append(abs(float(found.degree[1] / found.exact_degree[1]) - 1.0))
    rate = log_slope(errors[0], errors[-1], cells[-1] / cells[0])
    quantity = f"order of the degree at T = 0.1, {basis}, h = r_w/{cells[0]} to r_w/{cells[-1]}"
    yield absolute(quantity, rate, 2.0, 0.1, "linear elements")


def in_time(ratio: int) -> Iterator[Comparison]:
    """Degrees without the error of the steps, by extrapolation from steps and half steps."""
    coarse, fine = (run(ring(ratio, 4, steps)).degree for steps in (STEPS, 2 * STEPS))
    exact = RadialDrain(ratio)
    for time, value in zip(TIMES, 2.0 * fine - coarse, strict=True):
        quantity = (
            f"degree of consolidation at T = {time:g}, n {ratio}, nu 0.3, gimp, h = r_w/4, "
            "extrapolated to small steps"
        )
        yield relative(quantity, float(value), exact.degree(time), TOLERANCE, SERIES)
