# SPDX-License-Identifier: BSD-3-Clause
"""Assembly of the stiffness where grid lines cut domains: groups that share a local matrix."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest
from small_problems import CORNER_BASES, Laboratory

from tilth import _core
from tilth.arrays import Floats
from tilth.mpm.active_grid import Stencil

pytestmark = pytest.mark.usefixtures("every_loop_in_parallel")

CUT = [("3d", basis) for basis in ("gimp", *CORNER_BASES)] + [
    ("plane_strain", basis) for basis in ("gimp", *CORNER_BASES)
]
every_cut_basis = pytest.mark.parametrize(("kind", "basis"), CUT)


def cut_laboratory(kind: str, basis: str, material: str, stretch: float = 1.0) -> Laboratory:
    """Points at random places whose domains differ in size, cut by grid lines at random."""
    random = np.random.default_rng(11)
    laboratory = Laboratory.of(kind, basis, material, random, cells=3 if kind == "3d" else 10)
    points, dim = laboratory.points, laboratory.grid.dim
    points.position += random.uniform(-0.3, 0.3, points.position.shape)
    points.half_length *= random.uniform(0.6, 1.4, points.half_length.shape)
    tilt = np.eye(dim) + 0.15 * random.standard_normal((len(points), dim, dim))
    points.corner[:] = stretch * np.einsum("pij,pcj->pci", tilt, points.corner)
    laboratory.locate()
    laboratory.soil.update(laboratory.random_displacement(random, 0.04))
    return laboratory


def assembled(laboratory: Laboratory) -> Floats:
    """Blocks of the stiffness of the trial state."""
    dim = laboratory.grid.dim
    blocks = np.zeros((len(laboratory.active.column), dim, dim))
    laboratory.soil.add_stiffness(laboratory.active, blocks)
    return blocks


def spatial_tangent(response: Floats, dim: int) -> tuple[Floats, Floats, Floats]:
    """Map to principal gradients, principal axes [i, p], and a_pqrs (kernel/response.hpp)."""
    to_current, axis, rest = np.split(response, [dim**2, 2 * dim**2])
    stress, tangent, beta = rest[:3], rest[3:12].reshape(3, 3), rest[12 : 12 + dim]
    shear = dict(zip([(0, 1), (1, 2), (0, 2)], rest[12 + dim :], strict=False))
    a = np.zeros((dim,) * 4)
    for p in range(dim):
        for q in range(dim):
            a[p, p, q, q] += tangent[p, q]
            if p == q:
                a[p, p, p, p] -= stress[p]
                continue
            a[p, q, p, q] += shear[min(p, q), max(p, q)] * beta[q]
            a[p, q, q, p] += shear[min(p, q), max(p, q)] * beta[p] - stress[p]
    return to_current.reshape(dim, dim), axis.reshape(dim, dim), a


def straightforward(laboratory: Laboratory) -> Floats:
    """The same blocks, added point by point and block by block."""
    active, dim, points = laboratory.active, laboratory.grid.dim, laboratory.points
    (stencil,) = active.stencils
    _, gradients = stencil.basis()
    blocks = np.zeros((len(active.column), dim, dim))
    at = 0
    for g in range(len(stencil.start) - 1):
        node = stencil.node[stencil.node_start[g] : stencil.node_start[g + 1]]
        rows = [slice(*active.row_start[[a, a + 1]]) for a in node]
        places = [row.start + np.searchsorted(active.column[row], node) for row in rows]
        for p in range(stencil.start[g], stencil.start[g + 1]):
            gradient = gradients[at : at + dim * len(node)].reshape(dim, len(node))
            at += dim * len(node)
            to_current, axis, a = spatial_tangent(laboratory.soil._trial.response[p], dim)
            along = to_current @ gradient
            own = np.einsum("ip,qa,pqrs,sb,kr->abik", axis, along, a, along, axis, optimize=True)
            for row, column in enumerate(places):
                blocks[column] += points.initial_volume[p] * own[row]
    return blocks


def clusters(stencil: Stencil) -> list[list[frozenset[int]]]:
    """The nodes of the groups whose boxes begin at one node, in the order of the groups."""
    numbers = groupby(range(len(stencil.first)), lambda g: tuple(stencil.first[g]))
    start = stencil.node_start
    return [
        [frozenset(stencil.node[start[g] : start[g + 1]].tolist()) for g in group]
        for _, group in numbers
    ]


@pytest.mark.slow
@every_cut_basis
@pytest.mark.parametrize("material", ["hencky_elastic", "von_mises", "mohr_coulomb"])
def test_sum_over_points(kind: str, basis: str, material: str) -> None:
    """Clusters of several groups, with one widest group and with several."""
    laboratory = cut_laboratory(kind, basis, material)
    (stencil,) = laboratory.active.stencils
    found = clusters(stencil)
    widest = [sum(not any(own < other for other in group) for own in group) for group in found]
    assert max(map(len, found)) >= 4
    assert min(widest) == 1
    assert max(widest) > 1
    expected = straightforward(laboratory)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(assembled(laboratory), expected, rtol=0, atol=1e-13 * scale)


@pytest.mark.parametrize("basis", CORNER_BASES)
def test_domains_too_wide_for_one_local_matrix(basis: str) -> None:
    laboratory = cut_laboratory("3d", basis, "von_mises", stretch=2.5)
    (stencil,) = laboratory.active.stencils
    assert stencil.count.prod(axis=1).max() > 64
    expected = straightforward(laboratory)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(assembled(laboratory), expected, rtol=0, atol=1e-13 * scale)


@every_cut_basis
@pytest.mark.parametrize("material", ["von_mises", "mohr_coulomb"])
def test_same_bits_for_any_number_of_threads(kind: str, basis: str, material: str) -> None:
    laboratory = cut_laboratory(kind, basis, material)
    bits = set()
    for threads in (1, 2, 3, 2):
        _core.set_threads(threads)
        bits.add(assembled(laboratory).tobytes())
    assert len(bits) == 1


@pytest.mark.parametrize("basis", CORNER_BASES)
def test_nodes_outside_of_their_boxes_are_refused(basis: str) -> None:
    laboratory = cut_laboratory("3d", basis, "hencky_elastic")
    active = laboratory.active
    (stencil,) = active.stencils
    laboratory.soil.active = replace(
        active, stencils=[replace(stencil, node_key=stencil.node_key + 7)]
    )
    with pytest.raises(ValueError, match="does not fit"):
        assembled(laboratory)
