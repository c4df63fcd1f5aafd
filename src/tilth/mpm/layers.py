# SPDX-License-Identifier: BSD-3-Clause
"""Layers of a body: which of its points belong to each (docs/decisions/0024-layers.md)."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies import BodyPoints
from tilth.errors import BadInput
from tilth.model import Body
from tilth.model.problems import unknown_name
from tilth.variation.level import elevation
from tilth.variation.tables import place_text

ROUND_OFF = 1e-9
"""A horizon may be above the one over it by this share of a point's size."""


def by_layer(body: Body, points: BodyPoints, key: str) -> tuple[BodyPoints, list[int]]:
    """Returns the points sorted by layer, and the number of points of each layer.

    The order within a layer is kept. A point on a horizon belongs to the layer above it. A body
    without layers is one layer.

    key: of the body in the case file, for messages.

    Raises:
        BadInput: a layer without points, horizons that cross each other, or a mesh that has not
            each element in a physical group of a layer.
    """
    if not body.layers:
        return points, [len(points.position)]
    grouped = body.layers[0].group is not None
    layer = _by_group(body, points, key) if grouped else _by_horizon(body, points, key)
    count = np.bincount(layer, minlength=len(body.layers))
    if not count.all():
        empty = int(np.flatnonzero(count == 0)[0])
        raise BadInput(
            f"no material point is in this layer of {body.name!r}",
            "leave it out, or use more points: a layer needs a point between its horizons",
            key=f"{key}.layers[{empty}]",
        )
    return points.ordered(np.argsort(layer, kind="stable")), count.tolist()


def _by_horizon(body: Body, points: BodyPoints, key: str) -> Integers:
    """Returns the layer of each point by the horizons above it, shape (n,)."""
    position = points.position
    layer = np.zeros(len(position), dtype=np.int64)
    above: Floats = np.full(len(position), np.inf)
    for i, declared in enumerate(body.layers[:-1]):
        assert declared.bottom is not None, "checked by the model"
        where = f"{key}.layers[{i}].bottom"
        horizon = elevation(declared.bottom, position, where)
        crossed = np.flatnonzero(horizon > above + ROUND_OFF * points.half_length[:, -1])
        if len(crossed):
            first = crossed[0]
            raise BadInput(
                f"lies at {horizon[first]:.6g}, above the horizon over it at {above[first]:.6g}, "
                f"at the material point at {place_text(position[first])}",
                "list the layers from the top down; where one ends, give it the elevation of the "
                "horizon over it",
                key=where,
            )
        layer += position[:, -1] < horizon
        above = horizon
    return layer


def _by_group(body: Body, points: BodyPoints, key: str) -> Integers:
    """Returns the layer of each point by the physical group of its element, shape (n,)."""
    assert points.group is not None, "the model allows groups for a mesh only"
    names = [layer.group or "" for layer in body.layers]
    found = sorted({str(name) for name in np.unique(points.group)} - {""})
    for i, name in enumerate(names):
        if name not in found:
            words = unknown_name("physical group", name, found)
            raise BadInput(*words, key=f"{key}.layers[{i}].group", value=name)
    layer = np.full(len(points.group), -1, dtype=np.int64)
    for i, name in enumerate(names):
        layer[points.group == name] = i
    if (layer < 0).any():
        first = int((layer < 0).argmax())
        group = str(points.group[first])
        which = f"in the physical group {group!r}, which no layer names" if group else "in no group"
        raise BadInput(
            f"the element of the mesh at {place_text(points.position[first])} is {which}",
            "give every group of the mesh a layer, and every element a group",
            key=f"{key}.layers",
        )
    return layer
