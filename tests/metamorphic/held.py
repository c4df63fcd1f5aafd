# SPDX-License-Identifier: BSD-3-Clause
"""Until when the soil of a model is held."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from metamorphic.models import TOLERANCE
from metamorphic.runs import Moment, Run
from metamorphic.subject import Subject


def while_held(subject: Subject, one: Run, other: Run) -> tuple[Run, Run]:
    """Two runs up to where soil without weight has come off all that held it upwards.

    It is in balance at any height then, also in one that a step's iteration has thrown it to: only
    the weak springs, of 1e-8 of the soil's stiffness, tell where. With inertia it has a motion.
    """
    choice = subject.choice
    holds = choice["driver"] in ("footing", "prescribed_plane")
    if choice["base"] != "contact" or choice["inertia"] != "none" or holds:
        return one, other
    end = min(_steps_held(one), _steps_held(other))
    return replace(one, moments=one.moments[:end]), replace(other, moments=other.moments[:end])


def _steps_held(run: Run) -> int:
    """The number of steps until the base bears nothing."""
    bears = [_bears(moment) for moment in run.moments]
    return bears.index(False) if False in bears else len(bears)


def _bears(moment: Moment) -> bool:
    least = np.sqrt(moment.nodes) * TOLERANCE * moment.size
    return float(np.linalg.norm(moment.forces.get("base", np.zeros(1)))) > least
