# SPDX-License-Identifier: BSD-3-Clause
"""Random rigid polygons that are pressed, pushed, turned and dropped on random blocks of soil."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries.surfaces.gap import measure_gap

WAYS = ("pressed", "pushed", "turned", "dropped", "resting")
"""Motions: down; down and sideways; down and round; by a force, without turning; free, on
springs that hold it sideways and against turning."""

YOUNG, STRENGTH = 1e6, 1e4
STEPS = 5

SAMPLES = 8
"""Places on a line at which the depth in the polygon is measured."""


def corners_of(random: np.random.Generator, size: float) -> Floats:
    """A polygon of 3 to 8 corners around the origin, anticlockwise: convex, or star-shaped."""
    count = int(random.integers(3, 9))
    share = (np.arange(count) + random.uniform(0.1, 0.9, count)) / count
    angle = 2.0 * np.pi * (share + random.random())
    convex = random.random() < 0.5
    radius = np.ones(count) if convex else random.uniform(0.45, 1.0, count)
    return size * radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def material(random: np.random.Generator) -> dict[str, Any]:
    """A soil of some strength; undrained clay is nearly incompressible."""
    name = str(random.choice(["hencky_elastic", "von_mises", "tresca", "mohr_coulomb"]))
    entries: dict[str, Any] = {
        "hencky_elastic": {"poisson_ratio": 0.3},
        "von_mises": {
            "poisson_ratio": 0.49, "yield_stress": np.sqrt(3.0) * STRENGTH, "hardening_modulus": 0.0
        },
        "tresca": {"poisson_ratio": 0.49, "undrained_shear_strength": STRENGTH},
        "mohr_coulomb": {
            "poisson_ratio": 0.3, "cohesion": STRENGTH,
            "friction_angle": random.uniform(10.0, 35.0),
            "dilation_angle": random.uniform(0.0, 10.0),
        },
    }[name]  # fmt: skip
    return {"model": name, "young_modulus": YOUNG, "density": 1800.0, **entries}


def law(random: np.random.Generator, soil: str) -> dict[str, Any]:
    """A law of contact; soil can separate in most. Elastic soil has no strength of its own."""
    normal = "unilateral" if random.random() < 0.8 else "bilateral"
    tangential = str(random.choice(["smooth", "friction", "adhesion", "rough", "bonded"]))
    if tangential == "rough" and soil == "hencky_elastic":
        tangential = "bonded"
    more: dict[str, Any] = {}
    if tangential == "friction":
        more["friction"] = random.uniform(0.1, 0.8)
    if tangential == "adhesion" or (tangential == "friction" and random.random() < 0.5):
        more["shear_limit"] = random.uniform(0.2, 1.0) * STRENGTH
    return {"normal": normal, "tangential": tangential, **more}


def motion(random: np.random.Generator, way: str, depth: float, size: float) -> dict[str, Any]:
    """The motion or the force of a body, and how far above the soil it begins."""
    if way == "pressed":
        return {"displacement": {"x": 0.0, "y": -depth}, "rotation": 0.0}
    if way == "pushed":
        aside = random.uniform(-1.0, 1.0) * depth
        rows = [[0.0, 0.0], [0.4, 0.0], [1.0, aside]]
        down = [[0.0, 0.0], [0.4, -depth], [1.0, -depth]]
        return {"displacement": {"x": rows, "y": down}, "rotation": 0.0}
    if way == "turned":
        angle = random.uniform(-1.0, 1.0) * 30.0
        down = [[0.0, 0.0], [0.4, -depth], [1.0, -depth]]
        return {
            "displacement": {"x": 0.0, "y": down},
            "rotation": [[0.0, 0.0], [0.4, 0.0], [1.0, angle]],
        }
    force = random.uniform(0.3, 1.5) * STRENGTH * size
    if way == "dropped":
        return {"displacement": {"x": 0.0}, "rotation": 0.0, "force": {"y": -force}}
    aside = random.uniform(-0.2, 0.2) * force
    return {
        "force": {"x": aside, "y": -force},
        "springs": {"x": 0.05 * YOUNG, "rotation": 0.05 * YOUNG * size**2},
    }


def problem(seed: int) -> dict[str, Any]:
    """The entries of a model."""
    random = np.random.default_rng([19, seed])
    way = WAYS[seed % len(WAYS)]
    h = random.uniform(0.15, 0.3)
    basis = str(random.choice(["linear", "gimp", "cpdi2"]))
    width, height = random.uniform(2.0, 3.0), random.uniform(1.0, 1.5)
    # a convex body, or not, somewhere over the block
    size = random.uniform(2.0, 4.0) * h
    corners = corners_of(random, size)
    x = random.uniform(-0.25, 0.25) * width
    free = way in ("dropped", "resting")
    gap = 0.0 if free or random.random() < 0.3 else random.uniform(0.0, 0.3) * h
    centre = np.array([x, gap - corners[:, 1].min()])
    vertices = corners + centre
    depth = gap + random.uniform(0.3, 1.2) * h
    soil = material(random)
    entries: dict[str, Any] = {
        "title": f"{way} polygon {seed}",
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": h, "origin": (random.uniform(-1.0, 0.0, 2) * h).tolist()},
        "materials": {"soil": soil},
        "bodies": [
            {"name": "soil", "material": "soil", "basis": basis,
             "points_per_cell": int(random.integers(2, 4)),
             "shape": {"type": "box", "lower": [-0.5 * width, -height],
                       "upper": [0.5 * width, 0.0]}}
        ],
        "boundaries": [
            {"name": "base", "type": "implicit", "condition": "fixed",
             "geometry": {"type": "plane", "point": [0.0, -height], "normal": [0.0, 1.0]}}
        ],
        "rigid_bodies": [
            {"name": "polygon",
             "geometry": {"type": "polyline", "vertices": vertices.tolist(), "closed": True,
                          "soil": "right"},
             "centre": centre.tolist(), "contact": law(random, soil["model"]),
             **motion(random, way, depth, size)}
        ],
        "schedule": {"steps": STEPS, "outputs": 1},
        "output": {"report": False},
    }  # fmt: skip
    if random.random() < 0.3:
        entries["loads"] = [{"type": "body_force", "acceleration": [0.0, -10.0]}]
    if soil["poisson_ratio"] > 0.4:
        entries["bodies"][0]["anti_locking"] = "f_bar"
    return entries


def mean_depth(simulation: Simulation) -> tuple[float, float]:
    """Mean overlap of soil and polygon where they are in contact, measured anew, and length of it.

    At a quadrature point it is what of the line along its normal lies within both, but no more than
    the depth of this part in the polygon: beside a corner the line runs along the other face. It is
    negative where the surfaces are apart: the scatter of the domains around the soil's surface has
    no mean.
    """
    (surface,) = simulation.state.contact_surfaces
    time = simulation.state.bodies[0].time
    position, normal, _ = surface.surface_points(time)
    gap, point = measure_gap(
        simulation.state.points, simulation.state.grid, simulation.state.surfaces, position, normal,
        surface.cell, surface.behind,
    )  # fmt: skip
    touching = np.flatnonzero((surface.carried[:, 2] == 1.0) & (point >= 0))
    weight, overlap = surface.weights(time, touching), -gap[touching]
    depth = np.zeros(len(touching))
    for share in (np.arange(SAMPLES) + 1.0) / SAMPLES:
        place = position[touching] - (share * overlap)[:, None] * normal[touching]
        depth = np.maximum(depth, -surface.distance(place, time))
    length = float(weight.sum())
    mean = weight @ np.minimum(overlap, depth) / length if length > 0.0 else 0.0
    return float(mean), length


def tracked_depth(simulation: Simulation) -> tuple[float, float]:
    """Mean overlap as the contact follows it, over the points in contact, and size of their parts.

    It is the gap that these points carry on; other than measured ones it knows that the soil is
    displaced beside a corner of the polygon within a cell only as the nodes allow.
    """
    (surface,) = simulation.state.contact_surfaces
    dim = simulation.setup.model.dimension
    touching = np.flatnonzero(surface.carried[:, dim] == 1.0)
    weight = surface.weights(simulation.state.bodies[0].time, touching)
    size, gap = float(weight.sum()), surface.carried[touching, dim + 2]
    return (-float(weight @ gap) / size if size > 0.0 else 0.0), size
