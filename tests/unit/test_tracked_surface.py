# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces that move with the soil: redistribution, marks, crossings, resumed runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, run_until
from small_problems import BASES

from tilth import Model, resume, run
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.curves.chain import Chain
from tilth.curves.spline import LocalCubicSpline
from tilth.errors import BadInput, StepFailed
from tilth.surface.redistribution import redistribute_points
from tilth.surface.tracked import LONGEST_CHORD_RATIO, SHORTEST_CHORD_RATIO, TrackedSurface
from tilth.surface.tracked_triangles import TrackedSolidSurface
from tilth.surface.triangles import Triangles

pytestmark = pytest.mark.slow

STEPS = 8


def stretched(
    end: list[list[float]], path: str = "linear", basis: str = "gimp", **surface: Any
) -> Model:
    """A square moved by an affine motion, with a load on its top and on a part of its side."""
    body = {
        "name": "square",
        "material": "soil",
        "basis": basis,
        "shape": {"type": "box", "lower": [0.1, 0.2], "upper": [2.1, 2.2]},
        "spacing": 0.25,
        "surface": surface,
    }
    pressure = {"type": "surface", "body": "square", "pressure": 1.0}
    return Model.from_dict(
        {
            "analysis": {"kind": "plane_strain"},
            "grid": {"cell_size": 0.5},
            "materials": {
                "soil": {"model": "hencky_elastic", "young_modulus": 1e3, "poisson_ratio": 0.2}
            },
            "bodies": [body],
            "boundaries": [
                {
                    "type": "affine",
                    "name": "drive",
                    "deformation_gradient": end,
                    "path": path,
                }
            ],
            "loads": [
                {**pressure, "start": [2.1, 2.2], "end": [0.1, 2.2]},
                {**pressure, "start": [0.1, 1.7], "end": [0.1, 0.61]},
            ],
            "schedule": {"steps": STEPS},
            "output": {"report": False},
        }
    )


def surface_of(simulation: Simulation) -> TrackedSurface:
    found = simulation.state.surfaces["square"]
    assert isinstance(found, TrackedSurface)
    return found


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("points", ["extra", "outer_layer"])
def test_boundary_points_move_with_the_soil(points: str, basis: str) -> None:
    """Stretched to three times its length: points come and go, corners and marks stay."""
    end = np.array([[3.0, 0.4], [0.0, 0.4]])
    simulation = march(stretched(end.tolist(), basis=basis, points=points))
    tracked = surface_of(simulation).chains[0]
    origin = simulation.state.grid.origin
    expected = origin + (tracked.initial.points - origin) @ end.T
    np.testing.assert_allclose(tracked.current.points, expected, atol=1e-9)
    assert tracked.current.corner.sum() == 4
    if points == "extra":
        chord = np.linalg.norm(tracked.current.chord, axis=1)
        assert chord.max() <= LONGEST_CHORD_RATIO * 0.25 * (1.0 + 1e-9)
        assert chord.min() >= SHORTEST_CHORD_RATIO * 0.25 * 0.5
        assert len(tracked.current) != 32
        area = LocalCubicSpline(tracked.current).area
        assert area == pytest.approx(4.0 * np.linalg.det(end), rel=1e-9)
        places = [[2.1, 2.2], [0.1, 2.2], [0.1, 1.7], [0.1, 0.61]]
        np.testing.assert_allclose(tracked.initial.points[tracked.marked], places, atol=1e-9)


def test_extra_points_lie_on_the_edge_and_the_outer_layer_within() -> None:
    for points, side in (("extra", 2.0), ("outer_layer", 1.75)):
        simulation = Simulation(stretched([[1.0, 0.0], [0.0, 1.0]], points=points))
        area = LocalCubicSpline(surface_of(simulation).chains[0].current).area
        assert area == pytest.approx(side**2, rel=1e-12)


