# SPDX-License-Identifier: BSD-3-Clause
"""Accuracy and time of the gap between a rigid surface and the soil, measured with the domains.

A surface lies half a point spacing above the true surface of a body of soil. The error of the gap
is measured at many points on parts of it that are one cell long (in space one cell square), placed
at random on the body, which itself is placed at random on the grid. Lengths are in spacings of the
material points. Prints the mean of the error over all parts (bias), its standard deviation over all
points (scatter), and the root mean square over the parts of their mean errors. Run it with
`python benchmarks/soil_gap.py` (half a minute on one thread).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from tilth import Model, _core
from tilth.arrays import Floats
from tilth.boundaries.surfaces.gap import measure_gap
from tilth.grid.background import Grid
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints

CLEARANCE = 0.5
"""Distance of the rigid surface from the true surface of the soil, in point spacings."""
ANGLES = (0.0, 5.0, 15.0, 30.0, 45.0)
RADIUS = {2: 4.0, 3: 3.0}
"""Radius of circle and sphere, in cells."""
PLACES, PARTS = 20, 20
"""Places of the body on the grid, and parts of its surface at each."""

Surface = Callable[[np.random.Generator, Floats], tuple[Floats, Floats]]
"""Returns positions on the true surface and outward normals, (n, dim), of a part at random.

It is given the coordinates on the part, shape (n, dim - 1).
"""


def body_points(shape: dict[str, Any], per_cell: int, basis: str) -> MaterialPoints:
    """Returns the material points of a body on a grid with cells of size 1."""
    dim = len(shape.get("lower") or shape.get("centre") or (0, 0))
    entries: dict[str, Any] = {
        "analysis": {"kind": "3d" if dim == 3 else "plane_strain"},
        "grid": {"cell_size": 1.0},
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": 1.0, "poisson_ratio": 0.0}
        },
        "bodies": [
            {
                "name": "soil", "material": "soil", "shape": shape, "basis": basis,
                "points_per_cell": per_cell,
            }
        ],
        "boundaries": [
            {
                "name": "motion", "type": "affine", "path": "linear",
                "deformation_gradient": np.eye(dim).tolist(),
            }
        ],
        "schedule": {"steps": 1},
    }  # fmt: skip
    return initial_points(Model.from_dict(entries))


def slope(kind: str, dim: int, angle: float) -> Callable[[Floats], tuple[dict[str, Any], Surface]]:
    """Returns a body with a plane surface at an angle, for a place on the grid.

    kind: "cut" for points along the grid's axes, "turned" for points along the surface.
    """
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    axes = np.eye(dim)
    axes[:2, :2] = [[c, s], [-s, c]]
    length = 14.0 if dim == 2 else 8.0

    def place(corner: Floats) -> tuple[dict[str, Any], Surface]:
        depth, sides = 4.0, np.full(dim, length)
        sides[1] = depth
        shape: dict[str, Any] = {
            "type": "box", "lower": corner.tolist(), "upper": (corner + sides).tolist(),
            "angle": angle,
        }  # fmt: skip
        if dim == 3:
            shape["axis"] = "z"
        if kind == "cut":
            corners = np.array([[0, 0], [length, 0], [length, depth], [0, depth]], dtype=float)
            shape = {"type": "polygon", "vertices": (corner + corners @ axes).tolist()}

        def surface(random: np.random.Generator, part: Floats) -> tuple[Floats, Floats]:
            own = np.full((len(part), dim), depth)
            start = random.uniform(2.0, length - 3.0, dim - 1)
            own[:, [0, 2][: dim - 1]] = start + part
            return corner + own @ axes, np.tile(axes[1], (len(part), 1))

        return shape, surface

    return place


def ball(dim: int) -> Callable[[Floats], tuple[dict[str, Any], Surface]]:
    """Returns a circle or a sphere, for a place on the grid."""

    def place(centre: Floats) -> tuple[dict[str, Any], Surface]:
        def surface(random: np.random.Generator, part: Floats) -> tuple[Floats, Floats]:
            axes = np.linalg.qr(random.normal(size=(dim, dim)))[0]
            normal = axes[0] + part @ axes[1:] / RADIUS[dim]
            normal /= np.linalg.norm(normal, axis=1)[:, None]
            return centre + RADIUS[dim] * normal, normal

        kind = "circle" if dim == 2 else "sphere"
        return {"type": kind, "centre": centre.tolist(), "radius": RADIUS[dim]}, surface

    return place


def errors(
    place: Callable[[Floats], tuple[dict[str, Any], Surface]],
    dim: int,
    per_cell: int,
    basis: str,
    on_grid: bool = False,
    width: float = 0.0,
) -> Floats:
    """Returns the errors of the gap in point spacings, (parts, points on each).

    width: the error is the mean over parallel lines across so many point spacings; in the plane.
    """
    random = np.random.default_rng(1)
    axis = (np.arange(50 if dim == 2 else 12) + 0.5) / (50 if dim == 2 else 12) - 0.5
    part = np.stack(np.meshgrid(*[axis] * (dim - 1)), axis=-1).reshape(-1, dim - 1)
    grid, clearance, found = Grid(np.zeros(dim), np.ones(dim)), CLEARANCE / per_cell, []
    for _ in range(1 if on_grid else PLACES if dim == 2 else PLACES // 4):
        shape, surface = place(np.zeros(dim) if on_grid else random.uniform(0.0, 1.0, dim))
        points = body_points(shape, per_cell, basis)
        for _ in range(PARTS):
            x, outward = surface(random, part)
            along = width / per_cell * np.roll(outward, 1, axis=1)
            along[:, 0] *= -1.0  # in the plane: the tangent
            lines = []
            for offset in np.linspace(-0.5, 0.5, 9) if width else (0.0,):
                begin = x + clearance * outward + offset * along
                gap, point = measure_gap(points, grid, {}, begin, -outward, 2.0, 1.0)
                assert (point >= 0).all()
                lines.append(gap)
            found.append((np.mean(lines, axis=0) - clearance) * per_cell)
    return np.array(found)


def show(name: str, error: Floats) -> None:
    """Prints bias, scatter and the error of the parts' means."""
    of_parts = np.sqrt((error.mean(axis=1) ** 2).mean())
    print(
        f"| {name:46} | {error.mean():+.3f} | {error.std():.3f} | {of_parts:.3f} | "
        f"{np.abs(error).max():.2f} |"
    )


