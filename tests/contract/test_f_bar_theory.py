# SPDX-License-Identifier: BSD-3-Clause
"""docs/theory/f_bar.md once more, slowly: the assumed gradient, and the potential of the force."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from itertools import permutations, product

import numpy as np
import pytest
import scipy.linalg
from readings import some_of
from small_problems import (
    BASES,
    CORNER_BASES,
    ELASTIC,
    KINDS,
    SPACINGS,
    Laboratory,
    block_entries,
    jittered_points,
    spaced,
    tensor,
)

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.grid.background import Grid

pytestmark = pytest.mark.slow

Place = tuple[int, ...]

LAME = ELASTIC["young_modulus"] * ELASTIC["poisson_ratio"]
LAME /= (1.0 + ELASTIC["poisson_ratio"]) * (1.0 - 2.0 * ELASTIC["poisson_ratio"])
SHEAR = ELASTIC["young_modulus"] / (2.0 + 2.0 * ELASTIC["poisson_ratio"])


def simplices(corner: Floats) -> list[Floats]:
    """Triangles or tetrahedra of a domain with corners (2^dim, dim), x fastest."""
    dim = corner.shape[1]
    found = []
    for order in permutations(range(dim)):
        steps = np.cumsum([0] + [2**k for k in order])
        found.append(corner[steps])
    return found


def volume_of(simplex: Floats) -> float:
    return float(abs(np.linalg.det(simplex[1:] - simplex[0]))) / (2.0 if len(simplex) == 3 else 6.0)


def ends(place: Place, grid: Grid) -> Floats:
    """The lowest and the highest corner of a cell, shape (2, dim)."""
    return grid.position(np.array([place, np.add(place, 1)], dtype=float))


def cell_at(x: Floats, grid: Grid) -> Place:
    """The cell that contains a position."""
    return tuple(np.floor(grid.in_cells(x)).astype(int).tolist())


def below(simplex: Floats, axis: int, side: float, at: float) -> list[Floats]:
    """The part of a simplex where side * (x[axis] - at) <= 0, as simplices: edges are split."""
    height = side * (simplex[:, axis] - at)
    if (height <= 0.0).all():
        return [simplex]
    if (height >= 0.0).all():
        return []
    low, high = int(height.argmin()), int(height.argmax())
    share = height[low] / (height[low] - height[high])
    place = simplex[low] + share * (simplex[high] - simplex[low])
    place[axis] = at
    lower, upper = simplex.copy(), simplex.copy()
    lower[high] = upper[low] = place
    return below(lower, axis, side, at) + below(upper, axis, side, at)


def clipped(simplex: Floats, place: Place, grid: Grid) -> list[Floats]:
    """The part of a simplex in a cell, as simplices."""
    found = [simplex]
    for axis, (lower, upper) in enumerate(ends(place, grid).T):
        for side, at in ((-1.0, lower), (1.0, upper)):
            found = [part for each in found for part in below(each, axis, side, at)]
    return found


def parts_of_domain(corner: Floats, grid: Grid) -> list[tuple[Place, Floats]]:
    """Simplices of a domain, each with its cell."""
    parts = []
    for simplex in simplices(corner):
        low = np.floor(grid.in_cells(simplex.min(axis=0))).astype(int)
        high = np.ceil(grid.in_cells(simplex.max(axis=0))).astype(int)
        for place in product(*map(range, low, high)):
            parts += [(place, part) for part in clipped(simplex, place, grid)]
    return parts


def hats(place: Place, x: Floats, grid: Grid) -> dict[Place, tuple[float, Floats]]:
    """Value and gradient of the functions of a cell's corners."""
    dim = len(place)
    lower, upper = ends(place, grid)
    size = upper - lower
    local = (x - lower) / size
    corners = list(product((0, 1), repeat=dim))
    sign = np.where(np.array(corners) == 1, 1.0, -1.0)
    hat = np.where(sign > 0.0, local, 1.0 - local)
    value = hat.prod(axis=1)
    slope = sign / size
    for k in range(dim):
        slope[:, k] *= hat[:, [other for other in range(dim) if other != k]].prod(axis=1)
    nodes = [tuple(p + c for p, c in zip(place, corner, strict=True)) for corner in corners]
    return {node: (float(value[i]), slope[i]) for i, node in enumerate(nodes)}


def quadrature(simplex: Floats) -> list[tuple[float, Floats]]:
    """Weights, sum 1, and places of a rule that is exact for quadratic functions."""
    dim = simplex.shape[1]
    at_vertex, at_centroid = 1.0 / ((dim + 1) * (dim + 2)), (dim + 1) / (dim + 2)
    return [(at_vertex, x) for x in simplex] + [(at_centroid, simplex.mean(axis=0))]


