# SPDX-License-Identifier: BSD-3-Clause
"""Values of parameters that vary from place to place, against closed forms and statistics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilth import BadInput, VonMises
from tilth.arrays import Floats
from tilth.model import RandomField
from tilth.variation import random_field
from tilth.variation.evaluate import parameter_values
from tilth.variation.random_field import random_values, standard_normal

RANDOM = {
    "mean": 20.0,
    "coefficient_of_variation": 0.3,
    "correlation_lengths": [4.0, 1.0],
    "distribution": "lognormal",
    "model": "exponential",
    "seed": 1,
}


def clay(yield_stress: Any, **others: Any) -> VonMises:
    given = {"young_modulus": 1e6, "poisson_ratio": 0.3, "hardening_modulus": 0.0}
    return VonMises(**{**given, "yield_stress": yield_stress, **others})


def values(yield_stress: Any, position: Any) -> Floats:
    found = parameter_values(clay(yield_stress), np.array(position, float), "materials.clay")
    assert list(found) == ["yield_stress"]
    return found["yield_stress"]


def refusal(yield_stress: Any, position: Any) -> str:
    with pytest.raises(BadInput) as caught:
        values(yield_stress, position)
    return str(caught.value)


PLACES = [[0.0, -1.0], [3.0, -4.0], [10.0, -9.5]]


def test_a_table_over_the_depth_below_level_ground() -> None:
    declared = {"depth": [[0, 5], [4, 13], [12, 13]], "surface": 2.0}
    np.testing.assert_allclose(values(declared, PLACES), [11.0, 13.0, 13.0], rtol=1e-14)
    in_space = [[7.0, -2.0, y] for _, y in PLACES]
    np.testing.assert_allclose(values(declared, in_space), [11.0, 13.0, 13.0], rtol=1e-14)


def test_a_table_over_the_depth_below_a_slope() -> None:
    """Strength 5 + 1.5 z with z below the line y = x / 5."""
    declared = {"depth": [[0, 5], [20, 35]], "surface": [[0, 0], [10, 2]]}
    exact = [5.0 + 1.5 * (0.2 * x - y) for x, y in PLACES]
    np.testing.assert_allclose(values(declared, PLACES), exact, rtol=1e-14)
    problem = refusal(declared, [[10.5, -1.0]])
    assert "materials.clay.yield_stress.surface: " in problem
    assert "(10.5, -1) is outside the table: its x is 10.5" in problem


def test_a_table_along_an_axis() -> None:
    declared = {"axis": "y", "values": [[-10, 20], [0, 5]]}
    np.testing.assert_allclose(values(declared, PLACES), [6.5, 11.0, 19.25], rtol=1e-14)
    problem = refusal(declared, [[3.0, -1.0], [3.0, -10.5]])
    assert "materials.clay.yield_stress.values: " in problem
    assert "(3, -10.5) is outside the table: its y is -10.5, and the rows go from -10" in problem
    assert "1 of 2 points" in problem


def write_grid(folder: Path, text: str) -> dict[str, str]:
    file = folder / "su.csv"
    file.write_text(text, encoding="utf-8")
    return {"file": str(file)}


def test_a_grid_reproduces_a_bilinear_function(tmp_path: Path) -> None:
    """Rows in any order, lines at any distances, blanks and comments."""
    rows = [
        f"{x}, {y}, {100 + 2 * x - 3 * y + 0.5 * x * y}"
        for x in (10.0, -1.0, 2.5)
        for y in (0.0, -10.0, -4.0, 1.0)
    ]
    random = np.random.default_rng(3)
    random.shuffle(rows)
    declared = write_grid(tmp_path, "# measured\nx, y, value\n\n" + "\n".join(rows) + "\n")
    place = random.uniform([-1, -10], [10, 1], (200, 2))
    # bilinear within each cell, and the function is one bilinear function
    exact = 100 + 2 * place[:, 0] - 3 * place[:, 1] + 0.5 * place[:, 0] * place[:, 1]
    np.testing.assert_allclose(values(declared, place), exact, rtol=1e-13)
    problem = refusal(declared, [[0.0, 0.0], [0.0, 1.5]])
    assert "materials.clay.yield_stress.file = " in problem
    assert "(0, 1.5) is outside the grid, which goes from y = -10 to 1" in problem


def test_a_grid_over_some_axes(tmp_path: Path) -> None:
    declared = write_grid(tmp_path, "y,value\n-10,30\n0,10\n")
    np.testing.assert_allclose(values(declared, PLACES), [12.0, 18.0, 29.0], rtol=1e-14)
    declared = write_grid(tmp_path, "z,x,value\n0,0,1\n0,1,2\n1,0,3\n1,1,4\n")
    np.testing.assert_allclose(values(declared, [[0.25, 9.0, 0.5]]), [2.25], rtol=1e-14)


def test_a_horizon_of_a_grid_as_surface_in_3d(tmp_path: Path) -> None:
    surface = write_grid(tmp_path, "x,y,value\n0,0,1\n0,2,3\n2,0,5\n2,2,7\n")  # 1 + 2 x + y
    declared = {"depth": [[0, 5], [20, 25]], "surface": surface}
    np.testing.assert_allclose(values(declared, [[0.5, 1.5, -2.0]]), [5.0 + 5.5], rtol=1e-14)


WRONG_GRIDS = {
    "": "is empty instead of the names of its columns",
    "0,0,1\n": "begins with '0,0,1' instead of the names",
    "x,z,value\n0,0,1\n": "such as x,y,value",
    "x,x,value\n0,0,1\n": "such as x,y,value",
    "x,y,su\n0,0,1\n": "such as x,y,value",
    "x,y,value\n": "has no rows of 3 numbers",
    "x,y,value\n0,0,abc\n": "has a row that cannot be read",
    "x,y,value\n0,0\n": "has no rows of 3 numbers",
    "x,y,value\n0,0,1\n0,1\n": "has a row that cannot be read",
    "x,y,value\n0,0,1\n0,1,nan\n": "row 2 below the names has a number that is not finite",
    "x,y,value\n0,0,1\n0,1,2\n": "has a single coordinate along x",
    "x,y,value\n0,0,1\n0,1,2\n1,0,3\n": "its coordinates have 2 x 2 crossings, but it has 3 rows, "
    "and no value at (1, 1)",
    "x,value\n0,1\n0,2\n1,3\n": "and 2 values at (0)",
}


@pytest.mark.parametrize("text", WRONG_GRIDS)
def test_wrong_grids(text: str, tmp_path: Path) -> None:
    problem = refusal(write_grid(tmp_path, text), PLACES)
    assert "materials.clay.yield_stress.file = " in problem
    assert WRONG_GRIDS[text] in problem


def test_a_function_of_positions(tmp_path: Path) -> None:
    file = tmp_path / "strength.py"
    file.write_text("def su(x):\n    return 5.0 - 1.5 * x[:, 1]\n", encoding="utf-8")
    exact = [5.0 - 1.5 * y for _, y in PLACES]
    np.testing.assert_array_equal(values(f"{file}:su", PLACES), exact)
    problem = refusal(f"{file}:su", [[0.0, 1.0], [2.0, 4.0]])
    assert "materials.clay.yield_stress = -1.0: must be greater than zero" in problem
    assert "at the material point at (2, 4)" in problem


def test_values_must_be_those_of_the_parameter() -> None:
    declared = {"axis": "x", "values": [[0, -1], [10, 9]]}
    problem = refusal(declared, [[5.0, 0.0], [0.5, 2.0], [9.0, 0.0]])
    assert problem.startswith("materials.clay.yield_stress = -0.5: must be greater than zero")
    assert "at the material point at (0.5, 2)" in problem
    material = clay(1.0, poisson_ratio={"axis": "x", "values": [[0, 0.0], [10, 0.6]]})
    with pytest.raises(
        BadInput, match=r"poisson_ratio = 0.54: .* smaller than 0.5, .* at \(9, 0\)"
    ):
        parameter_values(material, np.array([[9.0, 0.0], [0.0, 0.0]]), "materials.clay")


def test_a_normal_field_that_becomes_negative() -> None:
    wide = {**RANDOM, "distribution": "normal", "coefficient_of_variation": 2.0}
    place = np.random.default_rng(0).uniform(0, 10, (500, 2))
    problem = refusal({"random": wide}, place)
    assert "must be greater than zero" in problem
    assert 'choose "lognormal"' in problem


def test_youngs_modulus_by_the_initial_stress() -> None:
    """E = E_ref (p / p_ref)^m, and its units."""
    stress = np.zeros((2, 6))
    stress[:, 1], stress[:, 0], stress[:, 2] = (-100.0, -400.0), (-50.0, -200.0), (-50.0, -200.0)
    stress[1, 3] = 120.0  # principal stresses in the plane -300 +- sqrt(100^2 + 120^2)
    position = np.zeros((2, 2))
    for kind, pressure in (
        ("mean", [200 / 3, 800 / 3]),
        ("minor", [50.0, 300.0 - np.hypot(100.0, 120.0)]),
    ):
        by_stress = {"reference": 3e4, "reference_pressure": 100.0, "exponent": 0.5, "stress": kind}
        material = clay(1.0, young_modulus=by_stress)
        found = parameter_values(material, position, "materials.sand", stress)["young_modulus"]
        np.testing.assert_allclose(found, 3e4 * np.sqrt(np.array(pressure) / 100.0), rtol=1e-13)
    with pytest.raises(
        BadInput, match=r"young_modulus: depends on the initial stress.*\n.*initial"
    ):
        parameter_values(material, position, "materials.sand")
    with pytest.raises(BadInput, match=r"young_modulus = 0.0: must be greater than zero"):
        parameter_values(material, position, "materials.sand", np.zeros((2, 6)))


@pytest.mark.parametrize("distribution", ["normal", "lognormal"])
def test_moments_of_a_random_field(distribution: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Mean and standard deviation by Gauss-Hermite integration over the standard normal field."""
    normal, weight = np.polynomial.hermite_e.hermegauss(20)
    weight /= weight.sum()
    monkeypatch.setattr(random_field, "standard_normal", lambda *_: normal)
    declared = RandomField(**{**RANDOM, "distribution": distribution})
    found = random_values(declared, np.zeros((len(normal), 2)), "random")
    mean = weight @ found
    assert mean == pytest.approx(20.0, rel=1e-10)
    assert np.sqrt(weight @ (found - mean) ** 2) == pytest.approx(0.3 * 20.0, rel=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("distribution", ["normal", "lognormal"])
@pytest.mark.parametrize("model", ["exponential", "gaussian"])
def test_statistics_of_a_random_field(distribution: str, model: str) -> None:
    """Mean, coefficient of variation and correlation over 300 realisations.

    The standard error of a mean of N independent values is sigma / sqrt(N); the bounds are four
    of them. One place at a time, as the places of a realisation are correlated.
    """
    place = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 1.0], [40.0, 20.0]])
    entries = {**RANDOM, "distribution": distribution, "model": model}
    count = 300
    declared = RandomField(**entries)
    found = np.array(
        [
            random_values(declared.model_copy(update={"seed": seed}), place, "random")
            for seed in range(count)
        ]
    )
    error = 4.0 / np.sqrt(count)
    assert np.abs(found.mean(axis=0) / 20.0 - 1.0).max() < error * 0.3
    assert np.abs(found.std(axis=0) / 6.0 - 1.0).max() < error  # kurtosis of a lognormal included
    field = np.log(found) if distribution == "lognormal" else found
    correlation = np.corrcoef(field.T)
    at_length = np.exp(-1.0) if model == "exponential" else np.exp(-np.pi / 4.0)
    assert abs(correlation[0, 1] - at_length) < error  # 4 along x is the correlation length
    assert abs(correlation[0, 2] - at_length) < error
    assert abs(correlation[0, 3]) < error


