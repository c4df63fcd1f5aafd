# SPDX-License-Identifier: BSD-3-Clause
"""Construction of implicit boundaries from their declarations."""

from __future__ import annotations

import numpy as np

from tilth.boundaries.implicit.boundary import GridProperties, Implicit
from tilth.boundaries.implicit.motion import make_motion
from tilth.geometry.make import make_geometry
from tilth.model import ImplicitBoundary, Model
from tilth.mpm.background import background_grid


def make(declared: ImplicitBoundary, model: Model, kind: type[Implicit] = Implicit) -> Implicit:
    """Returns a declared implicit boundary of a model; kind: its class, without contact.

    Raises:
        BadInput: a file or function of the boundary cannot be used.
    """
    if declared.contact is not None:
        from tilth.boundaries.contact.make import make_contact

        return make_contact(declared, model)
    key = model.boundary_keys()[declared.name]
    geometry = make_geometry(declared, model)
    return kind(
        declared,
        key,
        model.load_curve(declared),
        geometry,
        make_motion(declared, geometry, f"{key}.motion", np.array(model.cell_size)),
        model.delta(declared),
        grid_properties(model),
    )


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
