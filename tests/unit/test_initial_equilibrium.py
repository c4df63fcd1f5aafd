# SPDX-License-Identifier: BSD-3-Clause
"""Equilibrium of the starting state: nothing moves, the residual vanishes, the law is obeyed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_problems import (
    BASES,
    KINDS,
    block_entries,
    by_number,
    dimension,
    material_entries,
    plane,
    rollers,
    weight,
)

from tilth import AnalysisFailed, BadInput, Model
from tilth.analysis.initial_equilibrium import InitialEquilibrium, find_initial_equilibrium
from tilth.analysis.simulation import Simulation

FACTOR = [[0.0, 1.0], [1.0, 1.0]]

WHERE = (
    "position", "displacement", "last_displacement", "last_gradient", "deformation_gradient",
    "assumed_jacobian", "half_length", "corner", "initial_volume",
)  # fmt: skip


def bench(kind: str, basis: str, law: str = "mohr_coulomb", **changed: Any) -> dict[str, Any]:
    """Two blocks of soil between smooth walls on a fixed base, the second half as high."""
    dim = dimension(kind)
    entries = block_entries(
        kind, basis, law, boundaries=rollers(kind, 4.0), loads=[weight(kind, 5.0)]
    )
    entries["boundaries"][dim - 1]["condition"] = "fixed"
    entries["materials"]["soil"] = material_entries(law, **changed)
    entries["loads"][0]["factor"] = FACTOR
    low, high = dict(entries["bodies"][0]), entries["bodies"][0]
    high["shape"] = {"type": "box", "lower": [0.0] * dim, "upper": [2.0] + [4.0] * (dim - 1)}
    low |= {"name": "low"}
    low["shape"] = {
        "type": "box",
        "lower": [2.0] + [0.0] * (dim - 1),
        "upper": [4.0] * (dim - 1) + [2.0],
    }
    entries["bodies"] = [high, low]
    entries["initial"] = {
        "stress": [{"type": "k0", "body": name, "K0": 0.6} for name in ("block", "low")]
    }
    return entries


def found(entries: dict[str, Any]) -> tuple[Simulation, InitialEquilibrium]:
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    return simulation, find_initial_equilibrium(simulation)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
def test_a_bench_is_in_equilibrium_where_it_is(kind: str, basis: str) -> None:
    entries = bench(kind, basis)
    before = by_number(Simulation(Model.from_dict(entries)).state.points)
    simulation, report = found(entries)
    after = by_number(simulation.state.points)
    assert report.residual_before > 1e-3
    assert report.residual_after < 1e-8
    for name in WHERE:
        assert before[name].tobytes() == after[name].tobytes(), name
    change = np.abs(after["stress"] - before["stress"]).max(axis=1)
    assert report.change == change.max() > 0.1
    np.testing.assert_array_equal(report.place, after["position"][change.argmax()])
    result = simulation.advance(0.0, 1.0)
    assert result.equilibrium.iterations == 0
    assert (
        np.abs(simulation.state.points.displacement).max() < 1e-15
    )  # cpdi2 has round-off of corners


@pytest.mark.parametrize("kind", KINDS)
def test_reactions_at_the_start_carry_the_weight(kind: str) -> None:
    simulation, report = found(bench(kind, "gimp"))
    up = dimension(kind) - 1
    total = 5.0 * simulation.state.points.mass.sum()
    assert report.result.resultant(f"low {'xyz'[up]}")[up] == pytest.approx(total, rel=1e-7)


@pytest.mark.parametrize("change", [{}, {"anti_locking": "f_bar"}])
@pytest.mark.parametrize(
    ("law", "changed"),
    [
        ("mohr_coulomb", {"cohesion": 3.6, "friction_angle": 13.0, "dilation_angle": 0.0}),
        ("undrained_mohr_coulomb", {"cohesion": 12.0, "pore_fluid_bulk_modulus": 5000.0}),
        ("von_mises", {"yield_stress": 15.2}),
        ("tresca", {"undrained_shear_strength": 7.6}),
    ],
)
def test_soil_that_yields(law: str, changed: dict[str, Any], change: dict[str, Any]) -> None:
    """The stress obeys the law: with the strength it cannot be outside the yield surface."""
    entries = bench("plane_strain", "gimp", law.removeprefix("undrained_"), **changed)
    for body in entries["bodies"]:
        body |= change
    simulation, report = found(entries)
    assert report.residual_after < 1e-8
    if not law.startswith("undrained"):
        assert (simulation.state.points.plastic[:, 0] > 0.0).any()
    result = simulation.advance(0.0, 1.0)
    assert result.equilibrium.iterations == 0


def test_stress_follows_from_the_elastic_strain() -> None:
    """Hencky's law: Kirchhoff, here Cauchy, stress is linear in the logarithmic elastic strain."""
    simulation, _ = found(bench("plane_strain", "gimp"))
    points, (modulus, nu) = simulation.state.points, (1000.0, 0.3)
    shear, lame = modulus / 2.6, modulus * nu / (1.3 * 0.4)
    strain = points.elastic_strain
    expected = 2.0 * shear * strain
    expected[:, :3] += lame * strain[:, :3].sum(axis=1)[:, None]
    np.testing.assert_allclose(points.stress, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", ["linear", "gimp"])
def test_gravity_loading_of_level_ground(kind: str, basis: str) -> None:
    """Elastic soil without lateral strain: nu / (1 - nu) of the weight acts sideways.

    The stress within a cell of a grid of linear shape functions is that at its centre.
    """
    entries = bench(kind, basis, "hencky_elastic")
    size = [4.0] * dimension(kind)
    entries["bodies"] = entries["bodies"][:1]
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [0.0] * len(size), "upper": size}
    entries["boundaries"][dimension(kind) - 1]["condition"] = "roller"
    entries["initial"]["stress"] = [{"type": "gravity", "body": "block", "steps": 3}]
    simulation, report = found(entries)
    points, up = simulation.state.points, dimension(kind) - 1
    weight_above = 10.0 * (3.5 - np.floor(points.position[:, up]))
    np.testing.assert_allclose(points.stress[:, up], -weight_above, rtol=1e-7)
    np.testing.assert_allclose(points.stress[:, 0], -0.3 / 0.7 * weight_above, rtol=1e-7)
    assert report.parts == 3
    assert not points.displacement.any()


