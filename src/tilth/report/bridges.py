# SPDX-License-Identifier: BSD-3-Clause
"""What lies between bodies that stick together, where their domains leave a gap in pictures.

Domains follow the deformation each for itself: between bodies of one overlay, which
share the nodes where they meet, they leave gaps and overlap as they do within a body. What lies
between belongs to the body whose points are nearer, with the values of this one: a stress that
jumps from one body to the other has no value in between.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.output.snapshot import Snapshot
from tilth.report.region import Part, Region, part_of_domains, shares_of

REACH = 3.0
"""Distance of points that may be beside another body, over the diagonal of a domain."""


ON_EDGE = 1e-9
"""Share of a triangle beyond an edge that is round-off."""


def sticking(snapshot: Snapshot) -> dict[int, int]:
    """Returns the number of the overlay of each body, by its number."""
    bodies = np.unique(snapshot.body_id).tolist()
    if not snapshot.body_fields:
        return dict.fromkeys(bodies, 0)
    return {body: snapshot.body_fields[body] for body in bodies}


def region_of(snapshot: Snapshot, corners: Floats) -> Region:
    """Returns the region of the soil at an output in the plane, with what lies between bodies.

    corners: of the domains, relative to the points [length], x fastest, shape (n, 4, 2).
    """
    position, body_id = snapshot.position, snapshot.body_id
    region = Region.of(position, corners, body_id, snapshot.surfaces)
    bridges = bridges_of(position, corners, body_id, sticking(snapshot))
    return replace(region, bridges=tuple(bridges))


def bridges_of(
    position: Floats, corners: Floats, body_id: Integers, overlay_of: Mapping[int, int]
) -> list[Part]:
    """Returns parts between bodies of the same overlay, one for each body at least.

    The bodies may cover them.

    Args:
        position: of the points [length], shape (n, 2).
        corners: of their domains, relative to them [length], x fastest, shape (n, 4, 2).
        body_id: of the points, shape (n,).
        overlay_of: number of the overlay of each body, by its number.
    """
    found = []
    bodies = np.unique(body_id)
    overlay = np.array([overlay_of[body] for body in bodies.tolist()])
    for number in np.unique(overlay):
        own = bodies[overlay == number]
        if len(own) < 2:
            continue
        chosen = np.flatnonzero(np.isin(body_id, own))
        near = chosen[_beside_others(position[chosen], corners[chosen], body_id[chosen])]
        part = part_of_domains(near, position[near], corners[near]) if len(near) else None
        if part is not None:
            found += _between(part, body_id)
    return found


def _beside_others(position: Floats, corners: Floats, body_id: Integers) -> Flags:
    """Returns which points may be beside one of another body, shape (n,)."""
    from scipy.spatial import cKDTree

    reach = REACH * float(np.median(np.linalg.norm(corners[:, 3] - corners[:, 0], axis=1)))
    near = np.zeros(len(position), dtype=bool)
    for body in np.unique(body_id):
        own = body_id == body
        away, _ = cKDTree(position[~own]).query(position[own], distance_upper_bound=reach)
        near[own] = np.isfinite(away)
    return near


def _between(part: Part, body_id: Integers) -> list[Part]:
    """Returns the triangles between points of different bodies, and those that touch them.

    A triangle between two bodies is cut through the middles of its sides between them, and one
    between three into thirds.
    """
    from scipy.spatial import cKDTree

    count = len(part.points)
    _, nearest = cKDTree(part.vertex[:count]).query(part.vertex)
    body = body_id[part.points][nearest]
    corner = body[part.triangle]
    across = (corner != corner[:, :1]).any(axis=1)
    touched = np.zeros(len(part.vertex), dtype=bool)
    touched[part.triangle[across]] = True
    triangle = part.triangle[across | (touched[part.triangle].sum(axis=1) >= 2)]
    pieces, of_body = _cut(part.vertex[triangle], body[triangle])
    found = []
    for own in np.unique(of_body).tolist():
        inner = body_id[part.points] == own
        found.append(
            _part_of(part.points[inner], part.vertex[:count][inner], pieces[of_body == own])
        )
    return found


def _cut(corner: Floats, body: Integers) -> tuple[Floats, Integers]:
    """Returns triangles (n, 3, 2) in pieces that belong to one body, and the bodies.

    body: of the corners, shape (n, 3).
    """
    pieces, bodies = [], []
    alike = [body[:, (k + 1) % 3] == body[:, (k + 2) % 3] for k in range(3)]
    whole = alike[0] & alike[1]
    pieces.append(corner[whole])
    bodies.append(body[whole, 0])
    for k in range(3):
        turned, own = np.roll(corner, -k, axis=1), np.roll(body, -k, axis=1)
        alone = alike[k] & ~whole
        a, b, c = np.moveaxis(turned[alone], 1, 0)
        one, other = 0.5 * (a + b), 0.5 * (a + c)
        for piece, number in (((a, one, other), 0), ((one, b, c), 1), ((one, c, other), 1)):
            pieces.append(np.stack(piece, axis=1))
            bodies.append(own[alone, number])
        third = ~alike[0] & ~alike[1] & ~alike[2]
        a, b, c = np.moveaxis(turned[third], 1, 0)
        middle = turned[third].mean(axis=1)
        for piece in ((a, 0.5 * (a + b), middle), (a, middle, 0.5 * (a + c))):
            pieces.append(np.stack(piece, axis=1))
            bodies.append(own[third, 0])
    return np.concatenate(pieces), np.concatenate(bodies)


def _part_of(points: Integers, position: Floats, corner: Floats) -> Part:
    """Returns triangles (n, 3, 2) as the part of some points of one body, at positions (m, 2)."""
    vertex, number = np.unique(corner.reshape(-1, 2), axis=0, return_inverse=True)
    triangle = len(points) + number.reshape(-1, 3)
    every = np.concatenate([position, vertex])
    kept = np.ones(len(triangle), dtype=bool)
    return Part(every, points, triangle, _Triangles(every[triangle], triangle), kept)


class _Triangles:
    """Triangles to find positions in, as the triangulations of scipy are."""

    def __init__(self, corner: Floats, simplices: Integers) -> None:
        self._corner, self.simplices = corner, simplices

    def find_simplex(self, places: Floats) -> Integers:
        """Returns the triangles in which places (n, 2) lie, -1 where there is none."""
        found = np.full(len(places), -1, dtype=np.int64)
        low, high = self._corner.min(axis=(0, 1)), self._corner.max(axis=(0, 1))
        near = np.flatnonzero(((places >= low) & (places <= high)).all(axis=1))
        for number, corner in enumerate(self._corner):
            share = shares_of(np.broadcast_to(corner, (len(near), 3, 2)), places[near])
            found[near[(share >= -ON_EDGE).all(axis=1)]] = number
        return found
