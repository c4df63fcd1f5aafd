# SPDX-License-Identifier: BSD-3-Clause
"""Resultants of loads on splines: exact sums whatever the grid, before and after deformation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from small_problems import affine, material_entries

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.curves import LocalCubicSpline
from tilth.errors import BadInput
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.surface.loads import SurfaceLoads, declared_loads

PRESSURE = 3.0
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
SHIFTS = ([0.0, 0.0], [0.137, 0.291], [0.25, 0.05], [0.4999, 1e-9])
LENGTH = 6.0
"""Of the outlines below, about [length]."""
CIRCLE = {"type": "circle", "centre": [2.1, 1.3], "radius": 1.0}
TURNED = {"type": "box", "lower": [1.4, 0.5], "upper": [2.9, 1.7], "angle": 25.0}
STAR = {
    "type": "polygon",
    "vertices": [[1.0, 0.4], [2.0, 0.7], [3.1, 0.2], [2.7, 1.4], [3.0, 2.2], [1.9, 1.8]],
}
BOX = {"type": "box", "lower": [1.0, 0.5], "upper": [3.0, 2.0]}
TOP = {"start": [2.83, 2.0], "end": [1.17, 2.0]}
"""Part of the upper edge of BOX: its ends are no boundary points and on no grid line."""


@dataclass
class Loaded:
    """The loads of a body on one grid, and what drives it."""

    simulation: Simulation
    active: ActiveGrid
    loads: SurfaceLoads

    @classmethod
    def by(
        cls,
        shape: dict[str, Any],
        *loads: dict[str, Any],
        kind: str = "plane_strain",
        shift: tuple[float, float] | list[float] = (0.137, 0.291),
        time: float = 2.0,
        **surface: Any,
    ) -> Loaded:
        body = {"name": "block", "material": "soil", "shape": shape, "basis": "gimp"}
        body |= {"spacing": 0.09, "surface": surface}
        model = Model.from_dict(
            {
                "analysis": {"kind": kind},
                "grid": {"cell_size": 0.5, "origin": list(shift)},
                "materials": {"soil": material_entries("hencky_elastic")},
                "bodies": [body],
                "boundaries": [affine(np.eye(2))],
                "loads": [{"type": "surface", "body": "block", **load} for load in loads],
                "schedule": {"steps": 1, "end": 2.0},
            }
        )
        simulation = Simulation(model)
        active = locate(simulation.state.points, simulation.state.grid, Buffers())
        return cls(
            simulation,
            active,
            SurfaceLoads(
                declared_loads(model),
                model.analysis.kind,
                simulation.state.surfaces,
                active,
                0.0,
                time,
            ),
        )

    def forces(self, displacement: Floats | None = None) -> Floats:
        """Nodal forces [force] at the end of the step, without motion if none is given."""
        if displacement is None:
            displacement = np.zeros_like(self.active.position)
        return self.loads.force(displacement)

    def resultant(self, displacement: Floats | None = None) -> Floats:
        return np.asarray(self.forces(displacement).sum(axis=0))

    def moment(self, displacement: Floats) -> float:
        """Moment about the origin [force length]."""
        arm, force = self.active.position + displacement, self.forces(displacement)
        return float((arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum())

    def affine(self, gradient: list[list[float]]) -> Floats:
        return np.asarray(self.active.position @ (np.array(gradient) - np.eye(2)).T)

    def random(self, size: float) -> Floats:
        random = np.random.default_rng(5)
        return size * random.uniform(-1.0, 1.0, self.active.position.shape)

    def moved(self, places: Floats, displacement: Floats) -> Floats:
        """Places (n, 2) moved with the bilinear shape functions of their cells."""
        active = self.active
        scaled = (places - active.grid.origin) / active.grid.cell_size
        lattice = np.ceil(scaled).astype(np.int64) - 1  # below a grid line it lies on
        node = active.corners(np.pad(lattice, ((0, 0), (0, 1))))
        x, y = (scaled - lattice).T
        value = np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=1)
        return places + np.einsum("na,nai->ni", value, displacement[node])

    @property
    def spline(self) -> LocalCubicSpline:
        return LocalCubicSpline(self.simulation.state.surfaces["block"].chains[0].current)


SHEARED = [[1.4, 0.7], [-0.3, 0.9]]


@pytest.mark.parametrize("shift", SHIFTS)
@pytest.mark.parametrize("shape", [CIRCLE, TURNED, STAR], ids=["circle", "turned", "star"])
def test_pressure_on_a_closed_spline_has_no_resultant(shape, shift):
    loaded = Loaded.by(shape, {"pressure": PRESSURE}, shift=shift)
    for displacement in (loaded.affine(np.eye(2)), loaded.affine(SHEARED)):
        assert np.abs(loaded.forces(displacement)).max() > 0.1 * PRESSURE
        assert np.abs(loaded.resultant(displacement)).max() < 1e-14 * PRESSURE * LENGTH
        assert abs(loaded.moment(displacement)) < 1e-13 * PRESSURE * LENGTH


@pytest.mark.parametrize("shape", [CIRCLE, TURNED, STAR], ids=["circle", "turned", "star"])
def test_nor_has_it_after_any_displacement_of_the_nodes(shape):
    loaded = Loaded.by(shape, {"pressure": PRESSURE})
    assert np.abs(loaded.resultant(loaded.random(0.1))).max() < 1e-14 * PRESSURE * LENGTH


@pytest.mark.parametrize("shift", SHIFTS)
def test_pressure_on_an_open_piece_is_that_on_its_chord(shift):
    loaded = Loaded.by(BOX, {"pressure": PRESSURE, **TOP}, shift=shift)
    ends = np.array([TOP["start"], TOP["end"]])
    np.testing.assert_allclose(loaded.resultant(), [0.0, -1.66 * PRESSURE], atol=1e-14)
    for displacement in (loaded.affine(SHEARED), loaded.random(0.1)):
        start, end = loaded.moved(ends, displacement)
        exact = PRESSURE * TURN @ (end - start)
        np.testing.assert_allclose(loaded.resultant(displacement), exact, atol=1e-13)


def test_pressure_on_an_arc_is_that_on_its_chord():
    angle = np.radians([-35.0, 68.0])
    ends = np.array(CIRCLE["centre"]) + np.stack([np.cos(angle), np.sin(angle)], axis=1)
    part = {"start": ends[0].tolist(), "end": ends[1].tolist()}
    loaded = Loaded.by(CIRCLE, {"pressure": PRESSURE, **part})
    # the ends are put on the spline, whose 26 points leave it 9e-6 off the circle
    exact = PRESSURE * TURN @ (ends[1] - ends[0])
    np.testing.assert_allclose(loaded.resultant(), exact, atol=2.0 * PRESSURE * 9e-6)
    points = loaded.simulation.state.surfaces["block"].chains[0]
    start, end = points.current.points[points.marked]
    np.testing.assert_allclose(loaded.resultant(), PRESSURE * TURN @ (end - start), atol=1e-13)


@pytest.mark.parametrize("shift", SHIFTS)
def test_in_axisymmetry_forces_are_those_of_the_whole_ring(shift):
    # top edge from r 2.83 to 1.17: p times the area of the ring, downwards
    loaded = Loaded.by(BOX, {"pressure": PRESSURE, **TOP}, kind="axisymmetric", shift=shift)
    ring = np.pi * (2.83**2 - 1.17**2)
    np.testing.assert_allclose(loaded.resultant(), [0.0, -PRESSURE * ring], rtol=1e-13, atol=1e-12)
    # F maps the radius to a r + b z, z to c r + d z; on the edge z is constant
    (a, b), (c, _) = SHEARED
    ends = np.array([2.83, 1.17])
    radius, height = a * ends + b * 2.0, c * ends
    exact = [
        -2.0 * np.pi * PRESSURE * radius.mean() * (height[1] - height[0]),
        PRESSURE * np.pi * (radius[1] ** 2 - radius[0] ** 2),
    ]
    displacement = loaded.affine(SHEARED)
    np.testing.assert_allclose(loaded.resultant(displacement), exact, rtol=1e-12)


@pytest.mark.parametrize("shape", [CIRCLE, TURNED, STAR], ids=["circle", "turned", "star"])
def test_in_axisymmetry_a_closed_spline_is_pressed_towards_the_axis(shape):
    # sum of -p n_r 2 pi r over the outline: 2 pi p times the enclosed area (divergence theorem)
    loaded = Loaded.by(shape, {"pressure": PRESSURE}, kind="axisymmetric")
    exact = [-2.0 * np.pi * PRESSURE * loaded.spline.area, 0.0]
    np.testing.assert_allclose(loaded.resultant(), exact, rtol=1e-12, atol=1e-12)
    stretched = loaded.resultant(loaded.affine([[1.2, 0.3], [0.1, 0.9]]))
    determinant = 1.2 * 0.9 - 0.3 * 0.1
    np.testing.assert_allclose(stretched, determinant * np.array(exact), rtol=1e-12, atol=1e-11)


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
def test_dead_loads_keep_their_resultant(kind):
    area = np.pi * (2.83**2 - 1.17**2) if kind == "axisymmetric" else 1.66
    traction = [0.7, -2.0]
    dead = {"pressure": PRESSURE, "shear": 0.5, "follower": False, **TOP}
    for load, stress in (({"traction": traction, **TOP}, traction), (dead, [-0.5, -PRESSURE])):
        loaded = Loaded.by(BOX, load, kind=kind)
        for displacement in (None, loaded.affine(SHEARED), loaded.random(0.1)):
            resultant = loaded.resultant(displacement)
            np.testing.assert_allclose(resultant, area * np.array(stress), rtol=1e-12)


def test_shear_goes_along_the_moved_surface():
    loaded = Loaded.by(BOX, {"shear": 0.5, **TOP})
    np.testing.assert_allclose(loaded.resultant(), [-0.5 * 1.66, 0.0], atol=1e-14)
    for displacement in (loaded.affine(SHEARED), loaded.random(0.1)):
        start, end = loaded.moved(np.array([TOP["start"], TOP["end"]]), displacement)
        np.testing.assert_allclose(
            loaded.resultant(displacement), 0.5 * (end - start), rtol=1e-12, atol=1e-14
        )


def test_shear_on_a_circle_is_a_couple():
    loaded = Loaded.by(CIRCLE, {"shear": 0.5}, spacing=0.02)
    still = loaded.affine(np.eye(2))
    assert np.abs(loaded.resultant()).max() < 1e-13
    np.testing.assert_allclose(loaded.moment(still), 0.5 * 2.0 * np.pi, rtol=1e-7)


def test_pressure_along_the_arc_is_a_table():
    # from `start` on: 2 over the first 0.4, down to 0 at 0.9, which holds to the end at 1.66
    table = {"pressure_along": [[0.0, 2.0], [0.4, 2.0], [0.9, 0.0]], **TOP}
    exact = 2.0 * 0.4 + 0.5 * 2.0 * 0.5
    for spacing, error in ((0.1, 2e-3), (0.01, 2e-5)):  # kinks within pieces: second order
        loaded = Loaded.by(BOX, table, spacing=spacing)
        np.testing.assert_allclose(loaded.resultant(), [0.0, -exact], atol=error)
    first = exact * (2.83 - 2.0 - (0.8 * 0.2 + 0.5 * (0.4 + 0.5 / 3.0)) / exact)
    forces, x = loaded.forces()[:, 1], loaded.active.position[:, 0]
    np.testing.assert_allclose(-forces @ (x - 2.0), first, atol=1e-4)


def test_pressure_along_adds_to_pressure_and_keeps_to_the_initial_arc():
    straight = {"pressure": 1.0, "pressure_along": [[0.0, 0.0], [1.66, 4.0]], **TOP}
    loaded = Loaded.by(BOX, straight)
    np.testing.assert_allclose(loaded.resultant()[1], -1.66 * 3.0, rtol=1e-13)
    stretched = loaded.resultant(loaded.affine([[2.0, 0.0], [0.0, 1.0]]))
    np.testing.assert_allclose(stretched[1], -2.0 * 1.66 * 3.0, rtol=1e-13)


@pytest.mark.parametrize(("time", "factor"), [(0.25, 0.5), (0.5, 1.0), (1.0, -1.0), (1.7, -1.0)])
def test_factors_are_linear_between_rows_and_constant_after(time, factor):
    table = [[0.0, 0.0], [0.5, 1.0], [1.0, -1.0]]
    for load in ({"pressure": PRESSURE}, {"traction": [0.0, -PRESSURE]}):
        loaded = Loaded.by(BOX, {**load, **TOP, "factor": table}, time=time)
        expected = -1.66 * PRESSURE * factor
        np.testing.assert_allclose(loaded.resultant()[1], expected, rtol=1e-13)
    assert not loaded.loads.force_before().any()


def test_without_a_table_the_load_grows_over_the_schedule():
    loaded = Loaded.by(BOX, {"pressure": PRESSURE, **TOP}, time=0.5)  # the schedule ends at 2
    np.testing.assert_allclose(loaded.resultant()[1], -0.25 * 1.66 * PRESSURE, rtol=1e-13)


def test_loads_add_up():
    upper = {"pressure": PRESSURE, **TOP}
    loaded = Loaded.by(BOX, upper, {"traction": [1.0, 0.0], **TOP}, {"pressure": 7.0})
    np.testing.assert_allclose(loaded.resultant(), [1.66, -1.66 * PRESSURE], rtol=1e-12)


def test_a_model_with_a_surface_survives_being_written():
    model = Loaded.by(BOX, {"pressure": PRESSURE, **TOP}).simulation.setup.model
    assert Model.from_dict(model.to_dict()) == model
    with pytest.raises(BadInput, match="vertices"):
        Loaded.by(BOX, {"pressure": PRESSURE}, closed=False)
