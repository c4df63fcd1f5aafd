# SPDX-License-Identifier: BSD-3-Clause
"""The declared model: exact round trip, frozen, and every refused entry named by its key."""

import copy
import json
import math
import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from tilth.errors import BadInput
from tilth.model import (
    AffineBoundary,
    Analysis,
    Body,
    BodyForce,
    Box,
    Grid,
    HenckyElastic,
    Model,
    NodeBoundary,
    PlaneBoundary,
    PointForce,
    Polygon,
    Schedule,
    Track,
    VonMises,
)
from tilth.model.fields import per_direction
from tilth.model.load_curve import LoadCurve

ODD_VALUES = [
    None,
    True,
    "",
    "nonsense",
    "1.0",
    -1,
    0,
    2.5,
    10**400,
    math.nan,
    math.inf,
    [],
    [1],
    [1, 2, 3, 4],
    ["a", "b"],
    [[]],
    [[0, 0], [0, 1]],
    [[1, 2], 3],
    {},
    {"type": "nonsense"},
    {"x": "y"},
    object,
]


def declared() -> Model:
    """A model that uses most of the schema."""
    return Model(
        title="column",
        analysis=Analysis(kind="plane_strain"),
        grid=Grid(cell_size=[0.25, 0.5], limits={"lower": [-1, 0], "upper": [4, 4]}),
        materials={
            "clay": VonMises(
                young_modulus=1e6,
                poisson_ratio=0.1 + 0.2,
                density=1800,
                yield_stress=1e4 / 3,
                hardening_modulus=0,
            ),
            "stiff clay": HenckyElastic(young_modulus=2e6, poisson_ratio=0),
        },
        bodies=[
            Body(
                name="column",
                material="clay",
                shape=Box(lower=[0, 0], upper=[1, 2]),
                basis="gimp",
                points_per_cell=2,
            ),
            Body(
                name="wedge",
                material="clay",
                shape=Polygon(vertices=[[1, 0], [2, 0], [1, 1]]),
                basis="linear",
                spacing=np.array([0.1, 0.2]),
            ),
        ],
        boundaries=[
            PlaneBoundary(name="base", axis="y", at=0, condition="fixed", range={"x": [0, 1]}),
            NodeBoundary(
                name="top",
                at=[0.25, 2],
                condition="prescribed",
                displacement={"y": -0.1},
                factor=[[0, 0], [0.3, 2], [1, 1]],
            ),
        ],
        loads=[
            BodyForce(acceleration=[0, -9.81]),
            PointForce(body="column", at=[1, 2], force=[1, 0], factor=[[0, 1], [1, 1]]),
        ],
        schedule=Schedule(steps=7, output_times=[1 / 3, 0.5]),
        track=[
            Track(name="push", quantity="reaction", boundary="top", component="y", scale=-1e-3),
            Track(name="crest", quantity="top_height", of="domains"),
        ],
    )


def taken_or_refused(entries: dict[str, Any]) -> tuple[dict[str, Any], BadInput | None]:
    """Returns the model of `entries` as a dictionary, or the error; anything else is raised."""
    try:
        return Model.from_dict(entries).to_dict(), None
    except BadInput as error:
        return {}, error


def key_of(error: BadInput) -> list[str]:
    return [problem.key for problem in error.problems]


def test_a_model_survives_json_to_the_bit() -> None:
    model = declared()
    entries = json.loads(json.dumps(model.to_dict(), allow_nan=False))
    again = Model.from_dict(entries)
    assert again == model
    assert again.to_dict() == model.to_dict()
    assert again.materials["clay"].poisson_ratio == 0.1 + 0.2
    assert again.materials["clay"].yield_stress == 1e4 / 3
    assert pickle.loads(pickle.dumps(model)) == model


def test_a_surface_with_its_defaults_survives_json() -> None:
    """What `to_dict` writes for it, `closed` among it, is no vertex of the user's."""
    entries = declared().to_dict()
    entries["bodies"][0]["surface"] = {"spacing": 0.1}
    model = Model.from_dict(entries)
    assert Model.from_dict(json.loads(json.dumps(model.to_dict()))) == model
    entries["bodies"][0]["surface"] = {"closed": False}
    with pytest.raises(BadInput, match="for `vertices` only") as error:
        Model.from_dict(entries)
    assert key_of(error.value) == ["bodies[0].surface.closed"]


def test_a_model_cannot_be_changed() -> None:
    model = declared()
    with pytest.raises(Exception, match="frozen"):
        model.title = "other"
    with pytest.raises(Exception, match="frozen"):
        model.grid.cell_size = 1.0
    assert isinstance(model.bodies, tuple)
    assert isinstance(model.bodies[0].shape.lower, tuple)


def test_numpy_numbers_and_arrays_are_taken_as_numbers() -> None:
    box = Box(lower=np.zeros(2), upper=(np.float32(1), np.int64(2)), angle=Fraction(1, 2))
    assert box.upper == (1.0, 2.0)
    assert [type(u) for u in box.upper] == [float, float]
    assert box.angle == 0.5


def test_directions_of_a_two_dimensional_model() -> None:
    model = declared()
    assert model.dimension == 2
    assert model.cell_size == (0.25, 0.5)
    assert model.origin == (0.0, 0.0)
    assert per_direction(3, 2) == (3, 3)


def test_load_factors() -> None:
    curve = LoadCurve([(0.0, 0.0), (0.5, 2.0), (1.0, -1.0)])
    assert [curve.factor(t) for t in (0, 0.25, 0.5, 0.75, 1, 7)] == [0, 1, 2, 0.5, -1, -1]
    model = declared()
    assert model.load_curve(model.loads[0]).factor(0.25) == 0.25
    assert model.load_curve(model.loads[1]).factor(0.25) == 1.0
    assert model.load_curve(model.boundaries[1]).factor(0.3) == 2.0


