# SPDX-License-Identifier: BSD-3-Clause
"""The stress update for given displacement gradients is that of points in the grid."""

from __future__ import annotations

import numpy as np
import pytest
from small_problems import (
    KINDS,
    MATERIALS,
    affine,
    block_entries,
    dimension,
    initial_state,
    parameters,
    start_strain,
)

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth_verification.closed_forms import full_deformation_gradient

COUNT = 21
SIZES = {"elastic": 1e-3, "plastic": 0.3}


def random_gradients(kind: str, size: float, seed: int = 1) -> Floats:
    """Displacement gradients that a kind of analysis can have."""
    gradients = size * np.random.default_rng(seed).normal(size=(COUNT, 3, 3))
    if kind != "3d":
        gradients[:, :2, 2] = gradients[:, 2, :2] = 0.0
    if kind == "plane_strain":
        gradients[:, 2, 2] = 0.0
    return np.clip(gradients, -0.35, 0.35)


def update(kind: str, material: str, gradients: Floats) -> tuple[Floats, Floats, Floats, int]:
    """Kirchhoff stress, its derivative, elastic deformation and status of points at the start."""
    count = len(gradients)
    given, state = parameters(material), np.tile(initial_state(material), (count, 1))
    before = np.zeros((count, 6))
    before[:, :3] = np.expm1(2.0 * start_strain(material))
    elastic, plastic, after = np.empty((count, 6)), np.empty((count, 2)), np.zeros_like(state)
    kirchhoff, tangent = np.empty((count, 6)), np.empty((count, 6, 9))
    _, status = _core.update_of_gradients(
        kind, material, given, gradients, before, np.zeros((count, 2)), state,
        elastic, plastic, after, kirchhoff, tangent, np.zeros(3),
    )  # fmt: skip
    return kirchhoff, tangent, elastic, status


@pytest.mark.parametrize("size", SIZES.values(), ids=SIZES.keys())
@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("kind", KINDS)
def test_derivative_is_that_of_the_stress(kind: str, material: str, size: float) -> None:
    gradients = random_gradients(kind, size)
    _, tangent, _, status = update(kind, material, gradients)
    assert status == 0
    entries = [(0, 0), (0, 1), (1, 0), (1, 1)]
    entries += {"plane_strain": [], "axisymmetric": [(2, 2)]}.get(
        kind, [(0, 2), (1, 2), (2, 0), (2, 1), (2, 2)]
    )
    step = 1e-6
    for i, j in entries:
        shift = np.zeros((3, 3))
        shift[i, j] = step
        above, below = (update(kind, material, gradients + s * shift)[0] for s in (1.0, -1.0))
        slope = (above - below) / (2 * step)
        error = np.abs(slope - tangent[:, :, 3 * i + j]).max(axis=1)
        assert np.median(error) < 1e-8 * np.abs(tangent).max()
        assert np.sum(error > 1e-6 * np.abs(tangent).max()) <= 1  # a point about to yield


@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("kind", KINDS)
def test_stress_is_that_of_points_in_the_grid(kind: str, material: str) -> None:
    end = np.eye(dimension(kind)) + np.diag([0.1, -0.2, 0.05][: dimension(kind)])
    if kind != "axisymmetric":
        end[0, 1] = 0.15
    model = Model.from_dict(block_entries(kind, "linear", material, boundaries=[affine(end)]))
    simulation = Simulation(model)
    simulation.advance(0.0, 1.0)
    full = full_deformation_gradient(end, kind)
    kirchhoff, _, elastic, status = update(kind, material, (full - np.eye(3))[None])
    assert status == 0
    cauchy = kirchhoff[0] / np.linalg.det(full)
    points = simulation.state.points
    scale = np.abs(cauchy).max()
    np.testing.assert_allclose(points.stress, np.tile(cauchy, (len(points), 1)), atol=1e-9 * scale)
    np.testing.assert_allclose(
        points.elastic_deformation, np.tile(elastic[0], (len(points), 1)), atol=1e-9
    )


def test_an_inverted_point_is_reported() -> None:
    gradients = np.zeros((3, 3, 3))
    gradients[1] = -1.5 * np.eye(3)
    width = np.zeros((3, 0))
    found = _core.update_of_gradients(
        "3d", "hencky_elastic", parameters("hencky_elastic"), gradients, np.zeros((3, 6)),
        np.zeros((3, 2)), width, np.zeros((3, 6)), np.zeros((3, 2)), width.copy(),
        np.zeros((3, 6)), np.zeros((3, 6, 9)), np.zeros(3),
    )  # fmt: skip
    assert found == (1, 1)
