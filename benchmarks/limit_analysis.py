# SPDX-License-Identifier: BSD-3-Clause
"""Bounds of limit loads of weightless clay in plane strain, by finite elements and linear programs.

The clay is of Tresca's type, shear strength 1: sqrt((s_xx - s_yy)^2 + 4 s_xy^2) <= 2. Load and
dissipation are per length.

* Upper bound: velocities are quadratic in straight triangles, so that the strain rate is linear in
  each and its convex dissipation is at most what its corners give (A. Makrodimopoulos,
  C.M. Martin, Upper bound limit analysis using simplex strain elements, 2007). The velocity field
  is the optimum for a yield polygon around the circle; the bound is the dissipation of that field
  by the circle itself.
* Lower bound: stresses are linear in each triangle and jump between them, tractions do not; the
  yield polygon lies inside the circle (S.W. Sloan, Lower bound limit analysis using finite
  elements and linear programming, 1988).

A rigid body pushes the soil with the velocity V on the part "contact" of the boundary. Soil may
separate from it, or may not; the shear stress on it is at most the adhesion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from limit_mesh import Mesh, Snap, refined
from scipy.optimize import linprog

from tilth.arrays import Floats, Integers

SIDES = 24
"""Of the yield polygons."""


@dataclass(frozen=True)
class Body:
    """The rigid body that pushes the soil.

    Attributes:
        velocity: of the body, a unit vector, shape (2,).
        adhesion: largest shear stress on it over the strength of the clay [-].
        separates: whether no tension acts on it.
        normal: unit normals into the soil at points of its surface, (n, 2) -> (n, 2).
    """

    velocity: tuple[float, float]
    adhesion: float
    separates: bool
    normal: Callable[[Floats], Floats]


@dataclass
class Program:
    """A linear program under construction: columns with costs and bounds, rows."""

    columns: int = 0
    cost: list[Floats] = field(default_factory=list)
    bounds: list[Floats] = field(default_factory=list)
    equal: list[tuple[sp.coo_array, Floats]] = field(default_factory=list)
    below: list[tuple[sp.coo_array, Floats]] = field(default_factory=list)

    def add(self, count: int, cost: float | Floats, lower: float, upper: float) -> Integers:
        """Adds columns; returns their numbers."""
        number = self.columns + np.arange(count)
        self.columns += count
        self.cost.append(np.broadcast_to(np.asarray(cost, dtype=float), count).copy())
        self.bounds.append(np.tile([lower, upper], (count, 1)))
        return number

    def row(self, kind: str, number: Integers, factor: Floats, right: Floats | float) -> None:
        """Adds rows, sum of factor times column (n, k) = or <= right (n,)."""
        rows = np.broadcast_to(np.arange(len(number))[:, None], number.shape)
        entries = (np.broadcast_to(factor, number.shape).ravel(), (rows.ravel(), number.ravel()))
        values = np.broadcast_to(np.asarray(right, dtype=float), len(number))
        getattr(self, kind).append((entries, values, len(number)))

    def solve(self) -> tuple[Floats, float]:
        """Returns the columns at the least cost, and this cost."""

        def stacked(blocks):
            if not blocks:
                return None, None
            matrix = sp.vstack(
                [sp.coo_array(entries, shape=(n, self.columns)) for entries, _, n in blocks]
            )
            return matrix.tocsr(), np.concatenate([values for _, values, _ in blocks])

        a_equal, b_equal = stacked(self.equal)
        a_below, b_below = stacked(self.below)
        found = linprog(
            np.concatenate(self.cost),
            A_ub=a_below,
            b_ub=b_below,
            A_eq=a_equal,
            b_eq=b_equal,
            bounds=np.concatenate(self.bounds),
            method="highs-ipm",
        )
        assert found.x is not None, found.message
        return found.x, float(found.fun)


def _midside(mesh: Mesh) -> tuple[Integers, Floats, dict[tuple[int, int], int]]:
    """Node numbers (m, 6) of quadratic triangles, all nodes, edge -> its middle node."""
    nodes = [tuple(each) for each in mesh.nodes]
    middle: dict[tuple[int, int], int] = {}
    extra = np.empty((len(mesh.triangles), 3), dtype=np.int64)
    for number, triangle in enumerate(mesh.triangles.tolist()):
        for i in range(3):
            a, b = triangle[i], triangle[(i + 1) % 3]
            key = (min(a, b), max(a, b))
            if key not in middle:
                middle[key] = len(nodes)
                nodes.append(tuple(0.5 * (mesh.nodes[a] + mesh.nodes[b])))
            extra[number, i] = middle[key]
    return np.concatenate([mesh.triangles, extra], axis=1), np.array(nodes), middle


def _area_gradients(mesh: Mesh) -> Floats:
    """Gradients of the three area coordinates, shape (m, 3, 2)."""
    corner = mesh.corners()
    edge = np.roll(corner, -2, axis=1) - np.roll(corner, -1, axis=1)
    return np.stack([-edge[..., 1], edge[..., 0]], axis=-1) / (2.0 * mesh.areas())[:, None, None]


def _corner_gradients(mesh: Mesh) -> Floats:
    """Gradients of the six quadratic functions at the three corners, shape (m, 3, 6, 2)."""
    slope = _area_gradients(mesh)
    result = np.zeros((len(slope), 3, 6, 2))
    for at in range(3):
        for i in range(3):
            result[:, at, i] = (3.0 if i == at else -1.0) * slope[:, i]
            j = (i + 1) % 3  # the node between i and j: 4 L_i L_j
            if i == at:
                result[:, at, 3 + i] += 4.0 * slope[:, j]
            if j == at:
                result[:, at, 3 + i] += 4.0 * slope[:, i]
    return result


def upper_bound(mesh: Mesh, body: Body, held: dict[str, str]) -> tuple[float, Floats]:
    """Returns the upper bound of the load and the dissipation of the triangles, shape (m,).

    held: part of the boundary -> components of the velocity that vanish there, such as "x".
    """
    triangles, nodes, middle = _midside(mesh)
    program = Program()
    velocity = program.add(2 * len(nodes), 0.0, -np.inf, np.inf).reshape(-1, 2)
    gradient, weight = _corner_gradients(mesh), np.repeat(mesh.areas() / 3.0, 3)
    u, v = (velocity[triangles[:, None, :]][..., i].repeat(3, axis=1) for i in (0, 1))
    u, v = u.reshape(-1, 6), v.reshape(-1, 6)
    along_x, along_y = gradient.reshape(-1, 6, 2)[..., 0], gradient.reshape(-1, 6, 2)[..., 1]
    both = np.concatenate([u, v], axis=1)
    program.row("equal", both, np.concatenate([along_x, along_y], axis=1), 0.0)
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    count = len(both)
    rate = np.stack([program.add(count, weight, 0.0, np.inf) for _ in range(SIDES)], axis=-1)
    parts = ((along_x, -along_y, np.cos(angle)), (along_y, along_x, np.sin(angle)))
    for of_u, of_v, direction in parts:
        factor = np.concatenate([of_u, of_v, np.broadcast_to(-direction, (count, SIDES))], axis=1)
        program.row("equal", np.concatenate([both, rate], axis=1), factor, 0.0)
    bounds = program.bounds[0]
    contact, slips = [], []
    for (a, b), part in mesh.boundary.items():
        line = (a, middle[min(a, b), max(a, b)], b)
        if part == "contact":
            contact.append(line)
        for axis in held.get(part, ""):
            bounds[velocity[list(line), "xy".index(axis)]] = 0.0
    edges = np.array(contact)
    touched = np.unique(edges)
    normal, motion = body.normal(nodes[touched]), np.array(body.velocity)
    kind = "below" if body.separates else "equal"
    program.row(kind, velocity[touched], -normal, -(normal @ motion))
    if body.adhesion > 0.0:
        ends = nodes[edges[:, 2]] - nodes[edges[:, 0]]
        length = np.hypot(*ends.T)
        tangent = ends / length[:, None]
        for share in ((1.0, 0.0, 0.0), (-0.5, 2.0, -0.5), (0.0, 0.0, 1.0)):  # Bernstein's
            cost = body.adhesion * length / 3.0
            slip = [program.add(len(edges), cost, 0.0, np.inf) for _ in range(2)]
            number = np.concatenate([velocity[edges].reshape(-1, 6), np.stack(slip, -1)], axis=1)
            factor = np.concatenate(
                [s * tangent for s in share] + [np.tile([-1.0, 1.0], (len(edges), 1))], axis=1
            )
            program.row("equal", number, factor, tangent @ motion)
            slips.append((slip, cost))
    solution, _ = program.solve()
    place = solution[velocity][triangles]
    moved = np.einsum("taij,tic->tajc", gradient, place)  # d u_c / d x_j at the corners
    size = np.hypot(moved[..., 0, 0] - moved[..., 1, 1], moved[..., 0, 1] + moved[..., 1, 0])
    dissipation = (mesh.areas() / 3.0)[:, None] * size
    on_face = sum(cost @ np.abs(solution[p] - solution[m]) for (p, m), cost in slips)
    return float(dissipation.sum() + on_face), dissipation.sum(axis=1)


def lower_bound(mesh: Mesh, body: Body, stress_free: dict[str, str]) -> float:
    """Returns the lower bound of the load.

    stress_free: part of the boundary -> "xy" where no traction acts, or "x" or "y" where this
        component of the traction, along the boundary, vanishes (symmetry).
    """
    program = Program()
    count = len(mesh.triangles)
    stress = program.add(9 * count, 0.0, -np.inf, np.inf).reshape(count, 3, 3)  # corner, xx yy xy
    slope = _area_gradients(mesh)
    for x, y in ((0, 2), (2, 1)):
        number = np.concatenate([stress[:, :, x], stress[:, :, y]], axis=1)
        program.row("equal", number, np.concatenate([slope[..., 0], slope[..., 1]], axis=1), 0.0)
    angle = 2.0 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
    flat = stress.reshape(-1, 3)
    for c, s in zip(np.cos(angle), np.sin(angle), strict=True):
        program.row("below", flat, np.array([c, -c, 2.0 * s]), 2.0 * np.cos(np.pi / SIDES))
    owner = {}
    for number, triangle in enumerate(mesh.triangles.tolist()):
        for i in range(3):
            owner[triangle[i], triangle[(i + 1) % 3]] = (number, i)
    inner = [(each, owner[edge[::-1]]) for edge, each in owner.items() if edge[::-1] in owner]
    inner = [(one, other) for one, other in inner if one < other]
    (t, i), (s, j) = (np.array(each).T for each in zip(*inner, strict=True))
    ends = mesh.corners()[t, (i + 1) % 3] - mesh.corners()[t, i]
    normal = np.stack([ends[:, 1], -ends[:, 0]], axis=-1) / np.hypot(*ends.T)[:, None]

    def traction(axis: int, n: Floats) -> Floats:
        zero = np.zeros(len(n))
        of = [n[:, 0], zero, n[:, 1]] if axis == 0 else [zero, n[:, 1], n[:, 0]]
        return np.stack(of, axis=-1)

    for here, there in ((i, (j + 1) % 3), ((i + 1) % 3, j)):
        number = np.concatenate([stress[t, here], stress[s, there]], axis=1)
        for axis in (0, 1):
            factor = np.concatenate([traction(axis, normal), -traction(axis, normal)], axis=1)
            program.row("equal", number, factor, 0.0)
    cost = program.cost[0]
    for edge, part in mesh.boundary.items():
        triangle, i = owner[edge]
        along = mesh.nodes[edge[1]] - mesh.nodes[edge[0]]
        length = float(np.hypot(*along))
        n = np.array([[along[1], -along[0]]]) / length  # out of the soil
        of = [traction(axis, n)[0] for axis in (0, 1)]
        for corner in (i, (i + 1) % 3):
            number = stress[triangle, corner][None]
            for axis in stress_free.get(part, ""):
                program.row("equal", number, of["xy".index(axis)][None], 0.0)
            if part == "contact":
                across = n[0, 0] * of[0] + n[0, 1] * of[1]
                shear = -n[0, 1] * of[0] + n[0, 0] * of[1]
                if body.separates:
                    program.row("below", number, across[None], 0.0)
                kind = "below" if body.adhesion else "equal"
                program.row(kind, number, shear[None], body.adhesion)
                if body.adhesion:
                    program.row(kind, number, -shear[None], body.adhesion)
                # the soil pushes back with minus the traction that acts on it
                work = body.velocity[0] * of[0] + body.velocity[1] * of[1]
                cost[number[0]] -= 0.5 * length * work
    return -program.solve()[1]


@dataclass(frozen=True)
class Problem:
    """A limit load: a first mesh and what acts on its boundary.

    Attributes:
        mesh: first, coarse.
        body: pushes on the part "contact".
        held, stress_free: by part of the boundary, see `upper_bound` and `lower_bound`.
        snap: moves nodes that are new on the boundary.
        multiple: load of the whole over that of the part that is modelled.
    """

    mesh: Mesh
    body: Body
    held: dict[str, str]
    stress_free: dict[str, str]
    snap: Snap = lambda part, point: point
    multiple: float = 2.0


def bounds(
    problem: Problem, triangles: int, report: Callable[[str], None] = lambda text: None
) -> tuple[float, float]:
    """Returns lower and upper bound of the load on a mesh of about so many triangles.

    The triangles with the largest share of the dissipation, together half of it, are bisected again
    and again.
    """
    mesh = problem.mesh
    while True:
        upper, dissipation = upper_bound(mesh, problem.body, problem.held)
        report(f"    {len(mesh.triangles)} triangles: at most {problem.multiple * upper:.4f}")
        if len(mesh.triangles) >= triangles:
            break
        order = np.argsort(-dissipation)
        share = np.cumsum(dissipation[order]) / dissipation.sum()
        most = max(
            1, min(int((share < 0.7).sum()), (triangles * 6 // 5 - len(mesh.triangles)) // 2)
        )
        mesh = refined(mesh, order[:most], problem.snap)
    lower = lower_bound(mesh, problem.body, problem.stress_free)
    return problem.multiple * lower, problem.multiple * upper
