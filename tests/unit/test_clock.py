# SPDX-License-Identifier: BSD-3-Clause
"""The clock of adaptive load steps: hits its events exactly, halves, grows, gives up."""

from __future__ import annotations

import numpy as np
import pytest

from tilth.analysis.clock import GROW_AFTER, Clock
from tilth.model import Schedule


def march(clock: Clock, fails: set[int] = frozenset()) -> list[float]:  # type: ignore[assignment]
    """Times accepted until the end; attempts whose number is in `fails` are cut."""
    times, attempt = [], 0
    while not clock.done:
        after = clock.next_time()
        assert after > clock.time
        if attempt in fails:
            assert clock.cut()
        else:
            clock.accept(after)
            times.append(after)
        attempt += 1
        assert attempt < 10_000
    return times


@pytest.mark.parametrize("steps", [1, 3, 7, 40, 365])
@pytest.mark.parametrize("end", [1.0, 0.3, 1e6 / 3])
def test_regular_times_are_hit_exactly(steps: int, end: float) -> None:
    schedule = Schedule(steps=steps, end=end, outputs=1)
    times = march(Clock(schedule))
    assert times == [schedule.regular_time(k) for k in range(1, steps + 1)]
    assert times[-1] == end


def test_last_step_of_a_step_size_is_shorter() -> None:
    assert march(Clock(Schedule(step_size=0.3, outputs=1))) == [0.3, 0.6, pytest.approx(0.9), 1.0]


def test_output_times_between_steps_are_hit_exactly() -> None:
    schedule = Schedule(steps=4, output_times=[0.1, 1 / 3, 0.5])
    times = march(Clock(schedule))
    assert times == [0.1, 0.25, 1 / 3, 0.5, 0.75, 1.0]


@pytest.mark.parametrize("seed", range(20))
def test_all_events_are_hit_whatever_fails(seed: int) -> None:
    random = np.random.default_rng(seed)
    outputs = sorted(set(random.uniform(0.01, 1.0, 5).tolist()))
    schedule = Schedule(steps=10, output_times=outputs, minimum_step=1e-9)
    fails = set(random.integers(0, 60, 15).tolist())
    times = march(Clock(schedule), fails)
    events = {schedule.regular_time(k) for k in range(1, 11)} | set(outputs)
    assert events <= set(times)
    assert np.all(np.diff([0.0, *times]) > 0)
    assert np.diff([0.0, *times]).max() <= 0.1 * (1 + 1e-8)


def test_failed_step_is_halved_and_grows_back() -> None:
    clock = Clock(Schedule(steps=4, outputs=1))
    assert clock.next_time() == 0.25
    assert clock.cut()
    assert clock.next_time() == 0.125
    assert clock.cut()
    assert clock.next_time() == 0.0625
    sizes = []
    while not clock.done:
        before = clock.time
        clock.accept(clock.next_time())
        sizes.append(clock.time - before)
    # two of each size before it doubles; the fifth is cut short by the regular time 0.5
    assert sizes == [0.0625, 0.0625, 0.125, 0.125, 0.125, 0.25, 0.25]
    assert GROW_AFTER == 2


def test_cut_halves_the_step_that_failed_not_the_regular_one() -> None:
    """A step shortened by an output time is itself halved, so that a retry is never the same."""
    clock = Clock(Schedule(steps=2, output_times=[0.1]))
    assert clock.next_time() == 0.1
    assert clock.cut()
    assert clock.next_time() == 0.05


def test_least_step_ends_the_halving() -> None:
    clock = Clock(Schedule(steps=2, minimum_step=0.25, outputs=1))
    assert clock.cut()  # 0.25
    assert clock.cut()  # 0.125 = a quarter of 0.5: still allowed
    assert not clock.cut()
    assert clock.time == 0.0
    assert clock.step == 0


def test_without_adaptivity_a_failed_step_is_the_end() -> None:
    assert not Clock(Schedule(steps=2, adaptive=False)).cut()


@pytest.mark.parametrize(
    ("until", "time"),
    [(0.3, 0.3), (0.29, 0.3), (0.31, 0.4), (0.05, 0.1), (1e-13, 0.1), (0.95, 1.0), (1.0, 1.0)],
)
def test_the_clock_stops_with_the_first_step_that_reaches_the_time(
    until: float, time: float
) -> None:
    schedule = Schedule(steps=10)
    clock, whole = Clock(schedule, until=until), Clock(schedule)
    while not clock.stops:
        assert clock.next_time() == whole.next_time()
        clock.accept(clock.next_time())
        whole.accept(whole.next_time())
    assert clock.time == pytest.approx(time, rel=1e-14)
    assert clock.done == (time == 1.0)
    assert not whole.stops


