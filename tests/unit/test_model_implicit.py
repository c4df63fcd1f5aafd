# SPDX-License-Identifier: BSD-3-Clause
"""Declared implicit boundaries: round trip, and every refused entry named by its key."""

from __future__ import annotations

import copy
import json
import math
import pickle
from typing import Any

import numpy as np
import pytest
from implicit_entries import (
    BLADE,
    BOX,
    CIRCLE,
    CONE,
    CUBE,
    CYLINDER,
    FOOTING,
    FUNCTION,
    MESH,
    PLANE,
    PLATE,
    POLYLINE,
    SLAB,
    SPHERE,
    SPLINE,
    STL,
    TERRAIN,
    WEDGE,
    boundary,
    entries,
    refused,
    taken_or_refused,
)

from tilth.model import ImplicitBoundary, Model
from tilth.model.geometry import GEOMETRIES, BoxGeometry, CylinderGeometry, unit

FLAT = [PLANE, CIRCLE, POLYLINE, SPLINE, BOX, FOOTING, PLATE, WEDGE, FUNCTION, MESH, TERRAIN]
SOLID = [
    {**PLANE, "point": [0, 0, 0.1], "normal": [0, 1, 1]},
    CYLINDER,
    SPHERE,
    CUBE,
    SLAB,
    BLADE,
    CONE,
]
SOLID += [FUNCTION, STL]
SOLID += [{**TERRAIN, "surface": {"file": "z.csv"}, "lower": [0, 0], "upper": [1, 1]}]

TURN = {"angle": 30.0, "centre": [0.0, 1.0]}
RAMP = [[0, 0], [1, 1]]


def test_a_model_with_every_geometry_survives_json_to_the_bit() -> None:
    for kind, geometries in (("plane_strain", FLAT), ("3d", SOLID)):
        walls = [boundary(g, name=g["type"], delta=0.1 / 3) for g in geometries]
        walls[0] |= {"condition": "direction", "direction": [1] * (2 if kind != "3d" else 3)}
        walls[1] |= {"radius_change": 0.1 + 0.2, "displacement": {"y": -1}, "factor": RAMP}
        walls[2] |= {"motion": "motion.py:lift", "form": "band"}
        model = Model.from_dict(entries(*walls, kind=kind))
        given = json.loads(json.dumps(model.to_dict(), allow_nan=False))
        assert Model.from_dict(given) == model
        assert Model.from_dict(given).to_dict() == model.to_dict()
        assert pickle.loads(pickle.dumps(model)) == model
    assert {type(g) for g in (b.geometry for b in model.boundaries)} <= set(GEOMETRIES)
    assert {g["type"] for g in FLAT + SOLID} == {
        cls.model_fields["type"].default for cls in GEOMETRIES
    }


def test_width_of_the_band() -> None:
    model = Model.from_dict(
        entries(boundary(), boundary(name="b", delta=0.125), cell_size=[0.5, 0.25])
    )
    first, second = model.boundaries
    assert model.delta(first) == 0.25e-3
    assert model.delta(second) == 0.125  # half the smallest edge is just allowed


def test_a_boundary_moves_where_a_motion_is_given() -> None:
    assert not ImplicitBoundary(**boundary()).is_moving
    for motion in (
        {"displacement": {"x": 1}},
        {"rotation": TURN},
        {"motion": "motion.py:lift"},
    ):
        assert ImplicitBoundary(**boundary(**motion)).is_moving
    assert ImplicitBoundary(**boundary(CIRCLE, radius_change=-0.1)).is_moving


def test_the_factor_of_a_motion() -> None:
    table = [[0, 0], [0.5, 3], [1, 1]]
    model = Model.from_dict(
        entries(
            boundary(displacement={"x": 1}),
            boundary(name="table", displacement={"x": 1}, factor=table),
        )
    )
    assert [model.load_curve(model.boundaries[0]).factor(t) for t in (0, 0.25, 1)] == [0, 0.25, 1]
    assert [model.load_curve(model.boundaries[1]).factor(t) for t in (0, 0.25, 1)] == [0, 1.5, 1]


def test_directions() -> None:
    assert CylinderGeometry(**CYLINDER).direction == (0, 0, 1)
    oblique = CylinderGeometry(**{**CYLINDER, "axis": np.array([3.0, 0, 4.0])})
    assert oblique.direction == (0.6, 0, 0.8)
    assert unit([0, -1e-320]) == (0, -1)
    assert unit([1.7e308, 1.7e308]) == pytest.approx([math.sqrt(0.5)] * 2, rel=1e-15)
    assert BoxGeometry(**{**BOX, "angle": 90}).axes == ((0, 1), (-1, 0))


