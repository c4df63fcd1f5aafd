# SPDX-License-Identifier: BSD-3-Clause
"""Check of the elastic moduli that are declared of a law of the user."""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model.laws import Law

PROBE = np.array([[-1.00e-9, -1.02e-9, -0.98e-9]])
"""Principal strain for which a law answers elastically [-]: compression, a little shear."""

WITHIN = 1e-5
"""Difference from the elastic stress, at most, over the stress."""


def require_declared_moduli(law: Law, parameters: Floats, key: str) -> None:
    """Checks that a law of the user answers to a small strain with Hencky's elastic stress.

    Springs, starting stresses and the elastic strain of a UMAT follow from the declared constants.
    A law that finds no stress for this strain, and one with its own elasticity, is not checked.

    Args:
        law: any law.
        parameters: of the law, shape (m,) or (n, m).
        key: of the material in the case file.

    Raises:
        BadInput: the stress is another one.
    """
    if law.source is None or not law.source.hencky:
        return
    n = 1 if parameters.ndim == 1 else len(parameters)
    state, (bulk, shear, young) = np.zeros((n, len(law.state_variables))), np.empty((3, n))
    _core.initial_state("3d", law.core, parameters, np.zeros((n, 6)), state)
    _core.elastic_moduli("3d", law.core, parameters, np.zeros((n, 6)), state, bulk, shear, young)
    stress, elastic, tangent = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    good = np.zeros(n, dtype=bool)
    _core.principal_update(
        law.core, parameters, np.repeat(PROBE, n, axis=0), np.zeros((n, 2)), state.copy(), state,
        stress, elastic, tangent, good,
    )  # fmt: skip
    volumetric = PROBE.sum()
    expected = bulk[:, None] * volumetric + 2.0 * shear[:, None] * (PROBE - volumetric / 3.0)
    error = np.where(good, np.abs(stress - expected).max(axis=1), 0.0)
    wrong = np.flatnonzero(error > WITHIN * np.abs(expected).max(axis=1))
    if len(wrong):
        found, wanted = (
            ", ".join(f"{x:.6g}" for x in each[wrong[0]]) for each in (stress, expected)
        )
        raise BadInput(
            f"{law.source.title} answers to a strain of 1e-9 with the stress [{found}], but the "
            f"bulk modulus {bulk[wrong[0]]:.6g} and shear modulus {shear[wrong[0]]:.6g} of "
            "`young_modulus` and "
            f"`poisson_ratio` give [{wanted}]",
            "declare the constants with which the law computes; its elasticity must be linear",
            key=key,
        )
