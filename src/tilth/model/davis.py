# SPDX-License-Identifier: BSD-3-Clause
"""Davis' associated equivalents (docs/theory/strength_reduction.md#davis-associated-equivalents).

Davis 1968; the forms A, B and C are those of Tschuchnigg, Schweiger and Sloan 2015.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from tilth.arrays import Floats

DavisForm = Literal["A", "B", "C"]
"""Angles of which the share of the strength is: "A" those declared, "B" both angles reduced, "C"
the reduced friction angle and the declared dilation angle."""


def davis_share(
    phi: float | Floats, psi: float | Floats, factor: float, form: DavisForm | None
) -> float | Floats:
    """Returns Davis' share of the strength [-], cos(psi) cos(phi) / (1 - sin(psi) sin(phi)).

    It is exactly 1 where the angles are the same, and without a form; a dilation angle above the
    friction angle counts as that.

    Args:
        phi, psi: declared angles of friction and dilation [radians].
        factor: by which the strength is divided [-].
        form: of the equivalent; None for the soil itself.
    """
    if form is None:
        return 1.0
    if form != "A":
        phi = np.arctan(np.tan(phi) / factor)
    if form == "B":
        psi = np.arctan(np.tan(psi) / factor)
    psi = np.minimum(psi, phi)
    # 1 - sin(psi) sin(phi) = cos(psi) cos(phi) + 1 - cos(phi - psi)
    apart = (1.0 - np.cos(phi - psi)) / (np.cos(psi) * np.cos(phi))
    share: float | Floats = 1.0 / (1.0 + apart)
    return share
