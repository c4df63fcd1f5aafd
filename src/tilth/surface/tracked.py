# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surface of a body in the plane: chains of boundary points that move with the soil."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats, Integers, require_table, require_within
from tilth.comm import from_owners
from tilth.curves.chain import BadSurface, Chain, sharp_corners
from tilth.curves.crossing import find_crossings, require_no_crossing
from tilth.curves.nearest import NearestPoints
from tilth.curves.quadrature import cut_at_grid, gauss_points
from tilth.curves.spline import LocalCubicSpline
from tilth.errors import BadInput, StepFailed
from tilth.model import Body, Model
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import near_process
from tilth.output.snapshot import SurfaceShape
from tilth.surface.beside_soil import lost_points, moved_with_grid, points_near_soil
from tilth.surface.outline import AXIS_TOLERANCE, outline
from tilth.surface.parts import DeclaredPart, declared_parts
from tilth.surface.quadrature import SurfaceQuadrature
from tilth.surface.redistribution import redistribute_points

LONGEST_CHORD_RATIO = 1.25
"""A chord longer than this many initial spacings is divided."""
SHORTEST_CHORD_RATIO = 0.25
"""Two points nearer than this many initial spacings are merged."""
GAUSS_POINTS = 5
"""Gauss points per piece of the spline in a cell; exact for forces of a constant pressure."""
PARTS_OF_SEGMENT = 4
"""Quadrature points per segment for contact: with two segments in a cell eight."""
ROUND_OFF = 1e-9
"""Share of a chain's length that does not count."""
LEAST_KEPT = 0.9
"""Share of a chain's points near the soil with which it goes on without the others."""
COINCIDENCE_TOLERANCE = 1e-6
"""Points nearer than this many initial spacings coincide."""


@dataclass(frozen=True)
class TrackedChain:
    """One chain with its initial configuration; n points.

    Attributes:
        current: the chain at its current position.
        initial: the chain of the same points at time 0.
        marked: numbers of the points where declared parts begin or end, shape (marks,).
        point_id: the material points of the chain, shape (n,); empty for extra points.
    """

    current: Chain
    initial: Chain
    marked: Integers
    point_id: Integers


