# SPDX-License-Identifier: BSD-3-Clause
"""Labels that contradict each other, and numbers that look like other units, are named."""

from __future__ import annotations

from typing import Any

import pytest
from small_problems import block_entries, material_entries, rollers

from tilth import Model
from tilth.analysis.snapshots import units_of
from tilth.analysis.unit_warnings import unit_warnings
from tilth.model.unit_labels import force_of, label_of, length_of, mass_of, same, stress_of
from tilth.mpm.initial_points import initial_points
from tilth.report.fields import field_unit

KILO = {"length": "m", "force": "kN", "stress": "kPa", "mass": "t"}
SOIL = {
    "model": "mohr_coulomb", "young_modulus": 2e4, "poisson_ratio": 0.3, "cohesion": 5.0,
    "friction_angle": 30.0, "dilation_angle": 0.0, "density": 1.9,
}  # fmt: skip
GRAVITY = {"type": "body_force", "acceleration": [0.0, -9.81]}


def warned(soil: dict[str, Any] | None = None, **changes: Any) -> list[str]:
    entries = block_entries("plane_strain", "gimp", boundaries=rollers("plane_strain"))
    materials = {"soil": {**SOIL, **(soil or {})}}
    given = {**entries, "materials": materials, "loads": [GRAVITY], "units": KILO, **changes}
    model = Model.from_dict(given)
    return [text for _, text in unit_warnings(model, initial_points(model))]


CONSISTENT = [
    {"length": "m", "force": "N", "stress": "Pa", "mass": "kg"},
    KILO,
    {"length": "m", "force": "MN", "stress": "MPa", "mass": "Gg"},
    {"length": "m", "force": "kN", "stress": "kN/m2", "mass": "Mg"},
    {"length": "m", "force": "kN/m", "stress": "kN/m^2", "mass": "t"},
    {"length": "mm", "force": "N", "stress": "MPa", "mass": "t"},
    {"length": "mm", "force": "N", "stress": "N/mm²", "mass": "t"},
    {"length": "ft", "force": "lb", "stress": "psf", "mass": "slug"},
    {"length": "ft", "force": "lbf", "stress": "lbf/ft2", "mass": "slug"},
    {"length": "in", "force": "lbf", "stress": "psi", "mass": "slinch"},
    {"length": "ft", "force": "pdl", "stress": "pdl/ft2", "mass": "lb"},
    {"length": "mm", "force": "kN", "stress": "GPa", "mass": "kg", "time": "ms"},
]


@pytest.mark.parametrize("units", CONSISTENT, ids=lambda units: " ".join(units.values()))
def test_consistent_labels_are_silent(units: dict[str, str]) -> None:
    """With soil of 18.6 kN/m3, in these units."""
    length, mass = length_of(units["length"]), mass_of(units["mass"])
    stress = stress_of(units["stress"])
    assert length is not None
    assert mass is not None
    assert stress is not None
    assert force_of(units["force"], length) is not None
    time = 1e-3 if units.get("time") else 1.0
    density, gravity = 1900.0 / mass * length**3, 9.81 / length * time**2
    soil = {"density": density, "young_modulus": 2e7 / stress, "cohesion": 5e3 / stress}
    load = {**GRAVITY, "acceleration": [0.0, -gravity]}
    assert warned(soil, units=units, loads=[load]) == []


@pytest.mark.parametrize(
    ("units", "words"),
    [
        ({"stress": "Pa"}, ["units.stress = 'Pa'", "is 1000 Pa", 'stress = "kPa" or force = "N"']),
        ({"force": "N"}, ["units.stress = 'kPa'", "N/m^2 is 0.001 kPa", 'force = "kN"']),
        ({"mass": "kg"}, ["units.mass = 'kg'", "kg m/s^2 is 0.001 kN", 'mass = "t"']),
        ({"length": "mm"}, ["units.stress = 'kPa'", "kN/mm^2 is 1e+06 kPa", '"GPa"']),
        ({"length": "ft", "stress": "psf"}, ["kN/ft^2"]),
    ],
)
def test_labels_that_contradict_each_other(units: dict[str, str], words: list[str]) -> None:
    found = [text for text in warned(units={**KILO, **units}) if text.startswith("units.")]
    assert found
    for word in words:
        assert word in found[0]


@pytest.mark.parametrize(
    "units", [{"stress": "tsf"}, {"length": "fathom"}, {"force": "F", "stress": "S", "mass": "M"}]
)
def test_nothing_is_guessed_of_labels_that_one_does_not_know(units: dict[str, str]) -> None:
    assert warned({"density": 19.0}, units={**KILO, "force": "P", **units}) == []


def test_the_mass_is_silent_without_weight() -> None:
    units = {**KILO, "mass": "kg"}
    load = {"type": "body_force", "acceleration": [0.0, 0.0]}
    assert warned(units=units, loads=[load]) == []
    weightless = {key: value for key, value in SOIL.items() if key != "density"}
    assert warned({**weightless, "density": 0.0}, units=units) == []
    time = {"units": {**KILO, "time": "min"}, "analysis": inertia()}
    time["schedule"] = {"steps": 2, "end": 1.0}
    assert any("t m/min^2" in text for text in warned(**time))


