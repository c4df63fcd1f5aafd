# SPDX-License-Identifier: BSD-3-Clause
"""Mistakes in parameters that vary and in layers: exit code 2 and one message."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Outcome
from .test_wrong_input import refused

Case = Callable[..., Path]
Tilth = Callable[..., Outcome]


def strength(text: str) -> tuple[str, str]:
    """Replaces the yield stress."""
    return "yield_stress = 2e4", f"yield_stress = {text}"


RANDOM = (
    "mean = 2e4, coefficient_of_variation = 0.2, correlation_lengths = 1.0, "
    'distribution = "lognormal", model = "gaussian", seed = 1'
)


def random_field(old: str, new: str) -> tuple[str, str]:
    """Replaces the yield stress by a random field with one of its entries changed."""
    assert RANDOM.count(old) == 1
    return strength(f"{{ random = {{ {RANDOM.replace(old, new)} }} }}")


def layers(*bottoms: str) -> tuple[str, str]:
    """Replaces the material of the body by layers, each with the given further entry."""
    listed = ", ".join(f'{{ material = "clay"{entry} }}' for entry in bottoms)
    return 'material = "clay"\n', f"layers = [{listed}]\n"


KEY = "materials.clay.yield_stress"

WRONG = {
    "no kind of variation": (
        strength("{ deth = [[0, 1], [9, 1]] }"),
        [f"{KEY} = ", "must be a number, or a table with one of the keys", "it has none"],
    ),
    "two kinds of variation": (
        strength('{ depth = [[0, 1], [9, 1]], surface = 4, file = "a.csv" }'),
        [f"{KEY}.file", "no such file"],
    ),
    "depth and axis": (
        strength('{ depth = [[0, 1], [9, 1]], axis = "y" }'),
        [f"{KEY} = ", "it has more than one"],
    ),
    "no surface": (
        strength("{ depth = [[0, 1e4], [9, 2e4]] }"),
        [f"{KEY}.surface: missing", "measured downwards"],
    ),
    "depths that decrease": (
        strength("{ depth = [[0, 1e4], [9, 2e4], [8, 2e4]], surface = 4 }"),
        [f"{KEY}.depth = ", "the first column must increase, but 8 follows 9", "sort the rows"],
    ),
    "one row": (
        strength("{ depth = [[0, 1e4]], surface = 4 }"),
        [f"{KEY}.depth = ", "at least two rows (depth, value)"],
    ),
    "a text in a table": (
        strength('{ axis = "y", values = [[0, 1e4], [9, "2e4"]] }'),
        [f"{KEY}.values", "must be a number", "without quotes"],
    ),
    "no such axis": (
        strength('{ axis = "r", values = [[0, 1e4], [9, 2e4]] }'),
        [f'{KEY}.axis = "r"', 'choose from "x", "y", "z"'],
    ),
    "an axis of another dimension": (
        strength('{ axis = "z", values = [[0, 1e4], [9, 2e4]] }'),
        [f'{KEY}.axis = "z"', "names the z direction", "plane_strain has the directions x, y"],
    ),
    "a misspelt key": (
        strength('{ axis = "y", value = [[0, 1e4], [9, 2e4]] }'),
        [f"{KEY}.value", "unknown key", "did you mean `values`?"],
    ),
    "a point outside a table": (
        strength("{ depth = [[0, 1e4], [3, 2e4]], surface = 4 }"),
        [f"{KEY}.depth: the material point at (", "outside the table", "add a row"],
    ),
    "a value that is no strength": (
        strength("{ depth = [[0, 1e4], [9, -2e4]], surface = 4 }"),
        [f"{KEY} = -", "must be greater than zero, at the material point at ("],
    ),
    "a surface that is text": (
        strength('{ depth = [[0, 1e4], [9, 2e4]], surface = "4" }'),
        [f'{KEY}.surface = "4"', "must be a number", "without quotes"],
    ),
    "a surface beside the soil": (
        strength("{ depth = [[0, 1e4], [9, 2e4]], surface = [[3, 4], [9, 4]] }"),
        [f"{KEY}.surface: the material point at (", "its x is", "from 3 to 9"],
    ),
    "a grid that is not there": (
        strength('{ file = "su.csv" }'),
        [f'{KEY}.file = "su.csv"', "no such file", "relative to the case file"],
    ),
    "a surface that is not there": (
        strength('{ depth = [[0, 1e4], [9, 2e4]], surface = { file = "top.csv" } }'),
        [f'{KEY}.surface.file = "top.csv"', "no such file"],
    ),
    "a function that is not there": (
        strength('"su.py:strength"'),
        [f'{KEY} = "su.py:strength"', "no such file", "relative to the case file"],
    ),
    "no function": (
        strength('{ function = "su" }'),
        [f"{KEY}.function", "does not name a function in a Python file"],
    ),
    "no mean": (random_field("mean = 2e4, ", ""), [f"{KEY}.random.mean: missing", "give `mean`"]),
    "a mean of zero": (
        random_field("mean = 2e4", "mean = 0"),
        [f"{KEY}.random.mean = 0", "must be greater than zero"],
    ),
    "a negative coefficient of variation": (
        random_field("0.2", "-0.2"),
        [f"{KEY}.random.coefficient_of_variation = -0.2", "must be greater than zero"],
    ),
    "three correlation lengths in the plane": (
        random_field("1.0", "[1, 1, 1]"),
        [f"{KEY}.random.correlation_lengths", "must have 2 components, not 3"],
    ),
    "an unknown distribution": (
        random_field('"lognormal"', '"log-normal"'),
        [f"{KEY}.random.distribution", 'did you mean "lognormal"?'],
    ),
    "an unknown correlation model": (
        random_field('"gaussian"', '"markov"'),
        [f"{KEY}.random.model", 'choose from "exponential", "gaussian"'],
    ),
    "a negative seed": (
        random_field("seed = 1", "seed = -1"),
        [f"{KEY}.random.seed = -1", "must not be negative"],
    ),
    "too large a seed": (
        random_field("seed = 1", "seed = 5_000_000_000"),
        [f"{KEY}.random.seed", "must be at most"],
    ),
    "a gradient without a surface": (
        random_field("seed = 1", "seed = 1, gradient = 1e3"),
        [f"{KEY}.random.surface: missing", "give the elevation"],
    ),
    "a surface without a gradient": (
        random_field("seed = 1", "seed = 1, surface = 4"),
        [f"{KEY}.random.surface = 4.0", "has no meaning without a `gradient`"],
    ),
    "strength by stress": (
        strength('{ reference = 1e4, reference_pressure = 1e5, exponent = 1, stress = "mean" }'),
        [f"{KEY} = ", "must be a number, or a table", "it has none"],
    ),
    "a modulus by the stress that there is not": (
        (
            "young_modulus = 1e6",
            "young_modulus = "
            '{ reference = 1e6, reference_pressure = 1e5, exponent = 0.5, stress = "mean" }',
        ),
        ["materials.clay.young_modulus: depends on the initial stress", "[[initial.stress]]"],
    ),
    "an exponent above 1": (
        (
            "young_modulus = 1e6",
            "young_modulus = "
            '{ reference = 1e6, reference_pressure = 1e5, exponent = 2, stress = "mean" }',
        ),
        ["materials.clay.young_modulus.exponent = 2", "must be between 0 and 1"],
    ),
    "a density that varies": (
        ("density = 1800", "density = { depth = [[0, 1], [9, 1]], surface = 4 }"),
        ["materials.clay.density = ", "must be a number"],
    ),
    "material and layers": (
        ('material = "clay"\n', 'material = "clay"\nlayers = [{ material = "clay" }]\n'),
        ['bodies[0].material = "clay"', "given together with `layers`", "either one `material`"],
    ),
    "neither material nor layers": (
        ('material = "clay"\n', ""),
        ["bodies[0].material: missing", "or `layers` with a material each"],
    ),
    "a layer of an unknown material": (
        ('material = "clay"\n', 'layers = [{ material = "cley" }]\n'),
        ['bodies[0].layers[0].material = "cley"', "did you mean `clay`?"],
    ),
    "a layer without a horizon": (
        layers("", ""),
        ["bodies[0].layers[0].bottom: missing", "from the top down"],
    ),
    "a horizon below the lowest layer": (
        layers(", bottom = 2", ", bottom = 1"),
        ["bodies[0].layers[1].bottom", "the lowest layer has no horizon below it"],
    ),
    "layers in the wrong order": (
        layers(", bottom = 1", ", bottom = 2", ""),
        ["bodies[0].layers[1].bottom: lies at 2, above the horizon over it at 1"],
    ),
    "a layer outside the body": (
        layers(", bottom = 7", ""),
        ["bodies[0].layers[0]: no material point is in this layer of 'column'", "leave it out"],
    ),
    "a horizon that is not there": (
        layers(', bottom = { file = "a.csv" }', ""),
        ['bodies[0].layers[0].bottom.file = "a.csv"', "no such file"],
    ),
    "groups without a mesh": (
        layers(', group = "a"', ', group = "b"'),
        ["bodies[0].layers[0].group", "is for a body whose shape is a mesh"],
    ),
}


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize("name", WRONG)
def test_wrong_variation(tilth: Tilth, case: Case, command: str, name: str) -> None:
    pytest.importorskip("tilth._core")
    replaced, parts = WRONG[name]
    file = case(replaced)
    refused(tilth(command, file), str(file), parts)
    assert list(file.parent.iterdir()) == [file]


def test_a_polyline_as_horizon_in_3d(tilth: Tilth, case: Case) -> None:
    pytest.importorskip("tilth._core")
    file = case(
        ('kind = "plane_strain"', 'kind = "3d"'),
        ("lower = [-1, 0], upper = [2, 5]", "lower = [-1, 0, 0], upper = [2, 5, 5]"),
        ("lower = [0, 0], upper = [1, 4]", "lower = [0, 0, 0], upper = [1, 4, 4]"),
        ("acceleration = [0, -9.81]", "acceleration = [0, 0, -9.81]"),
        ("at = [0.5, 4]", "at = [0.5, 4, 4]"),
        layers(", bottom = [[0, 2], [1, 3]]", ""),
    )
    what = ["bodies[0].layers[0].bottom", "a polyline of rows (x, elevation) is for 2D"]
    refused(tilth("check", file), str(file), what)


def test_a_function_that_gives_no_numbers(tilth: Tilth, case: Case) -> None:
    pytest.importorskip("tilth._core")
    file = case(strength('"su.py:su"'))
    functions = file.with_name("su.py")
    functions.write_text("def su(x):\n    return x[:, 0] / 0.0\n", encoding="utf-8")
    what = [f"{KEY}.function = ", "returned inf at (", "a finite number everywhere where there is"]
    refused(tilth("run", file), str(file), what)
    functions.write_text("def su(x):\n    return 1.0\n", encoding="utf-8")
    refused(tilth("run", file), str(file), [f"{KEY}.function", "shape ()", "not (64,)"])


def test_a_specimen_whose_parameters_vary(tilth: Tilth, tmp_path: Path) -> None:
    file = tmp_path / "clay.toml"
    strength = "yield_stress = { depth = [[0, 10.0], [1, 20.0]], surface = 0.0 }"
    file.write_text(ELEMENT.replace("yield_stress = 40.0", strength), encoding="utf-8")
    what = [f"{KEY}: ", "varies from place to place, but a specimen is one", "give a number"]
    refused(tilth("element", file), str(file), what)
    assert list(tmp_path.iterdir()) == [file]


ELEMENT = """\
format = 1
[materials.clay]
model = "von_mises"
young_modulus = 5e3
poisson_ratio = 0.3
yield_stress = 40.0
hardening_modulus = 0.0
[[tests]]
name = "drained"
type = "triaxial"
material = "clay"
start = { isotropic = 100 }
drainage = "drained"
direction = "compression"
axial_strain = 0.1
steps = 2
"""
