# SPDX-License-Identifier: BSD-3-Clause
"""Laws of the user that are wrong: one message with file, key, value and remedy; who runs them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from user_laws import UMAT_IN_C, code_blocks, library

from tilth.case import load_case
from tilth.output.folder import REPORT

from .conftest import CASE, Outcome

pytest.importorskip("tilth._core")

Case = Callable[..., Path]
Tilth = Callable[..., Outcome]

CLAY = CASE[CASE.index("[materials.clay]") : CASE.index("[[bodies]]")]

PYTHON = """[materials.clay]
model = "user_python"
class = "clay.py:Clay"
density = 1800

[materials.clay.parameters]
young_modulus = 1e6
poisson_ratio = 0.3
yield_stress = 2e4
hardening_modulus = 1e5

"""

COMPILED = """[materials.clay]
model = "user_compiled"
function = "compiled.py:clay"
young_modulus = 1e6
poisson_ratio = 0.3
parameters = []
state_variables = [{ name = "strength", unit = "stress", initial = 2e4 }]
density = 1800

"""

UMAT = """[materials.clay]
model = "user_umat"
library = "libc_umat.so"
routine = "umat"
properties = [1e6, 0.3, 2e4, 1e5, 0.0]
young_modulus = 1e6
poisson_ratio = 0.3
state_variables = 1
density = 1800

"""

FILE = """import numpy as np

def law(x):
    return x

class Bare:
    def __init__(self, **parameters):
        pass

class Reserved(Bare):
    state_variables = {"volume": "-"}

class Metres(Bare):
    state_variables = {"strength": "m"}

class NoStart(Bare):
    state_variables = {"strength": "stress"}
    def update(self, trial, plastic_strain, state):
        pass

class Fails(Bare):
    calls = 0
    def update(self, trial, plastic_strain, state):
        if len(trial) > 1 and np.abs(trial).max() > 1e-2:
            raise ValueError("no such strain")
        return STRESS

class Shape(Fails):
    def update(self, trial, plastic_strain, state):
        return trial, trial, np.zeros((len(trial), 3)), state

class Words(Fails):
    def update(self, trial, plastic_strain, state):
        return "stress", trial, trial, state

class One(Fails):
    def update(self, trial, plastic_strain, state):
        return trial

class Elastic(Bare):
    def update(self, trial, plastic_strain, state):
        return STRESS

class Nan(Bare):
    def update(self, trial, plastic_strain, state):
        nothing = np.full((len(trial), 3), np.nan)
        return nothing, trial, np.zeros((len(trial), 3, 3)), state
