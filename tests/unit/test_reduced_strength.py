# SPDX-License-Identifier: BSD-3-Clause
"""Reduced strengths: the laws themselves, evaluated with the reduced parameters."""

from __future__ import annotations

import numpy as np
import pytest
from small_problems import block_entries, declared

from tilth import (
    DruckerPrager,
    HenckyElastic,
    Model,
    MohrCoulomb,
    Tresca,
    VonMises,
    _core,
)
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model.isotropic import AnyMaterial, ParametersAt
from tilth.mpm.frozen_points import FrozenPoints
from tilth.mpm.initial_stress import require_within_yield

FACTORS = (0.5, 1.0, 1.7, 4.0)
C, PHI, PSI = 12.0, 30.0, 8.0
PARTS = {"young_modulus": 1e4, "poisson_ratio": 0.3}
FRICTION = {**PARTS, "cohesion": C, "friction_angle": PHI, "dilation_angle": PSI}


def parameters_of(material: AnyMaterial) -> Floats:
    return material.parameter_array(ParametersAt(lambda key: getattr(material, key), 1.0), 1)


def returned(
    material: AnyMaterial, parameters: Floats, plastic_strain: float = 0.0
) -> tuple[Floats, Floats]:
    """Stresses (n, 3) at random trial strains that yield, largest first, and plastic strains."""
    random = np.random.default_rng(3)
    n, law = 400, material.law
    trial = np.ascontiguousarray(random.normal(size=(n, 3)) * 0.01 - 0.004)
    plastic = np.tile([plastic_strain, 0.0], (n, 1))
    stress, elastic, tangent = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    state, good = np.zeros((n, len(law.state_variables))), np.zeros(n, dtype=bool)
    _core.principal_update(
        law.core, parameters, trial, plastic, state.copy(), state, stress, elastic, tangent, good
    )
    assert good.all()
    yielding = np.abs(trial - elastic).max(axis=1) > 1e-9
    assert yielding.sum() > 50
    if "excess_pore_pressure" in law.state_variables:
        stress += state[:, [list(law.state_variables).index("excess_pore_pressure")]]
    return -np.sort(-stress[yielding]), (trial - elastic)[yielding]


def mohr_coulomb_excess(stress: Floats, c: float, tangent: float) -> Floats:
    """Shear stress on the worst plane over c + sigma tan(phi), times cos(phi), less 1, (n,)."""
    sine, cosine = np.sin(np.arctan(tangent)), np.cos(np.arctan(tangent))
    radius, centre = 0.5 * (stress[:, 0] - stress[:, 2]), 0.5 * (stress[:, 0] + stress[:, 2])
    return np.asarray(radius + centre * sine - c * cosine)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("fluid", [None, 1e5])
def test_mohr_coulomb_yields_at_c_and_tan_phi_over_the_factor(
    factor: float, fluid: float | None
) -> None:
    material = MohrCoulomb(**FRICTION, pore_fluid_bulk_modulus=fluid)
    reduced = material.reduced_parameters(parameters_of(material), factor)
    stress, _ = returned(material, reduced)
    tangent = np.tan(np.radians(PHI)) / factor
    excess = mohr_coulomb_excess(stress, C / factor, tangent)
    assert excess.max() <= 1e-10 * np.abs(stress).max()
    on_plane = np.abs(excess) <= 1e-10 * np.abs(stress).max()
    assert on_plane.sum() > 40  # the others are at the cut-off, the apex c cot(phi)
    apex = C / np.tan(np.radians(PHI))
    assert stress[:, 0].max() <= apex * (1.0 + 1e-10)


@pytest.mark.parametrize("factor", FACTORS)
def test_softened_strength_is_divided_too(factor: float) -> None:
    softening = {"softening_strain": 0.01, "softening_length": 1.0}
    material = MohrCoulomb(
        **FRICTION, residual_cohesion=2.0, residual_friction_angle=20.0, **softening
    )
    reduced = material.reduced_parameters(parameters_of(material), factor)
    stress, _ = returned(material, reduced, plastic_strain=0.5)
    excess = mohr_coulomb_excess(stress, 2.0 / factor, np.tan(np.radians(20.0)) / factor)
    assert np.abs(excess[excess > -1e-3]).max() <= 1e-10 * np.abs(stress).max()
    assert (np.abs(excess) < 1e-9).sum() > 40


def test_cut_off_is_divided_and_dilation_limited() -> None:
    material = MohrCoulomb(**{**FRICTION, "dilation_angle": 25.0}, tension_cut_off=5.0)
    names = material.parameter_names
    for factor in FACTORS:
        reduced = material.reduced_parameters(parameters_of(material), factor)
        found = dict(zip(names, reduced, strict=True))
        assert found["tension_cut_off"] == 5.0 / factor
        assert found["dilation_angle"] == pytest.approx(min(25.0, found["friction_angle"]))
        assert found["young_modulus"] == 1e4


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("fluid", [None, 1e5])
@pytest.mark.parametrize("fit", ["compression", "extension", "plane_strain"])
def test_drucker_prager_is_the_fit_to_the_reduced_pyramid(
    fit: str, factor: float, fluid: float | None
) -> None:
    """The same as a material that is declared with c / F and atan(tan(phi) / F)."""
    weaker = np.degrees(np.arctan(np.tan(np.radians(PHI)) / factor))
    material = DruckerPrager(
        **FRICTION, fit=fit, tension_cut_off=3.0, pore_fluid_bulk_modulus=fluid
    )  # type: ignore[arg-type]
    declared = DruckerPrager(
        **{**FRICTION, "cohesion": C / factor, "friction_angle": float(weaker)},
        fit=fit,  # type: ignore[arg-type]
        tension_cut_off=3.0 / factor,
        pore_fluid_bulk_modulus=fluid,
    )
    reduced = material.reduced_parameters(parameters_of(material), factor)
    np.testing.assert_allclose(reduced, parameters_of(declared), rtol=1e-12)


