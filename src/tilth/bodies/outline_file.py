# SPDX-License-Identifier: BSD-3-Clause
"""Outline of a body from a DXF drawing or a GeoJSON file, as a polygon with holes."""

from __future__ import annotations

import importlib
import io
import json
import math
import re
from codecs import BOM_UTF8
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.bodies.request import Request
from tilth.errors import BadInput
from tilth.input_files import require_file, why_failed
from tilth.memory_errors import is_memory_error
from tilth.model import Polygon
from tilth.model.file_shapes import Outline
from tilth.model.problems import unknown_name

CHORD_TOLERANCE = 1e-4
"""Distance of chords from a curve, over its extent."""

END_TOLERANCE = 1e-6
"""Ends nearer than this, over the extent of the drawing, meet."""

ROUND_OFF = 1e-14
"""Of a coordinate, relative to its magnitude."""

DRAWN = frozenset({"LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"})
"""Kinds of entities of a drawing that may be parts of outlines."""

DEGREES = re.compile(r"CRS:?84$|EPSG:([^:]*:)?(4326|4258|4269)$", re.IGNORECASE)
"""Names of coordinate reference systems of longitude and latitude: WGS 84, ETRS89, NAD83."""

PROJECT = (
    "project it to plane coordinates in a unit of length (as with ogr2ogr -t_srs), or correct "
    "shape.scale"
)

LARGEST_SCALE = 1e4
"""Factor above which a scale is none between units of length: a mile is 1609 m."""

Line = tuple[Floats, bool]
"""Places along a line [unit of the file], shape (n, 2), and whether its ends are joined."""


def outline_of(shape: Outline, request: Request) -> Polygon:
    """Returns the polygon of an outline file, with its holes, in the coordinates of the case.

    Raises:
        BadInput: the file cannot be read, there is no such layer or no closed outline in it, or
            outlines cross themselves or each other.
    """
    dxf = shape.file.lower().endswith(".dxf")
    by_layer = _read_dxf(shape, request) if dxf else _read_geojson(shape, request)
    lines = _of_layer(by_layer, shape, request)
    if not dxf:
        _require_lengths(lines, shape, request)
    loops = [
        (loop - np.array(shape.origin)) * shape.scale for loop in _closed(lines, shape, request)
    ]
    loops.sort(key=_area, reverse=True)
    holes = [{"type": "polygon", "vertices": loop.tolist()} for loop in loops[1:]]
    try:
        return Polygon(vertices=loops[0].tolist(), holes=holes)  # type: ignore[arg-type]
    except BadInput as error:
        hole = "holes" in error.key
        number = f" (outline {error.key.partition('[')[2][:1]} in it, by area)" if hole else ""
        remedy = "correct the drawing"
        if hole:
            remedy += "; separate parts are separate bodies: put each on a layer of its own"
        raise _refused(
            shape, request, f"{_where(shape)}{number}: {error.problem}", remedy
        ) from None


def _refused(
    shape: Outline, request: Request, problem: str, remedy: str, key: str = "file"
) -> BadInput:
    return request.refused(problem, remedy, f"shape.{key}", getattr(shape, key))


def _where(shape: Outline) -> str:
    return "the outline" if shape.layer is None else f"the outline of {shape.layer!r}"


def _of_layer(by_layer: dict[str, list[Line]], shape: Outline, request: Request) -> list[Line]:
    """Returns the lines of the layer that is named, or of the only one."""
    if not by_layer:
        kinds = "lines" if shape.file.lower().endswith(".dxf") else "polygons"
        raise _refused(shape, request, f"contains no {kinds}", "save the closed outline of a body")
    if shape.layer is None:
        if len(by_layer) > 1:
            listed = ", ".join(f"`{name}`" for name in by_layer)
            remedy = f"name one with outlines: {listed}"
            raise _refused(shape, request, "missing, but there are several", remedy, "layer")
        return next(iter(by_layer.values()))
    named = {name.casefold(): lines for name, lines in by_layer.items()}
    if (found := named.get(shape.layer.casefold())) is None:
        problem, remedy = unknown_name("layer with outlines", shape.layer, by_layer)
        raise _refused(shape, request, problem, remedy, "layer")
    return found


