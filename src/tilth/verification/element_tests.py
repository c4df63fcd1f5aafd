# SPDX-License-Identifier: BSD-3-Clause
"""Element tests of each law against closed forms: strengths, slopes and stress paths."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.arrays import Floats
from tilth.case import load_element_case
from tilth.element_tests.result import ElementResult
from tilth.element_tests.run import element
from tilth.model import ElementCase, HenckyElastic, VonMises
from tilth.verification.cases import folder_of_cases
from tilth.verification.closed_forms.moduli import Moduli
from tilth.verification.comparison import Comparison, relative, vanishing

PROBLEM = "element_tests"
SOURCE = "closed form"
KPA = "kPa"
EXACT = 1e-9
"""Relative error of what has a closed form for steps of any size."""

Results = dict[tuple[str, str], ElementResult]


def comparisons(long: bool) -> Iterator[Comparison]:
    """All laws; `long` changes nothing."""
    yield from _elastic()
    yield from _clay()


def _made(file: str) -> tuple[ElementCase, Results]:
    """Returns the tests of a case file of this problem, made, by test and material."""
    case = load_element_case(folder_of_cases() / PROBLEM / file)
    return case, {(each.test, each.material): each for each in element(case)}


def _elastic() -> Iterator[Comparison]:
    """Large strains of Hencky elasticity; the stress at the start and the lateral one are zero."""
    case, results = _made("hencky_elastic.toml")
    for (test, name), result in results.items():
        material = case.materials[name]
        assert isinstance(material, HenckyElastic)
        if test == "simple shear":
            yield _error(f"{test}, {name}", *_simple_shear(result, Moduli.of(material)))
        else:
            exact = material.young_modulus * result["axial_strain"]
            yield _error(f"{test}, {name}", result["q"] * _jacobian(result), exact)


def _clay() -> Iterator[Comparison]:
    """Hencky elasticity and von Mises; Kirchhoff stresses are those of the table times J."""
    case, results = _made("case.toml")
    for (test, name), result in results.items():
        material = case.materials[name]
        assert isinstance(material, HenckyElastic | VonMises)
        moduli, of = Moduli.of(material), f"{test}, {name}"
        jacobian = _jacobian(result)
        if test == "oedometer":
            yield _error(of, *_oedometer(result, material, moduli))
        elif test == "isotropic":
            pressure = 10.0 - moduli.bulk * np.log(jacobian)
            yield _error(of, result["p"] * jacobian, pressure)
        elif test == "drained":
            yield _error(of, *_drained(result, material, moduli))
        elif test == "undrained":
            yield _error(f"pore pressure, {of}", *_undrained(result, 40.0))
        elif test == "elastic shear":
            yield _error(of, *_simple_shear(result, moduli))
        elif test == "constant p":
            yield _error(f"volume, {of}", jacobian, np.ones_like(jacobian))
    strength = 80.0
    triaxial, biaxial = results["undrained", "perfect"], results["biaxial", "perfect"]
    yield relative("strength, undrained, perfect", -triaxial["q"][-1], strength, EXACT, SOURCE, KPA)
    difference = biaxial["stress_yy"][-1] - biaxial["stress_xx"][-1]
    in_plane = 2.0 / math.sqrt(3.0) * strength
    yield relative("strength, biaxial, perfect", difference, in_plane, EXACT, SOURCE, KPA)


def _simple_shear(result: ElementResult, moduli: Moduli) -> tuple[Floats, Floats]:
    """Shear stress: the principal logarithmic strains are +- asinh(gamma / 2)."""
    gamma = result["shear_strain"]
    exact = 4.0 * moduli.shear * np.arcsinh(gamma / 2.0) / np.sqrt(4.0 + gamma**2)
    return result["stress_xy"], exact


def _oedometer(
    result: ElementResult, material: HenckyElastic | VonMises, moduli: Moduli
) -> tuple[Floats, Floats]:
    """Axial Kirchhoff stress of the first loading, computed and exact.

    The radial return is exact under proportional strain: beyond yield the slope is that of the
    elastic material less (2 G)^2 / (3 G + H) times 2/3.
    """
    loading = result["stage"] <= 1.0
    strain = result["axial_strain"][loading]
    computed = (result["stress_yy"] * _jacobian(result))[loading]
    deviator = 2.0 * moduli.shear * strain
    plastic = np.zeros_like(strain)
    if isinstance(material, VonMises):
        excess = np.maximum(deviator - material.initial_yield_stress, 0.0)
        plastic = excess / (3.0 * moduli.shear + material.hardening_modulus)
    deviator = deviator - 3.0 * moduli.shear * plastic
    return computed, 10.0 + moduli.bulk * strain + 2.0 / 3.0 * deviator


def _drained(
    result: ElementResult, material: HenckyElastic | VonMises, moduli: Moduli
) -> tuple[Floats, Floats]:
    """Kirchhoff q, computed, and from the strains and the yield stress."""
    jacobian, shearing = _jacobian(result), result["stage"] == 2.0
    shear_strain = 2.0 / 3.0 * (result["strain_yy"] - result["strain_xx"])
    exact = 3.0 * moduli.shear * shear_strain
    if isinstance(material, VonMises):
        excess = np.maximum(exact - material.initial_yield_stress, 0.0)
        exact = exact - 3.0 * moduli.shear * excess / (
            3.0 * moduli.shear + material.hardening_modulus
        )
    return (result["q"] * jacobian)[shearing], exact[shearing]


def _undrained(result: ElementResult, q_at_start: float) -> tuple[Floats, Floats]:
    """Excess pore pressure: the mean effective and the total lateral stress remain."""
    return result["excess_pore_pressure"], (result["q"] - q_at_start) / 3.0


def _jacobian(result: ElementResult) -> Floats:
    return np.exp(-result["volumetric_strain"])


def _error(quantity: str, computed: Floats, exact: Floats, tolerance: float = EXACT) -> Comparison:
    """Returns the largest error over the path, over the largest exact value."""
    error = float(np.abs(computed - exact).max() / np.abs(exact).max())
    return vanishing(f"largest error along the path, {quantity}", error, tolerance, SOURCE)
