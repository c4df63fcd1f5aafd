# SPDX-License-Identifier: BSD-3-Clause
"""Other coordinates and units for the same model: turned, mirrored, shifted and scaled."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import permutations, product

import numpy as np

from tilth.arrays import Floats

AXES = "xyz"


@dataclass(frozen=True)
class Frame:
    """Maps places x to length * (turn x) + shift.

    Attributes:
        turn: matrix with one 1 or -1 in each row and column, (dim, dim): it maps grids onto grids.
        shift: [new unit of length], shape (dim,).
        length, stress, time: how many new units an old one is.
    """

    turn: Floats
    shift: Floats
    length: float = 1.0
    stress: float = 1.0
    time: float = 1.0
    _from: tuple[int, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_from", tuple(int(k) for k in np.abs(self.turn).argmax(axis=1)))

    @property
    def dim(self) -> int:
        return len(self.shift)

    @property
    def handedness(self) -> float:
        """1, or -1 of a mirror image."""
        return float(round(np.linalg.det(self.turn)))

    def unit(self, length: float = 0.0, stress: float = 0.0, time: float = 0.0) -> float:
        """How many new units of a quantity an old one is, by its powers of the basic units."""
        return self.length**length * self.stress**stress * self.time**time

    def source(self, axis: int) -> int:
        """The old axis that the new one was."""
        return self._from[axis]

    def axis(self, old: int) -> tuple[int, float]:
        """The new axis of an old one, and its sign."""
        new = self._from.index(old)
        return new, float(self.turn[new, old])

    def vector(self, old: Floats) -> Floats:
        """Components of vectors, shape (..., dim), without a change of units."""
        old = np.asarray(old, dtype=float)
        return np.stack([self.turn[k, j] * old[..., j] for k, j in enumerate(self._from)], axis=-1)

    def place(self, old: Floats) -> Floats:
        return self.length * self.vector(old) + self.shift

    def tensor(self, old: Floats) -> Floats:
        """Components xx yy zz xy yz xz of symmetric tensors, shape (..., 6)."""
        old, turn = np.asarray(old, dtype=float), np.eye(3)
        turn[: self.dim, : self.dim] = self.turn
        place = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
        full = turn @ old[..., place] @ turn.T
        return full[..., (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)]

    def axial(self, old: Floats) -> Floats:
        """Components of rotations and moments, shape (..., 3)."""
        turn = np.eye(3)
        turn[: self.dim, : self.dim] = self.turn
        return self.handedness * np.asarray(old, dtype=float) @ turn.T


def unchanged(dim: int) -> Frame:
    return Frame(np.eye(dim), np.zeros(dim))


def turns(dim: int) -> list[Floats]:
    """All matrices of turns and mirror images that map the axes onto axes, but for the identity."""
    found = []
    for order in permutations(range(dim)):
        for signs in product((1.0, -1.0), repeat=dim):
            matrix = np.zeros((dim, dim))
            matrix[range(dim), order] = signs
            found.append(matrix)
    return found[1:]