@dataclass
class Cell:
    """Sums over the parts of the material in a cell, for each node."""

    volume: float = 0.0
    pressure: float = 0.0
    radius: float = 0.0
    gradient: dict[Place, Floats] = field(default_factory=lambda: defaultdict(lambda: np.zeros(1)))
    value: dict[Place, float] = field(default_factory=lambda: defaultdict(float))


@dataclass
class Point:
    """Shares of a point's domain, and of its radius, in the cells."""

    share: dict[Place, float] = field(default_factory=lambda: defaultdict(float))
    hoop_share: dict[Place, float] = field(default_factory=lambda: defaultdict(float))


class Reading:
    """The cells of a laboratory's points at the start of a step."""

    def __init__(self, laboratory: Laboratory, basis: str) -> None:
        self.kind = laboratory.kind
        self.lattice = [tuple(row) for row in laboratory.active.lattice[:, : laboratory.grid.dim]]
        self.cells: dict[Place, Cell] = defaultdict(Cell)
        self.points: list[Point] = []
        points, grid = laboratory.points, laboratory.grid
        dim = grid.dim
        sides = np.array([c[::-1] for c in product((-1.0, 1.0), repeat=dim)])
        scaled = 2 if self.kind == "plane_strain" else 3
        pressure = points.stress[:, :scaled].mean(axis=1)
        for p in range(len(points)):
            x, volume = points.position[p], float(points.volume[p])
            if basis == "linear":
                places = [(cell_at(x, grid), [(1.0, x)])]
            else:
                corners = x + (
                    points.corner[p] if basis in CORNER_BASES else sides * points.half_length[p]
                )
                cut = parts_of_domain(corners, grid)
                own = {cell_at(x + (1.0 - 1e-8) * (c - x), grid) for c in corners}
                if basis in CORNER_BASES:  # other cells have no nodes of the point
                    cut = [(place, part) for place, part in cut if place in own]
                total = sum(volume_of(part) for _, part in cut)
                places = [
                    (place, [(volume_of(part) / total * w, y) for w, y in quadrature(part)])
                    for place, part in cut
                ]
            point = Point()
            self.points.append(point)
            for place, samples in places:
                cell = self.cells[place]
                for weight, y in samples:
                    point.share[place] += weight
                    cell.volume += weight * volume
                    cell.pressure += weight * volume * pressure[p]
                    for node, (_, slope) in hats(place, y, grid).items():
                        cell.gradient[node] = cell.gradient[node] + weight * volume * slope
            if self.kind != "axisymmetric":
                continue
            if basis in CORNER_BASES:
                means = corner_means(corners - x)
                places = [
                    (cell_at(x + (1.0 - 1e-8) * (c - x), grid), [(w, c)])
                    for w, c in zip(means, corners, strict=True)
                ]
            for place, samples in places:
                cell = self.cells[place]
                for weight, y in samples:
                    point.hoop_share[place] += weight * y[0] / x[0]
                    cell.radius += weight * volume / x[0] * y[0]
                    for node, (value, _) in hats(place, y, grid).items():
                        cell.value[node] += weight * volume / x[0] * value
        self.pressure = np.array([
            sum(w * self.cells[e].pressure / self.cells[e].volume for e, w in point.share.items())
            for point in self.points
        ]) * points.assumed_jacobian  # fmt: skip

    def jacobian(self, u: Floats) -> Floats:
        """J0 of the points."""
        nodal = dict(zip(self.lattice, u, strict=True))
        dim = u.shape[1]
        in_plane, hoop = {}, {}
        for place, cell in self.cells.items():
            h = sum(np.outer(nodal[a], g) for a, g in cell.gradient.items()) / cell.volume
            in_plane[place] = float(np.linalg.det(np.eye(dim) + h))
            if self.kind == "axisymmetric" and cell.radius > 0.0:
                strain = sum(nodal[a][0] * v for a, v in cell.value.items()) / cell.radius
                hoop[place] = 1.0 + strain
        found = []
        for point in self.points:
            of_point = sum(w * in_plane[e] for e, w in point.share.items())
            if self.kind == "axisymmetric":
                of_point *= sum(w * hoop[e] for e, w in point.hoop_share.items())
            found.append(of_point)
        return np.array(found)


