# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies on a block of soil, and the term of their contact in a step, for tests of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import tilth.analysis.attempts
from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries.contact.forces import AssembledContact
from tilth.terms.balance import Balance

YOUNG, STRENGTH = 1000.0, 10.0
CELL = 0.5

CENTRE = {"plane_strain": [0.9, 2.1], "axisymmetric": [0.0, 2.0], "3d": [0.8, 0.7, 2.1]}

FREE, DRIVEN = "free", "driven"

LAWS: dict[str, dict[str, Any]] = {
    "smooth": {"normal": "unilateral", "tangential": "smooth"},
    "friction": {"normal": "unilateral", "tangential": "friction", "friction": 0.4},
    "limited": {
        "normal": "unilateral", "tangential": "friction", "friction": 0.4, "shear_limit": 2.0
    },
    "adhesion": {"normal": "unilateral", "tangential": "adhesion", "shear_limit": 2.0},
    "rough": {"normal": "unilateral", "tangential": "rough"},
    "bonded": {"normal": "unilateral", "tangential": "bonded"},
    "cut-off": {
        "normal": "unilateral", "tensile_strength": 3.0, "tangential": "friction", "friction": 0.4
    },
    "held friction": {"normal": "bilateral", "tangential": "friction", "friction": 0.4},
    "held adhesion": {"normal": "bilateral", "tangential": "adhesion", "adhesion_factor": 0.5},
    "held smooth": {"normal": "bilateral", "tangential": "smooth"},
    "glued": {"normal": "bilateral", "tangential": "bonded"},
}  # fmt: skip


def shapes(kind: str, length: float) -> dict[str, Any]:
    """One round shape; in plane strain it is joined with a box."""
    if kind == "3d":
        centre = (np.array([0.7, 0.8, 2.0]) * length).tolist()
        return {
            "geometry": {
                "type": "sphere", "centre": centre, "radius": 0.48 * length, "soil": "outside"
            }
        }  # fmt: skip
    x = 0.0 if kind == "axisymmetric" else 0.8
    circle = {
        "type": "circle", "centre": [x * length, 2.0 * length], "radius": 0.48 * length,
        "soil": "outside",
    }  # fmt: skip
    if kind == "axisymmetric":
        return {"geometry": circle}
    box = {
        "type": "box", "lower": [1.13 * length, 1.51 * length],
        "upper": [1.71 * length, 2.1 * length], "soil": "outside",
    }  # fmt: skip
    return {"geometries": [circle, box]}


def motion(kind: str, way: str, force: float, length: float, stress: float) -> dict[str, Any]:
    """Free with springs against everything, or driven down, aside and round."""
    dim = 3 if kind == "3d" else 2
    up = "xyz"[dim - 1]
    if way == DRIVEN:
        down = {up: -0.04 * length}
        if kind == "axisymmetric":
            return {"displacement": down}
        turned: Any = {"x": 2.0, "y": 3.0, "z": -2.0} if dim == 3 else 3.0
        aside = dict.fromkeys("xyz"[: dim - 1], 0.01 * length)
        return {"displacement": down | aside, "rotation": turned}
    if kind == "axisymmetric":
        return {"force": {"y": -force}, "springs": {"y": 10.0 * force / length}}
    turns = ["rotation"] if dim == 2 else ["rotation_x", "rotation_y", "rotation_z"]
    springs = dict.fromkeys("xyz"[:dim], 10.0 * force / length)
    springs |= dict.fromkeys(turns, 5.0 * force * length)
    moment: Any = 0.1 * force * length
    if dim == 3:
        moment = {"x": 0.05 * force * length, "y": -0.02 * force * length, "z": moment}
    return {
        "force": {up: -force, "x": 0.1 * force}, "moment": moment, "springs": springs,
        "mass": 0.1 * force * length / stress,
    }  # fmt: skip


