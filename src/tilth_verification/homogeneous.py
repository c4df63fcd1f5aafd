# SPDX-License-Identifier: BSD-3-Clause
"""Common parts of the problems of homogeneous deformation: bases, and the error of the stress."""

from __future__ import annotations

from collections.abc import Iterator
from typing import get_args

import numpy as np

from tilth.arrays import Floats
from tilth.model import AffineBoundary, Body, Model
from tilth.model.bodies import DomainUpdate
from tilth.mpm.points import MaterialPoints
from tilth_verification.cases import varied
from tilth_verification.closed_forms import components, full_deformation_gradient


def with_each_basis(model: Model) -> Iterator[tuple[str, list[Model]]]:
    """Yields each basis with the models of its domain rules (one without, where it has none)."""
    for basis in get_args(Body.model_fields["basis"].annotation):
        rules = get_args(DomainUpdate) if basis == "gimp" else (None,)
        yield (
            basis,
            [
                varied(model, {"bodies.0.basis": basis, "bodies.0.domain_update": rule})
                for rule in rules
            ],
        )


def final_deformation_gradient(model: Model) -> Floats:
    """Returns the 3x3 deformation gradient at the end that a model's affine motion prescribes."""
    motion = model.boundaries[0]
    assert isinstance(motion, AffineBoundary)
    return full_deformation_gradient(motion.deformation_gradient, model.analysis.kind)


def stress_error(points: MaterialPoints, exact: Floats) -> float:
    """Returns the largest error of any stress component over the largest exact component [-].

    Args:
        exact: Cauchy stress, shape (3, 3), of all points.
    """
    expected = components(exact)
    return float(np.abs(points.stress - expected).max() / np.abs(expected).max())
