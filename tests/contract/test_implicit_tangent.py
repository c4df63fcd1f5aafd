# SPDX-License-Identifier: BSD-3-Clause
"""Stiffness of implicit boundaries = derivative of their force; Newton stays quadratic."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from balances import blocks_at, residual_at
from implicit_problems import implicit, line, locate_contacts, of_part, rotation
from small_problems import (
    BASES,
    KINDS,
    WEAK,
    block_entries,
    dimension,
    material_entries,
    spaced,
    weight,
    yields,
)

import tilth.analysis.attempts
from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.analysis.step import Equilibrium, solve_step
from tilth.arrays import Floats

CONDITIONS = ("roller", "fixed", "tangential", "direction")
FORMS = ("surface", "band")
MOTIONS = ("rests", "moves")

every_kind = pytest.mark.parametrize("kind", KINDS)
every_condition = pytest.mark.parametrize("condition", CONDITIONS)
every_form = pytest.mark.parametrize("form", FORMS)
every_motion = pytest.mark.parametrize("motion", MOTIONS)

LOW, HIGH = 0.3, 1.8
"""The block's extent in each direction; its inner face is on the axis in axisymmetry."""


def motion_entries(kind: str, motion: str, size: float = 0.05) -> dict[str, Any]:
    """A translation, where the kind of analysis allows it with a rotation."""
    if motion == "rests":
        return {}
    up = "z" if kind == "3d" else "y"
    entries: dict[str, Any] = {"displacement": {up: size}}
    if kind != "axisymmetric":
        entries["rotation"] = {"angle": 60.0 * size, "centre": [0.0] * dimension(kind)}
        if kind == "3d":
            entries["rotation"]["axis"] = "x"
    return entries


def held_block(
    kind: str,
    condition: str,
    form: str,
    motion: str,
    *,
    basis: str = "gimp",
    material: str = "hencky_elastic",
    delta: float = 0.2,
    tilt: float = 0.25,
    load: float = 20.0,
    size: float = 0.05,
    spacing: str = "uniform",
) -> Simulation:
    """A block that cuts cells on an inclined implicit base, its outer side fixed to another one.

    The wide band makes all parts of the stiffness of one size, so that none hides behind another.
    """
    dim = dimension(kind)
    high = LOW + 0.9 if kind == "3d" else HIGH  # for speed
    lower = [LOW] * dim
    if kind == "axisymmetric":
        lower[0] = 0.0
    normal = np.append(np.full(dim - 1, -tilt), 1.0)
    base = implicit(
        "base", line(np.full(dim, LOW), normal), condition=condition, form=form, delta=delta,
        **motion_entries(kind, motion, size),
    )  # fmt: skip
    if condition == "direction":
        base["direction"] = [0.6, 0.8, -0.3][:dim]
    side = implicit(
        "side", line(np.full(dim, high), -np.eye(dim)[0]), condition="fixed", form=form,
        delta=delta,
    )  # fmt: skip
    entries = block_entries(
        kind, basis, material, boundaries=[base, side], loads=[weight(kind, load)]
    )
    entries["materials"]["soil"] = material_entries(material, **WEAK.get(material, {}))
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body["spacing"] = 0.3
    body["shape"] = {"type": "box", "lower": lower, "upper": [high] * dim}
    entries["analysis"] |= {"tolerance": 1e-12, "maximum_iterations": 40, "line_search": False}
    return Simulation(Model.from_dict(spaced(entries, spacing)))


def carry_something(simulation: Simulation, random: np.random.Generator) -> None:
    """As after earlier steps: tractions at all quadrature points."""
    locate_contacts(simulation)
    for boundary in simulation.state.implicit:
        boundary.carried = 10.0 * random.uniform(-1, 1, boundary.carried.shape)


def relative_difference(
    force: Callable[[Floats], Floats],
    product: Floats,
    centre: Floats,
    direction: Floats,
    steps: tuple[float, ...],
) -> float:
    """Of a product K v and the central difference of the force along v; that of the best step."""
    errors = []
    for step in steps:
        above, below = force(centre + step * direction), force(centre - step * direction)
        difference = (above - below).ravel() / (2.0 * step)
        errors.append(np.linalg.norm(difference - product.ravel()) / np.linalg.norm(product))
    return float(min(errors))


