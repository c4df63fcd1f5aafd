# SPDX-License-Identifier: BSD-3-Clause
"""How much the results of two copies of a model may differ.

The reasons are in docs/decisions/0042-metamorphic-tests.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from metamorphic.compare import Scales
from metamorphic.models import CELL
from metamorphic.subject import Subject

DIFFERENCE = 1e-6
"""Largest relative difference of two copies that differ by round-off: the tolerance of Newton's
iteration, 1e-11, times the greatest condition number with ghost stabilisation of less than 1e5."""

OF_PATCHES = {2: 0.25, 3: 1.0}
"""The same where the patches of boundaries are others, by the number of directions: a cell over
the least extent of the surfaces that hold the soil, in the plane its width, in space its depth."""

OF_COMMON_NODES = 1.0
"""The same where two surfaces are less than two cells apart and have nodes in common: each node is
for a patch of one of them only, and the patches that are left to the other one may be as wide as it
is. Five patches of a base became two below a footing, of 0.11 and 1.71 of its width of 1.83."""

OF_BODY = 0.5
"""The same where a round body alone moves the soil, the weight being in balance at the start, over
its radius in cells: the surface is as wide as the body, and the mean gap of other patches is
another one. A circle of 0.8 cells has patches of 0.37 and 0.45; turned, 0.35 and 0.47 in length."""

OF_DIAGONALS = 0.125
"""The same of a surface load in space that has moved, over the displacement in cells: squares of a
surface, half a cell wide at most, have a diagonal that does not turn with them. At the middle of
one the two differ by half of its area times the twist of the displacement, the change of a strain
within a cell over its width: an eighth of a cell times the strain, and so the place of the load.
With the triangles turned, too, the copies of a model that differ by 4e-5 agree to 1e-15."""

AT_REST, DIES_OUT = 0.2, 0.5
"""Motion of soil in a stage in which nothing changes, as a share of its displacement; and in
further such steps, as a share of that motion: the change of basis is of the order of the strain."""

OF_STRIPS = 1.0
"""The same where a narrow strip of soil has come over a line of the grid: it moves by its strain
out of balance times a cell (`hang_over`), in soil a few cells high as far as all of it has."""

STILL = 1e-3
"""Motion of soil at rest in a step that counts as none, as a share of its displacement: of the
order of the square of the strain."""

HALVED, LEAST_OF_HALVED = 1.0, 1e-3
"""Greatest ratio of what changes when steps are halved once more and when they are halved; and a
relative difference that is small enough in any case."""

UNLOADED, LEFT_OF_HALVED = 0.2, 0.75
"""Share of the displacement that is left of an elastic load cycle: of the order of the motion of a
step in cells, as the basis is another one on the way back; and what is left of it with steps of
half the size, where an error of the first order is halved."""

STEP_ENERGY = 1.0
"""Error of the work of a step over that work, divided by the displacement in cells."""

OF_WATER = 0.1
"""The same of water in soil without stress at the start, over the energies: its uplift acts at
once, and of the work on a motion through which a force is constant one half is stored. That is the
square of the share that it has in the loads."""

CONTACT_ENERGY = 0.5
"""The same of contact, over the change of its force times the motion in a step: a force that begins
in it is taken to grow from its start on, but may act through all of the motion, or through none."""

CROSSING_ENERGY = 0.5
"""The same of points that come into another cell with linear functions, and of narrow strips over a
line of the grid, over the forces times the motion in a step: these points act on other nodes, and
are in balance again after this motion."""

LEAST_DISSIPATION = 1e-9
"""Negative dissipation that is round-off, as a share of the energies."""

LARGEST_GAP = 0.25
"""Largest gap between two bodies that is carried in contact [cells]: the moments of the forces on
the two differ by it (docs/theory/contact.md)."""


def has_patches(subject: Subject) -> bool:
    """Whether conditions of a model hold means over patches of a surface."""
    entries = subject.entries
    of_surfaces = any(
        each["type"] == "implicit" or each["condition"] == "absorbing"
        for each in entries["boundaries"]
    )
    return of_surfaces or "rigid_bodies" in entries or "contact_pairs" in entries


def of_patches(subject: Subject) -> float:
    """Largest relative difference of copies on grids that are turned or mirrored.

    Motion with inertia keeps the differences of all steps.
    """
    if not has_patches(subject):
        return DIFFERENCE
    steps = len(subject.run.moments) if "inertia" in subject.entries["analysis"] else 1
    heights = sorted(_heights(subject))
    common = any(above - below < 1.999 * CELL for below, above in pairwise(heights))
    bound = OF_COMMON_NODES if common else OF_PATCHES[subject.dim]
    return max(bound, _of_body(subject)) * steps


def _of_body(subject: Subject) -> float:
    entries = subject.entries
    if "initial" not in entries or "stages" in entries or len(entries["loads"]) > 1:
        return 0.0
    return _of_width(subject)


def _of_width(subject: Subject) -> float:
    bodies = subject.entries.get("rigid_bodies", ())
    return max((OF_BODY * CELL / body["geometry"]["radius"] for body in bodies), default=0.0)


def of_touch(subject: Subject) -> float:
    """Largest motion of soil at rest, over its displacement, after a step in which it was touched.

    A run of one step in which a round body has come into contact: the patches of this step are of
    soil that was not yet in contact, and those of the next one others. As `OF_BODY`.
    """
    return _of_width(subject) if len(subject.run.moments) == 1 else 0.0


def of_images(subject: Subject) -> float:
    """Largest relative difference of turned or mirrored copies: of patches or diagonals."""
    return max(of_patches(subject), _of_diagonals(subject))


def _of_diagonals(subject: Subject) -> float:
    loads, steps = subject.entries["loads"], len(subject.run.moments)
    if subject.dim == 2 or steps < 2 or all(each["type"] != "surface" for each in loads):
        return DIFFERENCE
    return max(DIFFERENCE, OF_DIAGONALS * Scales.of(subject.run).length / CELL)


def _heights(subject: Subject) -> Iterator[float]:
    """Yields where the surfaces with patches are at the start [length]."""
    entries = subject.entries
    for boundary in entries["boundaries"]:
        if boundary["type"] == "implicit":
            geometry = boundary["geometry"]
            yield geometry["point" if "point" in geometry else "centre"][-1]
    for body in entries.get("rigid_bodies", ()):
        yield body["centre"][-1] - body["geometry"]["radius"]
    for pair in entries.get("contact_pairs", ()):
        upper = next(each for each in entries["bodies"] if each["name"] == pair["bodies"][0])
        yield upper["shape"]["lower"][-1]


def of_stress(subject: Subject, bound: float) -> float:
    """Largest relative difference of stresses where that of displacements and forces is `bound`.

    Other patches move what happens beside them by up to a cell. A cell over the width is the change
    of what changes evenly over it. A stress may change more within a cell, as at the free end of
    soil on a rough base, where friction takes up all of the horizontal stress.
    """
    if bound <= DIFFERENCE or not has_patches(subject):
        return bound
    run, largest = subject.run, bound
    for moment in run.moments:
        way = np.abs(moment.position[:, None] - moment.position).max(axis=2)
        change = np.abs(moment.stress[:, None] - moment.stress).max(axis=2)
        largest = max(largest, float(change[way <= CELL].max()) / Scales.of(run).stress)
    return largest


def by_round_off(subject: Subject) -> float:
    """Largest relative difference of copies that differ by round-off.

    Where the soil ends on grid lines it decides what of a surface is touched, and so the patches.
    """
    return of_patches(subject) if ends_on_lines(subject) else DIFFERENCE


def ends_on_lines(subject: Subject) -> bool:
    """Whether soil ends on grid lines, but for the one on which it is held at x = 0."""
    names = [boundary["name"] for boundary in subject.entries["boundaries"]]
    return subject.choice["places"] == "regular" or "right" in names
