# SPDX-License-Identifier: BSD-3-Clause
"""Flowing water with laws, stages, contact and starting states: it converges to what it should."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from clay_columns import (
    CLAY,
    ENTRIES,
    FREE_BLOCK,
    LOAD,
    UNDER_WATER,
    column,
    computed,
    pressures,
)

from tilth import BadInput, Model, StrengthReduction
from tilth.analysis.safety import strength_reduction
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.errors import StepFailed
from tilth.mpm.pore_water import CONDUCTIVITY, POROSITY, STORED

ELASTIC = {key: CLAY[key] for key in ("model", "young_modulus", "poisson_ratio")}
UNDRAINED = {**ELASTIC, "pore_fluid_bulk_modulus": 1e6}
PRESSED = {
    **ENTRIES["flow"]["boundaries"][0], "condition": "pressure", "excess_pressure": 1e4,
}  # fmt: skip
SHUT = {"name": "loading", "schedule": {"end": 1.0, "steps": 1}, "flow": False}
OPEN = {"name": "consolidation", "schedule": {"end": 8.0, "steps": 4}}
LONG = {"name": "consolidation", "schedule": {"end": 800.0, "steps": 2}}


def staged(*stages: Mapping[str, Any], **changes: Any) -> StagedAnalysis:
    """The column after some stages."""
    return computed(column({"schedule": None, "stages": list(stages), **changes}))


def total(analysis: StagedAnalysis) -> Any:
    """Vertical total stress of the points, compression positive."""
    return pressures(analysis) - analysis.state.points.stress[:, 1]


@pytest.fixture(scope="module")
def reference() -> Any:
    """Pressures of the elastic column."""
    found = pressures(computed(column()))
    assert 0.0 < found.min() < 0.1 * LOAD
    assert 0.3 * LOAD < found.max() < 0.4 * LOAD
    return found


YIELDING: Mapping[str, Mapping[str, Any]] = {
    "mohr_coulomb": {"cohesion": 50.0, "friction_angle": 20.0, "dilation_angle": 0.0},
    "von_mises": {"yield_stress": 50.0, "hardening_modulus": 0.0},
    "tresca": {"undrained_shear_strength": 50.0},
    "drucker_prager": {
        "cohesion": 50.0, "friction_angle": 20.0, "dilation_angle": 0.0, "fit": "plane_strain"
    },
}  # fmt: skip


@pytest.mark.parametrize("law", YIELDING)
def test_laws_that_do_not_yield_consolidate_as_the_elastic_one(law: str, reference: Any) -> None:
    material = {**CLAY, **YIELDING[law], "model": law}
    found = pressures(computed(column({"materials.clay": material})))
    np.testing.assert_allclose(found, reference, rtol=1e-6)


def test_cam_clay_consolidates() -> None:
    material = {
        "model": "modified_cam_clay", "porosity": 0.5, "hydraulic_conductivity": 1e-3,
        "compression_index": 0.1, "swelling_index": 0.02, "poisson_ratio": 0.3,
        "critical_state_slope": 0.8, "overconsolidation_ratio": 1.2,
    }  # fmt: skip
    stress = [{"type": "given", "body": "soil", "stress": [-40.0, -40.0, -40.0, 0.0]}]
    changes = {
        "materials.clay": material, "initial.stress": stress,
        "loads.0.pressure": 40.0, "loads.0.factor": [[0, 1], [1, 1.25]],
    }  # fmt: skip
    found = pressures(staged(SHUT, **changes))
    np.testing.assert_allclose(found, LOAD, rtol=0.02)
    analysis = staged(SHUT, LONG, **changes)
    assert np.abs(pressures(analysis)).max() < 1e-3 * LOAD
    assert (analysis.state.points.displacement[:, 1] < 0.0).all()


def test_all_kinds_and_bases_converge(reference: Any) -> None:
    for changes in (
        {"analysis.kind": "axisymmetric"}, {"bodies.0.basis": "linear"},
        {"bodies.0.basis": "cpdi2"}, {"bodies.0.anti_locking": "f_bar"},
    ):  # fmt: skip
        found = pressures(computed(column(changes)))
        np.testing.assert_allclose(found, reference, rtol=0.05, atol=0.01 * LOAD)


def test_sealed_soil_keeps_the_load() -> None:
    analysis = computed(column({"flow.boundaries": []}))
    np.testing.assert_allclose(pressures(analysis), LOAD, rtol=1e-3)


def test_a_stage_without_flow_is_undrained(reference: Any) -> None:
    """The water carries the load, and flows in the stage after it."""
    analysis = staged(SHUT)
    np.testing.assert_allclose(pressures(analysis), LOAD, rtol=1e-3)
    found = pressures(staged(SHUT, OPEN))
    np.testing.assert_allclose(found, reference, rtol=1e-3)


def test_drains_come_and_go(reference: Any) -> None:
    later = staged(SHUT, {**OPEN, "activate": ["drain"]})
    np.testing.assert_allclose(pressures(later), reference, rtol=1e-3)
    sealed = staged(OPEN, {**LONG, "name": "sealed", "deactivate": ["drain"]})
    found = pressures(sealed)
    assert found.max() - found.min() < 1e-3 * LOAD, "the pressure is the same everywhere"
    assert found.mean() == pytest.approx(reference.mean(), rel=0.02)


def test_a_given_pressure_lifts_the_soil() -> None:
    drain = {**ENTRIES["flow"]["boundaries"][0], "condition": "pressure", "excess_pressure": 3.0}
    rises = {**LONG, "factors": {"drain": [[0, 0], [800, 1]]}}
    changes: Any = {"loads": [], "flow.boundaries.0": drain}
    analysis = staged(rises, {**LONG, "name": "held"}, **changes)
    np.testing.assert_allclose(pressures(analysis), 3.0, rtol=1e-3)
    np.testing.assert_allclose(total(analysis), 0.0, atol=1e-3)
    assert (analysis.state.points.displacement[:, 1] > 0.0).all()
    assert not [text for text in analysis.services.warnings.texts if "no load" in text]


@pytest.mark.parametrize("start", ["gravity", "k0"])
def test_soil_under_water_begins_in_equilibrium(start: str) -> None:
    """Its weight and the water at rest cause no excess pressure, the load does."""
    stress = {"type": start, "body": "soil", **({"K0": 3.0 / 7.0} if start == "k0" else {})}
    still = {**UNDER_WATER, "initial.stress": [stress], "loads": UNDER_WATER["loads"][:1]}
    assert np.abs(pressures(staged(SHUT, OPEN, **still))).max() < 0.02 * LOAD
    found = pressures(staged(SHUT, **{**UNDER_WATER, "initial.stress": [stress]}))
    np.testing.assert_allclose(found, LOAD, rtol=0.02)


@pytest.mark.parametrize("tangential", ["smooth", "bonded", "adhesion"])
def test_rigid_plates_press_on_the_water_first(tangential: str) -> None:
    """A plate goes down by one per cent of the height, and its force falls to the drained one."""
    adhesion = {"adhesion_factor": 0.5} if tangential == "adhesion" else {}
    material = {**CLAY, **({"model": "tresca", "undrained_shear_strength": 500.0} if adhesion
                           else {})}  # fmt: skip
    normal = "bilateral" if tangential == "bonded" else "unilateral"
    plate = {
        "name": "plate", "centre": [0.25, 3.25], "rotation": 0.0,
        "geometry": {"type": "box", "lower": [-0.1, 3.0], "upper": [0.6, 3.5], "soil": "outside"},
        "displacement": {"x": 0.0, "y": [[0.0, 0.0], [1.0, -0.03], [900.0, -0.03]]},
        "contact": {"normal": normal, "tangential": tangential, **adhesion},
    }  # fmt: skip
    entries = {"loads": [], "rigid_bodies": [plate], "materials.clay": material}
    fast = computed(column({**entries, "schedule": {"end": 1.0, "steps": 2}}))
    slow = computed(column({**entries, "schedule": {"end": 801.0, "step_size": 200.0}}))
    assert pressures(fast).max() > 50.0
    assert np.abs(pressures(slow)).max() < 0.1
    drained = 0.01 * 5e3 * 0.7 / (1.3 * 0.4)
    assert total(slow).mean() == pytest.approx(drained, rel=0.03)


def test_exchanged_materials_have_their_own_pores() -> None:
    """Conductivity and porosity are those of the new material, the excess pressure stays."""
    other = {**CLAY, "porosity": 0.3, "hydraulic_conductivity": 1e-2}
    change = {**SHUT, "name": "change", "materials": {"clay": "other"}}
    before = staged(SHUT)
    analysis = staged(SHUT, change, **{"materials.other": other})
    np.testing.assert_allclose(pressures(analysis), LOAD, rtol=1e-3)
    water = analysis.state.points.water
    np.testing.assert_allclose(water[:, POROSITY], 0.3)
    np.testing.assert_allclose(water[:, CONDUCTIVITY], 1e-3)
    stored = before.state.points.water[:, STORED] - 0.2
    np.testing.assert_allclose(water[:, STORED], stored, rtol=1e-6)


def test_undrained_soil_begins_to_consolidate() -> None:
    """The pressure of its pore fluid is that of the water that flows from then on, and back."""
    plain: Mapping[str, Any] = {"materials.stiff": UNDRAINED}
    quick = {"name": "flows", "schedule": {"end": 1e-3, "steps": 1}, "materials": {"stiff": "clay"}}
    analysis = staged(SHUT, quick, **plain, **{"bodies.0.material": "stiff"})
    found = pressures(analysis)
    assert found.max() == pytest.approx(LOAD, rel=0.01)
    assert total(analysis).mean() == pytest.approx(LOAD, rel=1e-3)
    back = staged(SHUT, {**SHUT, "name": "back", "materials": {"clay": "stiff"}}, **plain)
    assert not back.state.points.water.any()
    excess = back.state.points.state_variable("excess_pore_pressure")
    np.testing.assert_allclose(excess, LOAD, rtol=0.01)
    np.testing.assert_allclose(back.state.points.stress[:, 1], -LOAD, rtol=1e-3)


def test_water_that_flows_no_more_leaves_its_load_to_the_soil() -> None:
    analysis = staged(
        SHUT, {**SHUT, "name": "dry", "materials": {"clay": "dry"}}, **{"materials.dry": ELASTIC}
    )
    assert not analysis.state.points.water.any()
    np.testing.assert_allclose(analysis.state.points.stress[:, 1], -LOAD, rtol=5e-3)


def test_affine_motions_need_water_that_leaves_or_is_compressed() -> None:
    motion = {"name": "all", "type": "affine", "path": "linear",
              "deformation_gradient": [[1.0, 0.0], [0.0, 0.99]]}  # fmt: skip
    entries = {"boundaries": [motion], "loads": []}
    assert pressures(computed(column(entries))).max() > LOAD
    sealed = {**entries, "flow.boundaries": []}
    with pytest.raises(BadInput) as error:
        Model.from_dict(column(sealed))
    assert error.value.key == "flow.bulk_modulus"
    found = pressures(computed(column({**sealed, "flow.bulk_modulus": 1e3})))
    expected = -1e3 * np.log((0.5 - 0.01) / 0.5)
    np.testing.assert_allclose(found, expected, rtol=1e-4)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"materials.clay.porosity": 0.005}, "the pores of a material point have closed"),
        (
            {"flow.bulk_modulus": 1.0, "flow.boundaries.0": PRESSED},
            "the pore pressure of a material point is a multiple of flow.bulk_modulus",
        ),
    ],
)
def test_steps_end_where_there_is_no_water(changes: Mapping[str, Any], reason: str) -> None:
    """A plate goes down by more than the pores, or the water has next to no stiffness."""
    simulation = Simulation(Model.from_dict(column({**changes, "loads.0.pressure": 1e3})))
    with pytest.raises(StepFailed, match=reason):
        simulation.advance(0.0, 800.0)


def fails_at(pressure: float, held: float) -> float:
    """Factor of safety of a block under a pressure, free at one side, its pore pressure held.

    The total stress is the pressure and 0: q = (q - 2 p) sin(phi) + 2 c cos(phi).
    """
    cohesion, tangent = 14.0, np.tan(np.radians(20.0))
    low, high = 0.1, 10.0
    while high - low > 1e-6:
        factor = 0.5 * (low + high)
        angle = np.arctan(tangent / factor)
        bears = (pressure - 2.0 * held) * np.sin(angle) + 2.0 * cohesion / factor * np.cos(angle)
        low, high = (factor, high) if bears > pressure else (low, factor)
    return low


def factor_of(*stages: Mapping[str, Any]) -> tuple[float, float]:
    """Factors of safety between which that of the block is after some stages."""
    analysis = staged(*stages, **FREE_BLOCK)
    found = strength_reduction(
        analysis.simulation, analysis.clock.time, StrengthReduction(tolerance=0.02)
    )
    return found.factor, found.above


@pytest.mark.slow
def test_strength_reduction_holds_the_pore_pressure() -> None:
    """Undrained, in the middle of the consolidation, and drained."""
    undrained, drained = fails_at(20.0, 10.0), fails_at(20.0, 0.0)
    loading = {**SHUT, "schedule": {"end": 1.0, "steps": 4}, "factors": {"fill": [[0, 0], [1, 1]]}}
    low, high = factor_of(loading)
    assert low - 0.02 < undrained < high + 0.02
    low, high = factor_of(loading, LONG)
    assert low - 0.02 < drained < high + 0.02
    low, high = factor_of(loading, {**OPEN, "schedule": {"end": 0.3, "steps": 4}})
    assert undrained + 0.02 < low
    assert high < drained
