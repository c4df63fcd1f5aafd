# SPDX-License-Identifier: BSD-3-Clause
"""Writes cone.stl: a cone of 60 degrees, its tip at (0, 0, 1.25) m and its base 0.5 m in radius."""

import math
from pathlib import Path

SEGMENTS = 48
TIP = (0.0, 0.0, 1.25)
RADIUS = 0.5


def triangles():
    """The side, then the base, seen from outside anticlockwise."""
    angle = 2.0 * math.pi / SEGMENTS
    radius = RADIUS * math.sqrt(angle / math.sin(angle))  # sections have the circle's area
    height = TIP[2] + RADIUS / math.tan(math.radians(30.0))
    rim = [
        (radius * math.cos(i * angle), radius * math.sin(i * angle), height)
        for i in range(SEGMENTS)
    ]
    for start, end in zip(rim, rim[1:] + rim[:1], strict=True):
        yield TIP, end, start
        yield (0.0, 0.0, height), start, end


def write(file):
    """Text, with the normals left to the reader, as the format allows."""
    lines = ["solid cone"]
    for corners in triangles():
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x:.6f} {y:.6f} {z:.6f}" for x, y, z in corners]
        lines += ["endloop", "endfacet"]
    file.write_text("\n".join([*lines, "endsolid cone", ""]), encoding="ascii")


if __name__ == "__main__":
    write(Path(__file__).with_name("cone.stl"))
