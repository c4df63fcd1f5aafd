# SPDX-License-Identifier: BSD-3-Clause
"""A cantilever bent through more than its length, against finite elements of the same law."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.boundaries.surfaces.motion import rotation_matrix
from tilth.model import Model
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.terms.loads import nearest_points
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, relative, vanishing
from tilth_verification.reference import end_loaded_cantilever
from tilth_verification.turned import ALIGNED, aligned, copies

LENGTH = 10.0
TIP = (10.0, 0.5)
SOURCE = "FE, 80 x 8 nine-node"
SHIFTED = {0.25: 7e-4, 0.125: 1.6e-4}
"""Cell size [m] -> distance of the tip on a shifted grid over the length when each quadrature point
was constrained (decision 18)."""
HALVED, ORDER = 0.0034, 2.0
"""Distance of the tips on cells of 0.25 and 0.125 m along the grid over the length, and the order
with which it falls: that of bending with bilinear functions, whose strains are linear over the
depth. The error on cells of 0.25 m is then HALVED / (1 - 2^-ORDER)."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """The whole curve of the tip at h 0.25 m (0.01 of the length) and 0.125 m (0.005); turned."""
    yield from compare(0.25, 0.01)
    if long:
        yield from compare(0.125, 0.005)
    yield from turned_copies(long)


def turned_copies(long: bool) -> Iterator[Comparison]:
    """Distance of the tip in turned copies, and on a shifted grid, from the aligned model.

    A turned copy and the aligned model have an error each, and the two may have opposite signs. A
    turned cell of size h is cos + sin times h deep across the beam, and its error that of such
    cells. On a shifted grid the limit is the distance with each quadrature point constrained.
    """
    worst, tips = [], []
    for size, shift in SHIFTED.items() if long else [(0.25, SHIFTED[0.25])]:
        model = aligned("end_loaded_cantilever", size)
        tips.append(tip_at(model, 0.0))
        error = HALVED / (1.0 - 2.0**-ORDER) * (size / 0.25) ** ORDER
        quantity = f"largest distance of the tip over the length, h {size:g} m"
        distances = []
        for at, angle, copy in copies(model):
            distance = largest_distance(tip_at(copy, angle), tips[-1])
            depth = np.cos(np.radians(angle)) + np.sin(np.radians(angle))
            tolerance = error * (1.0 + depth**ORDER) if angle else shift
            yield vanishing(f"{quantity}, {at}", distance, tolerance, ALIGNED)
            if angle:
                distances.append(distance)
        worst.append(max(distances))
    if long:
        quantity = "largest distance of the tip over the length, h 0.25 and 0.125 m"
        yield relative(quantity, largest_distance(*tips), HALVED, 0.03, "as the bounds have it")
        quantity = "largest distance of a turned copy's tip, h 0.25 over 0.125 m"
        yield at_least(quantity, worst[0] / worst[1], 1.0, 0.0, "it falls with the cell")


def tip_at(model: Model, angle: float) -> Floats:
    """Returns the tip displacement of a copy turned by `angle` [degrees], turned back, (steps, 2).

    It is evaluated at the times of the declared steps, also where some were halved.
    """
    turn = rotation_matrix(angle, None, 2)
    fraction, tip = tip_curve(model, turn @ TIP)
    steps = model.schedule.steps
    assert steps is not None
    at = np.arange(1, steps + 1) / steps
    return np.stack([np.interp(at, fraction, u) for u in (tip @ turn).T], axis=1)


def largest_distance(tip: Floats, reference: Floats) -> float:
    """Returns the largest distance of two curves of the tip over the length."""
    return float(np.linalg.norm(tip - reference, axis=1).max()) / LENGTH


def compare(cell_size: float, tolerance: float) -> Iterator[Comparison]:
    """Largest distance to the reference over all steps, and the tip under full load."""
    reference = end_loaded_cantilever()
    fraction, tip = tip_curve(
        varied(example("end_loaded_cantilever"), {"grid.cell_size": cell_size})
    )
    exact = np.stack(
        [np.interp(fraction, reference.load_fraction, u) for u in reference.displacement.T], axis=1
    )
    distance = np.linalg.norm(tip - exact, axis=1) / LENGTH
    at = f"h {cell_size:g} m"
    quantity = f"largest distance of the tip over the length, {at}"
    yield vanishing(quantity, float(distance.max()), tolerance, SOURCE)
    for name, computed, expected in zip("xy", tip[-1], exact[-1], strict=True):
        quantity = f"tip displacement {name} under full load, {at}"
        yield relative(quantity, float(computed), float(expected), 0.01, SOURCE, "m")


def tip_curve(model: Model, position: npt.ArrayLike = TIP) -> tuple[Floats, Floats]:
    """Returns load fraction (steps,) and displacement of the end face's middle (steps, 2).

    position: of that middle at the start [length], shape (2,).
    """
    end = np.array(position, dtype=float)
    initial = initial_points(model)
    near = nearest_points(initial, end, model.cell_size)
    start = initial.position[initial.index_of(near)]
    fraction, tip = [], []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        fraction.append(time)
        tip.append(extrapolated_displacement(simulation.state.points, near, start, end))

    march(model, after_step)
    return np.array(fraction), np.array(tip)


def extrapolated_displacement(
    points: MaterialPoints, ids: npt.NDArray[np.int64], start: Floats, position: Floats
) -> Floats:
    """Returns the displacement of a material position X between the points [length], shape (dim,).

    The nearest points are half their spacing inside the end face. Each extrapolates by its
    deformation gradient, x(X) = x_p + F_p (X - X_p); the result is the mean over them.

    Args:
        points: at the time of interest; `ids` of the nearest ones, `start` their initial positions.
        position: the material position X in the undeformed body, shape (dim,).
    """
    index = points.index_of(ids)
    gradient = points.deformation_gradient[index, : len(position), : len(position)]
    carried = points.position[index] + np.einsum("pij,pj->pi", gradient, position - start)
    return np.asarray(carried.mean(axis=0) - position)