def time_large() -> None:
    """Prints the time of 1e5 lines against 1e6 material points on one thread."""
    _core.set_threads(1)
    random = np.random.default_rng(1)
    for dim, side in ((2, 500), (3, 50)):
        shape = {"type": "box", "lower": [0.0] * dim, "upper": [float(side)] * dim}
        for basis in ("gimp", "cpdi1"):
            points = body_points(shape, 2, basis)
            normal = -np.eye(dim)[1] + 0.3 * random.normal(size=(100_000, dim))
            normal /= np.linalg.norm(normal, axis=1)[:, None]
            x = random.uniform(0.0, side, (100_000, dim))
            x[:, 1] = side + random.uniform(-0.2, 0.5, 100_000)
            grid = Grid(np.zeros(dim), np.ones(dim))
            seconds = []
            for _ in range(3):
                begin = time.perf_counter()
                measure_gap(points, grid, {}, x, normal, 1.0, 1.0)
                seconds.append(time.perf_counter() - begin)
            print(f"{dim}D, {basis}, {len(points):,} points: {np.median(seconds):.2f} s")


def main() -> None:
    """Prints the table."""
    print("| body, points per cell | bias | scatter | rms of a cell's mean | largest |")
    print("| --- | --- | --- | --- | --- |")
    for dim in (2, 3):
        for per_cell in (2, 3):
            label = f"{'x'.join([str(per_cell)] * dim)}"
            kinds = [("cut", "gimp")] if dim == 2 else []
            for kind, basis in [*kinds, ("turned", "gimp"), ("turned", "cpdi1")]:
                for angle in ANGLES if basis == "gimp" else (30.0,):
                    error = errors(slope(kind, dim, angle), dim, per_cell, basis, angle == 0.0)
                    show(f"{dim}D plane, {kind}, {basis}, {angle:g} degrees, {label}", error)
            error = errors(ball(dim), dim, per_cell, "gimp")
            show(f"{dim}D {'circle' if dim == 2 else 'sphere'}, cut, gimp, {label}", error)
    for width in (0.0, 1.0, 2.0):
        for angle in (15.0, 30.0):
            error = errors(slope("cut", 2, angle), 2, 2, "gimp", width=width)
            show(f"cut, {angle:g} degrees, mean over a width of {width:g}", error)
    time_large()


if __name__ == "__main__":
    main()
