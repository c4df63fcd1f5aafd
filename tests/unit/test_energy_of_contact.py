# SPDX-License-Identifier: BSD-3-Clause
"""The balance of energy of blocks, plates, pipes and pairs of bodies that slide with friction.

The work of a boundary or rigid body is its force times its own motion. What is in none of the
energies, less what time integration, ghost stabilisation and gaps of contact take by their own
formulas, is the error of the balance.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from readings import long

from tilth import Model
from tilth.analysis.energies import Energies
from tilth.analysis.initial_equilibrium import find_initial_equilibrium
from tilth.analysis.run_warnings import RunWarnings
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats

END, STEPS, CELL = 0.4, 40, 0.25
LOADED = 0.15
"""Time until which gravity or a plate's pressure grows: slowly, so that little vibrates."""
LARGEST_ERROR = {
    "block": 1e-4,
    "turned block": 1e-4,
    "plate": 1e-4,
    "free plate": 1e-4,
    "pair": 1e-3,
    "pipe": 1e-4,
}
"""Of the balance over the work, or over what is stored and dissipated if that is more, in six
situations. In a pair the forces at the start of a step, when patches are others, are not those at
the end of the last one."""
Entries = dict[str, Any]


def smooth(first: float, last: float) -> list[list[float]]:
    """Factors that rise from 0 to 1 between two times without a jump of the velocity."""
    share = np.linspace(0.0, 1.0, 21)
    times, factors = first + (last - first) * share, 0.5 - 0.5 * np.cos(np.pi * share)
    rows = np.column_stack([times, factors]).tolist()
    return rows if first == 0.0 else [[0.0, 0.0], *rows]


def scaled(table: list[list[float]], factor: float) -> list[list[float]]:
    return [[time, factor * value] for time, value in table]


def flat(point: list[float], angle: float = 0.0, up: float = 1.0) -> Entries:
    normal = [-up * np.sin(angle), up * np.cos(angle)]
    return {"type": "plane", "point": point, "normal": normal}


def held(name: str, point: list[float], condition: str = "fixed", **more: Any) -> Entries:
    geometry = {"geometry": flat(point)} | more
    return {"name": name, "type": "implicit", "condition": condition, **geometry}


def situation_of(seed: int) -> str:
    return list(LARGEST_ERROR)[seed % len(LARGEST_ERROR)]


def drawn(seed: int) -> Entries:
    """A situation with friction at random: soil, basis, place in the grid, law, inertia."""
    draw = np.random.default_rng(seed)
    modulus = float(10.0 ** draw.uniform(6.5, 8.0))
    soil: Entries = {
        "model": "hencky_elastic",
        "young_modulus": modulus,
        "poisson_ratio": 0.2,
        "density": 2000.0,
    }
    if draw.random() < 0.3:
        soil |= {"model": "von_mises", "yield_stress": 0.005 * modulus, "hardening_modulus": 0.0}
    contact = {
        "normal": str(draw.choice(["unilateral", "bilateral"])),
        "tangential": "friction",
        "friction": float(draw.uniform(0.05, 0.6)),
    }
    basis = str(draw.choice(["gimp", "cpdi2", "linear"]))
    body: Entries = {"name": "soil", "material": "soil", "basis": basis, "points_per_cell": 2}
    entries: Entries = {
        "units": {"time": "s"},
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": CELL, "origin": draw.uniform(0.0, CELL, 2).tolist()},
        "materials": {"soil": soil},
        "bodies": [body],
        "schedule": {"end": END, "steps": STEPS},
        "output": {"report": False},
    }
    if draw.random() < 0.6:
        radius = float(draw.choice([0.5, 0.8]))
        entries["analysis"]["inertia"] = {"scheme": "generalised_alpha", "spectral_radius": radius}
        if basis == "linear":
            body["basis"] = "gimp"  # points that cross the lines of the grid would shake the soil
    situation = situation_of(seed)
    if situation in ("block", "turned block"):
        angle = float(draw.uniform(0.1, 0.7)) if situation == "turned block" else 0.0
        return _block(entries, contact, angle, float(draw.uniform(0.3, 0.8)))
    if situation == "pipe":
        return _pipe(entries, contact, modulus)
    if situation == "pair":
        return _pair(entries, contact)
    return _plate(entries, contact, modulus, situation == "free plate", draw.random() < 0.5)


