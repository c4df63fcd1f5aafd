# SPDX-License-Identifier: BSD-3-Clause
"""A pipe pushed into weightless clay from its level surface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth.verification.cases import example, varied
from tilth.verification.closed_forms.limit_loads import SEABED_PIPE_BOUNDS, seabed_pipe
from tilth.verification.comparison import Comparison, relative
from tilth.verification.contact_runs import run_contact
from tilth.verification.curves import Curve

PROBLEM = "seabed_pipe"
DIAMETER, STRENGTH = 1.0, 10e3
"""Of the pipe [m]; s_u [Pa]."""
FILES = {"smooth": "case.toml", "rough": "rough.toml"}
EMBEDMENT = 0.25
"""w / D at which the published fits are compared; measured from the original surface."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Smooth, to a quarter of the diameter; long: rough, wished in place."""
    smooth = push("smooth", 16, to=EMBEDMENT)
    yield from at_a_quarter("smooth", smooth)
    if long:
        yield from at_a_quarter("rough", push("rough", 16, to=EMBEDMENT))
        yield wished_in_place()


def at_a_quarter(face: str, curve: Curve) -> Iterator[Comparison]:
    """Row: the force at a quarter of the diameter against the fit; heave adds to it."""
    lower, upper = SEABED_PIPE_BOUNDS[EMBEDMENT, face]
    source = f"fit; wished in place {lower:g} to {upper:g}"
    factor = float(curve.at(EMBEDMENT * DIAMETER))
    quantity = f"V / (D s_u) at 0.25 D, {face}, h D/16"
    yield relative(quantity, factor, seabed_pipe(EMBEDMENT, face), 0.12, source)


def wished_in_place() -> Comparison:
    """Returns a row: the limit load of a smooth pipe at a quarter of its diameter.

    It is pushed down by 0.03 D from there, with the surface level.
    """
    law = {"normal": "unilateral", "tangential": "smooth"}
    model = varied(example(PROBLEM), {"rigid_bodies.0.contact": law, **in_place(EMBEDMENT)})
    curve = run_contact(model).curve("pipe", 1, -2.0 / (DIAMETER * STRENGTH))
    lower, upper = SEABED_PIPE_BOUNDS[EMBEDMENT, "smooth"]
    quantity = "V / (D s_u), wished in place at 0.25 D, smooth, h D/16"
    factor, middle = float(curve.force[-1]), 0.5 * (lower + upper)
    return relative(quantity, factor, middle, 0.05, f"limit analysis {lower:g} to {upper:g}")


def in_place(embedment: float) -> dict[str, Any]:
    """Returns the changes that carve the pipe's place out of the soil and push it by 0.03 D."""
    radius, surface, width = 0.5 * DIAMETER, 2.5, 3.0
    height = radius - embedment * DIAMETER
    angle = np.linspace(-0.5 * np.pi, -np.arcsin(height / radius), 25)
    arc = np.column_stack([radius * np.cos(angle), surface + height + radius * np.sin(angle)])
    arc[0, 0] = 0.0
    box = [[0.0, 0.0], [width, 0.0], [width, surface]]
    centre = [0.0, surface + height]
    return {
        "bodies.0.shape": {"type": "polygon", "vertices": [*box, *arc[::-1].tolist()]},
        "rigid_bodies.0.geometry.centre": centre,
        "rigid_bodies.0.centre": centre,
        "rigid_bodies.0.displacement": {"x": 0.0, "y": -0.03 * DIAMETER},
        "schedule.steps": 20,
    }


def push(face: str, cells: int, to: float | None = None) -> Curve:
    """Returns V / (D s_u) against the depth, with this number of cells to the diameter.

    Args:
        to: depth of the end [m]; that of the case file if not given.
    """
    model = varied(example(PROBLEM, FILES[face]), {"grid.cell_size": DIAMETER / cells})
    if to is not None:
        steps = round(model.schedule.number_of_steps * to / 0.5)
        motion = {"x": 0.0, "y": -to}
        model = varied(model, {"rigid_bodies.0.displacement": motion, "schedule.steps": steps})
    return run_contact(model).curve("pipe", 1, -2.0 / (DIAMETER * STRENGTH))
