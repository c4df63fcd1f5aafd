# SPDX-License-Identifier: BSD-3-Clause
"""Factors of safety of laws of the user: those of the how-tos, by what they declare of themselves.

The block is that of test_strength_reduction.py: with the yield stress s it fails under the pressure
2 s / sqrt(3).
"""

from __future__ import annotations

import ctypes
import math
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from test_strength_reduction import PRESSURE, block, reduced
from user_laws import BUILT_IN, LAWS, c_compiler, material

from tilth import BadInput, Model
from tilth.model.isotropic import Isotropic
from tilth.mpm.frozen_points import require_reducible

ROOT = Path(__file__).parents[2]
START, SATURATED, RATE = 30.0, 36.0, 2e3
ELASTIC = {"young_modulus": 1e4, "poisson_ratio": 0.3}
VOCE = {**ELASTIC, "yield_stress": START, "saturation_stress": SATURATED, "saturation_rate": RATE}

PYTHON_VOCE = """
import numpy as np


class Voce:
    state_variables = {"strength": "stress"}
    parameter_kinds = {
        "young_modulus": "stiffness", "poisson_ratio": "dimensionless", "yield_stress": "strength",
        "saturation_stress": "strength", "saturation_rate": "per strain",
    }
    state_kinds = {"strength": "strength"}

    def __init__(self, young_modulus, poisson_ratio, yield_stress, saturation_stress,
                 saturation_rate=2e3):
        self.bulk = young_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio))
        self.shear = young_modulus / (2.0 * (1.0 + poisson_ratio))
        self.first, self.last, self.rate = yield_stress, saturation_stress, saturation_rate

    def strength(self, p):
        return self.last - (self.last - self.first) * np.exp(-self.rate * p)

    def initial_state(self, stress):
        return np.full((len(stress), 1), self.first)

    def update(self, trial, plastic_strain, state):
        shear = 2.0 * self.shear
        mean = trial.mean(axis=1, keepdims=True)
        deviator = trial - mean
        norm = np.maximum(np.linalg.norm(deviator, axis=1), 1e-300)
        direction = deviator / norm[:, None]
        size = np.sqrt(1.5) * shear * norm
        flows = size > self.strength(plastic_strain)
        p = plastic_strain.copy()
        for _ in range(50):
            hardening = self.rate * (self.last - self.strength(p))
            excess = size - 1.5 * shear * (p - plastic_strain) - self.strength(p)
            correction = np.where(flows, excess / (1.5 * shear + hardening), 0.0)
            p = p + correction
            if not (correction > 1e-15 * p).any():
                break
        slope = shear + 2.0 / 3.0 * self.rate * (self.last - self.strength(p))
        multiplier = np.sqrt(1.5) * (p - plastic_strain)
        elastic = trial - multiplier[:, None] * direction
        stress = 3.0 * self.bulk * mean + shear * (elastic - mean)
        radial = np.where(flows, shear / slope - multiplier / norm, 0.0)
        projector = np.eye(3) - 1.0 / 3.0
        dyads = direction[:, :, None] * direction[:, None, :]
        scaled = (1.0 - multiplier / norm)[:, None, None] * projector
        tangent = self.bulk + shear * (scaled - radial[:, None, None] * dyads)
        return stress, elastic, tangent, self.strength(p)[:, None]
"""

WRAPPER = """
#include "voce.hpp"

extern "C" int voce(const double* parameters, const double* trial, double plastic_strain,
                    const double* before, double* state, double* kirchhoff, double* elastic,
                    double* tangent) {
  const auto law = tilth::material::Voce::from(parameters);
  auto rows = reinterpret_cast<double(*)[3]>(tangent);
  return law.update(trial, plastic_strain, before, state, kirchhoff, elastic, rows) ? 0 : 1;
}
"""


def model_of(soil: dict[str, Any], **changed: Any) -> Model:
    entries = block({"model": "hencky_elastic"}).to_dict()
    entries["materials"]["soil"] = {**soil, "density": 1.0, **changed}
    return Model.from_dict(entries)


def python_voce(folder: Path, text: str = PYTHON_VOCE, **changed: Any) -> dict[str, Any]:
    (folder / "voce.py").write_text(text, encoding="utf-8")
    parameters = {name: value for name, value in {**VOCE, **changed}.items() if value is not None}
    return {"model": "user_python", "class": f"{folder}/voce.py:Voce", "parameters": parameters}


