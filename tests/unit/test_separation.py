# SPDX-License-Identifier: BSD-3-Clause
"""Soil that separates: volume gained at the apex must close before pressure comes back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from law_updates import BULK, SHEAR, Update, update
from small_problems import block_entries, declared, material_entries, parameters

from tilth import BadInput, Model, _core
from tilth.arrays import Floats

LAWS = ("separating_mohr_coulomb", "separating_drucker_prager")
every_law = pytest.mark.parametrize("law", LAWS)
SAND: dict[str, Any] = {"cohesion": 0.0, "friction_angle": 30.0, "dilation_angle": 0.0}


def steps(law: str, increments: list[Floats], **changed: Any) -> list[Update]:
    """States of a point after increments of its principal strains, one after the other."""
    found: list[Update] = []
    for increment in increments:
        before = found[-1] if found else update(law, np.zeros(3), **SAND | changed)
        found.append(update(law, before.elastic + increment, 0.0, before.state, **SAND | changed))
    return found


@every_law
def test_a_gap_closes_before_pressure_comes_back(law: str) -> None:
    """Pulled apart by 0.3, sheared, and pressed together by a bit more than that: K times it."""
    unit = np.ones(3) / 3.0
    shear = np.array([0.2, 0.0, -0.2])
    apart, sheared, nearer, pressed = steps(law, [0.3 * unit, shear, -0.2 * unit, -0.101 * unit])
    for each, void in ((apart, 0.3), (sheared, 0.3), (nearer, 0.1)):
        np.testing.assert_allclose(each.stress, 0.0, atol=1e-12 * BULK)
        np.testing.assert_allclose(each.state, [void], rtol=1e-12)
    np.testing.assert_allclose(pressed.stress, -0.001 * BULK, rtol=1e-10)
    assert pressed.state[0] == 0.0


@every_law
def test_other_soil_forgets_what_it_gained(law: str) -> None:
    """The law alone: pressure comes back with the first compression."""
    unit = np.ones(3) / 3.0
    pressed = steps(law.removeprefix("separating_"), [0.3 * unit, -0.2 * unit])[-1]
    np.testing.assert_allclose(pressed.stress, -0.2 * BULK, rtol=1e-10)


@every_law
def test_soil_that_is_never_pulled_apart_is_that_of_the_law_alone(law: str) -> None:
    random = np.random.default_rng(4)
    increments = [0.02 * random.normal(size=3) - 0.05 for _ in range(30)]
    own = steps(law, increments, cohesion=5.0)
    alone = steps(law.removeprefix("separating_"), increments, cohesion=5.0)
    for one, other in zip(own, alone, strict=True):
        assert np.array_equal(one.stress, other.stress)
        assert np.array_equal(one.tangent, other.tangent)
        assert one.state[0] == 0.0


@every_law
@pytest.mark.parametrize("cohesion", [0.0, 8.0])
@pytest.mark.parametrize("psi", [0.0, 20.0])
def test_the_tangent_of_soil_with_voids_is_the_derivative(
    law: str, cohesion: float, psi: float
) -> None:
    random = np.random.default_rng(6)
    changed = SAND | {"cohesion": cohesion, "dilation_angle": psi}
    closed = 0
    for _ in range(300):
        void = 10.0 ** random.uniform(-3, 0)
        trial = 0.3 * void * random.normal(size=3) - random.uniform(0.0, 0.6) * void
        state, direction, step = np.array([void]), random.normal(size=3), 1e-6 * void
        ahead, here, behind = (
            update(law, trial + sign * step * direction, 0.0, state, **changed)
            for sign in (1.0, 0.0, -1.0)
        )
        if np.abs(ahead.stress - 2.0 * here.stress + behind.stress).max() > 1e-3 * step * BULK:
            continue  # on the border of two regions of the return mapping
        closed += here.state[0] == 0.0
        slope = (ahead.stress - behind.stress) / (2.0 * step)
        np.testing.assert_allclose(here.tangent @ direction, slope, rtol=0, atol=1e-6 * BULK)
    assert 60 < closed < 260, "both open and closed states are tested"


@every_law
def test_closing_dissipates_nothing(law: str) -> None:
    """A step that closes a gap of 0.1 and compresses by 0.001 stores all its work."""
    stretch = np.expm1(2.0 * -0.101 / 3.0)
    deformation = np.array([[stretch] * 3 + [0.0] * 3])
    elastic, plastic, stress = np.empty((1, 6)), np.empty((1, 2)), np.empty((1, 6))
    after, good = np.empty((1, 1)), np.zeros(1, dtype=bool)
    _core.return_to_law(
        "3d", law, parameters(law, **SAND), deformation, np.zeros((1, 2)), np.array([[0.1]]),
        elastic, plastic, after, stress, good,
    )  # fmt: skip
    assert good.all()
    np.testing.assert_allclose(stress[0, :3], -0.001 * BULK, rtol=1e-9)
    np.testing.assert_allclose(plastic[0], 0.0, atol=1e-12 * SHEAR)


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({"tension_cut_off": 1.0}, "tension_cut_off = 1.0: is given together with `separates`"),
        ({"pore_fluid_bulk_modulus": 1e4}, "`separates`"),
        ({"friction_angle": 0.0, "cohesion": 5.0}, "separates = true: needs an apex"),
    ],
)
@every_law
def test_what_does_not_go_with_it_is_refused(law: str, changed: dict[str, Any], text: str) -> None:
    assert declared(law, **SAND).law.name == law
    entries = block_entries("plane_strain", "gimp")
    entries["materials"] = {"soil": material_entries(law, **SAND | changed)}
    with pytest.raises(BadInput) as caught:
        Model.from_dict(entries)
    assert text in str(caught.value)
