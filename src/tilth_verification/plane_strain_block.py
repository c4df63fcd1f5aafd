# SPDX-License-Identifier: BSD-3-Clause
"""A block stretched, sheared and rotated: elastic exact, von Mises first order in steps."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tilth.analysis.march import march
from tilth.model import AffineBoundary, HenckyElastic, Model, VonMises
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms import full_deformation_gradient, hencky_cauchy_stress
from tilth_verification.comparison import Comparison, absolute, vanishing
from tilth_verification.homogeneous import (
    final_deformation_gradient,
    stress_error,
    with_each_basis,
)
from tilth_verification.rate_form import linear_path, von_mises_response

PROBLEM = "plane_strain_block"
KINDS = {
    "case.toml": "plane strain",
    "axisymmetric.toml": "axisymmetric",
    "three_dimensional.toml": "3d",
}


def comparisons(long: bool) -> Iterator[Comparison]:
    """Elastic for any F by all kinds and bases; von Mises against the rate equations."""
    for file, kind in KINDS.items():
        model = example(PROBLEM, file)
        gradient = final_deformation_gradient(model)
        soil = model.materials["soil"]
        assert isinstance(soil, HenckyElastic | VonMises)
        exact = hencky_cauchy_stress(gradient, soil)
        for basis, variants in with_each_basis(model):
            error = max(stress_error(march(variant).state.points, exact) for variant in variants)
            quantity = f"stress error, elastic, {kind}, {basis}"
            yield vanishing(quantity, error, 1e-8, "closed form")
    yield from von_mises(example(PROBLEM, "von_mises.toml"), (40, 160) if long else (20, 40))


def von_mises(model: Model, steps: tuple[int, int]) -> Iterator[Comparison]:
    """Error against the integrated rate equations with few and more steps, and its rate."""
    motion, material = model.boundaries[0], model.materials["soil"]
    assert isinstance(motion, AffineBoundary)
    assert isinstance(material, VonMises)
    end = full_deformation_gradient(motion.deformation_gradient, model.analysis.kind)
    exact = von_mises_response(linear_path(end), [1.0], material)
    for basis, variants in with_each_basis(model):
        errors = []
        for count in steps:
            points = march(varied(variants[0], {"schedule.steps": count})).state.points
            errors.append(stress_error(points, exact.cauchy_stress[0]))
        quantity = f"stress error, von Mises, {steps[1]} steps, {basis}"
        yield vanishing(quantity, errors[1], 1.0 / steps[1], "rate equations")
        rate = math.log(errors[0] / errors[1]) / math.log(steps[1] / steps[0])
        quantity = f"order in the step, von Mises, {basis}"
        yield absolute(quantity, rate, 1.0, 0.15, "backward Euler")
