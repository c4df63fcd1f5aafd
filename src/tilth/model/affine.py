# SPDX-License-Identifier: BSD-3-Clause
"""Check that an affine motion is possible: det F > 0 on its path, and a real logarithm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

_ROUND_OFF = 1e-12

GREATEST_STRETCH = 1e6
"""Greatest principal stretch; the least one is its inverse."""


def affine_problem(
    deformation_gradient: Sequence[Sequence[float]], path: str, least: float, greatest: float
) -> str:
    """Returns why the motion is impossible for factors from `least` to `greatest`, or "".

    Linear path: det(I + f (F - I)) vanishes at f = -1 / mu for a real eigenvalue mu of F - I.
    Exponential path: F has a real principal logarithm unless an eigenvalue is real and negative.
    """
    rows = [len(row) for row in deformation_gradient]
    if rows != [len(rows)] * len(rows):
        return "must be a square matrix"
    if len(rows) not in (2, 3):
        return f"is a {len(rows)} x {len(rows)} matrix, but must be 2 x 2 or 3 x 3"
    matrix = np.array(deformation_gradient, dtype=float)
    if np.linalg.det(matrix) <= 0.0:
        return f"its determinant is {np.linalg.det(matrix):g}, but must be greater than 0"
    stretches = np.linalg.svd(matrix, compute_uv=False)
    if stretches[0] > GREATEST_STRETCH or stretches[-1] < 1.0 / GREATEST_STRETCH:
        return (
            f"its principal stretches are {stretches[-1]:g} to {stretches[0]:g}, but must lie "
            f"between {1.0 / GREATEST_STRETCH:g} and {GREATEST_STRETCH:g}"
        )
    if path == "exponential":
        eigenvalues = np.linalg.eigvals(matrix)
        if any(abs(e.imag) <= _ROUND_OFF * abs(e) and e.real < 0.0 for e in eigenvalues):
            return (
                "has no principal logarithm, which the exponential path needs: it contains a "
                "rotation by 180 degrees or a reflection of two axes"
            )
        return ""
    for mu in np.linalg.eigvals(matrix - np.eye(len(matrix))):
        if abs(mu.imag) <= _ROUND_OFF * abs(mu) and mu.real != 0.0:
            singular = -1.0 / float(mu.real)
            if least <= singular <= greatest:
                return f"det F vanishes on the linear path, at factor {singular:g}"
    return ""