def pressed(
    kind: str,
    law: str,
    way: str = FREE,
    length: float = 1.0,
    stress: float = 1.0,
    steps: int = 4,
    basis: str = "gimp",
) -> Simulation:
    """A block of 2 by 1.53 (in space 1.5 by 1.5 by 1.53) with a body on it, before its first step.

    `length` and `stress` are units: how often the ones of the numbers below go into them.
    """
    dim = 3 if kind == "3d" else 2
    upper = [1.5, 1.5, 1.53] if dim == 3 else [2.0, 1.53]
    axes = "xyz"[:dim]
    force = 4.0 * stress * length ** (1 if kind == "plane_strain" else 2)
    sides = [
        {"name": f"{axis} {end}", "type": "plane", "axis": axis, "at": at * length,
         "condition": "roller"}
        for axis, top in zip(axes[:-1], upper, strict=False)
        for end, at in (("low", 0.0), ("high", top))
    ]  # fmt: skip
    base = {"name": "base", "type": "plane", "axis": axes[-1], "at": 0.0, "condition": "fixed"}
    body = {
        "name": "body", "contact": LAWS[law] | _limits(law, stress), **shapes(kind, length),
        "centre": [length * x for x in CENTRE[kind]],
        **motion(kind, way, force, length, stress),
    }  # fmt: skip
    entries: dict[str, Any] = {
        "analysis": {"kind": kind, "tolerance": 1e-11, "ghost_stabilisation": 0.005},
        "grid": {"cell_size": CELL * length},
        "materials": {
            "soil": {"model": "von_mises", "young_modulus": YOUNG * stress, "poisson_ratio": 0.3,
                     "yield_stress": np.sqrt(3.0) * STRENGTH * stress, "hardening_modulus": 0.0,
                     "density": 1.0}
        },
        "bodies": [
            {"name": "soil", "material": "soil", "basis": basis, "points_per_cell": 2,
             "shape": {"type": "box", "lower": [0.0] * dim,
                       "upper": [length * edge for edge in upper]}}
        ],
        "boundaries": [*sides, base],
        "rigid_bodies": [body],
        "loads": [
            {"type": "body_force", "acceleration": [0.0] * (dim - 1) + [-0.5 * stress / length]}
        ],
        "schedule": {"steps": steps},
    }  # fmt: skip
    return Simulation(Model.from_dict(entries))


def _limits(law: str, stress: float) -> dict[str, float]:
    keys = ("shear_limit", "tensile_strength")
    return {key: stress * LAWS[law][key] for key in keys if key in LAWS[law]}


class Stopped(Exception):
    """Ends a step where its balance is known."""


def next_balance(
    simulation: Simulation, before: float, after: float, monkeypatch: pytest.MonkeyPatch
) -> Balance:
    """Balance of the next step, which begins at its first unknowns and is not taken."""
    found: list[Balance] = []

    def stop(balance: Balance, *_: Any) -> None:
        balance.begin(balance.first())
        found.append(balance)
        raise Stopped

    with monkeypatch.context() as patched:
        patched.setattr(tilth.analysis.attempts, "solve_step", stop)
        with pytest.raises(Stopped):
            simulation.advance(before, after)
    return found[0]


def next_contact(
    simulation: Simulation, before: float, after: float, monkeypatch: pytest.MonkeyPatch
) -> tuple[Balance, AssembledContact]:
    """Balance and contact term of the next step, which is not taken."""
    balance = next_balance(simulation, before, after, monkeypatch)
    (term,) = [each for each in balance.terms if isinstance(each, AssembledContact)]
    return balance, term


def linearised(term: AssembledContact, balance: Balance, u: Floats, g: Floats) -> Floats:
    """The blocks of the term's stiffness; twice, so that what turned round has its direction."""
    dim = balance.active.grid.dim
    term._linearisations = 0  # never so many that the shear strength is a given one
    for _ in range(2):
        term.forces(u, g)
        blocks = np.zeros((len(balance.active.column), dim, dim))
        term.add_stiffness(u, blocks)
        term.linearised()
    term.forces(u, g)
    return blocks


def product(balance: Balance, blocks: Floats, direction: Floats) -> Floats:
    """Matrix of node blocks times a direction (nodes, dim)."""
    active = balance.active
    rows = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    found = np.zeros_like(direction)
    np.add.at(found, rows, np.einsum("nij,nj->ni", blocks, direction[active.column]))
    return found


def states(term: AssembledContact) -> list[tuple[bool, bool, float]]:
    """Whether each multiplier is closed, and slides, and how its strength grows with pressure."""
    found = []
    for patch, _, each in term._each():
        response = each.response
        growth = patch.law.strength(-response.traction[:, 0])[1]
        found += zip(
            response.closed.tolist(), response.sliding.tolist(), growth.tolist(), strict=True
        )
    return found


