# SPDX-License-Identifier: BSD-3-Clause
"""The surface of a body in the plane: chains of boundary points that move with the soil."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats, Integers
from tilth.curves.chain import BadSurface, Chain, sharp_corners
from tilth.curves.crossing import find_crossings, require_no_crossing
from tilth.curves.nearest import NearestPoints
from tilth.curves.quadrature import cut_at_grid, gauss_points
from tilth.curves.spline import LocalCubicSpline
from tilth.errors import BadInput, StepFailed
from tilth.model import Body, Model, SurfaceLoad
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import locate_in_cells, near_soil
from tilth.output.snapshot import SurfaceShape
from tilth.surface.outline import ON_AXIS, outline
from tilth.surface.quadrature import SurfaceQuadrature
from tilth.surface.upkeep import upkeep

LONGEST = 1.25
"""A chord longer than this many spacings of the start is divided."""
SHORTEST = 0.25
"""Of two points nearer than this many spacings one is left out."""
GAUSS_POINTS = 5
"""On each piece of the spline in a cell; exact for a constant pressure on the shape functions."""
COINCIDENT = 1e-6
"""Places nearer than this many spacings are one."""


@dataclass(frozen=True)
class TrackedChain:
    """One chain and what its points remember.

    Attributes:
        now: the n points where they are.
        initial: the same points where they were at time 0.
        marked: numbers of the points that loaded parts begin and end at, shape (marks,).
        point_id: the material points it consists of, shape (n,); empty for extra points.
    """

    now: Chain
    initial: Chain
    marked: Integers
    point_id: Integers


class TrackedSurface:
    """All chains of one body.

    Attributes:
        name: of the body.
        chains: outer ones first, then holes; the soil is on their left.

    Args:
        model: the declared problem.
        number: of the body in it, which has a `surface`.
        points: the material points at time 0.

    Raises:
        BadInput: no chain can be made of what is declared, or a load finds no part of it.
    """

    def __init__(self, model: Model, number: int, points: MaterialPoints) -> None:
        body = model.bodies[number]
        assert body.surface is not None
        self.name = body.name
        self._axisymmetric = model.analysis.kind == "axisymmetric"
        self._spacing = body.surface.spacing or 0.5 * min(model.cell_size)
        key = f"bodies[{number}].surface"
        chains = _declared_chains(body, model, self._spacing, f"{key}.vertices")
        self.chains = []
        for chain in chains:
            ids = np.zeros(0, dtype=np.int64)
            if body.surface.points == "outer_layer":
                chain, ids = _outer_layer(chain, points, number)
            self.chains.append(TrackedChain(chain, chain, np.zeros(0, dtype=np.int64), ids))
        self._parts: dict[int, tuple[int, int, int]] = {}
        for load_number, load in enumerate(model.loads):
            if isinstance(load, SurfaceLoad) and load.body == body.name and load.start is not None:
                self._mark(load_number, load)

    def _mark(self, number: int, load: SurfaceLoad) -> None:
        """Marks the ends of a loaded part; a point is added where there is none."""
        found = [self._nearest(np.array([x])) for x in (load.start, load.end)]
        key = f"loads[{number}]"
        if found[0][0] != found[1][0]:
            raise BadInput(
                "`start` and `end` lie on different chains of the surface",
                "give each chain a load of its own",
                key=f"{key}.end",
                value=load.end,
            )
        chain_number = found[0][0]
        tracked, at = self.chains[chain_number], np.array([place for _, place in found])
        if not tracked.now.closed and at[0] >= at[1]:
            raise BadInput(
                "the part runs against the chain: the soil would be on its right",
                "exchange `start` and `end`",
                key=f"{key}.start",
                value=load.start,
            )
        tracked, here = _with_points(tracked, at)
        mark = len(tracked.marked)
        self._parts[number] = (chain_number, mark, mark + 1)
        self.chains[chain_number] = replace(tracked, marked=np.append(tracked.marked, here))

    def _nearest(self, x: Floats) -> tuple[int, float]:
        """Chain, and segment plus parameter on it, of the place nearest to x (1, 2)."""
        best = (0, 0.0, np.inf)
        for number, tracked in enumerate(self.chains):
            nearest = NearestPoints(LocalCubicSpline(tracked.now)).find(x)
            at = float(nearest.segment[0] + nearest.parameter[0])
            to_point = np.linalg.norm(tracked.now.points - x, axis=1)
            near = int(to_point.argmin())
            if len(tracked.point_id) or to_point[near] < COINCIDENT * self._spacing:
                at = float(near)  # there is a point already, or only material points will do
            distance = float(np.linalg.norm(nearest.offset))
            if distance < best[2]:
                best = number, at, distance
        return best[0], best[1]

    def quadrature(self, active: ActiveGrid) -> SurfaceQuadrature:
        """Returns Gauss points on the spline's pieces in the cells of the grid."""
        parts = []
        for tracked in self.chains:
            now, initial = LocalCubicSpline(tracked.now), LocalCubicSpline(tracked.initial)
            pieces = cut_at_grid(now, active.grid.origin, active.grid.cell_size)
            at = gauss_points(now, pieces, GAUSS_POINTS)
            share = at.weight * 0.5 * (pieces.end - pieces.begin)[at.piece]
            parts.append(
                SurfaceQuadrature(
                    position=at.position,
                    edges=(at.weight[:, None] * at.derivative)[:, None],
                    initial_position=initial.position(at.segment, at.parameter),
                    initial_edges=(share[:, None] * initial.derivative(at.segment, at.parameter))[
                        :, None
                    ],
                    patch=at.segment,
                    arc_length=initial.arc_length(at.segment, at.parameter),
                )
            )
        return SurfaceQuadrature.joined(parts, [len(tracked.now) for tracked in self.chains])

    def loaded(self, number: int, quadrature: SurfaceQuadrature) -> tuple[Integers, Floats]:
        """Returns what of the quadrature a load of the model covers, and the arc lengths there.

        Rows of the quadrature, shape (m,), and initial arc length from the part's start [length].
        """
        if number not in self._parts:
            return np.arange(len(quadrature.patch)), quadrature.arc_length
        chain, first, last = self._parts[number]
        tracked = self.chains[chain]
        n, (begin, end) = len(tracked.now), tracked.marked[[first, last]]
        count = (end - begin) % n or n
        offset = sum(len(before.now) for before in self.chains[:chain])
        segment = quadrature.patch - offset
        rows = np.flatnonzero((segment >= 0) & (segment < n) & ((segment - begin) % n < count))
        initial = LocalCubicSpline(tracked.initial)
        arc = quadrature.arc_length[rows] - initial.arc_length(begin, np.zeros(()))
        return rows, np.where(arc < 0.0, arc + initial.length, arc)

    def moved(
        self, active: ActiveGrid, displacement: Floats, points: MaterialPoints, position: Floats
    ) -> tuple[list[TrackedChain], str | None]:
        """As `BodySurface.moved`."""
        moved = []
        for tracked in self.chains:
            if len(tracked.point_id):
                place = position[points.index_of(tracked.point_id)]
            else:
                place = moved_with(active, tracked.now.points, displacement, self.name)
                on_axis = self._ends_on_axis(tracked.now, active)
                place[on_axis, 0] = tracked.now.points[on_axis, 0]
            try:
                now = Chain(place, tracked.now.closed, tracked.now.corner)
            except BadSurface as error:
                raise StepFailed(f"the surface of {self.name!r}: {error.problem}") from error
            tracked = replace(tracked, now=now)
            moved.append(tracked if len(tracked.point_id) else self._kept_up(tracked))
        crossings = find_crossings([tracked.now for tracked in moved])
        if not len(crossings.position):
            return moved, None
        where = ", ".join(f"{x:.4g}" for x in crossings.position[0])
        return moved, f"the surface of {self.name!r} touches or crosses itself at ({where})"

    def _ends_on_axis(self, chain: Chain, active: ActiveGrid) -> Flags:
        """Returns which points are ends of an open chain on the axis of symmetry, shape (n,)."""
        found = np.zeros(len(chain), dtype=bool)
        if self._axisymmetric and not chain.closed:
            found[[0, -1]] = True
        near = np.abs(chain.points[:, 0]) <= ON_AXIS * active.grid.cell_size[0]
        return np.asarray(found & near)

    def commit(self, state: list[TrackedChain]) -> None:
        """As `BodySurface.commit`."""
        self.chains = state

    def _kept_up(self, tracked: TrackedChain) -> TrackedChain:
        kept = np.zeros(len(tracked.now), dtype=bool)
        kept[tracked.marked] = True
        new = upkeep(tracked.now, LONGEST * self._spacing, SHORTEST * self._spacing, kept)
        if not (new.inserted or new.merged):
            return tracked
        initial = LocalCubicSpline(tracked.initial).position(new.segment, new.parameter)
        number = np.rint(new.segment + new.parameter).astype(np.int64)
        old = np.abs(new.segment + new.parameter - number) == 0.0
        place = np.full(len(tracked.now) + 1, -1)
        place[number[old]] = np.flatnonzero(old)
        return TrackedChain(
            now=new.chain,
            initial=Chain(initial, new.chain.closed, new.chain.corner),
            marked=place[tracked.marked],
            point_id=tracked.point_id,
        )

    def enclosed(self) -> float:
        """As `BodySurface.enclosed`; holes have none."""
        return sum(LocalCubicSpline(tracked.now).area for tracked in self.chains)

    def shape(self) -> SurfaceShape:
        """Returns the surface as it is written: the boundary points and the chords."""
        position, cells, normal, arc, first = [], [], [], [], 0
        for tracked in self.chains:
            spline, n = LocalCubicSpline(tracked.now), len(tracked.now)
            segment, t = np.arange(n), np.zeros(n)
            if not tracked.now.closed:
                segment[-1], t[-1] = n - 2, 1.0
            position.append(tracked.now.points)
            normal.append(_mean_normal(spline, segment, t))
            arc.append(spline.arc_length(segment, t))
            ahead = np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1)
            cells.append(first + ahead[: len(spline)])
            first += n
        fields = {"normal": np.concatenate(normal), "arc_length": np.concatenate(arc)}
        return SurfaceShape(self.name, np.concatenate(position), np.concatenate(cells), fields)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns what a checkpoint must hold."""
        found: dict[str, npt.NDArray[Any]] = {}
        for number, tracked in enumerate(self.chains):
            for name, array in (
                ("points", tracked.now.points),
                ("corner", tracked.now.corner),
                ("initial", tracked.initial.points),
                ("marked", tracked.marked),
                ("point_id", tracked.point_id),
            ):
                found[f"{number}_{name}"] = array
        return found

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Goes on from the state of a checkpoint."""
        chains = []
        for number, tracked in enumerate(self.chains):
            closed, corner = tracked.now.closed, state[f"{number}_corner"]
            chains.append(
                TrackedChain(
                    now=Chain(state[f"{number}_points"], closed, corner),
                    initial=Chain(state[f"{number}_initial"], closed, corner),
                    marked=state[f"{number}_marked"],
                    point_id=state[f"{number}_point_id"],
                )
            )
        self.chains = chains


