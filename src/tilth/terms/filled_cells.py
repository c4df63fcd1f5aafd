# SPDX-License-Identifier: BSD-3-Clause
"""The cells with soil: how far they are filled, how stiff and how heavy the soil in them is."""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.grid.keys import places_of_keys
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.soil import Soil

LEAST_ELASTIC_SHARE = 1e-3
"""Least fraction of Young's modulus in plastic flow, so that partly filled cells stay stiff."""
LEAST_MODULUS_OVER_STRESS = 2.0
"""Least ratio of the modulus to the equivalent stress, which limits the motion of loaded nodes."""

LARGEST_EXPANSION = 1.5
"""Volume over the initial one, at most, with which a point fills cells: soil that expands more has
come apart."""


def filled_cells(soil: Soil) -> tuple[Integers, Floats, Floats]:
    """Returns the populated cells: keys, filled fraction [-], harmonic mean of modulus [stress].

    The key is that of the cell's lowest node. The fraction refers to the cell's volume, in
    axisymmetry to that of its ring. The modulus is Young's modulus in elastic soil.
    """
    active, key, points = soil.active, soil.active.cell_keys, soil.points
    volume = np.minimum(points.volume, LARGEST_EXPANSION * points.initial_volume)
    share = np.maximum(points.elastic_share, LEAST_ELASTIC_SHARE)
    least_modulus = LEAST_MODULUS_OVER_STRESS * _equivalent_stress(points.stress)
    filled = sums_in_cells(
        soil, volume, 1.0 / np.maximum(soil.elastic_moduli.young * share, least_modulus)
    )
    size = active.grid.sizes(cell_places(active, key)).prod(axis=1)
    if soil.kind == "axisymmetric":
        size *= 2.0 * np.pi * centre_radii(active, key)
    modulus = np.maximum(filled[:, 0], 1e-300) / np.maximum(filled[:, 1], 1e-300)
    return key, filled[:, 0] / size, modulus


def means_in_cells(soil: Soil, value: Floats) -> Floats:
    """Returns means of a value of the points (n,) over their volume in each cell, (cells,)."""
    filled = sums_in_cells(soil, soil.points.volume, value)
    return np.asarray(filled[:, 1] / np.maximum(filled[:, 0], 1e-300))


def sums_in_cells(soil: Soil, volume: Floats, value: Floats) -> Floats:
    """Returns the sums of volumes of the points, and of these times a value, shape (cells, 2).

    volume: [length^dim; in axisymmetry length^3], value: of the points, shape (n,).
    """
    active, grid = soil.active, soil.active.grid
    filled = np.zeros((len(active.cell_keys), 2))
    for range_, stencil in zip(soil.points.ranges, active.stencils, strict=True):
        s, own = slice(range_.start, range_.stop), active.of_overlay(range_.overlay)
        if range_.has_corners:
            for column, weight in enumerate((volume[s], volume[s] * value[s])):
                _, _, _, _, moment, *_ = _core.share_corner_domains(
                    stencil, soil.points.position[s], soil.points.corner[s], weight, grid,
                    own.cell_keys, False,
                )  # fmt: skip
                filled[own.cells, column] += moment[:, 0]
            continue
        _core.fill_cells(
            stencil, soil.points.position[s], soil.points.half_length[s], volume[s], value[s],
            grid, own.cell_keys, filled[own.cells],
        )  # fmt: skip
    return filled


def _equivalent_stress(stress: Floats) -> Floats:
    """Returns von Mises' equivalent stress of Cauchy stresses (n, 6) [stress], shape (n,)."""
    xx, yy, zz, *shear = stress.T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    square = 0.5 * normal + 3.0 * (shear[0] ** 2 + shear[1] ** 2 + shear[2] ** 2)
    return np.asarray(np.sqrt(square))


def centre_radii(active: ActiveGrid, key: Integers) -> Floats:
    """Returns the cells' centre radii [length], at least half a cell, shape (cells,)."""
    place = cell_places(active, key)
    centre = np.abs(active.grid.position(place.astype(float) + 0.5)[:, 0])
    return np.asarray(np.maximum(centre, 0.5 * active.grid.sizes(place)[:, 0]))


def cell_places(active: ActiveGrid, key: Integers) -> Integers:
    """Returns the lattice indices of cells by their keys, shape (cells, dim)."""
    return places_of_keys(key, active.overlays)[0][:, : active.grid.dim]