def _block(entries: Entries, contact: Entries, angle: float, slope: float) -> Entries:
    """A block slides down a plane; without inertia the plane is drawn along under it."""
    with_inertia = "inertia" in entries["analysis"]
    along = np.array([np.cos(angle), np.sin(angle)])
    slope = slope if with_inertia else 0.0
    down = angle - slope
    shape = {"type": "box", "lower": [0.0, 0.0], "upper": [1.0, 0.5]}
    entries["bodies"][0]["shape"] = shape | ({"angle": np.degrees(angle)} if angle else {})
    plane = {
        "name": "plane", "type": "implicit", "geometry": flat([0.0, 0.0], angle),
        "contact": contact, "wished_in_place": True,
    }  # fmt: skip
    entries["boundaries"] = [plane]
    if not with_inertia:
        way = (0.05 * along).tolist()
        plane |= {"displacement": {"x": way[0], "y": way[1]}, "factor": smooth(LOADED, END)}
        stop = {"type": "plane", "point": along.tolist(), "normal": (-along).tolist()}
        entries["boundaries"].append(held("stop", [], "roller", geometry=stop))
    entries["loads"] = [
        {
            "type": "body_force",
            "acceleration": [9.81 * np.sin(down), -9.81 * np.cos(down)],
            "factor": smooth(0.0, LOADED),
        }
    ]
    return entries


def _plate(entries: Entries, contact: Entries, modulus: float, free: bool, spring: bool) -> Entries:
    """A plate is pressed on soil and drawn over it; if free by a force, maybe on a spring."""
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [0.0, 0.0], "upper": [2.0, 0.5]}
    entries["boundaries"] = [held("base", [0.0, 0.0])]
    plate: Entries = {
        "name": "plate",
        "geometry": {"type": "box", "lower": [0.5, 0.5], "upper": [1.5, 0.8], "soil": "outside"},
        "contact": contact,
        "centre": [1.0, 0.65],
        "rotation": 0.0,
        "wished_in_place": True,
        "displacement": {"x": scaled(smooth(LOADED, END), 0.08)},
    }
    if free:
        plate["force"] = {"y": scaled(smooth(0.0, LOADED), -1e-3 * modulus)}
        plate |= {"springs": {"y": 0.1 * modulus}} if spring else {}
        plate |= {"mass": 500.0} if "inertia" in entries["analysis"] else {}
    else:
        plate["displacement"]["y"] = scaled(smooth(0.0, LOADED), -5e-4)
    entries["rigid_bodies"] = [plate]
    return entries


def _pipe(entries: Entries, contact: Entries, modulus: float) -> Entries:
    """A pipe in stressed soil is pressed down and turned."""
    centre = [0.02, 0.03]
    entries["grid"]["origin"] = [0.0, 0.0]
    entries["bodies"][0]["shape"] = {
        "type": "box", "lower": [-1.0, -1.0], "upper": [1.0, 1.0],
        "holes": [{"type": "circle", "centre": centre, "radius": 0.45}],
    }  # fmt: skip
    entries["boundaries"] = [
        {"name": f"{axis}{side}", "type": "plane", "axis": axis, "at": side, "condition": "roller"}
        for axis in "xy"
        for side in (-1.0, 1.0)
    ]
    pressure = -1e-3 * modulus
    stress = {"type": "given", "body": "soil", "stress": [pressure, pressure, pressure, 0.0]}
    entries["initial"] = {"stress": [stress]}
    entries["rigid_bodies"] = [
        {
            "name": "pipe",
            "geometry": {"type": "circle", "centre": centre, "radius": 0.45, "soil": "outside"},
            "contact": contact,
            "centre": centre,
            "wished_in_place": True,
            "displacement": {"x": 0.0, "y": scaled(smooth(0.0, LOADED), -2e-4)},
            "rotation": scaled(smooth(LOADED, END), -3.0),
        }
    ]
    return entries


def _pair(entries: Entries, contact: Entries) -> Entries:
    """A block slides over another one: drawn by a lid, or with inertia by gravity."""
    ground = entries["bodies"][0]
    if ground["basis"] == "linear":
        ground["basis"] = "gimp"  # for a tracked surface
    ground["shape"] = {"type": "box", "lower": [0.0, 0.0], "upper": [2.0, 0.5]}
    shape = {"type": "box", "lower": [0.5, 0.5], "upper": [1.25, 1.0]}
    entries["bodies"] = [ground | {"name": "block", "surface": {}, "shape": shape}, ground]
    pair = {"name": "between", "bodies": ["block", "soil"], "contact": contact}
    entries["contact_pairs"] = [pair | {"wished_in_place": True}]
    entries["boundaries"] = [held("base", [0.0, 0.0])]
    if "inertia" in entries["analysis"]:
        gravity = {"type": "body_force", "acceleration": [7.0, -7.0], "factor": smooth(0.0, LOADED)}
        entries["loads"] = [gravity]
    else:
        lid = held("lid", [], geometry=flat([0.0, 1.0], up=-1.0), factor=smooth(0.0, END))
        entries["boundaries"].append(lid | {"displacement": {"x": 0.08, "y": -1e-3}})
    return entries


