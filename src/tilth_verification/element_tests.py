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
from tilth.model import (
    DruckerPrager,
    ElementCase,
    HenckyElastic,
    ModifiedCamClay,
    MohrCoulomb,
    Tresca,
    VonMises,
)
from tilth_verification.cases import folder_of_cases
from tilth_verification.closed_forms.moduli import Moduli
from tilth_verification.comparison import Comparison, relative, vanishing

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
    yield from _strengths()
    yield from _cam_clay()


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


def _strengths() -> Iterator[Comparison]:
    """Strengths of Tresca, Mohr-Coulomb and Drucker-Prager, in Kirchhoff stress."""
    case, results = _made("strength.toml")
    for (test, name), result in results.items():
        material, of = case.materials[name], f"strength, {test}, {name}"
        axial, lateral = _at_the_end(result)
        if isinstance(material, Tresca):
            exact = 2.0 * material.undrained_shear_strength
            yield relative(of, abs(axial - lateral), exact, EXACT, SOURCE, KPA)
        elif isinstance(material, DruckerPrager):
            if material.fit == "plane_strain":
                exact = _mohr_coulomb(material, lateral)
                yield relative(of, axial, exact, 1e-3, "Mohr-Coulomb at collapse", KPA)
            else:
                yield _on_cone(of, result, material)
                if material.fit == test:
                    least, most = sorted((axial, lateral))
                    yield relative(
                        f"{of}, as Mohr-Coulomb", most, _mohr_coulomb(material, least), EXACT,
                        SOURCE, KPA,
                    )  # fmt: skip
        elif isinstance(material, MohrCoulomb):
            if test == "undrained":
                exact = _undrained_strength(material, 0.5 * (100.0 + 60.0))
                tolerance = EXACT if material.pore_fluid_bulk_modulus is None else 1e-4
                yield relative(of, 0.5 * (axial - lateral), exact, tolerance, SOURCE, KPA)
            else:
                least, most = sorted((axial, lateral))
                yield relative(of, most, _mohr_coulomb(material, least), EXACT, SOURCE, KPA)


def _at_the_end(result: ElementResult) -> tuple[float, float]:
    """Returns the axial and the lateral Kirchhoff stress [stress] at the end of a test."""
    jacobian = _jacobian(result)[-1]
    return float(result["stress_yy"][-1] * jacobian), float(result["stress_xx"][-1] * jacobian)


def _mohr_coulomb(material: MohrCoulomb | DruckerPrager, least: float) -> float:
    """Returns the largest principal stress at failure, with the smallest one [stress]."""
    angle = math.radians(material.friction_angle)
    cohesive = 2.0 * material.cohesion * math.cos(angle)
    return (least * (1.0 + math.sin(angle)) + cohesive) / (1.0 - math.sin(angle))


def _undrained_strength(material: MohrCoulomb, mean: float) -> float:
    """Returns c cos(phi) + s0' sin(phi) [stress], with the mean in-plane stress at the start."""
    angle = math.radians(material.friction_angle)
    return material.cohesion * math.cos(angle) + mean * math.sin(angle)


def _on_cone(of: str, result: ElementResult, material: DruckerPrager) -> Comparison:
    """Compares sqrt(J2) at the end with xi c - eta p (de Souza Neto et al. 2008, sec. 8.3)."""
    sine, cosine = (f(math.radians(material.friction_angle)) for f in (math.sin, math.cos))
    divisor = math.sqrt(3.0) * (3.0 + (sine if material.fit == "extension" else -sine))
    jacobian = _jacobian(result)[-1]
    strength = 6.0 * (cosine * material.cohesion + sine * result["p"][-1] * jacobian) / divisor
    root = abs(result["q"][-1]) * jacobian / math.sqrt(3.0)
    return relative(f"{of}, on the cone", root, strength, EXACT, SOURCE, KPA)


def _cam_clay() -> Iterator[Comparison]:
    """Modified Cam Clay: strengths, and the stress path and the volume on the yield surface.

    With a constant shear modulus the elastic volume depends on the pressure alone, and the volume
    is a function of the stress. Slopes of Kirchhoff stress: index / (1 - index).
    """
    case, results = _made("modified_cam_clay.toml")
    for (test, name), result in results.items():
        material, of = case.materials[name], f"{test}, {name}"
        assert isinstance(material, ModifiedCamClay)
        slope = material.critical_state_slope
        compression, swelling = material.compression_index, material.swelling_index
        normal, elastic = compression / (1.0 - compression), swelling / (1.0 - swelling)
        plastic = 1.0 - elastic / normal
        p, q, strain = result["p"], result["q"], result["volumetric_strain"]
        squared = (q / p / slope) ** 2
        if test == "undrained":
            assert material.overconsolidation_ratio is not None
            strength = slope * p[0] * (0.5 * material.overconsolidation_ratio) ** plastic
            yield relative(f"strength, {of}", q[-1], strength, 1e-6, SOURCE, KPA)
            if material.overconsolidation_ratio == 1.0:
                yield _error(f"p / p0, {of}", p / p[0], (1.0 + squared) ** -plastic, 1e-10)
        elif test == "drained":
            strength = 3.0 * slope * p[0] / (3.0 - slope)
            yield relative(f"strength, {of}", q[-1], strength, 1e-6, SOURCE, KPA)
            if material.overconsolidation_ratio == 1.0:
                kirchhoff = p * _jacobian(result)
                exact = normal * np.log(kirchhoff / p[0])
                exact = exact + (normal - elastic) * np.log1p(squared)
                yield _error(f"volume, {of}", strain, exact, 1e-10)
        elif test == "isotropic":
            loading = result["stage"] <= 1.0
            largest = p[loading][-1]
            exact = np.where(
                loading,
                compression * np.log(p / p[0]),
                compression * np.log(largest / p[0]) + swelling * np.log(p / largest),
            )
            yield _error(f"volume, {of}", strain, exact, 1e-10)
        elif material.poisson_ratio is not None:  # stiffness in proportion to the pressure
            loaded = np.flatnonzero(result["stage"] == 1.0)[-2:]
            found = np.diff(strain[loaded])[0] / np.diff(np.log(result["stress_yy"][loaded]))[0]
            yield relative(f"slope, {of}", found, compression, 1e-6, SOURCE)


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
