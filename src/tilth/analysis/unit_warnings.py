# SPDX-License-Identifier: BSD-3-Clause
"""Warnings of labels that contradict each other, and of numbers that look like other units."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth.model import BodyForce, Model
from tilth.model.unit_labels import (
    FORCES,
    MASSES,
    STRESSES,
    force_of,
    label_of,
    length_of,
    mass_of,
    same,
    stress_of,
    time_of,
)
from tilth.mpm.points import MaterialPoints
from tilth.mpm.shear_strength import shear_strength

SOILS = ("mohr_coulomb", "drucker_prager", "tresca", "modified_cam_clay")
"""Laws of soil; with others there may be a foam or a metal."""

WEIGHTS = {True: (5e3, 40e3), False: (100.0, 200e3)}
"""Unit weights of soil, buoyant to wet, and of any other material [N/m3]."""

WATER = (9e3, 13e3)
"""Unit weights of water, salt water and slurry [N/m3]."""

DENSITIES = (500.0, 4100.0)
"""Densities of soil [kg/m3]."""

GRAVITY = 9.81
"""[m/s2]"""

CENTRIFUGE = 300.0
"""Greatest acceleration of a centrifuge [g]."""

WEIGHTLESS = 1e-3
"""A weight below this, over that of the heaviest material, is none."""

RADIANS = (0.08, 1.06)
"""Angles of friction of 5 to 60 degrees in radians [-]; no soil has so few degrees."""

STIFFEST = 1e5
"""Young's modulus over the undrained strength above which the two are probably in different units:
clay has 50 to 2000."""


def unit_warnings(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Yields what labels and numbers contradict: what each warning is about, and its text.

    Nothing is said of labels that one does not know, and of what has no weight.
    """
    yield from _labels(model)
    yield from _weights(model)
    yield from _upwards(model)
    yield from _water_weight(model)
    yield from _angles(model, points)
    yield from _stiff(model, points)


def _labels(model: Model) -> Iterator[tuple[str, str]]:
    """Labels of stress, force and mass that do not belong together."""
    units = model.units
    length = length_of(units.length)
    if length is None or (force := force_of(units.force, length)) is None:
        return
    stress = stress_of(units.stress)
    if stress is not None and not same(stress, wanted := force / length**2):
        choices = _choices(
            ("stress", label_of(wanted, STRESSES)), ("force", label_of(stress * length**2, FORCES))
        )
        yield (
            "label of stress",
            f"units.stress = {units.stress!r}: stresses are forces over areas, but "
            f"{units.force}/{units.length}^2 is {_times(wanted / stress)} {units.stress}, so that "
            f"forces or stresses of the results have a wrong label; {choices}",
        )
    mass = mass_of(units.mass)
    if mass is None or not _has_weight(model):
        return
    times = {1.0, time_of(units.time) or 1.0}
    if model.analysis.inertia is not None:
        times = {time_of(units.time) or math.nan}  # accelerations are in its unit
    forces = [mass * length / time**2 for time in times]
    if any(math.isnan(each) or same(each, force) for each in forces):
        return
    choices = _choices(
        ("mass", label_of(force / length * min(times) ** 2, MASSES)),
        ("force", label_of(forces[0], FORCES)),
    )
    yield (
        "label of mass",
        f"units.mass = {units.mass!r}: weights are masses times accelerations, but "
        f"{units.mass} {units.length}/{units.time or 's'}^2 is {_times(forces[0] / force)} "
        f"{units.force}, so that densities or forces have a wrong label; {choices}",
    )


def _choices(*labels: tuple[str, str]) -> str:
    """Returns the remedy: the labels that fit, if one knows any."""
    known = [f'{key} = "{label}"' for key, label in labels if label]
    remedy = f"give {' or '.join(known)} in [units]" if known else "correct [units]"
    return f"{remedy}, as the numbers of the case are"


def _times(ratio: float) -> str:
    return f"{ratio:.4g}"


def _has_weight(model: Model) -> bool:
    """Whether forces depend on a density."""
    dense = any(model.materials[name].density for name in _used(model))
    return dense and (bool(_gravity(model)) or model.analysis.inertia is not None)


def _used(model: Model) -> list[str]:
    return sorted({name for body in model.bodies for name in body.materials})


def _gravity(model: Model) -> list[float]:
    """Returns the least and the greatest magnitude of the body forces' accelerations.

    At their greatest factors and at 1: loads may be increased up to a collapse. Empty for none.
    """
    loads = [load for _, load in model.acting_loads() if isinstance(load, BodyForce)]
    whole = [np.array(load.acceleration, dtype=float) for load in loads]
    factors = [max(abs(f) for _, f in model.load_curve(load).table) for load in loads]
    most = [each * factor for each, factor in zip(whole, factors, strict=True)]
    sizes = [float(np.linalg.norm(np.sum(each, axis=0))) for each in (whole, most) if each]
    return sorted(sizes) if sizes and max(sizes) > 0.0 else []


def greatest_gravity(model: Model) -> float:
    """Returns the greatest acceleration of the body forces [length/time^2]; 0 without them."""
    return max(_gravity(model), default=0.0)


