# SPDX-License-Identifier: BSD-3-Clause
"""What a case file of element tests may declare, and what is refused."""

from __future__ import annotations

from typing import Any

import pytest

from tilth import BadInput, ElementCase

CLAY = {
    "model": "von_mises",
    "young_modulus": 1e4,
    "poisson_ratio": 0.3,
    "yield_stress": 80.0,
    "hardening_modulus": 0.0,
}
COMMON = {"name": "first", "material": "clay", "start": {"isotropic": 100.0}, "steps": 10}
OEDOMETER = {**COMMON, "type": "oedometer", "vertical_stress": 200.0}
TRIAXIAL = {
    **COMMON, "type": "triaxial", "drainage": "drained", "direction": "compression",
    "axial_strain": 0.1,
}  # fmt: skip
ISOTROPIC = {**COMMON, "type": "isotropic", "pressure": [200.0, 50.0]}
SHEAR = {**COMMON, "type": "simple_shear", "drainage": "undrained", "shear_strain": 0.1}
ROWS = [[0.0, 100.0], [1.0, 200.0]]
PATH = {**COMMON, "type": "path", "stress": {"xx": ROWS, "yy": ROWS, "zz": ROWS}}


def case_of(*tests: dict[str, Any], **more: Any) -> ElementCase:
    return ElementCase.from_dict(
        {"format": 1, "materials": {"clay": CLAY}, "tests": list(tests), **more}
    )


def test_every_kind_is_read() -> None:
    kinds = (OEDOMETER, TRIAXIAL, ISOTROPIC, SHEAR, PATH, {**TRIAXIAL, "type": "biaxial"})
    case = case_of(*({**test, "name": test["type"]} for test in kinds))
    assert [test.type for test in case.tests] == [test["type"] for test in kinds]
    assert case.tests[0].material == ("clay",)
    assert case.tests[2].pressure == (200.0, 50.0)
    assert [plot.name for plot in case.plots] == ["plots"]