def _read_dxf(shape: Outline, request: Request) -> dict[str, list[Line]]:
    """Returns the lines of a drawing by layer."""
    try:
        ezdxf, paths = importlib.import_module("ezdxf"), importlib.import_module("ezdxf.path")
    except ModuleNotFoundError:
        problem = "a DXF file needs the package ezdxf, which is not installed"
        raise request.refused(problem, "install it with `pip install tilth[dxf]`") from None
    try:
        require_file(shape.file)
        with Path(shape.file).open("rb") as opened:
            marked = opened.read(len(BOM_UTF8)) == BOM_UTF8  # by an editor; ezdxf does not know it
        if marked:
            text = Path(shape.file).read_text(encoding="utf-8-sig")
            drawing = ezdxf.read(io.StringIO(text))
        else:
            drawing = ezdxf.readfile(shape.file)
        found: dict[str, list[Line]] = {}
        for entity in drawing.modelspace():
            if entity.dxftype() not in DRAWN:
                continue
            path = paths.make_path(entity)
            ends = np.array([tuple(v) for v in path.control_vertices()])
            if not np.isfinite(ends).all():  # chords of these would not end
                problem = f"a {entity.dxftype()} has a coordinate that is no finite number"
                raise _refused(shape, request, problem, "correct the drawing")
            extent = float(np.ptp(ends, axis=0).max(initial=0.0)) if len(ends) else 0.0
            if not extent > 0.0:
                continue
            if CHORD_TOLERANCE * extent <= ROUND_OFF * np.abs(ends).max():  # nor of these
                where = _text(ends[0])
                problem = f"a {entity.dxftype()} at {where} is too small, so far from the origin"
                raise _refused(shape, request, problem, "draw the section near the origin")
            places = np.array([tuple(v) for v in path.flattening(CHORD_TOLERANCE * extent)])
            if np.ptp(places[:, 2]) > CHORD_TOLERANCE * extent:
                problem = f"a {entity.dxftype()} is not in a plane of constant z"
                raise _refused(shape, request, problem, "draw the section in the x-y plane")
            line = _without_repeats(places[:, :2]), bool(path.is_closed)
            found.setdefault(entity.dxf.layer, []).append(line)
    except BadInput:
        raise
    except Exception as error:  # ezdxf raises all kinds for what is no drawing
        if is_memory_error(error):
            raise
        problem = f"cannot be read as a DXF drawing: {why_failed(error)}"
        raise _refused(shape, request, problem, "save it as DXF again") from None
    return found


def _read_geojson(shape: Outline, request: Request) -> dict[str, list[Line]]:
    """Returns the rings of the polygons in a GeoJSON file by the name of their feature."""
    found: dict[str, list[Line]] = {}
    try:
        require_file(shape.file)
        whole = json.loads(Path(shape.file).read_text(encoding="utf-8-sig"))
        if (system := _system(whole)) and DEGREES.search(system):
            what = f"its coordinate reference system {system!r} is in degrees, not in lengths"
            raise _refused(shape, request, what, PROJECT)
        for name, rings in _polygons(whole, ""):
            if name in found:
                what = f"has several polygons{f' of the name {name!r}' if name else ''}"
                remedy = 'give each the property "name", and name one as `layer`'
                raise _refused(shape, request, what, remedy)
            places = [np.array([place[:2] for place in ring], dtype=float) for ring in rings]
            if any(p.shape[1:] != (2,) or not np.isfinite(p).all() for p in places):
                raise ValueError("a place is not two finite numbers")
            open_ring = [p for p in places if len(p) < 4 or (p[0] != p[-1]).any()]
            if open_ring:
                what = f"a ring is not closed: it begins at {_text(open_ring[0][0])}"
                remedy = "repeat the first place as the last one; a ring has four places or more"
                raise _refused(shape, request, what, remedy)
            found[name] = [(_without_repeats(place), True) for place in places]
    except (
        OSError,
        ValueError,
        KeyError,
        IndexError,
        TypeError,
        AttributeError,
        OverflowError,
        RecursionError,
    ) as error:
        problem = f"cannot be read as GeoJSON: {why_failed(error)}"
        raise _refused(shape, request, problem, "save it as GeoJSON again") from None
    return found