def balance(entries: Entries) -> tuple[dict[str, float], list[StepResult]]:
    """All energies at the end of a model's steps, and these."""
    simulation = Simulation(Model.from_dict(entries))
    if "stress" in entries.get("initial", {}):
        find_initial_equilibrium(simulation)
    energies = Energies.at_start(simulation.setup, simulation.state)
    results = []
    end, steps = entries["schedule"]["end"], entries["schedule"]["steps"]
    for before, after in pairwise(np.linspace(0.0, end, steps + 1)):
        results.append(simulation.advance(before, after))
        energies.add(results[-1])
    return energies.values(simulation.setup, simulation.state, end), results


def error_of(energies: dict[str, float]) -> float:
    """The error of the balance over the greatest of work and of what it became."""
    stated = ("time_integration", "stabilisation", "contact_gaps")
    error = energies["numerical_dissipation"] - sum(energies[kind] for kind in stated)
    found = ("elastic", "kinetic", "plastic_dissipation", "friction_dissipation")
    return error / max(abs(energies["external_work"]), sum(energies[kind] for kind in found))


@pytest.mark.parametrize("seed", [*range(12), *(long(seed) for seed in range(12, 84))])
def test_energy_is_balanced(seed: int) -> None:
    energies, _ = balance(drawn(seed))
    assert energies["friction_dissipation"] > 0.0
    assert abs(error_of(energies)) < LARGEST_ERROR[situation_of(seed)]


def test_what_ghost_stabilisation_and_gaps_take_is_told() -> None:
    """Without these two terms the balance of a turned pipe is wrong by half a per cent."""
    energies, _ = balance(drawn(11))
    size = energies["external_work"]
    assert energies["stabilisation"] > 5e-3 * size
    assert energies["contact_gaps"] < -5e-3 * size


def falling(steps: int, radius: float | None) -> Entries:
    """An elastic block that strikes a smooth plane at 1 m/s; radius: None with Newmark's method."""
    plane = {"name": "plane", "type": "implicit", "geometry": flat([0.0, 0.0])}
    plane["contact"] = {"normal": "unilateral", "tangential": "smooth"}
    entries = with_inertia([plane], 0.5, 0.2, steps)
    entries["grid"]["origin"] = [0.0, 0.03]
    entries["materials"]["soil"] |= {"young_modulus": 1e6, "poisson_ratio": 0.0}
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [0.0, 0.05], "upper": [0.5, 1.05]}
    entries["initial"] = {"velocity": [{"body": "soil", "y": -1.0}], "equilibrium": False}
    if radius is None:
        entries["analysis"]["inertia"] = {"scheme": "newmark"}
    else:
        entries["analysis"]["inertia"]["spectral_radius"] = radius
    return entries


def test_the_work_of_a_plane_at_rest_is_none_in_an_impact() -> None:
    """What soil loses or gets where a gap closes or opens in a step is that of contact's gaps."""
    energies, results = balance(falling(50, 0.5))
    start = 0.5 * 1000.0
    assert max(result.resultant("plane")[1] for result in results) > 0.0
    assert abs(energies["contact_gaps"]) > 0.01 * start
    assert abs(energies["external_work"]) < 0.1 * abs(energies["contact_gaps"])


@pytest.mark.parametrize("radius", [None, 0.1])
def test_energy_that_contact_adds_is_warned_of(radius: float | None) -> None:
    """Impacts add energy with the trapezoidal rule, and none with strong numerical damping."""
    start = 0.5 * 1000.0
    energies, _ = balance(falling(50, radius))
    stored = energies["kinetic"] + energies["elastic"]
    warnings = RunWarnings()
    warnings.contact_gives(energies, start)
    assert (stored > 1.05 * start) == (radius is None)
    assert len(warnings.texts) == (radius is None)


def test_soil_that_comes_loose_gets_nothing_from_friction() -> None:
    """Soil that its weight has bulged springs back as it lifts off, against the last traction."""
    plane = {"name": "plane", "type": "implicit", "geometry": flat([0.0, 0.0])}
    plane |= {"contact": FRICTION, "wished_in_place": True}
    left = {"name": "left", "type": "plane", "axis": "x", "at": 0.0, "condition": "roller"}
    entries = with_inertia([plane, left], 2.0, 0.1, 5)
    entries["grid"]["origin"] = [0.0, 0.1]
    entries["analysis"]["inertia"] = {"scheme": "newmark"}
    weight = [[0.0, 0.0], [0.05, 1.0], [0.06, 0.0]]
    entries["loads"] = [{"type": "body_force", "acceleration": [0.0, -9.81], "factor": weight}]
    energies, results = balance(entries)
    assert not results[-1].resultant("plane").any()
    assert min(result.friction_work for result in results) >= 0.0
    assert abs(error_of(energies)) < 1e-3


