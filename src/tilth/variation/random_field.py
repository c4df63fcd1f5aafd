# SPDX-License-Identifier: BSD-3-Clause
"""Random fields, by GSTools (Müller et al. 2022, Geosci. Model Dev. 15, 3161-3182)."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.model.fields import per_direction
from tilth.model.variation import RandomField
from tilth.variation.level import elevation


def random_values(declared: RandomField, position: Floats, key: str) -> Floats:
    """Returns the values of one realisation at positions (n, dim), shape (n,).

    A value depends on the seed and its place only, not on the other positions. With the mean m, the
    coefficient of variation V and a standard normal field g a normal field is m (1 + V g), a
    lognormal one m exp(s g - s^2 / 2) with s^2 = ln(1 + V^2).

    Raises:
        BadInput: a position beside the surface from which the depth is measured.
    """
    normal = standard_normal(declared, position)
    mean = np.full(len(position), declared.mean)
    if declared.gradient is not None and declared.surface is not None:
        surface = elevation(declared.surface, position, f"{key}.surface")
        mean = mean + declared.gradient * (surface - position[:, -1])
    variation = declared.coefficient_of_variation
    if declared.distribution == "normal":
        return np.asarray(mean * (1.0 + variation * normal))
    variance = float(np.log1p(variation**2))
    return np.asarray(mean * np.exp(np.sqrt(variance) * normal - 0.5 * variance))


def standard_normal(declared: RandomField, position: Floats) -> Floats:
    """Returns the field with mean 0 and variance 1 at positions (n, dim), shape (n,).

    By the randomisation method: a sum of 1,000 waves with random amplitudes and wave vectors.
    """
    import gstools

    dim = position.shape[1]
    models = {"exponential": gstools.Exponential, "gaussian": gstools.Gaussian}
    lengths = list(per_direction(declared.correlation_lengths, dim))
    model = models[declared.model](dim=dim, var=1.0, len_scale=lengths)
    field = gstools.SRF(model, mean=0.0, seed=declared.seed)
    return np.asarray(field(position.T, store=False), dtype=np.float64)
