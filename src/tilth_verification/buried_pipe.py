# SPDX-License-Identifier: BSD-3-Clause
"""A pipe lifted in deep clay: its limit load, smooth and rough."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.limit_loads import LIFTED_PIPE_BOUNDS
from tilth_verification.comparison import Comparison, at_least, relative, vanishing
from tilth_verification.contact_runs import run_contact
from tilth_verification.curves import Curve, reaction_curve

PROBLEM = "buried_pipe"
DIAMETER = 1.0
"""Diameter of the pipe [m]."""
FLOW_LIFT = 0.03 * DIAMETER
"""Lift from which on the clay yields at a constant force [m]."""
CONTACT_LIFT = 0.06 * DIAMETER
"""Lift of the pipe as a rigid body in contact [m]."""
COARSE, FINE = DIAMETER / 8.0, DIAMETER / 16.0
"""Cell sizes [m]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Cells of an eighth of the diameter; long: of a sixteenth, and the order."""
    sizes = (COARSE, FINE) if long else (COARSE,)
    for h in sizes:
        yield from smooth(h)
    yield from graded()
    rough = [lift("rough.toml", h) for h in sizes]
    exact = bearing_factor(1.0)
    for h, curve, tolerance in zip(sizes, rough, (0.11, 0.06), strict=False):
        factor = curve.after(FLOW_LIFT).force.max()
        quantity = f"greatest F / (c D) from 0.03 D on, rough, {at(h)}"
        # a band of clay one cell thick moves with the pipe
        yield relative(quantity, factor, exact, tolerance, "2 pi + 4 sqrt(2)")
        yield limit_load(curve, f"rough, {at(h)}")
    if long:
        coarse, fine = (curve.after(FLOW_LIFT).force.mean() / exact - 1.0 for curve in rough)
        quantity = f"order of the mean of F / (c D), rough, {at(COARSE)} and {at(FINE)}"
        yield at_least(quantity, math.log2(coarse / fine), 0.8, 0.0, "first order")
        yield from in_contact()


def graded() -> Iterator[Comparison]:
    """Cells of D/16 around the pipe that grow away from it, against smaller ones."""
    coarse, fine = (lift("case.toml", graded_sizes(h)) for h in (FINE, FINE / 1.5))
    flow, reference = (curve.after(FLOW_LIFT).force for curve in (coarse, fine))
    quantity = f"greatest F / (c D) from 0.03 D on, smooth, graded, {at(FINE)}"
    yield relative(quantity, flow.max(), reference.max(), 0.01, "graded, h D/24")
    yield relative(quantity, flow.max(), 9.2, 0.1 / 9.2, "9.1 to 9.3")


def graded_sizes(h: float) -> dict[str, list[list[float]]]:
    """Returns cell sizes that grow from `h` within 0.9 D of the pipe's axis to 0.4 D."""
    return {
        "x": [[0.0, h], [0.9, h], [3.0, 0.4]],
        "y": [[0.0, 0.4], [2.1, h], [3.9, h], [6.0, 0.4]],
    }


def in_contact() -> Iterator[Comparison]:
    """A rigid body held by suction, with any adhesion, and one that a gap opens below."""
    for adhesion in (0.0, 0.25, 0.5, 0.75, 1.0):
        curve = lift_in_contact("contact.toml", FINE, {"adhesion_factor": adhesion})
        factor, exact = curve.after(FLOW_LIFT).force.max(), bearing_factor(adhesion)
        quantity = f"greatest F / (c D), contact, adhesion {adhesion:g}, {at(FINE)}"
        tolerance, source = (0.06, "exact") if adhesion == 1.0 else (0.05, "lower bound")
        yield relative(quantity, factor, exact, tolerance, source)
        quantity = f"the same over {exact:.3f}, adhesion {adhesion:g}"
        yield at_least(quantity, factor / exact, 0.99, 0.0, "lower bound")
    lower, upper = LIFTED_PIPE_BOUNDS[2.0, "smooth"]
    factor = lift_in_contact("separation.toml", FINE, {}).force.max()
    quantity = f"greatest F / (c D), gap below, centre 2 D deep, smooth, {at(FINE)}"
    source = f"limit analysis {lower:g} to {upper:g}"
    yield relative(quantity, factor, 0.5 * (lower + upper), 0.05, source)


def lift_in_contact(file: str, h: float, law: Mapping[str, object]) -> Curve:
    """Lifts the rigid body of a case file on cells of `h` [m]; returns F / (c D) and the lift."""
    changes: dict[str, object] = {
        f"rigid_bodies.0.contact.{key}": value for key, value in law.items()
    }
    base = example(PROBLEM, file)
    steps = round(base.schedule.number_of_steps * CONTACT_LIFT / (0.1 * DIAMETER))
    motion = {"x": 0.0, "y": CONTACT_LIFT}
    changes |= {"rigid_bodies.0.displacement": motion, "schedule.steps": steps}
    model = varied(base, {"grid.cell_size": h, **changes})
    shear_strength = model.materials["clay"].parameter("undrained_shear_strength")
    scale = model.track[0].scale / (shear_strength * DIAMETER)
    return run_contact(model).curve("pipe", 1, scale)


def smooth(h: float) -> Iterator[Comparison]:
    """The force is between the lower bound and slightly above the best upper one, about 9.20."""
    curve = lift("case.toml", h)
    flow = curve.after(FLOW_LIFT).force
    exact = bearing_factor(0.0)
    quantity = f"least F / (c D) from 0.03 D on, smooth, {at(h)}"
    yield at_least(quantity, flow.min(), 9.0, 0.0, "lower bound 6 + pi = 9.142")
    quantity = f"greatest F / (c D) from 0.03 D on, smooth, {at(h)}"
    yield relative(quantity, flow.max(), exact, 9.45 / exact - 1.0, "6 + pi")
    yield limit_load(curve, f"smooth, {at(h)}")


def limit_load(curve: Curve, of: str) -> Comparison:
    """Returns a row: the spread of the force from a lift of 0.03 D on, 0 for a limit load."""
    flow = curve.after(FLOW_LIFT).force
    spread = (flow.max() - flow.min()) / flow.mean()
    return vanishing(f"spread of F from 0.03 D to 0.1 D, {of}", spread, 0.02, "a limit load")


def bearing_factor(adhesion: float) -> float:
    """Returns F / (c D) of a deep pipe in contact with clay on its whole circumference [-].

    Randolph & Houlsby (1984): a lower bound, exact at adhesion 1.

    Args:
        adhesion: shear strength of the face over that of the clay, 0 smooth to 1 rough [-].
    """
    delta = math.asin(adhesion)
    angle = 0.25 * math.pi - 0.5 * delta
    fan = math.sqrt(2.0) + math.sin(angle)
    return math.pi + 2.0 * delta + 4.0 * math.cos(angle) * fan


def lift(file: str, h: float | Mapping[str, object]) -> Curve:
    """Lifts the pipe of a case file on cells of `h` [m]; returns F / (c D) against the lift."""
    model = varied(example(PROBLEM, file), {"grid.cell_size": h})
    curve = reaction_curve(model)
    shear_strength = model.materials["clay"].parameter("yield_stress") / math.sqrt(3.0)
    return Curve(curve.displacement, curve.force / (shear_strength * DIAMETER))


def at(h: float) -> str:
    """Returns the label of a cell size."""
    return f"h D/{round(DIAMETER / h)}"
