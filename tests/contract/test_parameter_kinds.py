# SPDX-License-Identifier: BSD-3-Clause
"""Every law says what each of its numbers is, and what it says is true of the law.

The kinds are tested by what follows from them: the law at other strains, in other units, and with
its strength over a factor.
"""

from __future__ import annotations

import re
from typing import Any, get_args

import numpy as np
import pytest
from law_updates import around_start
from small_problems import (
    MATERIALS,
    VARIANTS,
    declared,
    initial_state,
    material_entries,
    parameters,
)

from tilth import _core
from tilth.arrays import Floats
from tilth.model.base import meaning_of
from tilth.model.laws import laws
from tilth.model.materials import Material
from tilth.model.parameter_kinds import KINDS, LIMITS, reduced, stiffened
from tilth.model.soils import NO_CUT_OFF

CLASSES = get_args(get_args(Material)[0])
DENSITIES = {"density", "saturated_density"}
FACTOR = 1.7

every_material = pytest.mark.parametrize("material", MATERIALS)
every_variant = pytest.mark.parametrize(("material", "changed"), VARIANTS)


def returned(
    material: str, given: Floats, trial: Floats, plastic: float, before: Floats
) -> tuple[Floats, Floats, Floats]:
    """Stress and elastic strain (n, 3) and state (n, k) after trial strains (n, 3)."""
    n = len(trial)
    stress, elastic, tangent = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    after, good = np.empty((n, len(before))), np.zeros(n, dtype=bool)
    _core.principal_update(
        material, given, np.ascontiguousarray(trial), np.tile([plastic, 0.0], (n, 1)),
        np.tile(before, (n, 1)), after, stress, elastic, tangent, good,
    )  # fmt: skip
    assert good.all()
    return stress, elastic, after


def trials(material: str, changed: dict[str, Any]) -> Floats:
    """Elastic and plastic trial strains, shape (60, 3)."""
    random = np.random.default_rng(2)
    strains = random.normal(size=(60, 3)) * 10.0 ** random.uniform(-3, -0.7, (60, 1))
    return np.array([around_start(material, each, **changed) for each in strains])


def test_every_law_of_the_core_says_what_its_numbers_are() -> None:
    assert set(MATERIALS) == laws().keys()
    for name, law in laws().items():
        material = declared(name)
        assert material.law is law
        assert material.parameter_kinds_of(law).keys() == set(law.parameters)
        kinds = material.state_kinds_of(law)
        assert kinds.keys() == law.state_variables.keys()
        units = {variable: KINDS[kind].unit for variable, kind in kinds.items()}
        assert units == law.state_variables


@pytest.mark.parametrize("cls", CLASSES)
def test_every_entry_with_a_unit_has_a_kind_of_this_unit(cls: Any) -> None:
    """A kind that names no entry and no parameter of a law of the core is a slip."""
    units = {
        key: found[1]
        for key in cls.model_fields
        if (found := re.search(r"\[([^\]]+)\](?!\()", meaning_of(cls, key)))
    }
    assert units.keys() >= DENSITIES
    assert units == {
        key: KINDS[kind].unit for key, kind in cls.kinds.items() if key in cls.model_fields
    }
    names = {name for law in laws().values() for name in law.parameters} | {"cell_length"}
    assert cls.kinds.keys() <= cls.model_fields.keys() | names