def test_what_is_just_right_is_taken() -> None:
    for kind, given in (
        ("axisymmetric", boundary(CIRCLE, displacement={"x": 0.1}, radius_change=0.1)),
        ("axisymmetric", boundary(condition="direction", direction=[1, 1])),
        ("plane_strain", boundary(rotation=TURN)),
        ("plane_strain", boundary({**POLYLINE, "closed": True})),
        ("plane_strain", boundary({**POLYLINE, "vertices": [[0, 0], [1, 0]]})),
        ("plane_strain", boundary({**SPLINE, "corners": [], "closed": True})),
        ("axisymmetric", boundary({**SPLINE, "soil": "right"}, displacement={"y": 1})),
        ("plane_strain", boundary({**BOX, "faces": ["x-", "y+"], "angle": 30})),
        ("plane_strain", boundary(CIRCLE, radius_change=-0.3, factor=[[0, 0], [1, 0.99]])),
        ("3d", boundary(CUBE | {"angle": 30, "axis": "x", "faces": ["z-"]})),
        ("3d", boundary(CYLINDER, rotation={**TURN, "centre": [0, 0, 0], "axis": "x"})),
    ):
        Model.from_dict(entries(given, kind=kind))


def test_a_roller_alone_is_left_to_the_simulation() -> None:
    """What an implicit boundary holds is known only where it touches soil."""
    base = {"type": "plane", "name": "base", "axis": "y", "at": 0, "condition": "roller"}
    assert refused(entries(base)).key == "boundaries"
    Model.from_dict(entries(base, boundary()))


