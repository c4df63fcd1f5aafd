# SPDX-License-Identifier: BSD-3-Clause
"""Slopes of soil with little or no cohesion, and the bounds of their factors of safety."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq
from spencer import SpencerSlope

from tilth import Model, StrengthReduction
from tilth.analysis.march import march
from tilth.analysis.safety import SafetyResult, strength_reduction
from tilth.model.davis import DavisForm

HEIGHT, BASE, BEHIND, AHEAD = 5.0, -2.0, 9.0, 6.0
"""Of the slope above its toe at the origin, of the base, of the soil behind and ahead [m]."""
WEIGHT = 20.0
"""Unit weight, with and without water [kN/m3]."""
LOW, HIGH = 0.95, 1.05
"""A factor of safety is above this share of Davis', below this multiple of Spencer's."""


@dataclass(frozen=True)
class SafetySlope:
    """A slope; angles in degrees, stresses in kPa.

    Attributes:
        run: horizontal over vertical.
        cohesion, friction_angle, dilation_angle: of the soil.
        wet: whether water stands at half the height behind the slope, and falls to the toe.
        angle: by which slope, gravity and boundaries are turned against the grid.
    """

    run: float
    cohesion: float
    friction_angle: float
    dilation_angle: float
    wet: bool = False
    angle: float = 0.0

    @property
    def crest(self) -> float:
        """x of the crest; the slope descends to the right, to the toe at the origin."""
        return -self.run * HEIGHT

    @property
    def water(self) -> list[tuple[float, float]] | None:
        """The phreatic surface."""
        if not self.wet:
            return None
        back = self.crest - BEHIND
        return [
            (back - 1.0, 0.4 * HEIGHT),
            (self.crest, 0.4 * HEIGHT),
            (0.0, 0.0),
            (AHEAD + 1, 0.0),
        ]

    def spencer(self) -> SpencerSlope:
        """The same for Spencer's method."""
        ground = [(self.crest - BEHIND, HEIGHT), (self.crest, HEIGHT), (0.0, 0.0), (AHEAD, 0.0)]
        return SpencerSlope(
            ground, WEIGHT, self.cohesion, self.friction_angle, BASE, self.water, 10.0
        )

    def bounds(self) -> tuple[float, float]:
        """Returns Davis' factor, form C, that is B too if psi is 0, and Spencer's."""
        slope = self.spencer()
        entries, exits = (self.crest - 5.0, self.crest + 1.0), (-1.0, 3.0)

        def excess(factor: float) -> float:
            with_davis = slope.with_davis(self.dilation_angle, factor)
            return with_davis.least_factor(entries, exits) - factor

        upper = slope.least_factor(entries, exits)
        if self.dilation_angle >= self.friction_angle:
            return upper, upper
        return float(brentq(excess, 0.6 * upper, upper, xtol=2e-3)), upper

    def model(self, cell_size: float) -> Model:
        """Returns the slope in a grid."""
        angle = math.radians(self.angle)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])

        def turned(*point: float) -> list[float]:
            return (turn @ point).tolist()  # type: ignore[no-any-return]

        back = self.crest - BEHIND
        corners = [(back, BASE), (AHEAD, BASE), (AHEAD, 0.0), (0.0, 0.0), (self.crest, HEIGHT)]
        corners.append((back, HEIGHT))
        sides = {
            "base": ((0.0, BASE), (0.0, 1.0), "fixed"), "back": ((back, 0.0), (1.0, 0.0), "roller"),
            "ahead": ((AHEAD, 0.0), (-1.0, 0.0), "roller"),
        }  # fmt: skip
        water = {}
        if self.water is not None:
            rising = [[0.0, 0.0], [1.0, 1.0]]
            water = {"water": {"level": self.water, "unit_weight": 10.0, "factor": rising}}
        entries: dict[str, Any] = {
            "analysis": {"kind": "plane_strain"},
            "grid": {"cell_size": cell_size},
            "materials": {
                "soil": {
                    "model": "mohr_coulomb", "young_modulus": 2e4, "poisson_ratio": 0.3,
                    "density": WEIGHT / 10.0, "saturated_density": WEIGHT / 10.0,
                    "cohesion": self.cohesion, "friction_angle": self.friction_angle,
                    "dilation_angle": self.dilation_angle,
                },
            },
            "bodies": [
                {
                    "name": "ground", "material": "soil", "basis": "gimp", "points_per_cell": 2,
                    "anti_locking": "f_bar",
                    "shape": {"type": "polygon", "vertices": [turned(*each) for each in corners]},
                },
            ],
            "boundaries": [
                {
                    "name": name, "type": "implicit", "condition": condition,
                    "geometry": {
                        "type": "plane", "point": turned(*point), "normal": turned(*normal)
                    },
                }
                for name, (point, normal, condition) in sides.items()
            ],
            "loads": [{"type": "body_force", "acceleration": turned(0.0, -10.0)}],
            "schedule": {"steps": 10},
            **water,
        }  # fmt: skip
        if not self.wet:
            del entries["materials"]["soil"]["saturated_density"]
        return Model.from_dict(entries)


def reduced(
    slope: SafetySlope, cell_size: float, tolerance: float = 0.01, davis: DavisForm | None = None
) -> SafetyResult:
    """Runs a slope and finds its factor of safety, or that of Davis' equivalent of a form."""
    model = slope.model(cell_size)
    settings = StrengthReduction(tolerance=tolerance, davis=davis)
    return strength_reduction(march(model), model.schedule.end, settings)


def agrees(result: SafetyResult, davis: float, spencer: float) -> bool:
    """Whether a factor is between the bounds, or what is certain of it does not contradict them."""
    return result.factor <= HIGH * spencer and result.above >= LOW * davis