@every_variant
@pytest.mark.parametrize("plastic_strain", [0.0, 0.1])
def test_strains_over_a_number_give_the_stress_of_a_law_that_is_as_much_stiffer(
    material: str, changed: dict[str, Any], plastic_strain: float
) -> None:
    entries, scale = declared(material, **changed), 64.0
    given, before = parameters(material, **changed), initial_state(material, **changed)
    kinds = list(entries.state_kinds_of(laws()[material]).values())
    trial = trials(material, changed)
    stress, elastic, state = returned(material, given, trial, plastic_strain, before)
    stiff_state = np.array([stiffened(*each, scale) for each in zip(kinds, before, strict=True)])
    found, strain, after = returned(
        material, entries.stiffened_parameters(given, scale), trial / scale,
        plastic_strain / scale, stiff_state,
    )  # fmt: skip
    size = np.abs(stress).max()
    np.testing.assert_allclose(found, stress, rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(strain * scale, elastic, rtol=0, atol=1e-9)
    for column, kind in enumerate(kinds):
        expected = stiffened(kind, state[:, column], scale)
        np.testing.assert_allclose(after[:, column], expected, rtol=1e-8, atol=1e-9 * size / scale)


@every_variant
def test_in_other_units_of_stress_and_length_the_law_is_the_same(
    material: str, changed: dict[str, Any]
) -> None:
    units = {"stress": 8.0, "length": 4.0, "mass / length^3": 0.5, "-": 1.0, "degrees": 1.0}
    cls = type(declared(material, **changed))
    own = material_entries(material, **changed)
    other = {
        key: value * units[KINDS[cls.kinds[key]].unit] if key in cls.kinds else value
        for key, value in own.items()
    }
    softening = units["length"] if "softening_length" in own else 1.0
    given = parameters(material, **changed)
    scaled = parameters(material, **{**changed, **other})
    names = laws()[material].parameters
    if "softening_strain" in names:  # cells of size 1 in both units
        scaled[names.index("softening_strain")] /= softening
    trial, before = trials(material, changed), initial_state(material, **changed)
    kinds = declared(material).state_kinds_of(laws()[material]).values()
    factors = np.array([units[KINDS[kind].unit] for kind in kinds])
    if material.endswith("cam_clay"):  # the strain is 0 at the pressure 1 of the units
        scaled[names.index("reference_pressure")] *= units["stress"]
    stress, elastic, state = returned(material, given, trial, 0.05, before)
    found, strain, after = returned(material, scaled, trial, 0.05, before * factors)
    size = np.abs(stress).max()
    np.testing.assert_allclose(found, units["stress"] * stress, rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(strain, elastic, rtol=0, atol=1e-10)
    np.testing.assert_allclose(after, state * factors, rtol=1e-9, atol=1e-9 * size)


@every_variant
def test_a_factor_changes_strengths_and_what_they_limit_only(
    material: str, changed: dict[str, Any]
) -> None:
    entries, law = declared(material, **changed), laws()[material]
    if any(KINDS[kind].reduced == "never" for kind in entries.kinds_of_parameters.values()):
        pytest.skip("cannot be reduced")
    given = parameters(material, **changed)
    found = entries.reduced_parameters(given, FACTOR)
    for name, before, after in zip(law.parameters, given, found, strict=True):
        rule = KINDS[entries.kinds[name]].reduced
        if rule is None or before in (0.0, NO_CUT_OFF):
            assert after == before, name
        elif rule == "limited":
            assert after <= before * (1.0 + 1e-12), name
        else:
            assert 0.0 < after < before, name


@pytest.mark.parametrize("psi", [0.0, 10.0, 24.0])
def test_the_kinds_alone_reduce_mohr_and_coulombs_law_as_it_does_itself(psi: float) -> None:
    entries = declared("mohr_coulomb", friction_angle=25.0, dilation_angle=psi, tension_cut_off=3.0)
    names = entries.parameter_names
    given = parameters("mohr_coulomb", friction_angle=25.0, dilation_angle=psi, tension_cut_off=3.0)
    own = entries.reduced_parameters(given, FACTOR)
    found = reduced(entries.kinds_of_parameters, dict(zip(names, given, strict=True)), FACTOR)
    assert found == dict(zip(names, own, strict=True))


def test_dilation_is_limited_by_the_friction_of_its_own_measure() -> None:
    kinds: dict[str, Any] = {"M": "friction slope", "D": "dilation slope", "psi": "dilation angle"}
    found = reduced(kinds, {"M": np.array([1.2, 0.6]), "D": np.array([0.5, 0.5]), "psi": 5.0}, 2.0)
    np.testing.assert_array_equal(found["M"], [0.6, 0.3])
    np.testing.assert_array_equal(found["D"], [0.5, 0.3])
    assert found["psi"] == 5.0
    assert set(LIMITS) == {kind for kind, rules in KINDS.items() if rules.reduced == "limited"}
