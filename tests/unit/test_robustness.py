# SPDX-License-Identifier: BSD-3-Clause
"""Random bodies on implicit boundaries: every analysis comes to its end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from small_problems import CORNER_BASES

from tilth import AnalysisFailed, BadInput, Model
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats

FEW, MANY = 12, 200
DRAWN = ("linear", "gimp")
"""The bases that the seeds choose from. Others are given, so that no seed's problem changes."""


def half_plane(corners: Floats, normal: Floats, least: float) -> Floats:
    """The part of a polygon (n, 2), star-shaped about a place in the half plane, that is in it."""
    kept: list[Floats] = []
    for one, two in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        a, b = one @ normal - least, two @ normal - least
        if a >= 0.0:
            kept.append(one)
        if a * b < 0.0:
            kept.append(one + a / (a - b) * (two - one))
    return np.array(kept)


@dataclass(frozen=True)
class Problem:
    """A random problem.

    Attributes:
        entries: the model; a body force, if it has one, has the size 1 yet.
        text: what it is, for the list of those that stop.
        pushed: whether a platen drives it; otherwise its body force.
    """

    entries: dict[str, Any]
    text: str
    pushed: bool


def problem_of(seed: int, given: str | None = None) -> Problem:
    """A convex or star-shaped polygon with a flat base on a plane or in the corner of a box.

    A flat top opposite to the base carries the platen. A basis that is given replaces the drawn
    one; all else stays as it is.
    """
    random = np.random.default_rng([20, seed])
    star, in_box, pushed, plastic = (random.random(4) < 0.5).tolist()
    drawn = str(random.choice(DRAWN))
    angle = random.uniform(0.0, 360.0)
    turn = np.radians(angle)
    along, up = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    around = np.linspace(0.0, 2.0 * np.pi, int(random.integers(7, 14)), endpoint=False)
    radius = random.uniform(0.6, 1.0, len(around)) if star else np.full(len(around), 0.9)
    stretch = random.uniform(0.8, 1.2, 2)
    corners = radius[:, None] * np.column_stack([np.cos(around), np.sin(around)]) * stretch
    own = half_plane(corners, np.array([0.0, 1.0]), -random.uniform(0.2, 0.45))
    if in_box:
        own = half_plane(own, np.array([1.0, 0.0]), -random.uniform(0.2, 0.45))
    own = half_plane(own, np.array([0.0, -1.0]), -random.uniform(0.2, 0.45))
    centre = random.uniform(-1.0, 1.0, 2)
    base, top = own[:, 1].min(), own[:, 1].max()
    vertices = centre + own @ np.array([along, up])

    def place(x: float, y: float) -> list[float]:
        return (centre + x * along + y * up).tolist()

    if in_box:
        lower = place(own[:, 0].min(), base)
        box = {"type": "box", "lower": lower, "upper": (np.array(lower) + 3.0).tolist(),
               "angle": angle, "soil": "inside", "faces": ["x-", "y-"]}  # fmt: skip
        walls = [implicit("corner", box)]
    else:
        walls = [implicit("base", flat(place(0.0, base), up.tolist()), "fixed")]
    loads, load = [], ""
    if pushed:
        on_top = own[np.isclose(own[:, 1], top), 0]
        width = random.uniform(0.4, 1.2) * np.ptp(on_top)
        middle = on_top.mean() + random.uniform(-0.2, 0.2) * np.ptp(on_top)
        platen = {"type": "footing", "centre": place(middle, top), "normal": (-up).tolist(),
                  "width": float(width)}  # fmt: skip
        depth = random.uniform(0.05, 0.15) * (top - base)
        condition = str(random.choice(["roller", "fixed"]))
        walls.append(
            implicit("platen", platen, condition,
                     displacement=dict(zip("xy", (-depth * up).tolist(), strict=True)))
        )  # fmt: skip
        load = f"{condition} platen {width:.2f} wide, {depth:.3f} down"
    else:
        side = random.uniform(-1.0, 1.0)
        force = side * along - up
        loads = [{"type": "body_force", "acceleration": force.tolist()}]
        load = f"body force with a slope of {side:.2f}"
    nu = random.uniform(0.0, 0.45)
    soil: dict[str, Any] = {
        "model": "von_mises" if plastic else "hencky_elastic",
        "young_modulus": 1000.0, "poisson_ratio": nu, "density": 1.0,
    }  # fmt: skip
    if plastic:
        soil["yield_stress"] = random.uniform(5.0, 50.0)
        soil["hardening_modulus"] = float(random.choice([0.0, random.uniform(1.0, 100.0)]))
    body: dict[str, Any] = {
        "name": "body", "material": "soil", "basis": given or drawn,
        "points_per_cell": int(random.integers(2, 5)),
        "shape": {"type": "polygon", "vertices": vertices.tolist()},
    }  # fmt: skip
    if drawn == "gimp":
        rule = str(random.choice(["right_stretch", "determinant"]))
        if given is None:
            body["domain_update"] = rule
    cell = float(random.uniform(0.15, 0.3))
    entries = {
        "analysis": {"kind": "plane_strain", "solver": "superlu"},
        "grid": {"cell_size": cell, "origin": random.uniform(0.0, cell, 2).tolist()},
        "materials": {"soil": soil},
        "bodies": [body],
        "boundaries": walls,
        "loads": loads,
        "schedule": {"steps": int(random.integers(4, 11)), "outputs": 1},
    }
    text = (
        f"seed {seed}: {'star' if star else 'convex'}, {'box' if in_box else 'plane'} at "
        f"{angle:.0f} degrees, {soil['model']}, nu {nu:.2f}, {body['basis']}, "
        f"{body['points_per_cell']} points, cell {cell:.2f}, {load}"
    )
    return Problem(entries, text, pushed)