def test_a_random_field_depends_on_seed_and_place_only() -> None:
    place = np.random.default_rng(0).uniform(0, 10, (50, 2))
    whole = values({"random": RANDOM}, place)
    np.testing.assert_array_equal(whole[17:30], values({"random": RANDOM}, place[17:30]))
    np.testing.assert_array_equal(whole, values({"random": RANDOM}, place))
    assert np.abs(whole / values({"random": {**RANDOM, "seed": 2}}, place) - 1.0).max() > 0.1


def test_a_random_field_about_a_trend_with_depth() -> None:
    """The field over its mean at that depth is the field without a trend over its mean."""
    place = np.random.default_rng(0).uniform([0, -10], [10, 0], (50, 2))
    trend = {**RANDOM, "gradient": 1.5, "surface": 2.0}
    mean = 20.0 + 1.5 * (2.0 - place[:, 1])
    for distribution in ("normal", "lognormal"):
        ratio, plain = (
            values({"random": {**entries, "distribution": distribution}}, place)
            for entries in (trend, RANDOM)
        )
        np.testing.assert_allclose(ratio / mean, plain / 20.0, rtol=1e-13)


def test_lengths_in_other_units_give_the_same_random_field() -> None:
    place = np.random.default_rng(0).uniform(0, 10, (50, 2))
    metres = RandomField(**RANDOM)
    feet = metres.model_copy(update={"correlation_lengths": [4.0 / 0.3048, 1.0 / 0.3048]})
    np.testing.assert_allclose(
        standard_normal(metres, place), standard_normal(feet, place / 0.3048), atol=1e-9
    )
