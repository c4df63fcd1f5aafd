# SPDX-License-Identifier: BSD-3-Clause
"""Where implicit boundaries touch soil in a step: their quadrature points near it, and its moduli.

Each process finds this for its own cells. Then all of them know it for the whole of each boundary,
in the order of a serial run: the patches of the multipliers extend over the cells of several
processes, and which vertices have one depends on their neighbours' (`multipliers.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.surfaces.ends import Ends
from tilth.boundaries.surfaces.gap import measure_gap
from tilth.boundaries.surfaces.measure import EVEN, SurfaceParts, sampled
from tilth.boundaries.surfaces.trace import Trace, trace_of_domains, with_corners
from tilth.comm import Communicator
from tilth.geometry.flat import box_corners
from tilth.grid.background import cell_corners
from tilth.grid.keys import lattice_keys
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.domains import half_edges
from tilth.mpm.elastic_moduli import ElasticModuli
from tilth.mpm.owned_places import OwnedPlaces
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import PointsInCells, find_cells, points_in_cells

if TYPE_CHECKING:
    from tilth.boundaries.surfaces.boundary import Implicit

LARGEST_CONSTRAINED_MODULUS = 3.0
"""Cap on the constrained modulus that scales the penalty, in units of Young's modulus.

The exact modulus is unbounded for nu -> 1/2 and would impair the matrix's condition. Because the
traction is carried from step to step, the value does not change the converged reaction.
"""

TRACE_REACH = 0.5
"""Distance from a boundary, in cells, up to which it is on the face of a domain."""


@dataclass(frozen=True)
class NearSoil:
    """The n quadrature points of a boundary that act on soil, ordered by cell.

    Attributes:
        chosen: their numbers among all points of the boundary, shape (n,).
        key: of the cell of each, shape (n,).
        local: coordinates in the cell, in cells, shape (n, dim).
        fraction: of the tributary part that is in contact with soil, 0 to 1, shape (n,).
        moduli: capped constrained and shear modulus of the soil [stress], shape (n, 2).
        elastic_share: elastic part of the soil's last strain increment [-], shape (n,).
        moved: motion of the soil in the last step [cells], shape (n,).
        open_ends: ends of the boundary beyond which the soil goes on; None without an end.
        trace: the soil's displacement there, with keys of nodes; None if it is that in the cells.
    """

    chosen: Integers
    key: Integers
    local: Floats
    fraction: Floats
    moduli: Floats
    elastic_share: Floats
    moved: Floats
    open_ends: Ends | None = None
    trace: Trace | None = None

    def at(self, active: ActiveGrid) -> PointsInCells:
        """Returns the points in the cells of a grid that has all these cells' nodes."""
        return points_in_cells(active, self.key, self.local)


def find_near_soil(
    boundaries: Sequence[Implicit],
    points: MaterialPoints,
    active: ActiveGrid,
    time: float,
    traced: bool = False,
) -> list[NearSoil]:
    """Returns the points of each boundary near soil at `time`, the start of the step.

    traced: whether with the soil's displacement on domains with corners.
    """
    if not boundaries:
        return []
    box = soil_box(points, active.comm)
    for boundary in boundaries:
        extend_quadrature(boundary, box, time)
    surfaces = [boundary.surface_points(time) for boundary in boundaries]
    ends = [boundary.ends(time) for boundary in boundaries]
    surfaces += [(each.beyond, each.normal, each.parts()) for each in ends if each is not None]
    last = np.cumsum([len(position) for position, _, _ in surfaces])
    surface, normal, part = (np.concatenate(each) for each in zip(*surfaces, strict=True))
    nearest, fraction = _find_contact(points, active, last, surface, normal, part)
    touched, share = np.split(nearest, last[:-1]), np.split(fraction, last[:-1])
    moduli = capped_moduli(points.elastic_moduli())
    found = [
        _near_soil(boundary, touched[i], share[i], points, active, moduli, time)
        for i, boundary in enumerate(boundaries)
    ]
    joined = [_of_all(each, active) for each in found]
    goes_on = iter(_in_any([each >= 0 for each in touched[len(boundaries) :]], active.comm))
    joined = [
        near if of is None else replace(near, open_ends=of.of(next(goes_on)))
        for near, of in zip(joined, ends, strict=True)
    ]
    if not traced:
        return joined
    return [
        replace(near, trace=_trace(boundary, near, points, active, time))
        for boundary, near in zip(boundaries, joined, strict=True)
    ]


def _in_any(flags: list[Flags], comm: Communicator) -> list[Flags]:
    """Returns the flags that are set in any process."""
    if not flags:
        return flags
    return [np.logical_or.reduce(each) for each in zip(*comm.gathered(flags), strict=True)]


def _near_soil(
    boundary: Implicit,
    nearest: Integers,
    fraction: Floats,
    points: MaterialPoints,
    active: ActiveGrid,
    moduli: Floats,
    time: float,
) -> NearSoil:
    """Returns the points near the soil of this process.

    nearest, fraction: of the boundary's surface points, see `_find_contact`.
    """
    assert boundary.quadrature is not None
    point = nearest[boundary.quadrature.on_surface]
    chosen = np.flatnonzero(point >= 0)
    overlay = points.overlays_of(point[chosen])
    key, local = find_cells(active, boundary.positions(time, chosen), overlay)
    order = np.argsort(key, kind="stable")
    chosen = chosen[order]
    touched = point[chosen]
    moved = points.last_displacement[touched]
    moved = np.abs(moved / active.grid.sizes_at(points.position[touched])).max(axis=1, initial=0.0)
    return NearSoil(
        chosen=chosen,
        key=key[order],
        local=local[order],
        fraction=fraction[boundary.quadrature.on_surface[chosen]],
        moduli=moduli[touched],
        elastic_share=points.elastic_share[touched],
        moved=moved,
    )


