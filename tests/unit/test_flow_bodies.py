# SPDX-License-Identifier: BSD-3-Clause
"""Water that flows in some bodies beside others, and in soil that is placed and dug."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from clay_columns import (
    CLAY,
    ENTRIES,
    GRAVITY,
    HEIGHT,
    LOAD,
    UNDER_WATER,
    column,
    computed,
    pressures,
)

from tilth import BadInput, Model
from tilth.mpm.pore_water import CONDUCTIVITY, POROSITY

SOIL = ENTRIES["bodies"][0]
ELASTIC = {key: CLAY[key] for key in ("model", "young_modulus", "poisson_ratio")}
SHUT = {"name": "shut", "schedule": {"end": 1.0, "steps": 1}, "flow": False}
AT_REST = {**UNDER_WATER, "loads": [GRAVITY], "schedule": None,
           "initial.stress": [{"type": "k0", "body": "soil", "K0": 0.5}]}  # fmt: skip


def body(name: str, low: float, high: float, **more: Any) -> dict[str, Any]:
    shape = {"type": "box", "lower": [0.0, low], "upper": [0.5, high]}
    return {**{k: v for k, v in SOIL.items() if k != "surface"}, "name": name, "shape": shape,
            **more}  # fmt: skip


BESIDE: Mapping[str, Mapping[str, Any]] = {
    "dry": ELASTIC,
    "watertight": {**ELASTIC, "watertight": True},
    "undrained": {**ELASTIC, "pore_fluid_bulk_modulus": 1e5},
}


@pytest.mark.parametrize("kind", BESIDE)
def test_soil_below_lets_no_water_in(kind: str) -> None:
    """The upper half drains to the line between the two, as a column of its own would."""
    upper = body("soil", 1.5, HEIGHT, surface={})
    bodies = [body("below", 0.0, 1.5, material="other"), upper]
    drain = {"flow.boundaries.0.at": 1.5}
    both = computed(column({**drain, "bodies": bodies, "materials.other": BESIDE[kind]}))
    alone = computed(column({**drain, "bodies": [upper], "boundaries.2.at": 1.5}))
    wet = both.state.points.position[:, 1] > 1.5 - 0.1
    found, expected = pressures(both), pressures(alone)
    assert not found[~wet].any()
    np.testing.assert_allclose(found[wet], expected, atol=0.01 * LOAD)


def test_dug_soil_takes_its_weight_off_the_water() -> None:
    """A metre of 18 kN/m3, in whose place there is water then: -8 kPa."""
    region = {"body": "soil", "shape": {"type": "box", "lower": [0, 2], "upper": [0.5, 3]}}
    stages = [SHUT, {**SHUT, "name": "dug", "excavate": [region]}]
    entries = {**AT_REST, "bodies": [body("soil", 0.0, HEIGHT)], "stages": stages}
    np.testing.assert_allclose(pressures(computed(column(entries))), -8.0, rtol=0.01)


def test_placed_soil_weighs_on_the_water() -> None:
    """A metre of 18 kN/m3 above the water, in which no water flows."""
    stages = [SHUT, {**SHUT, "name": "placed", "activate": ["fill"]}]
    sand = {**ELASTIC, "density": 1.8, "saturated_density": 2.0}
    bodies = [SOIL, body("fill", HEIGHT, HEIGHT + 1.0, material="sand")]
    entries = {**AT_REST, "bodies": bodies, "materials.sand": sand, "stages": stages}
    analysis = computed(column(entries))
    points = analysis.state.points
    soil = points.of_body("soil")
    np.testing.assert_allclose(pressures(analysis)[soil], 18.0, rtol=0.02)
    assert not points.water[points.of_body("fill")].any()


def test_placed_clay_has_water_without_excess_pressure() -> None:
    stages = [SHUT, {**SHUT, "name": "placed", "activate": ["more"]}]
    entries = {"schedule": None, "stages": stages, "loads": [],
               "bodies": [SOIL, body("more", HEIGHT, HEIGHT + 1.0)]}  # fmt: skip
    analysis = computed(column(entries))
    points = analysis.state.points
    np.testing.assert_allclose(points.water[points.of_body("more"), POROSITY], 0.5)
    np.testing.assert_allclose(pressures(analysis), 0.0, atol=1e-9)


def test_pores_vary_from_place_to_place() -> None:
    depth = {"depth": [[0.0, 1e-3], [3.0, 4e-3]], "surface": HEIGHT}
    porous = {"depth": [[0.0, 0.6], [3.0, 0.3]], "surface": HEIGHT}
    clay = {**CLAY, "hydraulic_conductivity": depth, "porosity": porous}
    analysis = computed(column({"materials.clay": clay, "bodies": [body("soil", 0.0, HEIGHT)],
                                "loads": [], "schedule": {"end": 1.0, "steps": 1}}))  # fmt: skip
    points = analysis.state.points
    below = HEIGHT - points.position[:, 1]
    np.testing.assert_allclose(points.water[:, CONDUCTIVITY], 1e-4 * (1.0 + below), rtol=1e-9)
    np.testing.assert_allclose(points.water[:, POROSITY], 0.6 - 0.1 * below, rtol=1e-9)


@pytest.mark.parametrize(("key", "last"), [("porosity", 1.4), ("hydraulic_conductivity", -1.0)])
def test_wrong_pores_name_their_place(key: str, last: float) -> None:
    rows = {"depth": [[0.0, 0.5], [3.0, last]], "surface": HEIGHT}
    with pytest.raises(BadInput) as error:
        computed(column({f"materials.clay.{key}": rows}))
    assert error.value.key == f"materials.clay.{key}"
    assert "at the material point at (0.125, 0.125)" in error.value.problem


def test_loads_of_bodies_that_are_gone_are_named() -> None:
    bodies = [body("below", 0.0, 1.5), body("soil", 1.5, HEIGHT, surface={})]
    stages = [SHUT, {**SHUT, "name": "dug", "deactivate": ["soil"]}]
    with pytest.raises(BadInput) as error:
        Model.from_dict(column({"bodies": bodies, "schedule": None, "stages": stages}))
    assert error.value.key == "stages[1]"
