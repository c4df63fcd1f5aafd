# SPDX-License-Identifier: BSD-3-Clause
"""Patch test of contact: uniform pressure and shear through turned surfaces across the cells."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.model import Model
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, relative, vanishing
from tilth_verification.contact_runs import run_contact

PROBLEM = "contact_patch"
YOUNG, POISSON = 1e7, 0.3
CORNER = np.array([0.43, 0.17])
"""Lower left corner of the layer, about which it is turned [m]."""
LENGTH, THICKNESS = 5.0, 0.4
"""Of the layer [m]."""
PRESSED, SHEARED = 0.01, 0.01
"""Motion of the plate over the layer's thickness, towards the floor and along it [-]."""
ENDS = 2.0
"""What is nearer to an end of the layer than this [m] feels it: at five thicknesses, as measured,
1e-4 of the stress."""
OVERHANG = 0.2
"""Of the plate beyond the layer's ends [m]."""
SOURCE = "uniform stress"


@dataclass(frozen=True)
class Spread:
    """Pressure or shear stress on the middle of a surface.

    Attributes:
        mean: weighted by area [stress].
        largest: greatest deviation from the mean, over the mean [-].
        variation: coefficient of variation, weighted by area [-].
    """

    mean: float
    largest: float
    variation: float

    @classmethod
    def of(cls, value: Floats, weight: Floats) -> Spread:
        """Returns that of a quantity, shape (n,)."""
        mean = float(np.average(value, weights=weight))
        deviation = value / mean - 1.0
        squares = np.average(deviation**2, weights=weight)
        return cls(mean, float(np.abs(deviation).max()), float(np.sqrt(squares)))


def comparisons(long: bool) -> Iterator[Comparison]:
    """Pressure and shear on floor and plate at several angles and places; long: more of both."""
    angles = (0.0, 17.0, 30.0, 45.0) if long else (17.0, 45.0)
    shifts = (0.0, 0.37, 0.73) if long else (0.37,)
    for angle in angles:
        for shift in shifts:
            yield from uniform(turned(example(PROBLEM), angle, shift), angle, shift)
    if long:
        fine = turned(example(PROBLEM), 17.0, 0.37, 0.05)
        yield from uniform(fine, 17.0, 0.37, ", cells half as large")


def uniform(model: Model, angle: float, shift: float, label: str = "") -> Iterator[Comparison]:
    """Rows: means and greatest deviations of pressure and shear on floor and plate."""
    exact = dict(zip(("pressure", "shear"), stress_in_layer(), strict=True))
    at = f"{angle:g} degrees, moved by {shift:g} cells{label}"
    for surface, found in spreads(model, angle, shift).items():
        for name, spread in zip(("pressure", "shear"), found, strict=True):
            quantity = f"{name} on the {surface}, {at}"
            yield relative(quantity, spread.mean, exact[name], 1e-3, "closed form", "Pa")
            yield vanishing(f"deviation of the {quantity}", spread.largest, 0.01, SOURCE)


def spreads(model: Model, angle: float, shift: float) -> dict[str, tuple[Spread, Spread]]:
    """Returns pressure and shear stress on the middle of floor and plate."""
    run, found = run_contact(model), {}
    normal, tangent = directions(angle)
    corner = CORNER + shift * model.cell_size[0]
    for name in ("floor", "plate"):
        state = run.contacts[name]
        along = (state.position - corner) @ tangent
        middle = state.in_contact & (along > ENDS) & (along < LENGTH - ENDS)
        weight = state.weight[middle]
        shear = state.shear_stress[middle] @ tangent * np.sign(state.normal[0] @ normal)
        found[name] = Spread.of(-state.normal_stress[middle], weight), Spread.of(-shear, weight)
    return found


def stress_in_layer() -> tuple[float, float]:
    """Returns pressure and shear stress on the plate [Pa] of a layer that is infinitely long.

    Hencky's law with the deformation gradient [[1, s], [0, 1 - p]]: pressed by p, sheared by s.
    """
    gradient = np.eye(3)
    gradient[0, 1], gradient[1, 1] = SHEARED, 1.0 - PRESSED
    value, vector = np.linalg.eigh(gradient @ gradient.T)
    strain = 0.5 * np.log(value)
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    lame = 2.0 * shear * POISSON / (1.0 - 2.0 * POISSON)
    principal = (lame * strain.sum() + 2.0 * shear * strain) / np.linalg.det(gradient)
    stress = (vector * principal) @ vector.T
    return -float(stress[1, 1]), float(stress[0, 1])


def directions(angle: float) -> tuple[Floats, Floats]:
    """Returns normal and tangent of the floor at an angle [degrees], shape (2,) each."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return np.array([-s, c]), np.array([c, s])


def turned(model: Model, angle: float, shift: float, cell: float | None = None) -> Model:
    """Returns the model at an angle [degrees], moved by a share of its cell along both axes.

    cell: size of its cells [m] if not that of the model.
    """
    size = model.cell_size[0] if cell is None else cell
    normal, tangent = directions(angle)
    corner = CORNER + shift * size
    top = corner + THICKNESS * normal
    low, high = top - OVERHANG * tangent, top + (LENGTH + OVERHANG) * tangent
    thick = 0.3 * normal
    moved = THICKNESS * (SHEARED * tangent - PRESSED * normal)
    return varied(model, {
        "grid.cell_size": size,
        "bodies.0.shape.lower": corner.tolist(),
        "bodies.0.shape.upper": (corner + np.array([LENGTH, THICKNESS])).tolist(),
        "bodies.0.shape.angle": angle,
        "boundaries.0.geometry.point": corner.tolist(),
        "boundaries.0.geometry.normal": normal.tolist(),
        "rigid_bodies.0.geometry.vertices": [
            each.tolist() for each in (low, high, high + thick, low + thick)
        ],
        "rigid_bodies.0.centre": top.tolist(),
        "rigid_bodies.0.displacement.x": float(moved[0]),
        "rigid_bodies.0.displacement.y": float(moved[1]),
    })  # fmt: skip
