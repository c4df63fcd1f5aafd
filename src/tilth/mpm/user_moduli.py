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
    row = parameters if parameters.ndim == 1 else parameters[0]
    state, moduli = np.zeros((1, len(law.state_variables))), np.empty((3, 1))
    _core.initial_state("3d", law.core, row, np.zeros((1, 6)), state)
    _core.elastic_moduli("3d", law.core, row, np.zeros((1, 6)), state, *moduli)
    stress, elastic, tangent = np.empty((1, 3)), np.empty((1, 3)), np.empty((1, 3, 3))
    good = np.zeros(1, dtype=bool)
    _core.principal_update(
        law.core, row, PROBE, np.zeros((1, 2)), state.copy(), state, stress, elastic, tangent, good
    )
    volumetric = PROBE.sum()
    bulk, shear = float(moduli[0, 0]), float(moduli[1, 0])
    expected = bulk * volumetric + 2.0 * shear * (PROBE - volumetric / 3.0)
    if good[0] and np.abs(stress - expected).max() > WITHIN * np.abs(expected).max():
        found = ", ".join(f"{x:.6g}" for x in stress[0])
        wanted = ", ".join(f"{x:.6g}" for x in expected[0])
        raise BadInput(
            f"{law.source.title} answers to a strain of 1e-9 with the stress [{found}], but the "
            f"bulk modulus {bulk:.6g} and shear modulus {shear:.6g} of `young_modulus` and "
            f"`poisson_ratio` give [{wanted}]",
            "declare the constants with which the law computes; its elasticity must be linear",
            key=key,
        )
