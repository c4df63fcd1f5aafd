# SPDX-License-Identifier: BSD-3-Clause
"""A strip footing on soil with cohesion, friction and weight: its bearing capacity.

Without dilation the capacity lies below that of associated flow and not far below that of Davis'
associated equivalent.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.model import Model
from tilth.model.davis import davis_share
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.slip_lines import Footing
from tilth_verification.comparison import Comparison, at_least, at_most, relative, vanishing
from tilth_verification.contact_runs import run_contact

PROBLEM = "strip_footing_friction"
WIDTH = 1.0
"""Width of the footing, B [m]."""
UNIT_WEIGHT = 20.0
"""Unit weight of the soil [kN/m3]."""
SOURCE = "method of characteristics"
SURCHARGE = 10.0
"""On the ground beside the footing on sand [kPa]."""
WAY, EARLY, STEP = 0.2, 0.05, 0.001
"""Penetration into sand in all, that of the bearing capacity, and in a step [m]."""


@dataclass(frozen=True)
class Soil:
    """A soil under a smooth or a rough footing, and its bearing capacity.

    Attributes:
        cohesion: [kPa].
        friction: friction angle, also of dilation [degrees].
        rough: whether the footing is perfectly rough.
        capacity: bearing pressure without settlement, by the method of characteristics [kPa].
        surcharge_factor: N_q of that friction angle [-]: settlement is a surcharge.
        settlement: of the footing at the end [m].
        width, depth: of the soil's half [m].
        surcharge: pressure on the ground beside the footing [kPa].
    """

    cohesion: float
    friction: float
    rough: bool
    capacity: float
    surcharge_factor: float
    settlement: float
    width: float
    depth: float
    surcharge: float = 0.0

    def __str__(self) -> str:
        beside = f"surcharge {self.surcharge:g}, " if self.surcharge else ""
        roughness = "rough" if self.rough else "smooth"
        return f"c {self.cohesion:g}, phi {self.friction:g}, {beside}{roughness}"


LOOSE = Soil(10.0, 20.0, False, 178.93, 6.3994, 0.005, 4.0, 2.0)
LOOSE_ROUGH = replace(LOOSE, rough=True, capacity=205.16)
DENSE = Soil(10.0, 30.0, False, 428.70, 18.4011, 0.01, 6.0, 3.0)
DENSE_ROUGH = replace(DENSE, rough=True, capacity=536.1, settlement=0.015)
WEAK = replace(DENSE, cohesion=2.0, capacity=165.1, settlement=0.005)
WEAK_ROUGH = replace(WEAK, rough=True, capacity=251.7)
SAND = replace(WEAK, cohesion=0.0, capacity=303.6, surcharge=10.0)
SAND_ROUGH = replace(SAND, rough=True, capacity=402.8, settlement=0.01)


def comparisons(long: bool) -> Iterator[Comparison]:
    """Bearing capacities on cells of B/9; long: also of B/19 and B/39, and without dilation."""
    for soil in (LOOSE, LOOSE_ROUGH):
        yield from towards_the_capacity(soil, (9, 19, 39) if long else (9,))
    for basis in ("gimp", "cpdi2"):
        pressure = capacity(LOOSE, 9, basis, implicit=True)
        quantity = f"q [kPa], {LOOSE}, implicit footing, {basis}, h B/9"
        yield relative(quantity, pressure, LOOSE.capacity, 0.12, SOURCE)
    yield from in_contact()
    if long:
        for soil in (DENSE, DENSE_ROUGH, SAND, SAND_ROUGH):
            yield from towards_the_capacity(soil, (9, 19))
        for soil in (WEAK, WEAK_ROUGH):
            yield from towards_the_capacity(soil, (9, 19), "gimp")
        for cohesion in (0.0, 0.1):
            for friction in (30.0, 37.0):
                yield from without_dilation(cohesion, friction, 9, WAY)
                yield from without_dilation(cohesion, friction, 19, EARLY)


def in_contact() -> Iterator[Comparison]:
    """The footing as a rigid body: its bearing capacity, and that it lifts off."""
    for soil in (LOOSE, LOOSE_ROUGH):
        pressure = capacity_in_contact(soil, 9)
        quantity = f"q [kPa], {soil}, rigid body, h B/9"
        yield relative(quantity, pressure, soil.capacity, 0.12, SOURCE)
    model = touched(LOOSE, 9)
    lift = [[0.0, 0.0], [0.3, -0.001], [1.0, 0.002]]
    model = varied(model, {"rigid_bodies.0.displacement": {"x": 0.0, "y": lift}})
    model = varied(model, {"rigid_bodies.0.factor": None})
    run = run_contact(model)
    pushed, lifted = -run.force["footing"][:, 1].min(), float(run.force["footing"][-1, 1])
    quantity = "force of the lifted footing over the greatest"
    yield vanishing(quantity, lifted / pushed, 1e-8, "no tension")
    yield vanishing("its area in contact [m]", float(run.area[-1]), 0.0, "no tension")


def without_dilation(
    cohesion: float, friction: float, divisions: int, way: float
) -> Iterator[Comparison]:
    """The footing of `sand.toml`: its load up to 0.05 B, and that no step is cut on its way.

    Args:
        cohesion: [kPa].
        friction: friction angle [degrees]; that of dilation is zero.
        divisions: cells to its width.
        way: its penetration at the end [m].
    """
    run = run_contact(sunk(cohesion, friction, divisions, way))
    settlement = -run.displacement[:, 1]
    tangent = math.tan(math.radians(friction))
    surcharge = math.exp(math.pi * tangent) * math.tan(math.radians(45.0 + 0.5 * friction)) ** 2
    load = -run.force["footing"][:, 1] / (0.5 * WIDTH) - UNIT_WEIGHT * settlement * surcharge
    early = load[settlement <= EARLY + 0.5 * STEP]
    name = f"c {cohesion:g}, phi {friction:g}, psi 0, h B/{divisions}"
    associated = Footing(WIDTH, cohesion, friction, UNIT_WEIGHT, SURCHARGE)
    share = float(davis_share(math.radians(friction), 0.0, 1.0, "A"))
    davis = replace(
        associated,
        cohesion=share * cohesion,
        friction_angle=math.degrees(math.atan(share * tangent)),
    )
    most = (1.12 if divisions < 15 else 1.08) * associated.rough()
    source = f"{SOURCE}, associated flow, and 12 % on h B/9, 8 % on B/19"
    yield at_most(f"greatest q to 0.05 B, {name}", float(early.max()), most, 0.0, source, "kPa")
    source = f"{SOURCE}, Davis' equivalent less 5 %"
    least = 0.95 * davis.rough()
    yield at_least(f"q at 0.05 B, {name}", float(early[-1]), least, 0.0, source, "kPa")
    steps = len(run.time) - round(way / STEP)
    yield vanishing(f"steps cut to {way / WIDTH:g} B, {name}", steps, 0.0, "none fails")


def sunk(cohesion: float, friction: float, divisions: int, way: float) -> Model:
    """Returns the model of `sand.toml` with this sand, cells of B / n and way, as above."""
    size = WIDTH / divisions
    edge, ground = 0.5 * (WIDTH - size), 3.0
    return varied(
        example(PROBLEM, "sand.toml"),
        {
            "grid.cell_size": size,
            "materials.sand.cohesion": cohesion,
            "materials.sand.friction_angle": friction,
            "bodies.0.surface.spacing": size,
            "rigid_bodies.0.geometry.lower": [-edge, ground],
            "rigid_bodies.0.geometry.upper": [edge, ground + 0.5],
            "rigid_bodies.0.displacement.y": -way,
            "schedule.steps": round(way / STEP),
        },
    )


def touched(soil: Soil, divisions: int) -> Model:
    """Returns the model of a soil under the rigid body of `contact.toml`, cells of B / n."""
    size = WIDTH / divisions
    return varied(
        example(PROBLEM, "contact.toml"),
        {
            "grid.cell_size": size,
            "materials.soil.cohesion": soil.cohesion,
            "materials.soil.friction_angle": soil.friction,
            "materials.soil.dilation_angle": soil.friction,
            "rigid_bodies.0.geometry.width": WIDTH - size,
            "rigid_bodies.0.contact.tangential": "rough" if soil.rough else "smooth",
            "rigid_bodies.0.displacement.y": -soil.settlement,
        },
    )


def capacity_in_contact(soil: Soil, divisions: int) -> float:
    """Returns the bearing pressure less the surcharge of the settlement [kPa], as `capacity`."""
    run = run_contact(touched(soil, divisions))
    load = -run.force["footing"][:, 1] / (0.5 * WIDTH)
    above = -UNIT_WEIGHT * run.displacement[:, 1]
    return float((load - above * soil.surcharge_factor).max())


def towards_the_capacity(
    soil: Soil, divisions: tuple[int, ...], basis: str = "linear"
) -> Iterator[Comparison]:
    """The bearing capacity on grids of B over these numbers, and what it tends to."""
    pressures = [capacity(soil, n, basis) for n in divisions]
    for n, pressure in zip(divisions, pressures, strict=True):
        tolerance = 0.12 if n < 15 else 0.06
        yield relative(f"q [kPa], {soil}, h B/{n}", pressure, soil.capacity, tolerance, SOURCE)
    if len(divisions) == 3:
        (_, n, m), (_, coarse, fine) = divisions, pressures
        extrapolated = fine + (fine - coarse) * n / (m - n)
        quantity = f"q [kPa], {soil}, extrapolated from h B/{n} and B/{m} at first order"
        yield relative(quantity, extrapolated, soil.capacity, 0.025, SOURCE)


def capacity(soil: Soil, divisions: int, basis: str = "linear", *, implicit: bool = False) -> float:
    """Returns the bearing pressure less the surcharge of the settlement [kPa], cells of B / n."""
    model = pressed(soil, divisions, basis, implicit=implicit)
    footing = next(b for b in model.boundaries if b.name == "footing")
    curve = model.load_curve(footing)
    pressures: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        above = UNIT_WEIGHT * curve.factor(time) * soil.settlement
        load = -result.resultant("footing")[1] / (0.5 * WIDTH)
        pressures.append(load - above * soil.surcharge_factor)

    march(model, after_step)
    return float(np.max(pressures))


def pressed(soil: Soil, divisions: int, basis: str, *, implicit: bool) -> Model:
    """Returns the model of a soil under its footing."""
    base, size = example(PROBLEM), WIDTH / divisions
    motion = {"y": -soil.settlement} | ({"x": 0.0} if soil.rough else {})
    changes: dict[str, Any] = {
        "grid.cell_size": size,
        "materials.soil.cohesion": soil.cohesion,
        "materials.soil.friction_angle": soil.friction,
        "materials.soil.dilation_angle": soil.friction,
        "bodies.0.shape.upper": [soil.width, soil.depth],
        "bodies.0.basis": basis,
        "initial.stress.0.ground": soil.depth,
        "boundaries.1.at": soil.width,
        "boundaries.3.at": soil.depth,
        "boundaries.3.displacement": motion,
    }
    if soil.surcharge:
        changes["initial.stress.0.surcharge"] = soil.surcharge
        changes["bodies.0.surface"] = {"spacing": size}
        beside = {
            "type": "surface",
            "body": "soil",
            "pressure": soil.surcharge,
            "start": [soil.width, soil.depth],
            "end": [0.5 * WIDTH, soil.depth],
            "factor": [[0, 1], [1, 1]],
        }
        changes["loads"] = [*base.to_dict()["loads"], beside]
    if implicit:
        changes = {key: value for key, value in changes.items() if "boundaries.3" not in key}
        changes["boundaries.3"] = {
            "name": "footing",
            "type": "implicit",
            "geometry": {
                "type": "footing",
                "centre": [0.0, soil.depth],
                "normal": [0.0, -1.0],
                "width": WIDTH - size,  # its edge half a cell inside that of the footing
            },
            "condition": "fixed" if soil.rough else "roller",
            "displacement": motion,
            "factor": [[0, 0], [0.5, 0.25], [1, 1]],
        }
    return varied(base, changes)
