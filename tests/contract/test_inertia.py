# SPDX-License-Identifier: BSD-3-Clause
"""Inertia of soil and rigid bodies: tangents, momentum, units, order, energy, closed forms."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from contact_terms import next_balance
from small_problems import AXES, SPACINGS, dimension

from tilth import Model
from tilth.analysis.energies import Energies
from tilth.analysis.march import march_stages
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.terms.inertia import RELATIVE_SHIFT, AssembledInertia, TimeIntegration
from tilth.terms.motion import Motion

NEWMARK: dict[str, Any] = {"scheme": "newmark"}
ALPHA: dict[str, Any] = {"scheme": "generalised_alpha", "spectral_radius": 0.6}
PIC: dict[str, Any] = NEWMARK | {"velocity_update": "pic"}
BASES = ["linear", "gimp", "cpdi1", "cpdi2"]
KINDS = ["plane_strain", "axisymmetric", "3d"]
GRAVITY = 9.81


AROUND_THE_BLOCK = {
    "x": [[0.0, 0.2], [1.2, 0.35]],
    "y": [[-0.6, 0.4], [0.6, 0.2], [1.5, 0.3]],
    "z": [[-0.5, 0.35], [1.0, 0.2]],
}
"""Cell sizes of a graded grid at places."""


def block(
    kind: str = "plane_strain",
    basis: str = "gimp",
    inertia: dict[str, Any] = NEWMARK,
    turns: bool = True,
    length: float = 1.0,
    time: float = 1.0,
    spacing: str = "uniform",
) -> Simulation:
    """An elastic block beside the grid's lines that moves, turns and falls.

    `length` and `time` are units: how often the ones of the numbers below go into them.
    """
    dim = 3 if kind == "3d" else 2
    lower = np.array([0.0 if kind == "axisymmetric" else 0.13, 0.21, 0.17][:dim])
    upper = np.array([0.93, 1.32, 0.71][:dim])
    box = {"type": "box", "lower": (length * lower).tolist(), "upper": (length * upper).tolist()}
    velocity: dict[str, Any] = {"body": "block", "y": 0.7 * length / time}
    if kind != "axisymmetric":
        velocity["x"] = 0.3 * length / time
    if kind != "axisymmetric" and turns:
        spin = np.array([0.1, 0.4, -0.3]) / time
        velocity["angular_velocity"] = float(spin[1]) if dim == 2 else spin.tolist()
        velocity["centre"] = (0.5 * length * (lower + upper)).tolist()
    gravity = [0.0] * (dim - 1) + [-GRAVITY * length / time**2]
    entries: dict[str, Any] = {
        "units": {"time": "s"},
        "analysis": {"kind": kind, "inertia": inertia, "tolerance": 1e-12},
        "grid": {"cell_size": 0.25 * length},
        "materials": {
            "soil": {
                "model": "hencky_elastic", "poisson_ratio": 0.3, "density": 1e3 / length**3,
                "young_modulus": 1e5 / (length * time**2),
            }
        },
        "bodies": [
            {"name": "block", "material": "soil", "basis": basis, "points_per_cell": 2,
             "shape": box}
        ],
        "initial": {"velocity": [velocity]},
        "loads": [
            {"type": "body_force", "acceleration": gravity, "factor": [[0.0, 1.0], [time, 1.0]]}
        ],
        "schedule": {"end": 0.2 * time, "steps": 10},
    }  # fmt: skip
    if spacing == "graded":
        entries["grid"]["cell_size"] = {axis: AROUND_THE_BLOCK[axis] for axis in AXES[:dim]}
    return Simulation(Model.from_dict(entries))


def run(simulation: Simulation) -> Energies:
    """Takes all steps."""
    simulation.check()
    energies = Energies.at_start(simulation.setup, simulation.state)
    schedule = simulation.setup.model.schedule
    for number in range(schedule.steps or 0):
        times = schedule.regular_time(number), schedule.regular_time(number + 1)
        energies.add(simulation.advance(*times))
    return energies


@pytest.mark.parametrize("inertia", [NEWMARK, ALPHA | {"damping": {"mass": 3.0}}])
@pytest.mark.parametrize("kind", KINDS)
def test_the_stiffness_of_inertia_is_the_derivative_of_its_force(
    kind: str, inertia: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    simulation = block(kind, inertia=inertia)
    simulation.advance(0.0, 0.02)
    balance = next_balance(simulation, 0.02, 0.05, monkeypatch)
    term, random = balance.motion, np.random.default_rng(3)
    assert isinstance(term, AssembledInertia)
    shape = (balance.active.nodes, balance.active.grid.dim)
    u, direction = 1e-3 * random.normal(size=shape), random.normal(size=shape)
    direction[term._constrained] = 0.0  # the axis
    blocks = np.zeros((len(balance.active.column), shape[1], shape[1]))
    term.add_stiffness(u, blocks)
    shift = RELATIVE_SHIFT * blocks[:, 0, 0].max() / (1.0 + RELATIVE_SHIFT)
    blocks[balance.active.diagonal] -= shift * np.eye(shape[1])
    rows = np.repeat(np.arange(shape[0]), np.diff(balance.active.row_start))
    product = np.zeros(shape)
    np.add.at(product, rows, np.einsum("bij,bj->bi", blocks, direction[balance.active.column]))
    difference = term.force(u + direction) - term.force(u)
    np.testing.assert_allclose(product, difference, rtol=0, atol=1e-9 * np.abs(difference).max())


@pytest.mark.slow
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("inertia", "spacing"), [*product([NEWMARK, ALPHA, PIC], ["uniform"]), (NEWMARK, "graded")]
)
def test_free_fall_is_exact(kind: str, basis: str, inertia: dict[str, Any], spacing: str) -> None:
    """The parabola is in the space of the method: displacement, velocity and no stress."""
    simulation = block(kind, basis, inertia, turns=False, spacing=spacing)
    run(simulation)
    points, end = simulation.state.points, 0.2
    first = np.zeros(points.position.shape[1])
    first[1] = 0.7
    first[0] = 0.0 if kind == "axisymmetric" else 0.3
    gravity = np.zeros_like(first)
    gravity[-1] = -GRAVITY
    moved = first * end + 0.5 * gravity * end**2
    np.testing.assert_allclose(points.displacement, np.tile(moved, (len(points), 1)), atol=1e-10)
    velocity = np.tile(first + gravity * end, (len(points), 1))
    np.testing.assert_allclose(points.motion[:, 0], velocity, rtol=0, atol=1e-8)
    assert np.abs(points.stress).max() < 1e-4 * 1e3 * GRAVITY


@pytest.mark.slow
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("spacing", SPACINGS)
def test_momentum_is_kept(kind: str, basis: str, spacing: str) -> None:
    """That of a turning, vibrating block in free fall, whatever lies on the grid's lines."""
    simulation = block(kind, basis, ALPHA, spacing=spacing)
    run(simulation)
    points = simulation.state.points
    first = np.array([0.3, 0.7, 0.0][: points.position.shape[1]])
    first[-1] -= GRAVITY * 0.2
    momentum = points.mass @ points.motion[:, 0]
    np.testing.assert_allclose(momentum, points.mass.sum() * first, rtol=0, atol=1e-7)


