# SPDX-License-Identifier: BSD-3-Clause
"""A small correct file of each kind that a body can be read from."""

from __future__ import annotations

import io
import json

import numpy as np
from ezdxf.addons.r12writer import r12writer

GEOJSON = {
    "type": "FeatureCollection",
    "features": [
        {
            "type": "Feature",
            "properties": {"name": "clay"},
            "geometry": {
                "type": "Polygon",
                "coordinates": [
                    [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 0.0]],
                    [[1.0, 0.5], [1.5, 0.5], [1.5, 1.0], [1.0, 0.5]],
                ],
            },
        },
        {"type": "Feature", "geometry": {"type": "MultiPolygon", "coordinates": []}},
    ],
}

CORNERS = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]], dtype=float)
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def stl() -> str:
    lines = ["solid a"]
    for face in FACES:
        lines += ["facet normal 0 0 0", " outer loop"]
        lines += [f"  vertex {x:g} {y:g} {z:g}" for x, y, z in CORNERS[face]]
        lines += [" endloop", "endfacet"]
    return "\n".join([*lines, "endsolid a", ""])


MESH_2 = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 2 0 0
3 2 2 0
4 0 2 0
$EndNodes
$Elements
2
1 2 2 1 1 1 2 3
2 2 2 1 1 1 3 4
$EndElements
"""

MESH_4 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$Nodes
1 4 1 4
2 1 0 4
1
2
3
4
0 0 0
2 0 0
2 2 0
0 2 0
$EndNodes
$Elements
1 2 1 2
2 1 2 2
1 1 2 3
2 1 3 4
$EndElements
"""


def dxf() -> str:
    """Of a version without a header, so that it is short."""
    stream = io.StringIO()
    with r12writer(stream) as drawing:
        drawing.add_polyline_2d([(0, 0), (2, 0), (2, 2)], layer="clay", closed=True)
        drawing.add_circle((1.2, 0.6), 0.2, layer="clay")
    return stream.getvalue()


FILES = {
    "outline.geojson": json.dumps(GEOJSON),
    "drawing.dxf": dxf(),
    "surface.stl": stl(),
    "two.msh": MESH_2,
    "four.msh": MESH_4,
    "section.csv": "x,z\n0,2\n1,1.5\n2,3\n",
    "grid.csv": "x,y,z\n0,0,2\n0,2,2\n2,0,3\n2,2,1\n",
    "survey.csv": "x,y,z\n-1,-1,2\n-1,3,2\n3,-1,3\n3,3,1\n1,1,2\n",
    "grid.asc": "ncols 3\nnrows 3\nxllcenter -1\nyllcenter -1\ncellsize 2\nNODATA_value -9999\n"
    "2 2 3\n2 3 2\n3 2 2\n",
}
"""Their contents, by names that say what they are."""
