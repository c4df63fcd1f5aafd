# SPDX-License-Identifier: BSD-3-Clause
"""The JSON schema of case files: what the loader takes it takes, and it finds what is misspelt."""

import sys
from pathlib import Path
from typing import Any

import pytest
from example_cases import ALL, ANALYSES, ELEMENT_TESTS, EXAMPLES
from jsonschema import Draft202012Validator

import tilth
from tilth.model.json_schema import case_schema, element_schema

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

CASE = Draft202012Validator(case_schema())
ELEMENT = Draft202012Validator(element_schema())


def entries(case: Path) -> dict[str, Any]:
    return tomllib.loads(case.read_text(encoding="utf-8"))


@pytest.mark.parametrize("validator", [CASE, ELEMENT], ids=["analysis", "element"])
def test_the_schema_is_one(validator: Draft202012Validator) -> None:
    Draft202012Validator.check_schema(validator.schema)
    assert validator.schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"


@pytest.mark.parametrize("case", ALL, ids=lambda case: f"{case.parent.name}-{case.stem}")
def test_every_example_is_accepted_by_its_schema_alone(case: Path) -> None:
    ours, other = (ELEMENT, CASE) if case in ELEMENT_TESTS else (CASE, ELEMENT)
    assert [error.message for error in ours.iter_errors(entries(case))] == []
    assert not other.is_valid(entries(case))


def changed(path: str, value: Any, example: str = "plough") -> dict[str, Any]:
    """The entries of an example, with one more or another value at a path; None removes it."""
    whole = table = entries(EXAMPLES / example / "case.toml")
    *above, last = path.split(".")
    for key in above:
        table = table[int(key)] if key.isdigit() else table[key]
    if value is None:
        del table[last]
    else:
        table[last] = value
    return whole


MISSPELT = [
    "boddies", "analysis.kimd", "grid.cellsize", "materials.clay.young_modulos",
    "bodies.0.point_per_cell", "bodies.0.shape.lowwer", "boundaries.0.conditions",
    "boundaries.0.name_of", "loads.0.accel", "schedule.step", "track.0.quantty",
]  # fmt: skip


@pytest.mark.parametrize("path", MISSPELT)
def test_a_misspelt_key_is_found(path: str) -> None:
    example = "plough" if path.split(".")[0] != "loads" else "collapse"
    whole = changed(path, 1, example)
    with pytest.raises(tilth.BadInput):  # as the loader
        tilth.Model.from_dict(whole)
    (error,) = CASE.iter_errors(whole)
    places = [error, *(error.context or [])]
    name = path.rpartition(".")[2]
    assert any(f"'{name}' was unexpected" in place.message for place in places)


WRONG = {
    "format": 2,
    "analysis.kind": "plain_strain",
    "materials.clay.model": "von_misses",
    "bodies.0.basis": "gump",
    "bodies.0.points_per_cell": 0,
    "bodies.0.shape.type": "ball",
    "boundaries.0.condition": "rolling",
    "materials.clay.young_modulus": "200e3",
    "materials.clay.density": True,
    "grid.cell_size": {"u": 1.0},
    "schedule.steps": 2.5,
}


@pytest.mark.parametrize("path", WRONG)
def test_a_wrong_value_is_found(path: str) -> None:
    assert not CASE.is_valid(changed(path, WRONG[path]))


REQUIRED = [
    "format", "analysis", "analysis.kind", "grid", "bodies", "materials.clay.model",
    "materials.clay.poisson_ratio", "bodies.0.shape", "boundaries.0.type", "schedule",
]  # fmt: skip


@pytest.mark.parametrize("path", REQUIRED)
def test_a_missing_key_is_found(path: str) -> None:
    assert not CASE.is_valid(changed(path, None))


@pytest.mark.parametrize("key", ["material", "axial_strian", "drained"])
def test_wrong_element_tests_are_found(key: str) -> None:
    case = ELEMENT_TESTS[0]
    value = {"material": 1.0, "axial_strian": 0.1, "drained": True}[key]
    whole = entries(case)
    whole["tests"][0][key] = value
    assert not ELEMENT.is_valid(whole)


def test_parameters_that_vary_are_accepted() -> None:
    for value in (
        {"depth": [[0, 5e3], [10, 2e4]], "surface": 0.0},
        "properties.py:modulus",
        {"function": "properties.py:modulus"},
    ):
        assert CASE.is_valid(changed("materials.clay.young_modulus", value))
    assert not CASE.is_valid(changed("materials.clay.young_modulus", {"depht": [[0, 1]]}))


def test_keys_have_the_descriptions_of_the_reference() -> None:
    tables = CASE.schema["$defs"]
    cell_size = tables["Grid"]["properties"]["cell_size"]["description"]
    assert cell_size == tilth.model.base.meaning_of(tilth.Grid, "cell_size")
    assert "[length]" in cell_size
    bare = [
        f"{name}.{key}"
        for name, table in tables.items()
        for key, entry in table["properties"].items()
        if "description" not in entry and "const" not in entry
    ]
    assert bare == []


def test_the_loader_takes_the_line_that_names_the_schema(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    text = (EXAMPLES / "collapse" / "case.toml").read_text(encoding="utf-8")
    case.write_text(f"#:schema ./tilth.schema.json\n{text}", encoding="utf-8")
    assert tilth.load_case(case) == tilth.load_case(EXAMPLES / "collapse" / "case.toml")


def test_there_are_examples_of_both() -> None:
    assert len(ANALYSES) > 100
    assert len(ELEMENT_TESTS) > 1
