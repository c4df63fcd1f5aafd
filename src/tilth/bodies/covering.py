# SPDX-License-Identifier: BSD-3-Clause
"""How often a closed surface covers a place: once or not at all.

The volume that a closed surface encloses by the divergence theorem, as the sum of the volumes of a
mesh's elements, counts a place as often as it is covered. Shells that overlap or are turned to the
wrong side, and elements that overlap, cover places twice or less than not at all. They are found
along vertical lines: upwards, the number grows by one where a line enters and falls where it
leaves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.vertical_lines import crossed_by_lines
from tilth.errors import BadInput
from tilth.variation.tables import place_text

LINES = 4096
"""Vertical lines that are spread over a body in plan."""

MOST_LINES = 4096
"""Vertical lines through single triangles or between nodes, at most."""

PLASTIC = (0.7548776662466927, 0.5698402909980532)
"""Inverse powers of the plastic number: multiples of them spread evenly over a square."""

WITHIN = (0.41, 0.34, 0.25)
"""Barycentric coordinates of a line through a triangle, on no line of symmetry."""

STEEP = 1e-3
"""Triangles with a smaller area in plan, over their area, get no line of their own."""

SLACK = 1e-6
"""Pieces of lines shorter than this, over the extent, are round-off of a file."""


@dataclass(frozen=True)
class Fault:
    """A place that is covered more than once, or less than not at all.

    Attributes:
        place: in the middle of the longest such piece of a line [length], shape (d,).
        times: how often it is covered [-].
        length: of the piece [length].
    """

    place: Floats
    times: int
    length: float


def require_shells_nested(vertex: Floats, node: Integers) -> None:
    """Refuses a closed surface that does not enclose each place once or not at all.

    Args:
        vertex: [length], shape (m, 3).
        node: numbers of the triangles' vertices, normals outwards, shape (n, 3).

    Raises:
        BadInput: without key; says which shells overlap, or are turned to the wrong side.
    """
    corner = vertex[node]
    at = lines_in_space(corner)
    line, _, height, sign = crossed_by_lines(corner, at)
    fault = fault_along(line, height, sign, at, float(np.ptp(vertex, axis=0).max()))
    if fault is not None:
        raise BadInput(*_wrong_shells(vertex, node, fault))


def fault_along(
    line: Integers, height: Floats, sign: Floats, at: Floats, extent: float
) -> Fault | None:
    """Returns the longest piece of vertical lines that is not covered once or not at all.

    Args:
        line, height, sign: of the crossings, as of `crossed_by_lines`.
        at: horizontal coordinates of the lines, shape (n, d - 1).
        extent: of the body [length].
    """
    whole = np.bincount(line, sign, len(at)) == 0.0  # else it runs through an edge
    kept = whole[line]
    line, height, sign = line[kept], height[kept], sign[kept]
    order = np.lexsort((height, line))
    line, height, sign = line[order], height[order], sign[order]
    times = -np.cumsum(sign)[:-1]  # each line ends outside
    length = np.where(np.diff(line) == 0, np.diff(height), 0.0)
    length = np.where((times < -0.5) | (times > 1.5), length, 0.0)
    if not len(length) or length.max() <= SLACK * extent:
        return None
    most = int(length.argmax())
    place = np.append(at[line[most]], height[most] + 0.5 * length[most])
    return Fault(place, round(float(times[most])), float(length[most]))


def lines_in_space(corner: Floats) -> Floats:
    """Returns places in plan of lines: evenly over triangles (n, 3, 3), and through some of them.

    They avoid lines of symmetry, on which there are edges. Shape (m, 2).
    """
    plan = corner[..., :2]
    lower, upper = plan.min(axis=(0, 1)), plan.max(axis=(0, 1))
    share = np.mod(np.arange(1, LINES + 1)[:, None] * np.array(PLASTIC), 1.0)
    twice = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    level = np.flatnonzero(np.abs(twice[:, 2]) > STEEP * np.linalg.norm(twice, axis=1))
    chosen = level[:: -(-len(level) // MOST_LINES) or 1]
    through = np.einsum("c,nci->ni", np.array(WITHIN), plan[chosen])
    return np.concatenate([lower + share * (upper - lower), through])


def _wrong_shells(vertex: Floats, node: Integers, fault: Fault) -> tuple[str, str]:
    """Returns what is wrong with the shells of a surface at a place, and the remedy.

    Arguments as of `require_shells_nested`.
    """
    corner, shell = vertex[node], _shells(node)
    line, triangle, height, sign = crossed_by_lines(corner, fault.place[None, :2])
    above = (height > fault.place[2]) & (line == 0)
    own = shell[triangle[above]]
    number = int(shell.max()) + 1
    times = np.bincount(own, sign[above], number)
    where = place_text(fault.place)
    wrong = np.flatnonzero(times * np.sign(fault.times) > 0.5).tolist()
    if number == 1 or (np.abs(times) > 1.5).any() or not wrong:
        return (
            f"the surface passes through itself: the material at {where} would count "
            f"{fault.times} times",
            "repair the mesh where it does, or draw the parts as bodies of their own",
        )
    names = [_shell_text(corner[shell == k], k, number) for k in wrong]
    if fault.times < 0:
        return (
            f"{names[0]} has its triangles turned inwards, as the surface of a cavity has, but is "
            f"not within the body at {where}: its volume would be taken away there",
            "turn the triangles of this shell over if it is a part of the body, move it to within "
            "the body if it is a cavity, or leave it out",
        )
    nested = [(i, k) for i in wrong for k in wrong if i != k and _within(vertex, node, shell, i, k)]
    if nested:
        inner = _shell_text(corner[shell == nested[0][0]], nested[0][0], number)
        return (
            f"{inner} is within another one and turned outwards as that is: the material in it, "
            f"at {where}, would count {fault.times} times",
            "turn the triangles of the inner shell over if it is a cavity, or leave it out",
        )
    return (
        f"{names[0]} overlaps {names[1]} at {where}: the material there would count "
        f"{fault.times} times",
        "unite the parts before they are saved, or give each a file and a body of its own",
    )


def _within(vertex: Floats, node: Integers, shell: Integers, inner: int, outer: int) -> bool:
    """Returns whether every vertex of one shell is within another."""
    own = vertex[np.unique(node[shell == inner])]
    around = vertex[node[shell == outer]]
    extent = float(np.ptp(vertex, axis=0).max())
    line, _, height, sign = crossed_by_lines(around, own[:, :2] + 1e-9 * extent * np.array(PLASTIC))
    above = height > own[line, 2]
    return bool((np.bincount(line[above], sign[above], len(own)) > 0.5).all())


def _shells(node: Integers) -> Integers:
    """Returns the number of each triangle's shell: those that edges connect, in order."""
    from scipy.sparse import coo_array  # take 0.2 s: only where there is such a surface
    from scipy.sparse.csgraph import connected_components

    ends = node[:, [0, 1, 1, 2]].reshape(-1, 2)
    links = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), 2 * (int(node.max()) + 1,))
    group = connected_components(links, directed=False)[1][node[:, 0]]
    _, first, number = np.unique(group, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[number.ravel()]


def _shell_text(corner: Floats, number: int, of: int) -> str:
    """Returns a shell's number, from 1, and where it is; corner: of its triangles, (n, 3, 3)."""
    lower, upper = corner.min(axis=(0, 1)), corner.max(axis=(0, 1))
    return (
        f"shell {number + 1} of {of} ({len(corner)} triangles, from {place_text(lower)} to "
        f"{place_text(upper)})"
    )
