# SPDX-License-Identifier: BSD-3-Clause
"""Steps of flowing water by the local error of the pore pressure."""

from __future__ import annotations

import numpy as np
import pytest
from consolidating import with_flow
from small_problems import block_entries, rollers

from tilth import AnalysisFailed
from tilth.analysis.simulation import Simulation
from tilth.errors import StepFailed
from tilth_verification import terzaghi
from tilth_verification.cases import varied
from tilth_verification.consolidating import Consolidation, consolidate

MIDDLE = [0.0, 0.5 * terzaghi.HEIGHT]


def consolidated(most: float, scheme: str = "backward_euler", **schedule: float) -> Consolidation:
    """A column under a load that jumps, in at least four steps; most: error over the load."""
    model = terzaghi.column(16, 4)
    entries = {f"schedule.{key}": value for key, value in schedule.items()}
    entries |= {"flow.largest_error": most * terzaghi.LOAD, "flow.scheme": scheme}
    return consolidate(varied(model, entries), [MIDDLE])


def worst(found: Consolidation) -> float:
    """Greatest error of the pressure in the middle over the load, after the first cells drained."""
    exact = terzaghi.closed_form(terzaghi.column(16, 4))
    late = [i for i, time in enumerate(found.time) if time > 0.02 * exact.unit]
    errors = [
        float(found.pressure[i][0]) / terzaghi.LOAD - exact.pressure(MIDDLE[1], found.time[i])
        for i in late
    ]
    return float(np.abs(errors).max())


@pytest.mark.parametrize(
    ("scheme", "steps", "errors"),
    [("backward_euler", (34, 64), (0.0081, 0.0037)), ("bdf2", (34, 65), (0.0031, 0.0018))],
)
def test_steps_follow_from_the_error(
    scheme: str, steps: tuple[int, int], errors: tuple[float, float]
) -> None:
    """Also the first one; the errors add up to less than that of the coarsest step."""
    for most, count, error in zip((0.01, 0.002), steps, errors, strict=True):
        found = consolidated(most, scheme, minimum_step=1e-6)
        assert len(found.steps) == pytest.approx(count, abs=3)
        assert found.steps[0] < 3e-3 * max(found.steps)
        assert worst(found) < error


def test_a_large_limit_changes_nothing() -> None:
    model = terzaghi.column(16, 4)
    free = consolidate(model, [MIDDLE])
    limited = consolidated(1e3)
    assert limited.time == free.time
    np.testing.assert_array_equal(limited.pressure, free.pressure)


def test_the_run_fails_where_the_least_step_is_too_long() -> None:
    with pytest.raises(AnalysisFailed, match=r"flow\.largest_error = 1e-08"):
        consolidated(1e-5, minimum_step=0.1)


def test_the_error_is_that_of_the_step() -> None:
    """A flux that begins: half of the water of the step comes too late or too early."""
    entries = block_entries("plane_strain", "gimp", "hencky_elastic", cells=4)
    entries["boundaries"] = rollers("plane_strain", 4.0)
    entries["schedule"] = {"end": 1.0, "steps": 1}
    found = []
    for size in (1e-3, 5e-4):
        place = {"type": "plane", "point": [0.0, 1.5], "normal": [0.0, 1.0]}
        flux = {"name": "in", "type": "implicit", "condition": "flux", "flux": 1e-3,
                "geometry": place}  # fmt: skip
        model = with_flow(entries, [flux], largest_error=1e-12)
        with pytest.raises(StepFailed) as failure:
            Simulation(model).advance(0.0, size)
        assert failure.value.share is not None
        found.append(failure.value.share)
    assert found[1] / found[0] == pytest.approx(2.0**0.5, rel=0.05)
