# SPDX-License-Identifier: BSD-3-Clause
"""Uniaxial compression without lateral strain, elastic and plastic, against closed forms."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.analysis.march import march
from tilth.model import VonMises
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms import (
    hencky_cauchy_stress,
    hencky_strain,
    proportional_von_mises,
)
from tilth_verification.comparison import Comparison, vanishing
from tilth_verification.homogeneous import (
    final_deformation_gradient,
    stress_error,
    with_each_basis,
)

PROBLEM = "oedometer"
KINDS = {
    "case.toml": "plane strain",
    "axisymmetric.toml": "axisymmetric",
    "three_dimensional.toml": "3d",
}
SOURCE = "closed form"


def comparisons(long: bool) -> Iterator[Comparison]:
    """Stress and plastic strain of all kinds and bases; `long` adds more and smaller steps."""
    for file, kind in KINDS.items():
        model = example(PROBLEM, file)
        material = model.materials["clay"]
        assert isinstance(material, VonMises)
        gradient = final_deformation_gradient(model)
        strain = hencky_strain(gradient)
        kirchhoff, plastic_strain = proportional_von_mises(strain, material)
        exact = kirchhoff * np.exp(-np.trace(strain))
        for basis, variants in with_each_basis(model):
            stress, plastic = [], []
            for variant in variants:
                steps = {"schedule.steps": 200} if long else {}
                points = march(varied(variant, steps)).state.points
                stress.append(stress_error(points, exact))
                plastic.append(float(np.abs(points.plastic[:, 0] / plastic_strain - 1.0).max()))
            of = f"von Mises, {kind}, {basis}"
            yield vanishing(f"stress error, {of}", max(stress), 1e-8, SOURCE)
            yield vanishing(f"plastic strain error, {of}", max(plastic), 1e-8, SOURCE)
        elastic = varied(model, {"materials.clay.yield_stress": 1e3 * material.young_modulus})
        error = stress_error(march(elastic).state.points, hencky_cauchy_stress(gradient, material))
        yield vanishing(f"stress error below yield, {kind}", error, 1e-8, SOURCE)
