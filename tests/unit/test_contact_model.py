# SPDX-License-Identifier: BSD-3-Clause
"""Declared laws of contact and rigid bodies, and what a wrong one is told."""

from __future__ import annotations

import copy
import json
import math
from pathlib import Path
from typing import Any

import pytest
from implicit_entries import (
    BLADE,
    BOX,
    CIRCLE,
    PLANE,
    POLYLINE,
    SPHERE,
    boundary,
    entries,
    refused,
    taken_or_refused,
)

import tilth
from tilth import BadInput, Contact, Model, RigidBody
from tilth.analysis.contact_warnings import contact_warnings
from tilth.geometry.make import make_shapes

SMOOTH = {"normal": "unilateral", "tangential": "smooth"}
FRICTION = {"normal": "unilateral", "tangential": "friction", "friction": 0.3}
ROUGH = {"normal": "bilateral", "tangential": "rough"}
HALF = {"normal": "bilateral", "tangential": "adhesion", "adhesion_factor": 0.5}
HELD = {"displacement": {"x": 0, "y": -0.25}, "rotation": 0}
HELD_3D = {"displacement": {"x": 0, "y": 0, "z": -1}, "rotation": {"x": 0, "y": 0, "z": 30}}
GRAVITY = {"type": "body_force", "acceleration": [0, -9.81]}
ELASTIC = {"model": "hencky_elastic", "young_modulus": 1e3, "poisson_ratio": 0.3, "density": 1}
CLAY = {"model": "tresca", "young_modulus": 1e3, "poisson_ratio": 0.3,
        "undrained_shear_strength": 5, "density": 1}  # fmt: skip
SAND = {"model": "mohr_coulomb", "young_modulus": 1e3, "poisson_ratio": 0.3, "cohesion": 0,
        "friction_angle": 30, "dilation_angle": 0, "density": 1}  # fmt: skip
CAM = {"model": "modified_cam_clay", "compression_index": 0.2, "swelling_index": 0.04,
       "critical_state_slope": 1.0, "shear_modulus": 1e3, "overconsolidation_ratio": 2,
       "density": 1}  # fmt: skip


def rigid(geometry: dict[str, Any] | None = CIRCLE, **changed: Any) -> dict[str, Any]:
    """A rigid body as a case file would declare it; what is changed to None is left out."""
    given = {"name": "pipe", "geometry": geometry, "contact": SMOOTH, "centre": [0, 1], **changed}
    return {key: value for key, value in given.items() if value is not None}


def solid(**changed: Any) -> dict[str, Any]:
    return rigid(SPHERE | {"soil": "outside"}, centre=[0, 0, 1], **changed)


def with_bodies(*bodies: dict[str, Any], soil: Any = CLAY, **replaced: Any) -> dict[str, Any]:
    given = entries(boundary(), rigid_bodies=[*bodies], **replaced)
    if replaced.get("kind") == "3d":
        given["boundaries"][0]["geometry"] = {**PLANE, "point": [0, 0, 0], "normal": [0, 0, 1]}
    if soil is CAM:
        stress = {"type": "given", "body": "b", "stress": [-9, -9, -9, 0]}
        given["initial"] = {"stress": [stress]}
    return {**given, "materials": {"m": soil}}


def declared(*bodies: dict[str, Any], **replaced: Any) -> Model:
    return Model.from_dict(with_bodies(*bodies, **replaced))


# --- the law -----------------------------------------------------------------------------------


def test_every_law_is_taken() -> None:
    for normal in ("unilateral", "bilateral"):
        for tangential, keys in (
            ("smooth", {}), ("rough", {}), ("bonded", {}), ("friction", {"friction": 0}),
            ("friction", {"friction": 0.3, "adhesion_factor": 1}),
            ("friction", {"friction": 0.3, "shear_limit": 0}),
            ("adhesion", {"adhesion_factor": 0.5}), ("adhesion", {"shear_limit": 3.0}),
        ):  # fmt: skip
            law = Contact(normal=normal, tangential=tangential, **keys)
            assert law.needs_strength == (tangential == "rough" or "adhesion_factor" in keys)
    assert Contact(**SMOOTH, tensile_strength=2.0).tensile_strength == 2.0


