# SPDX-License-Identifier: BSD-3-Clause
"""A slab between rigid smooth plates, drained at its sides (Mandel 1953).

The plate moves as in the solution, under a load so small that the strain is; the force on it shows
that it is the solution. The series take the steps of backward Euler as the analysis does, so that
the difference is the error of the grid.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.arrays import Floats
from tilth.model import HenckyElastic, Model
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.closed_forms import Moduli
from tilth_verification.closed_forms.consolidation import Mandel
from tilth_verification.comparison import Comparison, absolute, relative, vanishing
from tilth_verification.consolidating import Consolidation, conductivity, consolidate
from tilth_verification.convergence import log_slope

PROBLEM = "mandel"
HALF_WIDTH = 0.5
"""Of the slab [m]."""
STRESS = 1e-3
"""Mean stress under the plate [kPa]: a strain of 1e-6."""
DECLARED = 2.0
"""That of case.toml [kPa]."""
END, STEPS = 0.15, 15
"""Time over a^2/c [-], after the peak, and steps to it."""
SOURCE = "Mandel's series with steps of backward Euler"


def comparisons(long: bool) -> Iterator[Comparison]:
    """Peak of the pressure, pressures later and the force, with some bases and Poisson's ratios."""
    cases = [("gimp", 0.2), ("linear", 0.2), ("gimp", 0.0)]
    if long:
        cases += [(basis, 0.2) for basis in BASES if basis.startswith("cpdi")]
    for basis, ratio in cases:
        yield from grids(basis, ratio, (8, 16, 32) if long else (8, 16))
    yield in_time()


def slab(cells: int, ratio: float, steps: int = STEPS) -> tuple[Model, Mandel, float]:
    """Returns the slab of case.toml on a number of cells to its middle, its series and a^2/c."""
    size = HALF_WIDTH / cells
    model = varied(example(PROBLEM), {"materials.clay.poisson_ratio": ratio})
    exact, unit, shear = closed_form(model)
    sizes = [END / steps] * steps
    motion = [
        [unit * END * (i + 1) / steps, exact.strain(END * (i + 1) / steps, sizes[: i + 1])]
        for i in range(steps)
    ]
    changes = {
        "grid.cell_size": size,
        "bodies.0.shape.upper": [HALF_WIDTH, 2.0 * size],
        "boundaries.2.at": 2.0 * size,
        "boundaries.2.displacement": {"y": -STRESS / shear * 2.0 * size},
        "boundaries.2.factor": [[0.0, 0.0], *motion],
        "schedule": {"end": unit * END, "steps": steps},
        "analysis.tolerance": 1e-9,
        "track": [],
    }
    return varied(model, changes), exact, unit


def closed_form(model: Model) -> tuple[Mandel, float, float]:
    """Returns the series for a slab, a^2/c [hour] and the shear modulus [kPa]."""
    clay = model.materials["clay"]
    assert isinstance(clay, HenckyElastic)
    moduli = Moduli.of(clay)
    unit = HALF_WIDTH**2 / (conductivity(model, "clay") * moduli.constrained)
    return Mandel(clay.parameter("poisson_ratio")), unit, moduli.shear


def isochrone(model: Model, time: float) -> tuple[Floats, Floats]:
    """Returns distances from the middle [m] and the excess pressure there by the series [kPa].

    For the slab of case.toml, shape (n,) each.
    """
    (exact, unit, _), place = closed_form(model), np.linspace(0.0, HALF_WIDTH, 101)
    shape = [exact.pressure(x / HALF_WIDTH, time / unit) for x in place]
    return place, 0.5 * DECLARED * np.array(shape)


def run(model: Model) -> Consolidation:
    """Returns what is found at the middle and at half of the half width."""
    return consolidate(model, [[0.0, 0.0], [0.5 * HALF_WIDTH, 0.0]], "plate")


def grids(basis: str, ratio: float, cells: tuple[int, ...]) -> Iterator[Comparison]:
    """Pressures on some grids with a basis, and the order of the peak."""
    errors = []
    of = f"nu {ratio:g}, {basis}"
    for n in cells:
        model, exact, unit = slab(n, ratio)
        found = run(with_basis(model, basis))
        pressure = np.array(found.pressure) / (0.5 * STRESS)
        sizes = [size / unit for size in found.steps]
        expected = np.array([
            [exact.pressure(x, time / unit, sizes[: i + 1]) for x in (0.0, 0.5)]
            for i, time in enumerate(found.time)
        ])  # fmt: skip
        peak, highest = float(pressure[:, 0].max()), float(expected[:, 0].max())
        errors.append(abs(peak / highest - 1.0))
        tolerance = 0.01 if n == 8 else 0.003
        quantity = f"peak of the pressure in the middle, {of}, h = a/{n}"
        yield relative(quantity, peak, highest, tolerance, SOURCE)
        quantity = f"pressure at a/2 at T = {END:g}, {of}, h = a/{n}"
        yield relative(quantity, float(pressure[-1, 1]), float(expected[-1, 1]), tolerance, SOURCE)
        force = -np.array(found.force)[:, 1] / (STRESS * HALF_WIDTH)
        worst = float(np.abs(force - 1.0).max())
        quantity = f"largest change of the force on the plate, {of}, h = a/{n}"
        yield vanishing(quantity, worst, 1e-3, "the force stays")
    rate = log_slope(errors[0], errors[-1], cells[-1] / cells[0])
    quantity = f"order of the peak, {of}, h = a/{cells[0]} to a/{cells[-1]}"
    yield absolute(quantity, rate, 2.0, 0.2, "linear elements")


def in_time() -> Comparison:
    """The peak without the error of the steps, by extrapolation from steps and half steps."""
    peaks = []
    for steps in (STEPS, 2 * STEPS):
        model, exact, _ = slab(16, 0.2, steps)
        peaks.append(max(float(each[0]) for each in run(model).pressure) / (0.5 * STRESS))
    reference = max(exact.pressure(0.0, time) for time in np.linspace(0.02, END, 500))
    quantity = "peak of the pressure, nu 0.2, gimp, h = a/16, extrapolated to small steps"
    return relative(quantity, 2.0 * peaks[1] - peaks[0], reference, 0.003, "Mandel's series")