YIELD = 20.0
"""Strength that scales the body force of elastic problems, in the unit of Young's modulus 1000."""


def scaled(problem: Problem) -> Model:
    """The model with half of the body force that first yields it, found by an elastic run."""
    if problem.pushed:
        return Model.from_dict(problem.entries)
    soil = problem.entries["materials"]["soil"]
    (load,) = problem.entries["loads"]
    elastic = {k: v for k, v in soil.items() if k not in ("yield_stress", "hardening_modulus")}
    small = 1e-3
    trial = Model.from_dict(
        {
            **problem.entries,
            "materials": {"soil": {**elastic, "model": "hencky_elastic"}},
            "loads": [{**load, "acceleration": (small * np.array(load["acceleration"])).tolist()}],
            "schedule": {"steps": 1},
        }
    )
    stress = march(trial).state.points.stress
    deviator = stress[:, :3] - stress[:, :3].mean(axis=1)[:, None]
    mises = np.sqrt(1.5 * (deviator**2).sum(axis=1) + 3.0 * (stress[:, 3:] ** 2).sum(axis=1))
    size = 0.5 * small * soil.get("yield_stress", YIELD) / float(mises.max())
    acceleration = (size * np.array(load["acceleration"])).tolist()
    return Model.from_dict({**problem.entries, "loads": [{**load, "acceleration": acceleration}]})


@pytest.mark.slow
@pytest.mark.parametrize("given", [None, *CORNER_BASES])
@pytest.mark.parametrize(
    "count", [FEW, pytest.param(MANY, marks=pytest.mark.long)], ids=["few", "many"]
)
def test_every_problem_converges(count: int, given: str | None) -> None:
    stops, kinds = [], set()
    for seed in range(count):
        problem = problem_of(seed, given)
        results: list[StepResult] = []
        try:
            simulation = march(scaled(problem), lambda *step: results.append(step[1]))  # noqa: B023
        except (AnalysisFailed, BadInput) as error:
            stops.append(f"{problem.text}: {error} (after {len(results)} steps)")
            continue
        assert_sensible(problem, simulation, results)
        soil = simulation.setup.model.materials["soil"].model
        kinds.add((soil, simulation.setup.model.bodies[0].basis, problem.pushed))
    assert not stops, f"{len(stops)} of {count} stop:\n" + "\n".join(stops)
    assert len(kinds) >= (8 if count == MANY and given is None else 4), "the problems do not differ"


def assert_sensible(problem: Problem, simulation: Simulation, results: list[StepResult]) -> None:
    """Forces balance, and the platen has left the soil where it pushed it."""
    points = simulation.state.points
    assert np.isfinite(points.stress).all(), problem.text
    load = simulation.setup.loads.force(points, 1.0).sum(axis=0)
    reaction = results[-1].reaction
    size = max(np.abs(load).max(), np.abs(reaction).max())
    assert np.abs(load + reaction.sum(axis=0)).max() < 1e-5 * size, problem.text
    moved = np.abs(points.displacement).max()
    assert (0.01 if problem.pushed else 1e-6) < moved < 0.6, problem.text
