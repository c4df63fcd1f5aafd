# SPDX-License-Identifier: BSD-3-Clause
"""The predictor: where a load step's iteration begins, if the soil moves on as it did."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.mpm.grid import ActiveGrid, find_keys
from tilth.mpm.soil import Soil
from tilth.terms.weak_springs import well_supported

LARGEST_MOTION = 0.25
"""Motion in the last load step, in cells, up to which the nodes still stand at the same soil."""


class Predictor:
    """Remembers the last load step's displacement.

    While the grid stands still and the soil moves by no more than `LARGEST_MOTION` in a step, each
    node is given its own displacement of the last step. Otherwise all nodes are given that of the
    material points around them: with their own, a slender body that moves on through the grid would
    be torn. So are new nodes, and nodes at the edge of the soil: they are badly supported, move at
    random within Newton's tolerance, and this motion would grow if each step began with that of the
    last.

    Attributes:
        size: of the last load step [time]; 0 before the first one.
        origin: of its grid [length], shape (dim,).
        key: of its nodes, shape (nodes,).
        displacement: of its nodes [length], shape (nodes, dim).
    """

    def __init__(self, dim: int) -> None:
        self.size = 0.0
        self.origin: Floats = np.zeros(dim)
        self.key: Integers = np.zeros(0, dtype=np.int64)
        self.displacement: Floats = np.zeros((0, dim))

    def guess(self, soil: Soil, size: float) -> Floats | None:
        """Returns the nodal displacement of a step of this size [time], shape (nodes, dim).

        None before the first step.
        """
        if self.size == 0.0:
            return None
        active = soil.active
        guess = _from_points(soil)
        cells = np.abs(self.displacement).max(axis=0) / active.grid.cell_size
        if np.array_equal(self.origin, active.grid.origin) and cells.max() <= LARGEST_MOTION:
            number = find_keys(self.key, active.key)
            kept = (number >= 0) & well_supported(soil)
            guess[kept] = self.displacement[number[kept]]
        return np.asarray(size / self.size * guess)

    def commit(self, active: ActiveGrid, displacement: Floats, size: float) -> None:
        """Remembers a converged step."""
        self.size, self.origin = size, active.grid.origin
        self.key, self.displacement = active.key.copy(), displacement

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns what a checkpoint must hold."""
        return {
            "size": np.array(self.size),
            "origin": self.origin,
            "key": self.key,
            "displacement": self.displacement,
        }

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Goes on from the state of a checkpoint."""
        self.size, self.origin = float(state["size"]), state["origin"]
        self.key, self.displacement = state["key"], state["displacement"]


def _from_points(soil: Soil) -> Floats:
    """Each node's mean of the points' last displacement fields, by volume."""
    points, active, dim = soil.points, soil.active, soil.active.grid.dim
    volume = points.volume
    total = np.zeros((active.nodes, 1 + dim))
    for body, stencil in zip(points.bodies, active.stencils, strict=True):
        s = slice(body.start, body.stop)
        _core.add_predictions(
            stencil, active.position, points.position[s], points.last_displacement[s],
            points.last_gradient[s], volume[s], total,
        )  # fmt: skip
    return np.asarray(total[:, 1:] / np.maximum(total[:, :1], 1e-300))  # domains may only touch
