# SPDX-License-Identifier: BSD-3-Clause
"""All implicit boundaries of a step taken together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.implicit.band import BandConstraint
from tilth.boundaries.implicit.constraint import ImplicitConstraint, SurfaceConstraint
from tilth.boundaries.implicit.multipliers import (
    choose_multipliers,
    joined_cells,
    multiplier_coupling,
)
from tilth.geometry.flat import box_corners
from tilth.mpm.domains import half_edges
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.points import ElasticModuli, MaterialPoints
from tilth.mpm.quadrature import locate_places
from tilth.terms.linear import LinearElements

if TYPE_CHECKING:
    from tilth.boundaries.implicit.boundary import Implicit

LARGEST_CONSTRAINED_MODULUS = 3.0
"""Cap on the constrained modulus that scales the penalty, in units of Young's modulus.

The exact one grows without limit towards nu = 1/2 and would spoil the matrix's condition; with the
carried traction its value does not change the converged reaction.
"""

STIFFNESS_RATIO_OF_BAND = 2.0
"""How much firmer the band form ties nodes behind: it holds each point and needs no freedom there.
"""


@dataclass(frozen=True)
class ImplicitConstraints:
    """What the implicit boundaries do in one step.

    Attributes:
        active: the grid of the step.
        parts: one per boundary that touches soil.
        untouched: the other boundaries.
    """

    active: ActiveGrid
    parts: list[ImplicitConstraint]
    untouched: list[Implicit]

    @classmethod
    def gather(
        cls,
        boundaries: list[Implicit],
        points: MaterialPoints,
        active: ActiveGrid,
        kind: str,
        before: float,
        after: float,
        constrained: Flags | None = None,
    ) -> ImplicitConstraints:
        """Finds out where the boundaries touch soil in the step from time `before` to `after`.

        constrained: components that other conditions prescribe at nodes, (nodes, dim); none if not
            given.
        """
        if not boundaries:
            return cls(active, [], [])
        surfaces, normals, parts_of, box = [], [], [], _box(points)
        for boundary in boundaries:
            _cover(boundary, box, before)
            places, normal, part_of = boundary.surface_places(before)
            surfaces.append(places)
            normals.append(normal)
            parts_of.append(part_of)
        places, normal = np.concatenate(surfaces), np.concatenate(normals)
        ends = np.cumsum([len(of_one) for of_one in surfaces])
        nearest, share = _touching(
            points, active, ends, places, normal, np.concatenate(parts_of), box
        )
        moduli = _moduli(points.elastic_moduli())
        parts: list[ImplicitConstraint] = []
        untouched = []
        for boundary, end, places in zip(boundaries, ends, surfaces, strict=True):
            assert boundary.quadrature is not None
            own = slice(end - len(places), end)
            point = nearest[own][boundary.quadrature.on_surface]
            chosen = np.flatnonzero(point >= 0)
            if len(chosen) == 0:
                untouched.append(boundary)
                continue
            place = boundary.places(before, chosen)
            order, at = locate_places(active, place)
            chosen = chosen[order]
            pose = boundary.pose(before, after, chosen)
            covered = share[own][boundary.quadrature.on_surface[chosen]]
            make = SurfaceConstraint if boundary.declared.form == "surface" else BandConstraint
            parts.append(
                make(
                    boundary=boundary,
                    chosen=chosen,
                    at=at,
                    pose=replace(pose, weight=pose.weight * covered),
                    moduli=moduli[point[chosen]],
                    axisymmetric=kind == "axisymmetric",
                    elastic_share=points.elastic_share[point[chosen]],
                )
            )
        if constrained is None:
            constrained = np.zeros((active.nodes, active.grid.dim), dtype=bool)
        of_surfaces = [part for part in parts if isinstance(part, SurfaceConstraint)]
        multipliers = iter(choose_multipliers(active, of_surfaces, constrained))
        parts = [
            replace(part, multipliers=next(multipliers))
            if isinstance(part, SurfaceConstraint)
            else part
            for part in parts
        ]
        return cls(active, parts, untouched)

    def behind(self) -> tuple[Integers, Floats]:
        """Returns the nodes behind boundaries, near them: sorted keys, and how firmly to tie them.

        From 0 on the boundary to 1 a cell behind it (to `STIFFNESS_RATIO_OF_BAND` with the band
        form), times the square of the normal's component along each axis, shape (nodes, dim).
        """
        keys, depths = [np.zeros(0, dtype=np.int64)], [np.zeros((0, self.active.grid.dim))]
        for form, factor in ((SurfaceConstraint, 1.0), (BandConstraint, STIFFNESS_RATIO_OF_BAND)):
            parts = [part for part in self.parts if isinstance(part, form)]
            if not parts:
                continue
            key, depth = _core.nodes_behind(
                *joined_cells(parts), self.active.lattice, self.active.grid.cell_size
            )
            keys.append(np.asarray(key))
            depths.append(factor * np.asarray(depth))
        key, number = np.unique(np.concatenate(keys), return_inverse=True)
        firmest = np.zeros((len(key), self.active.grid.dim))
        np.maximum.at(firmest, number, np.concatenate(depths))
        return key, firmest

    def warnings(self) -> list[tuple[str, str]]:
        """Returns what is probably not meant: a key for each warning, and its text."""
        found = [
            (
                f"place of {boundary.name}",
                f"boundary {boundary.name!r} touches no soil: no material point is beside it",
            )
            for boundary in self.untouched
        ]
        for part in self.parts:
            if isinstance(part, BandConstraint) and part.may_lock():
                name = part.boundary.name
                text = (
                    f'the boundary {name!r} with form = "band" holds each of its quadrature '
                    "points: where it moves or is not along the grid, the soil beside it is too "
                    'stiff; form = "surface" is not'
                )
                found.append((f"band of {name}", text))
        return found

    def couplings(self) -> list[LinearElements]:
        """Returns the forces of the slip, linear in the displacement of the step."""
        couplings: list[LinearElements] = []
        surfaces = [part for part in self.parts if isinstance(part, SurfaceConstraint)]
        if surfaces:
            multipliers = [part.multipliers for part in surfaces if part.multipliers is not None]
            slips = [part.slip_at_rest() for part in surfaces]
            couplings.append(multiplier_coupling(multipliers, slips))
        return couplings + [p.coupling() for p in self.parts if isinstance(p, BandConstraint)]

    def reached(self) -> Flags:
        """Returns the nodes of the cells that the boundaries act on, shape (nodes,)."""
        found = np.zeros(self.active.nodes, dtype=bool)
        for part in self.parts:
            found[part.at.node] = True
        return found

    def largest_increment(self) -> float:
        """Returns how far the boundaries that touch soil move in the step [length]."""
        return max(
            (float(np.linalg.norm(part.pose.increment, axis=1).max()) for part in self.parts),
            default=0.0,
        )

    @cached_property
    def carried_force(self) -> Floats:
        """The boundaries' internal force of what they carry from before, (nodes, dim)."""
        force = np.zeros((self.active.nodes, self.active.grid.dim))
        for part in self.parts:
            force += part.nodal_force(part.before, self.active.nodes)
        return force

    def reaction_before(self, initial: Floats, constrained: Flags, constant: Floats) -> Floats:
        """Returns the nodal forces of all boundaries at the start of the step, (nodes, dim).

        initial: what the constrained nodes bear at zero displacement, shape (nodes, dim). It
        contains `constant`, the force by which implicit boundaries begin to move the soil; what
        acted before the step is what they carry.
        """
        carried = self.carried_force
        return np.asarray(initial - np.where(constrained, constant - carried, 0.0) - carried)

    def forces(self, carried: list[Floats]) -> dict[str, Floats]:
        """Returns each boundary's nodal forces on the soil at the end, (nodes, dim), by name."""
        still = np.zeros((self.active.nodes, self.active.grid.dim))
        forces = dict.fromkeys([boundary.name for boundary in self.untouched], still)
        for part, each in zip(self.parts, carried, strict=True):
            forces[part.boundary.name] = -part.nodal_force(each, self.active.nodes)
        return forces

    def after(self, displacement: Floats) -> list[Floats]:
        """Returns what each part carries at the end of a step, see `ImplicitConstraint.after`."""
        return [part.after(displacement) for part in self.parts]

    def commit(self, carried: list[Floats]) -> None:
        """Carries on to the next step; a boundary that touches no soil carries nothing."""
        for part, each in zip(self.parts, carried, strict=True):
            part.commit(each)
        for boundary in self.untouched:
            boundary.carried = np.zeros_like(boundary.carried)


