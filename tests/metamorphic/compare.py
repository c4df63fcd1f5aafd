# SPDX-License-Identifier: BSD-3-Clause
"""Differences of two runs of the same model in different frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from metamorphic.frames import Frame, unchanged
from metamorphic.models import YOUNG
from metamorphic.runs import Moment, Run
from tilth.arrays import Floats, Integers

LEAST_STRESS = 1e-6
"""Stresses are compared with this share of Young's modulus, at least; free soil has none."""

LEAST_STRAIN = 0.01
"""Displacements are compared with this share, at least, of those that go with the stress."""


@dataclass(frozen=True)
class Scales:
    """Sizes of the quantities of a run, by which differences are divided, in the generator's units.

    A difference of the displacement of a step is in the velocity twice over the time of the step,
    and with the other sign in all that follow.
    """

    length: float
    stress: float
    force: float
    strain: float
    velocity: float
    energy: float

    @classmethod
    def of(cls, run: Run) -> Scales:
        def largest(arrays: list[Floats]) -> float:
            return max((float(np.abs(a).max(initial=0.0)) for a in arrays), default=0.0) or 1.0

        moments = run.moments
        stress = max(largest([m.stress for m in moments]), LEAST_STRESS * YOUNG)
        elastic = stress / YOUNG * float(np.ptp(run.initial, axis=0).max())
        length = max(largest([m.displacement for m in moments]), LEAST_STRAIN * elastic)
        return cls(
            length=length,
            stress=stress,
            force=max((m.size for m in moments), default=1.0) or 1.0,
            strain=max(length / run.cell, largest([m.plastic_strain for m in moments])),
            velocity=max(
                largest([m.velocity for m in moments]),
                2.0 * len(moments) * length / moments[-1].time,
            ),
            energy=max((abs(e) for m in moments for e in m.energies.values()), default=0.0) or 1.0,
        )


def matching(one: Run, other: Run, frame: Frame) -> Integers:
    """Numbers of the other run's points that are those of the first one in the frame."""
    names = sorted(set(one.body))
    away = 1e3 * (np.abs(other.initial).max() + 1.0)

    def places(initial: Floats, body: list[str]) -> Floats:
        number = np.array([names.index(name) for name in body], dtype=float)
        return np.column_stack([initial, away * number])

    tree = cKDTree(places(other.initial, other.body))
    distance, found = tree.query(places(frame.place(one.initial), one.body))
    if distance.max() > 1e-9 * away or len(set(found)) != len(one.initial):
        raise AssertionError("the points are not at the same places")
    return np.asarray(found)


def differences(
    one: Run, other: Run, frame: Frame | None = None, *, by_boundary: bool = True
) -> list[tuple[float, str]]:
    """The relative differences of two runs, and of what; infinite if they end differently.

    frame: of the other run as seen from the first one. by_boundary: whether the force of each
    boundary is compared; where two constrain a node it is that of the one declared first.
    """
    frame = frame or unchanged(one.initial.shape[1])
    if one.exit_code != other.exit_code or len(one.moments) != len(other.moments):
        return [(np.inf, f"end: {_end(one)}; {_end(other)}")]
    if not one.moments:
        return [(0.0, "")]
    match, scales = matching(one, other, frame), Scales.of(one)
    return [
        each
        for a, b in zip(one.moments, other.moments, strict=True)
        for each in _differences(a, b, match, frame, scales, by_boundary)
    ]


def difference(one: Run, other: Run) -> tuple[float, str]:
    """The largest of these in the same frame."""
    return max(differences(one, other))


def _end(run: Run) -> str:
    return f"{len(run.moments)} steps, exit code {run.exit_code}, {run.error}"


def _differences(
    a: Moment, b: Moment, match: Integers, frame: Frame, scales: Scales, by_boundary: bool
) -> list[tuple[float, str]]:
    if set(match[a.number]) != set(b.number):
        return [(np.inf, f"points at time {a.time:g}")]
    order = np.searchsorted(b.number, match[a.number])
    speed = frame.unit(1, 0, -1)
    pairs = {
        "displacement": (
            frame.length * frame.vector(a.displacement), b.displacement[order],
            frame.length * scales.length,
        ),
        "stress": (
            frame.stress * frame.tensor(a.stress), b.stress[order], frame.stress * scales.stress,
        ),
        "plastic strain": (a.plastic_strain, b.plastic_strain[order], scales.strain),
        "volume": (a.volume, b.volume[order], scales.strain),
        "velocity": (
            speed * frame.vector(a.velocity) if a.velocity.size else a.velocity,
            b.velocity[order] if b.velocity.size else b.velocity, speed * scales.velocity,
        ),
    }  # fmt: skip
    found = [
        (float(np.abs(x - y).max(initial=0.0)) / size, f"{name} at time {a.time:g}")
        for name, (x, y, size) in pairs.items()
    ]
    if a.forces.keys() != b.forces.keys():
        return [*found, (np.inf, f"boundaries with forces at time {a.time:g}")]
    force = frame.unit(*a.force_units)
    for name in a.forces if by_boundary else ():
        gap = np.abs(force * frame.vector(a.forces[name]) - b.forces[name]).max()
        found.append((float(gap) / (scales.force * force), f"force of {name} at time {a.time:g}"))
    return found
