# SPDX-License-Identifier: BSD-3-Clause
"""The paper's full form, integrated over the band, tends to its limit on the surface.

The limits of docs/theory/implicit_boundaries.md are written here once more, with the elasticity
tensor in full and the shape functions of the grid.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from implicit_problems import (
    MODULUS,
    POISSON,
    dense,
    implicit,
    line,
    locate_contacts,
    of_part,
)
from small_problems import KINDS, block_entries, dimension

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries.implicit.band import BandConstraint
from tilth.mpm.active_grid import ActiveGrid

CONDITIONS = ("roller", "fixed", "tangential", "direction")
CASES = [
    *product(KINDS, ["flat"], CONDITIONS),
    *product(["plane_strain", "axisymmetric"], ["round"], CONDITIONS),
    ("3d", "round", "tangential"),
]


def geometries(kind: str) -> dict[str, dict[str, Any]]:
    """An inclined piece and a round face, both inside a block of two cells a side."""
    dim = dimension(kind)
    edges = {"width": 1.1} if dim == 2 else {"width": [1.1, 0.9], "along": [1.0, 0.0, 0.0]}
    return {
        "flat": {
            "type": "footing", "centre": [1.07] * dim, "normal": [0.3, 0.5, 1.0][-dim:],
            **edges,
        },
        "round": {
            "type": "sphere" if dim == 3 else "circle", "centre": [1.07] * dim, "radius": 0.61,
            "soil": "outside",
        },
    }  # fmt: skip


def block(
    kind: str, geometry: dict[str, Any], condition: str, form: str, delta: float
) -> Simulation:
    """A block with one implicit boundary and what holds the rest of it."""
    wall = implicit("wall", geometry, condition=condition, form=form, delta=delta)
    if condition == "direction":
        wall["direction"] = [0.6, 0.8, -0.3][: dimension(kind)]
    return Simulation(Model.from_dict(block_entries(kind, "linear", boundaries=[wall])))


def elasticity() -> Floats:
    """C_ijkl of isotropic elasticity [stress]."""
    one = np.eye(3)
    lame, shear = (
        MODULUS * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)),
        MODULUS / (2 + 2 * POISSON),
    )
    pairs = np.einsum("ik,jl->ijkl", one, one) + np.einsum("il,jk->ijkl", one, one)
    return np.asarray(lame * np.einsum("ij,kl->ijkl", one, one) + shear * pairs)


def shape_functions(active: ActiveGrid, place: Floats) -> tuple[Floats, Floats]:
    """Hat functions of all nodes at one place, (nodes,), and their gradients, (nodes, dim)."""
    ratio = (place - active.position) / active.grid.cell_size
    hat, slope = np.maximum(0.0, 1.0 - np.abs(ratio)), -np.sign(ratio) / active.grid.cell_size
    slope = np.where(np.abs(ratio) < 1.0, slope, 0.0)
    gradient = [slope[:, k] * np.delete(hat, k, axis=1).prod(axis=1) for k in range(len(place))]
    return hat.prod(axis=1), np.stack(gradient, axis=1)


def limits(
    kind: str, geometry: dict[str, Any], condition: str, delta: float
) -> tuple[Floats, Floats]:
    """K3 and K2 + K2^T in the limit of a narrow band, from the surface's own points."""
    simulation = block(kind, geometry, condition, "surface", delta)
    active, constraints = locate_contacts(simulation)
    pose = constraints.parts[0].pose
    dim, nodes = active.grid.dim, active.nodes
    stiffness = elasticity()
    k3, k2 = np.zeros((nodes, dim, nodes, dim)), np.zeros((nodes, dim, nodes, dim))
    for place, normal, weight, projector in zip(
        pose.position, pose.normal, pose.weight, pose.projector, strict=True
    ):
        m, constrained = np.zeros(3), np.zeros((3, 3))
        m[:dim], constrained[:dim, :dim] = normal, projector
        hat, gradient = shape_functions(active, place)
        touched = np.flatnonzero(hat)
        hat, gradient = hat[touched], gradient[touched]
        vector = np.zeros((len(touched), dim, 3))  # the field of one unknown
        vector[:, range(dim), range(dim)] = hat[:, None]
        rate = np.zeros((len(touched), dim, 3, 3))  # its gradient
        for k in range(dim):
            rate[:, k, k, :dim] = gradient
        if kind == "axisymmetric":
            rate[:, 0, 2, 2] = hat / place[0]
        jump = np.einsum("ij,akj,l->akil", constrained, vector, m)
        mean = np.einsum("ij,akjl->akil", np.eye(3) - 0.5 * constrained, rate)
        rows = np.ix_(touched, range(dim), touched, range(dim))
        k3[rows] += (
            4.0 / (3.0 * delta) * weight
            * np.einsum("akij,ijmn,blmn->akbl", jump, stiffness, jump)
        )  # fmt: skip
        k2[rows] += weight * np.einsum("akij,ijmn,blmn->akbl", mean, stiffness, jump)
    size = nodes * dim
    k2 = k2.reshape(size, size)
    return k3.reshape(size, size), k2 + k2.T


