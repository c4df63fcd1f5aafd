# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies that leave the soil and come back, small and thin ones, stiff and soft soil."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from random_polygons import mean_depth

from tilth import BadInput, Model, run
from tilth.analysis.contact_warnings import contact_warnings
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.boundaries.contact.checks import require_not_passed
from tilth.errors import StepFailed

CELL = 0.2
STIFFNESS = 1e6
BLOCK = ((-0.4, 0.0), (0.4, 0.0), (0.4, 0.5), (-0.4, 0.5))


def problem(outline: Any = BLOCK, young: float = STIFFNESS, **motion: Any) -> dict[str, Any]:
    """A body on a block of elastic soil of 2.8 m by 1.2 m."""
    steps = motion.pop("steps", 4)
    return {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": CELL, "origin": [-0.07, -0.03]},
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": young, "poisson_ratio": 0.3}
        },
        "bodies": [
            {"name": "soil", "material": "soil", "basis": "gimp", "points_per_cell": 2,
             "shape": {"type": "box", "lower": [-1.4, -1.2], "upper": [1.4, 0.0]}}
        ],
        "boundaries": [
            {"name": "base", "type": "implicit", "condition": "fixed",
             "geometry": {"type": "plane", "point": [0.0, -1.2], "normal": [0.0, 1.0]}}
        ],
        "rigid_bodies": [
            {"name": "body", "centre": [0.0, 0.25],
             "geometry": {"type": "polyline", "vertices": outline, "closed": True,
                          "soil": "right"},
             "contact": {"normal": "unilateral", "tangential": "friction", "friction": 0.4},
             "rotation": 0.0, **motion}
        ],
        "schedule": {"steps": steps, "outputs": 1},
        "output": {"report": False},
    }  # fmt: skip


class Results:
    """The end of each step: time, displacement and force of the body along y, mean overlap."""

    def __init__(self, folder: Path, entries: dict[str, Any]) -> None:
        rows: list[tuple[float, float, float, float]] = []
        advance = Simulation.advance

        def watched(simulation: Simulation, *rest: Any, **more: Any) -> StepResult:
            result = advance(simulation, *rest, **more)
            body = simulation.state.rigid_bodies["body"]
            overlap = mean_depth(simulation)[0]
            rows.append((result.time, body.displacement[1], body.force[1], overlap))
            return result

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Simulation, "advance", watched)
            run(Model.from_dict(entries), folder / "run", quiet=True)
        self.time, self.displacement, self.force, self.overlap = np.array(rows).T


@pytest.fixture(scope="module")
def sprung(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """A body on a spring of 10 kN/m that is pressed down, pulled up and pressed down again."""
    force = [[0.0, 0.0], [0.25, -2e4], [0.5, 5e3], [0.75, -2e4], [1.0, -3e4]]
    motion: dict[str, Any] = {
        "displacement": {"x": 0.0}, "springs": {"y": 1e4}, "force": {"y": force}, "steps": 16
    }  # fmt: skip
    return Results(tmp_path_factory.mktemp("sprung"), problem(**motion))


def test_a_body_on_a_spring_leaves_the_soil(sprung: Results) -> None:
    """Above it only the spring holds the body: u = F / k."""
    (top,) = np.flatnonzero(np.isclose(sprung.time, 0.5))
    assert sprung.displacement[top] == pytest.approx(5e3 / 1e4, rel=1e-8)
    assert sprung.force[top] == 0.0


def test_a_body_that_comes_back_meets_the_soil(sprung: Results) -> None:
    """From further away than contact sees in a step, which is cut; the soil carries the rest."""
    assert len(sprung.time) > 16
    assert sprung.force[-1] == pytest.approx(3e4 + 1e4 * sprung.displacement[-1], rel=1e-8)
    assert sprung.overlap.max() < 0.01 * CELL


def test_elastic_soil_forgets_that_a_body_was_away(tmp_path: Path, sprung: Results) -> None:
    """The depth under 30 kN is that of a body that stays."""
    motion: dict[str, Any] = {"displacement": {"x": 0.0}, "springs": {"y": 1e4}}
    stays = Results(tmp_path, problem(force={"y": -3e4}, steps=16, **motion))
    assert sprung.displacement[-1] == pytest.approx(stays.displacement[-1], rel=0.02)


def test_forces_are_proportional_to_the_stiffness_of_the_soil(tmp_path: Path) -> None:
    """From 1 Pa to 1e12 Pa: no number of the contact has units of its own."""
    found = []
    for i, young in enumerate((1.0, 1e6, 1e12)):
        (folder := tmp_path / str(i)).mkdir()
        down = {"x": 0.0, "y": -0.1}
        found.append(Results(folder, problem(young=young, displacement=down)).force / young)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6)
    np.testing.assert_allclose(found[2], found[1], rtol=1e-6)


