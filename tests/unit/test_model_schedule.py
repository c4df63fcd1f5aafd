# SPDX-License-Identifier: BSD-3-Clause
"""Steps and output times of the schedule."""

import pytest

from tilth.errors import BadInput
from tilth.model import Schedule


def test_equal_steps_end_exactly_at_the_end() -> None:
    schedule = Schedule(end=0.7, steps=3)
    times = [schedule.regular_time(k) for k in range(4)]
    assert times == pytest.approx([0, 0.7 / 3, 1.4 / 3, 0.7], rel=1e-15)
    assert times[-1] == 0.7
    assert schedule.least_step == schedule.first_step / 1024


@pytest.mark.parametrize(
    ("end", "size", "number"), [(1.0, 0.1, 10), (0.3, 0.1, 3), (1.0, 0.3, 4), (1.0, 1.0, 1)]
)
def test_steps_of_a_given_size(end: float, size: float, number: int) -> None:
    schedule = Schedule(end=end, step_size=size)
    assert schedule.number_of_steps == number
    assert schedule.first_step == size
    assert schedule.regular_time(number) == end
    assert 0 < end - schedule.regular_time(number - 1) <= size * (1 + 1e-12)


def test_output_times() -> None:
    assert Schedule(steps=40).times_of_output() == pytest.approx([0.1 * k for k in range(1, 11)])
    assert Schedule(steps=3, outputs=1).times_of_output() == (1.0,)
    assert Schedule(steps=8, outputs=2, end=4).times_of_output() == (2.0, 4.0)
    assert Schedule(steps=5, output_every=2, end=5).times_of_output() == (2.0, 4.0, 5.0)
    assert Schedule(steps=4, output_every=2, end=4).times_of_output() == (2.0, 4.0)
    assert Schedule(steps=4, output_times=[0.25]).times_of_output() == (0.25, 1.0)
    assert Schedule(steps=4, output_times=[0.25, 1]).times_of_output() == (0.25, 1.0)
    nearly = [0.25 + 1e-14, 1.0 - 1e-12]  # as regular times are: no step of round-off between
    assert Schedule(steps=4, output_times=nearly).times_of_output() == (0.25, 1.0)


@pytest.mark.parametrize("steps", [1, 2, 3, 7, 25, 40])
def test_outputs_that_nobody_asked_for_add_no_steps(steps: int) -> None:
    schedule = Schedule(steps=steps)
    regular = {schedule.regular_time(k) for k in range(1, steps + 1)}
    outputs = schedule.times_of_output()
    assert set(outputs) <= regular
    assert outputs[-1] == 1.0
    assert len(outputs) == min(steps, 10)


@pytest.mark.parametrize(
    ("entries", "key"),
    [
        ({}, "steps"),
        ({"steps": 2, "step_size": 0.5}, "steps"),
        ({"steps": 0}, "steps"),
        ({"steps": 2.0}, "steps"),
        ({"step_size": 1.5}, "step_size"),
        ({"steps": 2, "outputs": 3, "output_every": 1}, "output_every"),
        ({"steps": 2, "output_times": [0.5, 0.5]}, "output_times"),
        ({"steps": 2, "output_times": [0.0, 0.5]}, "output_times"),
        ({"steps": 2, "output_times": [0.5, 1.1]}, "output_times"),
        ({"steps": 2, "end": 0}, "end"),
        ({"steps": 2, "minimum_step": 2}, "minimum_step"),
        ({"steps": 1_000_001}, "steps"),
        ({"steps": 10**400}, "steps"),
        ({"step_size": 1e-9}, "step_size"),
        ({"steps": 2, "minimum_step": 1e-12}, "minimum_step"),
        ({"steps": 1_000_000, "minimum_step": 1e-7}, "minimum_step"),
        ({"steps": 2, "outputs": 100_001}, "outputs"),
        ({"steps": 500_000, "output_every": 1}, "output_every"),
        ({"steps": 2, "output_times": [0.5, 0.5 + 1e-15]}, "output_times"),
        ({"steps": 2, "output_times": [1e-13, 1]}, "output_times"),
    ],
)
def test_wrong_schedules(entries: dict[str, object], key: str) -> None:
    with pytest.raises(BadInput) as caught:
        Schedule(**entries)
    assert caught.value.key == f"Schedule.{key}"


@pytest.mark.parametrize(
    ("entries", "what"),
    [
        ({"step_size": 0.1}, "is given with `step_size`"),
        ({"steps": 10, "first_step_size": 0.1}, "is not less than 0.1, the size of 10 equal steps"),
        ({"steps": 3}, "would make each step more than 10 times the one before"),
    ],
)
def test_first_steps_that_do_not_fit(entries: dict[str, float], what: str) -> None:
    with pytest.raises(BadInput, match=what) as error:
        Schedule(**{"first_step_size": 1e-4, **entries})  # type: ignore[arg-type]
    assert "first_step_size" in str(error.value)