GEOMETRY = "boundaries[0].geometry"
WRONG_GEOMETRIES = [
    (SPHERE, "plane_strain", ".type", 'does not exist with analysis.kind = "plane_strain"'),
    (STL, "axisymmetric", ".type", "does not exist"),
    (CYLINDER, "plane_strain", ".type", "does not exist"),
    (CIRCLE, "3d", ".type", "does not exist"),
    (POLYLINE, "3d", ".type", "does not exist"),
    ({"type": "plain"}, "3d", ".type", 'did you mean "plane"?'),
    ({"point": [0, 0]}, "3d", ".type", "missing"),
    ({**PLANE, "normal": [0, 0]}, "plane_strain", ".normal", "zero vector"),
    ({**PLANE, "normal": [0, 5e-324]}, "plane_strain", ".normal", "shorter than 1e-30"),
    ({**PLANE, "normal": [0, 0, 1]}, "plane_strain", ".normal", "must have 2 components"),
    ({**PLANE, "normal": [0, 0, 1]}, "3d", ".point", "must have 3 components"),
    ({**CIRCLE, "centre": [0]}, "plane_strain", ".centre", "must have 2 components"),
    ({**CIRCLE, "centre": [-0.1, 0]}, "axisymmetric", ".centre", "keep the centre at x >= 0"),
    ({**CIRCLE, "radius": 0}, "plane_strain", ".radius", "greater than zero"),
    ({**CIRCLE, "soil": "left"}, "plane_strain", ".soil", '"inside", "outside"'),
    ({"type": "circle", "centre": [0, 0], "radius": 1}, "plane_strain", ".soil", "missing"),
    ({**CYLINDER, "axis": [0, 0, 0]}, "3d", ".axis", "zero vector"),
    ({**CYLINDER, "axis": [0, 0, 1e-200]}, "3d", ".axis", "shorter than 1e-30"),
    ({**CYLINDER, "axis": "w"}, "3d", ".axis", "names no axis"),
    ({**CYLINDER, "axis": [1, 0]}, "3d", ".axis", "must have 3 components"),
    ({**POLYLINE, "vertices": [[0, 0]]}, "plane_strain", ".vertices", "two vertices"),
    (
        {**POLYLINE, "vertices": [[0, 0], [1, 0]], "closed": True},
        "plane_strain", ".vertices", "three vertices",
    ),
    ({**POLYLINE, "vertices": [[0, 0], [0, 0]]}, "plane_strain", ".vertices", "right after itself"),
    ({**POLYLINE, "vertices": [[0, 0, 0], [1, 0, 0]]}, "3d", ".vertices", "two coordinates"),
    (
        {**POLYLINE, "vertices": [[0, 0], [2, 0], [1, 1], [1, -1]]},
        "plane_strain", ".vertices", "intersect each other",
    ),
    (
        {**POLYLINE, "vertices": [[0, 0], [2, 0], [1, 0]]},
        "plane_strain", ".vertices", "intersect each other",
    ),
    (
        {**POLYLINE, "vertices": [[0, 0], [1, 0], [1, 1], [0, 0]]},
        "plane_strain", ".vertices", "set closed = true",
    ),
    (
        {**POLYLINE, "vertices": [[0, 0], [1, 0], [1, 1], [0, 0]], "closed": True},
        "plane_strain", ".vertices", "leave the last vertex out",
    ),
    (
        {**POLYLINE, "vertices": [[0, 0], [1, 1], [1, 0], [0, 1]], "closed": True},
        "plane_strain", ".vertices", "intersect each other",
    ),
    (SPLINE, "3d", ".type", "does not exist"),
    ({**SPLINE, "vertices": [[0, 0, 0], [1, 0, 0]]}, "plane_strain", ".vertices", "points in 2D"),
    ({**SPLINE, "corners": [1, 4]}, "plane_strain", ".corners", "numbered from 0 to 3"),
    ({**SPLINE, "corners": [-1]}, "plane_strain", ".corners", "must not be negative"),
    ({**SPLINE, "corners": 2}, "plane_strain", ".corners", "must be a list of whole numbers"),
    ({**SPLINE, "soil": "inside"}, "plane_strain", ".soil", '"left", "right"'),
    ({"type": "spline", "soil": "left"}, "plane_strain", ".vertices", "missing"),
    ({**BOX, "upper": [1, 0]}, "plane_strain", ".upper", "must exceed `lower`"),
    ({**BOX, "axis": "z"}, "plane_strain", ".axis", "3D only"),
    ({**CUBE, "angle": 5}, "3d", ".axis", "missing"),
    ({**BOX, "faces": ["z-"]}, "plane_strain", ".faces", "names the z direction"),
    ({**BOX, "faces": ["top"]}, "plane_strain", ".faces[0]", "not one of the choices"),
    ({**BOX, "faces": []}, "plane_strain", ".faces", "must not be empty"),
    ({**BOX, "faces": "x-"}, "plane_strain", ".faces", "must be a list of faces"),
    ({**BOX, "faces": ["x-", "x-"]}, "plane_strain", ".faces", "names a face twice"),
    ({**FOOTING, "width": -1}, "plane_strain", ".width", "greater than zero"),
    ({**FOOTING, "width": [1, 1]}, "plane_strain", ".width", "must be one number in 2D"),
    ({**SLAB, "width": 1}, "3d", ".width", "must be two numbers in 3D"),
    ({**FOOTING, "along": [1, 0]}, "plane_strain", ".along", "3D only"),
    ({**SLAB, "along": [0, 0, 3]}, "3d", ".along", "parallel to `normal`"),
    ({**SLAB, "along": [0, 0, 0]}, "3d", ".along", "zero vector"),
    ({k: v for k, v in SLAB.items() if k != "along"}, "3d", ".along", "missing"),
    ({**FUNCTION, "function": "shape.py"}, "plane_strain", ".function", "does not name a function"),
    ({**FUNCTION, "function": ":f"}, "plane_strain", ".function", "does not name a function"),
    ({**FUNCTION, "function": "a.py:b c"}, "plane_strain", ".function", "does not name a function"),
    ({**STL, "file": " "}, "3d", ".file", "must not be empty"),
]  # fmt: skip


@pytest.mark.parametrize(("geometry", "kind", "key", "words"), WRONG_GEOMETRIES)
def test_wrong_geometries(geometry: dict[str, Any], kind: str, key: str, words: str) -> None:
    error = refused(entries(boundary(geometry), kind=kind))
    assert error.key == GEOMETRY + key
    assert words in str(error)
    assert len(error.problems) == 1


MOVED = {"displacement": {"y": 1}}


