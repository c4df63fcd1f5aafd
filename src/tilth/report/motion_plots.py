# SPDX-License-Identifier: BSD-3-Clause
"""Force against displacement of boundaries and rigid bodies that move, from boundaries.csv."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.charts import Chart, Line
from tilth.report.fields import with_unit
from tilth.report.stage_marks import MOST_NAMES, Span

AXES = ("x", "y", "z")
STRAIGHT = 1e-6
"""Departure of a straight path from a line, over its length."""
_LEAST_COMPONENT = 1e-3
"""Components smaller than this share of the largest one are not drawn."""
_COLUMN = re.compile(
    r"(?P<name>.*) (?P<quantity>(displacement|force|rotation|moment)_[xyz]|radius_change|pressure)"
    r"( \[(?P<unit>.*)\])?",
    re.DOTALL,
)


@dataclass(frozen=True)
class Curve:
    """A reaction against the motion of its boundary, one value per step; NaN where it is absent."""

    motion: Floats
    motion_label: str
    reaction: Floats
    reaction_label: str


@dataclass
class _Motion:
    values: dict[str, Floats] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)

    def table(self, quantity: str, axes: Sequence[str]) -> Floats:
        """Returns the components of a vector along axes, shape (rows, len(axes))."""
        return np.column_stack([self.values[f"{quantity}_{axis}"] for axis in axes])

    def axes_of(self, quantity: str) -> list[str]:
        """Returns the axes along which there are components of a vector."""
        return [axis for axis in AXES if f"{quantity}_{axis}" in self.values]


def force_charts(curves: Sequence[Curve], ends: Sequence[tuple[str, int]] = ()) -> list[Chart]:
    """Returns a chart of each curve; ``ends`` as :func:`ends_of_stages`, marked with circles.

    Where they are few, they have their names.
    """
    found = []
    for curve in curves:
        lines = [Line(curve.motion, curve.reaction)]
        rows = [row for _, row in ends]
        if rows:
            lines.append(Line(curve.motion[rows], curve.reaction[rows], kind="rings"))
        words = [
            (float(curve.motion[row]), float(curve.reaction[row]), name)
            for name, row in ends
            if np.isfinite([curve.motion[row], curve.reaction[row]]).all()
        ]
        found.append(
            Chart(
                f"{curve.reaction_label} against {curve.motion_label}",
                curve.motion_label,
                curve.reaction_label,
                lines,
                across=[0.0],
                words=words if len(words) <= MOST_NAMES else (),
            )
        )
    return found


def motion_curves(table: Mapping[str, Floats], summary: Mapping[str, Any]) -> list[Curve]:
    """Returns the curves of all that has moved, in the order of the columns of boundaries.csv.

    ``summary`` is the declared model. A translation along a straight line has one curve, along it;
    another one a curve for each component. For a rigid body only the prescribed components have
    curves, or if there is none, the largest one.
    """
    bodies = {body["name"]: body for body in summary.get("rigid_bodies", ())}
    found: list[Curve] = []
    for name, motion in _motions(table).items():
        found += _translation(name, motion, bodies.get(name))
        found += _rotation(name, motion)
        if "radius_change" in motion.values and _moves(motion.values["radius_change"]):
            unit = motion.units["radius_change"]
            found.append(
                Curve(
                    motion.values["radius_change"],
                    with_unit(f"change of the radius of {name}", unit),
                    motion.values["pressure"],
                    with_unit(f"mean pressure of {name}", motion.units["pressure"]),
                )
            )
    return found


def caption(curves: Sequence[Curve], kind: str) -> str:
    """Returns the text below the charts."""
    per = {
        "plane_strain": " They are per unit length.",
        "axisymmetric": " They are those of the full circle.",
    }
    text = (
        "Forces and moments are those of the boundary or body on the soil; "
        "forces are positive in the direction in which displacements are positive here, so that "
        f"what pushes the soil away is positive.{per.get(kind, '')}"
    )
    if any("mean pressure" in curve.reaction_label for curve in curves):
        text += (
            " The mean pressure is the integral of the radial traction over the area that touches "
            "soil, positive in compression."
        )
    return text + " The numbers, one row per step, are in boundaries.csv."


def ends_of_stages(time: Floats, stages: Sequence[Span]) -> list[tuple[str, int]]:
    """Returns the names of the stages and the rows at their ends."""
    last = len(time) - 1
    return [
        (name, min(int(np.searchsorted(time, end, side="right")) - 1, last))
        for name, _, end in stages
    ]


def _motions(table: Mapping[str, Floats]) -> dict[str, _Motion]:
    """Returns the columns of each boundary or body by quantity."""
    found: dict[str, _Motion] = {}
    for heading, values in table.items():
        if (match := _COLUMN.fullmatch(heading)) is not None:
            motion = found.setdefault(match["name"], _Motion())
            motion.values[match["quantity"]] = values
            motion.units[match["quantity"]] = match["unit"] or ""
    return found


def _moves(values: Floats) -> bool:
    return bool(np.nanmax(np.abs(values), initial=0.0) > 0.0)


def _translation(name: str, motion: _Motion, body: Mapping[str, Any] | None) -> Iterator[Curve]:
    axes = [a for a in motion.axes_of("displacement") if f"force_{a}" in motion.values]
    if not axes:
        return
    moved, force = motion.table("displacement", axes), motion.table("force", axes)
    known = moved[np.isfinite(moved).all(axis=1)]
    if len(known) == 0 or not known.any():
        return
    _, size, directions = np.linalg.svd(known, full_matrices=False)
    if len(size) == 1 or size[1] <= STRAIGHT * size[0]:
        chosen = [_exact(directions[0])]
    else:
        prescribed = [axes.index(a) for a in (body or {}).get("displacement") or {} if a in axes]
        largest = np.abs(known).max(axis=0)
        components = [
            k
            for k in (prescribed or range(len(axes)))
            if largest[k] > _LEAST_COMPONENT * largest.max()
        ]
        if body is not None and not prescribed:
            components = [int(np.argmax(largest))]
        chosen = [np.eye(len(axes))[k] for k in components]
    for direction in chosen:
        along = known @ direction
        sign = -1.0 if along[np.argmax(np.abs(along))] < 0.0 else 1.0
        text = _direction(sign * direction, axes)
        yield Curve(
            sign * moved @ direction,
            with_unit(
                f"displacement of {name} along {text}", motion.units[f"displacement_{axes[0]}"]
            ),
            sign * force @ direction,
            with_unit(f"force of {name} along {text}", motion.units[f"force_{axes[0]}"]),
        )


def _rotation(name: str, motion: _Motion) -> Iterator[Curve]:
    for axis in motion.axes_of("rotation"):
        angle = motion.values[f"rotation_{axis}"]
        if f"moment_{axis}" in motion.values and _moves(angle):
            unit = motion.units[f"moment_{axis}"]
            yield Curve(
                angle,
                with_unit(f"rotation of {name} about {axis}", "degrees"),
                motion.values[f"moment_{axis}"],
                with_unit(f"moment of {name} about {axis}", unit),
            )


def _exact(direction: Floats) -> Floats:
    """Returns a unit vector, without the round-off of one along an axis."""
    k = int(np.argmax(np.abs(direction)))
    along = np.sign(direction[k]) * np.eye(len(direction))[k]
    return along if np.abs(direction - along).max() < STRAIGHT else direction


def _direction(direction: Floats, axes: Sequence[str]) -> str:
    """Returns a direction in words, such as "-y"."""
    if np.count_nonzero(direction) == 1:
        k = int(np.flatnonzero(direction)[0])
        return axes[k] if direction[k] > 0.0 else f"-{axes[k]}"
    numbers = ", ".join(f"{value:.3g}" for value in direction + 0.0)
    return f"({numbers})"
