# SPDX-License-Identifier: BSD-3-Clause
"""Points that are torn off keep their shape in steps that would press or turn them inside out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from small_problems import KINDS, Laboratory

from tilth.arrays import Floats
from tilth.errors import StepFailed


def laboratory(kind: str, anti_locking: str) -> Laboratory:
    found = Laboratory.of(kind, "gimp", "mohr_coulomb", np.random.default_rng(3))
    bodies = found.points.ranges
    found.points.ranges = [replace(body, anti_locking=anti_locking) for body in bodies]
    return found


def folded(found: Laboratory, share: float) -> Floats:
    """A displacement that moves the upper part of the block down by a share of its height."""
    position = found.active.position
    displacement = np.zeros_like(position)
    displacement[:, -1] = -share * position[:, -1]
    return displacement


@pytest.mark.parametrize("anti_locking", ["none", "f_bar"])
@pytest.mark.parametrize("kind", KINDS)
def test_torn_off_points_keep_their_shape(kind: str, anti_locking: str) -> None:
    """The other points are pressed to half their volume; those torn off move with the grid."""
    found = laboratory(kind, anti_locking)
    found.points.deformation_gradient[::3] *= 1.6 ** (1.0 / 3.0)
    found.locate()
    before = found.points.deformation_gradient.copy()
    place = found.points.position.copy()
    number = found.points.point_id.copy()
    found.step(folded(found, 0.6))
    order = found.points.index_of(number)
    after = found.points.deformation_gradient[order]
    np.testing.assert_array_equal(after[::3], before[::3])
    assert (np.linalg.det(after[1::3]) < 0.6 * np.linalg.det(before[1::3])).all()
    moved = found.points.position[order] - place
    np.testing.assert_allclose(moved[:, -1], -0.6 * place[:, -1], rtol=1e-9, atol=1e-12)


def test_points_that_are_not_torn_off_fail_the_step() -> None:
    found = laboratory("plane_strain", "none")
    with pytest.raises(StepFailed, match="inverted"):
        found.soil.update(folded(found, 1.5))
    found.points.deformation_gradient[:] *= 1.6 ** (1.0 / 3.0)
    found.locate()
    found.soil.update(folded(found, 1.5))
    inverses = found.soil.step_inverses(folded(found, 1.5))
    np.testing.assert_array_equal(inverses[0], 1.0)
    np.testing.assert_array_equal(inverses[1], np.tile(np.eye(3), (len(found.points), 1, 1)))