def page_blocks(language: str) -> str:
    text = (ROOT / "docs" / "howto" / "add_a_material.md").read_text(encoding="utf-8")
    (found,) = re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return str(found)


def documented_voce(folder: Path) -> dict[str, Any]:
    """The header of the page as a compiled law, with the kinds that the page's class declares."""
    compiler = c_compiler().replace("gcc", "g++").replace("/cc", "/c++")
    (folder / "voce.hpp").write_text(page_blocks("cpp"), encoding="utf-8")
    (folder / "wrapper.cpp").write_text(WRAPPER, encoding="utf-8")
    library = folder / "libvoce.so"
    where = ROOT / "cpp" / "tilth" / "material"
    command = [compiler, "-std=c++20", "-O1", "-shared", "-fPIC", f"-I{folder}", f"-I{where}"]
    subprocess.run([*command, str(folder / "wrapper.cpp"), "-o", str(library)], check=True)
    assert hasattr(ctypes.CDLL(str(library)), "voce")
    (folder / "compiled.py").write_text(
        f"import ctypes\n\nvoce = ctypes.CDLL({str(library)!r}).voce\n", encoding="utf-8"
    )
    names: dict[str, Any] = {}
    exec(page_blocks("python"), names)  # declares the class of the page
    declared = names["Voce"]
    assert issubclass(declared, Isotropic)
    further = [name for name in VOCE if name not in ELASTIC]
    return {
        "model": "user_compiled", "function": f"{folder}/compiled.py:voce", **ELASTIC,
        "parameters": [VOCE[name] for name in further],
        "parameter_kinds": [declared.kinds[name] for name in further],
        "state_variables": [{
            "name": "strength", "unit": "stress", "kind": declared.state_kinds["strength"],
            "initial": START,
        }],
    }  # fmt: skip


@pytest.mark.parametrize("law", LAWS)
def test_laws_of_the_how_to_have_the_factor_of_the_law_of_the_core(
    law: str, tmp_path: Path
) -> None:
    """With hardening, in the class and the function a state variable that is a strength itself."""
    expected = reduced(model_of(BUILT_IN))
    assert expected.factor > 2.0 * 60.0 / math.sqrt(3.0) / PRESSURE, "hardening counts"
    found = reduced(model_of(material(law, tmp_path)))
    assert (found.factor, found.above) == (expected.factor, expected.above)
    for one, other in zip(found.trials, expected.trials, strict=True):
        assert one.outcome == other.outcome
        assert one.iterations == other.iterations
        assert one.displacement == pytest.approx(other.displacement, rel=1e-6, nan_ok=True)


@pytest.mark.parametrize("source", ["class", "header of the page"])
def test_voce_hardening_fails_at_its_saturation_stress(source: str, tmp_path: Path) -> None:
    """In the class with the rate that is the default of its argument: a parameter as well."""
    if source == "class":
        soil = python_voce(tmp_path, saturation_rate=None)
    else:
        soil = documented_voce(tmp_path)
    result = reduced(model_of(soil), tolerance=0.001)
    exact = 2.0 * SATURATED / math.sqrt(3.0) / PRESSURE
    assert result.factor - 0.002 <= exact <= result.above + 0.002


def test_voce_without_hardening_is_von_mises(tmp_path: Path) -> None:
    ideal = {"model": "von_mises", **ELASTIC, "yield_stress": START, "hardening_modulus": 0.0}
    expected = reduced(model_of(ideal))
    found = reduced(model_of(python_voce(tmp_path, saturation_stress=START)))
    assert (found.factor, found.above) == (expected.factor, expected.above)


def test_a_wrong_kind_gives_a_wrong_factor(tmp_path: Path) -> None:
    """So the tests above can fail: a rate that is called a pure number hides the hardening."""
    wrong = PYTHON_VOCE.replace('"per strain"', '"dimensionless"')
    result = reduced(model_of(python_voce(tmp_path, wrong)))
    assert result.factor == pytest.approx(2.0 * START / math.sqrt(3.0) / PRESSURE, abs=0.02)


def refused(soil: dict[str, Any], davis: Any = None) -> list[tuple[str, str, str]]:
    """Keys, problems and remedies of a law that cannot be reduced."""
    with pytest.raises(BadInput) as caught:
        require_reducible(model_of(soil), davis)
    return [(each.key, each.problem, each.remedy) for each in caught.value.problems]