def branches(term: AssembledContact) -> set[str]:
    """The branches of the law at the last forces."""
    found = set()
    for patch, _, each in term._each():
        present = patch.area > 0.0
        closed, sliding = each.response.closed & present, each.response.sliding
        found |= {"open"} if (present & ~closed).any() else set()
        found |= {"slip"} if (closed & sliding).any() else set()
        found |= {"stick"} if (closed & ~sliding).any() else set()
    return found


def quarter_turn(simulation: Simulation, shift: tuple[float, float]) -> Simulation:
    """The same problem in the plane turned by 90 degrees about the origin, then shifted."""

    def place(point: Any) -> list[float]:
        return [shift[0] - point[1], shift[1] + point[0]]

    def turned(by_axis: dict[str, float]) -> dict[str, float]:
        return {"x": -by_axis["y"], "y": by_axis["x"]}

    def box(shape: dict[str, Any]) -> dict[str, Any]:
        ends = np.array([place(shape["lower"]), place(shape["upper"])])
        return shape | {"lower": ends.min(axis=0).tolist(), "upper": ends.max(axis=0).tolist()}

    entries = simulation.setup.model.to_dict()
    for boundary in entries["boundaries"]:
        along_x = boundary["axis"] == "x"
        boundary["at"] = shift[1] + boundary["at"] if along_x else shift[0] - boundary["at"]
        boundary["axis"] = "y" if along_x else "x"
    (soil,), (body,) = entries["bodies"], entries["rigid_bodies"]
    soil["shape"] = box(soil["shape"])
    circle, brick = body["geometries"]
    body["geometries"] = [circle | {"centre": place(circle["centre"])}, box(brick)]
    body["centre"] = place(body["centre"])
    for key in ("displacement", "force"):
        if body.get(key):
            body[key] = turned(body[key])
    if body.get("springs"):
        body["springs"] |= {"x": body["springs"]["y"], "y": body["springs"]["x"]}
    (load,) = entries["loads"]
    x, y = load["acceleration"]
    load["acceleration"] = [-y, x]
    return Simulation(Model.from_dict(entries))


SIZES = {"tiny": (1e-9, 1e-9), "small": (1e-5, 1e-5), "large": (2e-3, 0.02), "turned": (2e-3, 0.6)}
"""Random displacements of the nodes, and of the body beyond the motion that it has them follow."""


def check_derivatives(
    balance: Balance, term: AssembledContact, u: Floats, g: Floats, step: float, seed: int
) -> bool:
    """Whether a random direction leaves all multipliers on their branches; there it compares."""
    blocks = linearised(term, balance, u, g)
    border, at = term.border(u, g), states(term)
    random = np.random.default_rng([3, seed])
    way, turn = random.normal(size=u.shape), random.normal(size=len(g))
    ends = []
    for one, other in ((way, 0.0 * turn), (0.0 * way, turn)):
        for sign in (step, -step):
            ends.append(term.forces(u + sign * one, g + sign * other))
            if states(term) != at:
                return False
    by_nodes = product(balance, blocks, way), np.einsum("mni,ni->m", border.rows, way)
    by_body = np.einsum("mni,m->ni", border.columns, turn), border.corner @ turn
    for expected, ahead, behind in ((by_nodes, *ends[:2]), (by_body, *ends[2:])):
        for found, a, b in zip(expected, ahead, behind, strict=True):
            difference = (a - b) / (2.0 * step)
            largest = np.abs(difference).max(initial=0.0)
            round_off = 1e-14 * np.abs(a).max(initial=0.0) / step
            np.testing.assert_allclose(
                found, difference, rtol=0, atol=2e-6 * largest + round_off + 1e-12
            )
    return True


def branches_compared(balance: Balance, term: AssembledContact) -> set[str]:
    """Compares derivatives at random displacements; returns the branches met."""
    seen: set[str] = set()
    for number, (nodes, body) in enumerate(SIZES.values()):
        compared = 0
        for seed in range(12):
            random = np.random.default_rng([11, number, seed])
            u = nodes * random.normal(size=(balance.active.nodes, balance.active.grid.dim))
            u[:, -1] += 4.0 * nodes * random.normal()  # towards the body, or away from it
            g = body * random.normal(size=len(term.scale))
            if check_derivatives(balance, term, u, g, 1e-4 * nodes, seed):
                compared += 1
                seen |= branches(term)
        assert compared >= 6
    return seen
