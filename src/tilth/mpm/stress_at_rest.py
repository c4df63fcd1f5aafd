# SPDX-License-Identifier: BSD-3-Clause
"""Earth pressure at rest: effective stress of the points of a body from weight and K0."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.fields.evaluate import parameter_values
from tilth.fields.tables import place_text
from tilth.model import Model
from tilth.model.cam_clay import ModifiedCamClay
from tilth.model.fields import LEAST
from tilth.model.initial import JAKY, AtRest
from tilth.model.initial_checks import at_rest_of
from tilth.model.isotropic import ParametersAt
from tilth.model.problems import dotted
from tilth.model.soils import DruckerPrager
from tilth.mpm.overburden import overburden
from tilth.mpm.water import PhreaticSurface

ROUND_OFF = 1e-12
"""Pore pressure above the total stress that counts as equal to it, relative to the latter."""


@dataclass(frozen=True)
class AtRestLayer:
    """The stress of the points of one material.

    Attributes:
        stress: effective Cauchy stress, tension positive, shape (n, 6).
        preconsolidation: mean effective stress at the tip of Cam Clay's yield surface,
            compression positive [stress], shape (n,); None if the material gives it.
    """

    stress: Floats
    preconsolidation: Floats | None


def stress_at_rest(
    model: Model, key: str, entry: AtRest, number: int, materials: tuple[str, str], position: Floats
) -> AtRestLayer:
    """Returns the stress of points of one material of a body at rest.

    Args:
        model: the declared problem.
        key: of the entry in the case file, for messages.
        entry: of the body's stress.
        number: of the body.
        materials: names of the points' material at the start, whose stress this is, and of that
            whose preconsolidation is asked for: the same, or one that a stage exchanges for it.
        position: of the points [length], shape (n, dim).

    Raises:
        BadInput: a point lies above the ground, no weight balances the stress, or the pore pressure
            exceeds the weight.
    """
    vertical = _effective_vertical_stress(model, key, entry, number, position)
    material, other = materials
    coefficient, ratio = at_rest_of(entry, material)
    past = 1.0 if ratio is None else ratio
    if coefficient == JAKY:
        sine = _sine(model, material, position)
        lateral = (1.0 - sine) * past**sine
    else:
        assert isinstance(coefficient, float), "checked by the model"
        lateral = np.full(len(position), coefficient)
    stress = np.zeros((len(position), 6))
    stress[:, :3] = -(lateral * vertical)[:, None]
    stress[:, model.dimension - 1] = -vertical
    preconsolidation, declared = None, model.materials[other]
    if isinstance(declared, ModifiedCamClay) and not (
        ratio is None or declared.has_preconsolidation
    ):
        sine = _sine(model, other, position)
        slope = _values(model, other, position, "critical_state_slope")
        mean = ratio * vertical * (1.0 + 2.0 * (1.0 - sine)) / 3.0
        deviator = ratio * vertical * sine
        preconsolidation = mean + deviator**2 / (slope**2 * np.maximum(mean, LEAST))
        preconsolidation = np.maximum(preconsolidation, LEAST)
    return AtRestLayer(stress, preconsolidation)


def _effective_vertical_stress(
    model: Model, key: str, entry: AtRest, number: int, position: Floats
) -> Floats:
    """Returns total vertical stress less pore pressure, compression positive [stress], (n,)."""
    water = PhreaticSurface.of(model)
    if water is None:
        return overburden(model, key, entry, number, position, None)
    water.require_covers(position)
    total = overburden(model, key, entry, number, position, water)
    pressure = water.pore_pressure(position, 0.0)
    effective = total - pressure
    if (effective < -ROUND_OFF * total).any():
        worst = int(effective.argmin())
        raise BadInput(
            f"the pore pressure {pressure[worst]:.4g} exceeds the weight {total[worst]:.4g} above "
            f"the point at {place_text(position[worst])}",
            "check level and unit weight of the water, and the densities",
            key=f"{key}.type",
            value="k0",
        )
    return np.maximum(effective, 0.0)


def _sine(model: Model, material: str, position: Floats) -> Floats:
    """Returns the sine of the friction angle in triaxial compression at points, shape (n,).

    Strength in triaxial compression is q = M p with M = 6 sin(phi) / (3 - sin(phi)); M is sqrt(3)
    times the slope of Drucker and Prager's cone in sqrt(J2) over p.
    """
    declared = model.materials[material]
    if isinstance(declared, ModifiedCamClay):
        slope = _values(model, material, position, "critical_state_slope")
    elif isinstance(declared, DruckerPrager):
        entries = parameter_values(declared, position, dotted(("materials", material)))
        at = ParametersAt(lambda name: entries.get(name, getattr(declared, name)), 1.0)
        cone = declared.law_parameters(at)["friction_slope"]
        slope = np.sqrt(3.0) * np.broadcast_to(cone, len(position))
    else:
        angle = _values(model, material, position, "friction_angle")
        return np.asarray(np.sin(np.radians(angle)))
    return np.asarray(3.0 * slope / (6.0 + slope))


def _values(model: Model, material: str, position: Floats, key: str) -> Floats:
    """Returns an entry of a material at points, shape (n,)."""
    declared = model.materials[material]
    found = parameter_values(declared, position, dotted(("materials", material)))
    return np.asarray(found.get(key, np.full(len(position), getattr(declared, key))))
