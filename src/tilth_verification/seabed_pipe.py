# SPDX-License-Identifier: BSD-3-Clause
"""A pipe pushed into weightless clay from its level surface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.limit_loads import SEABED_PIPE_BOUNDS, seabed_pipe
from tilth_verification.comparison import Comparison, relative
from tilth_verification.contact_runs import run_contact
from tilth_verification.curves import Curve, largest_difference

PROBLEM = "seabed_pipe"
DIAMETER, STRENGTH = 1.0, 10e3
"""Of the pipe [m]; s_u [Pa]."""
FILES = {"smooth": "case.toml", "rough": "rough.toml"}
EMBEDMENT = 0.25
"""w / D at which the published fits are compared; measured from the original surface."""
WEIGHT = 30e3
"""Of the pipe that sinks [N/m]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Smooth, to a quarter of the diameter; long: rough, wished in place, free, two grids."""
    smooth = push("smooth", 16, to=None if long else EMBEDMENT)
    yield from at_a_quarter("smooth", smooth)
    if long:
        yield from at_a_quarter("rough", push("rough", 16, to=EMBEDMENT))
        yield from wished_in_place()
        yield free()
        yield two_grids(smooth)


def at_a_quarter(face: str, curve: Curve) -> Iterator[Comparison]:
    """Row: the force at a quarter of the diameter against the fit; heave adds to it."""
    lower, upper = SEABED_PIPE_BOUNDS[EMBEDMENT, face]
    source = f"fit; wished in place {lower:g} to {upper:g}"
    factor = float(curve.at(EMBEDMENT * DIAMETER))
    quantity = f"V / (D s_u) at 0.25 D, {face}, h D/16"
    yield relative(quantity, factor, seabed_pipe(EMBEDMENT, face), 0.12, source)


def wished_in_place() -> Iterator[Comparison]:
    """Rows: a smooth pipe at a quarter of its diameter, free to separate and held.

    It is pushed down by 0.03 D from there, with the surface level. All of the contact is
    compressed, so that both are the same; the force reaches the limit load.
    """
    curves = []
    for normal in ("unilateral", "bilateral"):
        law = {"normal": normal, "tangential": "smooth"}
        model = varied(example(PROBLEM), {"rigid_bodies.0.contact": law, **in_place(EMBEDMENT)})
        curves.append(run_contact(model).curve("pipe", 1, -2.0 / (DIAMETER * STRENGTH)))
    displacement, computed, exact = largest_difference(curves[0], curves[1], 0.0)
    quantity = f"V / (D s_u) {displacement:.3g} m below its place, the farthest apart, held and not"
    yield relative(quantity, computed, exact, 1e-6, "nothing opens")
    lower, upper = SEABED_PIPE_BOUNDS[EMBEDMENT, "smooth"]
    quantity = "V / (D s_u), wished in place at 0.25 D, smooth, h D/16"
    factor, middle = float(curves[0].force[-1]), 0.5 * (lower + upper)
    yield relative(quantity, factor, middle, 0.05, f"limit analysis {lower:g} to {upper:g}")


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
        "bodies.0.surface": None,
        "bodies.0.shape": {"type": "polygon", "vertices": [*box, *arc[::-1].tolist()]},
        "rigid_bodies.0.geometry.centre": centre,
        "rigid_bodies.0.centre": centre,
        "rigid_bodies.0.displacement": {"x": 0.0, "y": -0.03 * DIAMETER},
        "rigid_bodies.0.wished_in_place": True,
        "schedule.steps": 20,
    }


def push(face: str, cells: int, to: float | None = None, step: float | None = None) -> Curve:
    """Returns V / (D s_u) against the depth, with this number of cells to the diameter.

    Args:
        to: depth of the end [m]; that of the case file if not given.
        step: depth of a step [m]; that of the case file if not given.
    """
    model = varied(example(PROBLEM, FILES[face]), {"grid.cell_size": DIAMETER / cells})
    if to is not None:
        steps = round(to / (step or 0.5 / model.schedule.number_of_steps))
        motion = {"x": 0.0, "y": -to}
        model = varied(model, {"rigid_bodies.0.displacement": motion, "schedule.steps": steps})
    return run_contact(model).curve("pipe", 1, -2.0 / (DIAMETER * STRENGTH))


def free() -> Comparison:
    """Returns a row: the depth at which a pipe stays that sinks by its weight.

    The other pipe is pushed there in as many steps.
    """
    depth = -float(run_contact(example(PROBLEM, "free.toml")).displacement[-1, 1])
    pushed = push("smooth", 16, to=0.12, step=0.0025)
    rising = np.maximum.accumulate(pushed.force)
    expected = float(np.interp(WEIGHT / (DIAMETER * STRENGTH), rising, pushed.displacement))
    quantity = "depth of a smooth pipe under 3 s_u D, h D/16"
    return relative(quantity, depth, expected, 0.01, "where the pushed pipe has this force", "m")


def two_grids(smooth: Curve) -> Comparison:
    """Returns a row: two grids, where they are farthest apart from 0.05 D to half of the diameter.

    smooth: the curve on cells of D/16.
    """
    displacement, computed, exact = largest_difference(smooth, push("smooth", 24), 0.05 * DIAMETER)
    quantity = f"V / (D s_u) at {displacement:.3g} m, the farthest apart, smooth, h D/16"
    return relative(quantity, computed, exact, 0.04, "h D/24")