def moved_with(active: ActiveGrid, place: Floats, displacement: Floats, name: str) -> Floats:
    """Returns places (n, dim) moved with the grid; in an empty cell with the nearest soil.

    Raises:
        StepFailed: a place is more than a cell away from the soil.
    """
    if not near_soil(active, place).all():
        raise StepFailed(f"a boundary point of {name!r} left the soil")
    order, at = locate_in_cells(active, place)
    moved = place.copy()
    moved[order] += at.interpolate(displacement)
    return moved


def _declared_chains(body: Body, model: Model, spacing: float, key: str) -> list[Chain]:
    surface = body.surface
    assert surface is not None
    if surface.vertices is None:
        kind, angle = model.analysis.kind, surface.corner_angle
        return outline(body, kind, model.cell_size, spacing, angle)
    vertices = np.array(surface.vertices)
    try:
        corner = sharp_corners(vertices, surface.closed, surface.corner_angle)
        if surface.corners is not None:
            corner = np.isin(np.arange(len(vertices)), surface.corners)
        chain = Chain(vertices, surface.closed, corner)
    except BadSurface as error:
        raise BadInput(error.problem, error.remedy, key=key) from error
    require_no_crossing(chain, key)
    return [chain]


def _outer_layer(chain: Chain, points: MaterialPoints, number: int) -> tuple[Chain, Integers]:
    """The chain through the material points of a body nearest to an outline, and their numbers."""
    part = points.part(points.bodies[number])
    distance = np.linalg.norm(part.position[None] - chain.points[:, None], axis=2)
    nearest = distance.argmin(axis=1)
    kept = nearest != np.roll(nearest, 1)
    if not chain.closed:
        kept[0] = True
    nearest = nearest[kept]
    group = np.cumsum(kept) - 1
    corner = np.zeros(len(nearest), dtype=bool)
    corner[group[chain.corner]] = True
    return Chain(part.position[nearest], chain.closed, corner), part.point_id[nearest]