@every_kind
@every_condition
@every_form
@every_motion
def test_matrix_of_a_boundary_is_the_derivative_of_its_force(
    kind: str, condition: str, form: str, motion: str
) -> None:
    simulation = held_block(kind, condition, form, motion)
    random = np.random.default_rng(2)
    carry_something(simulation, random)
    active, constraints = locate_contacts(simulation, 0.2, 0.7)
    assert len(constraints.parts) == 2
    shape = active.position.shape
    for part in constraints.parts:
        matrix, constant = of_part(part, active.nodes)
        assert np.abs(matrix - matrix.T).max() < 1e-12 * np.abs(matrix).max()

        def force(u: Floats, part: Any = part) -> Floats:
            return np.asarray(part.nodal_force(part.after(u), active.nodes))

        centre = 0.05 * random.uniform(-1, 1, shape)
        expected = constant + (matrix @ centre.ravel()).reshape(shape)
        np.testing.assert_allclose(force(centre), expected, atol=1e-11 * np.abs(expected).max())
        columns = random.choice(np.flatnonzero(np.abs(matrix).max(axis=0)), 4, replace=False)
        for column in columns:
            direction = np.zeros(matrix.shape[0])
            direction[column] = 1.0
            error = relative_difference(
                force, matrix[:, column], centre, direction.reshape(shape), (1e-3,)
            )
            assert error < 1e-7


@every_kind
@every_form
@pytest.mark.parametrize("condition", ["fixed", "direction"])
def test_soil_that_moves_with_a_boundary_only_turns_what_it_carries(
    kind: str, condition: str, form: str
) -> None:
    """No slip: tractions and the band's stresses turn with the boundary, half by half."""
    simulation = held_block(kind, condition, form, "moves")
    carry_something(simulation, np.random.default_rng(3))
    active, constraints = locate_contacts(simulation, 0.2, 0.7)
    part = next(p for p in constraints.parts if p.boundary.name == "base")
    boundary, quadrature = part.boundary, part.boundary.quadrature
    assert quadrature is not None
    carried = boundary.carried[part.chosen]
    dim = dimension(kind)
    at_start = boundary.motion.reference(active.position, 0.2)
    rigid = boundary.motion.position(at_start, 0.7) - active.position
    assert np.abs(rigid).max() > 0.02
    after = part.after(rigid)
    np.testing.assert_allclose(after, part.before, atol=1e-9 * np.abs(part.penalty).max())
    part.commit(after)
    angle = 0.0 if kind == "axisymmetric" else 3.0
    half, whole, normal_turn = (_turn(kind, share * angle) for share in (0.25, 0.5, 0.45))
    for turn, found in ((half, part.before), (whole, boundary.carried[part.chosen])):
        expected = carried[:, :dim] @ turn[:dim, :dim].T
        np.testing.assert_allclose(found[:, :dim], expected, atol=1e-6)
        if form == "band":
            stress = turn @ carried[:, dim:].reshape(-1, 3, 3) @ turn.T
            np.testing.assert_allclose(found[:, dim:].reshape(-1, 3, 3), stress, atol=1e-6)
    expected = quadrature.normal[part.chosen] @ normal_turn[:dim, :dim].T
    np.testing.assert_allclose(part.pose.normal, expected, atol=1e-12)


def _turn(kind: str, degrees: float) -> Floats:
    """Rotation about z, in 3D about x."""
    whole = np.eye(3)
    first = 1 if kind == "3d" else 0
    whole[first : first + 2, first : first + 2] = rotation(degrees)
    return whole


class Stopped(Exception):
    """Ends a step where its equations are known."""


