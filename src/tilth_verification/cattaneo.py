# SPDX-License-Identifier: BSD-3-Clause
"""A rigid cylinder pressed onto elastic soil and drawn along it without sliding (Cattaneo)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.model import HenckyElastic, Model
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.elastic_contact import (
    Cattaneo,
    HertzCylinder,
    contact_modulus,
)
from tilth_verification.comparison import Comparison, relative, vanishing
from tilth_verification.contact_runs import ContactRun, fitted_ellipse, run_contact

FILE, NAME = "cattaneo.toml", "cylinder"
RADIUS, FRICTION, CELLS = 10.0, 0.3, 12
"""Of the cylinder [m]; of the contact [-]; in half the contact of the example."""
PRESSED = 10.0
"""Time at which the cylinder is pressed on; then it is drawn."""
HERTZ, CATTANEO = "Hertz", "Cattaneo"


@dataclass(frozen=True)
class Tractions:
    """Shear along the contact in n parts, and the closed form for the forces that act.

    Attributes:
        place: along the surface of the soil [length], shape (n,).
        width: of the parts [length], shape (n,).
        shear, expected: of the surface on the soil [stress], shape (n,).
    """

    place: Floats
    width: Floats
    shear: Floats
    expected: Floats

    @property
    def error(self) -> float:
        """L2 norm of the difference over that of the closed form [-]."""
        squares = self.width @ (self.shear - self.expected) ** 2
        return float(np.sqrt(squares / (self.width @ self.expected**2)))

    def about_nodes(self, size: float) -> Tractions:
        """Returns the means over a cell's length about each node: the supports of the multipliers.

        size: of a cell, on whose multiples the nodes are [length].
        """
        part = np.floor(self.place / size + 0.5).astype(np.int64)
        part -= part.min(initial=0)
        width = np.bincount(part, self.width).astype(np.float64)
        present = width > 0.0

        def mean(value: Floats) -> Floats:
            total = np.bincount(part, self.width * value)[present]
            return np.asarray(total / width[present])

        return Tractions(mean(self.place), width[present], mean(self.shear), mean(self.expected))


def drawn_cylinder() -> Iterator[Comparison]:
    """Rows: pressure and shear under given forces, and forces and shear on the same path."""
    model = example("hertz", FILE)
    run = run_contact(model)
    found = tractions(model, run)
    label, size = f"a / h {CELLS}", model.cell_size[0]
    state, force = run.contacts[NAME], -float(run.force[NAME][-1, 1])
    middle = model.rigid_bodies[0].centre[0] + run.displacement[-1, 0]
    peak, width = fitted_ellipse(state, state.position[:, 0] - middle)
    exact = normal_contact(model)
    yield relative(f"p0, Cattaneo, {label}", peak, exact.peak_pressure(force), 0.05, HERTZ, "Pa")
    yield relative(f"a, Cattaneo, {label}", width, exact.half_width(force), 0.05, HERTZ, "m")
    quantity = f"error in L2 of the means of the shear, {label}"
    yield vanishing(quantity, found.about_nodes(size).error, 0.07, CATTANEO)
    moved = varied(model, moved_as(run))
    guided = run_contact(moved)
    for axis, name in ((0, "Q"), (1, "P")):
        computed, given = (abs(float(each.force[NAME][-1, axis])) for each in (guided, run))
        yield relative(f"{name}, displacement given", computed, given, 1e-3, "force given", "N")
    quantity = "error in L2 of the means of the shear, displacement given"
    yield vanishing(quantity, tractions(moved, guided).about_nodes(size).error, 0.07, CATTANEO)


def normal_contact(model: Model) -> HertzCylinder:
    """Returns Hertz's contact of the example."""
    material = model.materials["rubber"]
    assert isinstance(material, HenckyElastic)
    return HertzCylinder(RADIUS, contact_modulus(material))


def tractions(model: Model, run: ContactRun) -> Tractions:
    """Returns the shear at the quadrature points of the cylinder at the end of a run."""
    state, (across, down) = run.contacts[NAME], run.force[NAME][-1]
    middle = model.rigid_bodies[0].centre[0] + run.displacement[-1, 0]
    place, law = state.position[:, 0], Cattaneo(normal_contact(model), FRICTION)
    expected = law.shear(place - middle, -float(down), float(across))
    return Tractions(place, state.weight, state.shear_stress[:, 0], expected)


def moved_as(run: ContactRun) -> dict[str, object]:
    """Returns the changes by which the cylinder moves on a path of two straight lines.

    Its corners are where the cylinder was when pressed on, and at the end.
    """
    corner = run.displacement[np.abs(run.time - PRESSED).argmin()]
    rows = {
        axis: [[0.0, 0.0], [PRESSED, float(first)], [float(run.time[-1]), float(last)]]
        for axis, first, last in zip("xy", corner, run.displacement[-1], strict=True)
    }
    return {"rigid_bodies.0.force": None, "rigid_bodies.0.displacement": rows}