@pytest.mark.parametrize(
    ("given", "kind", "key", "words"),
    [
        (boundary(condition="free"), "plane_strain", "condition", '"tangential"'),
        (boundary(condition="direction"), "plane_strain", "direction", "missing"),
        (boundary(direction=[1, 0]), "plane_strain", "direction", 'choose condition = "direction"'),
        (
            boundary(condition="direction", direction=[0, 0]),
            "plane_strain", "direction", "zero vector",
        ),
        (
            boundary(condition="direction", direction=[0, 0, 1]),
            "plane_strain", "direction", "must have 2 components",
        ),
        (boundary(delta=0), "plane_strain", "delta", "greater than 0 and at most 0.25"),
        (boundary(delta=-1e-4), "plane_strain", "delta", "greater than 0 and at most 0.25"),
        (boundary(delta=0.2500001), "plane_strain", "delta", "half the smallest edge"),
        (boundary(form="line"), "plane_strain", "form", '"surface", "band"'),
        (boundary(displacement={}), "plane_strain", "displacement", "must not be empty"),
        (boundary(displacement={"z": 1}), "plane_strain", "displacement", "z direction"),
        (boundary(rotation={"angle": 3}), "plane_strain", "rotation.centre", "missing"),
        (
            boundary(rotation={**TURN, "axis": "z"}),
            "plane_strain", "rotation.axis", "3D only",
        ),
        (
            boundary(SPHERE, rotation={**TURN, "centre": [0, 0, 0]}),
            "3d", "rotation.axis", "missing",
        ),
        (
            boundary(SPHERE, rotation={**TURN, "axis": "z"}),
            "3d", "rotation.centre", "must have 3 components",
        ),
        (boundary(rotation=TURN), "axisymmetric", "rotation", "break the axisymmetry"),
        (boundary(radius_change=0.1), "plane_strain", "radius_change", "has no radius"),
        (boundary(CIRCLE, radius_change=-0.3), "plane_strain", "radius_change", "at factor 1"),
        (
            boundary(CIRCLE, radius_change=0.1, factor=[[0, 0], [0.5, -4], [1, 1]]),
            "plane_strain", "radius_change", "becomes -0.1 at factor -4",
        ),
        *(
            (boundary(CIRCLE, volume_loss=v), "plane_strain", "volume_loss", "between 0 and 1")
            for v in (0, 1, -0.02, 2)
        ),
        (boundary(volume_loss=0.02), "plane_strain", "volume_loss", "has no radius"),
        (
            boundary(CIRCLE, volume_loss=0.02, radius_change=-0.1),
            "plane_strain", "volume_loss", "given together with `radius_change`",
        ),
        (
            boundary(CIRCLE, volume_loss=0.4, factor=[[0, 0], [1, 3]]),
            "plane_strain", "volume_loss", "becomes 0 at factor 3",
        ),
        (boundary(CIRCLE, volume_loss=0.02), "axisymmetric", "volume_loss", "a sphere or a ring"),
        (boundary(motion="lift"), "plane_strain", "motion", "does not name a function"),
        (
            boundary(CIRCLE, motion="m.py:lift", radius_change=0.1, **MOVED),
            "plane_strain", "motion", "together with `displacement` and `radius_change`",
        ),
        (boundary(factor=RAMP), "plane_strain", "factor", "nothing to scale"),
        (
            boundary(factor=[[0, 1], [1, 1]], **MOVED),
            "plane_strain", "factor", "first factor must be 0",
        ),
        (boundary(components=["x"]), "plane_strain", "components", "unknown key"),
        (boundary(deltas=1), "plane_strain", "deltas", "did you mean `delta`?"),
    ],
)  # fmt: skip
def test_wrong_entries(given: dict[str, Any], kind: str, key: str, words: str) -> None:
    error = refused(entries(given, kind=kind))
    assert error.key == f"boundaries[0].{key}"
    assert words in str(error)
    assert len(error.problems) == 1


def test_an_affine_motion_stands_alone() -> None:
    drive = {
        "type": "affine", "name": "drive", "deformation_gradient": [[1, 0], [0, 1]],
        "path": "linear",
    }  # fmt: skip
    assert "cannot be combined" in str(refused(entries(boundary(), drive)))


BASE = {"type": "plane", "name": "base", "axis": "y", "at": 0, "condition": "fixed"}
MOMENT = {
    "name": "m", "quantity": "moment", "boundary": "wall", "about": [0, 0], "component": "z",
}  # fmt: skip
DEPTH = {"name": "d", "quantity": "penetration", "boundary": "wall"}