@pytest.mark.parametrize("basis", ["linear", "gimp"])
@pytest.mark.parametrize("kind", KINDS)
def test_pic_loses_only_what_the_grid_does_not_represent(kind: str, basis: str) -> None:
    """Of random velocities, in a step of almost no size: the momenta stay."""
    simulation = block(kind, basis, PIC, turns=False)
    points = simulation.state.points
    x, mass, number = points.position.copy(), points.mass.copy(), points.point_id.copy()
    before = np.random.default_rng(8).normal(size=x.shape)
    points.motion[:, 0] = before
    simulation.advance(0.0, 1e-12)
    after = points.motion[points.index_of(number), 0]
    np.testing.assert_allclose(mass @ after[:, 1], mass @ before[:, 1], rtol=1e-7)
    if kind != "axisymmetric":
        moments = [mass @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]) for v in (before, after)]
        assert moments[1] == pytest.approx(moments[0], rel=1e-7)
    energies = [mass @ (v**2).sum(axis=1) for v in (before, after)]
    assert 0.1 * energies[0] < energies[1] < 0.8 * energies[0]


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_results_do_not_depend_on_the_units(kind: str) -> None:
    one, other = block(kind), block(kind, length=1000.0, time=60.0)
    for each in (one, other):
        run(each)
    order, again = one.state.points.in_order, other.state.points.in_order
    np.testing.assert_allclose(
        other.state.points.displacement[again] / 1000.0,
        one.state.points.displacement[order],
        atol=1e-11,
    )
    velocity = other.state.points.motion[again, 0] * 60.0 / 1000.0
    np.testing.assert_allclose(velocity, one.state.points.motion[order, 0], atol=1e-8)