def _moduli(points: ElasticModuli) -> Floats:
    """Returns the capped constrained and the shear modulus of points [stress], shape (n, 2)."""
    capped = np.minimum(points.constrained, LARGEST_CONSTRAINED_MODULUS * points.young)
    return np.stack([capped, points.shear], axis=1)


def _box(points: MaterialPoints) -> Floats:
    """Returns the lower and the upper corner of the box of all points' boxes, shape (2, dim)."""
    corners = []
    for x, reach in zip(points.position.T, points.half_length.T, strict=True):  # fast by columns
        corners.append((x.min() - reach.max(), x.max() + reach.max()))
    return np.array(corners).T


def _cover(boundary: Implicit, box: Floats, time: float) -> None:
    """Makes sure that a boundary has quadrature points wherever the soil is at `time`."""
    at_rest = boundary.at_rest(box_corners(*box), time)
    boundary.cover(at_rest.min(axis=0), at_rest.max(axis=0))


def _touching(
    points: MaterialPoints,
    active: ActiveGrid,
    ends: Integers,
    places: Floats,
    normal: Floats,
    part: Floats,
    box: Floats,
) -> tuple[Integers, Floats]:
    """Returns the nearest point that each place touches, -1 if none, and how much of its part is.

    Shapes (n,); the share between 0 and 1.
    ends: where the places of each boundary end. part: what they stand for, (n, dim, dim).
    """
    dim, cell = places.shape[1], active.grid.cell_size
    edge = half_edges(points)
    if edge is None:
        edge = inverse = np.zeros((0, dim, dim))
        around = np.ones(dim, dtype=np.int64)  # domains end at most half a cell from the point
    else:
        inverse = np.ascontiguousarray(np.linalg.inv(edge).transpose(0, 2, 1))
        farthest = 2.0 * np.abs(edge).sum(axis=1).max(axis=0)  # see touch.hpp
        around = np.ceil(farthest / cell).astype(np.int64)
    near = np.ones(len(places), dtype=bool)
    for x, low, high, margin in zip(places.T, *box, around * cell, strict=True):
        near &= (x >= low - margin) & (x <= high + margin)
    nearest, share = np.full(len(places), -1), np.zeros(len(places))
    start = np.searchsorted(np.flatnonzero(near), np.append(0, ends))
    nearest[near], share[near] = _core.touching_points(
        start, places[near], normal[near], part[near], points.position, points.half_length,
        edge, inverse, around, active.grid.origin, cell,
    )  # fmt: skip
    return nearest, share