@pytest.mark.parametrize(
    ("changed", "key", "words"),
    [
        ({"friction": -0.1}, "friction", "must not be negative"),
        ({"friction": "a"}, "friction", "must be a number"),
        ({"friction": math.inf}, "friction", "finite"),
        ({"friction": None}, "friction", "missing"),
        ({"tangential": "smooth"}, "friction", 'choose tangential = "friction"'),
        ({"tangential": "rough", "friction": None, "adhesion_factor": 1}, "adhesion_factor",
         'choose tangential = "friction" or "adhesion"'),
        ({"tangential": "bonded", "friction": None, "shear_limit": 1}, "shear_limit", "no meaning"),
        ({"tangential": "adhesion", "friction": None}, "adhesion_factor", "`shear_limit`"),
        ({"adhesion_factor": 1.5}, "adhesion_factor", "between 0 and 1"),
        ({"adhesion_factor": -0.5}, "adhesion_factor", "between 0 and 1"),
        ({"shear_limit": -1}, "shear_limit", "must not be negative"),
        ({"adhesion_factor": 0.5, "shear_limit": 1}, "shear_limit", "leave one of them out"),
        ({"tangential": "frictional"}, "tangential", 'did you mean "friction"?'),
        ({"normal": None}, "normal", "missing"),
        ({"normal": "bilateral", "tensile_strength": 1}, "tensile_strength", "never opens"),
        ({"tensile_strength": 0}, "tensile_strength", "greater than zero"),
        ({"frction": 0.2, "friction": None}, "frction", "did you mean `friction`?"),
    ],
)  # fmt: skip
def test_a_wrong_law(changed: dict[str, Any], key: str, words: str) -> None:
    given = {k: v for k, v in {**FRICTION, **changed}.items() if v is not None}
    with pytest.raises(BadInput) as caught:
        Contact(**given)
    assert caught.value.key == f"Contact.{key}"
    assert len(caught.value.problems) == 1
    assert words in str(caught.value)


# --- on boundaries -------------------------------------------------------------------------------


def in_contact(**changed: Any) -> dict[str, Any]:
    given = {**boundary(contact=FRICTION), **changed}
    return {k: v for k, v in given.items() if k != "condition" or "condition" in changed}


def test_a_boundary_has_a_condition_or_a_contact() -> None:
    model = Model.from_dict(entries(in_contact(displacement={"y": 1}, contact_with={"b": SMOOTH})))
    assert model.boundaries[0].condition is None
    assert model.boundaries[0].kind == "contact"
    assert Model.from_dict(json.loads(json.dumps(model.to_dict()))) == model
    assert Model.from_dict(entries(boundary())).boundaries[0].kind == "roller"
    both_sides = {**POLYLINE, "soil": "both"}
    Model.from_dict(entries(in_contact(geometry=both_sides)))


@pytest.mark.parametrize(
    ("given", "key", "words"),
    [
        (in_contact(condition="fixed"), "condition", "given together with `contact`"),
        (in_contact(direction=[1, 0]), "direction", "no meaning with `contact`"),
        (in_contact(form="band"), "form", "no meaning with `contact`"),
        ({**in_contact(), "contact": None}, "condition", "missing"),
        (boundary(contact_with={"b": SMOOTH}), "contact_with", "no meaning without `contact`"),
        (in_contact(contact={**FRICTION, "friction": -1}), "contact.friction", "not be negative"),
        (in_contact(contact_with={"soil": SMOOTH}), "contact_with.soil", "no body of this name"),
        (in_contact(contact=ROUGH), "contact.tangential", "hencky_elastic"),
        (boundary({**POLYLINE, "soil": "both"}), "geometry", "soil on both sides"),
        (boundary({"type": "plate", "centre": [0, 0], "normal": [0, 1], "width": 1}), "geometry",
         "give `contact` instead"),
    ],
)  # fmt: skip
def test_a_wrong_contact_on_a_boundary(given: dict[str, Any], key: str, words: str) -> None:
    error = refused(entries(given))
    assert error.key == f"boundaries[0].{key}"
    assert len(error.problems) == 1
    assert words in str(error)


# --- rigid bodies --------------------------------------------------------------------------------