def test_gravity_loading_of_weak_soil_in_parts_until_it_fails() -> None:
    """A vertical bank of cohesive soil: 2 high and 4 s_u / gamma = 3 stands, 1.2 does not."""
    for strength, stands in ((7.5, True), (3.0, False)):
        entries = bench("plane_strain", "gimp", "tresca", undrained_shear_strength=strength)
        entries["initial"]["stress"] = [
            {"type": "gravity", "body": name, "steps": 2} for name in ("block", "low")
        ]
        for body in entries["bodies"]:
            body["anti_locking"] = "f_bar"
        if stands:
            simulation, _ = found(entries)
            assert (simulation.state.points.plastic[:, 0] > 0.0).any()
            continue
        message = r"no equilibrium with the loads .* at time 0: .* at the point \d+ at \("
        with pytest.raises(AnalysisFailed, match=message):
            found(entries)


def test_plastic_strain_is_reset_on_request() -> None:
    changed = {"cohesion": 3.6, "friction_angle": 13.0, "dilation_angle": 0.0}
    entries = bench("plane_strain", "gimp", **changed)
    kept, _ = found(entries)
    assert kept.state.points.plastic[:, 0].max() > 0.0
    entries["initial"]["reset_plastic_strain"] = True
    reset, _ = found(entries)
    assert not reset.state.points.plastic.any()
    np.testing.assert_array_equal(reset.state.points.stress, kept.state.points.stress)


def test_hardened_soil_cannot_lose_its_plastic_strain() -> None:
    entries = bench("plane_strain", "gimp", "von_mises", yield_stress=15.2, hardening_modulus=200.0)
    found(entries)
    entries["initial"]["reset_plastic_strain"] = True
    with pytest.raises(BadInput, match=r"reset_plastic_strain.*outside the yield surface"):
        found(entries)


