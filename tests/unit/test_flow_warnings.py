# SPDX-License-Identifier: BSD-3-Clause
"""Warnings of flowing water, and the time of consolidation that tilth check tells."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import pytest
from clay_columns import CLAY, COEFFICIENT, ENTRIES, GRAVITY, HEIGHT, UNDER_WATER, column
from rich.console import Console

from tilth import Model, check
from tilth.analysis.check import consolidation_texts
from tilth.analysis.consolidation_time import ConsolidationTime, consolidation_time
from tilth.analysis.memory import memory_of
from tilth.analysis.setup_picture import setup_figures
from tilth.analysis.simulation import Simulation
from tilth.report.setup_data import Setup
from tilth.report.summary import print_summary

WAY = HEIGHT - 0.125
"""Of the water from the farthest material point [m]."""
DRAIN = ENTRIES["flow"]["boundaries"][0]
KILO = ENTRIES["units"]


def warned(changes: Mapping[str, Any] | None = None) -> list[str]:
    return check(Model.from_dict(column(changes))).warnings


def estimate(changes: Mapping[str, Any] | None = None) -> ConsolidationTime:
    simulation = Simulation(Model.from_dict(column(changes)))
    state = simulation.state
    found = consolidation_time(
        simulation.setup.model, state.undeformed(), state.surfaces, state.grid
    )
    assert found is not None
    return found


def test_a_right_case_is_silent() -> None:
    assert warned() == []
    assert warned({**UNDER_WATER, "schedule": {"end": 8.0, "steps": 40}}) == []


def test_the_time_of_consolidation_follows_from_the_longest_way() -> None:
    found = estimate()
    assert found.coefficients == pytest.approx((COEFFICIENT, COEFFICIENT))
    assert found.path == pytest.approx(WAY)
    assert found.time == pytest.approx(0.848 * WAY**2 / COEFFICIENT)
    assert found.first_step == pytest.approx(0.5**2 / (6.0 * COEFFICIENT))
    both = estimate({"flow.boundaries": [DRAIN, {**DRAIN, "name": "top", "at": HEIGHT}]})
    way = 0.5 * HEIGHT - 0.125
    assert both.first_step == pytest.approx(0.01 * 0.848 * way**2 / COEFFICIENT)


def test_every_kind_of_drain_counts() -> None:
    top = {"name": "top", "condition": "drained"}
    surface = {**top, "type": "surface", "body": "soil", "start": [0.5, 3.0], "end": [0.0, 3.0]}
    whole = {**top, "type": "surface", "body": "soil"}
    geometry = {"type": "plane", "point": [0.0, 3.0], "normal": [0.0, -1.0]}
    implicit = {**top, "type": "implicit", "geometry": geometry}
    for each in (surface, implicit):
        both = estimate({"flow.boundaries": [DRAIN, each]})
        assert both.path == pytest.approx(0.5 * HEIGHT - 0.125)
    outline = estimate({"flow.boundaries": [whole]}).path
    assert outline is not None
    assert outline < 0.25
    flux = {**implicit, "condition": "flux", "flux": 1.0}
    assert estimate({"flow.boundaries": [flux]}).time is None
    part = {**DRAIN, "range": {"x": [3.0, 4.0]}}
    way = estimate({"flow.boundaries": [part]}).path
    assert way == pytest.approx((WAY**2 + (3.0 - 0.125) ** 2) ** 0.5)


def test_water_that_is_compressed_consolidates_slower() -> None:
    least, _ = estimate({"flow.bulk_modulus": 0.5 * 5e3 * 0.7 / (1.3 * 0.4)}).coefficients
    assert least == pytest.approx(0.5 * COEFFICIENT)


WARNINGS: Mapping[str, tuple[Mapping[str, Any], str, str]] = {
    "sealed": ({"flow.boundaries": []}, "flow.boundaries", "no water can leave"),
    "long step": ({"schedule": {"end": 80.0, "steps": 4}}, "schedule.steps", "not resolved"),
    "long step size": (
        {"schedule": {"end": 80.0, "step_size": 20.0}}, "schedule.step_size", "not resolved"),
    "short schedule": ({"schedule": {"end": 1e-3, "steps": 4}}, "schedule.end", "undrained"),
    "conductivity in other units": (
        {"materials.clay.hydraulic_conductivity": 1e-9, "schedule": {"end": 1e5, "steps": 4}},
        "materials.clay.hydraulic_conductivity", "check the unit"),
    "conductivity of nothing": (
        {"materials.clay.hydraulic_conductivity": 1e6, "schedule": {"end": 1e-8, "steps": 4}},
        "materials.clay.hydraulic_conductivity", "check the unit"),
    "conductivity of nothing along the layers": (
        {"materials.clay.hydraulic_conductivity": 1e3, "schedule": {"end": 2e-5, "steps": 40},
         "materials.clay.conductivity_ratios": [1e4, 1.0]},
        "materials.clay.hydraulic_conductivity", "check the unit"),
    "unit weight of the water": ({"flow.unit_weight": 1e3}, "flow.unit_weight", "9.81"),
    "plane without soil": (
        {"flow.boundaries": [DRAIN, {**DRAIN, "name": "far", "at": 9.0}]},
        "flow.boundaries[1].at", "correct its position"),
    "range without soil": (
        {"flow.boundaries": [DRAIN, {**DRAIN, "name": "far", "range": {"x": [3.0, 4.0]}}]},
        "flow.boundaries[1].at", "its range"),
    "rows after the end": (
        {"flow.boundaries": [{**DRAIN, "condition": "pressure", "excess_pressure": 1.0,
                              "factor": [[0, 0], [80, 1]]}]},
        "flow.boundaries[0].factor", "schedule.end"),
    "too much water": (
        {**UNDER_WATER, "materials.clay": {**CLAY, "density": 1.2, "saturated_density": 1.8}},
        "materials.clay.saturated_density", "pores hold 0.5 at most"),
    "light grains": (
        {**UNDER_WATER, "materials.clay": {**CLAY, "density": 1.3, "saturated_density": 1.4}},
        "materials.clay.saturated_density", "or correct the porosity"),
    "above the water": (
        {**UNDER_WATER, "water": {"level": 2.0, "unit_weight": 10.0}},
        "materials.clay.hydraulic_conductivity", "above the level"),
    "contact pair": (
        {"bodies": [{**ENTRIES["bodies"][0], "name": name, "shape": {
            "type": "box", "lower": [0.0, low], "upper": [0.5, low + 1.5]}}
            for name, low in (("low", 0.0), ("soil", 1.5))],
         "contact_pairs": [{"name": "joint", "bodies": ["low", "soil"], "contact": {
             "normal": "bilateral", "tangential": "bonded"}}]},
        "contact_pairs[0]", "lets no water pass"),
    "level that falls": (
        {**UNDER_WATER, "water": {"level": 2.0, "initial_level": 3.0, "unit_weight": 10.0}},
        "materials.clay.hydraulic_conductivity", "above the level"),
}  # fmt: skip


@pytest.mark.parametrize("name", WARNINGS)
def test_what_is_probably_not_meant_is_told(name: str) -> None:
    changes, key, text = WARNINGS[name]
    schedule = {} if "schedule" in changes else {"schedule": {"end": 4.0, "steps": 40}}
    found = [each for each in warned({**changes, **schedule}) if "first step is" not in each
             or "step" in name]  # fmt: skip
    assert [each.partition(":")[0].partition(" = ")[0] for each in found] == [key]
    assert text in found[0]


def test_unknown_labels_are_not_judged() -> None:
    units = {**KILO, "length": "rod"}
    changes = {"materials.clay.hydraulic_conductivity": 1e-9, "units": units,
               "schedule": {"end": 1e7, "steps": 40}}  # fmt: skip
    assert warned(changes) == []


def test_peat_is_lighter() -> None:
    peat = {**CLAY, "porosity": 0.9, "density": 0.2, "saturated_density": 1.05}
    assert warned({**UNDER_WATER, "materials.clay": peat}) == []


def test_stages_are_named() -> None:
    stages = [
        {"name": "loading", "schedule": {"end": 100.0, "steps": 1}, "flow": False},
        {"name": "rest", "schedule": {"end": 100.0, "steps": 1}},
    ]
    found = warned({"schedule": None, "stages": stages})
    assert len(found) == 1
    assert found[0].startswith("stages[1].schedule.steps: in the stage 'rest'")
    texts = [*consolidation_texts(Model.from_dict(column(schedule=None, stages=stages)))]
    assert len(texts) == 1
    assert texts[0].startswith("rest: c_v 0.673 m^2/day")


def test_a_stage_has_a_line_where_the_pressure_is_given() -> None:
    stages = [
        {"name": "one", "schedule": {"end": 1.0, "steps": 5}},
        {"name": "two", "schedule": {"end": 1.0, "steps": 5}, "grid": {"cell_size": 0.25}},
        {"name": "three", "schedule": {"end": 1.0, "steps": 5}, "grid": {"cell_size": 0.3}},
    ]
    changes = {"schedule": None, "stages": stages, "flow.boundaries.0.at": 0.5}
    found = [text for text in warned(changes) if "flow" in text]
    assert len(found) == 1
    assert found[0].startswith("flow.boundaries[0].at = 0.5: in the stage 'three': the grid of")


def test_check_prints_flow_and_time() -> None:
    declared = Model.from_dict(column({**UNDER_WATER, "loads": [GRAVITY]}))
    setup, _ = setup_figures(declared)
    assert isinstance(setup, Setup)
    screen = Console(file=io.StringIO(), width=400)
    texts = [*consolidation_texts(declared)]
    print_summary(declared, setup, memory_of(declared), None, screen, consolidation=texts)
    printed = screen.file.getvalue()  # type: ignore[attr-defined]
    assert "drain: drained at y = 0" in printed
    assert "hydraulic conductivity 0.001 m/day" in printed
    assert "90 % after about 10.4 day" in printed


def test_water_that_moves_freely_in_vibrations() -> None:
    moving = {
        "analysis.inertia": {"scheme": "newmark"}, "materials.clay.density": 2.0,
        "flow.density": 1.0, "units.time": "s", "schedule": {"end": 1.0, "steps": 100},
    }  # fmt: skip
    slow = {**moving, "materials.clay.hydraulic_conductivity": 1e-4}
    assert not [each for each in warned(slow) if "moves freely" in each]
    fast = {**moving, "materials.clay.hydraulic_conductivity": 0.05}
    directed = {**slow, "materials.clay.conductivity_ratios": [500.0, 1.0]}
    for changes in (fast, directed):
        (found,) = [each for each in warned(changes) if "moves freely" in each]
        assert "period of 0.1 s" in found
