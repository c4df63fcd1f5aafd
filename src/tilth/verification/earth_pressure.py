# SPDX-License-Identifier: BSD-3-Clause
"""A smooth wall moved away from and into level soil: active and passive earth pressure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from tilth.model import BodyForce, ImplicitBoundary, Model, MohrCoulomb
from tilth.verification.cases import BASES, example, varied, with_basis
from tilth.verification.comparison import Comparison, relative
from tilth.verification.march import march

PROBLEM = "earth_pressure"
HEIGHT = 5.0
"""Height of the wall [m]."""
TOLERANCE = 0.03
"""With ten cells over the wall."""
ACTIVE, PASSIVE = -0.003, 0.02
"""Displacements of the wall into the soil that mobilise the limit pressures [m]."""
COHESIVE: Mapping[str, Any] = MappingProxyType(
    {
        "materials.sand.cohesion": 10e3,
        "materials.sand.friction_angle": 20.0,
        "materials.sand.dilation_angle": 20.0,
        "initial.stress.0.K0": 0.7,
    }
)
"""Changes for a soil with c 10 kPa and phi 20 degrees."""
FINE: Mapping[str, Any] = MappingProxyType(
    {"grid.cell_size": 0.25, "grid.origin": [0.075, 0.0], "bodies.0.points": [120, 40]}
)
"""Changes for twenty cells over the wall."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Sand and a cohesive soil on a smooth base, with each psi, and on a rough one; other bases.

    On the rough base flow is associated: only then is the limit load that of Rankine's stress,
    whatever the mechanism.
    """
    for changes in ({}, COHESIVE):
        smooth = varied(example(PROBLEM, "smooth_base.toml"), changes)
        at = "smooth base, ten cells"
        yield from both_ways(smooth, at)
        yield from both_ways(varied(smooth, {"materials.sand.dilation_angle": 0.0}), at)
        rough = varied(example(PROBLEM), changes)
        yield from both_ways(rough, "rough base, ten cells")
        if long:
            yield from both_ways(varied(rough, FINE), "rough base, twenty cells", 0.015)
            for basis in BASES[1:]:  # the points of the first are inaccurate beside the wall
                yield from both_ways(with_basis(smooth, basis), f"{at}, {basis}")


def both_ways(model: Model, at: str, tolerance: float = TOLERANCE) -> Iterator[Comparison]:
    """The active and the passive force at the end against Rankine's."""
    sand = model.materials["sand"]
    assert isinstance(sand, MohrCoulomb)
    c, phi, psi = sand.cohesion, sand.friction_angle, sand.dilation_angle
    soil = f"c {c / 1e3:g} kPa, phi {phi:g}, psi {psi:g} degrees"
    for state, moved in (("active", ACTIVE), ("passive", PASSIVE)):
        force = push(varied(model, {"boundaries.0.displacement": {"x": moved}}))
        exact = rankine(model, passive=moved > 0.0)
        yield relative(f"{state} force, {soil}, {at}", force, exact, tolerance, "Rankine", "N/m")


def push(model: Model) -> float:
    """Moves the wall; returns its force on the soil at the end, per unit length."""
    wall = next(b for b in model.boundaries if isinstance(b, ImplicitBoundary))
    forces: list[float] = []
    march(model, lambda _, result, time: forces.append(float(result.resultant(wall.name)[0])))
    return forces[-1]


def rankine(model: Model, *, passive: bool) -> float:
    """Returns the limit force on a smooth wall per unit length, W. J. M. Rankine's states.

    The horizontal stress K sigma_v + 2 c sqrt(K) (passive) or K sigma_v - 2 c sqrt(K) (active, a
    tension near the surface that the wall bears), with K = tan^2(45 degrees +- phi / 2), over the
    height. The change of the height is neglected: 0.3 % of the force at the end.
    """
    sand, load = model.materials["sand"], model.loads[0]
    assert isinstance(sand, MohrCoulomb)
    assert isinstance(load, BodyForce)
    assert sand.density is not None
    sign = 1.0 if passive else -1.0
    root = math.tan(0.25 * math.pi + sign * 0.5 * math.radians(sand.friction_angle))
    weight = -load.acceleration[1] * sand.density
    return 0.5 * root**2 * weight * HEIGHT**2 + sign * 2.0 * sand.cohesion * root * HEIGHT
