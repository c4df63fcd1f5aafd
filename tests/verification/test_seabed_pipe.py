# SPDX-License-Identifier: BSD-3-Clause
"""A pipe in place on a coarse grid: as long as nothing opens, contact is as if it were held."""

import math

import numpy as np

from tilth_verification.cases import example, varied
from tilth_verification.contact_runs import ContactRun, run_contact
from tilth_verification.seabed_pipe import DIAMETER, EMBEDMENT, PROBLEM, in_place


def pushed_in_place(normal: str) -> ContactRun:
    law = {"normal": normal, "tangential": "smooth"}
    changes = {"rigid_bodies.0.contact": law, **in_place(EMBEDMENT)}
    changes |= {"grid.cell_size": DIAMETER / 8.0, "schedule.steps": 6}
    changes["rigid_bodies.0.displacement"] = {"x": 0.0, "y": -0.01 * DIAMETER}
    return run_contact(varied(example(PROBLEM), changes))


def test_free_to_separate_and_held_are_the_same_while_nothing_opens() -> None:
    free, held = (pushed_in_place(normal) for normal in ("unilateral", "bilateral"))
    np.testing.assert_allclose(free.force["pipe"], held.force["pipe"], rtol=1e-8, atol=1e-6)
    arc = 0.5 * DIAMETER * math.acos(1.0 - 2.0 * EMBEDMENT)
    np.testing.assert_allclose(free.area, arc, rtol=0.1)
    assert (np.diff(free.force["pipe"][:, 1]) < 0.0).all()  # ever more force, downwards
    assert held.contacts["pipe"].normal_stress.max() <= 0.0