def test_a_stop_is_reached_to_round_off() -> None:
    schedule = Schedule(steps=3, end=0.3)
    time = schedule.regular_time(2)
    assert time < 0.2  # by round-off
    assert Clock(schedule, step=2, time=time, until=0.2).stops


@pytest.mark.parametrize("stop", range(1, 12))
def test_restored_clock_goes_on_as_the_first(stop: int) -> None:
    schedule = Schedule(steps=3, output_times=[0.2, 0.7], minimum_step=1e-3)

    def times(restore_at: int) -> list[float]:
        clock, found, attempt = Clock(schedule), [], 0
        while not clock.done:
            after = clock.next_time()
            if attempt in (1, 2, 5):
                assert clock.cut()
            else:
                clock.accept(after)
                found.append(after)
                if len(found) == restore_at:
                    clock = Clock(
                        schedule, step=clock.step, time=clock.time, size=clock.size,
                        successes=clock.successes,
                    )  # fmt: skip
            attempt += 1
        return found

    assert times(stop) == times(0)


@pytest.mark.parametrize("seed", range(30))
def test_events_are_found_without_a_list_of_all_steps(seed: int) -> None:
    """At every event, and beside it, the next one is that of the sorted list of all."""
    random = np.random.default_rng(seed)
    end = 10.0 ** random.uniform(-20, 20)
    steps = int(random.integers(1, 400))
    size = {"steps": steps} if seed % 2 else {"step_size": end / random.uniform(1, 400)}
    ways = [{"outputs": 7}, {"output_every": 3}, {}, {"output_times": [0.1 * end, 0.77 * end]}]
    schedule = Schedule(end=end, **size, **ways[seed % 4])  # type: ignore[arg-type]
    outputs = schedule.times_of_output()
    regular = [schedule.regular_time(k) for k in range(1, schedule.number_of_steps + 1)]
    events = sorted({*regular, *outputs})
    for event in [0.0, *events]:
        for time in (np.nextafter(event, 0.0), event, np.nextafter(event, 2 * end)):
            if 0.0 <= time < end:
                clock = Clock(schedule, time=float(time), size=2 * end)
                assert clock.next_time() == next(each for each in events if each > time)
                assert clock.is_output == (time in outputs)


def test_a_million_steps_take_no_time_to_declare_and_to_search() -> None:
    schedule = Schedule(steps=1_000_000, end=1e9, outputs=100_000)
    clock = Clock(schedule, time=schedule.regular_time(987_654))
    for _ in range(1000):
        clock.accept(clock.next_time())
    assert clock.time == schedule.regular_time(988_654)


def test_a_step_that_cannot_be_shortened_is_the_end() -> None:
    """Just before an event the shortest step would be extended to it again, for ever."""
    schedule = Schedule(steps=1, minimum_step=1e-9, outputs=1)
    clock = Clock(schedule, time=1.0 - 1.5e-9, size=1e-9)
    assert clock.next_time() == 1.0
    assert not clock.is_least
    assert not clock.cut(share=0.1)


GROWING = Schedule(steps=30, first_step_size=1e-3, end=100.0, outputs=1)


def test_steps_that_grow() -> None:
    times = np.array([0.0, *march(Clock(GROWING))])
    sizes = np.diff(times)
    assert (len(sizes), sizes[0], times[-1]) == (30, pytest.approx(1e-3), 100.0)
    np.testing.assert_allclose(sizes[1:] / sizes[:-1], sizes[1] / sizes[0], rtol=1e-9)
    assert times.tolist() == [GROWING.regular_time(k) for k in range(31)]


def test_steps_that_grow_go_on_after_cuts_and_from_any_time() -> None:
    clock = Clock(GROWING)
    times = march(clock, fails={3, 4, 20, 21, 22})
    regular = [GROWING.regular_time(k) for k in range(1, 31)]
    assert set(regular) <= set(times)
    assert times[-5:] == regular[-5:]
    later = Clock(GROWING, step=7, time=times[11], size=0.0)
    assert march(later) == [time for time in regular if time > times[11]]


def test_outputs_between_steps_that_grow_are_hit() -> None:
    asked = [1e-3 * (1.0 + 1e-12), 0.5, 7.0]
    schedule = Schedule(steps=30, first_step_size=1e-3, end=100.0, output_times=asked)
    times = march(Clock(schedule))
    assert {schedule.regular_time(1), 0.5, 7.0} <= set(times)
    assert len(times) == 32
