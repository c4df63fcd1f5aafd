# SPDX-License-Identifier: BSD-3-Clause
"""Implicit boundaries: balance of forces, moments and work; a body at rest does not creep."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from implicit_blocks import (
    ACROSS,
    ALONG,
    BRICK,
    DENSITY,
    DISC,
    GRAVITY,
    SQUARE,
    by_number,
    flat,
    gravity,
    implicit,
    model_of,
    squeezed,
    steps_of,
)
from implicit_problems import ghost_force
from small_problems import BASES, dimension

import tilth.analysis.step_terms
from tilth import Model
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.terms.ghost import FaceCoupling, Ghost
from tilth.terms.weak_springs import WeakSprings

pytestmark = pytest.mark.slow

every_basis = pytest.mark.parametrize("basis", BASES)
every_form = pytest.mark.parametrize("form", ["surface", "band"])


BASE = flat([0.1, 0.2], ACROSS)
SUPPORTS: dict[str, tuple[str, dict[str, Any], list[Any]]] = {
    "fixed": ("plane_strain", SQUARE, [implicit("base", BASE, "fixed")]),
    "roller and tangential": (
        "plane_strain",
        SQUARE,
        [implicit("base", BASE), implicit("rough", BASE, "tangential")],
    ),
    "two directions": (
        "plane_strain",
        SQUARE,
        [
            implicit("one", BASE, "direction", direction=[1.0, 2.0]),
            implicit("two", BASE, "direction", direction=[1.0, -0.3]),
        ],
    ),
    "box": ("plane_strain", SQUARE, [implicit("box", {**SQUARE, "soil": "inside"})]),
    "circle": ("plane_strain", DISC, [implicit("rim", {**DISC, "soil": "inside"}, "fixed")]),
    "polyline": (
        "plane_strain",
        SQUARE,
        [
            implicit(
                "notch",
                {"type": "polyline", "soil": "right",
                 "vertices": [([0.1, 0.2] + 2 * ALONG).tolist(), [0.1, 0.2],
                              ([0.1, 0.2] + 2 * ACROSS).tolist()]},
            )
        ],
    ),
    "footing": (
        "plane_strain",
        SQUARE,
        [
            implicit(
                "footing",
                {"type": "footing", "centre": ([0.1, 0.2] + 0.4 * ALONG).tolist(), "width": 0.6,
                 "normal": ACROSS.tolist()},
                "fixed",
            )
        ],
    ),
    "axisymmetric": (
        "axisymmetric",
        {"type": "box", "lower": [0.0, 0.3], "upper": [1.0, 1.3]},
        [implicit("base", flat([0.0, 0.3], [0.0, 1.0]), "fixed")],
    ),
    "sphere": (
        "3d",
        {"type": "sphere", "centre": [0.1, 0.2, 0.0], "radius": 0.7},
        [
            implicit(
                "rim",
                {"type": "sphere", "centre": [0.1, 0.2, 0.0], "radius": 0.7, "soil": "inside"},
                "fixed",
            )
        ],
    ),
    "cylinder": (
        "3d",
        BRICK,
        [
            implicit(
                "bore",
                {"type": "cylinder", "centre": [0.6, 0.5, 0.8], "axis": "x", "radius": 0.25,
                 "soil": "outside"},
                "fixed",
            )
        ],
    ),
    "faces of a cuboid": (
        "3d",
        BRICK,
        [implicit("box", {**BRICK, "soil": "inside", "faces": ["z-", "y-"]}, "fixed")],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SUPPORTS)
@every_basis
@every_form
def test_reaction_and_moment_balance_the_loads(
    name: str, basis: str, form: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To round-off, with two aids to the solution that bear next to nothing themselves.

    These are the weak springs of hardly covered nodes, and the moment of ghost stabilisation, which
    is that of the forces it remembers on the displacement of the step.
    """
    springs: list[WeakSprings] = []
    ghosts: list[list[FaceCoupling]] = []
    couplings = Ghost.couplings

    def keep(*arguments: Any) -> WeakSprings:
        springs.append(WeakSprings.of(*arguments))
        return springs[-1]

    def keep_couplings(*arguments: Any) -> list[FaceCoupling]:
        ghosts.append(couplings(*arguments))
        return ghosts[-1]

    class Kept:
        of = staticmethod(keep)

    monkeypatch.setattr(tilth.analysis.step_terms, "WeakSprings", Kept)
    monkeypatch.setattr(Ghost, "couplings", keep_couplings)
    kind, shape, walls = SUPPORTS[name]
    dim = dimension(kind)
    loads: list[Any] = [gravity(dim)]
    if kind != "axisymmetric":
        middle = [0.6, 0.6, 0.8][:dim]
        force = [2.0, -1.0, 1.5][:dim]
        loads.append({"type": "point_force", "body": "block", "at": middle, "force": force})
    walls = [wall | {"form": form} for wall in walls]
    model = model_of(kind, basis, shape, walls, steps=2, loads=loads)
    if dim == 3 and form == "band":
        model = Model.from_dict({**model.to_dict(), "grid": {"cell_size": 0.7}})
    about = np.array([0.3, -0.4, 0.2])[:dim]

    def moment(arm: Floats, force: Floats) -> Floats:
        space = ((0, 0), (0, 3 - dim))
        return np.asarray(np.cross(np.pad(arm - about, space), np.pad(force, space)).sum(axis=0))

    def compare(simulation: Simulation, result: StepResult, time: float) -> None:
        applied = simulation.setup.loads.force(simulation.state.points, time)
        moved = result.equilibrium.displacement
        weak = -springs[-1].stiffness[:, None] * moved
        total = applied.sum(axis=0)
        rest = total + result.reaction.sum(axis=0) + weak.sum(axis=0)
        size = np.linalg.norm(total)
        place = result.active.position + moved
        ghost = np.zeros(moved.shape)
        for each in ghosts[-1]:
            ghost -= ghost_force(each, moved)
        points = simulation.state.points
        # not the place of a CPDI2 point: this is the centroid of its moved domain
        carried = simulation.soil_on(result.active).interpolate(moved)
        turning = (
            moment(points.position - points.last_displacement + carried, applied)
            + sum(result.moment(wall["name"], about) for wall in walls)
            + moment(place, weak)
            + moment(place, ghost)
        )
        if kind == "axisymmetric":  # radial forces of a ring balance by its hoop stress
            rest, turning = rest[1:], np.zeros(3)
        assert np.abs(rest).max() < 1e-10 * size
        assert np.abs(turning).max() < 1e-10 * size
        assert np.abs(weak).sum() < 1e-7 * size
        assert np.abs(ghost.sum(axis=0)).max() < 1e-12 * size
        assert np.abs(moment(place, ghost)).max() < 1e-6 * size

    march(model, compare)


