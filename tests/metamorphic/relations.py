# SPDX-License-Identifier: BSD-3-Clause
"""What must hold of a model and of copies of it, without knowing its result."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np

from metamorphic import balances, bounds
from metamorphic.bounds import (
    AT_REST,
    DIES_OUT,
    HALVED,
    LEAST_OF_HALVED,
    LEFT_OF_HALVED,
    OF_STRIPS,
    STILL,
    UNLOADED,
    by_round_off,
    of_images,
    of_patches,
    of_touch,
)
from metamorphic.changes import with_rest, with_steps, with_unloading
from metamorphic.choices import has_vertical
from metamorphic.commands import commands
from metamorphic.compare import Scales, difference, differences
from metamorphic.frames import Frame, turns
from metamorphic.held import while_held, while_settled, while_upright
from metamorphic.lines import come_into_other_cells, hang_over
from metamorphic.models import CELL
from metamorphic.resumed import resumed_run
from metamorphic.runs import Run, run_in_memory
from metamorphic.subject import Subject
from metamorphic.transformed import transformed
from tilth import _core


def _of_frame(subject: Subject, frame: Frame, bound: float) -> Iterator[str]:
    """Yields how a copy in another frame differs.

    Points with linear functions that begin on a line of the grid have the strain of the cell on one
    side of it, whichever round-off decides, and their image that of another one, such as the middle
    column of nine in soil of four cells: of these nothing is known but in the same bits.
    """
    if bound > 0.0 and subject.run.on_lines:
        return
    other = run_in_memory(transformed(subject.entries, frame, subject.kind))
    yield from _excess(subject, other, bound, frame)


def _excess(
    subject: Subject, other: Run, bound: float, frame: Frame | None = None, **options: bool
) -> Iterator[str]:
    """Yields the largest of the differences of two runs that are beyond their bounds."""
    one, of_stress = subject.run, bounds.of_stress(subject, bound)
    if bound > bounds.DIFFERENCE:
        one, other = while_settled(subject, one, other)
    if bound > 0.0 and one.exit_code == other.exit_code:
        one, other = while_held(subject, one, other)
        if bound > bounds.DIFFERENCE:
            one, other = while_upright(one, other)
    beyond = [
        (size, what, of_stress if what.startswith("stress") else bound)
        for size, what in differences(one, other, frame, **options)
    ]
    beyond = [each for each in beyond if each[0] > each[2]]
    if beyond:
        size, what, most = max(beyond)
        yield f"difference {size:.1e}, at most {most:.1e}: {what}"


def _turns(subject: Subject, handedness: float) -> list[np.ndarray]:
    """The turns or mirror images that leave the vertical axis, or that of symmetry, where it is."""
    dim, found = subject.dim, turns(subject.dim)
    if has_vertical(subject.choice):
        found = [turn for turn in found if turn[-1, -1] == 1.0]
    if subject.kind == "axisymmetric":
        found = [turn for turn in found if turn[0, 0] == 1.0]
    return [turn for turn in found if Frame(turn, np.zeros(dim)).handedness == handedness]


def mirror(subject: Subject) -> Iterator[str]:
    """The mirror image of a model has the mirror image of the result."""
    turn = subject.random.choice(_turns(subject, -1.0))
    yield from _of_frame(subject, Frame(turn, np.zeros(subject.dim)), of_images(subject))


def turn(subject: Subject) -> Iterator[str]:
    """A model that is turned by 90 or 180 degrees has the result turned."""
    turn = subject.random.choice(_turns(subject, 1.0))
    yield from _of_frame(subject, Frame(turn, np.zeros(subject.dim)), of_images(subject))


def shift(subject: Subject) -> Iterator[str]:
    """A model moved by whole cells has the same result there."""
    random = subject.random
    along = np.array([random.randint(-9, 9) for _ in range(subject.dim)])
    if subject.kind == "axisymmetric":
        along[0] = 0
    yield from _of_frame(subject, Frame(np.eye(subject.dim), CELL * along), by_round_off(subject))


def units(subject: Subject) -> Iterator[str]:
    """In units that are powers of four of the others all numbers are multiples, to the bit.

    But for the logarithms of Cam Clay.
    """
    random = subject.random
    length, stress, time = (4.0 ** random.randint(-3, 3) for _ in range(3))
    frame = Frame(np.eye(subject.dim), np.zeros(subject.dim), length, stress, time)
    bound = by_round_off(subject) if subject.choice["law"] == "modified_cam_clay" else 0.0
    yield from _of_frame(subject, frame, bound)


def order(subject: Subject) -> Iterator[str]:
    """The order of bodies, boundaries, loads and materials has no meaning."""
    other = copy.deepcopy(subject.entries)
    for name in ("bodies", "boundaries", "rigid_bodies", "contact_pairs", "loads"):
        if name in other:
            other[name].reverse()
    other["materials"] = dict(reversed(other["materials"].items()))
    yield from _excess(subject, run_in_memory(other), by_round_off(subject), by_boundary=False)


def resume(subject: Subject) -> Iterator[str]:
    """A run that is restored from its state after a step goes on as it would have."""
    steps = len(subject.run.moments)
    if steps > 1:
        other = resumed_run(subject.entries, subject.random.randint(1, steps - 1))
        yield from _excess(subject, other, 0.0)


def threads(subject: Subject) -> Iterator[str]:
    """The number of threads changes no bit."""
    before, least = _core.threads(), _core.parallel_from()
    _core.set_threads(3)
    _core.set_parallel_from(0)
    try:
        other = run_in_memory(subject.entries)
    finally:
        _core.set_threads(before)
        _core.set_parallel_from(least)
    yield from _excess(subject, other, 0.0)


def halved(subject: Subject) -> Iterator[str]:
    """Each step divided in two, and in four: the results come nearer to each other.

    Soil that yields does not have to so soon: what yields first in a step follows the elastic guess
    of all of the step, and as long as a zone begins to yield only in shorter ones the differences
    grow. Those of eighths and sixteenths must be less than both those before and those of halves.
    """
    runs = [subject.run.at_regular_times(), *_divided(subject, 2, 4)]
    (first, _), (second, what) = difference(*runs[:2]), difference(*runs[1:])
    if second <= max(HALVED * first, LEAST_OF_HALVED):
        return
    if _crosses_lines(subject, runs) or any(hang_over(subject.run.moments)):
        return
    text = f"differences {first:.1e} of halved steps and {second:.1e} of quarters"
    if any((moment.plastic_strain > 0.0).any() for moment in subject.run.moments):
        runs = [runs[-1], *_divided(subject, 8, 16)]
        (third, _), (last, what) = difference(*runs[:2]), difference(*runs[1:])
        if last <= HALVED * min(first, third):
            return
        text += f", {third:.1e} of eighths and {last:.1e} of sixteenths"
    yield f"{text}: {what}"


def _divided(subject: Subject, *factors: int) -> list[Run]:
    """The runs with each step divided into so many, at the times of the subject's own."""
    runs = (run_in_memory(with_steps(subject.entries, factor)) for factor in factors)
    return [run.at_regular_times(subject.run) for run in runs]


