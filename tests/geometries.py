# SPDX-License-Identifier: BSD-3-Clause
"""Geometries of every kind."""

import numpy as np

from tilth.curves import Chain, LocalCubicSpline
from tilth.geometry.box import Box
from tilth.geometry.cone import Cone
from tilth.geometry.footing import Footing
from tilth.geometry.plane import Plane
from tilth.geometry.polyline import Polyline
from tilth.geometry.round import Circle, Cylinder, Sphere
from tilth.geometry.spline import SplineGeometry
from tilth.model.shapes import box_axes

STAR = np.array([[1, 0.1], [0.35, 0.4], [0.1, 1], [-0.3, 0.2], [-1, -0.2], [0.1, -0.25]])


TURNED_2D = np.array(box_axes(2, 30.0, None))


TURNED_3D = np.array(box_axes(3, 40.0, "x")) @ np.array(box_axes(3, 25.0, "z"))


AXIS = np.array([0.3, -0.5, 0.8])


ROUND = 0.7 * np.stack([np.cos(np.arange(24) * np.pi / 12), np.sin(np.arange(24) * np.pi / 12)], 1)


DROP = LocalCubicSpline(Chain(ROUND * [1.3, 1.0] + [0.1, -0.2], True, np.arange(24) % 8 == 0))


# All within about 1.5 of the origin: the places below are too.
GEOMETRIES = {
    "line": Plane([0.1, 0.2], [3.0, 4.0]),
    "plane": Plane([0.1, 0.2, -0.1], [1.0, -2.0, 2.0]),
    "circle": Circle([0.1, -0.2], 0.7, inside=True),
    "hole": Circle([0.1, -0.2], 0.7, inside=False),
    "cylinder": Cylinder([0.1, -0.2, 0.3], AXIS, 0.7, inside=True),
    "borehole": Cylinder([0.1, -0.2, 0.3], [0.0, 0.0, 2.0], 0.7, inside=False),
    "sphere": Sphere([0.1, -0.2, 0.3], 0.7, inside=True),
    "cavity": Sphere([0.1, -0.2, 0.3], 0.7, inside=False),
    "open line": Polyline(STAR[:4], closed=False, left=True),
    "one segment": Polyline(STAR[:2], closed=False, left=False),
    "polygon": Polyline(STAR, closed=True, left=True),
    "rectangle": Box([-0.5, -0.4], [0.6, 0.3], TURNED_2D, inside=True),
    "obstacle": Box([-0.5, -0.4], [0.6, 0.3], TURNED_2D, inside=False),
    "cuboid": Box([-0.5, -0.4, -0.2], [0.6, 0.3, 0.3], TURNED_3D, inside=True),
    "block": Box([-0.5, -0.4, -0.2], [0.6, 0.3, 0.3], TURNED_3D, inside=False),
    "strip": Footing([0.1, 0.2], [0.6, -0.8], [1.1]),
    "pad": Footing([0.1, 0.2, -0.1], AXIS, [1.1, 0.6], along=[1.0, 1.0, 0.0]),
    "stake": Cone([0.1, -0.2, -0.6], AXIS, 0.4, 0.5, 0.7, inside=False),
    "pile": Cone([0.1, -0.2, 0.6], [0.0, 0.0, -1.0], 0.4, 0.0, 0.9, inside=False),
    "funnel": Cone([0.1, -0.2, -0.6], AXIS, 0.4, 0.5, 0.7, inside=True),
    "spline": SplineGeometry(DROP),
    "open spline": SplineGeometry(LocalCubicSpline(Chain(ROUND[:17:-1], False))),
}


FLAT = [name for name, geometry in GEOMETRIES.items() if geometry.flat]
