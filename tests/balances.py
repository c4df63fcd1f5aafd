# SPDX-License-Identifier: BSD-3-Clause
"""Residual and matrix of a balance at a displacement."""

from __future__ import annotations

from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.balance import Balance, Residual
from tilth.terms.space import OF_DISPLACEMENT, Space, displacement_of


def space_of(active: ActiveGrid) -> Space:
    """The displacement alone, on a grid."""
    return Space(active, [displacement_of(active)], [])


def residual_at(balance: Balance, u: Floats, of_globals: Floats | None = None) -> Residual:
    """The residual at a nodal displacement (nodes, dim) and global unknowns (m,)."""
    return balance.evaluate(balance.at(u, of_globals))


def blocks_at(balance: Balance, u: Floats, of_globals: Floats | None = None) -> Floats:
    """The node blocks of the displacement at the last evaluation, (entries, dim, dim)."""
    matrix = balance.space.matrix()
    balance.linearise(balance.at(u, of_globals), matrix)
    return matrix[OF_DISPLACEMENT].values.copy()  # the next step has the same memory


def committed(balance: Balance, u: Floats) -> None:
    """Commits the displacement of the last evaluation."""
    x = balance.at(u)
    balance.commit(x, balance.check(x))
