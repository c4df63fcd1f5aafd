# SPDX-License-Identifier: BSD-3-Clause
"""A slope with random strength: statistics of 200 realisations against the declared ones."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.analysis.march import march
from tilth.arrays import Floats
from tilth.model import Random
from tilth.model.variation import variations
from tilth.mpm.initial_points import initial_points
from tilth.variation.random_field import random_values
from tilth_verification.cases import example
from tilth_verification.comparison import Comparison, absolute, relative, vanishing

PROBLEM = "random_field_slope"
REALISATIONS = 200
SOURCE = "declared statistics"


def comparisons(long: bool) -> Iterator[Comparison]:
    """Mean, variation and correlation over 200 seeds, and the points' strength in the analysis.

    The tolerances are about four standard errors of these many correlated values.
    """
    model = example(PROBLEM)
    declared = variations(model.materials["clay"])["undrained_shear_strength"]
    assert isinstance(declared, Random)
    field = declared.random
    lengths = np.array(field.correlation_lengths)
    columns, rows = 5, 7
    place = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1) * lengths
    strength = np.array(
        [
            random_values(field.model_copy(update={"seed": seed}), place.reshape(-1, 2), "random")
            for seed in range(REALISATIONS)
        ]
    ).reshape(REALISATIONS, rows, columns)
    of = f"of {REALISATIONS} realisations at {rows * columns} places"
    mean, spread = float(strength.mean()), float(strength.std() / strength.mean())
    yield relative(f"mean {of}", mean, field.mean, 0.02, SOURCE, model.units.stress)
    variation = field.coefficient_of_variation
    yield relative(f"coefficient of variation {of}", spread, variation, 0.06, SOURCE)
    logarithm = np.log(strength)
    one_length = math.exp(-1.0)
    for axis, before, after in (
        ("x", logarithm[:, :, :-1], logarithm[:, :, 1:]),
        ("y", logarithm[:, :-1], logarithm[:, 1:]),
    ):
        quantity = f"correlation of the logarithm one length apart along {axis}"
        yield absolute(quantity, _correlation(before, after), one_length, 0.06, SOURCE)
    yield from _in_the_analysis()


def _correlation(one: Floats, other: Floats) -> float:
    return float(np.corrcoef(one.ravel(), other.ravel())[0, 1])


def _in_the_analysis() -> Iterator[Comparison]:
    """Nowhere does the stress of the slope under its weight exceed the strength at that point."""
    model = example(PROBLEM)
    points = march(model).state.points
    strength = initial_points(model).varying["undrained_shear_strength"][points.point_id]
    deviator = points.stress.copy()
    deviator[:, :3] -= deviator[:, :3].mean(axis=1, keepdims=True)
    square = (deviator[:, :3] ** 2).sum(axis=1) + 2.0 * (deviator[:, 3:] ** 2).sum(axis=1)
    jacobian = points.assumed_jacobian  # the strength is that of the Kirchhoff stress
    excess = jacobian * np.sqrt(0.5 * square) / strength - 1.0
    quantity = "greatest excess of the shear stress over the strength of the point"
    yield vanishing(quantity, max(float(excess.max()), 0.0), 1e-9, "yield condition")
