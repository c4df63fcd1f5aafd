# SPDX-License-Identifier: BSD-3-Clause
"""Warnings of a run: what can be computed, and is probably not meant."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries import Boundary, Conditions, ImplicitConstraints
from tilth.boundaries.implicit.passage import (
    PASSAGE_TOLERANCE,
    border_warning,
    depth_behind,
    surface_behind,
)
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.comm import Communicator
from tilth.grid.background import Grid
from tilth.grid.keys import lattice_keys
from tilth.model import Model, NodeBoundary, PlaneBoundary
from tilth.model.fields import AXES
from tilth.mpm.points import MaterialPoints
from tilth.surface.protocol import BodySurface
from tilth.variation.tables import place_text

JUMP, NO_JUMP = 30.0, 0.01
"""Soil that moves so many times as far in a step as the boundaries that drive it, and by more than
this part of a cell, is warned of."""

NOT_AT_REST = 1e-3
"""Relative residual above which soil beside absorbing boundaries counts as not at rest."""

HARDLY_MOVING = 1e-4
"""Kinetic energy, relative to the elastic one, up to which what moves may stop unsaid."""

GIVEN_BY_CONTACT = 0.05
"""Energy that contact gives, relative to all other, above which the motion is not to be trusted."""

FARTHEST_APART = 0.6
"""Mean distance of points in cells, above which there are fewer than two in a cell."""


LEAST_DEPARTURE, FARTHEST_DEPARTURE = 0.1, 0.5
"""Prescribed motion of nodes in cells from which on forces are wrong, and the material is lost."""

ROUND_OFF = 1e-9
"""Share of a cell that does not count."""


class RunWarnings:
    """Collects warnings, each kind once.

    Attributes:
        texts: those not yet reported; who reports them empties the list.
    """

    def __init__(self) -> None:
        self.texts: list[str] = []
        self._said: dict[str, str] = {}
        self._new: list[tuple[str, str]] = []

    def note(self, key: str, text: str) -> None:
        """Warns, unless there was a warning with this key."""
        if key not in self._said:
            self._said[key] = text
            self.texts.append(text)
            self._new.append((key, text))

    def collect(self, comm: Communicator) -> None:
        """Notes what other processes warn of since the last call; all processes call it."""
        for other in comm.gathered(self._new):
            for key, text in list(other):
                self.note(key, text)
        self._new.clear()

    def go_on_from(self, last: RunWarnings) -> None:
        """Leaves out what was warned of in the last stage, now and later."""
        known = {text for key, text in self._said.items() if key in last._said}
        self.texts = [text for text in self.texts if text not in known]
        self._said = last._said | self._said

    def fallback(self, reason: str) -> None:
        """A linear system that multigrid left to the direct solver."""
        self.note(
            "fallback",
            f"multigrid did not solve a linear system ({reason}), so the direct solver did, which "
            "needs more time and memory; later systems may need it too, without a further warning",
        )

    def not_at_rest(self, residual: float) -> None:
        """Soil that is not at rest when absorbing boundaries take over the forces on it.

        residual: of the soil beside them, relative to the forces [-].
        """
        if residual > NOT_AT_REST:
            self.note(
                "not at rest",
                "absorbing boundaries take over the forces that hold the soil at rest, but it is "
                f"not in equilibrium when inertia begins (relative residual {residual:.1e}): begin "
                "with [[initial.stress]], or with a stage with inertia = false",
            )

    def stopped(self, stage: str, soil: float, bodies: float, stored: float) -> None:
        """Motion at the end of a stage with inertia that the next one, without, does not have.

        soil, bodies: kinetic energy; stored: elastic energy of the soil [force length].
        """
        if soil + bodies > HARDLY_MOVING * stored:
            self.note(
                f"stopped in {stage}",
                f"the stage {stage!r} has no inertia: what moves is at rest from its start on, and "
                f"its kinetic energy ({soil:.3g} of the soil, {bodies:.3g} of rigid bodies) is "
                "lost (numerical_dissipation); let it come to rest before if that is not meant",
            )

    def contact_gives(self, energies: Mapping[str, float], start: float) -> None:
        """Contact that closes and opens and so gives energy, as impacts do without damping.

        energies: by kind, see `ENERGY_KINDS`; start: before the first step [force length].
        """
        other = start + abs(energies["external_work"])
        given = -max(energies["contact_gaps"], energies["numerical_dissipation"])
        if given > GIVEN_BY_CONTACT * other:
            self.note(
                "contact gives",
                f"contact that closes and opens has added {given:.3g} to the energy, which was "
                f"{other:.3g} with all work (contact_gaps of energies.csv): what strikes a surface "
                'comes off it too fast; take scheme = "generalised_alpha" with a spectral_radius '
                "of 0 to 0.1",
            )

    def line_search(self, reason: str, time: float) -> None:
        """A step that is repeated."""
        self.note(
            "line search",
            f"Newton's iteration failed in the step to time {time:.6g} ({reason}); the step is "
            "repeated with a line search; later steps may need it too, without a further warning",
        )

    def crept(self, reason: str, time: float) -> None:
        """A step whose equilibrium was found by letting the soil creep."""
        self.note(
            "crept",
            f"Newton's method failed in the step to time {time:.6g} ({reason}); the soil was let "
            "go against a drag until it came to rest; later steps may need it too, without a "
            "further warning",
        )

    def falls(self, borne: float, time: float) -> None:
        """A step at whose end soil still falls; borne: residual relative to the forces [-]."""
        self.note(
            "falls",
            f"at time {time:.6g} some soil still falls or crumbles against a drag beside what "
            f"drives it: forces of {borne:.1e} of all are not in equilibrium; in later steps up to "
            "1e-4, without a further warning",
        )

    def repeated_cuts(self, step: int, cuts: int, causes: Sequence[str]) -> None:
        """A step that was shortened several times in a row; causes: the likely ones."""
        self.note(
            f"cuts by {causes[0][:20]}",
            f"step {step} was undone {cuts} times in a row; likely causes: {'; '.join(causes)}",
        )

    def relaxation(self, number: int, before: float, after: float) -> None:
        """A step without equilibrium beyond which soil moves until it is at rest."""
        self.note(
            f"relaxation {number}",
            f"relaxation {number}: from the equilibrium at time {before:.6g} the least step has "
            f"none; the soil moves with damped inertia under the loads of time {after:.6g} until "
            "it is at rest",
        )

    def few_points(self, points: MaterialPoints, grid: Grid, key: str) -> None:
        """Bodies with fewer than two points in a cell along an axis of a stage's new grid.

        key: of the grid in the case file.
        """
        for body, own in points.whole_bodies():
            apart = 2.0 * points.half_length[own].mean(axis=0)
            in_cells = 2.0 * points.half_length[own] / grid.sizes_at(points.position[own])
            if (in_cells.mean(axis=0) > FARTHEST_APART).any():
                sides = " x ".join(f"{size:.3g}" for size in apart)
                self.note(
                    f"few points of {body.name}",
                    f"{key}: the points of {body.name!r} are {sides} apart in the mean, more than "
                    "half a cell of this grid: one with one point has motions without strain; give "
                    "the body more points, or the grid larger cells",
                )

    def unpaired(self, model: Model, points: MaterialPoints, grid: Grid) -> None:
        """Bodies of different overlays in the same cells, without a contact pair."""
        paired = [frozenset(pair.bodies) for _, pair in model.acting_pairs]
        bodies = points.whole_bodies()
        for i, (body, own) in enumerate(bodies):
            for other, others in bodies[:i]:
                names = frozenset((body.name, other.name))
                if body.overlay == other.overlay or names in paired:
                    continue
                one, two = points.position[own], points.position[others]
                low, high = np.maximum(one.min(axis=0), two.min(axis=0)), one.max(axis=0)
                high = np.minimum(high, two.max(axis=0))
                if (grid.in_cells(low) - 1.0 > grid.in_cells(high) + 1.0).any():
                    continue
                cells, occupied = (
                    lattice_keys(np.floor(grid.in_cells(x)).astype(np.int64)) for x in (one, two)
                )
                if np.isin(cells, occupied).any():
                    self.note(
                        f"passage of {other.name} and {body.name}",
                        f"contact_pairs: the bodies {other.name!r} and {body.name!r} have come "
                        "into the same cells. They have no contact pair, but overlays "
                        "(nodes) of their own because of their contact with others, so that they "
                        f'pass through each other; declare a pair with bodies = ["{other.name}", '
                        f'"{body.name}"]',
                    )

    def departures(self, model: Model) -> None:
        """Grid planes and nodes whose prescribed motion takes the material away from them."""
        forces = any(each.quantity in ("reaction", "moment") for each in model.track)
        least = LEAST_DEPARTURE if forces else FARTHEST_DEPARTURE
        for i, boundary in enumerate(model.boundaries):
            if not isinstance(boundary, PlaneBoundary | NodeBoundary):
                continue
            if boundary.condition != "prescribed":
                continue
            far, cells, axis = max(_ways(boundary, model), default=(0.0, 0.0, ""), key=_in_cells)
            if cells <= least * (1.0 + ROUND_OFF):
                continue
            if isinstance(boundary, PlaneBoundary):
                where = f"nodes at {boundary.axis} = {boundary.at:g}"
            else:
                where = f"node at {place_text(np.asarray(boundary.at))}"
            effect = "it loses the material that moves away from them"
            if cells <= FARTHEST_DEPARTURE:
                effect = (
                    "the cells beside them are filled in part only, and tracked forces are wrong: "
                    "by 3.5, 7 and 23 % on an elastic block at 0.1, 0.2 and 0.4 of a cell"
                )
            self.note(
                f"motion of {boundary.name}",
                f"boundaries[{i}].displacement: the boundary {boundary.name!r} moves by up to "
                f"{far:g} along {axis}, {cells:.2g} of a cell, but it acts on the "
                f"{where} throughout: {effect}; for a boundary that moves "
                'with the soil choose type = "implicit"',
            )

    def places(
        self,
        boundaries: Sequence[Boundary],
        conditions: Conditions,
        constraints: ImplicitConstraints,
        keys: Mapping[str, str],
        time: float,
    ) -> None:
        """Boundaries that touch nothing, and what `ImplicitConstraints.warnings` finds.

        keys: of the boundaries in the case file, by name. time: at the start of the step.
        """
        active = constraints.active
        for boundary, touched in zip(boundaries, conditions.has_nodes, strict=True):
            key = f"place of {boundary.name}"
            if touched or key in self._said:
                continue
            self.note(
                key,
                f"boundary {boundary.name!r} touches no node of a cell with material: the nearest "
                f"one is {boundary.distance_from(active):.3g} away; correct its position "
                f"({keys[boundary.name]}), or leave it out",
            )
        for implicit in constraints.without_contact:
            key = f"place of {implicit.name}"
            if key in self._said or implicit.body_name is not None:
                continue
            distance = np.abs(implicit.distance(active.points.position, time)).min()
            remedy = f"correct its position ({implicit.key}.geometry), or leave it out"
            if implicit.declared.is_moving:
                remedy = f"unless it is to come to the soil later, {remedy}"
            self.note(
                key,
                f"boundary {implicit.name!r} is not in contact with soil: no material point is "
                f"next to it, the nearest is {distance:.3g} away; {remedy}",
            )
        for key, text in constraints.warnings():
            self.note(key, text)

    def bounds(self, counts: Mapping[str, int]) -> None:
        """Domains that `bound_domains` kept from shrinking or growing further."""
        texts = {
            "floor": "were kept at the least size, 0.001 of a cell",
            "cap": "were kept at the size of a cell: they no longer tile the material; "
            "more points per cell, or another domain_update, avoid this",
        }
        for key, count in counts.items():
            if count:
                self.note(key, f"the domains of {count} material points {texts[key]}")

    def depths(
        self,
        boundaries: Sequence[Implicit],
        points: MaterialPoints,
        surfaces: Mapping[str, BodySurface],
        time: float,
        grid: Grid,
    ) -> None:
        """Soil behind implicit boundaries, again where it has become twice as deep.

        And once soil that has come to the border of one.

        surfaces: tracked ones, by the names of their bodies.
        """
        small = PASSAGE_TOLERANCE * float(grid.cell_size.min())
        for boundary in boundaries:
            key = f"border of {boundary.name}"
            if key not in self._said and (text := border_warning(boundary, points, time, grid)):
                self.note(key, text)
            depth = depth_behind(boundary, points, time, grid)
            if depth <= small:
                continue
            self.note(
                _depth_key(boundary.name, depth, small),
                f"material points are up to {depth:.3g} behind the boundary {boundary.name!r} at "
                f"time {time:.6g}",
            )
        vertices = {name: surface.shape().position for name, surface in surfaces.items()}
        for name, boundary in product(vertices, boundaries):
            depth = surface_behind(boundary, vertices[name], time, grid)
            if depth > small:
                self.note(
                    _depth_key(f"surface of {name}, {boundary.name}", depth, small),
                    f"the surface of the body {name!r} is up to {depth:.3g} "
                    f"({depth / float(grid.cell_size.min()):.2g} of a cell) behind the boundary "
                    f"{boundary.name!r} at time {time:.6g}: the soil is held at other places than "
                    "it should be; compare a run with smaller cells, or in smaller steps",
                )

    def known_depth(self, name: str, depth: float, grid: Grid) -> None:
        """Leaves out the warnings of `depths` for soil up to so deep [length] behind a boundary."""
        small = PASSAGE_TOLERANCE * float(grid.cell_size.min())
        while depth > small:
            self._said[_depth_key(name, depth, small)] = ""
            depth *= 0.5

    def jump(
        self,
        moved: Floats,
        driven: float,
        points: MaterialPoints,
        cell_size: Floats,
        time: float,
        predictor: bool,
    ) -> None:
        """Soil that moves much further in a step than the boundaries that alone drive it.

        moved: displacement of the points in the step [length], shape (n, dim). driven: how far the
        boundaries move in it [length]. predictor: whether the analysis has one.
        """
        point = int((moved**2).sum(axis=1).argmax())
        way = float(np.linalg.norm(moved[point]))
        if driven > 0.0 and way > max(JUMP * driven, NO_JUMP * float(cell_size.min())):
            self.note(
                "jump",
                f"in the step to time {time:.6g} material point {points.point_id[point]} moves by "
                f"{way:.3g}, {way / driven:.0f} times as far as any boundary, and no load changes: "
                "the soil slides by itself, or Newton's iteration ended in another equilibrium "
                "than the one that it followed; compare a run in smaller steps"
                f"{'' if predictor else ' or with predictor = true'}",
            )

    def strayed(self, way: float, explained: float) -> None:
        """A step whose motion neither its loads and boundaries nor its guess explain.

        way: greatest motion of a node [length]. explained: what `attempts.explained_motion` allows.
        """
        self.note(
            "strayed",
            f"a node moves by {way:.3g} in a step whose loads and boundaries explain not more than "
            f"{explained:.3g}, with the predictor and without it: the soil begins to slide or tip "
            'by itself; smaller steps show how, and inertia or beyond_limit = "relax" where to',
        )


def _ways(
    boundary: PlaneBoundary | NodeBoundary, model: Model
) -> Iterator[tuple[float, float, str]]:
    """Yields how far a motion takes soil away from nodes, [length] and in cells, and its axis."""
    factor = max(abs(factor) for _, factor in model.load_curve(boundary).table)
    for axis, value in boundary.prescribed(model.dimension).items():
        name = AXES[axis]
        if isinstance(boundary, NodeBoundary):
            place = boundary.at[axis]
        elif name == boundary.axis:
            place = boundary.at
        elif boundary.range is not None and name in boundary.range:
            place = boundary.range[name][0]
        else:
            continue  # soil that moves along the whole plane stays on it
        far = abs(value) * factor
        yield far, far / model.grid_axis(axis).size_at(place), name


def _in_cells(way: tuple[float, float, str]) -> float:
    return way[1]


def _depth_key(name: str, depth: float, small: float) -> str:
    """Returns the key of the warning of soil behind a boundary: a new one for twice the depth."""
    return f"depth of {math.floor(math.log2(depth / small))} behind {name}"