def test_arc_lengths_count_from_the_start_of_a_part() -> None:
    simulation = Simulation(stretched([[1.0, 0.0], [0.0, 1.0]]))
    surface, active = surface_of(simulation), simulation.check()
    quadrature = surface.quadrature(active)
    for number, start, length in ((0, [2.1, 2.2], 2.0), (1, [0.1, 1.7], 1.09)):
        loaded, arc = surface.of_part(f"loads[{number}]", quadrature)
        distance = np.linalg.norm(loaded.position - start, axis=1)
        np.testing.assert_allclose(arc, distance, atol=1e-12)
        total = np.linalg.norm(loaded.edges[:, 0], axis=1).sum()
        assert total == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize(
    ("points", "basis"), [*(("extra", basis) for basis in BASES), ("outer_layer", "gimp")]
)
def test_resumed_run_has_the_same_bits(
    points: str, basis: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = stretched([[2.0, 0.4], [0.0, 0.6]], basis=basis, points=points)
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    run(model, whole, threads=1, quiet=True)
    run_until(model, stopped, 5, monkeypatch)
    resume(stopped, threads=1, quiet=True)
    assert_same_results(whole, stopped)


def test_a_crossing_is_reported() -> None:
    """A block folded over by its own load would cross itself; here the chain is made to.

    Without a load it gets no new points then: a tangle would grow without end.
    """
    whole = stretched([[1.0, 0.0], [0.0, 1.0]])
    bare = whole.to_dict()
    bare["loads"] = []
    grown = {}
    for loaded, model in ((True, whole), (False, Model.from_dict(bare))):
        simulation = Simulation(model)
        surface, active = surface_of(simulation), simulation.check()
        displacement = np.zeros((active.nodes, 2))
        displacement[active.position[:, 0] > 1.6] = [-2.0, 0.3]
        state = simulation.state.points, simulation.state.points.position
        moved, warning = surface.moved(active, displacement, *state)
        assert warning is not None
        assert "'square' touches or crosses itself at (" in warning
        grown[loaded] = len(moved[0].current) - len(surface.chains[0].current)
    assert grown[True] > 0
    assert grown[False] <= 0


def test_a_boundary_point_that_leaves_the_soil_fails_the_step() -> None:
    """A chain of the user's own that begins far from the body."""
    vertices = [[3.9, 0.2], [4.1, 1.0], [3.9, 2.2]]
    entries = stretched([[1.0, 0.0], [0.0, 1.0]]).to_dict()
    entries["bodies"][0]["surface"] = {"vertices": vertices, "closed": False}
    entries["loads"] = []
    simulation = Simulation(Model.from_dict(entries))
    with pytest.raises(BadInput, match=r"boundary point at \(3.9, 0.2\) is more than a cell away"):
        simulation.check()
    with pytest.raises(StepFailed, match="all boundary points of 'square' left the soil"):
        simulation.advance(0.0, 0.1)
    entries["loads"] = [{"type": "surface", "body": "square", "pressure": 1.0}]
    simulation = Simulation(Model.from_dict(entries))
    with pytest.raises(StepFailed, match="a part of the surface of 'square' left the soil"):
        simulation.advance(0.0, 0.1)


@pytest.mark.parametrize(
    ("lost", "stay", "told"),
    [([12], 0, "goes on without them"), ([11, 12, 13], 3, "stays there where it was")],
)
def test_a_surface_without_load_goes_on_without_points_far_from_the_soil(
    lost: list[int], stay: int, told: str
) -> None:
    """A chain of the user's own with points more than a cell away; the run says what it does.

    It goes on without a few; where there are many they stay.
    """
    entries = stretched([[1.0, 0.0], [0.0, 1.0]]).to_dict()
    entries["loads"] = []
    side = np.linspace(0.0, 2.0, 6)[:-1]
    vertices = [
        *([x, 0.0] for x in side), *([2.0, y] for y in side),
        *([2.0 - x, 2.0] for x in side), *([0.0, 2.0 - y] for y in side),
    ]  # fmt: skip
    entries["bodies"][0]["surface"] = {"vertices": vertices, "closed": True}
    simulation = Simulation(Model.from_dict(entries))
    surface = surface_of(simulation)
    whole = surface.chains[0]
    points = whole.current.points.copy()
    points[lost] = [[1.2 - 0.1 * k, 5.0] for k in range(len(lost))]
    surface.chains[0] = replace(whole, current=Chain(points, True, whole.current.corner))
    simulation.advance(0.0, 0.1)
    assert any(told in text for text in simulation.services.warnings.texts)
    simulation.advance(0.1, 0.2)
    assert int((surface.chains[0].current.points[:, 1] == 5.0).sum()) == stay


def test_a_surface_in_space_without_load_moves_beside_vertices_far_from_the_soil() -> None:
    """One vertex is lifted off: it moves as those around it; with a load the step fails."""
    entries = stretched([[1.0, 0.0], [0.0, 1.0]]).to_dict()
    entries["analysis"]["kind"] = "3d"
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [0, 0, 0], "upper": [2, 2, 2]}
    entries["boundaries"][0]["deformation_gradient"] = [[1, 0, 0], [0, 1, 0], [0.2, 0, 1]]
    for loads in ([], [{"type": "surface", "body": "square", "pressure": 1.0}]):
        simulation = Simulation(Model.from_dict({**entries, "loads": loads}))
        surface = simulation.state.surfaces["square"]
        assert isinstance(surface, TrackedSolidSurface)
        before = surface.triangles.current
        place = before.vertices.copy()
        (lost,) = np.flatnonzero((place == [1.0, 1.0, 2.0]).all(axis=1))
        place[lost, 2] = 4.0
        lifted = Triangles(place, before.triangle, before.part, before.part_number)
        surface.triangles = replace(surface.triangles, current=lifted)
        if loads:
            with pytest.raises(StepFailed, match="a part of the surface of 'square' left the soil"):
                simulation.advance(0.0, 0.5)
            continue
        simulation.advance(0.0, 0.5)
        after = surface.triangles.current
        moved = (after.vertices[: len(place)] - place)[[lost]]
        np.testing.assert_allclose(moved, [[0.0, 0.0, 0.1]], atol=1e-10)
        assert any("moves there as beside them" in t for t in simulation.services.warnings.texts)


def test_redistribution_never_removes_a_kept_point() -> None:
    points = [[0.0, 0.0], [1.0, 0.0], [1.05, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0]]
    chain = Chain(points, closed=False)
    kept = np.array([False, False, True, False, False, False])
    for marks, expected in ((None, 1.025), (kept, 1.05)):
        new = redistribute_points(chain, 2.0, 0.2, marks).chain
        assert len(new) == 5
        assert new.points[1, 0] == pytest.approx(expected, abs=1e-12)