@pytest.mark.parametrize("factor", FACTORS)
def test_tresca_and_von_mises(factor: float) -> None:
    clay = Tresca(**PARTS, undrained_shear_strength=C)
    reduced = clay.reduced_parameters(parameters_of(clay), factor)
    stress, _ = returned(clay, reduced)
    np.testing.assert_allclose(stress[:, 0] - stress[:, 2], 2.0 * C / factor, rtol=1e-10)
    metal = VonMises(**PARTS, yield_stress=20.0, hardening_modulus=300.0)
    reduced = metal.reduced_parameters(parameters_of(metal), factor)
    stress, flow = returned(metal, reduced, plastic_strain=0.1)
    after = 0.1 + np.sqrt(2.0 / 3.0) * np.linalg.norm(flow, axis=1)
    deviator = stress - stress.mean(axis=1, keepdims=True)
    size = np.sqrt(1.5) * np.linalg.norm(deviator, axis=1)
    np.testing.assert_allclose(size, (20.0 + 300.0 * after) / factor, rtol=1e-10)


def test_parameters_of_each_point_are_reduced_alike() -> None:
    material = MohrCoulomb(**FRICTION)
    one = parameters_of(material)
    other = one.copy()
    other[material.parameter_names.index("cohesion")] = 40.0
    both = material.reduced_parameters(np.stack([one, other]), 1.4)
    for row, own in zip(both, (one, other), strict=True):
        alone = material.reduced_parameters(own, 1.4)
        np.testing.assert_array_equal(row, alone)


def test_elastic_soil_stays_and_cam_clay_is_refused() -> None:
    elastic = HenckyElastic(**PARTS)
    found = elastic.reduced_parameters(parameters_of(elastic), 2.0)
    np.testing.assert_array_equal(found, parameters_of(elastic))
    clay = declared("modified_cam_clay")
    (problem,) = clay.irreducible("materials.clay", clay.law, None)
    assert problem.key == "materials.clay.model"
    assert not list(elastic.irreducible("materials.rock", elastic.law, None))


@pytest.mark.parametrize("fluid", [None, 1e5])
def test_stiffened_laws_have_the_same_stress_at_smaller_strains(fluid: float | None) -> None:
    """All strains over 100, moduli times 100: on and off the yield surface, while it softens."""
    softening = {"softening_strain": 0.05, "softening_length": 1.0}
    soil = MohrCoulomb(
        **FRICTION, residual_cohesion=2.0, **softening, pore_fluid_bulk_modulus=fluid
    )
    metal = VonMises(**PARTS, yield_stress=20.0, hardening_modulus=300.0)
    for material in (soil, metal):
        law, scale = material.law, 100.0
        trial = np.random.default_rng(1).normal(size=(50, 3)) * 0.004 - 0.002
        results = []
        for parameters, divisor in (
            (parameters_of(material), 1.0),
            (material.stiffened_parameters(parameters_of(material), scale), scale),
        ):
            stress, elastic, tangent = np.empty((50, 3)), np.empty((50, 3)), np.empty((50, 3, 3))
            after, good = np.zeros((50, len(law.state_variables))), np.zeros(50, dtype=bool)
            plastic = np.tile([0.01 / divisor, 0.0], (50, 1))
            _core.principal_update(
                law.core, parameters, np.ascontiguousarray(trial / divisor), plastic,
                after.copy(), after, stress, elastic, tangent, good,
            )  # fmt: skip
            assert good.all()
            results.append((stress, elastic * divisor, tangent / divisor))
        for one, other in zip(*results, strict=True):
            np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9 * np.abs(one).max())


def test_frozen_points_have_softened_as_far() -> None:
    """Soil in the middle of its softening: the frozen copy carries the same stress and no less."""
    entries = block_entries("plane_strain", "gimp")
    entries["materials"]["soil"] = {
        "model": "mohr_coulomb", **FRICTION, "density": 1.0, "residual_cohesion": 2.0,
        "softening_strain": 0.05, "softening_length": 1.0,
    }  # fmt: skip
    model = Model.from_dict(entries)
    points = Simulation(model).state.points
    points.plastic[:, 0] = np.linspace(0.0, 0.04, len(points))
    beyond = np.tile([-10.0, -200.0, -30.0, 5.0, 0.0, 0.0], (len(points), 1))
    assert points.part(points.ranges[0]).start_with(beyond) < 0
    frozen = FrozenPoints(model, points, 100.0).points
    for each in (points, frozen):
        require_within_yield(each.part(each.ranges[0]), "soil", returned=True)
    assert (np.abs(points.stress - beyond).max(axis=1) > 10.0).all()
    np.testing.assert_allclose(frozen.stress, points.stress, rtol=0, atol=1e-7)
    np.testing.assert_allclose(frozen.elastic_strain * 100.0, points.elastic_strain, atol=1e-9)
