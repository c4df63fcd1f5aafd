# SPDX-License-Identifier: BSD-3-Clause
"""What is refused because entries of a model, or of one part, do not fit together."""

from typing import Any

import pytest

from tilth import ModifiedCamClay
from tilth.errors import BadInput
from tilth.model import AffineBoundary, Model, NodeBoundary, PlaneBoundary, Track

BOX = {"type": "box", "lower": [0, 0], "upper": [1, 2]}
BASE = {"type": "plane", "name": "base", "axis": "y", "at": 0, "condition": "fixed"}
DRIVE = {
    "type": "affine",
    "name": "drive",
    "deformation_gradient": [[1.2, 0], [0, 1]],
    "path": "linear",
}
GRAVITY = {"type": "body_force", "name": "weight", "acceleration": [0, -10]}
TOP = {"name": "top", "quantity": "displacement", "at": [0, 2], "component": "y"}


def entries(**replaced: Any) -> dict[str, Any]:
    """A valid 2D model as in a case file, with whole sections replaced."""
    body = {"name": "b", "material": "m", "shape": BOX, "basis": "linear", "points_per_cell": 2}
    material = {"model": "hencky_elastic", "young_modulus": 1, "poisson_ratio": 0}
    body.update(replaced.pop("body", {}))
    return {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 0.5},
        "materials": {"m": material},
        "bodies": [body],
        "boundaries": [BASE],
        "schedule": {"steps": 1},
        **replaced,
    }


AXISYMMETRIC = {"kind": "axisymmetric"}
SOLID = {"kind": "3d"}
CUBE = {"type": "box", "lower": [0, 0, 0], "upper": [1, 1, 1]}


@pytest.mark.parametrize(
    ("replaced", "key", "words"),
    [
        ({"boundaries": [BASE, BASE]}, "boundaries[1].name", "already the name of boundaries[0]"),
        (
            {"loads": [GRAVITY, {**GRAVITY, "name": "other"}, GRAVITY]},
            "loads[2].name",
            "already the name of loads[0]",
        ),
        ({"track": [TOP, TOP]}, "track[1].name", "already the name of track[0]"),
        ({"track": [{**TOP, "body": "c"}]}, "track[0].body", "no body of this name"),
        (
            {"track": [{"name": "r", "quantity": "reaction", "boundary": "bas", "component": "x"}]},
            "track[0].boundary",
            "did you mean `base`?",
        ),
        (
            {"loads": [{"type": "point_force", "body": "c", "at": [0, 0], "force": [0, 0]}]},
            "loads[0].body",
            "no body of this name",
        ),
        ({"boundaries": [DRIVE, BASE]}, "boundaries[0].type", "cannot be combined"),
        (
            {"analysis": {"kind": "plane_strain", "tolerance": 0.02}},
            "analysis.tolerance",
            "must be at most 0.01",
        ),
        (
            {"analysis": {"kind": "plane_strain", "tolerance": 0}},
            "analysis.tolerance",
            "must be greater than zero",
        ),
        (
            {"boundaries": [{**DRIVE, "deformation_gradient": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}]},
            "boundaries[0].deformation_gradient",
            "3 x 3",
        ),
        (
            {
                "analysis": AXISYMMETRIC,
                "boundaries": [{**DRIVE, "deformation_gradient": [[1, 0.1], [0, 1]]}],
            },
            "boundaries[0].deformation_gradient",
            "couples radius and axis",
        ),
        (
            {
                "analysis": AXISYMMETRIC,
                "boundaries": [
                    {
                        **DRIVE,
                        "deformation_gradient": [[-1, 0], [0, -1]],
                        "factor": [[0, 0], [1, 0.1]],
                    }
                ],
            },
            "boundaries[0].deformation_gradient",
            "inside out",
        ),
        (
            {"analysis": AXISYMMETRIC, "body": {"shape": {**BOX, "lower": [-0.1, 0]}}},
            "bodies[0].shape",
            "x is the radius",
        ),
        (
            {
                "grid": {"cell_size": 0.5, "limits": {"lower": [0, 0], "upper": [1, 2]}},
                "body": {"shape": {**BOX, "angle": 5}},
            },
            "bodies[0].shape",
            "outside the grid limits",
        ),
        (
            {"boundaries": [{"type": "node", "name": "n", "at": [0, 0.3], "condition": "fixed"}]},
            "boundaries[0].at",
            "y = 0 and 0.5",
        ),
        ({"boundaries": [{**BASE, "at": 1e-6}]}, "boundaries[0].at", "y = 0 and 0.5"),
        ({"boundaries": [{**BASE, "axis": "z"}]}, "boundaries[0].axis", "z direction"),
        (
            {"boundaries": [{**BASE, "components": ["x", "z"]}]},
            "boundaries[0].components",
            "z direction",
        ),
        ({"boundaries": [{**BASE, "range": {"y": [0, 1]}}]}, "boundaries[0].range.y", "normal to"),
        ({"track": [{**TOP, "component": "z"}]}, "track[0].component", "z direction"),
        ({"body": {"shape": {**BOX, "axis": "x"}}}, "bodies[0].shape.axis", "3D only"),
        ({"analysis": SOLID}, "bodies[0].shape.lower", "must have 3 components, not 2"),
        (
            {"analysis": SOLID, "body": {"shape": {**CUBE, "angle": 1}}},
            "bodies[0].shape.axis",
            "missing",
        ),
        ({"body": {"points": [1, 1]}}, "bodies[0].points", "exactly one"),
        ({"bodies": []}, "bodies", "at least one"),
        (
            {"boundaries": [{**BASE, "condition": "roller"}]},
            "boundaries",
            "constrains the x direction",
        ),
    ],
)
def test_entries_that_do_not_fit_together(replaced: dict[str, Any], key: str, words: str) -> None:
    with pytest.raises(BadInput) as caught:
        Model.from_dict(entries(**replaced))
    assert caught.value.key == key
    assert words in str(caught.value)