def _with_points(tracked: TrackedChain, at: Floats) -> tuple[TrackedChain, Integers]:
    """The chain with points at these places (segment plus parameter) too, and their numbers."""
    now = tracked.now
    spline = LocalCubicSpline(now)
    new = np.setdiff1d(at, np.arange(len(now)))
    segment = np.minimum(new.astype(np.int64), len(spline) - 1)
    place = np.concatenate([np.arange(len(now)), new])
    order = np.argsort(place)
    points = np.concatenate([now.points, spline.position(segment, new - segment)])[order]
    corner = np.concatenate([now.corner, np.zeros(len(new), dtype=bool)])[order]
    chain = Chain(points, now.closed, corner)
    place = place[order]
    marked = np.searchsorted(place, tracked.marked)
    return replace(tracked, now=chain, initial=chain, marked=marked), np.searchsorted(place, at)


def _mean_normal(spline: LocalCubicSpline, segment: Integers, t: Floats) -> Floats:
    """Normals at the points of a chain; at a corner the mean of both sides."""
    here = spline.normal(segment, t)
    before = np.roll(spline.normal(np.arange(len(spline)), np.ones(len(spline))), 1, axis=0)
    if not spline.chain.closed:
        before = np.concatenate([here[:1], before[1:], here[-1:]])
    both = here + before
    return np.asarray(both / np.linalg.norm(both, axis=1, keepdims=True))
