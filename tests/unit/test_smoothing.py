# SPDX-License-Identifier: BSD-3-Clause
"""Smoothing of the volumetric strains of yielding points within their cells (F-bar)."""

import numpy as np
import pytest

from tilth import _core
from tilth.analysis.march import march
from tilth.mpm.f_bar import FORGETTING_STRAIN, Centres
from tilth_verification.cases import example, varied

STRAIN = np.array([1e-3, -2e-3, 4e-3, 5e-3, -1e-3])
VOLUME = np.array([1.0, 2.0, 0.5, 1.5, 1.0])


def two_cells() -> Centres:
    """Three points in one cell, two in another."""
    return Centres(
        kind="plane_strain",
        group_start=np.array([0, 3, 5]),
        count=np.full((2, 3), 2, dtype=np.int32),
        cell_start=np.array([0, 1, 2]),
        cell=np.array([0, 1], dtype=np.int32),
        corner_node=np.zeros(0, dtype=np.int32),
        share_start=np.array([0, 3, 5]),
        share=np.ones(5),
        hoop_share=np.zeros(0),
        node=np.zeros((2, 4), dtype=np.int32),
        gradient=np.zeros((2, 4, 2)),
        hoop_gradient=np.zeros((0, 4)),
        pressure=np.zeros(5),
        jacobian_ratio_before=np.ones(5),
        jacobian_ratio=np.ones(5),
        jacobian=np.ones(5),
        volume_change=np.zeros(2),
        trace=np.zeros((2, 4, 2)),
        hoop_change=np.zeros(0),
    )


def test_no_smoothing_without_plastic_strain():
    assert np.array_equal(two_cells().smoothing(STRAIN, VOLUME, np.zeros(5)), np.zeros(5))


def test_sum_in_each_cell_is_conserved():
    plastic_increment = np.array([0.0, 0.01, 0.2, 0.03, 0.001])
    increment = two_cells().smoothing(STRAIN, VOLUME, plastic_increment)
    assert increment[0] == 0.0
    for cell in (slice(0, 3), slice(3, 5)):
        assert increment[cell] @ VOLUME[cell] == pytest.approx(0.0, abs=1e-18)


def test_differences_decay_with_plastic_strain():
    increment = two_cells().smoothing(STRAIN, VOLUME, np.full(5, FORGETTING_STRAIN))
    for cell in (slice(0, 3), slice(3, 5)):
        mean = np.average(STRAIN[cell], weights=VOLUME[cell])
        left = (STRAIN + increment)[cell] - mean
        np.testing.assert_allclose(left, (STRAIN[cell] - mean) / np.e, atol=1e-17)


@pytest.mark.parametrize("file", ["case.toml", "von_mises.toml"])
def test_stress_is_that_of_the_smoothed_strain(file):
    changes = {
        "grid.cell_size": 6.25,
        "bodies.0.shape.upper": [6.25, 50.0],
        "boundaries.2.at": 6.25,
        "bodies.0.anti_locking": "f_bar",
    }
    model = varied(example("self_weight_column", file), changes)
    points = march(model).state.points
    material = model.materials["soil"]
    bulk = material.young_modulus / (3.0 * (1.0 - 2.0 * material.poisson_ratio))
    pressure = points.stress[:, :3].mean(axis=1) * points.assumed_jacobian
    strain = points.elastic_strain[:, :3].sum(axis=1)
    np.testing.assert_allclose(pressure, bulk * strain, rtol=1e-9)
    # no point is left off the yield surface: the law takes the state as it is
    (body,) = points.ranges
    elastic, plastic, stress = (
        np.empty_like(a) for a in (points.elastic_deformation, points.plastic, points.stress)
    )
    state, good = points.state.copy(), np.empty(len(points), dtype=bool)
    _core.return_to_law(
        "plane_strain", body.law.name, body.parameters, points.elastic_deformation, points.plastic,
        points.state, elastic, plastic, state, stress, good,
    )  # fmt: skip
    assert good.all()
    np.testing.assert_allclose(plastic[:, 0], points.plastic[:, 0], rtol=0, atol=1e-14)
    kirchhoff = points.stress * points.assumed_jacobian[:, None]
    np.testing.assert_allclose(stress, kirchhoff, rtol=1e-9, atol=1e-9 * np.abs(stress).max())
    # plastic flow keeps the volume
    np.testing.assert_allclose(np.log(points.assumed_jacobian), strain, rtol=1e-9)
