# SPDX-License-Identifier: BSD-3-Clause
"""Until when the soil of a model is held, and its steps have a solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from metamorphic.models import CONTACTS, TOLERANCE
from metamorphic.runs import Moment, Run
from metamorphic.subject import Subject

NOT_SETTLED = "does not settle"


def while_settled(subject: Subject, one: Run, other: Run) -> tuple[Run, Run]:
    """Two runs up to a step of which the contact settles in one of them only.

    Contact that holds shear without pressure, and lets go of it as it opens, may be neither closed
    nor open: closed, its shear would need tension; open, soil and body would overlap. Which steps
    have no solution depends on the patches. A model that has none in its own frame says nothing.
    """
    law = CONTACTS.get(subject.choice["contact"], {})
    ends = [run for run in (one, other) if run.exit_code]
    if law.get("tangential") not in ("bonded", "rough") or len(ends) != 1:
        return one, other
    if NOT_SETTLED not in ends[0].error:
        return one, other
    end = len(ends[0].moments)
    one, other = (replace(run, moments=run.moments[:end], exit_code=0) for run in (one, other))
    return one, other


def while_upright(one: Run, other: Run) -> tuple[Run, Run]:
    """Two runs up to where the patches of a base leave the soil free to tilt in one of them only.

    Then only soft soil beside it holds a moment, and no width tells how far it tilts.
    """
    pairs = zip(one.moments, other.moments, strict=False)
    end = next((k for k, (a, b) in enumerate(pairs) if a.may_tilt != b.may_tilt), None)
    return replace(one, moments=one.moments[:end]), replace(other, moments=other.moments[:end])


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
