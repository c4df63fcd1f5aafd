# SPDX-License-Identifier: BSD-3-Clause
"""The grid on which surfaces act."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.grid.background import Grid, background_grid
from tilth.model import ImplicitBoundary, Model


@dataclass(frozen=True)
class GridProperties:
    """Properties of the grid on which an implicit boundary acts.

    Attributes:
        at_start: its lines at time 0.
        axisymmetric: whether x is the radius.
        grid_moves: whether the grid moves with a boundary.
    """

    at_start: Grid
    axisymmetric: bool
    grid_moves: bool


def grid_properties(model: Model) -> GridProperties:
    """Returns the grid on which the boundaries of a model act."""
    return GridProperties(
        at_start=background_grid(model),
        axisymmetric=model.analysis.kind == "axisymmetric",
        grid_moves=_grid_moves(model),
    )


def _grid_moves(model: Model) -> bool:
    """Returns whether the grid can move: its boundary does, along an axis of `follow`."""
    follow = model.grid.follow
    if follow is None:
        return False
    leader = next(each for each in model.boundaries if each.name == follow.boundary)
    assert isinstance(leader, ImplicitBoundary)
    turns_or_grows = (leader.rotation, leader.radius_change, leader.volume_loss, leader.motion)
    if model.stage.boundary_keys is not None or any(each is not None for each in turns_or_grows):
        return True  # other stages may move it
    return any((leader.displacement or {}).get(axis, 0.0) != 0.0 for axis in follow.axes)
