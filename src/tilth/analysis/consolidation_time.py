# SPDX-License-Identifier: BSD-3-Clause
"""How long soil will take to consolidate, by the drainage paths and the stiffness at the start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.geometry.make import make_shape
from tilth.grid.background import Grid
from tilth.model import Model
from tilth.model.fields import AXES
from tilth.model.flow import (
    FlowBoundary,
    ImplicitFlowBoundary,
    PlaneFlowBoundary,
    SurfaceFlowBoundary,
)
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import CONDUCTIVITY, POROSITY
from tilth.surface.protocol import BodySurface

T90 = 0.848
"""Time factor c_v t / H^2 at 90 % of consolidation (Terzaghi and Froehlich 1936)."""

LARGEST_FIRST_STEP = 0.01
"""First step that is recommended, at most, as a share of the time to 90 %."""


@dataclass(frozen=True)
class ConsolidationTime:
    """How long the soil of a stage will take to consolidate.

    Attributes:
        coefficients: least and greatest coefficient of consolidation c_v [length^2/time].
        path: longest way of water to where its pressure is given [length]; None if it is given
            nowhere.
        time: until 90 % there [time]; None as well.
        first_step: that is recommended for the first step [time]; None as well.
    """

    coefficients: tuple[float, float]
    path: float | None = None
    time: float | None = None
    first_step: float | None = None


def consolidation_time(
    model: Model, points: MaterialPoints, surfaces: Mapping[str, BodySurface], grid: Grid
) -> ConsolidationTime | None:
    """Returns an estimate for a stage; None if no water flows in it.

    c_v = kappa / (1/M + n/K_w) with the constrained modulus of elasticity M, for one direction. The
    slowest point counts: its distance d from where the pressure is given takes 0.848 d^2 / c_v. A
    first step of l^2 / (6 c_v) (Vermeer and Verruijt 1981) is that in which the pressure begins to
    fall in the first cell of size l: a shorter one shows no more.

    Args:
        model: of the stage.
        points: its points where they were declared.
        surfaces: tracked surfaces by the names of their bodies.
        grid: the background grid.
    """
    wet = np.flatnonzero(points.water[:, CONDUCTIVITY] > 0.0) if model.flow is not None else ()
    if model.flow is None or not model.water_flows or len(wet) == 0:
        return None
    stored = 1.0 / points.elastic_moduli().constrained[wet]
    stored += points.water[wet, POROSITY] / (model.flow.bulk_modulus or np.inf)
    coefficient = points.water[wet, CONDUCTIVITY] / stored
    ends = float(coefficient.min()), float(coefficient.max())
    position = points.position[wet]
    ways = [
        _way(each, model, position, surfaces)
        for each in model.flow.boundaries
        if each.condition != "flux"
    ]
    if not ways:
        return ConsolidationTime(ends)
    way = np.min(ways, axis=0)
    times = T90 * way**2 / coefficient
    last = int(times.argmax())
    size = float(grid.sizes_at(position[last : last + 1]).max())
    first = min(size**2 / (6.0 * coefficient[last]), LARGEST_FIRST_STEP * times[last])
    return ConsolidationTime(ends, float(way[last]), float(times[last]), float(first))


def _way(
    drain: FlowBoundary, model: Model, position: Floats, surfaces: Mapping[str, BodySurface]
) -> Floats:
    """Returns how far positions are from a flow boundary [length], shape (n,).

    A stretch of a surface counts as the straight line between its ends, a part of one in space as
    the whole surface.
    """
    if isinstance(drain, PlaneFlowBoundary):
        away = np.zeros_like(position)
        away[:, AXES.index(drain.axis)] = position[:, AXES.index(drain.axis)] - drain.at
        for name, (low, high) in (drain.range or {}).items():
            along = position[:, AXES.index(name)]
            away[:, AXES.index(name)] = np.maximum(np.maximum(low - along, along - high), 0.0)
        return np.asarray(np.linalg.norm(away, axis=1))
    if isinstance(drain, ImplicitFlowBoundary):
        key = f"{model.flow_boundary_keys()[drain.name]}.geometry"
        return np.abs(make_shape(drain.geometry, model, key).distance(position))
    assert isinstance(drain, SurfaceFlowBoundary)
    if drain.start is not None and drain.end is not None:
        start, line = np.array(drain.start), np.array(drain.end) - np.array(drain.start)
        length = max(float(line @ line), 1e-300)
        share = np.clip((position - start) @ line / length, 0.0, 1.0)
        return np.asarray(np.linalg.norm(position - start - share[:, None] * line, axis=1))
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(surfaces[drain.body].shape().position).query(position)[0])