def _of_all(own: NearSoil, active: ActiveGrid) -> NearSoil:
    """Returns the points that all processes found in the cells that they own."""
    if active.shared is None:
        return own
    kept = active.shared.owns(own.key)
    names = [each.name for each in fields(NearSoil) if each.name not in ("open_ends", "trace")]
    columns = [getattr(own, name)[kept] for name in names]
    gathered = zip(*active.comm.gathered(columns), strict=True)
    joined: dict[str, Any] = dict(zip(names, map(np.concatenate, gathered), strict=True))
    order = np.lexsort((joined["chosen"], joined["key"]))
    return replace(own, **{name: array[order] for name, array in joined.items()})


def _trace(
    boundary: Implicit, near: NearSoil, points: MaterialPoints, active: ActiveGrid, time: float
) -> Trace | None:
    """Returns the displacement of domains with corners at the points of a boundary near them.

    It is the mean over samples of the points' parts; the nodes have their keys for numbers. None
    without such domains. All processes call it.
    """
    if boundary.declared.form != "surface":
        return None
    cornered = with_corners(points)
    if active.comm.max(float(cornered.any())) == 0.0:
        return None
    assert boundary.quadrature is not None
    on_surface = boundary.quadrature.on_surface[near.chosen]
    surface, normal, part = (each[on_surface] for each in boundary.surface_points(time))
    parts = SurfaceParts(surface, normal, part)
    places = OwnedPlaces.at(active, parts.position)
    own = places.own
    reach = TRACE_REACH * float(active.grid.cell_size.min())

    def measure(position: Floats, normal: Floats, widening: float) -> tuple[Floats, Integers]:
        return measure_gap(points, active.grid, {}, position, normal, reach, reach, widening)

    samples = sampled(parts.of(own), EVEN, measure, np.arange(len(own)))
    kept = np.isfinite(samples.gap) & cornered[samples.point]
    at = points_in_cells(active, near.key[own], near.local[own])
    trace = trace_of_domains(
        active, points, at, samples.part[kept], samples.position[kept], samples.point[kept]
    )
    return trace.at_keys(active, places)


def nodes_of_cells(keys: Sequence[Integers], active: ActiveGrid) -> Integers:
    """Returns the sorted keys of the nodes of cells, by the keys of these in several arrays."""
    key = np.concatenate([np.zeros(0, dtype=np.int64), *keys])
    corner = lattice_keys(cell_corners(active.grid.dim))
    return np.unique(np.unique(key)[:, None] + (corner - corner[0]))


def capped_moduli(points: ElasticModuli) -> Floats:
    """Returns the capped constrained and the shear modulus of points [stress], shape (n, 2)."""
    capped = np.minimum(points.constrained, LARGEST_CONSTRAINED_MODULUS * points.young)
    return np.stack([capped, points.shear], axis=1)


def soil_box(points: MaterialPoints, comm: Communicator) -> Floats:
    """Returns the lower and the upper corner of the box of all points' boxes, shape (2, dim)."""
    corners = []
    for x, half in zip(points.position.T, points.half_length.T, strict=True):  # fast by columns
        most = comm.max(float(half.max(initial=0.0)))
        lower, upper = float(x.min(initial=np.inf)), float(x.max(initial=-np.inf))
        corners.append((-comm.max(-lower) - most, comm.max(upper) + most))
    return np.array(corners).T


def extend_quadrature(boundary: Implicit, box: Floats, time: float) -> None:
    """Extends the quadrature points of a boundary to the soil's box at `time`, shape (2, dim)."""
    reference = boundary.reference_position(box_corners(*box), time)
    boundary.extend_quadrature(reference.min(axis=0), reference.max(axis=0))


def _find_contact(
    points: MaterialPoints,
    active: ActiveGrid,
    ends: Integers,
    surface: Floats,
    normal: Floats,
    part: Floats,
) -> tuple[Integers, Floats]:
    """Returns the material point in contact with each surface point and the fraction in contact.

    The point's number, -1 without contact, and the fraction of the tributary part that is in
    contact with soil, 0 to 1; shape (n,) each.
    ends: end of each boundary's surface points. surface: positions [length], shape (n, dim).
    part: tributary parts, shape (n, dim, dim).
    """
    dim, grid = surface.shape[1], active.grid
    edge = half_edges(points)
    if edge is None:
        edge = inverse = np.zeros((0, dim, dim))
        reach = 2.0 * points.half_length
    else:
        inverse = np.ascontiguousarray(np.linalg.inv(edge).transpose(0, 2, 1))
        reach = 2.0 * np.abs(edge).sum(axis=1)  # see soil_contact.hpp
    around = np.ones(dim, dtype=np.int64)  # domains end at most half a cell from the point
    if grid.graded:
        farthest = reach.max(axis=0) + 2.0 * grid.largest_size
    else:
        if edge.size:
            around = np.ceil(reach.max(axis=0) / grid.cell_size).astype(np.int64)
        farthest, reach = around * grid.cell_size, np.zeros((0, dim))
    near = np.ones(len(surface), dtype=bool)
    for x, soil, half, margin in zip(
        surface.T, points.position.T, points.half_length.T, farthest, strict=True
    ):
        most = half.max()
        near &= (x >= soil.min() - most - margin) & (x <= soil.max() + most + margin)
    nearest, fraction = np.full(len(surface), -1), np.zeros(len(surface))
    start = np.searchsorted(np.flatnonzero(near), np.append(0, ends))
    nearest[near], fraction[near] = _core.find_contact(
        start, surface[near], normal[near], part[near], points.position, points.half_length,
        edge, inverse, around, reach, grid,
    )  # fmt: skip
    return nearest, fraction
