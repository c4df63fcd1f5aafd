# SPDX-License-Identifier: BSD-3-Clause
"""Free rigid bodies with inertia on a block of soil, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth import Model
from tilth.analysis.simulation import Simulation

GRAVITY, RADIUS, DENSITY = 10.0, 0.2, 3000.0
VOLUME = {
    "plane_strain": np.pi * RADIUS**2,
    "axisymmetric": 4.0 / 3.0 * np.pi * RADIUS**3,
    "3d": 4.0 / 3.0 * np.pi * RADIUS**3,
}
"""Of a circle, or of a sphere."""


def falling(
    kind: str,
    *,
    strength: float | None = 5e3,
    density: float = DENSITY,
    velocity: float = -1.0,
    gap: float = 0.01,
    end: float = 0.1,
    steps: int = 20,
    width: float = 0.5,
    depth: float = 0.4,
    cell: float = 0.1,
    young: float = 1.5e6,
    rho: float = 0.5,
    length: float = 1.0,
    time: float = 1.0,
    **body: Any,
) -> dict[str, Any]:
    """A ball that falls on clay, or on elastic soil without a strength, above the middle.

    `length` and `time` are units: how often the ones of the numbers go into them; force keeps its.
    """
    dim = 3 if kind == "3d" else 2
    up = "xyz"[dim - 1]
    centre = [0.0] * (dim - 1) + [(RADIUS + gap) * length]
    if kind != "axisymmetric":
        centre[0] = 0.013 * length
    sides = [
        {"name": f"{axis} {end}", "type": "plane", "axis": axis, "at": at * length,
         "condition": "roller"}
        for axis in "xyz"[: dim - 1]
        for end, at in (("low", -width), ("high", width))
        if not (kind == "axisymmetric" and end == "low")
    ]  # fmt: skip
    lower = [0.0 if kind == "axisymmetric" else -width] * (dim - 1) + [-depth]
    upper = [width] * (dim - 1) + [0.0]
    mass = density * VOLUME[kind] * time**2 / length
    if kind == "plane_strain":
        mass /= length  # per length, as the force
    inertia: dict[str, Any] = {}
    if kind != "axisymmetric":
        moment = 0.4 * mass * (RADIUS * length) ** 2
        inertia["moments_of_inertia"] = [moment] * 3 if dim == 3 else 1.25 * moment
    stress = length**-2
    soil: dict[str, Any] = {
        "young_modulus": young * stress, "density": 1600.0 * time**2 / length**4
    }  # fmt: skip
    if strength is None:
        soil |= {"model": "hencky_elastic", "poisson_ratio": 0.3}
    else:
        soil |= {
            "model": "von_mises", "poisson_ratio": 0.49, "hardening_modulus": 0.0,
            "yield_stress": np.sqrt(3.0) * strength * stress,
        }  # fmt: skip
    return {
        "units": {"time": "s"},
        "analysis": {
            "kind": kind, "tolerance": 1e-8,
            "inertia": {"scheme": "generalised_alpha", "spectral_radius": rho},
        },
        "grid": {"cell_size": cell * length},
        "materials": {"soil": soil},
        "bodies": [
            {"name": "soil", "material": "soil", "basis": "gimp", "points_per_cell": 2,
             "anti_locking": "none" if strength is None else "f_bar",
             "shape": {"type": "box", "lower": [length * x for x in lower],
                       "upper": [length * x for x in upper]}}
        ],
        "boundaries": [
            {"name": "base", "type": "plane", "axis": up, "at": -depth * length,
             "condition": "fixed"}, *sides,
        ],
        "rigid_bodies": [
            {
                "name": "ball", "centre": centre, "mass": mass,
                "geometry": {"type": "sphere" if dim == 3 else "circle", "centre": centre,
                             "radius": RADIUS * length, "soil": "outside"},
                "contact": {"normal": "unilateral", "tangential": "friction", "friction": 0.3},
                "velocity": [0.0] * (dim - 1) + [velocity * length / time],
                **inertia, **body,
            }
        ],
        "loads": [
            {"type": "body_force", "factor": [[0.0, 1.0], [time * end, 1.0]],
             "acceleration": [0.0] * (dim - 1) + [-GRAVITY * length / time**2]}
        ],
        "schedule": {"end": time * end, "steps": steps},
    }  # fmt: skip


def fallen(entries: dict[str, Any], steps: int | None = None) -> Simulation:
    """The state after some steps, or after all."""
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    schedule = simulation.setup.model.schedule
    for number in range(steps or schedule.number_of_steps):
        simulation.advance(schedule.regular_time(number), schedule.regular_time(number + 1))
    return simulation