def test_a_model_with_rigid_bodies_survives_json_to_the_bit() -> None:
    path = [[0, 0], [0.1, 1 / 3], [1, -0.1]]
    bucket = rigid(None, name="bucket", geometries=[BOX | {"soil": "outside"}, CIRCLE])
    bucket |= {"displacement": {"x": path, "y": 0.1}, "factor": path, "mass": 3, "rotation": path}
    free = rigid(force={"y": -1}, moment=path, springs={"x": 2}, moments_of_inertia=1.5)
    free |= {"contact_with": {"b": HALF}, "force_factor": path}
    model = declared(bucket, free)
    assert Model.from_dict(json.loads(json.dumps(model.to_dict(), allow_nan=False))) == model
    plough = solid(name="plough", **HELD_3D, moments_of_inertia=[1, 2, 3])
    model = declared(plough, kind="3d")
    assert Model.from_dict(json.loads(json.dumps(model.to_dict(), allow_nan=False))) == model


def test_values_of_prescribed_and_free_components() -> None:
    body = RigidBody(
        **rigid(displacement={"x": -2, "y": [[0, 0], [1, 3], [2, 3], [4, 1]]}, moment=5,
                factor=[[0, 0], [1, 1]], springs={"rotation": 7})
    )  # fmt: skip
    assert [body.prescribed("x", t, 4.0) for t in (0, 0.5, 1, 3)] == [0, -1, -2, -2]
    assert [body.prescribed("y", t, 4.0) for t in (0, 0.5, 2, 3, 9)] == [0, 1.5, 3, 2, 1]
    assert body.prescribed("rotation", 1.0, 4.0) is None
    assert body.applied("rotation", 1.0, 4.0) == 1.25  # the ramp to the end of the schedule
    assert body.spring("rotation") == 7.0
    assert [body.applied(c, 1.0, 4.0) for c in ("x", "y")] == [0.0, 0.0]
    assert [body.spring(c) for c in ("x", "y")] == [0.0, 0.0]
    turned = RigidBody(**solid(rotation={"z": 90, "x": [[0, 0], [2, 180]]}, moment={"y": 4}))
    assert turned.prescribed("rotation_z", 1.0, 2.0) == pytest.approx(0.25 * math.pi)
    assert turned.prescribed("rotation_x", 1.0, 2.0) == pytest.approx(0.5 * math.pi)
    assert turned.prescribed("rotation_y", 1.0, 2.0) is None
    assert turned.applied("rotation_y", 1.0, 2.0) == 2.0


def test_components_of_each_kind_of_analysis() -> None:
    assert RigidBody.components(2, "plane_strain") == ("x", "y", "rotation")
    assert RigidBody.components(2, "axisymmetric") == ("y",)
    in_3d = ("x", "y", "z", "rotation_x", "rotation_y", "rotation_z")
    assert RigidBody.components(3, "3d") == in_3d


RIGHT: list[tuple[dict[str, Any], dict[str, Any]]] = [
    (rigid(**HELD), {}),
    (rigid(force={"x": 0, "y": -1}, moment=0), {}),
    (rigid(springs={"x": 1, "y": 1, "rotation": 1}), {}),
    (rigid(mass=2), {"loads": [GRAVITY]}),
    (rigid(displacement={"x": 0}, rotation=0, force={"y": 1}, springs={"y": 2}), {}),
    (rigid({**CIRCLE, "centre": [0, 1]}, displacement={"y": -1}), {"kind": "axisymmetric"}),
    (rigid(contact=HALF, **HELD), {}),
    (rigid(contact=ROUGH, **HELD), {}),
    (rigid(contact=HALF, **HELD), {"soil": {**SAND, "cohesion": 1}}),
    (rigid(contact=ROUGH, **HELD), {"soil": SAND}),
    (rigid(contact=ROUGH, contact_with={"b": SMOOTH}, **HELD), {"soil": ELASTIC}),
    (rigid(contact={**HALF, "adhesion_factor": None, "shear_limit": 1}, **HELD), {"soil": CAM}),
    (solid(**HELD_3D), {"kind": "3d"}),
    (rigid(BLADE, centre=[0, 0, 2], **HELD_3D), {"kind": "3d"}),
    (rigid({**POLYLINE, "soil": "both"}, **HELD), {}),
]


@pytest.mark.parametrize(("body", "replaced"), RIGHT)
def test_rigid_bodies_that_are_taken(body: dict[str, Any], replaced: dict[str, Any]) -> None:
    if "adhesion_factor" in body["contact"] and body["contact"]["adhesion_factor"] is None:
        body = {**body, "contact": {k: v for k, v in body["contact"].items() if v is not None}}
    declared(body, **replaced)