WRONG: dict[str, tuple[dict[str, Any], str, str]] = {
    "no type": ({k: v for k, v in TRIAXIAL.items() if k != "type"}, "tests[0].type", "missing"),
    "unknown type": ({**TRIAXIAL, "type": "triaxal"}, "tests[0].type", 'did you mean "triaxial"'),
    "unknown key": ({**TRIAXIAL, "axial_strian": 0.1}, "tests[0].axial_strian", "unknown key"),
    "no material": ({**TRIAXIAL, "material": []}, "tests[0].material", "must not be empty"),
    "material twice": ({**TRIAXIAL, "material": ["clay", "clay"]}, "tests[0].material", "twice"),
    "unknown material": (
        {**TRIAXIAL, "material": "caly"}, "tests[0].material", "did you mean `clay`",
    ),
    "no start": ({k: v for k, v in TRIAXIAL.items() if k != "start"}, "tests[0].start", "missing"),
    "two starts": (
        {**TRIAXIAL, "start": {"isotropic": 1, "K0": 1}}, "tests[0].start.K0", "together",
    ),
    "half a start": ({**TRIAXIAL, "start": {"vertical": 1}}, "tests[0].start.K0", "missing"),
    "tension": (
        {**TRIAXIAL, "start": {"isotropic": -1}}, "tests[0].start.isotropic", "not be negative",
    ),
    "vertical zero": (
        {**TRIAXIAL, "start": {"vertical": 0, "K0": 1}}, "tests[0].start.vertical", "greater than",
    ),
    "K0 negative": (
        {**TRIAXIAL, "start": {"vertical": 1, "K0": -1}}, "tests[0].start.K0", "not be negative",
    ),
    "steps": ({**TRIAXIAL, "steps": 0}, "tests[0].steps", "at least 1"),
    "many steps": ({**TRIAXIAL, "steps": 10**6}, "tests[0].steps", "at most 100,000"),
    "void ratio": ({**TRIAXIAL, "void_ratio": 0}, "tests[0].void_ratio", "greater than zero"),
    "drainage": ({**TRIAXIAL, "drainage": "half"}, "tests[0].drainage", "not one of"),
    "no drainage": (
        {k: v for k, v in SHEAR.items() if k != "drainage"}, "tests[0].drainage", "missing",
    ),
    "direction": ({**TRIAXIAL, "direction": "up"}, "tests[0].direction", "not one of"),
    "strain in percent": ({**TRIAXIAL, "axial_strain": 10}, "tests[0].axial_strain", "percent"),
    "signed strain": ({**TRIAXIAL, "axial_strain": -0.1}, "tests[0].axial_strain", "greater than"),
    "consolidation": (
        {**TRIAXIAL, "consolidation": {"vertical": 1}}, "tests[0].consolidation.K0", "missing",
    ),
    "shear in percent": ({**SHEAR, "shear_strain": [0.1, 20]}, "tests[0].shear_strain", "percent"),
    "no shear": ({**SHEAR, "shear_strain": []}, "tests[0].shear_strain", "must not be empty"),
    "stress and strain": (
        {**OEDOMETER, "vertical_strain": 0.1}, "tests[0].vertical_stress", "together",
    ),
    "no target": (
        {k: v for k, v in OEDOMETER.items() if k != "vertical_stress"},
        "tests[0].vertical_stress", "missing",
    ),
    "no strain target": (
        {k: v for k, v in ISOTROPIC.items() if k != "pressure"}, "tests[0].pressure", "missing",
    ),
    "suction": ({**OEDOMETER, "vertical_stress": [9, -1]}, "tests[0].vertical_stress", "positive"),
    "pressure": ({**ISOTROPIC, "pressure": 0}, "tests[0].pressure", "compression is positive"),
    "large volume": (
        {**ISOTROPIC, "pressure": None, "volumetric_strain": 9}, "tests[0].volumetric_strain",
        "percent",
    ),
    "large strain": (
        {**OEDOMETER, "vertical_stress": None, "vertical_strain": [9]}, "tests[0].vertical_strain",
        "percent",
    ),
    "not isotropic": (
        {**ISOTROPIC, "start": {"vertical": 1, "K0": 1}}, "tests[0].start.vertical", "isotropic",
    ),
    "both controls": ({**PATH, "strain": {"yy": [[0, 0], [1, 1]]}}, "tests[0].strain.yy", "too"),
    "no control": ({**PATH, "stress": {"xx": ROWS, "yy": ROWS}}, "tests[0].strain.zz", "missing"),
    "component": ({**PATH, "strain": {"ab": ROWS}}, "tests[0].strain.ab", "not one of"),
    "first stress": (
        {**PATH, "stress": {"xx": ROWS, "yy": [[0, 50], [1, 60]], "zz": ROWS}},
        "tests[0].stress.yy", "does not begin with 100",
    ),
    "first strain": ({**PATH, "strain": {"xy": [[0, 1], [1, 2]]}}, "tests[0].strain.xy", "with 0"),
    "large path": ({**PATH, "strain": {"xy": [[0, 0], [1, 9]]}}, "tests[0].strain.xy", "percent"),
    "rows": ({**PATH, "strain": {"xy": [[0, 0]]}}, "tests[0].strain.xy", "two rows"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_wrong_tests_are_refused(name: str) -> None:
    test, key, words = WRONG[name]
    with pytest.raises(BadInput) as error:
        case_of(test)
    assert key in [problem.key for problem in error.value.problems]
    assert words in str(error.value)


def test_wrong_pictures_are_refused() -> None:
    wrong = {
        "plots[0].tests": {"name": "a", "tests": ["fist"]},
        "plots[0].panels[0]": {"name": "a", "panels": ["p-r"]},
        "plots[0].format": {"name": "a", "format": "gif"},
        "plots[0].name": {"name": ""},
        "plots[0].panels": {"name": "a", "panels": []},
    }
    for key, plot in wrong.items():
        with pytest.raises(BadInput) as error:
            case_of(OEDOMETER, plots=[plot])
        assert error.value.key == key


def test_names_of_files_are_unique() -> None:
    with pytest.raises(BadInput, match="same file") as error:
        case_of(OEDOMETER, {**TRIAXIAL, "name": "FIRST"})
    assert error.value.key == "tests[1].name"
    with pytest.raises(BadInput, match="same file"):
        case_of({**OEDOMETER, "name": "a/b"}, {**OEDOMETER, "name": "a:b"})
    plots = [{"name": "a"}, {"name": "A"}]
    with pytest.raises(BadInput, match="same file"):
        case_of(OEDOMETER, plots=plots)


def test_a_case_needs_tests_and_materials() -> None:
    for entries in ({"tests": []}, {"materials": {}}):
        with pytest.raises(BadInput, match="at least one entry"):
            case_of(OEDOMETER, **entries) if "materials" in entries else case_of(**entries)
