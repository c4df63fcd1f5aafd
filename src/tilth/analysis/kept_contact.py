# SPDX-License-Identifier: BSD-3-Clause
"""The force of contact at the end of a step: for the work of the next one, and for the next stage.

Where a body strikes the soil the points of contact and their shares are others in each step, and
the tractions that they carry are less than those that acted. The motion that the soil brings into
the next step is that under the force that acted: the trapezoidal rule takes this one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers, require_table
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.keys import find_keys


class KeptContact:
    """Nodal forces of rigid bodies and boundaries in contact at the end of the last step.

    Args:
        dim: number of directions.

    Attributes:
        key: of the loaded nodes, sorted, shape (m,).
        force: on the soil there [force], shape (m, dim).
        normal: integral of the normal traction over each surface [force], by its name.
    """

    def __init__(self, dim: int) -> None:
        self.key: Integers = np.zeros(0, dtype=np.int64)
        self.force: Floats = np.zeros((0, dim))
        self.normal: dict[str, float] = {}

    def at(self, active: ActiveGrid) -> Floats:
        """Returns the force on the nodes of the next step's grid [force], shape (nodes, dim)."""
        number = find_keys(active.key, self.key)
        nodal, there = np.zeros((active.nodes, self.force.shape[1])), number >= 0
        nodal[number[there]] = self.force[there]
        return nodal

    def keep(self, active: ActiveGrid, force: Floats, normal: dict[str, float]) -> None:
        """Keeps the force at the end of a step, shape (nodes, dim), and `normal`."""
        loaded = np.flatnonzero(force.any(axis=1))
        self.key, self.force = active.key[loaded].copy(), force[loaded]
        self.normal = normal

    def rows(self) -> tuple[Integers, list[str]]:
        """As `KeyedRows.rows`."""
        return self.key, ["node", "force"]

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        surfaces: dict[str, npt.NDArray[Any]] = {
            "surfaces": np.frombuffer("\n".join(self.normal).encode(), dtype=np.uint8),
            "normal": np.array(list(self.normal.values()), dtype=np.float64),
        }
        return {"node": self.key, "force": self.force, **surfaces}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        own = {name: state[name] for name in self.state()}
        require_table({name: own[name] for name in ("node", "force")})
        if own["force"].shape[1:] != self.force.shape[1:]:
            raise ValueError("'force' has another number of directions")
        self.key, self.force = own["node"], own["force"]
        names = own["surfaces"].tobytes().decode().splitlines()
        self.normal = dict(zip(names, own["normal"].tolist(), strict=True))
