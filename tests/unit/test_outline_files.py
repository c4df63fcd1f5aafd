# SPDX-License-Identifier: BSD-3-Clause
"""Outlines from DXF drawings and GeoJSON: areas in closed form, bits of a typed one, refusals."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest

from tilth.bodies.discretise import discretise
from tilth.bodies.forms import form_of
from tilth.bodies.request import Request
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Outline, Polygon

GRID = Grid(np.zeros(2), np.full(2, 0.5))
REQUEST = Request("soil", False, GRID)
SECTION = [[0.0, 0.0], [12.1, 0.0], [12.1, 2.3], [7.0, 2.3], [4.5, 5.7], [0.0, 5.7]]
HOLE = [[1.0, 1.0], [3.0, 1.0], [3.0, 2.5], [1.0, 2.5]]
HOLED = Polygon(vertices=SECTION, holes=[Polygon(vertices=HOLE)])


def drawn(folder: Path, draw: Callable[[Any], None]) -> str:
    document = ezdxf.new()
    draw(document.modelspace())
    document.saveas(folder / "section.dxf")
    return str(folder / "section.dxf")


def on(layer: str) -> dict[str, Any]:
    return {"dxfattribs": {"layer": layer}}


def as_polylines(m: Any) -> None:
    m.add_lwpolyline(SECTION, close=True, **on("clay"))
    m.add_lwpolyline(HOLE, close=True, **on("clay"))
    m.add_lwpolyline([(0, -3), (12, -3), (12, 0), (0, 0)], close=True, **on("rock"))
    m.add_text("Section A-A", **on("notes"))


def as_lines(m: Any) -> None:
    """In any order and direction, some as an open polyline."""
    m.add_line(SECTION[2], SECTION[1], **on("clay"))
    m.add_lwpolyline([*SECTION[3:], SECTION[0]], **on("clay"))
    m.add_line(SECTION[2], SECTION[3], **on("clay"))
    m.add_line(SECTION[0], SECTION[1], **on("clay"))
    m.add_polyline2d([*HOLE, HOLE[0]], **on("clay"))


def feature(name: str, *rings: Any) -> dict[str, Any]:
    closed = [[*ring, ring[0]] for ring in rings]
    geometry = {"type": "Polygon", "coordinates": closed}
    return {"type": "Feature", "properties": {"name": name}, "geometry": geometry}


def mapped(folder: Path, *features: dict[str, Any]) -> str:
    file = folder / "section.geojson"
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return str(file)


def form(file: str, **entries: Any) -> Polygon:
    found = form_of(Outline(file=file, **{"scale": 1.0, **entries}), REQUEST)
    assert isinstance(found, Polygon)
    return found


def test_points_are_those_of_the_same_polygon_to_the_last_bit(tmp_path: Path) -> None:
    entries = {"name": "soil", "material": "soil", "basis": "gimp", "points_per_cell": 3}
    typed = discretise(Body(shape=HOLED, **entries), "plane_strain", GRID)  # type: ignore[arg-type]
    files = [drawn(tmp_path, as_polylines), mapped(tmp_path, feature("clay", SECTION, HOLE))]
    for file in files:
        shape = Outline(file=file, layer="clay", scale=1.0)
        read = discretise(Body(shape=shape, **entries), "plane_strain", GRID)  # type: ignore[arg-type]
        np.testing.assert_array_equal(read.position, typed.position)
        np.testing.assert_array_equal(read.volume, typed.volume)
    assert math.fsum(typed.volume) == pytest.approx(HOLED.area - 3.0, rel=1e-14)


def test_lines_are_joined_at_their_ends(tmp_path: Path) -> None:
    found = form(drawn(tmp_path, as_lines))
    assert found.measure() == pytest.approx(HOLED.measure(), rel=1e-14)
    assert sorted(found.vertices) == sorted(HOLED.vertices)


def test_arcs_and_circles_have_their_area(tmp_path: Path) -> None:
    """A polyline with a bulge of 1 (half a circle), and a circular hole."""

    def draw(m: Any) -> None:
        corners = [(0, 0, 0), (6, 0, 1), (6, 4, 0), (0, 4, 0)]
        m.add_lwpolyline(corners, format="xyb", close=True)
        m.add_circle((3, 2), 1.5)

    found = form(drawn(tmp_path, draw))
    assert found.measure() == pytest.approx(24.0 + 0.5 * math.pi * 4.0 - math.pi * 2.25, rel=1e-3)
    assert found.bounds()[1][0] == pytest.approx(8.0, rel=1e-3)


def test_scale_and_origin_lead_to_the_units_of_the_case(tmp_path: Path) -> None:
    far = [[500000.0 + 1000.0 * x, 6600000.0 + 1000.0 * y] for x, y in SECTION]
    found = form(mapped(tmp_path, feature("clay", far)), scale=0.001, origin=[500000.0, 6600000.0])
    np.testing.assert_allclose(found.vertices, SECTION, atol=1e-9)


def refusal(file: str, **entries: Any) -> str:
    with pytest.raises(BadInput) as error:
        form(file, **entries)
    return str(error.value)


DRAWINGS: list[tuple[Callable[[Any], None], dict[str, Any], list[str]]] = [
    (as_polylines, {"layer": "caly"}, ["shape.layer", "did you mean `clay`?"]),
    (as_polylines, {"layer": "notes"}, ["shape.layer", "no layer with outlines of this name"]),
    (as_polylines, {}, ["shape.layer", "there are several", "`clay`, `rock`"]),
    (lambda m: m.add_text("nothing"), {}, ["shape.file", "contains no lines"]),
    (
        lambda m: m.add_lwpolyline(SECTION), {},
        ["the outline is open: no line goes on at (0, 5.7) in the file", "join the ends"],
    ),
    (
        lambda m: (as_lines(m), m.add_line(SECTION[3], (0, 0), **on("clay"))), {},
        ["branches: several lines go on at (0, 0)"],
    ),
    (
        lambda m: m.add_lwpolyline([(0, 0), (2, 2), (2, 0), (0, 2.1)], close=True), {},
        ["the edges intersect each other", "correct the drawing"],
    ),
    (
        lambda m: [m.add_circle((x, 0), 1 + 0.1 * x) for x in (0, 5)], {},
        ["(outline 0 in it, by area)", "not wholly inside", "layer of its own"],
    ),
    (
        lambda m: m.add_polyline3d([(0, 0, 0), (2, 0, 0), (2, 0, 2)], close=True), {},
        ["not in a plane of constant z"],
    ),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(DRAWINGS)))
def test_a_wrong_drawing_is_refused(case: int, tmp_path: Path) -> None:
    draw, entries, texts = DRAWINGS[case]
    found = refusal(drawn(tmp_path, draw), **entries)
    for text in ["section.dxf" if "layer" not in texts[0] else "soil", *texts]:
        assert text in found


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("{", "cannot be read as GeoJSON"),
        ('{"type": "FeatureCollection", "features": []}', "contains no polygons"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1]]]}', "a ring is not closed"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], [1, "a"], [1, 1], [0, 0]]]}', "could not"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], [1, NaN], [1, 1], [0, 0]]]}', "finite"),
        ("[1, 2]", "cannot be read as GeoJSON"),
    ],
)
def test_wrong_geojson_is_refused(text: str, part: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(text)
    found = refusal(str(tmp_path / "a.json"))
    assert part in found
    assert "a.json" in found


NEAR_OSLO = [[10.75, 59.91], [10.7501, 59.91], [10.7501, 59.9101], [10.75, 59.9101]]


def with_system(name: str) -> dict[str, Any]:
    return {"crs": {"type": "name", "properties": {"name": name}}}


@pytest.mark.parametrize("scale", [1.0, 111e3])
def test_longitude_and_latitude_are_refused(scale: float, tmp_path: Path) -> None:
    """RFC 7946 knows no other coordinates; as lengths the outline would be smaller than a cell."""
    file = mapped(tmp_path, feature("pit", NEAR_OSLO))
    found = refusal(file, scale=scale, origin=NEAR_OSLO[0])
    assert "its coordinates are those of longitude and latitude in degrees" in found
    assert "project it to plane coordinates" in found
    assert ("1e-04 long" in found or "0.0001 long" in found) == (scale == 1.0)


@pytest.mark.parametrize(
    "name", ["urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:4326", "urn:ogc:def:crs:EPSG::4258"]
)
def test_a_reference_system_in_degrees_is_refused(name: str, tmp_path: Path) -> None:
    whole = {"type": "FeatureCollection", "features": [feature("pit", SECTION)]}
    (tmp_path / "a.geojson").write_text(json.dumps(whole | with_system(name)))
    assert f"{name!r} is in degrees" in refusal(str(tmp_path / "a.geojson"))


def test_plane_coordinates_are_taken_with_and_without_a_reference_system(tmp_path: Path) -> None:
    """Also small numbers, if the outline is not smaller than a cell, and a drawing in mm."""
    whole = {"type": "FeatureCollection", "features": [feature("pit", SECTION)]}
    for system in ({}, with_system("urn:ogc:def:crs:EPSG::25832"), with_system("EPSG:14326")):
        (tmp_path / "a.geojson").write_text(json.dumps(whole | system))
        assert form(str(tmp_path / "a.geojson")).vertices
    metres = [[1000.0 * x, 1000.0 * y] for x, y in SECTION]
    assert form(mapped(tmp_path, feature("", metres)), scale=1e-3).vertices


def test_other_refusals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.dxf").write_text("no drawing")
    assert "cannot be read as a DXF drawing" in refusal(str(tmp_path / "a.dxf"))
    far = [[500000.0 + x, 6600000.0 + y] for x, y in SECTION]
    assert "cells from the origin of the grid" in refusal(mapped(tmp_path, feature("", far)))
    twice = mapped(tmp_path, feature("clay", SECTION), feature("clay", HOLE))
    assert "has several polygons of the name 'clay'" in refusal(twice)
    monkeypatch.setitem(__import__("sys").modules, "ezdxf", None)
    assert "pip install tilth[dxf]" in refusal(str(tmp_path / "a.dxf"))
