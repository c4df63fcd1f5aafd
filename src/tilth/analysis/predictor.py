# SPDX-License-Identifier: BSD-3-Clause
"""The predictor: a first guess of a load step's displacement from that of the last step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Flags, Floats, Integers, require_table
from tilth.grid.keys import find_keys, lattice_keys, places_of_keys
from tilth.model import Model
from tilth.model.load_curve import LoadCurve
from tilth.model.staging import moves
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.soil import Soil
from tilth.terms.weak_springs import covered_nodes

LARGEST_MOTION = 0.25
"""Largest motion in the last load step, in cells, for which nodes keep their own displacement."""

REST = 10
"""Steps without a guess from one on in which Newton's iteration failed with it, where soil is in
contact: yielding soil that slides along a body fails again."""


ROUND_OFF = 1e-9
"""Of increments of factors, relative to the factors."""


class Predictor:
    """Extrapolates the displacement of the last load step.

    It is scaled by the increment of the factors of loads and motions over that in the last step;
    where these differ from curve to curve, by the sizes of the steps in time.

    If the grid is fixed and the soil moved by no more than `LARGEST_MOTION` in the last step, the
    guess of a node is its own displacement in that step. Otherwise it is the mean displacement of
    the material points around the node, because the nodes' own displacements would tear a slender
    body that moves through the grid. The mean is also used for new nodes and for hardly covered
    nodes at the edge of the soil: their displacements are random within Newton's tolerance, and
    this error would grow from step to step.

    Nodes that an implicit boundary holds never take the mean, for its penalty would make a large
    force of the slip. They receive the displacement of the soil that is now at them, which was
    upstream in the last step: the boundary moves on with it.

    Args:
        dim: number of directions.
        curves: load curves of all loads and motions.

    Attributes:
        size: of the last load step [time]; 0 before the first one.
        origin: of its grid [length], shape (dim,).
        key: of its nodes, shape (nodes,).
        displacement: of its nodes [length], shape (nodes, dim).
        rest: number of further steps without a guess.
    """

    def __init__(self, dim: int, curves: Sequence[LoadCurve] = ()) -> None:
        self._curves = curves
        self.size = 0.0
        self.origin: Floats = np.zeros(dim)
        self.key: Integers = np.zeros(0, dtype=np.int64)
        self.displacement: Floats = np.zeros((0, dim))
        self.rest = 0
        self._axes = np.eye(dim, dtype=np.int64)

    def guess(
        self, soil: Soil, before: float, after: float, held: Flags | None = None
    ) -> Floats | None:
        """Returns the nodal displacement of the step from `before` to `after` [length].

        Shape (nodes, dim); None before the first step, and while the predictor rests.

        held: nodes that an implicit boundary holds, shape (nodes,); none if not given.
        """
        if self.size == 0.0 or self.rest > 0:
            return None
        active = soil.active
        guess = _from_points(soil)
        same_grid = np.array_equal(self.origin, active.grid.origin)
        if same_grid and self._motion_in_cells(active) <= LARGEST_MOTION:
            number = find_keys(self.key, active.key)
            kept = (number >= 0) & covered_nodes(soil)
            guess[kept] = self.displacement[number[kept]]
            if held is not None:
                held = held & (number >= 0)
                guess[held] = self._upstream(number[held], active)
        return np.asarray(self._growth(before, after) * guess)

    def _growth(self, before: float, after: float) -> float:
        """Returns the increment of loads and motions over that in the last step [-]."""
        in_time = (after - before) / self.size
        ratios = []
        for curve in self._curves:
            last, now, new = (curve.factor(t) for t in (before - self.size, before, after))
            negligible = ROUND_OFF * max(abs(last), abs(now), abs(new))
            if abs(now - last) > negligible:
                ratios.append((new - now) / (now - last))
            elif abs(new - now) > negligible:
                return in_time
        if not ratios or max(ratios) - min(ratios) > ROUND_OFF * max(map(abs, ratios)):
            return in_time
        return in_time if abs(ratios[0] - in_time) <= ROUND_OFF * in_time else max(ratios[0], 0.0)

    def _motion_in_cells(self, active: ActiveGrid) -> float:
        """Returns the largest motion of a node in the last step [cells]."""
        grid, comm = active.grid, active.comm
        if not grid.graded:
            largest = np.abs(self.displacement).max(axis=0, initial=0.0)
            return comm.max(float((largest / grid.cell_size).max()))
        lattice, _ = places_of_keys(self.key, active.overlays)
        in_cells = np.abs(self.displacement / grid.sizes(lattice[:, : grid.dim]))
        return comm.max(float(in_cells.max(initial=0.0)))

    def _upstream(self, node: Integers, active: ActiveGrid) -> Floats:
        """Returns the last displacement u at x - u for nodes of the last step at x, (n, dim).

        u is linear between a node and its neighbour upstream; where there is none, the slope is
        that on the other side.
        """
        own, key = self.displacement[node], self.key[node]
        found = own.copy()
        lattice, grid = places_of_keys(key, active.overlays)[0][:, : active.grid.dim], active.grid
        corner, *ends = lattice_keys(np.vstack([np.zeros_like(self._axes[:1]), self._axes]))
        for axis, end in enumerate(ends):
            side = np.where(own[:, axis] < 0.0, 1, -1)
            neighbour = find_keys(self.key, key + side * (end - corner))
            alone = np.flatnonzero(neighbour < 0)
            side[alone] *= -1
            neighbour[alone] = find_keys(self.key, key[alone] + side[alone] * (end - corner))
            slope = np.where(neighbour[:, None] < 0, 0.0, self.displacement[neighbour] - own)
            cell = lattice - np.where(side < 0, 1, 0)[:, None]
            found -= (own[:, axis] * side / grid.sizes(cell)[:, axis])[:, None] * slope
        return found

    def misled(self) -> None:
        """Rests for `REST` steps: Newton's iteration failed with the guess of this step."""
        self.rest = REST

    def commit(self, active: ActiveGrid, displacement: Floats, size: float) -> None:
        """Remembers a converged step."""
        self.size, self.origin = size, active.grid.origin
        self.key, self.displacement = active.key.copy(), displacement
        self.rest = max(self.rest - 1, 0)

    def rows(self) -> tuple[Integers, list[str]]:
        """As `KeyedRows.rows`."""
        return self.key, ["key", "displacement"]

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {
            "size": np.array(self.size),
            "origin": self.origin,
            "key": self.key,
            "displacement": self.displacement,
            "rest": np.array(self.rest),
        }

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Goes on from the state of a checkpoint; raises `ValueError` if it is no such state."""
        require_table({name: state[name] for name in ("key", "displacement")}, increasing="key")
        if len(state["origin"]) != len(self.origin) or min(state["size"], state["rest"]) < 0:
            raise ValueError("'origin' is no place, or 'size' or 'rest' is negative")
        self.size, self.origin = float(state["size"]), state["origin"]
        self.key, self.displacement = state["key"], state["displacement"]
        self.rest = int(state["rest"])


def load_curves(model: Model) -> list[LoadCurve]:
    """Returns the load curves of all loads and motions."""
    moving = (each for each in chain(model.boundaries, model.rigid_bodies) if moves(each))
    return [model.load_curve(each) for each in chain(model.loads, moving)]


def _from_points(soil: Soil) -> Floats:
    """Each node's mean of the points' last displacement fields, by volume."""
    points, active, dim = soil.points, soil.active, soil.active.grid.dim
    volume = points.volume
    total = np.zeros((active.nodes, 1 + dim))
    for range_, stencil in zip(points.ranges, active.stencils, strict=True):
        s = slice(range_.start, range_.stop)
        _core.add_predictions(
            stencil, active.position, points.position[s], points.last_displacement[s],
            points.last_gradient[s], volume[s], total,
        )  # fmt: skip
    return np.asarray(
        total[:, 1:] / np.maximum(total[:, :1], 1e-300)
    )  # a domain may end at the node