class TrackedSurface:
    """All chains of one body.

    Attributes:
        name: name of the body.
        chains: outer ones first, then holes; the soil is on their left.

    Args:
        model: the declared problem.
        number: index of the body in the model; it declares a `surface`.
        points: the material points at time 0.

    Raises:
        BadInput: the declared surface is no valid chain, or what acts on it is on no part of it.
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
        self._parts: dict[str, tuple[int, int, int]] = {}
        parts = declared_parts(model, body.name)
        self._is_loaded = bool(parts)
        for key, part in parts.items():
            if part.start is not None:
                self._mark(key, part)

    def _mark(self, key: str, part: DeclaredPart) -> None:
        """Marks the ends of a declared part; a boundary point is inserted where there is none."""
        found = [self._nearest(np.array([x])) for x in (part.start, part.end)]
        if found[0][0] != found[1][0]:
            raise BadInput(
                "`start` and `end` lie on different chains of the surface",
                "give each chain an entry of its own",
                key=f"{key}.end",
                value=part.end,
            )
        chain_number = found[0][0]
        tracked, at = self.chains[chain_number], np.array([coordinate for _, coordinate in found])
        if not tracked.current.closed and at[0] >= at[1]:
            raise BadInput(
                "the part runs against the chain: the soil would be on its right",
                "exchange `start` and `end`",
                key=f"{key}.start",
                value=part.start,
            )
        tracked, here = _with_points(tracked, at)
        mark = len(tracked.marked)
        self._parts[key] = (chain_number, mark, mark + 1)
        self.chains[chain_number] = replace(tracked, marked=np.append(tracked.marked, here))

    def _nearest(self, x: Floats) -> tuple[int, float]:
        """Returns chain, and segment plus parameter on it, of the point nearest to x (1, 2)."""
        best = (0, 0.0, np.inf)
        for number, tracked in enumerate(self.chains):
            nearest = NearestPoints(LocalCubicSpline(tracked.current)).find(x)
            at = float(nearest.segment[0] + nearest.parameter[0])
            to_point = np.linalg.norm(tracked.current.points - x, axis=1)
            near = int(to_point.argmin())
            if len(tracked.point_id) or to_point[near] < COINCIDENCE_TOLERANCE * self._spacing:
                at = float(near)  # an existing point; the outer layer has no others
            distance = float(np.linalg.norm(nearest.offset))
            if distance < best[2]:
                best = number, at, distance
        return best[0], best[1]

    def quadrature(self, active: ActiveGrid) -> SurfaceQuadrature:
        """As `BodySurface.quadrature`: Gauss points on the spline's pieces in the grid's cells."""
        parts = []
        for tracked in self.chains:
            current, initial = LocalCubicSpline(tracked.current), LocalCubicSpline(tracked.initial)
            pieces = cut_at_grid(current, active.grid)
            at = gauss_points(current, pieces, GAUSS_POINTS)
            length = at.weight * 0.5 * (pieces.end - pieces.begin)[at.piece]
            parts.append(
                SurfaceQuadrature(
                    position=at.position,
                    edges=(at.weight[:, None] * at.derivative)[:, None],
                    initial_position=initial.position(at.segment, at.parameter),
                    initial_edges=(length[:, None] * initial.derivative(at.segment, at.parameter))[
                        :, None
                    ],
                    element=at.segment,
                    arc_length=initial.arc_length(at.segment, at.parameter),
                )
            )
        return SurfaceQuadrature.joined(parts, [len(tracked.current) for tracked in self.chains])

    def material_quadrature(self) -> SurfaceQuadrature:
        """As `BodySurface.material_quadrature`: the middles of equal parts of each segment.

        The edges are the parts' chords, so that the integral of the normal is exact.
        """
        parts = []
        begin = np.arange(PARTS_OF_SEGMENT) / PARTS_OF_SEGMENT
        for tracked in self.chains:
            current, initial = LocalCubicSpline(tracked.current), LocalCubicSpline(tracked.initial)
            segment = np.repeat(np.arange(len(current)), PARTS_OF_SEGMENT)
            ends = [
                np.tile(begin + share / PARTS_OF_SEGMENT, len(current)) for share in (0, 0.5, 1)
            ]
            low, middle, high = ends
            parts.append(
                SurfaceQuadrature(
                    position=current.position(segment, middle),
                    edges=(current.position(segment, high) - current.position(segment, low))[
                        :, None
                    ],
                    initial_position=initial.position(segment, middle),
                    initial_edges=(
                        initial.position(segment, high) - initial.position(segment, low)
                    )[:, None],
                    element=segment,
                    arc_length=initial.arc_length(segment, middle),
                )
            )
        return SurfaceQuadrature.joined(parts, [len(tracked.current) for tracked in self.chains])

    def of_part(self, key: str, quadrature: SurfaceQuadrature) -> tuple[SurfaceQuadrature, Floats]:
        """As `BodySurface.of_part`."""
        if key not in self._parts:
            return quadrature, quadrature.arc_length
        chain, first, last = self._parts[key]
        tracked = self.chains[chain]
        n, (begin, end) = len(tracked.current), tracked.marked[[first, last]]
        count = (end - begin) % n or n
        offset = sum(len(before.current) for before in self.chains[:chain])
        segment = quadrature.element - offset
        rows = np.flatnonzero((segment >= 0) & (segment < n) & ((segment - begin) % n < count))
        initial = LocalCubicSpline(tracked.initial)
        arc = quadrature.arc_length[rows] - initial.arc_length(begin, np.zeros(()))
        return quadrature.ordered(rows), np.where(arc < 0.0, arc + initial.length, arc)

    def long_parts(self) -> dict[str, float]:
        """As `BodySurface.long_parts`."""
        found = {}
        for key, (chain, first, last) in self._parts.items():
            tracked = self.chains[chain]
            initial = LocalCubicSpline(tracked.initial)
            begin, end = tracked.marked[[first, last]]
            if tracked.initial.closed and begin != end:
                at = initial.arc_length(np.array([begin, end]), np.zeros(2))
                share = float((at[1] - at[0]) % initial.length / initial.length)
                if share > 0.5 + ROUND_OFF:
                    found[key] = share
        return found

    def moved(
        self, active: ActiveGrid, displacement: Floats, points: MaterialPoints, position: Floats
    ) -> tuple[list[TrackedChain], str | None]:
        """As `BodySurface.moved`."""
        moved, warning = [], None
        for tracked in self.chains:
            if len(tracked.point_id):
                x = self._at_points(active, tracked.point_id, points, position)
            else:
                try:
                    x = moved_with_grid(active, tracked.current.points, displacement, self.name)
                except StepFailed:
                    if self._is_loaded:
                        raise
                    tracked, x, remedy = self._moved_beside_soil(tracked, active, displacement)
                    warning = lost_points(self.name, remedy)
                on_axis = self._ends_on_axis(tracked.current, active)
                x[on_axis, 0] = tracked.current.points[on_axis, 0]
            try:
                current = Chain(x, tracked.current.closed, tracked.current.corner)
            except BadSurface as error:
                raise StepFailed(f"the surface of {self.name!r}: {error.problem}") from error
            moved.append(replace(tracked, current=current))
        crossings = find_crossings([tracked.current for tracked in moved])
        crosses = len(crossings.position) > 0
        grows = self._is_loaded or not crosses  # a tangle would grow without end
        moved = [
            tracked if len(tracked.point_id) else self._redistributed(tracked, grows)
            for tracked in moved
        ]
        if crosses:
            where = ", ".join(f"{x:.4g}" for x in crossings.position[0])
            return moved, f"the surface of {self.name!r} touches or crosses itself at ({where})"
        return moved, warning

    def _moved_beside_soil(
        self, tracked: TrackedChain, active: ActiveGrid, displacement: Floats
    ) -> tuple[TrackedChain, Floats, str]:
        """Returns a chain without points more than a cell away from the soil, and how it moves.

        Where they are too many they stay in it, and stay where they are.

        Returns:
            The chain, the positions of its points at the end of the step, and what became of it.
        """
        points = tracked.current.points
        kept = points_near_soil(active, points, self.name)
        if not kept.any():
            raise StepFailed(f"all boundary points of {self.name!r} left the soil")
        moved = moved_with_grid(active, points[kept], displacement, self.name)
        if kept.sum() < LEAST_KEPT * len(kept):
            whole = points.copy()
            whole[kept] = moved
            return tracked, whole, "stays there where it was"
        try:
            current, initial = (
                Chain(each.points[kept], each.closed, each.corner[kept])
                for each in (tracked.current, tracked.initial)
            )
        except BadSurface as error:
            raise StepFailed(f"the surface of {self.name!r}: {error.problem}") from error
        return replace(tracked, current=current, initial=initial), moved, "goes on without them"

    def _at_points(
        self, active: ActiveGrid, point_id: Integers, points: MaterialPoints, position: Floats
    ) -> Floats:
        """Returns the positions of the points with these numbers, of all processes, (n, dim)."""
        row = points.index_of(point_id)
        mine = row >= 0
        mine[mine] = near_process(active, points.position[row[mine]])
        return from_owners(active.comm, mine, position[row[mine]])

    def _ends_on_axis(self, chain: Chain, active: ActiveGrid) -> Flags:
        """Returns which points are ends of an open chain on the axis of symmetry, shape (n,)."""
        found = np.zeros(len(chain), dtype=bool)
        if self._axisymmetric and not chain.closed:
            found[[0, -1]] = True
        near = np.abs(chain.points[:, 0]) <= AXIS_TOLERANCE * active.grid.cell_size[0]
        return np.asarray(found & near)

    def commit(self, state: list[TrackedChain]) -> None:
        """As `BodySurface.commit`."""
        self.chains = state

    def _redistributed(self, tracked: TrackedChain, grows: bool) -> TrackedChain:
        """Returns the chain after merging of points, and their insertion if it grows."""
        kept = np.zeros(len(tracked.current), dtype=bool)
        kept[tracked.marked] = True
        new = redistribute_points(
            tracked.current,
            LONGEST_CHORD_RATIO * self._spacing if grows else np.inf,
            SHORTEST_CHORD_RATIO * self._spacing,
            kept,
        )
        if not (new.inserted or new.merged):
            return tracked
        initial = LocalCubicSpline(tracked.initial).position(new.segment, new.parameter)
        number = np.rint(new.segment + new.parameter).astype(np.int64)
        old = np.abs(new.segment + new.parameter - number) == 0.0
        new_number = np.full(len(tracked.current) + 1, -1)
        new_number[number[old]] = np.flatnonzero(old)
        return TrackedChain(
            current=new.chain,
            initial=Chain(initial, new.chain.closed, new.chain.corner),
            marked=new_number[tracked.marked],
            point_id=tracked.point_id,
        )

    def move_vertically(self, displacement: Callable[[Floats], Floats]) -> None:
        """As `BodySurface.move_vertically`."""
        chains = []
        for tracked in self.chains:
            points = tracked.current.points.copy()
            points[:, 1] += displacement(points[:, :1])
            chain = Chain(points, tracked.current.closed, tracked.current.corner)
            chains.append(replace(tracked, current=chain, initial=chain))
        self.chains = chains

    def enclosed(self) -> float:
        """As `BodySurface.enclosed`; negative for holes."""
        return sum(LocalCubicSpline(tracked.current).area for tracked in self.chains)

    def shape(self) -> SurfaceShape:
        """As `BodySurface.shape`: the boundary points and the chords."""
        position, cells, normal, arc, first = [], [], [], [], 0
        for tracked in self.chains:
            spline, n = LocalCubicSpline(tracked.current), len(tracked.current)
            segment, t = np.arange(n), np.zeros(n)
            if not tracked.current.closed:
                segment[-1], t[-1] = n - 2, 1.0
            position.append(tracked.current.points)
            normal.append(_mean_normal(spline, segment, t))
            arc.append(spline.arc_length(segment, t))
            ahead = np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1)
            cells.append(first + ahead[: len(spline)])
            first += n
        fields = {"normal": np.concatenate(normal), "arc_length": np.concatenate(arc)}
        return SurfaceShape(self.name, np.concatenate(position), np.concatenate(cells), fields)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """As `BodySurface.state`."""
        found: dict[str, npt.NDArray[Any]] = {}
        for number, tracked in enumerate(self.chains):
            for name, array in (
                ("points", tracked.current.points),
                ("corner", tracked.current.corner),
                ("initial", tracked.initial.points),
                ("marked", tracked.marked),
                ("point_id", tracked.point_id),
            ):
                found[f"{number}_{name}"] = array
        return found

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """As `BodySurface.restore`."""
        chains = []
        for number, tracked in enumerate(self.chains):
            closed, corner = tracked.current.closed, state[f"{number}_corner"]
            require_within("marked", state[f"{number}_marked"], len(corner))
            if len(state[f"{number}_marked"]) != len(tracked.marked):
                raise ValueError(f"chain {number} has not the ends of parts that are declared")
            if len(state[f"{number}_point_id"]) != len(tracked.point_id):
                raise ValueError(f"chain {number} does not have the declared material points")
            require_table({name: state[f"{number}_{name}"] for name in ("points", "initial")})
            chains.append(
                TrackedChain(
                    current=Chain(state[f"{number}_points"], closed, corner),
                    initial=Chain(state[f"{number}_initial"], closed, corner),
                    marked=state[f"{number}_marked"],
                    point_id=state[f"{number}_point_id"],
                )
            )
        self.chains = chains


def _declared_chains(body: Body, model: Model, spacing: float, key: str) -> list[Chain]:
    """Returns the chains of a declared surface; `key` is that of its vertices."""
    surface = body.surface
    assert surface is not None
    if surface.vertices is None:
        kind, angle = model.analysis.kind, surface.corner_angle
        return outline(body, kind, model.cell_size, spacing, angle, model.origin)
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
    """Returns the chain of the material points nearest to an outline, and their numbers."""
    own = next(own for body, own in points.whole_bodies() if body.body == number)
    position, point_id = points.position[own], points.point_id[own]
    distance = np.linalg.norm(position[None] - chain.points[:, None], axis=2)
    nearest = distance.argmin(axis=1)
    kept = nearest != np.roll(nearest, 1)
    if not chain.closed:
        kept[0] = True
    nearest = nearest[kept]
    group = np.cumsum(kept) - 1
    corner = np.zeros(len(nearest), dtype=bool)
    corner[group[chain.corner]] = True
    return Chain(position[nearest], chain.closed, corner), point_id[nearest]


def _with_points(tracked: TrackedChain, at: Floats) -> tuple[TrackedChain, Integers]:
    """Returns the chain with points inserted at `at`, and the numbers of these points.

    at: segment plus parameter of each point, shape (n,); existing points are not repeated.
    """
    current = tracked.current
    spline = LocalCubicSpline(current)
    new = np.setdiff1d(at, np.arange(len(current)))
    segment = np.minimum(new.astype(np.int64), len(spline) - 1)
    coordinate = np.concatenate([np.arange(len(current)), new])
    order = np.argsort(coordinate)
    points = np.concatenate([current.points, spline.position(segment, new - segment)])[order]
    corner = np.concatenate([current.corner, np.zeros(len(new), dtype=bool)])[order]
    chain = Chain(points, current.closed, corner)
    coordinate = coordinate[order]
    marked = np.searchsorted(coordinate, tracked.marked)
    return replace(tracked, current=chain, initial=chain, marked=marked), np.searchsorted(
        coordinate, at
    )


def _mean_normal(spline: LocalCubicSpline, segment: Integers, t: Floats) -> Floats:
    """Returns unit normals at the points of a chain (n, 2); at a corner the mean of both sides."""
    here = spline.normal(segment, t)
    before = np.roll(spline.normal(np.arange(len(spline)), np.ones(len(spline))), 1, axis=0)
    if not spline.chain.closed:
        before = np.concatenate([here[:1], before[1:], here[-1:]])
    both = here + before
    return np.asarray(both / np.linalg.norm(both, axis=1, keepdims=True))
