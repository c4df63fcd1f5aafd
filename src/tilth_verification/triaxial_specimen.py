# SPDX-License-Identifier: BSD-3-Clause
"""A whole cylindrical specimen compressed between smooth and rough platens: its strength."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import ImplicitBoundary, Model, MohrCoulomb, PlaneGeometry, SurfaceLoad, Tresca
from tilth.mpm.points import MaterialPoints
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.comparison import Comparison, at_least, relative

PROBLEM = "triaxial_specimen"
ROUGH = "rough.toml"
RADIUS = 0.05
"""Of the specimen at the start [m]."""
TOLERANCE = 5e-4
"""Of the strength between smooth platens, where the stress is uniform."""
OF_LINEAR = 3e-3
"""The same with the linear basis, whose points are an inaccurate quadrature of the cut cells."""
HEIGHTS = (0.1, 0.025)
"""Half the heights of rough specimens at the start: 2 diameters, and half a diameter [m]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Smooth platens on frictional soil and clay; rough ones between the bounds of clay."""
    for basis in BASES:
        for dilation in (0.0, 10.0, 30.0):
            yield smooth_on_soil(basis, dilation)
    yield smooth_on_clay()
    for half_height in HEIGHTS:
        for cells in (4, 8, 16) if long else (4, 8):
            yield from rough_on_clay(half_height, cells)


def smooth_on_soil(basis: str, dilation: float) -> Comparison:
    """Returns a row: Mohr-Coulomb's axial stress under the cell pressure.

    The law is one of Kirchhoff stress: with J = V / V0 the cohesion of Cauchy stress is c / J.
    """
    change = {"materials.soil.dilation_angle": dilation}
    model = varied(with_basis(example(PROBLEM), basis), change)
    soil, load = model.materials["soil"], model.loads[0]
    assert isinstance(soil, MohrCoulomb)
    assert isinstance(load, SurfaceLoad)
    points, stress = compress(model)
    flow = math.tan(0.25 * math.pi + 0.5 * math.radians(soil.friction_angle)) ** 2
    cohesion = soil.cohesion * points.initial_volume.sum() / points.volume.sum()
    exact = flow * load.pressure + 2.0 * cohesion * math.sqrt(flow)
    quantity = f"axial stress, smooth platens, {basis}, psi {dilation:g} degrees"
    tolerance = OF_LINEAR if basis == "linear" else TOLERANCE
    return relative(quantity, float(stress[-1]), exact, tolerance, "Mohr-Coulomb", "Pa")


def smooth_on_clay() -> Comparison:
    """Returns a row: unconfined clay between smooth platens, 2 s_u."""
    model = varied(on_clay(HEIGHTS[0], 8), {"boundaries.1.condition": "roller"})
    _, stress = compress(model)
    quantity = "axial stress over 2 s_u, smooth platens, clay"
    return relative(quantity, float(stress[-1]) / two_strengths(model), 1.0, TOLERANCE, "Tresca")


def rough_on_clay(half_height: float, cells: int) -> Iterator[Comparison]:
    """The greatest stress of unconfined clay over 2 s_u, between its bounds.

    Lower: the uniform stress that smooth platens cause. Upper: uniform flow, with the velocity
    v = r e / 2 on the platen at the axial rate e; the work done there, s_u times the integral of v
    over the platen, adds R / (3 H) to 2, where H is the whole height.
    """
    model = on_clay(half_height, cells)
    _, stress = compress(model)
    greatest = float(stress.max()) / two_strengths(model)
    upper = 1.0 + RADIUS / (6.0 * half_height)
    at = f"rough platens, clay, height {half_height / RADIUS:g} D, {cells} cells over the radius"
    quantity = f"greatest axial stress over 2 s_u, {at}"
    yield at_least(quantity, greatest, 1.0, 0.0, "lower bound: smooth platens")
    quantity = f"upper bound over that stress, {at}"
    yield at_least(quantity, upper / greatest, 1.0, 0.0, "uniform flow, rough platen")


def on_clay(half_height: float, cells: int) -> Model:
    """Returns the specimen of clay between rough platens, with so many cells over its radius."""
    changes = {
        "grid.cell_size": RADIUS / cells,
        "bodies.0.shape.upper": [RADIUS, half_height],
        "boundaries.1.geometry.point": [0.0, half_height],
        "boundaries.1.displacement": {"y": -0.02 * half_height},
    }
    return varied(example(PROBLEM, ROUGH), changes)


def two_strengths(model: Model) -> float:
    """Returns 2 s_u of the clay [stress]."""
    clay = model.materials["clay"]
    assert isinstance(clay, Tresca)
    return 2.0 * clay.undrained_shear_strength


def compress(model: Model) -> tuple[MaterialPoints, Floats]:
    """Compresses the specimen; returns the final points and the axial stress after each step.

    The stress is the platen's force over the area of a cylinder of the specimen's volume and
    height [stress], compression positive, shape (steps,).
    """
    platen = next(b for b in model.boundaries if isinstance(b, ImplicitBoundary))
    assert isinstance(platen.geometry, PlaneGeometry)
    assert platen.displacement is not None
    height, moved = platen.geometry.point[1], platen.displacement["y"]
    stresses: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        now = height + moved * model.load_curve(platen).factor(time)
        volume = float(simulation.state.points.volume.sum())
        stresses.append(-float(result.resultant(platen.name)[1]) * now / volume)

    return march(model, after_step).state.points, np.array(stresses)
