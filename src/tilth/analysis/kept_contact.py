# SPDX-License-Identifier: BSD-3-Clause
"""Forces at the end of a step: for the work of the next one, and of contact for the next stage.

Where a body strikes the soil the points of contact and their shares are others in each step, and
the tractions that they carry are less than those that acted. The motion that the soil brings into
the next step is that under the force that acted: the trapezoidal rule takes this one. So it does
for ghost stabilisation, whose faces and stored displacements are others in each step.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers, require_table
from tilth.grid.keys import find_keys
from tilth.mpm.active_grid import ActiveGrid


class KeptForce:
    """Nodal forces at the end of the last step.

    Args:
        dim: number of directions.

    Attributes:
        key: of the loaded nodes, sorted, shape (m,).
        force: on the nodes there [force], shape (m, dim).
    """

    def __init__(self, dim: int) -> None:
        self.key: Integers = np.zeros(0, dtype=np.int64)
        self.force: Floats = np.zeros((0, dim))

    def at(self, active: ActiveGrid) -> Floats:
        """Returns the force on the nodes of the next step's grid [force], shape (nodes, dim)."""
        number = find_keys(active.key, self.key)
        nodal, there = np.zeros((active.nodes, self.force.shape[1])), number >= 0
        nodal[number[there]] = self.force[there]
        return nodal

    def keep(self, active: ActiveGrid, force: Floats) -> None:
        """Keeps the force at the end of a step, shape (nodes, dim)."""
        loaded = np.flatnonzero(force.any(axis=1))
        self.key, self.force = active.key[loaded].copy(), force[loaded]

    def rows(self) -> tuple[Integers, list[str]]:
        """As `KeyedRows.rows`."""
        return self.key, ["node", "force"]

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {"node": self.key, "force": self.force}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        own = {name: state[name] for name in ("node", "force")}
        require_table(own)
        if own["force"].shape[1:] != self.force.shape[1:]:
            raise ValueError("'force' has another number of directions")
        self.key, self.force = own["node"], own["force"]


class KeptContact(KeptForce):
    """Those of rigid bodies and boundaries in contact on the soil.

    Attributes:
        normal: integral of the normal traction over each surface [force], by its name.
    """

    def __init__(self, dim: int) -> None:
        super().__init__(dim)
        self.normal: dict[str, float] = {}

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """As `KeptForce.state`."""
        return super().state() | {
            "surfaces": np.frombuffer("\n".join(self.normal).encode(), dtype=np.uint8),
            "normal": np.array(list(self.normal.values()), dtype=np.float64),
        }

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """As `KeptForce.restore`."""
        names = state["surfaces"].tobytes().decode().splitlines()
        normal = dict(zip(names, state["normal"].tolist(), strict=True))
        super().restore(state)
        self.normal = normal