def test_a_class_that_leaves_out_a_kind_is_refused(tmp_path: Path) -> None:
    silent = re.sub(r"    parameter_kinds = \{.*?\}\n", "", PYTHON_VOCE, flags=re.DOTALL)
    ((key, problem, remedy),) = refused(python_voce(tmp_path, silent))
    assert key == "materials.soil.class"
    assert "`Voce` in `voce.py` does not say what its parameters `young_modulus`," in problem
    assert remedy.startswith('give the class `parameter_kinds = {"young_modulus": ...')
    assert '"per strain"' in remedy
    one = PYTHON_VOCE.replace(', "saturation_rate": "per strain"', "")
    ((_, problem, _),) = refused(python_voce(tmp_path, one, saturation_rate=None))
    assert "its parameter `saturation_rate` is, so" in problem
    state = PYTHON_VOCE.replace('    state_kinds = {"strength": "strength"}\n', "")
    ((_, problem, remedy),) = refused(python_voce(tmp_path, state))
    assert "its state variable `strength` is, so" in problem
    assert "`state_kinds =" in remedy


def test_a_compiled_law_that_leaves_out_a_kind_is_refused(tmp_path: Path) -> None:
    soil = documented_voce(tmp_path)
    del soil["parameter_kinds"], soil["state_variables"][0]["kind"]
    (first, second) = refused(soil)
    assert first[0] == "materials.soil.parameter_kinds"
    assert "what each of `parameters` is" in first[1]
    assert second[0] == "materials.soil.state_variables[0].kind"
    umat = material("umat_in_c", tmp_path)
    del umat["property_kinds"]
    ((key, _, remedy),) = refused(umat)
    assert key == "materials.soil.property_kinds"
    assert '"strength"' in remedy


def test_laws_that_no_factor_can_reduce_are_refused(tmp_path: Path) -> None:
    soil = documented_voce(tmp_path)
    soil["parameter_kinds"] = ["preconsolidation", "strength", "per strain"]
    ((key, problem, _),) = refused(soil)
    assert key == "materials.soil.model"
    assert "cannot be reduced" in problem
    soil["parameter_kinds"] = ["friction slope", "strength", "per strain"]
    require_reducible(model_of(soil))
    ((key, problem, _),) = refused(soil, davis="B")
    assert key == "materials.soil.model"
    assert "Davis" in problem
    soil["parameter_kinds"] = ["stress", "stress", "per strain"]
    soil["state_variables"][0]["kind"] = "stress"
    with pytest.raises(BadInput, match="nothing can fail"):
        require_reducible(model_of(soil))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"per strain"', '"rate"', "gives 'saturation_rate' the kind 'rate'\n  choose from"),
        ('"saturation_rate":', '"rate":', "names 'rate', which the law does not have"),
        ('state_kinds = {"strength": "strength"}', "state_kinds = 3", "is not a dictionary"),
        ('"strength": "strength"}', '"strength": "strain"}', "has the unit 'stress', but in"),
    ],
)
def test_wrong_kinds_of_a_class_are_errors(
    old: str, new: str, message: str, tmp_path: Path
) -> None:
    soil = python_voce(tmp_path, PYTHON_VOCE.replace(old, new))
    with pytest.raises(BadInput, match=re.escape(message)) as caught:
        assert model_of(soil).laws
    assert caught.value.key == "materials.soil.class"


@pytest.mark.parametrize(
    ("changed", "key", "message"),
    [
        ({"parameter_kinds": ["strength"]}, "parameter_kinds", "has 1 entries, but `parameters`"),
        ({"parameter_kinds": ["rate"] * 3}, "parameter_kinds[0]", "strength"),
        (
            {"state_variables": [{"name": "s", "unit": "-", "kind": "strength", "initial": 0.0}]},
            "state_variables[0].kind", 'is [stress], but `unit` is "-"',
        ),
    ],
)  # fmt: skip
def test_wrong_kinds_in_the_case_file_are_errors(
    changed: dict[str, Any], key: str, message: str
) -> None:
    soil = {
        "model": "user_compiled", "function": "compiled.py:voce", **ELASTIC,
        "parameters": [START, SATURATED, RATE], "state_variables": 1,
    }  # fmt: skip
    with pytest.raises(BadInput) as caught:
        model_of(soil, **changed)
    assert caught.value.key == f"materials.soil.{key}"
    assert message in str(caught.value)
