# SPDX-License-Identifier: BSD-3-Clause
"""Shapes of random problems with curved boundaries, in the problem's own axes and in cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Floats

Random = np.random.Generator


@dataclass(frozen=True)
class Frame:
    """A problem's own axes, in which lengths are in cells: turned, moved and scaled."""

    turn: Floats
    origin: Floats
    cell: float

    def direction(self, own: Any) -> list[Any]:
        return (np.asarray(own) @ self.turn.T).tolist()

    def place(self, own: Any) -> list[Any]:
        return (self.origin + self.cell * np.array(self.direction(own))).tolist()

    def set_in(self, own: dict[str, Any]) -> dict[str, Any]:
        """A shape or a boundary that is declared in the own axes, in those of the grid."""
        placed = dict(own)
        for key, value in own.items():
            if key in ("point", "centre", "vertices"):
                placed[key] = self.place(value)
            elif key in ("normal", "axis") and not isinstance(value, str):
                placed[key] = self.direction(value)
            elif key in ("radius", "radius_change"):
                placed[key] = self.cell * value
            elif key == "displacement":
                by = self.cell * np.array(self.direction(value))
                placed[key] = dict(zip("xyz", by.tolist(), strict=False))
            elif isinstance(value, dict):
                placed[key] = self.set_in(value)
        return placed


@dataclass(frozen=True)
class Round:
    """A closed curve about its centre: a circle, a regular polygon or an ellipse."""

    type: str
    centre: Floats
    radius: float
    corner: Floats
    ratio: float
    tilt: float

    @classmethod
    def drawn(cls, random: Random, centre: Any, radius: float) -> Round:
        corners = int(random.integers(4, 7))
        turn = random.uniform(0.0, 2.0 * np.pi) + np.arange(corners) * 2.0 * np.pi / corners
        ratio, tilt = random.uniform(0.6, 0.8), random.uniform(0.0, np.pi)
        type_ = str(random.choice(["circle", "polyline", "spline"]))
        return cls(type_, np.array(centre), radius, np.sort(turn % (2.0 * np.pi)), ratio, tilt)

    def at(self, angle: Any) -> Floats:
        """Its places in the directions of polar angles."""
        angle = np.asarray(angle)
        out = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        length = np.full(angle.shape, self.radius)
        if self.type == "spline":
            along, across = np.cos(angle - self.tilt), np.sin(angle - self.tilt)
            length = self.radius / np.sqrt(along**2 + (across / self.ratio) ** 2)
        elif self.type == "polyline":
            half = np.pi / len(self.corner)
            from_corner = (angle - self.corner[0]) % (2.0 * half)
            length = self.radius * np.cos(half) / np.cos(from_corner - half)
        return np.asarray(self.centre + length[..., None] * out)

    def arc(self, start: float, end: float) -> Floats:
        """Its places from one angle to another, with all corners."""
        low, high = min(start, end), max(start, end)
        angle = np.linspace(low, high, round((high - low) / (np.pi / 16.0)) + 1)
        if self.type == "polyline":
            corner = self.corner[:, None] + 2.0 * np.pi * np.arange(-2, 3)
            corner = corner[(corner > low + 1e-3) & (corner < high - 1e-3)]
            angle = np.unique(np.concatenate([[low], corner.ravel(), [high]]))
        return self.at(angle if end > start else angle[::-1])

    def geometry(self, soil: str) -> dict[str, Any]:
        if self.type == "circle":
            return {"type": "circle", "centre": self.centre, "radius": self.radius, "soil": soil}
        angle = self.corner if self.type == "polyline" else np.arange(16) * np.pi / 8.0
        side = "left" if soil == "inside" else "right"
        return {"type": self.type, "vertices": self.at(angle), "closed": True, "soil": side}


def beyond(corners: Floats, normal: Any, least: float) -> Floats:
    """The part of a polygon with places @ normal >= least; it begins behind the cut, if any."""
    side = corners @ np.asarray(normal) - least
    side[np.abs(side) < 1e-9] = 0.0
    kept: list[Floats] = []
    first = 0
    for k, (a, b) in enumerate(zip(side, np.roll(side, -1), strict=True)):
        one, two = corners[k], corners[(k + 1) % len(corners)]
        if a >= 0.0:
            kept.append(one)
        if a * b < 0.0:
            kept.append(one + a / (a - b) * (two - one))
        if a < 0.0 <= b:
            first = len(kept) - (1 if b > 0.0 else 0)
    return np.roll(np.array(kept), -first, axis=0)


def pieces(outline: Floats, hole: Round | None, on_axis: bool) -> list[Floats]:
    """The polygon without its hole: one piece, or the halves on both sides of the hole's centre."""
    if hole is None:
        return [beyond(outline, [1.0, 0.0], 0.0)] if on_axis else [outline]
    quarter, at = 0.5 * np.pi, hole.centre[0]
    right = [beyond(outline, [1.0, 0.0], at), hole.arc(quarter, -quarter)]
    left = [beyond(outline, [-1.0, 0.0], -at), hole.arc(3.0 * quarter, quarter)]
    return [np.concatenate(half) for half in ([right] if on_axis else [right, left])]


def floor_of(random: Random, low: float, high: float) -> tuple[str, Floats, dict[str, Any]]:
    """The floor of a block: what it is, its places from left to right, and its geometry."""
    type_ = str(random.choice(["plane", "polyline", "spline", "circle"]))
    x = np.linspace(low, high, 25)
    if type_ == "plane":
        slope = random.uniform(-0.2, 0.2)
        places = np.array([[low, slope * low], [high, slope * high]])
        return type_, places, {"type": type_, "point": [0.0, 0.0], "normal": [-slope, 1.0]}
    if type_ == "circle":
        radius, sign = high * random.uniform(1.6, 3.0), 1.0 if random.random() < 0.5 else -1.0
        places = np.column_stack([x, sign * (radius - np.sqrt(radius**2 - x**2))])
        soil = "inside" if sign > 0.0 else "outside"
        circle = {"type": type_, "centre": [0.0, sign * radius], "radius": radius, "soil": soil}
        return f"circle, {soil}", places, circle
    if type_ == "polyline":
        kinks = np.linspace(low, high, int(random.integers(3, 6)))
        places = np.column_stack([kinks, random.uniform(-0.6, 0.6, len(kinks))])
        chain = np.vstack([places[0] - [2.0, 0.0], places, places[-1] + [2.0, 0.0]])
    else:
        size, phase, wave = random.uniform([0.2, 0.0, 5.0], [0.6, 2.0 * np.pi, 9.0])
        longer = np.arange(low - 2.0, high + 2.0, 0.4)
        chain, places = (
            np.column_stack([k, size * np.sin(phase + 2.0 * np.pi * k / wave)]) for k in (longer, x)
        )
    return type_, places, {"type": type_, "vertices": chain, "soil": "left"}