def bar(cells: int, steps: int, inertia: dict[str, Any] = NEWMARK) -> tuple[float, Energies, Any]:
    """Two periods of a fixed-free bar in its first mode; period over 4 L / c, energies, run.

    Its velocity at the start is the mode, sin(pi x / (2 L)).
    """
    length, speed = 1.0, 100.0
    period = 4.0 * length / speed
    simulation = Simulation(
        Model.from_dict(
            {
                "units": {"time": "s"},
                "analysis": {"kind": "plane_strain", "inertia": inertia, "tolerance": 1e-10},
                "grid": {"cell_size": length / cells},
                "materials": {
                    "steel": {
                        "model": "hencky_elastic",
                        "young_modulus": 1e3 * speed**2,
                        "poisson_ratio": 0.0,
                        "density": 1e3,
                    }
                },
                "bodies": [
                    {
                        "name": "bar",
                        "material": "steel",
                        "basis": "linear",
                        "points_per_cell": 2,
                        "shape": {
                            "type": "box",
                            "lower": [0.0, 0.0],
                            "upper": [length, length / cells],
                        },
                    }
                ],
                "boundaries": [
                    {"name": "end", "type": "plane", "axis": "x", "at": 0.0, "condition": "roller"}
                ],
                "schedule": {"end": 2.0 * period, "steps": 2 * steps},
            }
        )
    )
    points = simulation.state.points
    points.motion[:, 0, 0] = 1e-5 * np.sin(0.5 * np.pi * points.position[:, 0])
    tip = points.point_id[[points.position[:, 0].argmax()]]
    energies = Energies.at_start(simulation.setup, simulation.state)
    times, moved = [0.0], [0.0]
    for number in range(2 * steps):
        times.append(2.0 * period * (number + 1) / (2 * steps))
        energies.add(simulation.advance(times[-2], times[-1]))
        moved.append(float(points.displacement[points.index_of(tip)[0], 0]))
    crossing = [
        times[i] - moved[i] * (times[i + 1] - times[i]) / (moved[i + 1] - moved[i])
        for i in range(1, 2 * steps)
        if moved[i] * moved[i + 1] < 0.0
    ]
    found = 2.0 * (crossing[-1] - crossing[0]) / (len(crossing) - 1)
    return found / period, energies, simulation


def test_a_bar_has_its_period_and_keeps_its_energy() -> None:
    """0.2 % with 40 cells and 80 steps; the method's own error is (omega h)^2 / 12 and so on."""
    period, energies, simulation = bar(40, 80)
    assert period == pytest.approx(1.0, abs=2e-3)
    assert (
        abs(energies.value("numerical_dissipation", simulation.setup, simulation.state, 0.0))
        < 1e-7 * energies.start
    )


