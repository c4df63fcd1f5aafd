# SPDX-License-Identifier: BSD-3-Clause
"""Element tests: kinematics, mixed control, stages, tables, and what ends a test early."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import tilth
from tilth.element_tests.check import check_tangents, tangent_error
from tilth.element_tests.kinematics import along_planes, without_rotation
from tilth.element_tests.point import ElementPoint
from tilth.element_tests.run import element
from tilth.model.materials import Material

CLAY = {
    "model": "von_mises",
    "young_modulus": 1e4,
    "poisson_ratio": 0.3,
    "yield_stress": 80.0,
    "hardening_modulus": 100.0,
}
START = {"isotropic": 100.0}


def case_of(*tests: dict[str, Any], **changed: Any) -> tilth.ElementCase:
    """A case with the clay."""
    common = {"name": "test", "material": "clay", "start": START, "steps": 20}
    entries = [{**common, "name": f"test {n}", **test} for n, test in enumerate(tests)]
    return tilth.ElementCase.from_dict(
        {"materials": {"clay": {**CLAY, **changed}}, "tests": entries}
    )


def made(test: dict[str, Any], **changed: Any) -> tilth.element_tests.result.ElementResult:
    (result,) = element(case_of(test, **changed))
    assert result.stopped == ""
    return result


def triaxial(**changed: Any) -> dict[str, Any]:
    test = {"type": "triaxial", "drainage": "drained", "direction": "compression"}
    return {**test, "axial_strain": 0.05, **changed}


@pytest.mark.parametrize("kinematics", [without_rotation, along_planes])
def test_derivatives_of_kinematics(kinematics: Any) -> None:
    random = np.random.default_rng(1)
    for strain in (np.zeros(6), random.normal(size=6), np.array([0.3, 0.3, 0.3, 0, 0, 1e-7])):
        _, derivative = kinematics(strain)
        for k in range(6):
            shift = 1e-5 * np.eye(6)[k]
            slope = (kinematics(strain + shift)[0] - kinematics(strain - shift)[0]) / 2e-5
            np.testing.assert_allclose(derivative[:, :, k], slope, atol=1e-8)


def test_strain_without_rotation_is_the_logarithmic_one() -> None:
    strain = np.array([0.2, -0.4, 0.1, 0.3, -0.2, 0.5])
    gradient, _ = without_rotation(strain)
    np.testing.assert_allclose(gradient, gradient.T, atol=1e-15)
    value, axis = np.linalg.eigh(gradient)
    logarithm = axis @ np.diag(np.log(value)) @ axis.T
    np.testing.assert_allclose(
        logarithm[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]], strain, atol=1e-14
    )


def test_tangent_of_the_cauchy_stress() -> None:
    """Along a step from a deformed and rotated state."""
    material = tilth.VonMises(**{key: value for key, value in CLAY.items() if key != "model"})
    point = ElementPoint.at_start(material, np.array([-50.0, -90.0, -60.0, 0.0, 0.0, 0.0]))
    random = np.random.default_rng(2)
    point, _ = point.deformed(np.eye(3) + 0.1 * random.normal(size=(3, 3)))
    gradient = point.deformation_gradient + 0.02 * random.normal(size=(3, 3))
    _, tangent = point.deformed(gradient)
    for i in range(3):
        for j in range(3):
            shift = np.zeros((3, 3))
            shift[i, j] = 1e-6
            above, below = (point.deformed(gradient + s * shift)[0].stress for s in (1.0, -1.0))
            np.testing.assert_allclose(
                tangent[:, i, j], (above - below) / 2e-6, atol=1e-7 * np.abs(tangent).max()
            )


def test_given_stresses_are_met() -> None:
    """In every kind of test the stresses that are given, total or effective, are there."""
    drained = made(triaxial())
    np.testing.assert_allclose(drained["stress_xx"], 100.0, rtol=1e-11)
    np.testing.assert_array_equal(drained["stress_xx"], drained["stress_zz"])
    biaxial = made({**triaxial(), "type": "biaxial"})
    np.testing.assert_allclose(biaxial["stress_xx"], 100.0, rtol=1e-11)
    np.testing.assert_array_equal(biaxial["strain_zz"], 0.0)
    shear = {"type": "simple_shear", "drainage": "drained", "shear_strain": [0.1, -0.1]}
    sheared = made(shear)
    np.testing.assert_allclose(sheared["stress_yy"], 100.0, rtol=1e-11)
    for component in ("strain_xx", "strain_zz", "strain_yz", "strain_xz"):
        np.testing.assert_array_equal(sheared[component], 0.0)
    oedometer = made({"type": "oedometer", "vertical_stress": [400.0, 50.0]})
    expected = np.concatenate(
        [[100.0], 100.0 * 4.0 ** (np.arange(1, 21) / 20), 400.0 / 8.0 ** (np.arange(1, 21) / 20)]
    )
    np.testing.assert_allclose(oedometer["stress_yy"], expected, rtol=1e-11)


@pytest.mark.parametrize("direction", ["compression", "extension"])
def test_undrained_tests_keep_volume_and_total_lateral_stress(direction: str) -> None:
    for kind in ("triaxial", "biaxial"):
        test = triaxial(type=kind, drainage="undrained", direction=direction)
        result = made({**test, "consolidation": {"vertical": 150.0, "K0": 0.5}})
        sheared = result["stage"] == 2.0
        np.testing.assert_allclose(np.ptp(result["volumetric_strain"][sheared]), 0.0, atol=1e-14)
        total = result["stress_xx"] + result["excess_pore_pressure"]
        np.testing.assert_allclose(total[sheared], 75.0, rtol=1e-9)
        np.testing.assert_allclose(
            result["p_total"], result["p"] + result["excess_pore_pressure"], rtol=1e-14
        )
        assert result["excess_pore_pressure"][~sheared].max() == 0.0
        sign = 1.0 if direction == "compression" else -1.0
        assert np.all(sign * np.diff(result["axial_strain"][sheared]) > 0.0)


@pytest.mark.parametrize("drainage", ["drained", "undrained"])
def test_the_deviator_is_positive_in_compression_and_negative_in_extension(drainage: str) -> None:
    """q = sigma_a - sigma_r, so that a drained test follows dq = 3 dp in both directions."""
    for direction, sign in (("compression", 1.0), ("extension", -1.0)):
        result = made(triaxial(drainage=drainage, direction=direction))
        np.testing.assert_allclose(
            result["q"], result["stress_yy"] - result["stress_xx"], rtol=1e-12, atol=1e-9
        )
        assert np.all(sign * result["q"][1:] > 0.0)
        if drainage == "drained":
            np.testing.assert_allclose(result["q"], 3.0 * (result["p"] - 100.0), atol=1e-6)


def test_undrained_simple_shear_keeps_the_total_vertical_stress() -> None:
    test = {"type": "simple_shear", "drainage": "undrained", "shear_strain": [0.3, -0.1]}
    result = made(test)
    np.testing.assert_allclose(result["volumetric_strain"], 0.0, atol=1e-14)
    total = result["stress_yy"] + result["excess_pore_pressure"]
    np.testing.assert_allclose(total, 100.0, rtol=1e-12)


def test_a_path_of_the_user_repeats_a_triaxial_test() -> None:
    lateral = [[0.0, 100.0], [1.0, 100.0]]
    path = {
        "type": "path",
        "stress": {"xx": lateral, "zz": lateral},
        "strain": {"yy": [[0.0, 0.0], [1.0, 0.05]]},
    }
    own, expected = made(path), made(triaxial())
    for column in ("p", "stress_yy", "strain_xx", "plastic_strain", "volumetric_strain"):
        np.testing.assert_allclose(own[column], expected[column], rtol=1e-9, atol=1e-12)


def test_a_path_with_shear_stress() -> None:
    """Pure shear stress at constant normal stresses; every row of the tables is met."""
    constant = [[0.0, 100.0], [3.0, 100.0]]
    path = {
        "type": "path",
        "stress": {
            "xx": constant, "yy": constant, "zz": constant,
            "xy": [[0.0, 0.0], [1.0, 30.0], [3.0, -50.0]],
        },
    }  # fmt: skip
    result = made(path)
    assert len(result["step"]) == 1 + 2 * 20
    np.testing.assert_allclose(result["stress_xy"][[20, 30, 40]], [30.0, -10.0, -50.0], rtol=1e-10)
    assert result["strain_xy"][20] == pytest.approx(30.0 * 1.3 / 1e4, rel=1e-2)
    assert result["strain_xy"][40] < -50.0 * 1.3 / 1e4  # beyond yield


def test_turned_axes_give_the_same_test() -> None:
    """A path with the vertical axis along x has the results of the one along y."""
    lateral, axial = [[0.0, 100.0], [1.0, 100.0]], [[0.0, 0.0], [1.0, 0.05]]
    paths = [
        {"type": "path", "stress": {a: lateral, b: lateral}, "strain": {c: axial}}
        for a, b, c in (("xx", "zz", "yy"), ("yy", "zz", "xx"), ("xx", "yy", "zz"))
    ]
    first, *others = element(case_of(*paths))
    for other in others:
        np.testing.assert_allclose(other["q"], first["q"], rtol=1e-10, atol=1e-9)


def test_newton_converges_quadratically() -> None:
    """Few iterations a step, also where yielding begins and at large strain."""
    result = made(triaxial(axial_strain=1.0, steps=25))
    assert result["iterations"].max() <= 6


@pytest.mark.parametrize("steps", [10, 160])
def test_size_of_the_steps_does_not_matter_under_proportional_strain(steps: int) -> None:
    coarse, fine = (
        made({"type": "oedometer", "vertical_strain": 0.1, "steps": n})["stress_yy"][-1]
        for n in (steps, 2 * steps)
    )
    assert coarse == pytest.approx(fine, rel=1e-10)


def test_void_ratio_follows_the_volume() -> None:
    result = made({"type": "isotropic", "pressure": [800.0], "void_ratio": 1.2})
    expected = 2.2 * np.exp(-result["volumetric_strain"]) - 1.0
    np.testing.assert_allclose(result["void_ratio"], expected, rtol=1e-13)
    assert "void_ratio" not in made({"type": "isotropic", "pressure": [800.0]}).columns


def test_loading_beyond_the_strength_ends_the_test() -> None:
    constant = [[0.0, 100.0], [1.0, 100.0]]
    path = {
        "type": "path",
        "stress": {"xx": constant, "zz": constant, "yy": [[0.0, 100.0], [1.0, 300.0]]},
    }
    (result,) = element(case_of(path, hardening_modulus=0.0))
    assert "no strain was found" in result.stopped
    assert 70.0 < result["q"][-1] <= 82.0
    assert len(result["q"]) < 21


def test_a_start_beyond_the_strength_is_refused() -> None:
    with pytest.raises(tilth.BadInput, match="beyond the strength") as error:
        element(case_of({**triaxial(), "start": {"vertical": 300.0, "K0": 0.5}}))
    assert error.value.key == "tests[0].start"


def test_a_start_that_the_law_cannot_have_is_refused() -> None:
    """A stress of many times the stiffness would fold the point."""
    soft = {"young_modulus": 1e-10, "yield_stress": 1e30}
    with pytest.raises(tilth.BadInput, match="no state with this stress") as error:
        element(case_of(triaxial(), **soft))
    assert error.value.key == "tests[0].start"


def test_the_check_passes_for_every_law_of_the_case() -> None:
    case = case_of(triaxial(), {"type": "oedometer", "vertical_stress": [400.0, 50.0]})
    found = list(check_tangents(case))
    assert all(each.passed and each.states > 10 for each in found)
    assert max(each.error for each in found) < 1e-8
    assert list(check_tangents(case)) == found, "the random states have a fixed seed"


def test_the_check_finds_a_wrong_tangent(monkeypatch: pytest.MonkeyPatch) -> None:
    """An error of a thousandth of the stiffness fails."""
    original = ElementPoint.update

    def wrong(point: ElementPoint, *given: Any) -> Any:
        found = original(point, *given)
        found.tangent[:, 0, 0, 0] *= 1.001
        return found

    monkeypatch.setattr(ElementPoint, "update", wrong)
    (found,) = check_tangents(case_of(triaxial()))
    assert not found.passed
    assert found.error == pytest.approx(1e-3, rel=0.5)


def test_a_kink_is_no_error() -> None:
    """Exactly where yielding starts the stress has no derivative."""
    material: Material = tilth.VonMises(
        young_modulus=1.0, poisson_ratio=0.0, yield_stress=1e-2, hardening_modulus=0.0
    )
    point = ElementPoint.at_start(material, np.zeros(6))
    strain = 1e-2 / 1.5 * np.array([1.0, -0.5, -0.5])  # 3 G |eps| = yield stress, J = 1
    at_yield = np.diag(np.expm1(strain))
    assert tangent_error(point, at_yield) is None
    assert tangent_error(point, 0.99 * at_yield) < 1e-8  # type: ignore[operator]
    assert tangent_error(point, 1.01 * at_yield) < 1e-6  # type: ignore[operator]


def test_stages_are_counted() -> None:
    result = made(triaxial(consolidation={"isotropic": 200.0}))
    stage = result["stage"]
    assert list(stage) == [0.0] + [1.0] * 20 + [2.0] * 20
    assert all(after >= before for before, after in pairwise(stage))
    assert result["p"][20] == pytest.approx(200.0, rel=1e-11)