@pytest.mark.parametrize(
    ("tracked", "kind", "key", "words"),
    [
        ({**MOMENT, "component": "x"}, "plane_strain", "component", 'give component = "z"'),
        ({**MOMENT, "component": "xy"}, "plane_strain", "component", '"x", "y", "z"'),
        ({**MOMENT, "about": [0, 0, 0]}, "plane_strain", "about", "must have 2 components"),
        ({**MOMENT, "boundary": "wal"}, "plane_strain", "boundary", "did you mean `wall`?"),
        (
            {k: v for k, v in MOMENT.items() if k != "about"},
            "plane_strain", "about", "`boundary` and `about` and `component`",
        ),
        (MOMENT, "axisymmetric", "quantity", "no moment in axisymmetry"),
        ({**DEPTH, "boundary": "base"}, "plane_strain", "boundary", "choose from `wall`"),
        ({**DEPTH, "component": "x"}, "plane_strain", "component", "has no meaning"),
        ({**DEPTH, "about": [0, 0]}, "plane_strain", "about", "has no meaning"),
    ],
)  # fmt: skip
def test_wrong_tracked_quantities(tracked: dict[str, Any], kind: str, key: str, words: str) -> None:
    error = refused(entries(boundary(), BASE, kind=kind, track=[tracked]))
    assert error.key == f"track[0].{key}"
    assert words in str(error)
    assert len(error.problems) == 1


def test_tracked_quantities_of_boundaries() -> None:
    reaction = {"name": "r", "quantity": "reaction", "boundary": "wall", "component": "y"}
    Model.from_dict(entries(boundary(), track=[reaction, MOMENT, DEPTH]))
    Model.from_dict(entries(BASE, track=[{**MOMENT, "boundary": "base"}]))
    tracked = [{**MOMENT, "name": c, "component": c, "about": [0, 0, 0]} for c in ("x", "y", "z")]
    Model.from_dict(entries(boundary(SPHERE), kind="3d", track=tracked))


FOLLOW = {"boundary": "wall", "place": [0.5, 0.1], "axes": ["x"]}


@pytest.mark.parametrize(
    ("follow", "key", "words"),
    [
        ({**FOLLOW, "boundary": "wal"}, "boundary", "did you mean `wall`?"),
        ({**FOLLOW, "boundary": "base"}, "boundary", "choose from `wall`"),
        ({**FOLLOW, "place": [0, 0, 0]}, "place", "must have 2 components"),
        ({**FOLLOW, "axes": ["z"]}, "axes", "z direction"),
        ({**FOLLOW, "axes": []}, "axes", "must not be empty"),
    ],
)
def test_a_grid_that_cannot_follow(follow: dict[str, Any], key: str, words: str) -> None:
    grid = {"cell_size": 0.5, "follow": FOLLOW}
    Model.from_dict(entries(boundary(), BASE, grid=grid))
    error = refused(entries(boundary(), BASE, grid={**grid, "follow": follow}))
    assert error.key == f"grid.follow.{key}"
    assert words in str(error)
    assert len(error.problems) == 1


ODD_VALUES = [
    None, True, "", "nonsense", "z", -1, 0, 2.5, 10**400, math.nan, math.inf, [], [1], [1, 2, 3, 4],
    ["a", "b"], [[]], [[0, 0], [0, 1]], [[1, 2], 3], {}, {"type": "nonsense"}, {"x": "y"}, object,
]  # fmt: skip
FULL = [
    ("plane_strain", boundary(CIRCLE, radius_change=0.1, rotation=TURN, factor=RAMP, **MOVED)),
    ("plane_strain", boundary({**BOX, "faces": ["x-"], "angle": 5}, motion="m.py:f", delta=0.1)),
    ("plane_strain", boundary({**POLYLINE, "closed": True}, condition="direction",
                              direction=[1, 1])),
    ("plane_strain", boundary(SPLINE)),
    ("plane_strain", boundary(FOOTING)),
    ("plane_strain", boundary(FUNCTION)),
    ("3d", boundary(SLAB, rotation={"angle": 1, "centre": [0, 0, 0], "axis": "x"})),
    ("3d", boundary({**CYLINDER, "axis": [1, 0, 0]})),
    ("3d", boundary(STL)),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "given"), FULL)
def test_any_value_anywhere_is_taken_or_refused_in_plain_words(
    kind: str, given: dict[str, Any]
) -> None:
    Model.from_dict(entries(given, kind=kind))
    for holder in ((), ("geometry",), ("rotation",)):
        for key in given.get(holder[0], {}) if holder else given:
            for odd in ODD_VALUES:
                changed = copy.deepcopy(given)
                (changed[holder[0]] if holder else changed)[key] = odd
                model, message = taken_or_refused(entries(changed, kind=kind))
                for jargon in ("Input", "pydantic", "validation", "[key]", "_error"):
                    assert jargon not in message
                if model is None:
                    assert "boundaries[0]" in message
                else:
                    assert Model.from_dict(json.loads(json.dumps(model))).to_dict() == model
