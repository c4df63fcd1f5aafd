# SPDX-License-Identifier: BSD-3-Clause
"""Finite rotations against scipy's, and their derivatives against differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tilth.arrays import Floats
from tilth.boundaries.contact.rotation import (
    SMALL_ANGLE,
    cross_matrix,
    derivative,
    left_jacobian,
    rotated_by,
    rotation_by,
    second_derivative,
    vector_of,
)

ANGLES = [0.0, 1e-9, 1e-4, 0.02, 0.99 * SMALL_ANGLE, 1.01 * SMALL_ANGLE, 0.7, 2.0, 3.1]
AXIS = np.array([0.48, -0.6, 0.64])
ARM = np.random.default_rng(3).normal(size=(5, 3))


def vectors(angle: float) -> list[Floats]:
    return [angle * AXIS, np.array([angle])]


def arms(vector: Floats) -> Floats:
    return ARM if len(vector) == 3 else ARM[:, :2]


@pytest.mark.parametrize("angle", ANGLES)
def test_rotations_are_those_of_scipy(angle: float) -> None:
    space, plane = vectors(angle)
    expected = Rotation.from_rotvec(space).as_matrix()
    np.testing.assert_allclose(rotation_by(space), expected, rtol=0, atol=1e-15)
    about_z = Rotation.from_euler("z", angle).as_matrix()[:2, :2]
    np.testing.assert_allclose(rotation_by(plane), about_z, rtol=0, atol=1e-15)
    for vector in (space, plane):
        # an angle near pi is known from the matrix to less
        np.testing.assert_allclose(vector_of(rotation_by(vector)), vector, rtol=0, atol=1e-14)


@pytest.mark.parametrize("angle", ANGLES)
def test_displacement_of_turned_arms(angle: float) -> None:
    for vector in vectors(angle):
        arm = arms(vector)
        expected = arm @ rotation_by(vector).T - arm
        np.testing.assert_allclose(rotated_by(vector, arm), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("angle", ANGLES)
def test_derivatives(angle: float) -> None:
    step = 1e-5
    for vector in vectors(angle):
        arm, count = arms(vector), len(vector)
        first, second = derivative(vector, arm), second_derivative(vector, arm)
        assert first.shape == (count, *arm.shape)
        assert second.shape == (count, count, *arm.shape)
        for k, unit in enumerate(np.eye(count)):
            ends = vector + step * unit, vector - step * unit
            slope = (rotated_by(ends[0], arm) - rotated_by(ends[1], arm)) / (2.0 * step)
            np.testing.assert_allclose(first[k], slope, rtol=0, atol=1e-9)
            slopes = (derivative(ends[0], arm) - derivative(ends[1], arm)) / (2.0 * step)
            np.testing.assert_allclose(second[:, k], slopes, rtol=0, atol=1e-8)
        np.testing.assert_allclose(second, np.swapaxes(second, 0, 1), rtol=0, atol=1e-8)


@pytest.mark.parametrize("angle", ANGLES)
def test_left_jacobian_is_that_of_the_further_rotation(angle: float) -> None:
    """R(v + dv) = R(J dv) R(v)."""
    vector, step = angle * AXIS, 1e-6
    for k, unit in enumerate(np.eye(3)):
        ends = [Rotation.from_rotvec(vector + way * step * unit) for way in (1.0, -1.0)]
        further = (ends[0] * ends[1].inv()).as_rotvec() / (2.0 * step)
        np.testing.assert_allclose(left_jacobian(vector)[:, k], further, rtol=0, atol=2e-9)
    assert np.array_equal(left_jacobian(np.array([angle])), np.eye(1))


def test_cross_matrix() -> None:
    np.testing.assert_allclose(cross_matrix(AXIS) @ ARM[0], np.cross(AXIS, ARM[0]), atol=1e-15)