def _crosses_lines(subject: Subject, runs: list[Run]) -> bool:
    """Whether the strain of a point with linear functions is in other runs that of another cell."""
    return subject.choice["basis"] == "linear" and any(
        (one.cell != other.cell).any()
        for run in runs[1:]
        for one, other in zip(runs[0].moments, run.moments, strict=False)
        if one.cell.shape == other.cell.shape
    )


def rest(subject: Subject) -> Iterator[str]:
    """While nothing changes the soil moves by what the change of basis explains, less and less.

    Points of a linear basis that come into other cells act on other nodes, which the next step, or
    the next stage little by little, brings back into balance: as often as they do. Where patches
    change from step to step, as under a sphere that soil has just touched, the soil has moved for
    other means than those that it is now held by.
    """
    run, before = run_in_memory(with_rest(subject.entries)), len(subject.run.moments)
    if run.exit_code:
        yield f"a stage in which nothing changes ends with {run.error}"
        return
    moments = run.moments[before - 1 :]
    moved = [
        float(np.abs(after.position - earlier.position).max())
        for earlier, after in pairwise(moments)
    ]
    largest = Scales.of(subject.run).length
    most = max(AT_REST, of_patches(subject), of_touch(subject))
    if any(hang_over(moments)):
        most = max(most, OF_STRIPS)
    if max(moved) > most * largest:
        yield f"soil at rest moves by {max(moved) / largest:.1e} of its displacement"
    elif moved[-1] > max(DIES_OUT * moved[0], STILL * largest) and not (
        subject.choice["basis"] == "linear" and come_into_other_cells(moments[:-1])
    ):
        text = ", ".join(f"{each / largest:.1e}" for each in moved)
        yield f"the motion of soil at rest does not die out: {text} of its displacement"


def unload(subject: Subject) -> Iterator[str]:
    """Elastic soil goes back to where it was, or in half the steps by twice what is left."""
    left = []
    for factor in (1, 2):
        run = run_in_memory(with_steps(with_unloading(subject.entries), factor))
        if run.exit_code:
            yield f"unloading ends with {run.error}"
            return
        left.append(float(np.abs(run.moments[-1].displacement).max()) / Scales.of(run).length)
        if left[0] <= UNLOADED:
            return
    if left[1] > LEFT_OF_HALVED * left[0]:
        yield f"{left[0]:.1e} of the displacement is left, {left[1]:.1e} with halved steps"


def balance(subject: Subject) -> Iterator[str]:
    """Forces, moments and energies are in balance after each step."""
    yield from balances.faults(subject)


Relation = Callable[[Subject], Iterator[str]]
RELATIONS: dict[str, Relation] = {
    "balance": balance, "mirror": mirror, "turn": turn, "shift": shift, "units": units,
    "order": order, "resume": resume, "threads": threads, "rest": rest, "halved": halved,
    "unload": unload, "commands": commands,
}  # fmt: skip


def faults(subject: Subject) -> list[str]:
    """What does not hold of a model: its balances, and the relation chosen.

    A model that has no equilibrium, or is refused as its soil is placed, says nothing.
    """
    if subject.run.exit_code:
        return []
    names = dict.fromkeys(["balance", subject.choice["relation"]])
    return [f"{name}: {text}" for name in names for text in RELATIONS[name](subject)]