def parts(
    kind: str, geometry: dict[str, Any], condition: str, delta: float
) -> tuple[Floats, Floats]:
    """K3 of a boundary's band and the rest of its matrix."""
    active, constraints = locate_contacts(block(kind, geometry, condition, "band", delta))
    (part,) = constraints.parts
    assert isinstance(part, BandConstraint)
    weighted = part.pose.weight[:, None, None] * part.penalty
    node = part.at.node[part.at.cell]
    penalty = np.zeros((active.nodes, active.grid.dim) * 2)
    for nodes, value, own in zip(node, part.at.value, weighted, strict=True):
        block_of = np.einsum("a,b,ij->aibj", value, value, own)
        penalty[np.ix_(nodes, range(active.grid.dim), nodes, range(active.grid.dim))] += block_of
    k3 = penalty.reshape((active.nodes * active.grid.dim,) * 2)
    return k3, dense(part.coupling(), active.nodes) - k3


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "shape", "condition"), CASES)
def test_band_tends_to_the_surface_at_first_order(kind: str, shape: str, condition: str) -> None:
    geometry = geometries(kind)[shape]
    errors = []
    for delta in (1e-2, 1e-3):
        exact = limits(kind, geometry, condition, delta)
        found = parts(kind, geometry, condition, delta)
        errors.append(
            [np.linalg.norm(a - b) / np.linalg.norm(b) for a, b in zip(found, exact, strict=True)]
        )
    coarse, fine = np.array(errors)
    assert (coarse < 0.05).all()
    np.testing.assert_allclose(fine / coarse, 0.1, rtol=0.3)


@pytest.mark.parametrize(("kind", "shape", "condition"), CASES)
def test_surface_form_holds_means_of_the_first_limit(kind: str, shape: str, condition: str) -> None:
    """A mean's square is at most the mean square: no displacement costs more than K3 asks.

    It costs as much where the slip is the same all over a flat boundary.
    """
    geometry = geometries(kind)[shape]
    exact, _ = limits(kind, geometry, condition, 1e-3)
    active, constraints = locate_contacts(block(kind, geometry, condition, "surface", 1e-3))
    found, _ = of_part(constraints.parts[0], active.nodes)
    less = np.linalg.eigvalsh(exact - found)
    assert less.min() > -1e-9 * less.max()
    assert less.max() > 1e-3 * np.abs(exact).max(), "it holds less than each point would"
    if shape == "flat":
        for unit in np.eye(active.grid.dim):
            uniform = np.tile(unit, active.nodes)
            assert uniform @ found @ uniform == pytest.approx(
                uniform @ exact @ uniform, rel=1e-10, abs=1e-9 * np.abs(exact).max()
            )


@pytest.mark.parametrize("condition", CONDITIONS)
def test_wide_band_has_the_energy_of_the_product_of_functions(condition: str) -> None:
    """u K u = energy of D u in the band less that of D grad u, which is K1's part.

    Along a grid line's direction all is polynomial and integrated exactly.
    """
    delta, random = 0.3, np.random.default_rng(5)
    geometry = {"type": "footing", "centre": [0.5, 1.2], "normal": [0.0, 1.0], "width": 0.7}
    simulation = block("plane_strain", geometry, condition, "band", delta)
    active, constraints = locate_contacts(simulation)
    (part,) = constraints.parts
    assert isinstance(part, BandConstraint)
    matrix = dense(part.coupling(), active.nodes)
    constrained = part.pose.projector[0]
    u = random.uniform(-1, 1, active.position.shape)

    def field(place: Floats) -> Floats:
        hat, _ = shape_functions(active, place)
        share = (place[1] - 1.2) / delta
        return np.asarray((np.eye(2) - (1.0 - share) ** 2 * constrained) @ (hat @ u))

    energy, step = 0.0, 1e-5
    for s, across in zip(*np.polynomial.legendre.leggauss(6), strict=True):
        for t, along in zip(*np.polynomial.legendre.leggauss(6), strict=True):
            place = np.array([0.5 + 0.35 * t, 1.2 + 0.5 * delta * (1.0 + s)])
            _, slope = shape_functions(active, place)
            share = (place[1] - 1.2) / delta
            rates = np.zeros((2, 3, 3))
            for k, unit in enumerate(step * np.eye(2)):
                rates[0, :2, k] = (field(place + unit) - field(place - unit)) / (2.0 * step)
            rates[1, :2, :2] = (np.eye(2) - (1.0 - share) ** 2 * constrained) @ (u.T @ slope)
            squares = np.einsum("rij,ijkl,rkl->r", rates, elasticity(), rates)
            energy += across * along * 0.35 * 0.5 * delta * (squares[0] - squares[1])
    assert u.ravel() @ matrix @ u.ravel() == pytest.approx(energy, rel=1e-7)


@pytest.mark.parametrize(("poisson_ratio", "capped"), [(0.35, False), (0.45, True)])
def test_constrained_modulus_is_capped_at_three_times_young_s(
    poisson_ratio: float, capped: bool
) -> None:
    wall = implicit("wall", line(np.array([0.0, 0.3]), np.array([0.0, 1.0])), delta=1e-3)
    entries = block_entries("plane_strain", "linear", boundaries=[wall])
    entries["materials"]["soil"]["poisson_ratio"] = poisson_ratio
    _, constraints = locate_contacts(Simulation(Model.from_dict(entries)))
    nu = poisson_ratio
    constrained = (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
    assert (constrained > 3.0) == capped
    penalty = constraints.parts[0].penalty
    expected = 4.0 / 3e-3 * MODULUS * min(constrained, 3.0)
    np.testing.assert_allclose(penalty[:, 1, 1], expected, rtol=1e-12)
    np.testing.assert_allclose(penalty[:, 0], 0.0, atol=1e-9)
