# SPDX-License-Identifier: BSD-3-Clause
"""A smooth wall moved away from and into level soil: active and passive earth pressure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from tilth.analysis.march import march
from tilth.analysis.step_result import StepResult
from tilth.model import BodyForce, ImplicitBoundary, Model, MohrCoulomb
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.comparison import Comparison, at_least, at_most, relative, vanishing

PROBLEM = "earth_pressure"
HEIGHT, LENGTH = 5.0, 15.0
"""Height of the wall, and length of the soil beside it [m]."""
TOLERANCE = 0.03
"""With ten cells over the wall."""
ACTIVE, PASSIVE = -0.003, 0.02
"""Displacements of the wall into the soil that mobilise the limit pressures [m]."""
FAR, STEPS = 0.1, 100
"""How far the wall is pushed in, over its height [-], and in how many steps."""
MORE_ITERATIONS = 4.0
"""Iterations that a step with psi = 0 may take more than one with psi = phi, in the mean."""
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
    whatever the mechanism. With psi = 0 the wall is also pushed in by a tenth of its height.
    """
    yield from far_in_a_uniform_layer("none")
    if long:
        yield from far_in_a_uniform_layer("f_bar")
        yield from far_in_a_wedge()
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


@dataclass(frozen=True)
class Push:
    """A wall pushed in by `FAR` times its height.

    Attributes:
        moved: of the wall at the end [m].
        force: on the soil at the end, per unit length [N/m].
        iterations: of a step, in the mean.
        cut: steps more than declared.
    """

    moved: float
    force: float
    iterations: float
    cut: int

    def coefficient(self, model: Model, rise: float) -> float:
        """Returns K_p of a force K_p gamma (H + rise)^2 / 2 [-]."""
        return 2.0 * self.force / (weight_of(model) * (HEIGHT + rise) ** 2)


def pushed_far(model: Model) -> Push:
    """Pushes the wall of sand without dilation in."""
    moved = FAR * HEIGHT
    changes = {"boundaries.0.displacement": {"x": moved}, "schedule.steps": STEPS}
    forces: list[float] = []
    iterations: list[int] = []

    def after_step(_: Any, result: StepResult, time: float) -> None:
        forces.append(float(result.resultant("wall")[0]))
        iterations.append(result.equilibrium.iterations)

    march(varied(model, changes), after_step)
    mean = sum(iterations) / len(iterations)
    return Push(moved, forces[-1], mean, len(forces) - STEPS)


def far_in_a_uniform_layer(anti_locking: str) -> Iterator[Comparison]:
    """On the smooth base the whole layer yields alike, so that its stress is that of Rankine.

    It is shortened by the way of the wall, keeps its volume, and so rises alike everywhere.
    """
    model = example(PROBLEM, "smooth_base.toml")
    changes = {"materials.sand.dilation_angle": 0.0, "bodies.0.anti_locking": anti_locking}
    model = varied(model, changes)
    run = pushed_far(model)
    rise = HEIGHT * run.moved / (LENGTH - run.moved)
    at = f"wall pushed in by {FAR:g} H, psi 0, smooth base, anti-locking {anti_locking}"
    found, exact = run.coefficient(model, rise), passive_coefficient(math.radians(30.0))
    yield relative(f"K_p of the risen soil, {at}", found, exact, TOLERANCE, "Rankine")
    yield vanishing(f"steps that were cut, {at}", run.cut, 0.0, "none")


def far_in_a_wedge() -> Iterator[Comparison]:
    """On the rough base a wedge slides up: between Davis' equivalent and Rankine's strength.

    A rigid wedge over a plane at 45 degrees - phi / 2, L = H tan(45 degrees + phi / 2) long at its
    surface, rises by the way of the wall d times tan(45 degrees - phi / 2): the volume d H that
    the wall displaces, over L. Davis' sin(phi) is the tangent of the friction angle for psi = 0.
    """
    model = example(PROBLEM)
    phi = math.radians(30.0)
    run = pushed_far(varied(model, {"materials.sand.dilation_angle": 0.0}))
    found = run.coefficient(model, run.moved * root_of_coefficient(-phi))
    at = f"wall pushed in by {FAR:g} H, psi 0, rough base"
    least, most = passive_coefficient(math.atan(math.sin(phi))), passive_coefficient(phi)
    quantity = f"K_p of the risen soil, {at}"
    yield at_least(f"{quantity}, least", found, (1.0 - TOLERANCE) * least, 0.0, "Davis less 3 %")
    yield at_most(f"{quantity}, most", found, (1.0 + TOLERANCE) * most, 0.0, "Rankine and 3 %")
    yield vanishing(f"steps that were cut, {at}", run.cut, 0.0, "none")
    more = max(0.0, run.iterations - pushed_far(model).iterations)
    quantity = f"iterations a step more than with psi = phi, {at}"
    yield vanishing(quantity, more, MORE_ITERATIONS, "psi = phi")


def passive_coefficient(phi: float) -> float:
    """Returns Rankine's K_p of a friction angle [radians]."""
    return root_of_coefficient(phi) ** 2


def root_of_coefficient(phi: float) -> float:
    """Returns the root of Rankine's K_p of a friction angle [radians], with -phi that of K_a."""
    return math.tan(0.25 * math.pi + 0.5 * phi)


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
    sand = model.materials["sand"]
    assert isinstance(sand, MohrCoulomb)
    sign = 1.0 if passive else -1.0
    root = root_of_coefficient(sign * math.radians(sand.friction_angle))
    own = 0.5 * root**2 * weight_of(model) * HEIGHT**2
    return own + sign * 2.0 * sand.cohesion * root * HEIGHT


def weight_of(model: Model) -> float:
    """Returns the unit weight of the soil [N/m3]."""
    sand, load = model.materials["sand"], model.loads[0]
    assert isinstance(load, BodyForce)
    assert sand.density is not None
    return -load.acceleration[1] * sand.density