def _system(whole: Any) -> str:
    """Returns the name of the coordinate reference system that a GeoJSON file gives, or ""."""
    system = whole.get("crs") or {}
    return str((system.get("properties") or {}).get("name", ""))


def _require_lengths(lines: Sequence[Line], shape: Outline, request: Request) -> None:
    """Refuses places that are probably longitude and latitude, as RFC 7946 has them.

    Numbers up to 180 and 90 may be lengths, too, but not of an outline that is smaller than a cell,
    and with no unit of length that is so many of another one.
    """
    places = np.concatenate([places for places, _ in lines])
    if (np.abs(places) > np.array([180.0, 90.0])).any():
        return
    size = float(np.ptp(places, axis=0).max())
    short = size * shape.scale < float(request.grid.cell_size.min())
    if short or shape.scale > LARGEST_SCALE:
        what = "its coordinates are those of longitude and latitude in degrees, as GeoJSON has them"
        what += f": the outline would be {size * shape.scale:.3g} long" if short else ""
        what += "" if short else f", and no unit has {shape.scale:g} of another one"
        raise _refused(shape, request, what, PROJECT)


def _polygons(entry: dict[str, Any], name: str) -> Iterator[tuple[str, Any]]:
    """Yields the name and the rings of every polygon in a GeoJSON object."""
    kind = entry["type"]
    if kind == "FeatureCollection":
        for feature in entry["features"]:
            yield from _polygons(feature, name)
    elif kind == "Feature":
        own = (entry.get("properties") or {}).get("name", name)
        if entry.get("geometry"):
            yield from _polygons(entry["geometry"], str(own))
    elif kind in ("Polygon", "MultiPolygon"):
        for rings in [entry["coordinates"]] if kind == "Polygon" else entry["coordinates"]:
            if rings:  # one without is as good as none, by RFC 7946
                yield name, rings


def _closed(lines: Sequence[Line], shape: Outline, request: Request) -> list[Floats]:
    """Returns the closed outlines of lines: those that are closed, and others joined at ends."""
    every = np.concatenate([places for places, _ in lines])
    tolerance = END_TOLERANCE * float(np.ptp(every, axis=0).max())
    loops, parts = [], []
    for places, closed in lines:
        if closed or np.linalg.norm(places[0] - places[-1]) <= tolerance:
            if len(places) > 1 and np.linalg.norm(places[0] - places[-1]) <= tolerance:
                places = places[:-1]
            loops.append(places)
        else:
            parts.append(places)
    while parts:
        chain = parts.pop()
        while np.linalg.norm(chain[-1] - chain[0]) > tolerance:
            ahead = [
                (i, end)
                for i, part in enumerate(parts)
                for end in (0, -1)
                if np.linalg.norm(part[end] - chain[-1]) <= tolerance
            ]
            if len(ahead) != 1:
                what = "is open: no line goes on" if not ahead else "branches: several lines go on"
                problem = f"{_where(shape)} {what} at {_text(chain[-1])}"
                remedy = "join the ends of its lines, each with one other; remove other lines"
                raise _refused(shape, request, problem, remedy)
            number, end = ahead[0]
            part = parts.pop(number)
            chain = np.concatenate([chain, (part if end == 0 else part[::-1])[1:]])
        loops.append(chain[:-1])
    for loop in loops:
        if len(loop) < 3:
            problem = f"{_where(shape)} encloses no area at {_text(loop[0])}"
            raise _refused(shape, request, problem, "remove lines that lie on each other there")
    return loops


def _without_repeats(places: Floats) -> Floats:
    """Returns places (n, 2) without those that repeat the one before."""
    moved = np.ones(len(places), dtype=bool)
    moved[1:] = (np.diff(places, axis=0) != 0.0).any(axis=1)
    return places[moved]


def _area(loop: Floats) -> float:
    (x, y), (u, v) = (loop - loop[0]).T, np.roll(loop - loop[0], -1, axis=0).T
    return 0.5 * abs(math.fsum(x * v - y * u))


def _text(place: Floats) -> str:
    return f"({place[0]:.6g}, {place[1]:.6g}) in the file"