def test_implicit_boundaries_carry_the_soil_from_the_start() -> None:
    entries = bench("plane_strain", "gimp")
    entries["grid"]["origin"] = [0.0, -0.3]
    entries["boundaries"][1] = {
        "type": "implicit", "name": "base", "condition": "fixed",
        "geometry": {"type": "plane", "point": [0.0, 0.0], "normal": [0.0, 1.0]},
    }  # fmt: skip
    simulation, report = found(entries)
    weight = 5.0 * simulation.state.points.mass.sum()
    assert report.result.resultant("base")[1] == pytest.approx(weight, rel=1e-6)
    result = simulation.advance(0.0, 1.0)
    assert result.resultant("base")[1] == pytest.approx(weight, rel=1e-6)
    assert np.abs(simulation.state.points.displacement).max() < 1e-9


def test_tracked_surfaces_stay_and_their_loads_are_balanced() -> None:
    entries = bench("plane_strain", "gimp")
    entries["bodies"][0]["surface"] = {}
    entries["loads"].append(
        {"type": "surface", "body": "block", "start": [2.0, 4.0], "end": [0.0, 4.0],
         "pressure": 10.0, "factor": FACTOR}
    )  # fmt: skip
    entries["initial"]["stress"][0]["surcharge"] = 10.0
    simulation = Simulation(Model.from_dict(entries))
    before = simulation.state.surfaces["block"].shape().position.copy()
    report = find_initial_equilibrium(simulation)
    np.testing.assert_array_equal(simulation.state.surfaces["block"].shape().position, before)
    total = 5.0 * simulation.state.points.mass.sum() + 20.0
    assert report.result.resultant("low y")[1] == pytest.approx(total, rel=1e-7)


def test_a_state_in_equilibrium_stays_to_the_last_bit() -> None:
    entries = bench("plane_strain", "gimp")
    entries["bodies"] = entries["bodies"][:1]
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [0.0, 0.0], "upper": [4.0, 4.0]}
    entries["boundaries"][1] = plane("low y", "y", 0.0)
    entries["initial"]["stress"] = entries["initial"]["stress"][:1]
    before = by_number(Simulation(Model.from_dict(entries)).state.points)
    simulation, report = found(entries)
    assert report.iterations == 0
    after = by_number(simulation.state.points)
    assert all(before[name].tobytes() == after[name].tobytes() for name in before)
    assert report.text("kPa").startswith("in equilibrium as declared")


def no_load(entries: dict[str, Any]) -> dict[str, Any]:
    entries["initial"]["stress"] = [{"type": "gravity", "body": "block"}]
    del entries["loads"][0]["factor"]
    return entries


def never(entries: dict[str, Any]) -> dict[str, Any]:
    entries["initial"] = {"stress": [{"type": "gravity", "body": "block"}], "equilibrium": False}
    return entries


def nothing(entries: dict[str, Any]) -> dict[str, Any]:
    entries["initial"] = {"reset_plastic_strain": True}
    return entries


def cam_clay(entries: dict[str, Any]) -> dict[str, Any]:
    entries["materials"]["soil"] = material_entries("modified_cam_clay")
    entries["initial"]["stress"] = [
        {"type": "gravity", "body": "block"}, {"type": "k0", "body": "low", "K0": 0.5}
    ]  # fmt: skip
    return entries


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (no_load, r"type = .gravity.: no load acts at time 0"),
        (never, r"initial.equilibrium = false: gravity loading is a search"),
        (nothing, r"initial.reset_plastic_strain: there is no \[\[initial.stress\]\]"),
        (cam_clay, r"type = .gravity.: a material .* cannot be without stress, not even at first"),
    ],
)
def test_wrong_entries_are_refused(change: Any, message: str) -> None:
    with pytest.raises(BadInput, match=message):
        Model.from_dict(change(bench("plane_strain", "linear")))
