# SPDX-License-Identifier: BSD-3-Clause
"""A case whose body is drawn in a DXF file ends as the one with the polygon typed, to the bit."""

from __future__ import annotations

from pathlib import Path

import ezdxf
import numpy as np
import pytest

import tilth

CORNERS = [[0.0, 0.0], [9.0, 0.0], [6.0, 2.0], [3.0, 2.0]]
HOLE = [[4.0, 0.5], [5.0, 0.5], [5.0, 1.5], [4.0, 1.5]]
CASE = """format = 1
title = "Embankment with a culvert"
analysis = { kind = "plane_strain" }
grid = { cell_size = 0.5 }
schedule = { steps = 1 }
materials.fill = { model = "hencky_elastic", young_modulus = 2e6, poisson_ratio = 0.3, density = 2e3 }
loads = [{ type = "body_force", acceleration = [0.0, -9.81] }]
boundaries = [{ name = "base", type = "plane", axis = "y", at = 0.0, condition = "fixed" }]
bodies = [{ name = "fill", material = "fill", basis = "gimp", points_per_cell = 2, surface = {}, shape = SHAPE }]
"""  # noqa: E501
TYPED = f'{{ type = "polygon", vertices = {CORNERS}, holes = [{{ type = "polygon", vertices = {HOLE} }}] }}'  # noqa: E501
DRAWN = '{ type = "outline", file = "section.dxf", layer = "fill", scale = 1 }'


@pytest.mark.slow
def test_the_run_of_a_drawing_is_that_of_the_polygon(tmp_path: Path) -> None:
    document = ezdxf.new()
    for corners in (CORNERS, HOLE):
        document.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": "fill"})
    document.saveas(tmp_path / "section.dxf")
    ends = []
    for name, shape in (("typed", TYPED), ("drawn", DRAWN)):
        case = tmp_path / f"{name}.toml"
        case.write_text(CASE.replace("SHAPE", shape), encoding="utf-8")
        result = tilth.run(tilth.load_case(case), tmp_path / name, quiet=True)
        ends.append(result.points)
    typed, drawn = ends
    np.testing.assert_array_equal(drawn.displacement, typed.displacement)
    np.testing.assert_array_equal(drawn.stress, typed.stress)
    assert typed.displacement[:, 1].min() < -1e-3
