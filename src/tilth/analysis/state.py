# SPDX-License-Identifier: BSD-3-Clause
"""The state in a checkpoint besides the material points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

Arrays = Mapping[str, npt.NDArray[Any]]


class MissingState(Exception):
    """An array that a checkpoint lacks; `str` gives its name."""


class Stateful(Protocol):
    """An object with variables that persist from step to step."""

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns what a later step reads, by name; the names are the same at any time."""
        ...

    def restore(self, state: Arrays) -> None:
        """Goes back to what `state` returned."""
        ...


def state_of(owners: Mapping[str, Stateful]) -> dict[str, npt.NDArray[Any]]:
    """Returns the states of all owners, each array by `owner.name`."""
    return {
        f"{owner}.{name}": np.asarray(array)
        for owner, each in owners.items()
        for name, array in each.state().items()
    }


def restore_all(owners: Mapping[str, Stateful], arrays: Arrays) -> None:
    """Gives each owner back what `state_of` returned.

    Raises:
        MissingState: an array of an owner is missing.
    """
    for owner, each in owners.items():
        found = {}
        for name in each.state():
            key = f"{owner}.{name}"
            if key not in arrays:
                raise MissingState(key)
            found[name] = arrays[key]
        each.restore(found)