def test_only_gimp_points_have_a_domain_update() -> None:
    column, wedge = declared().bodies
    assert column.domain_update == "right_stretch"
    assert wedge.domain_update is None
    entries = wedge.model_dump(exclude_none=True)
    for basis, reason in (
        ("linear", "have no domains"),
        ("cpdi1", "always follow the deformation gradient"),
        ("cpdi2", "always move with the grid"),
    ):
        assert Body(**{**entries, "basis": basis}).domain_update is None
        with pytest.raises(BadInput, match=rf"Body\.domain_update.*{reason}"):
            Body(**{**entries, "basis": basis, "domain_update": "corners"})


def test_deviatoric_radius_is_another_name_of_the_uniaxial_yield_stress() -> None:
    entries = {"young_modulus": 1, "poisson_ratio": 0, "hardening_modulus": 0}
    stress = VonMises(**entries, deviatoric_radius=2.0).initial_yield_stress
    # uniaxial stress s has the deviator s (2/3, -1/3, -1/3)
    assert stress * math.sqrt(4 / 9 + 1 / 9 + 1 / 9) == pytest.approx(2.0, rel=1e-15)
    assert VonMises(**entries, yield_stress=3.0).initial_yield_stress == 3.0
    for wrong in ({}, {"yield_stress": 1, "deviatoric_radius": 1}):
        with pytest.raises(BadInput, match="exactly one of `yield_stress`"):
            VonMises(**entries, **wrong)


def test_a_part_alone_names_itself_and_suggests() -> None:
    with pytest.raises(BadInput) as caught:
        HenckyElastic(young_modulos=1e6, poisson_ratio=0.3)
    assert str(caught.value) == (
        "HenckyElastic.young_modulos = 1000000.0: unknown key\n  did you mean `young_modulus`?"
    )


def test_a_missing_parameter_is_explained() -> None:
    with pytest.raises(BadInput) as caught:
        HenckyElastic(poisson_ratio=0.3)
    assert caught.value.key == "HenckyElastic.young_modulus"
    assert "Young's modulus" in caught.value.remedy


def test_all_wrong_entries_are_reported_together() -> None:
    entries = declared().to_dict()
    entries["materials"]["stiff clay"]["poisson_ratio"] = 0.5
    entries["bodies"][0]["shape"]["lower"] = [0, "a"]
    entries["boundaries"][1]["typo"] = 1
    with pytest.raises(BadInput) as caught:
        Model.from_dict(entries)
    assert key_of(caught.value) == [
        'materials."stiff clay".poisson_ratio',
        "bodies[0].shape.lower",
        "boundaries[1].typo",
    ]
    assert str(caught.value).startswith("3 entries are wrong\n")


def _places(entries: object, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    children = []
    if isinstance(entries, dict):
        children = list(entries.items())
    elif isinstance(entries, list):
        children = list(enumerate(entries))
    return [path] * bool(path) + [p for k, v in children for p in _places(v, (*path, k))]


@pytest.mark.slow
@pytest.mark.parametrize("place", _places(declared().to_dict()), ids=str)
def test_any_value_anywhere_is_taken_or_refused_in_plain_words(
    place: tuple[str | int, ...],
) -> None:
    for odd in ODD_VALUES:
        entries = copy.deepcopy(declared().to_dict())
        target = entries
        for part in place[:-1]:
            target = target[part]
        target[place[-1]] = odd
        model, error = taken_or_refused(entries)
        if error is None:
            assert "NaN" not in json.dumps(model)
            assert "Infinity" not in json.dumps(model)
            continue
        assert error.problems[0].key or odd == []
        for jargon in ("Input", "pydantic", "https", "validation", "[key]", "_error"):
            assert jargon not in str(error)


@pytest.mark.parametrize(
    ("gradient", "path", "problem"),
    [
        ([[1, 0], [0, -1]], "linear", "determinant is -1"),
        ([[1, 0], [0, 0]], "exponential", "determinant is 0"),
        ([[1, 0], [0, 6e-31]], "exponential", "principal stretches are 6e-31 to 1"),
        ([[1, 0], [0, 2e6]], "linear", "principal stretches are 1 to 2e.06"),
        ([[-1, 0], [0, -1]], "linear", "vanishes on the linear path, at factor 0.5"),
        ([[-1, 0], [0, -2]], "exponential", "no principal logarithm"),
        ([[1, 0, 0], [0, 1, 0]], "linear", "square"),
    ],
)
def test_impossible_affine_motions(gradient: list[list[float]], path: str, problem: str) -> None:
    with pytest.raises(BadInput, match=problem):
        AffineBoundary(name="drive", deformation_gradient=gradient, path=path)


def test_an_affine_motion_is_checked_over_its_own_factors() -> None:
    stretch = {"name": "drive", "deformation_gradient": [[0.5, 0], [0, 1]], "path": "linear"}
    assert AffineBoundary(**stretch).path == "linear"
    with pytest.raises(BadInput, match="at factor 2"):
        AffineBoundary(**stretch, factor=[[0, 0], [1, 2.5]])
    rotation = [[0, -1], [1, 0]]
    for path in ("linear", "exponential"):
        AffineBoundary(name="turn", deformation_gradient=rotation, path=path)


def test_an_affine_motion_moves_all_or_the_outer_nodes() -> None:
    stretch = {"name": "drive", "deformation_gradient": [[0.5, 0], [0, 1]], "path": "linear"}
    assert AffineBoundary(**stretch).nodes == "all"
    with pytest.raises(BadInput, match='nodes = "inner": not one of') as error:
        AffineBoundary(**stretch, nodes="inner")
    assert 'choose from "all", "outer"' in str(error.value)
