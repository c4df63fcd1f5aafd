# SPDX-License-Identifier: BSD-3-Clause
"""The shear strength of the soil itself, held against what the laws bear when they are sheared."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from implicit_entries import boundary, entries

from tilth import DruckerPrager, Model, MohrCoulomb, Tresca, VonMises, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model.isotropic import AnyMaterial, ParametersAt
from tilth.mpm.shear_strength import shear_strength

ELASTIC = {"young_modulus": 1e4, "poisson_ratio": 0.3}
FRICTION = {**ELASTIC, "cohesion": 12.0, "friction_angle": 30.0, "dilation_angle": 0.0}
SOFTENING = {"residual_cohesion": 2.0, "residual_friction_angle": 20.0, "softening_strain": 0.01,
             "softening_length": 1.0}  # fmt: skip


def strength(material: AnyMaterial, plastic_strain: Floats) -> tuple[Floats, Floats]:
    """Cohesion and tan(phi) as the material says, (n,) each."""
    at = ParametersAt(lambda key: getattr(material, key), 1.0)
    columns = dict(zip(material.parameter_names, material.parameter_array(at, 1).T, strict=True))
    c, tangent = material.shear_strength(columns, plastic_strain)
    return np.broadcast_to(c, plastic_strain.shape), np.broadcast_to(tangent, plastic_strain.shape)


def sheared(material: AnyMaterial, plastic_strain: float) -> Floats:
    """Principal stresses (n, 3), largest first, after large plane shear under several pressures.

    The stress deviator is held at the trial strain of pure shear and a compression in addition.
    """
    at = ParametersAt(lambda key: getattr(material, key), 1.0)
    parameters, law = material.parameter_array(at, 1), material.law
    compression = np.linspace(1e-4, 5e-3, 30)
    trial = np.stack([0.02 - compression, -compression, -0.02 - compression], axis=1)
    n = len(trial)
    plastic = np.tile([plastic_strain, 0.0], (n, 1))
    stress, elastic, tangent = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    state, good = np.zeros((n, len(law.state_variables))), np.zeros(n, dtype=bool)
    _core.principal_update(
        law.core, parameters, trial, plastic, state.copy(), state, stress, elastic, tangent, good
    )
    assert good.all()
    return -np.sort(-stress)


def envelope(stress: Floats, c: Floats, tangent: Floats) -> Floats:
    """Greatest tau - (c + p tan(phi)) over all planes, (n,); 0 on the failing plane of the soil."""
    phi = np.arctan(tangent)
    radius, centre = 0.5 * (stress[:, 0] - stress[:, 2]), 0.5 * (stress[:, 0] + stress[:, 2])
    return np.asarray((radius + centre * np.sin(phi)) / np.cos(phi) - c)


@pytest.mark.parametrize("plastic_strain", [0.0, 0.004, 0.5])
@pytest.mark.parametrize(
    "material",
    [
        Tresca(**ELASTIC, undrained_shear_strength=7.0),
        MohrCoulomb(**FRICTION),
        MohrCoulomb(**{**FRICTION, "friction_angle": 0.0}),
    ],
    ids=lambda material: material.model,
)
def test_the_failing_plane_bears_cohesion_and_friction(
    material: AnyMaterial, plastic_strain: float
) -> None:
    """Coulomb's envelope touches the circle of the stress: tau = c + p tan(phi) on its plane."""
    stress = sheared(material, plastic_strain)
    c, tangent = strength(material, np.full(len(stress), plastic_strain))
    np.testing.assert_allclose(envelope(stress, c, tangent), 0.0, atol=1e-9)


def test_softened_strength_is_the_present_one() -> None:
    """At the residual strength the envelope is touched; half way both values are half way."""
    material = MohrCoulomb(**FRICTION, **SOFTENING)
    stress = sheared(material, 0.5)
    c, tangent = strength(material, np.full(len(stress), 0.5))
    np.testing.assert_allclose(c, 2.0)
    np.testing.assert_allclose(tangent, np.tan(np.radians(20.0)))
    np.testing.assert_allclose(envelope(stress, c, tangent), 0.0, atol=1e-9)
    c, tangent = strength(material, np.array([0.0, 0.005, 0.01]))
    np.testing.assert_allclose(c, [12.0, 7.0, 2.0])
    np.testing.assert_allclose(tangent, np.tan(np.radians([30.0, 25.0, 20.0])))


