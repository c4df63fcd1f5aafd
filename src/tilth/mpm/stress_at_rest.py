# SPDX-License-Identifier: BSD-3-Clause
"""Earth pressure at rest: effective stress of the points of a body from weight and K0."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model import Model
from tilth.model.cam_clay import ModifiedCamClay
from tilth.model.fields import LEAST
from tilth.model.initial import AtRest
from tilth.model.initial_checks import RestOfMaterial, at_rest_of
from tilth.model.isotropic import ParametersAt
from tilth.model.problems import dotted
from tilth.model.soils import DruckerPrager, MohrCoulomb
from tilth.model.variation import Variation
from tilth.mpm.overburden import overburden
from tilth.mpm.water import PhreaticSurface
from tilth.variation.evaluate import parameter_values, values_at
from tilth.variation.tables import place_text

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
    rest, declared = at_rest_of(entry, material), model.materials[material]
    past, ratio = _past(rest, vertical, position, key)
    has_angle = isinstance(declared, MohrCoulomb | DruckerPrager | ModifiedCamClay)
    sine = _sine(model, material, position) if has_angle else np.zeros(0)
    first = 1.0 - sine  # the coefficient of first loading
    if isinstance(rest.K0_nc, float):
        first = np.full(len(position), rest.K0_nc)
    if rest.K0_nc is not None:
        nu = _values(model, material, position, "poisson_ratio")
        lateral = first * past - nu / (1.0 - nu) * (past - vertical)
    elif isinstance(rest.K0, float):
        lateral = rest.K0 * vertical
    else:
        lateral = first * ratio**sine * vertical
    if has_angle and rest.past is not None and not isinstance(rest.K0, float):
        lateral = np.minimum(lateral, (1.0 + sine) / (1.0 - sine) * vertical)
    stress = np.zeros((len(position), 6))
    stress[:, :3] = -lateral[:, None]
    stress[:, model.dimension - 1] = -vertical
    preconsolidation, clay = None, model.materials[other]
    given = isinstance(clay, ModifiedCamClay) and clay.has_preconsolidation
    if isinstance(clay, ModifiedCamClay) and rest.past is not None and not given:
        if other != material and not isinstance(rest.K0_nc, float):
            first = 1.0 - _sine(model, other, position)
        slope = _values(model, other, position, "critical_state_slope")
        mean = past * (1.0 + 2.0 * first) / 3.0
        deviator = past * (1.0 - first)
        preconsolidation = mean + deviator**2 / (slope**2 * np.maximum(mean, LEAST))
        preconsolidation = np.maximum(preconsolidation, LEAST)
    return AtRestLayer(stress, preconsolidation)


def _past(
    rest: RestOfMaterial, vertical: Floats, position: Floats, key: str
) -> tuple[Floats, Floats]:
    """Returns the greatest past vertical effective stress and its ratio to the present one, (n,).

    Raises:
        BadInput: a variation has no value at a point, or one that is not possible.
    """
    if rest.past is None:
        return vertical, np.ones(len(vertical))
    key = f"{key}{rest.of_past}.{rest.past_key}"
    value: Any = rest.past
    is_variation = isinstance(value, Variation)
    given = values_at(value, position, key) if is_variation else np.full(len(vertical), value)
    is_ratio = rest.overconsolidation_ratio is not None
    least = 1.0 if is_ratio else 0.0
    if not (given >= least).all():
        wrong = int(np.flatnonzero(~(given >= least))[0])
        what = f"must be at least {least:g}, at the material point at {place_text(position[wrong])}"
        raise BadInput(what, "change what it is given by", key=key, value=float(given[wrong]))
    if is_ratio:
        return given * vertical, given
    return vertical + given, (vertical + given) / np.maximum(vertical, LEAST)


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
