# SPDX-License-Identifier: BSD-3-Clause
"""Two elastic cylinders of different radii and moduli pressed onto each other (Hertz)."""

from __future__ import annotations

from collections.abc import Iterator

from tilth.model import HenckyElastic, Model
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.elastic_contact import HertzCylinder, contact_modulus
from tilth_verification.comparison import Comparison, relative, vanishing
from tilth_verification.contact_runs import fitted_ellipse, run_contact

PROBLEM = "two_cylinders"
PAIR = "contact"
RADII = 3.0, 6.0
"""Of the upper and of the lower cylinder [m]."""
CELL = 0.025
HERTZ = "Hertz, 1/E* and 1/R the sums of both"


def comparisons(long: bool) -> Iterator[Comparison]:
    """Half-width and peak pressure of the contact, in the long form also on half the cells."""
    yield from cylinders(CELL)
    if long:
        yield from cylinders(0.5 * CELL)


def cylinders(cell: float) -> Iterator[Comparison]:
    """Rows: half-width and peak pressure under the force between the bodies, and its balance."""
    model = varied(example(PROBLEM), {"grid.cell_size": cell})
    run = run_contact(model)
    force = -2.0 * float(run.force[PAIR][-1, 1])
    state = run.contacts[PAIR]
    peak, width = fitted_ellipse(state, state.position[:, 0])
    exact = hertz(model)
    label = f"cell {cell:g} m"
    yield relative(f"p0, {label}", peak, exact.peak_pressure(force), 0.05, HERTZ, "Pa")
    yield relative(f"a, {label}", width, exact.half_width(force), 0.05, HERTZ, "m")
    top, base = (float(run.force[name][-1, 1]) for name in ("top", "base"))
    unbalanced = max(abs(top + base), abs(0.5 * force + top)) / (0.5 * force)
    quantity = f"forces of top, contact and base out of balance, {label}"
    yield vanishing(quantity, unbalanced, 1e-8, "equilibrium")


def hertz(model: Model) -> HertzCylinder:
    """Returns the contact of a rigid cylinder that is equivalent to that of the two bodies."""
    softness = 0.0
    for material in model.materials.values():
        assert isinstance(material, HenckyElastic)
        softness += 1.0 / contact_modulus(material)
    return HertzCylinder(1.0 / sum(1.0 / radius for radius in RADII), 1.0 / softness)