def inertia() -> dict[str, Any]:
    return {
        "kind": "plane_strain",
        "inertia": {"scheme": "generalised_alpha", "spectral_radius": 0.9, "largest_motion": 0.1},
    }


@pytest.mark.parametrize(
    ("density", "words"),
    [
        (19.0, "which is 186 kN/m3, and soil has 5 to 40 kN/m3"),
        (0.019, "the unit weight is 0.1864 kN/m^3"),
        (19000.0, "0.1019 for each kN/m3"),
        (0.7, None),  # buoyant
        (3.0, None),
    ],
)
def test_unit_weights_that_no_soil_has(density: float, words: str | None) -> None:
    found = warned({"density": density})
    assert len(found) == (words is not None)
    if words is not None:
        assert found[0].startswith(f"materials.soil.density = {density:g}: ")
        assert words in found[0]
        assert "or correct the labels in [units]" in found[0]


def test_units_that_are_not_given() -> None:
    """Numbers in kN, kPa and t are then called N, Pa and kg."""
    found = warned(units={})
    assert any("as without them they are m, N, Pa and kg" in text for text in found)


def test_weights_of_other_materials_and_tests() -> None:
    """Steel and foam; a load increased to collapse; a centrifuge at 50 g."""
    for density in (7.85, 0.02):
        steel = {**material_entries("hencky_elastic"), "density": density}
        assert warned(materials={"soil": steel}) == []
    assert warned(loads=[{**GRAVITY, "factor": [[0, 0], [1, 8]]}]) == []
    assert warned(loads=[{**GRAVITY, "acceleration": [0, -490.0]}]) == []
    assert len(warned(loads=[{**GRAVITY, "acceleration": [0, -9810.0]}])) == 1
    saturated = {"saturated_density": 0.2}
    water = {"level": 5.0, "unit_weight": 9.81}
    assert len(warned({**saturated, "density": 0.19}, water=water)) == 2


@pytest.mark.parametrize(("weight", "named"), [(9.81, False), (10.3, False), (9810.0, True)])
def test_water_of_another_unit(weight: float, named: bool) -> None:
    found = warned(water={"level": 0.5, "unit_weight": weight})
    assert len(found) == named
    assert all("water has 9.81, 9.81 kN/m^3" in text for text in found)


@pytest.mark.parametrize(
    ("soil", "words"),
    [
        ({"friction_angle": 0.5236}, "0.5236 radians are 30 degrees: give it in degrees"),
        ({"friction_angle": 0.6, "dilation_angle": 0.1}, "give it and `dilation_angle` in"),
        ({"friction_angle": 34.0, "dilation_angle": 0.5}, None),
        ({"friction_angle": 2.0}, None),
        ({"friction_angle": 0.0}, None),
        (
            {"residual_friction_angle": 0.35, "softening_strain": 0.1, "softening_length": 0.1},
            "residual_friction_angle: an angle of 0.35",
        ),
    ],
)
def test_angles_in_radians(soil: dict[str, Any], words: str | None) -> None:
    found = warned(soil)
    assert len(found) == (words is not None)
    assert all(words in text for text in found if words)


@pytest.mark.parametrize(("factor", "named"), [(1.0, True), (-1.0, False)])
def test_gravity_upwards(factor: float, named: bool) -> None:
    load = {"type": "body_force", "acceleration": [0.0, 9.81], "factor": [[0, 0], [1, factor]]}
    found = warned(loads=[load])
    assert len(found) == named
    assert all(text.startswith("loads[0].acceleration: the only body force") for text in found)


@pytest.mark.parametrize(("strength", "named"), [(20e3, False), (20.0, True)])
def test_a_strength_in_other_units_than_the_stiffness(strength: float, named: bool) -> None:
    clay = material_entries("tresca", young_modulus=4e6, undrained_shear_strength=strength)
    found = warned(materials={"soil": {**clay, "density": 1.9}})
    assert len(found) == named
    assert all("2e+05 times the undrained shear strength 20" in text for text in found)


@pytest.mark.parametrize(
    ("kind", "unit"), [("plane_strain", "m²"), ("axisymmetric", "m³"), ("3d", "m³")]
)
def test_the_volume_of_a_point_in_plane_strain_has_the_unit_of_an_area(
    kind: str, unit: str
) -> None:
    entries = block_entries(kind, "gimp", boundaries=rollers(kind))
    labels = units_of(Model.from_dict(entries))
    assert field_unit("volume", labels) == unit
    without = units_of(Model.from_dict({**entries, "units": {"length": ""}}))
    assert field_unit("volume", without) == "-"


def test_values_of_labels() -> None:
    """Each known unit has a value that is that of its definition."""
    assert same(stress_of("psi") or 0.0, 6894.757)
    assert same(stress_of("psf") or 0.0, 47.880259)
    assert same((mass_of("slug") or 0.0) * 0.3048, force_of("lbf", 1.0) or 0.0)
    assert label_of(1e3, {"N": 1.0, "kN": 1e3}) == "kN"
    assert label_of(2e3, {"N": 1.0, "kN": 1e3}) == ""
