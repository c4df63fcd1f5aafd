# SPDX-License-Identifier: BSD-3-Clause
"""Davis' associated equivalents in strength reduction: their strength, and factors of safety."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from test_reduced_strength import mohr_coulomb_excess, parameters_of, returned
from test_strength_reduction import LAWS, PRESSURE, block, reduced

from tilth import AnalysisFailed, BadInput, DruckerPrager, MohrCoulomb, StrengthReduction, Tresca
from tilth.analysis.safety_search import Outcome, Search, Trial
from tilth.model.davis import DavisForm, davis_share
from tilth.output.folder import safety_files
from tilth.output.safety_files import SafetySummary, read_safety, write_safety
from tilth.report.safety import text_of

FORMS: tuple[DavisForm, ...] = ("A", "B", "C")
C, PHI, PSI, FACTOR = 12.0, 37.0, 10.0, 1.3
SOIL = {
    "young_modulus": 1e4, "poisson_ratio": 0.3, "cohesion": C, "friction_angle": PHI,
    "dilation_angle": PSI,
}  # fmt: skip
SOFTENING = {
    "residual_cohesion": 5.0, "residual_friction_angle": 30.0, "softening_strain": 0.1,
    "softening_length": 1.0,
}  # fmt: skip
DAVIS: dict[str, Any] = {
    **LAWS["mohr_coulomb"], "cohesion": 9.0, "friction_angle": 30.0, "dilation_angle": 5.0
}  # fmt: skip


def share_of(phi: float, psi: float, factor: float, form: DavisForm) -> float:
    """Davis' share as it is printed; angles in degrees."""
    phi_f = math.degrees(math.atan(math.tan(math.radians(phi)) / factor))
    psi_f = math.degrees(math.atan(math.tan(math.radians(psi)) / factor))
    phi, psi = {"A": (phi, psi), "B": (phi_f, psi_f), "C": (phi_f, min(psi, phi_f))}[form]
    a, b = math.radians(phi), math.radians(psi)
    return math.cos(b) * math.cos(a) / (1.0 - math.sin(b) * math.sin(a))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("psi", [0.0, 10.0, 33.0])
@pytest.mark.parametrize("factor", [0.8, 1.3, 2.5])
def test_share_of_the_strength(form: DavisForm, psi: float, factor: float) -> None:
    found = davis_share(math.radians(PHI), math.radians(psi), factor, form)
    assert found == pytest.approx(share_of(PHI, psi, factor, form), rel=1e-14)


def test_share_by_numbers() -> None:
    """phi 37, psi 0, F 1.3: cos(37) in form A, and cos(phi_F) in B and C; tan(37) is 0.753554."""
    phi = math.radians(37.0)
    assert davis_share(phi, 0.0, 1.3, "A") == pytest.approx(0.798636, abs=1e-6)
    reduced_cosine = 1.0 / math.hypot(1.0, 0.753554 / 1.3)
    for form in ("B", "C"):
        assert davis_share(phi, 0.0, 1.3, form) == pytest.approx(reduced_cosine, abs=1e-6)
    assert davis_share(phi, 0.0, 1.3, None) == 1.0


@pytest.mark.parametrize("form", FORMS)
def test_mohr_coulomb_has_the_equivalents_strength_and_flow(form: DavisForm) -> None:
    material = MohrCoulomb(**SOIL)
    own = material.reduced_parameters(parameters_of(material), FACTOR, form)
    found = dict(zip(material.parameter_names, own, strict=True))
    divisor = FACTOR / share_of(PHI, PSI, FACTOR, form)
    tangent = math.tan(math.radians(PHI)) / divisor
    assert found["cohesion"] == pytest.approx(C / divisor, rel=1e-13)
    assert math.tan(math.radians(found["friction_angle"])) == pytest.approx(tangent, rel=1e-13)
    assert found["dilation_angle"] == found["friction_angle"]
    stress, flow = returned(material, own)
    excess = mohr_coulomb_excess(stress, C / divisor, tangent)
    assert excess.max() <= 1e-10 * np.abs(stress).max()
    apart = np.diff(-stress, axis=1).min(axis=1) > 1e-6  # on one plane of the pyramid
    sine = math.sin(math.atan(tangent))
    on_plane = apart & (np.abs(excess) < 1e-8)
    assert on_plane.sum() > 10
    volume, shear = flow.sum(axis=1), flow.max(axis=1) - flow.min(axis=1)
    np.testing.assert_allclose(volume[on_plane], sine * shear[on_plane], rtol=1e-8)