@every_form
def test_work_of_a_moving_boundary_is_stored_as_elastic_energy(form: str) -> None:
    """Second order in the step, as far as the touched part of the walls is known (surface form)."""
    error = []
    for steps in (4, 8, 16):
        model = squeezed("plane_strain", "gimp", "roller", 1e-6, steps=steps)
        entries = model.to_dict()
        entries["boundaries"] = [b | {"form": form} for b in entries["boundaries"]]
        entries["boundaries"][-1]["displacement"] = {"y": -0.2}
        simulation, results = steps_of(Model.from_dict(entries))
        work = sum(result.work for result in results)
        error.append(work / simulation.state.points.stored_energy() - 1.0)
    assert abs(error[-1]) < 1e-3
    if form == "surface":
        assert abs(error[-1]) < 0.1 * abs(error[0])
        return
    assert error[0] / error[1] == pytest.approx(4.0, rel=0.2)
    assert error[1] / error[2] == pytest.approx(4.0, rel=0.2)


# --- no drift ------------------------------------------------------------------------------------


def held_under_gravity(basis: str, angle: float, steps: int) -> tuple[Floats, Floats]:
    """A block whose weight grows in 10 steps and rests in all others, on a base at an angle.

    Returns the places of its points, (steps, n, 2), and the vertical reaction over the weight.
    """
    radians = np.radians(angle)
    shape = {**SQUARE, "angle": angle}
    base = implicit(
        "base", flat(SQUARE["lower"], [-np.sin(radians), np.cos(radians)]), "fixed"
    )  # fmt: skip
    end = 10.0 / steps
    load = gravity(2, factor=[[0.0, 0.0], [end, 1.0], [1.0, 1.0]])
    entries = model_of("plane_strain", basis, shape, [base], steps, loads=[load]).to_dict()
    entries["analysis"]["tolerance"] = 1e-12
    places, reactions = [], []

    def keep(simulation: Simulation, result: StepResult, time: float) -> None:
        places.append(by_number(simulation).copy())
        weight = DENSITY * GRAVITY * min(time / end, 1.0)
        reactions.append(result.resultant("base")[1] / weight)

    march(Model.from_dict(entries), keep)
    return np.array(places), np.array(reactions)


@every_basis
@pytest.mark.parametrize("angle", [0.0, 20.0])
@pytest.mark.parametrize("rest", [100, pytest.param(1000, marks=pytest.mark.long)])
def test_a_body_at_rest_does_not_creep(basis: str, angle: float, rest: int) -> None:
    """Over the last nine tenths of the further steps by less than 1e-10 of its height (1)."""
    places, reactions = held_under_gravity(basis, angle, rest + 10)
    settled = places[9] - places[0]
    assert np.abs(settled).max() > 1e-3
    assert reactions == pytest.approx(np.ones(rest + 10), rel=1e-7)
    creep = np.abs(places[-1] - places[10 + rest // 10 - 1]).max()
    assert creep < 1e-10