WRONG: list[tuple[dict[str, Any], dict[str, Any], str, str]] = [
    (rigid(None, **HELD), {}, "geometry", "missing"),
    (rigid(geometries=[CIRCLE], **HELD), {}, "geometries", "leave one of them out"),
    (rigid(None, geometries=[], **HELD), {}, "geometries", "must not be empty"),
    (rigid(contact=None, **HELD), {}, "contact", "missing"),
    (rigid(centre=None, **HELD), {}, "centre", "missing"),
    (rigid(centre=[0, 1, 2], **HELD), {}, "centre", "2 components"),
    (rigid(contact={**FRICTION, "friction": -1}, **HELD), {}, "contact.friction", "negative"),
    (rigid(contact_with={"snad": SMOOTH}, **HELD), {}, "contact_with.snad", "no body of this name"),
    (rigid(PLANE, **HELD), {}, "geometry.type", "implicit boundary with `contact`"),
    (rigid({**SPHERE, "soil": "outside"}, **HELD), {}, "geometry.type", "does not exist"),
    (rigid(contact=ROUGH, **HELD), {"soil": ELASTIC}, "contact.tangential", "no shear strength"),
    (rigid(contact=ROUGH, **HELD), {"soil": CAM}, "contact.tangential", '"friction"'),
    (rigid(contact=HALF, **HELD), {"soil": CAM}, "contact.adhesion_factor", "`shear_limit`"),
    (rigid(contact=HALF, **HELD), {"soil": SAND}, "contact.adhesion_factor", "no cohesion"),
    (rigid(contact=ROUGH, **HELD), {"soil": {**SAND, "pore_fluid_bulk_modulus": 1e4}},
     "contact.tangential", "effective stress"),
    (rigid(contact_with={"b": ROUGH}, **HELD), {"soil": ELASTIC}, "contact_with.b.tangential",
     "no shear strength"),
    (rigid(displacement={"x": 0, "y": 1}), {}, "", "nothing acts on rotation"),
    (rigid(), {}, "", "free body without weight or spring: nothing acts on x, y, rotation"),
    (rigid(mass=3), {}, "", "no load of type"),
    (rigid(displacement={"y": 1}, rotation=0), {}, "", "nothing acts on x"),
    (solid(displacement={"x": 0, "y": 0, "z": 0}, rotation={"x": 0, "y": 0}), {"kind": "3d"}, "",
     "nothing acts on rotation_z"),
    (rigid(force={"y": -1}, **HELD), {}, "force.y", "leave out one of `force.y` and `displacement"),
    (rigid(moment=-1, **HELD), {}, "moment", "leave out one of `moment` and `rotation`"),
    (rigid(springs={"x": 1}, **HELD), {}, "springs.x", "`displacement.x` prescribes"),
    (solid(**HELD_3D, moment={"z": 1}), {"kind": "3d"}, "moment.z", "`rotation.z` prescribes"),
    (rigid(springs={"x": -1}, displacement={"y": 0}, rotation=0), {}, "springs.x", "greater than"),
    (rigid(springs={"w": 1}, displacement={"y": 0}, rotation=0), {}, "springs.w", "choose from"),
    (rigid(springs={"rotation_x": 1}, **HELD), {}, "springs.rotation_x", "choose from x, y, rot"),
    (rigid(displacement={"x": 0, "y": 0, "z": 0}, rotation=0), {}, "displacement.z", "choose from"),
    (rigid(displacement={}, rotation=0), {}, "displacement", "must not be empty"),
    (rigid(**{**HELD, "rotation": {"z": 1}}), {}, "rotation", "one rotation, about z"),
    (solid(displacement={"x": 0, "y": 0, "z": 0}, rotation=0), {"kind": "3d"}, "rotation",
     "three components in 3D"),
    (rigid(displacement={"x": 0, "y": -1}), {"kind": "axisymmetric"}, "displacement.x",
     "move along y only"),
    (rigid(displacement={"y": -1}, rotation=0), {"kind": "axisymmetric"}, "rotation", "along y"),
    (rigid(displacement={"y": -1}, moment=[[0, 0], [1, 1]]), {"kind": "axisymmetric"}, "moment",
     "zero by axisymmetry"),
    (rigid(displacement={"y": -1}, springs={"rotation": 1}), {"kind": "axisymmetric"},
     "springs.rotation", "zero by axisymmetry"),
    (rigid(displacement={"y": -1}, centre=[1, 0]), {"kind": "axisymmetric"}, "centre", "x = 0"),
    (rigid(displacement={"y": -1}, moments_of_inertia=1), {"kind": "axisymmetric"},
     "moments_of_inertia", "leave it out"),
    (rigid(moments_of_inertia=[1, 2], **HELD), {}, "moments_of_inertia", "one number"),
    (solid(moments_of_inertia=2, **HELD_3D), {"kind": "3d"}, "moments_of_inertia", "[Ixx, Iyy,"),
    (rigid({"type": "cone", "tip": [0.1, 0], "angle": 60, "radius": 1, "length": 1,
            "soil": "outside"}, displacement={"y": -1}), {"kind": "axisymmetric"}, "geometry.tip",
     "give x = 0"),
    (rigid({"type": "cone", "tip": [0, 0], "angle": 60, "radius": 1, "length": 1, "axis": [1, 1],
            "soil": "outside"}, displacement={"y": -1}), {"kind": "axisymmetric"}, "geometry.axis",
     "axis of symmetry"),
    (rigid({"type": "cone", "tip": [0, 0], "angle": 0.5, "radius": 1, "length": 1,
            "soil": "outside"}, **HELD), {}, "geometry.angle", "between 1 and 180"),
    (rigid({"type": "cone", "tip": [0, 0], "angle": 60, "radius": 1, "length": 1, "axis": "z",
            "soil": "outside"}, **HELD), {}, "geometry.axis", "names the z direction"),
    (rigid(**HELD, mass=0), {}, "mass", "greater than zero"),
    (rigid(**HELD, factor=[[0, 1], [1, 2]]), {}, "factor", "first factor must be 0"),
    (rigid(displacement={"x": [[0, 1], [1, 2]], "y": 0}, rotation=0), {}, "displacement.x",
     "first value must be 0"),
    (rigid(displacement={"x": [[0, 0], [1, 2]], "y": [[0, 0], [1, 2]]}, rotation=[[0, 0], [1, 0]],
           factor=[[0, 0], [1, 2]]), {}, "factor", "no number to multiply"),
    (rigid(**HELD, force_factor=[[0, 0], [1, 2]]), {}, "force_factor", "no number to multiply"),
    (solid(**{**HELD_3D, "rotation": {"x": 0, "y": "1", "z": 0}}), {"kind": "3d"}, "rotation.y",
     "write it without quotes"),
    (solid(**{**HELD_3D, "rotation": {"x": 0, "q": 1, "z": 0}}), {"kind": "3d"}, "rotation.q",
     "names no axis"),
    (rigid(**HELD, dsplacement={"x": 1}), {}, "dsplacement", "unknown key"),
    (rigid({**CIRCLE, "radius": 1e-12}, **HELD), {}, "geometry.radius", "smaller than"),
    (rigid({**CIRCLE, "radius": 1e6}, **HELD), {}, "geometry", "passes through about"),
]  # fmt: skip


