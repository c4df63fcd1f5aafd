# SPDX-License-Identifier: BSD-3-Clause
"""Wrong entries of flowing water are refused, each with its key, its value and a remedy."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from clay_columns import CLAY, ENTRIES, GRAVITY, column

from tilth import BadInput, Model
from tilth.analysis.differences import first_difference, tables_of, without_tables
from tilth.case import load_case, load_element_case
from tilth.model.study import Study
from tilth.studies.samples import make_samples

DRAIN = "flow.boundaries.0"
KEY = "flow.boundaries[0]"
PRESSURE = {"name": "drain", "type": "plane", "axis": "y", "at": 0.0, "condition": "pressure"}
ANYWHERE = {"name": "drain", "type": "implicit", "condition": "drained"}
ON_SURFACE = {"name": "drain", "type": "surface", "condition": "drained", "body": "soil"}
CASE = {"format": 1, **ENTRIES}
STAGE = {"name": "fill", "schedule": {"end": 1.0, "steps": 1}}
WET = {"materials.clay": {**CLAY, "density": 1.3, "saturated_density": 1.8},
       "loads": [GRAVITY], "water": {"level": 3.0, "unit_weight": 10.0}}  # fmt: skip


def problems(changes: Mapping[str, Any]) -> dict[str, tuple[str, str, Any]]:
    """Problem, remedy and value of each wrong entry, by its key; nothing for a right model."""
    try:
        Model.from_dict(column(changes))
    except BadInput as error:
        return {str(e.key): (e.problem, e.remedy or "", e.value) for e in error.problems}
    return {}


WRONG: Mapping[str, tuple[Mapping[str, Any], str, str, str]] = {
    "no unit weight": ({"flow.unit_weight": None}, "flow.unit_weight", "missing", "give"),
    "unit weight": ({"flow.unit_weight": -1.0}, "flow.unit_weight", "greater than zero", ""),
    "bulk modulus": ({"flow.bulk_modulus": 0.0}, "flow.bulk_modulus", "greater than zero", ""),
    "scheme": ({"flow.scheme": "bdf3"}, "flow.scheme", "not one of", "bdf2"),
    "largest error": ({"flow.largest_error": 0.0}, "flow.largest_error", "greater than zero", ""),
    "unknown key": ({"flow.viscosity": 1.0}, "flow.viscosity", "unknown key", "known keys"),
    "no name": ({f"{DRAIN}.name": None}, f"{KEY}.name", "missing", "give"),
    "name of another": ({f"{DRAIN}.name": "left"}, f"{KEY}.name", "already the name", "different"),
    "type": ({f"{DRAIN}.type": "planes"}, f"{KEY}.type", "not one of", 'mean "plane"'),
    "condition": ({f"{DRAIN}.condition": "open"}, f"{KEY}.condition", "not one of", "drained"),
    "no flux": ({f"{DRAIN}.condition": "flux"}, f"{KEY}.flux", "missing", "give"),
    "no pressure": ({DRAIN: PRESSURE}, f"{KEY}.excess_pressure", "missing", "give"),
    "pressure of a drain": (
        {f"{DRAIN}.excess_pressure": 1.0}, f"{KEY}.excess_pressure", "no meaning", "pressure"),
    "flux of a drain": (
        {f"{DRAIN}.flux": 1.0}, f"{KEY}.flux", "no meaning", 'condition = "flux"'),
    "no head": (
        {**WET, DRAIN: {**PRESSURE, "condition": "head"}}, f"{KEY}.head", "missing", "give"),
    "head without water": (
        {DRAIN: {**PRESSURE, "condition": "head", "head": 4.0}},
        f"{KEY}.condition", "needs the water at rest", "add [water]"),
    "head of a drain": (
        {f"{DRAIN}.head": 1.0}, f"{KEY}.head", "no meaning", "head"),
    "factor of a drain": (
        {f"{DRAIN}.factor": [[0, 1], [1, 2]]}, f"{KEY}.factor", "nothing to scale", "leave it out"),
    "factor": (
        {DRAIN: {**PRESSURE, "excess_pressure": 1.0, "factor": [[1, 0], [2, 1]]}},
        f"{KEY}.factor", "first time", "rows"),
    "axis": ({f"{DRAIN}.axis": "z"}, f"{KEY}.axis", "names the z direction", "x, y"),
    "off the lines": ({f"{DRAIN}.at": 0.1}, f"{KEY}.at", "not on a grid line", "y = 0 and 0.5"),
    "far away": ({f"{DRAIN}.at": 1e7}, f"{KEY}.at", "cells from the origin", "larger cells"),
    "own range": ({f"{DRAIN}.range": {"y": [0, 1]}}, f"{KEY}.range.y", "normal", "leave it out"),
    "range": ({f"{DRAIN}.range": {"x": [1, 0]}}, f"{KEY}.range.x", "increasing", "such as"),
    "no geometry": ({DRAIN: ANYWHERE}, f"{KEY}.geometry", "missing", "give"),
    "geometry in space": (
        {DRAIN: {**ANYWHERE, "geometry": {
            "type": "sphere", "centre": [0, 0, 0], "radius": 1.0, "soil": "outside"}}},
        f"{KEY}.geometry.type", "does not exist", '"circle"'),
    "small geometry": (
        {DRAIN: {**ANYWHERE, "geometry": {
            "type": "circle", "centre": [0, 0], "radius": 1e-9, "soil": "outside"}}},
        f"{KEY}.geometry.radius", "smaller than", "larger size"),
    "unknown body": ({DRAIN: {**ON_SURFACE, "body": "sol"}}, f"{KEY}.body", "no body", "`soil`"),
    "body without surface": (
        {DRAIN: ON_SURFACE, "bodies.0.surface": None, "loads": []},
        f"{KEY}.body", "no tracked surface", "surface = {}"),
    "part in the plane": ({DRAIN: {**ON_SURFACE, "part": "z+"}}, f"{KEY}.part", "in 3D", "start"),
    "start alone": ({DRAIN: {**ON_SURFACE, "start": [0, 0]}}, f"{KEY}.end", "missing", "both"),
    "no porosity": (
        {"materials.clay.porosity": None}, "materials.clay.porosity", "missing", "such as"),
    "porosity": ({"materials.clay.porosity": 1.0}, "materials.clay.porosity", "between", ""),
    "pores without flow": (
        {"materials.clay.hydraulic_conductivity": None},
        "materials.clay.porosity", "no meaning without", "leave this out"),
    "conductivity": (
        {"materials.clay.hydraulic_conductivity": 0.0},
        "materials.clay.hydraulic_conductivity", "greater than zero", ""),
    "permeability": (
        {"materials.clay.permeability": "kozeny"},
        "materials.clay.permeability", "not one of", "kozeny_carman"),
    "ratios without conductivity": (
        {"materials.clay.hydraulic_conductivity": None, "materials.clay.porosity": None,
         "materials.clay.conductivity_ratios": [3.0, 1.0]},
        "materials.clay.conductivity_ratios", "no meaning without", "leave this out"),
    "ratio": (
        {"materials.clay.conductivity_ratios": [3.0, 0.0]},
        "materials.clay.conductivity_ratios", "principal value 0", "number > 0 per axis"),
    "ratios of no tensor": (
        {"materials.clay.conductivity_ratios": [[3.0, 1.0], [0.0, 1.0]]},
        "materials.clay.conductivity_ratios", "not symmetric", "symmetric matrix"),
    "ratios of no matrix": (
        {"materials.clay.conductivity_ratios": [[3.0, 1.0]]},
        "materials.clay.conductivity_ratios", "no square matrix", "symmetric matrix"),
    "indefinite ratios": (
        {"materials.clay.conductivity_ratios": [[1.0, 2.0], [2.0, 1.0]]},
        "materials.clay.conductivity_ratios", "principal value -1", "number > 0 per axis"),
    "far apart ratios": (
        {"materials.clay.conductivity_ratios": [1e6, 1.0]},
        "materials.clay.conductivity_ratios", "differ more than", "number > 0 per axis"),
    "ratios in space": (
        {"materials.clay.conductivity_ratios": [3.0, 3.0, 1.0]},
        "materials.clay.conductivity_ratios", "for 3 directions", "2 numbers"),
    "one ratio": (
        {"materials.clay.conductivity_ratios": 3.0},
        "materials.clay.conductivity_ratios", "list of numbers", "[3.0, 1.0]"),
    "no index": (
        {"materials.clay.permeability": "taylor"},
        "materials.clay.permeability_change_index", '"taylor" needs it', "give the number"),
    "no exponent": (
        {"materials.clay.permeability": "power"},
        "materials.clay.permeability_exponent", '"power" needs it', "give the number"),
    "index": (
        {"materials.clay.permeability": "taylor",
         "materials.clay.permeability_change_index": 0.0},
        "materials.clay.permeability_change_index", "greater than zero", ""),
    "exponent": (
        {"materials.clay.permeability": "power", "materials.clay.permeability_exponent": -1.0},
        "materials.clay.permeability_exponent", "greater than zero", ""),
    "index of a constant": (
        {"materials.clay.permeability_change_index": 0.5},
        "materials.clay.permeability_change_index", 'permeability = "constant"', '"taylor"'),
    "exponent of another law": (
        {"materials.clay.permeability": "kozeny_carman",
         "materials.clay.permeability_exponent": 4.0},
        "materials.clay.permeability_exponent", 'permeability = "kozeny_carman"', '"power"'),
    "index of soil without flow": (
        {"materials.clay.hydraulic_conductivity": None, "materials.clay.porosity": None,
         "materials.clay.permeability_change_index": 0.5},
        "materials.clay.permeability_change_index", "no meaning without", "leave this out"),
    "watertight": (
        {"materials.clay.watertight": True},
        "materials.clay.hydraulic_conductivity", "watertight", "one of the two"),
    "undrained law": (
        {"materials.clay.pore_fluid_bulk_modulus": 1e6},
        "materials.clay.pore_fluid_bulk_modulus", "cannot flow", "flow.bulk_modulus"),
    "no flow": (
        {"flow": None}, "materials.clay.hydraulic_conductivity", "no meaning", "add [flow]"),
    "nothing flows": (
        {"materials.clay.porosity": None, "materials.clay.hydraulic_conductivity": None},
        "flow", "through no material", "hydraulic_conductivity"),
    "no unit of time": ({"units.time": None}, "units.time", "missing", '"day"'),
    "no end": ({"schedule": {"steps": 4}}, "schedule.end", "missing", "time until"),
    "weight without water": (
        {**WET, "water": None}, "water", "missing", "level"),
    "another water": (
        {**WET, "flow.unit_weight": 9.81}, "flow.unit_weight", "water.unit_weight", "same"),
    "inertia": (
        {"analysis.inertia": {"scheme": "newmark"}, "materials.clay.density": 2.0},
        "flow.density", "has inertia", "density of the water"),
    "density without inertia": (
        {"flow.density": 1.0}, "flow.density", "without inertia", "leave it out"),
    "relaxation": (
        {"analysis.beyond_limit": "relax", "materials.clay.density": 2.0},
        "analysis.beyond_limit", "together with [flow]", "one of the two"),
    "flow in a stage": (
        {"flow": None, "materials.clay.porosity": None, "schedule": None,
         "materials.clay.hydraulic_conductivity": None, "stages": [{**STAGE, "flow": False}]},
        "stages[0].flow", "without [flow]", "leave it out"),
    "unknown name in a stage": (
        {"schedule": None, "stages": [{**STAGE, "deactivate": ["drian"]}]},
        "stages[0].deactivate", "no body, boundary, rigid body, flow boundary", "drain"),
    "factors of a drain": (
        {"schedule": None, "stages": [{**STAGE, "factors": {"drain": [[0, 1], [1, 2]]}}]},
        "stages[0].factors", "is drained", "leave it out"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_one_message_names_key_and_remedy(name: str) -> None:
    changes, key, problem, remedy = WRONG[name]
    if name.startswith("weight"):
        changes = {k: v for k, v in changes.items() if k != "water"}
    found = problems(changes)
    assert list(found) == [key]
    assert problem in found[key][0]
    assert remedy in found[key][1]


def test_right_entries_are_accepted() -> None:
    assert problems({}) == {}
    assert problems(WET) == {}
    assert (
        problems({"flow.bulk_modulus": 2e6, "materials.clay.permeability": "kozeny_carman"}) == {}
    )


def test_lines_that_move_have_no_pressure() -> None:
    """Where the grid follows a boundary along the axis of the drain."""
    moving = {
        "name": "cap", "type": "implicit",
        "contact": {"normal": "bilateral", "tangential": "smooth"},
        "geometry": {"type": "plane", "point": [0.0, 3.0], "normal": [0.0, -1.0]},
        "displacement": {"y": -0.1},
    }  # fmt: skip
    follow = {"boundary": "cap", "axes": ["y"], "place": [0.0, 3.0]}
    boundaries = [*ENTRIES["boundaries"][:2], moving]
    found = problems({"grid.follow": follow, "boundaries": boundaries, "loads": []})
    assert "lines move away" in found[KEY][0]
    assert "implicit" in found[KEY][1]


PLATE = {
    "name": "plate", "centre": [0.25, 3.25], "rotation": 0.0, "displacement": {"x": 0.0, "y": -0.1},
    "geometry": {"type": "box", "lower": [-0.1, 3.0], "upper": [0.6, 3.5], "soil": "outside"},
}  # fmt: skip
ROUGH = {"normal": "unilateral", "tangential": "friction", "friction": 0.3}


def test_friction_between_two_bodies_is_refused() -> None:
    """Each of them has its own pressure; that of a rigid body's contact is the soil's."""
    bodies = [{**ENTRIES["bodies"][0], "name": name} for name in ("soil", "other")]
    pair = {"name": "pair", "bodies": ["soil", "other"], "contact": ROUGH}
    found = problems({"bodies": bodies, "contact_pairs": [pair]})
    assert list(found) == ["contact_pairs[0].contact.tangential"]
    assert "[flow]" in found["contact_pairs[0].contact.tangential"][0]
    assert '"smooth"' in found["contact_pairs[0].contact.tangential"][1]
    assert problems({"rigid_bodies": [{**PLATE, "contact": ROUGH}]}) == {}


def test_studies_vary_what_belongs_to_the_flow() -> None:
    """By the names of flow boundaries, too; every sample is validated."""
    case = column({DRAIN: {**PRESSURE, "excess_pressure": 1.0}})
    outcomes = [{"type": "history", "name": "s", "column": "settlement"}]
    for key in ("materials.clay.hydraulic_conductivity", "flow.unit_weight",
                "flow.boundaries.drain.excess_pressure"):  # fmt: skip
        vary = [{"key": key, "values": [1.0, 2.0]}]
        study = Study.from_dict({"format": 1, "vary": vary, "outcomes": outcomes})
        assert len(make_samples(study, case)) == 2
    wrong = [{"key": "materials.clay.porosity", "values": [0.5, 1.5]}]
    with pytest.raises(BadInput, match="porosity"):
        make_samples(Study.from_dict({"format": 1, "vary": wrong, "outcomes": outcomes}), case)


def test_files_of_geometries_are_relative_to_the_case(tmp_path: Path) -> None:
    geometry = {"type": "stl", "file": "drain.stl", "soil": "outside"}
    case = {
        **CASE,
        "flow": {"unit_weight": 10.0, "boundaries": [{**ANYWHERE, "geometry": geometry}]},
    }
    file = tmp_path / "case.toml"
    file.write_text(tomli_w.dumps(case))
    with pytest.raises(BadInput) as error:
        load_case(file)
    assert error.value.key == f"{KEY}.geometry.file"
    assert str(tmp_path / "drain.stl") in str(error.value)


def test_runs_go_on_with_the_same_flow_only() -> None:
    """But for the rows of tables, which are compared up to the time that is reached."""
    first = Model.from_dict(column({DRAIN: {**PRESSURE, "excess_pressure": 1.0}}))
    other = Model.from_dict(column({DRAIN: {**PRESSURE, "excess_pressure": 2.0}}))
    plain = [without_tables(each.flow) for each in (first, other)]
    assert first_difference(*plain, "flow") == "flow.boundaries[0].excess_pressure"
    rows = [[0, 1], [5, 1], [8, 2]]
    scaled = Model.from_dict(column({DRAIN: {**PRESSURE, "excess_pressure": 1.0, "factor": rows}}))
    assert first_difference(without_tables(first.flow), without_tables(scaled.flow)) is None
    assert tables_of(scaled)[f"{KEY}.factor"].factor(8.0) == 2.0
    assert tables_of(first)[f"{KEY}.factor"].factor(8.0) == 1.0


def test_element_tests_take_the_materials_of_an_analysis(tmp_path: Path) -> None:
    """A specimen has no water that flows: what is declared of it plays no part."""
    test = {"name": "squeezed", "type": "oedometer", "material": "clay", "vertical_stress": [10.0],
            "start": {"isotropic": 1.0}, "steps": 4}  # fmt: skip
    file = tmp_path / "tests.toml"
    file.write_text(tomli_w.dumps({"format": 1, "materials": {"clay": CLAY}, "tests": [test]}))
    assert load_element_case(file).materials["clay"].conducts_water