def test_what_is_just_right_is_taken() -> None:
    assert Model.from_dict(entries()).dimension == 2
    roller = {**BASE, "condition": "roller"}
    Model.from_dict(entries(analysis=AXISYMMETRIC, boundaries=[roller]))
    Model.from_dict(entries(boundaries=[DRIVE]))
    Model.from_dict(entries(boundaries=[{**BASE, "at": 1.5 + 1e-11}]))
    limits = {"lower": [0, 0], "upper": [1, 2]}
    Model.from_dict(entries(grid={"cell_size": 0.5, "limits": limits}))
    grid = {"cell_size": [0.1, 0.3], "origin": [0.05, 0.1]}
    Model.from_dict(entries(grid=grid, boundaries=[{**BASE, "at": 0.1 + 7 * 0.3}]))


def test_directions_held_by_a_boundary() -> None:
    plane = {"name": "b", "axis": "y", "at": 0}
    assert PlaneBoundary(**plane, condition="roller").prescribed(2) == {1: 0.0}
    assert PlaneBoundary(**plane, condition="fixed").prescribed(2) == {0: 0.0, 1: 0.0}
    assert PlaneBoundary(**plane, condition="fixed", components=["x"]).prescribed(2) == {0: 0.0}
    push = PlaneBoundary(**plane, condition="prescribed", displacement={"y": -0.2})
    assert push.prescribed(2) == {1: -0.2}
    assert NodeBoundary(name="n", at=[0, 0, 0], condition="fixed").prescribed(3) == {
        0: 0,
        1: 0,
        2: 0,
    }


@pytest.mark.parametrize(
    ("replaced", "key"),
    [
        ({"condition": "prescribed"}, "displacement"),
        ({"condition": "roller", "displacement": {"y": 1}}, "displacement"),
        ({"condition": "fixed", "factor": [[0, 0], [1, 1]]}, "factor"),
        ({"condition": "roller", "components": ["y"]}, "components"),
        ({"condition": "fixed", "components": []}, "components"),
        ({"condition": "fixed", "components": "xy"}, "components"),
        ({"condition": "fixed", "components": ["x", "x"]}, "components"),
        ({"condition": "prescribed", "displacement": {}}, "displacement"),
        (
            {"condition": "prescribed", "displacement": {"y": 1}, "factor": [[0, 1], [1, 1]]},
            "factor",
        ),
        ({"condition": "fixed", "range": {"x": [1, 0]}}, "range.x"),
        ({"condition": "fixed", "range": {"x": [1]}}, "range.x"),
    ],
)
def test_conditions_with_entries_that_have_no_meaning(replaced: dict[str, Any], key: str) -> None:
    with pytest.raises(BadInput) as caught:
        PlaneBoundary(name="b", axis="y", at=0, **replaced)
    assert caught.value.key == f"PlaneBoundary.{key}"


def test_an_affine_motion_starts_from_the_undeformed_state() -> None:
    with pytest.raises(BadInput, match="first factor must be 0"):
        AffineBoundary(**{**DRIVE, "factor": [[0, 0.5], [1, 1]]})


@pytest.mark.parametrize(
    ("track", "key"),
    [
        ({"quantity": "reaction", "component": "x"}, "boundary"),
        ({"quantity": "reaction", "boundary": "b", "component": "xx"}, "component"),
        ({"quantity": "displacement", "component": "x"}, "at"),
        ({"quantity": "displacement", "at": [0, 0], "component": "xy"}, "component"),
        ({"quantity": "stress", "at": [0, 0], "component": "x"}, "component"),
        ({"quantity": "top_height"}, "of"),
        ({"quantity": "top_height", "of": "points", "axis": "x"}, "axis"),
        ({"quantity": "run_out", "of": "points"}, "axis"),
        ({"quantity": "energy"}, "kind"),
        ({"quantity": "energy", "kind": "elastic", "body": "b"}, "body"),
        ({"quantity": "energy", "kind": "elastic", "name": "time"}, "name"),
        ({"quantity": "energy", "kind": "elastic", "name": "two\nlines"}, "name"),
    ],
)
def test_tracked_quantities_take_their_own_keys(track: dict[str, Any], key: str) -> None:
    with pytest.raises(BadInput) as caught:
        Track(**{"name": "t", **track})
    assert caught.value.key == f"Track.{key}"


def test_a_swelling_index_above_the_compression_index_is_named() -> None:
    given = {"critical_state_slope": 1.0, "shear_modulus": 1e3, "overconsolidation_ratio": 1.5}
    with pytest.raises(BadInput) as error:
        ModifiedCamClay(compression_index=0.1, swelling_index=0.2, **given)
    (problem,) = error.value.problems
    assert (problem.key, problem.value) == ("ModifiedCamClay.swelling_index", 0.2)
    assert "must be smaller than `compression_index` (0.1)" in str(error.value)