def corner_means(corner: Floats) -> Floats:
    """Means of the corners' functions over a quadrilateral."""
    gauss, total, sums = 1.0 / np.sqrt(3.0), 0.0, np.zeros(4)
    for xi in product((-gauss, gauss), repeat=2):
        value = np.array([(1 + sx * xi[0]) * (1 + sy * xi[1]) / 4
                          for sy in (-1, 1) for sx in (-1, 1)])  # fmt: skip
        slope = np.array([[sx * (1 + sy * xi[1]) / 4, sy * (1 + sx * xi[0]) / 4]
                          for sy in (-1, 1) for sx in (-1, 1)])  # fmt: skip
        determinant = float(np.linalg.det(corner.T @ slope))
        total += determinant
        sums += value * determinant
    return sums / total


def deformed(kind: str, basis: str, spacing: str) -> Laboratory:
    """Jittered points after two steps; domains stay on their side of the axis."""
    random = np.random.default_rng(11)
    entries = spaced(block_entries(kind, basis), spacing)
    entries["bodies"][0]["anti_locking"] = "f_bar"
    model = Model.from_dict(entries)
    points = jittered_points(model, random, 0.4)
    if kind == "axisymmetric":
        points.position[:, 0] += 0.25
    laboratory = Laboratory(kind, points, Simulation(model, points).state.grid)
    for _ in range(2):
        laboratory.step(laboratory.random_displacement(random, 0.06))
    return laboratory


def after_step(laboratory: Laboratory, u: Floats) -> dict[str, np.ndarray]:
    """Arrays after a step, in the order of the points before it."""
    other = laboratory.copy()
    number = other.points.point_id.copy()
    other.step(u)
    order = other.points.index_of(number)
    arrays = other.points.arrays() | {"elastic_strain": other.points.elastic_strain}
    return {name: array[order].copy() for name, array in arrays.items()}


@some_of(kind=KINDS, basis=BASES, spacing=SPACINGS)
def test_one_step_against_a_slow_reading_of_the_theory(kind: str, basis: str, spacing: str) -> None:
    laboratory = deformed(kind, basis, spacing)
    points = laboratory.points
    reading = Reading(laboratory, basis)
    u = laboratory.random_displacement(np.random.default_rng(12), 0.06)
    stretch = reading.jacobian(u)
    after = after_step(laboratory, u)
    assumed_jacobian = points.assumed_jacobian * stretch
    np.testing.assert_allclose(after["assumed_jacobian"], assumed_jacobian, rtol=1e-12)

    gradient = after["deformation_gradient"] @ np.linalg.inv(points.deformation_gradient)
    scaled = 2 if kind == "plane_strain" else 3
    assumed = gradient.copy()
    ratio = (stretch / np.linalg.det(gradient)) ** (1.0 / scaled)
    assumed[:, :scaled, :scaled] *= ratio[:, None, None]
    for p in range(len(points)):
        left = assumed[p] @ scipy.linalg.expm(2.0 * tensor(points.elastic_strain[p]))
        strain = 0.5 * scipy.linalg.logm(left @ assumed[p].T).real
        np.testing.assert_allclose(tensor(after["elastic_strain"][p]), strain, rtol=0, atol=1e-11)
        kirchhoff = LAME * np.trace(strain) * np.eye(3) + 2.0 * SHEAR * strain
        cauchy = kirchhoff / after["assumed_jacobian"][p]
        error = np.abs(tensor(after["stress"][p]) - cauchy).max()
        assert error < 1e-10 * np.abs(cauchy).max()


@some_of(kind=KINDS, basis=BASES, spacing=SPACINGS[::-1])
def test_the_force_is_the_derivative_of_the_potential(kind: str, basis: str, spacing: str) -> None:
    """Pi = sum V / J_bar [psi(F_bar) - pi (ln J0 - ln J)], in any direction."""
    laboratory = deformed(kind, basis, spacing)
    points = laboratory.points
    reading = Reading(laboratory, basis)
    weight = points.volume / points.assumed_jacobian
    before = np.log(np.linalg.det(points.deformation_gradient))

    def potential(u: Floats) -> float:
        after = after_step(laboratory, u)
        strain = tensor(after["elastic_strain"])
        trace = np.trace(strain, axis1=1, axis2=2)
        energy = 0.5 * LAME * trace**2 + SHEAR * (strain**2).sum(axis=(1, 2))
        true = np.log(np.linalg.det(after["deformation_gradient"])) - before
        return float(weight @ (energy - reading.pressure * (np.log(reading.jacobian(u)) - true)))

    random = np.random.default_rng(13)
    centre = laboratory.random_displacement(random, 0.06)
    force = laboratory.internal_force(centre)
    step = 1e-5
    for _ in range(2):
        direction = laboratory.random_displacement(random, 1.0)
        difference = potential(centre + step * direction) - potential(centre - step * direction)
        power = float((force * direction).sum())
        assert difference / (2 * step) == pytest.approx(power, rel=1e-7, abs=1e-6)
