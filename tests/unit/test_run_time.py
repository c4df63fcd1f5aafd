# SPDX-License-Identifier: BSD-3-Clause
"""The estimate of the time of a run, with a clock that counts its calls."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from resumed_runs import entries_of

import tilth.analysis.run_time
from tilth import Model
from tilth.analysis.run_time import MOST_STEPS, RunTime, duration_text, run_time_of, time_text
from tilth.analysis.staged import StagedAnalysis


def ticking(seconds: float) -> Callable[[], float]:
    """A clock that goes on by so many seconds at each call."""
    count = 0

    def clock() -> float:
        nonlocal count
        count += 1
        return seconds * count

    return clock


def iterations_of(model: Model, steps: int) -> list[int]:
    found: list[int] = []
    for _, result in StagedAnalysis(model).steps():
        found.append(result.equilibrium.iterations)
        if len(found) == steps:
            break
    return found


@pytest.fixture
def model() -> Model:
    entries = entries_of()
    entries["schedule"] = {"steps": 40}
    return Model.from_dict(entries)


def test_a_step_takes_as_long_as_those_after_the_first(model: Model) -> None:
    """Each residual and each end of a step is one call of the clock."""
    taken = iterations_of(model, MOST_STEPS)[1:]
    found = run_time_of(model, ticking(1e-6))
    assert found is not None
    assert found.measured == MOST_STEPS
    assert found.iterations == pytest.approx(sum(taken) / len(taken))
    assert found.per_step == pytest.approx(1e-6 * (sum(taken) / len(taken) + 2.0))
    assert found.seconds == pytest.approx(40 * found.per_step)


@pytest.mark.parametrize("share", [0.4, 0.9])
def test_measuring_ends_after_its_time(
    share: float, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the first step, or within it: then iterations are assumed."""
    (first,) = iterations_of(model, 1)
    monkeypatch.setattr(tilth.analysis.run_time, "ITERATIONS", 2.5)
    whole = run_time_of(model, ticking(1.0 / (first + 1.5)))
    assert whole is not None
    assert (whole.measured, whole.iterations) == (1, first)
    part = run_time_of(model, ticking(share))
    assert part is not None
    assert (part.measured, part.iterations) == (0, 2.5)
    assert part.per_step == pytest.approx(share * (1.0 + 2.5))


def test_measuring_changes_nothing(model: Model, tmp_path: Path) -> None:
    before = model.to_dict()
    assert run_time_of(model) is not None
    assert model.to_dict() == before
    assert list(tmp_path.iterdir()) == []


def test_without_equilibrium_the_time_is_not_known(model: Model) -> None:
    entries = model.to_dict()
    entries["boundaries"] = [b for b in entries["boundaries"] if b["name"] != "top"]
    entries["track"] = []
    entries["loads"][0]["acceleration"] = [0.0, -1e6]
    assert run_time_of(Model.from_dict(entries)) is None
    assert "no equilibrium" in time_text(Model.from_dict(entries))


def test_what_is_said() -> None:
    told = str(RunTime(200, 2.5, 3.25, 3, False))
    assert told == (
        "about 8.3 min: 200 steps of 2.5 s (3.25 Newton iterations), as the first 3 took here"
    )
    assert str(RunTime(1, 0.5, 3.0, 0, True)) == (
        "about 500 ms: 1 step of 500 ms (3 Newton iterations assumed), "
        "as the first iterations of the first stage took here"
    )
    texts = [duration_text(x) for x in (0.0123, 1.25, 119.0, 125.0, 7300.0, 1e5, 1e6)]
    assert texts == ["12 ms", "1.2 s", "119 s", "2.1 min", "2 h", "28 h", "12 days"]