@pytest.mark.parametrize("form", FORMS)
def test_softened_strength_has_its_own_share(form: DavisForm) -> None:
    material = MohrCoulomb(**SOIL, **SOFTENING)
    own = material.reduced_parameters(parameters_of(material), FACTOR, form)
    found = dict(zip(material.parameter_names, own, strict=True))
    divisor = FACTOR / share_of(30.0, PSI, FACTOR, form)
    assert found["residual_cohesion"] == pytest.approx(5.0 / divisor, rel=1e-13)
    residual = math.degrees(math.atan(math.tan(math.radians(30.0)) / divisor))
    assert found["residual_friction_angle"] == pytest.approx(residual, rel=1e-13)
    assert found["dilation_angle"] == found["residual_friction_angle"] < found["friction_angle"]
    assert found["softening_strain"] == 0.1


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("fit", ["compression", "extension", "plane_strain"])
def test_drucker_prager_is_fitted_to_the_equivalent(form: DavisForm, fit: str) -> None:
    material = DruckerPrager(**SOIL, fit=fit)
    own = material.reduced_parameters(parameters_of(material), FACTOR, form)
    divisor = FACTOR / share_of(PHI, PSI, FACTOR, form)
    phi = math.degrees(math.atan(math.tan(math.radians(PHI)) / divisor))
    angles = {"cohesion": C / divisor, "friction_angle": phi, "dilation_angle": phi}
    expected = parameters_of(DruckerPrager(**(SOIL | angles), fit=fit))
    np.testing.assert_allclose(own, expected, rtol=1e-12)


@pytest.mark.parametrize("form", FORMS)
def test_associated_flow_is_its_own_equivalent(form: DavisForm) -> None:
    associated = SOIL | {"dilation_angle": PHI}
    for material in (
        MohrCoulomb(**associated, tension_cut_off=3.0),
        MohrCoulomb(**associated, **(SOFTENING | {"residual_friction_angle": PHI})),
        *(DruckerPrager(**associated, fit=fit) for fit in ("compression", "plane_strain")),
    ):
        own = parameters_of(material)
        for factor in (1.1, 1.3, 2.7):
            np.testing.assert_array_equal(
                material.reduced_parameters(own, factor, form),
                material.reduced_parameters(own, factor),
            )


@pytest.mark.parametrize("form", FORMS)
def test_soil_of_constant_volume_has_no_equivalent(form: DavisForm) -> None:
    """With psi = phi the pore pressure of undrained soil would fall as far as it is sheared."""
    fluid = {"pore_fluid_bulk_modulus": 1e6}
    for material in (
        MohrCoulomb(**SOIL, **fluid),
        DruckerPrager(**SOIL, **fluid, fit="plane_strain"),
        Tresca(young_modulus=1e4, poisson_ratio=0.3, undrained_shear_strength=10.0),
    ):
        own = parameters_of(material)
        np.testing.assert_array_equal(
            material.reduced_parameters(own, FACTOR, form),
            material.reduced_parameters(own, FACTOR),
        )


def test_each_point_has_its_own_share() -> None:
    material = MohrCoulomb(**SOIL)
    one = parameters_of(material)
    other = one.copy()
    other[material.parameter_names.index("dilation_angle")] = 25.0
    both = material.reduced_parameters(np.stack([one, other]), FACTOR, "B")
    for row, own in zip(both, (one, other), strict=True):
        np.testing.assert_array_equal(row, material.reduced_parameters(own, FACTOR, "B"))