def test_the_period_is_of_second_order() -> None:
    errors = [abs(bar(cells, 2 * cells)[0] - 1.0) for cells in (10, 20, 40)]
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(rates, 2.0, atol=0.1)


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("radius", [None, 1.0, 0.6, 0.0])
def test_the_local_error_is_that_of_a_constant_jerk(
    radius: float | None, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the method's displacement lacks of Taylor's series: (beta - 1/6) h^3 times the jerk.

    By the trapezoidal rule h^3 / 12 times it; beta = 1 / (1 + radius)^2. A step of the size that
    is said to be possible has just the largest error.
    """
    most, cell = 1e-3, 0.25
    inertia = NEWMARK if radius is None else ALPHA | {"spectral_radius": radius}
    simulation = block(kind, inertia=inertia | {"largest_error": most})
    simulation.advance(0.0, 1e-3)
    dim = dimension(kind)
    v, a, jerk = np.array([[2.0, -0.3, 1.1], [-40.0, 15.0, 3.0], [7e3, -2e4, 3e3]])[:, :dim]
    simulation.state.points.motion[:] = v, a, a
    beta = 0.25 if radius is None else (1.0 + radius) ** -2

    def step(h: float) -> tuple[Floats, float]:
        """Error and possible relative size; the points' velocity and acceleration are exact."""
        balance = next_balance(simulation, 1e-3, 1e-3 + h, monkeypatch)
        taylor = h * v + h**2 / 2.0 * a + h**3 / 6.0 * jerk
        moved = h * v + h**2 * ((0.5 - beta) * a + beta * (a + h * jerk))
        u = np.tile(moved, (balance.active.nodes, 1))
        error = balance.motion.local_error(u)
        if radius in (None, 1.0):
            trapezoidal = h * v + h**2 / 4.0 * (2.0 * a + h * jerk)
            np.testing.assert_allclose(trapezoidal - taylor, h**3 / 12.0 * jerk, rtol=1e-10)
        np.testing.assert_allclose(error, np.tile(moved - taylor, (len(error), 1)), rtol=1e-6)
        still = balance.motion.guess() - (h * v + h**2 / 2.0 * a)
        np.testing.assert_allclose(still, 0.0, atol=1e-8 * h * np.abs(v).max())
        dynamics, sizes = simulation.state.declared_dynamics, np.full_like(error, cell)
        assert dynamics is not None
        return error, dynamics.possible_size(balance, u, np.zeros_like(error), sizes)[0]

    h = 0.01
    error, share = step(h)
    assert share == pytest.approx((most * cell / np.linalg.norm(error[0])) ** (1.0 / 3.0), rel=1e-6)
    error, again = step(share * h)
    assert np.linalg.norm(error, axis=1) == pytest.approx(most * cell, rel=1e-6)
    assert again == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("radius", [1.0, 0.8, 0.5, 0.0])
def test_the_spectral_radius_is_that_of_high_frequencies(radius: float) -> None:
    """The largest eigenvalue of the method's amplification matrix at infinite frequency."""
    method, h = TimeIntegration.generalised_alpha(radius), 1.0
    omega = 1e8
    _, by_u = method.derivatives(h)
    columns = []
    for unit in np.eye(4):  # displacement, velocity, acceleration, algorithmic acceleration
        u, v, w, a = unit
        before = Motion(np.array([v]), np.array([w]), np.array([a]))
        constant = method.after(np.zeros(1), h, before).acceleration
        increment = -(constant + omega**2 * u) / (by_u + omega**2)
        after = method.after(increment, h, before)
        columns.append(
            [u + increment[0], after.velocity[0], after.acceleration[0], after.algorithmic[0]]
        )
    matrix = np.array(columns).T
    scale = np.array([1.0, 1.0 / h, omega**2, omega**2])  # balance
    values = np.abs(np.linalg.eigvals(matrix * (1.0 / scale)[:, None] * scale))
    assert values.max() == pytest.approx(radius, abs=2e-2)


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_a_grain_alone_flies_without_deforming(kind: str, basis: str) -> None:
    """Its own mass does not determine the velocity of its nodes: what is left is constant."""
    dim, steps = dimension(kind), 20
    lower = np.array([2.3, 2.6, 2.15][:dim])
    sand = {"model": "mohr_coulomb", "young_modulus": 1e6, "poisson_ratio": 0.3, "cohesion": 0.0}
    sand |= {"friction_angle": 30.0, "dilation_angle": 0.0, "density": 1500.0, "separates": True}
    box = {"type": "box", "lower": lower.tolist(), "upper": (lower + 0.5).tolist()}
    body = {"name": "grain", "material": "sand", "shape": box, "basis": basis, "points": [1] * dim}
    gravity = {"type": "body_force", "acceleration": [0.0] * (dim - 1) + [-GRAVITY]}
    simulation = Simulation(
        Model.from_dict(
            {
                "title": "Grain",
                "units": {"time": "s"},
                "analysis": {"kind": kind, "inertia": ALPHA | {"velocity_update": "pic"}},
                "grid": {"cell_size": 1.0},
                "materials": {"sand": sand},
                "bodies": [body],
                "initial": {"velocity": [{"body": "grain", "x": 7.0}]},
                "loads": [{**gravity, "factor": [[0.0, 1.0], [1.0, 1.0]]}],
                "schedule": {"end": 0.2, "steps": steps},
            }
        )
    )
    simulation.check()
    for step in range(steps):
        schedule = simulation.setup.model.schedule
        simulation.advance(schedule.regular_time(step), schedule.regular_time(step + 1))
    gradient = simulation.state.points.deformation_gradient[0]
    assert gradient == pytest.approx(np.eye(3), abs=1e-13)
    velocity = [7.0] + [0.0] * (dim - 2) + [-0.2 * GRAVITY]
    assert simulation.state.points.motion[0, 0] == pytest.approx(velocity, abs=1e-9)


def in_a_mirror(sign: float) -> dict[str, Any]:
    """Soft ground under its weight on a grid whose lines its domains reach but for round-off."""

    def box(name: str, left: float, right: float, base: float, top: float) -> dict[str, Any]:
        ends = sorted([sign * left, sign * right])
        shape = {"type": "box", "lower": [ends[0], base], "upper": [ends[1], top]}
        return {
            "name": name, "material": "soil", "basis": "gimp", "shape": shape, "points_per_cell": 4,
        }  # fmt: skip

    stiffness = {"depth": [[-1.0, 800.0], [5.0, 2000.0]], "surface": 1.5}
    soil = {"model": "hencky_elastic", "density": 2.0, "poisson_ratio": 0.3}
    rest = {"type": "k0", "K0": 0.6}
    return {
        "units": {"time": "s"},
        "analysis": {"kind": "plane_strain", "inertia": NEWMARK},
        "grid": {"cell_size": 0.5},
        "materials": {"soil": {**soil, "young_modulus": stiffness}},
        "bodies": [box("ground", 0.0, 2.0, 0.0, 1.0), box("above", 0.125, 0.925, 1.0, 1.5)],
        "boundaries": [
            {"name": axis, "type": "plane", "axis": axis, "at": 0.0, "condition": "roller"}
            for axis in "xy"
        ],
        "loads": [{"type": "body_force", "acceleration": [0.0, -5.0], "factor": [[0, 1], [1, 1]]}],
        "initial": {"stress": [{**rest, "body": body} for body in ("ground", "above")]},
        "stages": [
            {"name": "fall", "schedule": {"steps": 2, "end": 0.2}, "grid": {"cell_size": 0.25}}
        ],
    }


def test_nodes_that_soil_touches_by_round_off_have_the_same_ghost_mass() -> None:
    """In a mirror other nodes are touched so, and the motion must be the same."""
    found = []
    for sign in (1.0, -1.0):
        points = march_stages(Model.from_dict(in_a_mirror(sign))).simulation.state.points
        mirror = np.array([sign, 1.0])
        place, velocity = mirror * points.position, mirror * points.motion[:, 0]
        order = np.lexsort(np.round(place, 4).T)
        found.append(velocity[order])
    largest = np.abs(found[0]).max()
    np.testing.assert_allclose(found[1], found[0], rtol=0.0, atol=1e-9 * largest)
