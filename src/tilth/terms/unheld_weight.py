# SPDX-License-Identifier: BSD-3-Clause
"""The weight of soil that has friction but hardly any cohesion to hold itself at an edge."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.grid.background import Grid
from tilth.model import Model
from tilth.mpm.points import MaterialPoints
from tilth.mpm.shear_strength import shear_strength
from tilth.mpm.soil import Soil
from tilth.terms.filled_cells import means_in_cells

STIFFNESS = 10.0
"""Stiffness with which cells at an edge are held, over their weight per length [-]."""

FULL = 1e-3
"""Empty fraction below which a cell counts as full."""

HELD_BY_COHESION = 0.1
"""Cohesion over the weight of a cell with which soil holds itself at an edge [-]: a vertical face
half a cell high needs 0.066."""


def unheld_weight(points: MaterialPoints, model: Model, acceleration: Floats, grid: Grid) -> Floats:
    """Returns the points' unit weight that cohesion does not hold [stress/length], shape (n,).

    It falls to zero where the cohesion is `HELD_BY_COHESION` times the weight of a cell. It is zero
    in soil without friction or whose law does not say what its strength is.

    Args:
        points: with their parameters.
        model: of their stage.
        acceleration: by body forces, shape (dim,).
        grid: whose cells are meant.
    """
    weight = float(np.linalg.norm(acceleration)) * points.mass / points.volume
    of_cell = weight * grid.sizes_at(points.position).mean(axis=1)
    cohesion, tangent = shear_strength(points, model)
    needed = HELD_BY_COHESION * of_cell
    some = (tangent > 0.0) & (cohesion < needed)
    share = np.divide(cohesion, needed, out=np.ones_like(needed), where=some)
    return np.asarray(weight * (1.0 - share))


def weight_at_edges(soil: Soil, fill: Floats, at_edge: Flags, unit_weight: Floats) -> Floats:
    """Returns the stiffness per length that holds each cell, and its filled fraction.

    Args:
        soil: of the step.
        fill: filled fraction of the cells [-], shape (cells,).
        at_edge: whether they have neighbours without soil, shape (cells,).
        unit_weight: of the points, see `unheld_weight`, shape (n,).

    Returns:
        [stress/length] and [-], shape (2, cells); no stiffness in full cells and inside the soil.
    """
    empty = np.where(at_edge & (fill < 1.0 - FULL), 1.0 - fill, 0.0)
    return np.stack([STIFFNESS * empty * means_in_cells(soil, unit_weight), fill])