def exact_factor(form: DavisForm) -> float:
    """Of the block of `test_strength_reduction` with Davis' strength."""
    c, phi = DAVIS["cohesion"], DAVIS["friction_angle"]

    def excess(factor: float) -> float:
        divisor = factor / share_of(phi, DAVIS["dilation_angle"], factor, form)
        angle = math.atan(math.tan(math.radians(phi)) / divisor)
        return 2.0 * c / divisor * math.tan(math.pi / 4 + angle / 2) - PRESSURE

    return float(brentq(excess, 0.1, 10.0))


@pytest.mark.parametrize("form", FORMS)
def test_exact_collapse_of_a_block(form: DavisForm) -> None:
    result = reduced(block(DAVIS), tolerance=0.002, davis=form)
    exact = exact_factor(form)
    assert result.factor - 0.002 <= exact <= result.above + 0.002
    assert result.davis == form
    assert f", of Davis' associated equivalent, form {form}" in result.text
    assert f"strength, of Davis' associated equivalent, form {form}" in result.criterion
    itself = reduced(block(DAVIS), tolerance=0.002)
    assert itself.factor > result.above
    assert "Davis" not in itself.text + itself.criterion


def test_associated_soil_has_the_same_factor() -> None:
    model = block(LAWS["mohr_coulomb"])
    itself, equivalent = reduced(model), reduced(model, davis="B")
    assert equivalent.factor == itself.factor
    assert [each.factor for each in equivalent.trials] == [each.factor for each in itself.trials]


def test_a_factor_below_one() -> None:
    """The soil itself is in equilibrium at the factor 1, its equivalent is not."""
    weak = DAVIS | {"cohesion": 6.2}
    assert reduced(block(weak)).trials[0].in_equilibrium
    result = reduced(block(weak), davis="A")
    assert not result.trials[0].in_equilibrium
    assert result.factor < 1.0
    assert result.is_decided


@pytest.mark.parametrize("davis", [None, "B"])
def test_an_undecided_trial_below_one_is_an_error_only_of_the_soil_itself(
    davis: DavisForm | None,
) -> None:
    search = Search(StrengthReduction(davis=davis))
    undecided = Trial(1.0, math.nan, 30, Outcome.UNDECIDED, "the soil does not come to rest")
    assert search.next_factor() == 1.0
    if davis is None:
        with pytest.raises(AnalysisFailed, match="the equilibrium at the factor 1 is not found"):
            search.record(undecided)
    else:
        search.record(undecided)
        following = search.next_factor()
        assert following == pytest.approx(0.8)
        search.record(Trial(0.8, 0.1, 5, Outcome.EQUILIBRIUM))
        assert search.undecided == [1.0]


@pytest.mark.parametrize("davis", ["D", "b", "", 1])
def test_unknown_forms(davis: object) -> None:
    with pytest.raises(BadInput, match=r"StrengthReduction\.davis = .*: not one") as error:
        StrengthReduction(davis=davis)
    assert 'choose from "A", "B", "C"' in str(error.value)


def test_the_summary_says_whose_factor_it_is(tmp_path: Path) -> None:
    summary = SafetySummary(1.2, 1.21, 0.01, (), 1.0, "collapse", 0.1, [], "B")
    write_safety(tmp_path, summary, "m", safety_files())
    stored = read_safety(tmp_path)
    assert stored.davis == "B"
    begin = "Factor of safety 1.2, of Davis' associated equivalent, form B: between 1.2 (equ"
    assert text_of(stored).startswith(begin)
    file = tmp_path / safety_files().summary
    file.write_text(file.read_text().replace('"B"', '"D"'))
    with pytest.raises(BadInput, match="unknown form 'D'"):
        read_safety(tmp_path)