"""

FAILS = FILE.replace(
    "STRESS",
    "1e6 / 1.3 * (trial + 3 / 4 * trial.sum(axis=1, keepdims=True)), trial, "
    "np.tile(1e6 / 1.3 * (np.eye(3) + 3 / 4), (len(trial), 1, 1)), state",
)


def python_class(name: str) -> tuple[str, tuple[str, str]]:
    return PYTHON, ("clay.py:Clay", f"laws.py:{name}")


WRONG: dict[str, tuple[tuple[str, tuple[str, str] | None], list[str]]] = {
    "no file": (
        (PYTHON, ("clay.py:Clay", "mud.py:Clay")),
        ['materials.clay.class = "mud.py:Clay"', "there is no such file", "relative to the case"],
    ),
    "no reference": (
        (PYTHON, ("clay.py:Clay", "clay.Clay")),
        ['materials.clay.class = "clay.Clay"', "does not name a function in a Python file"],
    ),
    "no class": (
        (PYTHON, ("class =", "klass =")),
        ["materials.clay.klass", "did you mean `class`"],
    ),
    "no such class": (
        python_class("Bear"),
        ["materials.clay.class", "`laws.py` has no class `Bear`", "did you mean `Bare`?"],
    ),
    "a function for a class": (
        python_class("law"),
        ["materials.clay.class", "`law` in `laws.py` is a function, not a class"],
    ),
    "another parameter": (
        (PYTHON, ("hardening_modulus", "hardening")),
        ["materials.clay.class", "cannot be made of its parameters", "'hardening'", "keyword"],
    ),
    "a parameter as text": (
        (PYTHON, ("yield_stress = 2e4", 'yield_stress = "2e4"')),
        ['materials.clay.parameters.yield_stress = "2e4"', "must be a number", "without quotes"],
    ),
    "a parameter that is no name": (
        (PYTHON, ("yield_stress =", "yield-stress =")),
        ["materials.clay.parameters", "'yield-stress' is not a name"],
    ),
    "no elastic constants": (
        (PYTHON.replace("young_modulus", "stiffness"), ("clay.py:Clay", "laws.py:NoStart")),
        ["materials.clay.parameters", "moduli, energy, elastic_strain", "young_modulus > 0"],
    ),
    "no update": (python_class("Bare"), ["materials.clay.class", "has no method `update`"]),
    "no initial state": (python_class("NoStart"), ["has no method `initial_state`"]),
    "a name of the results": (
        python_class("Reserved"),
        ["materials.clay.class", "'volume'", "results have already", "another name"],
    ),
    "an unknown unit": (python_class("Metres"), ["'strength'", "the unit 'm'", '"stress"']),
    "a wrong shape": (
        python_class("Shape"),
        ["`update` of the law `Shape` in `laws.py` returned tangent of shape (1, 3)", "(n, 3, 3)"],
    ),
    "no numbers": (python_class("Words"), ["returned a str as stress", "array of real numbers"]),
    "one array": (python_class("One"), ["returned a ndarray, not four arrays", "tangent"]),
    "an unknown state variable": (
        (PYTHON, None),
        ['track[0].variable = "strengths"', "no state variable", "did you mean `strength`?"],
    ),
    "a function that is not compiled": (
        (COMPILED, ("compiled.py:clay", "laws.py:law")),
        ["materials.clay.function", "is a function, not a compiled function", "cfunc"],
    ),
    "a missing package": (
        (COMPILED, ("compiled.py:clay", "package.py:clay")),
        ["materials.clay.function", "No module named 'no_such_package'", "pip install no_such"],
    ),
    "parameters by name": (
        (COMPILED, ("parameters = []", "parameters = { a = 1 }")),
        ["materials.clay.parameters", "must be a list of numbers"],
    ),
    "a state variable without a value": (
        (COMPILED, (", initial = 2e4", "")),
        ["materials.clay.state_variables[0].initial: missing", "Value at the start"],
    ),
    "a negative number of state variables": (
        (UMAT, ("state_variables = 1", "state_variables = -1")),
        ["materials.clay.state_variables = -1", "must be 0 to 1,000"],
    ),
    "a state variable twice": (
        (
            COMPILED,
            ("[{", '[{ name = "strength", unit = "-", initial = 0 }, {'),
        ),
        ['materials.clay.state_variables[1].name = "strength"', "already the name"],
    ),
    "no library": (
        (UMAT, ("libc_umat.so", "libsand.so")),
        ['materials.clay.library = "libsand.so"', "there is no such file"],
    ),
    "a library that is none": (
        (UMAT, ("libc_umat.so", "laws.py")),
        ["materials.clay.library", "cannot be loaded", "gfortran -O2 -shared -fPIC"],
    ),
    "no routine": (
        (UMAT, ('"umat"', '"umat_"')),
        ['materials.clay.routine = "umat_"', "has no routine of this name", "nm -D libc_umat.so"],
    ),
    "a kind that there is not": (
        (COMPILED, ('unit = "stress"', 'unit = "stress", kind = "cohesion"')),
        ['materials.clay.state_variables[0].kind = "cohesion"', '"friction angle"'],
    ),
    "a kind too many": (
        (UMAT, ('routine = "umat"', 'routine = "umat"\nproperty_kinds = ["stiffness"]')),
        ["materials.clay.property_kinds", "has 1 entries, but `properties` has 5"],
    ),
    "other elastic constants": (
        (UMAT, ("young_modulus = 1e6", "young_modulus = 2e6")),
        ["materials.clay: ", "`umat` in `libc_umat.so`", "bulk modulus", "with which the law"],
    ),
}


def written(case: Case, material: str, replaced: tuple[str, str] | None) -> Path:
    """The case with this material, beside all files of laws."""
    if replaced is not None:
        assert material.count(replaced[0]) == 1
        file = case((CLAY, material.replace(*replaced)))
    else:
        file = case(
            (CLAY, material),
            ('quantity = "displacement"', 'quantity = "state"\nvariable = "strengths"'),
            ('component = "y"\n', ""),
        )
    (file.parent / "clay.py").write_text(code_blocks("python")[0], encoding="utf-8")
    (file.parent / "laws.py").write_text(FAILS, encoding="utf-8")
    (file.parent / "package.py").write_text("import no_such_package\n", encoding="utf-8")
    (file.parent / "compiled.py").write_text("clay = 1\n", encoding="utf-8")
    return file


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_before_the_first_step(tilth: Tilth, case: Case, name: str) -> None:
    (material, replaced), parts = WRONG[name]
    file = written(case, material, replaced)
    if material == UMAT:
        library(file.parent, UMAT_IN_C)
    outcome = tilth("check", file)
    assert outcome.code == 2, outcome
    assert "Traceback" not in outcome.err
    assert all(part in outcome.err for part in [str(file), *parts]), outcome.err


def test_an_exception_in_a_step(tilth: Tilth, case: Case, tmp_path: Path) -> None:
    file = written(case, *python_class("Fails"))
    outcome = tilth("run", file, "--out", tmp_path / "out", "--quiet")
    assert outcome.code == 2
    for part in (
        "`update` of the law `Fails` in `laws.py` failed: ValueError: no such strain (line",
        "(in step 1 to time 0.5)",
        "any number of points",
    ):
        assert part in outcome.err, outcome.err
    assert "Traceback" not in outcome.err


@pytest.mark.parametrize("shear", [0.0, 5.0])
def test_a_routine_that_fails(tilth: Tilth, case: Case, tmp_path: Path, shear: float) -> None:
    """It asks for smaller steps by PNEWDT, or is not isotropic: it has a shear stress."""
    numbers = "2e4, 1e5, 0.0", f"2e4, 1e5, {shear}"
    file = written(case, UMAT, numbers if shear else ("1e5, 0.0]", "1e5]"))
    library(tmp_path, UMAT_IN_C)
    outcome = tilth("run", file, "--out", tmp_path / "out", "--quiet")
    assert outcome.code == 1
    words = " ".join(outcome.err.split())
    assert words.startswith("step 1 to time 0.00"), words
    assert "failed: the law `umat` in `libc_umat.so` found no stress for a material" in words


def test_a_law_without_a_stress(tilth: Tilth, case: Case, tmp_path: Path) -> None:
    file = written(case, *python_class("Nan"))
    outcome = tilth("run", file, "--out", tmp_path / "out", "--quiet")
    assert outcome.code == 1
    words = " ".join(outcome.err.split())
    assert "step 1 to time" in words
    assert "the law `Nan` in `laws.py` found no stress for a material point" in words


def test_a_law_that_does_not_say_what_it_is_has_no_factor_of_safety(
    tilth: Tilth, case: Case, tmp_path: Path
) -> None:
    """It is refused before the run; the law itself is good enough for `tilth check`."""
    file = written(case, *python_class("Elastic"))
    assert tilth("check", file).code == 0
    outcome = tilth("safety", file, "--out", tmp_path / "out")
    assert outcome.code == 2, outcome
    for part in (
        str(file),
        "materials.clay.class = ",
        "laws.py:Elastic",
        "does not say what its parameters `young_modulus`, `poisson_ratio`, `yield_stress`, "
        "`hardening_modulus` are, so that its strength cannot be reduced",
        'give the class `parameter_kinds = {"young_modulus": ...',
        '"stiffness", "strength", "hardening"',
    ):
        assert part in outcome.err, outcome.err
    assert "Traceback" not in outcome.err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_who_runs_the_law_says_so_and_the_report_does_not(
    tilth: Tilth, case: Case, tmp_path: Path
) -> None:
    file = written(case, PYTHON, ("2e4", "3e4"))
    code = file.parent / "clay.py"
    marker = tmp_path / "marker"
    code.write_text(f"from pathlib import Path\nPath({str(marker)!r}).touch()\n" + code.read_text())
    assert load_case(file).functions == (f"{code}:Clay",)
    assert not marker.exists()
    outcome = tilth("check", file)
    assert outcome.code == 0, outcome.err
    assert outcome.out.startswith(f"runs the law Clay in {code}\n")
    assert "young_modulus 1e+06, poisson_ratio 0.3, yield_stress 30000" in " ".join(
        outcome.out.split()
    )
    folder = tmp_path / "out"
    assert tilth("run", file, "--out", folder, "--quiet").code == 0
    marker.unlink()
    code.unlink()
    (folder / REPORT).unlink()
    assert tilth("report", folder).code == 0
    assert (folder / REPORT).exists()
    assert not marker.exists()
