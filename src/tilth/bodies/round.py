# SPDX-License-Identifier: BSD-3-Clause
"""Material points of a circle, cylinder or sphere."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.bodies.lattice import anchored_axes, cut_lattice, spread
from tilth.bodies.request import BodyPoints, Request
from tilth.model import Circle, Cylinder, Sphere
from tilth.model.shapes import side_signs

# Centres up to this fraction of the radius outside the surface are inside (round-off).
SURFACE_TOLERANCE = 1e-9


def circle_points(shape: Circle, request: Request) -> BodyPoints:
    """Returns the points of a circle: the centres of the grid's sub-cells inside it.

    In axisymmetry a circle off the axis is a ring (volume 2 pi^2 R r^2, Pappus), one centred on
    the axis is a ball (half disc, 4/3 pi r^3). Raises BadInput for any other intersection with the
    axis.
    """
    centre, radius = np.asarray(shape.centre, dtype=float), float(shape.radius)
    lower, upper = centre - radius, centre + radius
    volume = math.pi * radius**2
    if request.axisymmetric:
        if centre[0] == 0.0:
            lower[0] = 0.0
            volume = 4.0 / 3.0 * math.pi * radius**3
        elif centre[0] >= radius:
            volume *= 2.0 * math.pi * centre[0]
        else:
            raise request.refused(
                f"the axis of symmetry cuts the circle (its centre has r = {centre[0]:.6g}, "
                f"its radius is {radius:.6g})",
                f"centre it on the axis (x = 0) or move its centre to x >= {radius:.6g}",
            )
    axes, sizes = anchored_axes(request, lower, upper)
    inside = _within(axes, centre, radius, directions=(0, 1))
    if request.axisymmetric:
        inside &= axes[0] > 0.0
    return cut_lattice(request, axes, sizes, inside, volume)


def cylinder_points(shape: Cylinder, request: Request) -> BodyPoints:
    """Returns the points of a cylinder along x, y or z with `centre` in its lower end face."""
    centre = np.asarray(shape.centre, dtype=float)
    along = "xyz".index(shape.axis)
    lower, upper = (np.array(corner) for corner in shape.bounds())
    axes, sizes = anchored_axes(request, lower, upper)
    across = tuple(i for i in range(3) if i != along)
    margin = SURFACE_TOLERANCE * shape.height
    between = (axes[along] >= lower[along] - margin) & (axes[along] <= upper[along] + margin)
    inside = _between_radii(axes, centre, shape, across) & spread(between, along)
    section = math.pi * (shape.radius**2 - (shape.inner_radius or 0.0) ** 2)
    return cut_lattice(
        request, axes, sizes, inside, _fraction(shape) * section * float(shape.height)
    )


def sphere_points(shape: Sphere, request: Request) -> BodyPoints:
    """Returns the points of a sphere: the centres of the grid's sub-cells inside it."""
    centre = np.asarray(shape.centre, dtype=float)
    lower, upper = (np.array(corner) for corner in shape.bounds())
    axes, sizes = anchored_axes(request, lower, upper)
    inside = _between_radii(axes, centre, shape, directions=(0, 1, 2))
    volume = 4.0 / 3.0 * math.pi * (shape.radius**3 - (shape.inner_radius or 0.0) ** 3)
    return cut_lattice(request, axes, sizes, inside, _fraction(shape) * volume)


def _fraction(shape: Cylinder | Sphere) -> float:
    """Returns the fraction of the whole round body on the declared sides."""
    return float(0.5 ** len(shape.sides or ()))


def _between_radii(
    axes: list[Floats],
    centre: Floats,
    shape: Cylinder | Sphere,
    directions: tuple[int, ...],
) -> npt.NDArray[np.bool_]:
    """Returns which lattice points lie between the radii of a body, on its declared sides."""
    inside = _within(axes, centre, shape.radius, directions)
    if shape.inner_radius is not None:
        hole = shape.inner_radius * (
            1.0 - 2.0 * SURFACE_TOLERANCE
        )  # points on its surface are inside the body
        inside = inside & ~_within(axes, centre, hole, directions)
    for i, sign in enumerate(side_signs(shape.sides)):
        inside = inside & spread(
            sign * (axes[i] - centre[i]) >= -SURFACE_TOLERANCE * shape.radius, i
        )
    return inside


def _within(
    axes: list[Floats], centre: Floats, radius: float, directions: tuple[int, ...]
) -> npt.NDArray[np.bool_]:
    """Returns which lattice points lie within `radius` of `centre`, along `directions`."""
    squared = np.zeros((1,) * len(axes))
    for i in directions:
        squared = squared + spread((axes[i] - centre[i]) ** 2, i)
    inside: npt.NDArray[np.bool_] = squared <= (radius * (1.0 + SURFACE_TOLERANCE)) ** 2
    return inside
