# SPDX-License-Identifier: BSD-3-Clause
"""A consolidating column in other units, mirrored, with its bodies in another order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from clay_columns import CLAY, ENTRIES, UNDER_WATER, column, computed, pressures

from tilth.analysis.staged import StagedAnalysis
from tilth.arrays import Floats

TIGHT = {"analysis.tolerance": 1e-11}
RTOL = 1e-9
SECONDS = 86400.0
"""In a day."""


def by_place(analysis: StagedAnalysis, scale: float = 1.0, sign: float = 1.0) -> Floats:
    """Pressures and vertical displacements in the order of the points' places, shape (n, 2)."""
    points = analysis.state.points
    place = np.round(points.position * [sign, 1.0] / scale, 6)
    found = np.stack([pressures(analysis), points.displacement[:, 1]], axis=1)
    return np.asarray(found[np.lexsort(place.T)])


def loaded() -> dict[str, Any]:
    """The column under water, in two stages."""
    stages = [
        {"name": "loading", "schedule": {"end": 1.0, "steps": 1}, "flow": False},
        {"name": "consolidation", "schedule": {"end": 2.0, "steps": 4}},
    ]
    k0 = [{"type": "k0", "body": "soil", "K0": 3.0 / 7.0}]
    water = {**UNDER_WATER, "initial.stress": k0, "flow.bulk_modulus": 1e5}
    return column({**water, **TIGHT, "schedule": None, "stages": stages})


def scaled(entries: Any, factors: Mapping[str, float]) -> Any:
    """Entries whose numbers are multiplied by factors, by their keys."""
    if isinstance(entries, Mapping):
        return {
            key: times(value, factors[key]) if key in factors else scaled(value, factors)
            for key, value in entries.items()
        }
    return [scaled(each, factors) for each in entries] if isinstance(entries, list) else entries


def times(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [times(each, factor) for each in value]
    if isinstance(value, Mapping):
        return {key: times(each, factor) for key, each in value.items()}
    return value * factor


def test_millimetres_newtons_and_seconds_give_the_same() -> None:
    """In place of metres, kilonewtons and days; accelerations are not in the unit of time."""
    length, stress, weight = 1e3, 1e-3, 1e3 / 1e9
    one = loaded()
    other = scaled(one, {
        "cell_size": length, "lower": length, "upper": length, "at": length, "start": length,
        "level": length, "young_modulus": stress, "pressure": stress, "bulk_modulus": stress,
        "unit_weight": weight, "hydraulic_conductivity": length / SECONDS, "end": SECONDS,
        "acceleration": length, "density": 1e-9, "saturated_density": 1e-9, "factor": 1.0,
    })  # fmt: skip
    for load in other["loads"]:
        load["factor"] = [[time * SECONDS, factor] for time, factor in load["factor"]]
        if load["type"] == "surface":
            load["end"] = [each / SECONDS * length for each in load["end"]]
    units = {"length": "mm", "force": "N", "stress": "MPa", "mass": "t", "time": "s"}
    analyses = [computed(one), computed({**other, "units": units})]
    assert not [text for each in analyses for text in each.services.warnings.texts]
    found = by_place(analyses[0]), by_place(analyses[1], length) / [stress, length]
    for column_ in (0, 1):
        size = np.abs(found[0][:, column_]).max()
        assert size > 0.0
        np.testing.assert_allclose(found[1][:, column_], found[0][:, column_], atol=RTOL * size)


def test_a_mirror_image_has_mirrored_results() -> None:
    one = loaded()
    other = loaded()
    other["bodies"][0]["shape"] |= {"lower": [-0.5, 0.0], "upper": [0.0, 3.0]}
    other["boundaries"][1]["at"] = -0.5
    other["loads"][1] |= {"start": [0.0, 3.0], "end": [-0.5, 3.0]}
    found = by_place(computed(one)), by_place(computed(other), sign=-1.0)
    np.testing.assert_allclose(found[1], found[0], rtol=RTOL, atol=RTOL * np.abs(found[0]).max())


def layered(order: tuple[int, int]) -> dict[str, Any]:
    """A column of two bodies, the upper one of sand, declared in an order."""
    lower = {**ENTRIES["bodies"][0], "name": "low", "surface": None}
    del lower["surface"]
    lower["shape"] = {"type": "box", "lower": [0.0, 0.0], "upper": [0.5, 1.5]}
    upper = {**ENTRIES["bodies"][0], "name": "soil", "material": "sand"}
    upper["shape"] = {"type": "box", "lower": [0.0, 1.5], "upper": [0.5, 3.0]}
    bodies = [lower, upper]
    sand = {**CLAY, "hydraulic_conductivity": 1e-1, "permeability": "kozeny_carman"}
    return column(
        {**TIGHT, "bodies": [bodies[i] for i in order], "materials.sand": sand,
         "schedule": {"end": 4.0, "steps": 4}}
    )  # fmt: skip


def test_the_order_of_bodies_and_drains_does_not_matter() -> None:
    entries = [layered((0, 1)), layered((1, 0))]
    middle = {"name": "middle", "type": "plane", "axis": "y", "at": 1.5, "condition": "pressure",
              "excess_pressure": 1.0}  # fmt: skip
    drains = [*ENTRIES["flow"]["boundaries"], middle]
    found = []
    for each, order in zip(entries, (drains, drains[::-1]), strict=True):
        each["flow"] = {**each["flow"], "boundaries": order}
        found.append(by_place(computed(each)))
    size = np.abs(found[0]).max()
    assert size == pytest.approx(1.0, rel=0.2)
    np.testing.assert_allclose(found[1], found[0], atol=RTOL * size)