def with_inertia(boundaries: list[Entries], width: float, end: float, steps: int) -> Entries:
    """Half a metre of elastic soil (1 t/m for each metre of its width)."""
    return {
        "units": {"time": "s"},
        "analysis": {
            "kind": "plane_strain",
            "inertia": {"scheme": "generalised_alpha", "spectral_radius": 0.5},
        },
        "grid": {"cell_size": CELL, "origin": [0.0, 0.1]},
        "materials": {
            "soil": {
                "model": "hencky_elastic", "young_modulus": 1e7, "poisson_ratio": 0.2,
                "density": 2000.0,
            }
        },
        "bodies": [
            {
                "name": "soil", "material": "soil", "basis": "gimp", "points_per_cell": 2,
                "shape": {"type": "box", "lower": [0.0, 0.0], "upper": [width, 0.5]},
                "surface": {},
            }
        ],
        "boundaries": boundaries,
        "schedule": {"end": end, "steps": steps},
    }  # fmt: skip


FRICTION = {"normal": "unilateral", "tangential": "friction", "friction": 0.3}


def test_a_block_that_slides_down_a_plane() -> None:
    """A rigid block has a = g (sin - mu cos): x = a t^2 / 2, T = m (a t)^2 / 2, of friction mu N x.

    The block is elastic and its weight acts at once: it vibrates, by 2.9 J as much again as its own
    weight shortens it.
    """
    plane = {
        "name": "plane", "type": "implicit", "geometry": flat([0.0, 0.0]), "contact": FRICTION,
        "wished_in_place": True,
    }  # fmt: skip
    down, against = 5.0, 8.660254037844386
    entries = with_inertia([plane], 1.0, 0.4, 40)
    entries["loads"] = [
        {"type": "body_force", "acceleration": [down, -against], "factor": [[0, 1], [0.4, 1]]}
    ]
    energies, _ = balance(entries)
    mass, acceleration = 1000.0, down - 0.3 * against
    way = 0.5 * acceleration * 0.4**2
    assert abs(error_of(energies)) < 1e-3
    assert energies["external_work"] == pytest.approx(mass * down * way, rel=5e-3)
    kinetic = 0.5 * mass * (acceleration * 0.4) ** 2
    assert energies["kinetic"] + energies["elastic"] == pytest.approx(kinetic, rel=1e-2)
    friction = mass * 0.3 * against * way
    assert energies["friction_dissipation"] == pytest.approx(friction, rel=1.5e-2)


def test_a_plate_drawn_over_soil() -> None:
    """What the plate does at its own motion is dissipated by friction, and stored in the soil."""
    entries = with_inertia([held("base", [0.0, 0.0])], 2.0, 1.0, 20)
    way, down = [[0, 0], [0.2, 0], [1, 0.2]], [[0, 0], [0.2, -0.0005], [1, -0.0005]]
    entries["rigid_bodies"] = [
        {
            "name": "plate",
            "geometry": {
                "type": "box",
                "lower": [0.5, 0.5],
                "upper": [1.5, 0.8],
                "soil": "outside",
            },
            "contact": FRICTION,
            "centre": [1.0, 0.65],
            "displacement": {"x": way, "y": down},
            "rotation": 0.0,
            "wished_in_place": True,
        }
    ]
    energies, results = balance(entries)
    times = [result.time for result in results]
    motion = np.column_stack([np.interp(times, *zip(*rows, strict=True)) for rows in (way, down)])
    force = np.array([result.resultant("plate") for result in results])
    assert abs(error_of(energies)) < 1e-3
    assert energies["external_work"] == pytest.approx(work_at_the_end(force, motion), rel=1e-2)
    dissipated = energies["friction_dissipation"]
    assert dissipated == pytest.approx(817.0, rel=1e-2)
    assert energies["external_work"] == pytest.approx(dissipated + energies["elastic"], rel=2e-3)


def work_at_the_end(force: Floats, motion: Floats) -> float:
    """The work of forces (steps, dim) at the ends of the steps: what slides has them at once."""
    increments = np.diff(motion, axis=0, prepend=np.zeros((1, 2)))
    return float((force * increments).sum())