@pytest.mark.parametrize(("body", "replaced", "key", "words"), WRONG)
def test_a_wrong_rigid_body(
    body: dict[str, Any], replaced: dict[str, Any], key: str, words: str
) -> None:
    error = refused(with_bodies(body, **replaced))
    assert error.key == ".".join(filter(None, ("rigid_bodies[0]", key)))
    assert words in str(error)
    assert len(error.problems) == 1


def test_names_are_different_among_boundaries_and_rigid_bodies() -> None:
    error = refused(with_bodies(rigid(name="wall", **HELD)))
    assert error.key == "rigid_bodies[0].name"
    assert "is already the name of boundaries[0]" in str(error)
    error = refused(with_bodies(rigid(**HELD), rigid(**HELD)))
    assert error.key == "rigid_bodies[1].name"


def test_rigid_bodies_and_the_rest_of_the_model() -> None:
    wide = {"type": "affine", "name": "a", "deformation_gradient": [[1, 0], [0, 2]],
            "path": "linear"}  # fmt: skip
    alone = {**with_bodies(rigid(**HELD)), "boundaries": []}
    Model.from_dict(alone)  # the simulation checks what they hold
    assert "rigid bodies or contact pairs" in str(refused({**alone, "boundaries": [wide]}))
    follow = {"cell_size": 0.5, "follow": {"boundary": "pipe", "axes": ["y"], "place": [0, 1]}}
    error = refused({**alone, "grid": follow})
    assert error.key == "grid.follow.boundary"
    assert "declare it as an implicit boundary" in str(error)
    force = {"name": "f", "quantity": "reaction", "boundary": "pipe", "component": "y"}
    Model.from_dict({**alone, "track": [force]})


