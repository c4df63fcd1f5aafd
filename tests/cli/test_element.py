# SPDX-License-Identifier: BSD-3-Clause
"""`tilth element`: tables, pictures, protection of earlier results, the check, and mistakes."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

CASE = """\
format = 1
title = "Clay"

[units]
stress = "kPa"

[materials.soft]
model = "von_mises"
young_modulus = 5e3
poisson_ratio = 0.3
yield_stress = 40.0
hardening_modulus = 0.0

[materials.stiff]
model = "von_mises"
young_modulus = 2e4
poisson_ratio = 0.3
yield_stress = 80.0
hardening_modulus = 100.0

[[tests]]
name = "drained"
type = "triaxial"
material = ["soft", "stiff"]
start = { isotropic = 100 }
drainage = "drained"
direction = "compression"
axial_strain = 0.1
steps = 12

[[tests]]
name = "fast/shear"
type = "simple_shear"
material = "stiff"
start = { vertical = 100, K0 = 0.9 }
drainage = "undrained"
shear_strain = [0.1, -0.1]
steps = 6

[[plots]]
name = "all of them"
format = "svg"

[[plots]]
name = "shear"
tests = ["fast/shear"]
panels = ["pressure-strain"]
"""

FILES = {
    "all of them.svg",
    "drained.soft.csv",
    "drained.stiff.csv",
    "element_tests.json",
    "fast_shear.stiff.csv",
    "shear.png",
}


@pytest.fixture
def element_case(tmp_path: Path) -> Callable[..., Path]:
    """Writes the case, with each (old, new) piece of its text replaced, to clay.toml."""

    def write(*replaced: tuple[str, str]) -> Path:
        text = CASE
        for old, new in replaced:
            assert text.count(old) == 1, f"{old!r} is not once in the case"
            text = text.replace(old, new)
        file = tmp_path / "clay.toml"
        file.write_text(text, encoding="utf-8")
        return file

    return write


def names(folder: Path) -> set[str]:
    return {file.name for file in folder.iterdir()}


def test_tables_and_pictures_are_written(tilth, element_case, tmp_path: Path) -> None:
    outcome = tilth("element", element_case())
    assert outcome.code == 0, outcome.err
    folder = tmp_path / "clay"
    assert f"results in {folder}" in outcome.out
    assert "fast/shear" in outcome.out
    assert names(folder) == FILES
    with (folder / "drained.stiff.csv").open(encoding="utf-8") as file:
        headings, *rows = csv.reader(file)
    assert len(rows) == 13
    table = np.array(rows, dtype=float)
    q = table[:, headings.index("q (compression positive) [kPa]")]
    strain = table[:, headings.index("axial_strain (compression positive) [-]")]
    assert strain[-1] == 0.1
    assert q[0] == 0.0
    assert 80.0 < q[-1] < 100.0
    assert table[:, headings.index("stress_xx (compression positive) [kPa]")] == pytest.approx(
        100.0
    )
    assert b"<svg" in (folder / "all of them.svg").read_bytes()
    with (folder / "fast_shear.stiff.csv").open(encoding="utf-8") as file:
        headings = next(csv.reader(file))
    assert "shear_strain [-]" in headings
    assert "q [kPa]" in headings
    assert "excess_pore_pressure (compression positive) [kPa]" in headings


def test_earlier_results_are_protected_and_replaced_as_a_whole(
    tilth, element_case, tmp_path: Path
) -> None:
    out = tmp_path / "results"
    assert tilth("element", element_case(), "--out", out).code == 0
    (out / "notes.csv").write_text("mine", encoding="utf-8")
    again = tilth("element", element_case(), "--out", out)
    assert again.code == 2
    assert "is not empty" in again.err
    assert "--overwrite" in again.err
    renamed = element_case(('name = "drained"', 'name = "slow"'))
    assert tilth("element", renamed, "--out", out, "--overwrite", "--quiet").code == 0
    slow = {name.replace("drained.", "slow.") for name in FILES}
    assert names(out) == slow | {"notes.csv"}, "only what the tests wrote is removed"


@pytest.mark.slow
@pytest.mark.parametrize("text", ["", "{", '{"a": 1}', '["../clay.toml", "../case.csv", 3]'])
def test_a_damaged_list_removes_nothing(tilth, element_case, tmp_path: Path, text: str) -> None:
    case, out = element_case(), tmp_path / "results"
    out.mkdir()
    (tmp_path / "case.csv").write_text("mine", encoding="utf-8")
    (out / "element_tests.json").write_text(text, encoding="utf-8")
    assert tilth("element", case, "--out", out, "--overwrite").code == 0
    assert (tmp_path / "case.csv").exists()
    assert case.exists()


def test_quiet_prints_nothing(tilth, element_case) -> None:
    outcome = tilth("element", element_case(), "--quiet")
    assert (outcome.code, outcome.out, outcome.err) == (0, "", "")


def test_check_compares_the_tangents_and_writes_nothing(
    tilth, element_case, tmp_path: Path
) -> None:
    outcome = tilth("element", element_case(), "--check")
    assert outcome.code == 0, outcome.out
    assert outcome.out.count("passed") == 3
    assert "von_mises" in outcome.out
    assert names(tmp_path) == {"clay.toml"}


def test_check_fails_where_a_tangent_is_wrong(
    tilth, element_case, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tilth.element_tests.check.TOLERANCE", 1e-16)
    outcome = tilth("element", element_case(), "--check")
    assert outcome.code == 1
    assert "FAILED" in outcome.out


def test_a_test_beyond_the_strength_leaves_its_table(tilth, element_case, tmp_path: Path) -> None:
    path = (
        'type = "path"\nstress = { xx = [[0, 100], [1, 100]], yy = [[0, 100], [1, 500]], '
        "zz = [[0, 100], [1, 100]] }"
    )
    sheared = 'type = "triaxial"\n'
    case = element_case(
        (sheared, path + "\n"),
        ('drainage = "drained"\ndirection = "compression"\naxial_strain = 0.1\n', ""),
        ('material = ["soft", "stiff"]', 'material = "soft"'),
    )
    outcome = tilth("element", case)
    assert outcome.code == 1
    assert "1 of 2 tests ended early" in outcome.err
    assert "drained, soft: stage 1, after step " in outcome.err
    assert "Traceback" not in outcome.err
    assert (tmp_path / "clay" / "drained.soft.csv").is_file()
    assert (tmp_path / "clay" / "fast_shear.stiff.csv").is_file()


WRONG = {
    "key": (('steps = 12', 'stesp = 12'), "tests[0].stesp = 12", "did you mean `steps`?"),
    "value": (("axial_strain = 0.1", "axial_strain = 10"), "tests[0].axial_strain = 10", "percent"),
    "material": (
        ('material = "stiff"', 'material = "stif"'), "tests[1].material", "did you mean `stiff`?",
    ),
    "parameter": (
        ("young_modulus = 5e3", "young_modulus = -5e3"), "materials.soft.young_modulus", "greater",
    ),
    "start": (
        ("{ isotropic = 100 }", "{ vertical = 900, K0 = 0.1 }"),
        "tests[0].start", "inside the yield surface",
    ),
    "plot": (('tests = ["fast/shear"]', 'tests = ["fast"]'), "plots[1].tests", "no test"),
    "format": (("format = 1", "format = 2"), "format = 2", "format = 1"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_mistakes_are_named(tilth, element_case, tmp_path: Path, name: str) -> None:
    replaced, key, remedy = WRONG[name]
    outcome = tilth("element", element_case(replaced))
    assert outcome.code == 2
    assert "clay.toml" in outcome.err
    assert key in outcome.err
    assert remedy in outcome.err
    assert "Traceback" not in outcome.err
    assert not any((tmp_path / "clay").glob("*")), "nothing was written"


def test_files_of_the_other_kind_are_named(tilth, case, element_case) -> None:
    assert "make them with: tilth element" in tilth("run", element_case()).err
    assert "make them with: tilth element" in tilth("check", element_case()).err
    outcome = tilth("element", case())
    assert outcome.code == 2
    assert "run it with: tilth run" in outcome.err


def test_other_mistakes_of_the_command(tilth, element_case, tmp_path: Path) -> None:
    missing = tilth("element", tmp_path / "none.toml")
    assert (missing.code, "no such file" in missing.err) == (2, True)
    inside = tilth("element", element_case(), "--out", tmp_path)
    assert (inside.code, "folder of the case file" in inside.err) == (2, True)
    (tmp_path / "clay").write_text("", encoding="utf-8")
    file = tilth("element", element_case())
    assert (file.code, "is a file, not a folder" in file.err) == (2, True)
