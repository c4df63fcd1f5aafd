# SPDX-License-Identifier: BSD-3-Clause
"""A pipe pushed into weightless clay from its level surface, and one that sinks by its weight."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.verification.cases import example, varied
from tilth.verification.closed_forms.limit_loads import SEABED_PIPE_BOUNDS, seabed_pipe
from tilth.verification.comparison import Comparison, relative
from tilth.verification.contact_runs import run_contact
from tilth.verification.curves import Curve, largest_difference

PROBLEM = "seabed_pipe"
DIAMETER, STRENGTH = 1.0, 10e3
"""Of the pipe [m]; s_u [Pa]."""
FILES = {"smooth": "case.toml", "rough": "rough.toml"}
EMBEDMENT = 0.25
"""w / D at which the published fits are compared; measured from the original surface."""
WEIGHT = 30e3
"""Of the pipe that sinks [N/m]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Smooth, to a quarter of the diameter; long: rough, two grids to half of it, glued, free."""
    smooth = push("smooth", 16, to=EMBEDMENT)
    yield from at_a_quarter("smooth", smooth)
    if long:
        yield from at_a_quarter("rough", push("rough", 16, to=EMBEDMENT))
        for face in FILES:
            fine = push(face, 24)
            displacement, computed, exact = largest_difference(push(face, 16), fine, 0.05)
            quantity = (
                f"V / (D s_u) at {displacement:.3g} m, the farthest apart, {face}, h D/16, D/24"
            )
            yield relative(quantity, computed, exact, 0.04, "the other grid")
        yield from glued()
        yield free(smooth)


def at_a_quarter(face: str, curve: Curve) -> Iterator[Comparison]:
    """Row: the force at a quarter of the diameter against the fit; heave adds to it."""
    lower, upper = SEABED_PIPE_BOUNDS[EMBEDMENT, face]
    source = f"fit; wished in place {lower:g} to {upper:g}"
    factor = float(curve.at(EMBEDMENT * DIAMETER))
    quantity = f"V / (D s_u) at 0.25 D, {face}, h D/16"
    yield relative(quantity, factor, seabed_pipe(EMBEDMENT, face), 0.12, source)


def glued() -> Iterator[Comparison]:
    """Row: a bonded pipe that may separate and one that may not, while nothing opens."""
    contacts = [
        {"normal": normal, "tangential": "bonded"} for normal in ("unilateral", "bilateral")
    ]
    parting, held = (push("smooth", 16, to=0.1, contact=contact) for contact in contacts)
    displacement, computed, exact = largest_difference(parting, held, 0.02)
    quantity = f"V / (D s_u) at {displacement:.3g} m, the farthest apart, bonded and glued"
    yield relative(quantity, computed, exact, 1e-6, "nothing opens")


def free(pushed: Curve) -> Comparison:
    """Returns a row: the depth at which a pipe stays that sinks by its weight."""
    run = run_contact(example(PROBLEM, "free.toml"))
    depth = -float(run.displacement[-1, 1])
    rising = np.maximum.accumulate(pushed.force)
    expected = float(np.interp(WEIGHT / (DIAMETER * STRENGTH), rising, pushed.displacement))
    quantity = "depth of a smooth pipe under 3 s_u D, h D/16"
    return relative(quantity, depth, expected, 0.02, "where the pushed pipe has this force", "m")


def push(
    face: str, cells: int, to: float | None = None, contact: dict[str, str] | None = None
) -> Curve:
    """Returns V / (D s_u) against the depth, with this number of cells to the diameter.

    Args:
        to: depth of the end [m]; that of the case file if not given.
        contact: another law.
    """
    model = varied(example(PROBLEM, FILES[face]), {"grid.cell_size": DIAMETER / cells})
    if to is not None:
        steps = round(model.schedule.number_of_steps * to / 0.5)
        motion = {"x": 0.0, "y": -to}
        model = varied(model, {"rigid_bodies.0.displacement": motion, "schedule.steps": steps})
    if contact is not None:
        model = varied(model, {"rigid_bodies.0.contact": contact})
    return run_contact(model).curve("pipe", 1, -2.0 / (DIAMETER * STRENGTH))