def test_a_mesh_that_is_not_closed_is_named(tmp_path: Path) -> None:
    triangle = "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    file = tmp_path / "blade.stl"
    file.write_text(f"solid s\n{triangle}endloop\nendfacet\nendsolid s\n", encoding="utf-8")
    blade = {"type": "stl", "file": str(file), "soil": "outside"}
    sphere = {**SPHERE, "soil": "outside"}
    body = rigid(None, geometries=[sphere, blade], centre=[0, 0, 0], **HELD_3D)
    model = declared(body, kind="3d")
    with pytest.raises(BadInput, match="repair the mesh") as caught:
        make_shapes(model.rigid_bodies[0], model)
    assert caught.value.key == "rigid_bodies[0].geometries[1].file"


def test_what_is_probably_not_meant_is_warned_of() -> None:
    steep = {**FRICTION, "friction": 20.0}
    footing = {"type": "footing", "centre": [0, 2], "normal": [0, -1], "width": 0.5}
    plate = {**footing, "type": "plate"}
    walls = [in_contact(contact_with={"b": steep}), in_contact(name="base")]
    bodies = [rigid(None, geometries=[plate, footing, POLYLINE], contact=steep, **HELD)]
    found = dict(contact_warnings(Model.from_dict(entries(*walls, rigid_bodies=bodies))))
    assert list(found) == [
        "friction of rigid_bodies[0].contact", "friction of boundaries[0].contact_with.b",
        f"thin sides of {bodies[0]['name']}",
        "one side of rigid_bodies[0].geometries[1]", "one side of rigid_bodies[0].geometries[2]",
    ]  # fmt: skip
    assert "friction = 0.364" in found["friction of rigid_bodies[0].contact"]
    assert not [*contact_warnings(Model.from_dict(entries(boundary())))]


def test_files_of_shapes_are_relative_to_the_case_file(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    text = """
        format = 1
        [[rigid_bodies]]
        geometry = { type = "stl", file = "blade.stl" }
        [[rigid_bodies]]
        geometries = [{ type = "function", function = "shape.py:distance" }]
        """
    case.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        tilth.load_case(case)
    assert [problem.key for problem in caught.value.problems] == [
        "rigid_bodies[0].geometry.file", "rigid_bodies[1].geometries[0].function",
    ]  # fmt: skip
    assert str(tmp_path / "blade.stl") in str(caught.value)


ODD_VALUES = [
    None, True, "", "nonsense", "z", -1, 0, 2.5, 10**400, math.nan, math.inf, [], [1], [1, 2, 3],
    ["a"], [[]], [[0, 0], [0, 1]], [[0, 0], [1, 1]], {}, {"type": "nonsense"}, {"x": "y"},
    {"x": 1}, {"x": [[0, 0], [1, 1]]}, object,
]  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        ("plane_strain", rigid(**HELD, contact_with={"b": HALF}, mass=1, moments_of_inertia=1)),
        ("plane_strain", rigid(force={"x": 0, "y": 1}, springs={"rotation": 1}, moment=1)),
        ("axisymmetric", rigid(force={"y": 1}, force_factor=[[0, 0], [1, 1]])),
        ("3d", solid(**HELD_3D, factor=[[0, 0], [1, 1]])),
    ],
)
def test_any_value_anywhere_is_taken_or_refused_in_plain_words(
    kind: str, given: dict[str, Any]
) -> None:
    Model.from_dict(with_bodies(given, kind=kind))
    for holder in ((), ("contact",), ("displacement",), ("rotation",), ("force",), ("springs",)):
        table = given.get(holder[0], {}) if holder else given
        for key in table if isinstance(table, dict) else ():
            for odd in ODD_VALUES:
                changed = copy.deepcopy(given)
                (changed[holder[0]] if holder else changed)[key] = odd
                model, message = taken_or_refused(with_bodies(changed, kind=kind))
                for jargon in ("Input", "pydantic", "validation", "[key]", "_error"):
                    assert jargon not in message
                if model is None:
                    assert "rigid_bodies[0]" in message
                else:
                    assert Model.from_dict(json.loads(json.dumps(model))).to_dict() == model