def equations(
    simulation: Simulation, monkeypatch: pytest.MonkeyPatch, before: float, after: float
) -> tuple[Callable[[Floats], Floats], Callable[[Floats], Floats], tuple[int, ...]]:
    """Internal force and dense matrix of a step, as functions of the nodal displacement."""
    found: list[Any] = []

    def stop(*arguments: Any) -> Equilibrium:
        found.extend(arguments)
        raise Stopped

    monkeypatch.setattr(tilth.analysis.attempts, "solve_step", stop)
    with pytest.raises(Stopped):
        simulation.advance(before, after)
    monkeypatch.setattr(tilth.analysis.attempts, "solve_step", solve_step)
    balance, *_ = found
    active = balance.active
    size = active.nodes * active.grid.dim

    def force(u: Floats) -> Floats:
        return np.asarray(residual_at(balance, u).u)

    def matrix(u: Floats) -> Floats:
        residual_at(balance, u)
        blocks = blocks_at(balance, u)
        whole = sp.bsr_matrix((blocks, active.column, active.row_start), shape=(size, size))
        return np.asarray(whole.toarray())

    return force, matrix, active.position.shape


OTHER_BASES = [basis for basis in BASES if basis != "gimp"]
STEPS = [
    *product(["gimp"], KINDS, CONDITIONS, FORMS, MOTIONS, ["uniform"]),
    *product(OTHER_BASES, KINDS, ["roller", "fixed"], ["surface"], ["moves"], ["uniform"]),
    *product(BASES, KINDS, ["roller"], FORMS, ["moves"], ["graded"]),
]


@pytest.mark.slow
@pytest.mark.parametrize(("basis", "kind", "condition", "form", "motion", "spacing"), STEPS)
def test_matrix_of_a_step_is_the_derivative_of_its_force(
    basis: str,
    kind: str,
    condition: str,
    form: str,
    motion: str,
    spacing: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Soil, boundaries, ghost stabilisation and springs together."""
    random = np.random.default_rng(4)
    simulation = held_block(kind, condition, form, motion, basis=basis, spacing=spacing)
    carry_something(simulation, random)
    force, matrix, shape = equations(simulation, monkeypatch, 0.2, 0.7)
    scale = np.ones(shape)
    if kind == "axisymmetric":
        scale[:, 0] = 0.0  # a random radial motion would tear the axis
    centre = 0.03 * scale * random.uniform(-1, 1, shape)
    whole = matrix(centre)
    for _ in range(2):
        direction = random.uniform(-1, 1, shape)
        product = whole @ direction.ravel()
        assert relative_difference(force, product, centre, direction, (1e-4, 1e-5, 1e-6)) < 1e-7


MATERIALS = ("hencky_elastic", "von_mises")
QUADRATIC = [
    *product(["gimp"], ["hencky_elastic"], ["plane_strain"], CONDITIONS, FORMS, MOTIONS),
    *product(["gimp"], ["von_mises"], ["plane_strain"], CONDITIONS, FORMS, ["moves"]),
    *product(["gimp"], MATERIALS, ["axisymmetric", "3d"], ["fixed"], FORMS, ["moves"]),
    *product(OTHER_BASES, MATERIALS, KINDS, ["roller", "fixed"], ["surface"], ["moves"]),
]


@pytest.mark.parametrize(("basis", "material", "kind", "condition", "form", "motion"), QUADRATIC)
def test_newton_converges_quadratically(
    basis: str, material: str, kind: str, condition: str, form: str, motion: str
) -> None:
    """r_(k+1) <= C r_k^2: a tangent that is 0.1 % wrong gains three digits a step, no more."""
    load = 12.0 if yields(material) else 40.0
    simulation = held_block(
        kind,
        condition,
        form,
        motion,
        basis=basis,
        material=material,
        delta=1e-2,
        load=load,
        size=0.03,
    )
    residuals = np.array(simulation.advance(0.0, 1.0).equilibrium.residuals)
    if yields(material):
        assert (simulation.state.points.plastic[:, 0] > 1e-3).mean() > 0.2
    tail = residuals[residuals < 0.1]
    clean = tail[tail > 1e-11]  # below that stands round-off
    assert len(clean) >= 2
    assert clean[0] / tail[-1] > 1e6
    constant = tail[1 : len(clean) + 1] / clean[: len(tail) - 1] ** 2
    assert constant[tail[1 : len(clean) + 1] > 1e-11].max() < 30.0