def _weights(model: Model) -> Iterator[tuple[str, str]]:
    """Unit weights that no soil has."""
    units, gravity = model.units, _gravity(model)
    length = length_of(units.length)
    force = None if length is None else force_of(units.force, length)
    if length is None or force is None or not gravity:
        return
    per_volume = force / length**3
    heaviest = max((model.materials[name].density or 0.0 for name in _used(model)), default=0.0)
    for name in _used(model):
        material: Any = model.materials[name]
        if material.model not in SOILS and not units.model_fields_set:
            continue  # an elastic body in units that nobody named may be anything
        least, most = WEIGHTS[material.model in SOILS]
        for key in ("density", "saturated_density"):
            density = getattr(material, key, None)
            if not density or density < WEIGHTLESS * heaviest:
                continue
            low, high = (density * each * per_volume for each in (gravity[0], gravity[-1]))
            if high >= least and low <= most:
                continue
            if _in_centrifuge(model, density, gravity[-1], length):
                continue
            kind = "soil" if material.model in SOILS else "a material"
            one = 1e3 / per_volume / gravity[-1]
            yield (
                f"{key} of {name}",
                f"materials.{name}.{key} = {density:g}: with the acceleration {gravity[-1]:g} the "
                f"unit weight is {density * gravity[-1]:.4g} {units.force}/{units.length}^3, which "
                f"is {high / 1e3:.3g} kN/m3, and {kind} has {least / 1e3:g} to {most / 1e3:g} "
                f"kN/m3; a density is the unit weight over the acceleration, {one:.4g} for each "
                f"kN/m3: check it and the acceleration, {_or_labels(model)}",
            )


def _or_labels(model: Model) -> str:
    if model.units.model_fields_set:
        return "or correct the labels in [units]"
    return "or give the labels of its units in [units], as without them they are m, N, Pa and kg"


def _in_centrifuge(model: Model, density: float, gravity: float, length: float) -> bool:
    """Whether a density is that of soil and the acceleration possible in a centrifuge."""
    mass = mass_of(model.units.mass)
    if mass is None:
        return False
    of_soil = DENSITIES[0] <= density * mass / length**3 <= DENSITIES[1]
    return of_soil and 0.9 * GRAVITY <= gravity * length <= CENTRIFUGE * GRAVITY


def _upwards(model: Model) -> Iterator[tuple[str, str]]:
    """Gravity that lifts the soil."""
    loads = [(i, load) for i, load in model.acting_loads() if isinstance(load, BodyForce)]
    dense = any(model.materials[name].density for name in _used(model))
    if len(loads) != 1 or not dense:
        return
    number, load = loads[0]
    factors = [factor for _, factor in model.load_curve(load).table]
    vertical = load.acceleration[-1]
    if vertical * max(factors, key=abs) > 0.0:
        axis = "xyz"[len(load.acceleration) - 1]
        yield (
            "gravity upwards",
            f"loads[{number}].acceleration: the only body force points upwards "
            f"({axis} = {vertical:g}, times its factor), so that it lifts the soil; {axis} is up: "
            f"give gravity a negative {axis} unless this is meant",
        )


def _water_weight(model: Model) -> Iterator[tuple[str, str]]:
    """A unit weight that water does not have."""
    length = length_of(model.units.length)
    force = None if length is None else force_of(model.units.force, length)
    key, water = ("flow", model.flow) if model.water is None else ("water", model.water)
    if water is None or length is None or force is None:
        return
    weight = water.unit_weight * force / length**3
    gravity = max(_gravity(model), default=GRAVITY / length) * length / GRAVITY
    if not WATER[0] <= weight <= WATER[1] * max(gravity, 1.0):
        yield (
            "weight of water",
            f"{key}.unit_weight = {water.unit_weight:g}: this is {weight / 1e3:.3g} kN/m3, "
            f"and water has 9.81, {9810.0 * length**3 / force:.4g} "
            f"{model.units.force}/{model.units.length}^3: check it, {_or_labels(model)}",
        )


def _angles(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Angles of friction that are probably in radians."""
    tangent = shear_strength(points, model)[1]
    for range_ in points.ranges:
        name = model.bodies[range_.body].materials[range_.layer]
        material: Any = model.materials[name]
        own = tangent[range_.points]
        angle = float(np.degrees(np.arctan(own.max(initial=0.0)))) if np.isfinite(own).all() else 0
        key = "friction_angle"
        declared = getattr(material, "residual_friction_angle", None)
        if isinstance(declared, float) and not RADIANS[0] <= angle <= RADIANS[1]:
            angle, key = declared, "residual_friction_angle"
        if RADIANS[0] <= angle <= RADIANS[1]:
            dilation = getattr(material, "dilation_angle", None)
            also = " and `dilation_angle`" if isinstance(dilation, float) and dilation else ""
            yield (
                f"angle of {name}",
                f"materials.{name}.{key}: an angle of {angle:.4g} degrees is that of no soil, but "
                f"{angle:.4g} radians are {math.degrees(angle):.3g} degrees: give it{also} in "
                "degrees",
            )


def _stiff(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Undrained strengths that are too small for the stiffness by orders of magnitude."""
    young = points.elastic_moduli().young
    cohesion, tangent = shear_strength(points, model)
    for range_ in points.ranges:
        name = model.bodies[range_.body].materials[range_.layer]
        own, strength = young[range_.points], cohesion[range_.points]
        ratio = own / np.where((strength > 0.0) & (tangent[range_.points] == 0.0), strength, np.nan)
        if not (ratio > STIFFEST).any():
            continue
        worst = int(np.nanargmax(ratio))
        yield (
            f"strength of {name}",
            f"materials.{name}: Young's modulus {own[worst]:.4g} is {ratio[worst]:.2g} times the "
            f"undrained shear strength {strength[worst]:.4g}, and clay has 50 to 2000 times: check "
            "the units of both",
        )