@pytest.mark.parametrize("hardening", [0.0, 300.0])
@pytest.mark.parametrize("plastic_strain", [0.0, 0.03])
def test_von_mises_bears_its_strength_in_plane_shear(
    hardening: float, plastic_strain: float
) -> None:
    """The plane shear has no mean deviator: the largest shear stress is k = yield / sqrt(3)."""
    material = VonMises(**ELASTIC, undrained_shear_strength=7.0, hardening_modulus=hardening)
    trial = np.array([[0.02, 0.0, -0.02]])
    at = ParametersAt(lambda key: getattr(material, key), 1.0)
    stress, elastic, tangent = np.empty((1, 3)), np.empty((1, 3)), np.empty((1, 3, 3))
    plastic, state = np.array([[plastic_strain, 0.0]]), np.zeros((1, 0))
    good = np.zeros(1, dtype=bool)
    parameters = material.parameter_array(at, 1)
    _core.principal_update(
        "von_mises", parameters, trial, plastic, state.copy(), state, stress, elastic, tangent, good
    )
    after = plastic_strain + np.sqrt(2.0 / 3.0) * np.linalg.norm(trial - elastic)
    c, friction = strength(material, np.array([after]))
    assert 0.5 * (stress[0, 0] - stress[0, 2]) == pytest.approx(c[0], rel=1e-9)
    assert c[0] == pytest.approx(7.0 + hardening * after / np.sqrt(3.0))
    assert friction[0] == 0.0


@pytest.mark.parametrize("fit", ["compression", "extension", "plane_strain"])
def test_drucker_prager_has_that_of_the_pyramid_it_is_fitted_to(fit: Any) -> None:
    for dilation in (0.0, 10.0, 30.0):
        material = DruckerPrager(**{**FRICTION, "dilation_angle": dilation}, fit=fit)
        c, tangent = strength(material, np.zeros(2))
        np.testing.assert_allclose(c, 12.0, rtol=1e-12)
        np.testing.assert_allclose(tangent, np.tan(np.radians(30.0)), rtol=1e-12)


def box(name: str, material: str, left: float) -> dict[str, Any]:
    shape = {"type": "box", "lower": [left, 0.0], "upper": [left + 1.0, 2.0]}
    return {"name": name, "material": material, "shape": shape, "basis": "linear",
            "points_per_cell": 2}  # fmt: skip


def test_strength_of_the_points_of_a_model() -> None:
    """Every body has its own; one increases with depth, and elastic soil has none."""
    rising = {"depth": [[0.0, 2.0], [2.0, 6.0]], "surface": 2.0}
    materials = {
        "clay": {"model": "tresca", **ELASTIC, "undrained_shear_strength": rising},
        "sand": {"model": "mohr_coulomb", **FRICTION},
        "rock": {"model": "hencky_elastic", **ELASTIC},
    }
    bodies = [box("a", "clay", 0.0), box("b", "sand", 1.0), box("c", "rock", 2.0)]
    given = entries(boundary(), bodies=bodies, materials=materials)
    model = Model.from_dict(given)
    points = Simulation(model).state.points
    c, tangent = shear_strength(points, model)
    assert c.shape == tangent.shape == (len(points),)
    depth = 2.0 - points.position[:, 1]
    clay, sand, rock = (points.body_id == i for i in range(3))
    np.testing.assert_allclose(c[clay], 2.0 + 2.0 * depth[clay])
    np.testing.assert_array_equal(tangent[clay], 0.0)
    np.testing.assert_array_equal(c[sand], 12.0)
    np.testing.assert_allclose(tangent[sand], np.tan(np.radians(30.0)))
    assert np.isnan(c[rock]).all()
    assert np.isnan(tangent[rock]).all()
