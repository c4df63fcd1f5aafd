# SPDX-License-Identifier: BSD-3-Clause
"""Motion of a face that narrows as the soil under it moves inwards."""

import numpy as np

SETTLEMENT = 0.3
"""At factor 1 [m]."""

SLIP = 0.059
"""Inward displacement of the soil at the footing's edge at that settlement [m], from this run."""


def face(place, factor):
    """Displacement [m] of the footing's face, half-width 1 m, at places (n, 2)."""
    return factor * np.column_stack([-SLIP * place[:, 0], np.full(len(place), -SETTLEMENT)])