def small(half: float, height: float) -> list[list[float]]:
    return [[-half, 0.0], [half, 0.0], [half, height], [-half, height]]


def test_a_body_smaller_than_a_cell_is_held(tmp_path: Path) -> None:
    """A tenth of a cell wide: its force grows with the depth, below that of the block."""
    down = {"x": 0.0, "y": -0.05}
    for name in ("small", "block"):
        (tmp_path / name).mkdir()
    found = Results(tmp_path / "small", problem(small(0.1 * CELL, 0.1), displacement=down))
    block = Results(tmp_path / "block", problem(displacement=down))
    assert (np.diff(found.force) > 0.0).all()
    assert 0.1 * block.force[-1] < found.force[-1] < block.force[-1]


def test_a_body_that_the_soil_cannot_feel_is_refused(tmp_path: Path) -> None:
    """Its sides are slivers: it would pass through the soil without force."""
    entries = problem(small(0.005 * CELL, 0.01 * CELL), displacement={"x": 0.0, "y": -0.05})
    with pytest.raises(BadInput, match=r"of only 0\.008, and on cells of 0\.2") as caught:
        run(Model.from_dict(entries), tmp_path / "run", quiet=True)
    assert caught.value.key == "rigid_bodies[0]"


@pytest.mark.parametrize(
    ("outline", "thickness"),
    [
        (small(0.2, 0.019), 0.019),
        (small(0.2, 0.021), None),
        ([[-0.001, 0.5], [0.0, 0.0], [0.001, 0.5]], 0.002),
        (BLOCK, None),
    ],
    ids=["slab", "thicker slab", "needle", "block"],
)
def test_a_thin_solid_body_is_warned_of(outline: Any, thickness: float | None) -> None:
    model = Model.from_dict(problem(outline, displacement={"x": 0.0, "y": -0.05}))
    found = dict(contact_warnings(model))
    if thickness is None:
        assert not found
    else:
        assert f"only {thickness} thick" in found["thickness of rigid_bodies[0].geometry"]


@pytest.mark.parametrize(
    "geometry",
    [
        {"type": "polyline", "vertices": [[-0.4, 0.0], [0.4, 0.0]], "soil": "both"},
        {"type": "plate", "centre": [0.0, 0.0], "normal": [0.0, 1.0], "width": 0.8},
    ],
    ids=["line", "plate"],
)
def test_a_thin_shape_is_not(geometry: dict[str, Any]) -> None:
    entries = problem(displacement={"x": 0.0, "y": -0.05})
    entries["rigid_bodies"][0]["geometry"] = geometry
    assert not any("thickness" in key for key, _ in contact_warnings(Model.from_dict(entries)))


def test_soil_may_not_pass_through_a_body_unless_it_is_torn_off() -> None:
    """A point of 1.6 times its volume bears nothing, and falls however short the step is.

    It may not come from more than a cell away.
    """
    simulation = Simulation(Model.from_dict(problem(displacement={"x": 0.0, "y": -0.01})))
    simulation.check()
    points = simulation.state.points
    inside = points.position.copy()
    inside[0] = [0.0, 0.25]
    surfaces = simulation.state.contact_surfaces
    with pytest.raises(StepFailed, match="soil passes through the surface of 'body'"):
        require_not_passed(surfaces, [], points, inside, 0.0, 0.0)
    points.deformation_gradient[0, 0, 0] = 1.6
    with pytest.raises(StepFailed, match="soil passes through the surface of 'body'"):
        require_not_passed(surfaces, [], points, inside, 0.0, 0.0)  # it is shot there
    points.position[0] = [0.0, 0.1]
    require_not_passed(surfaces, [], points, inside, 0.0, 0.0)
