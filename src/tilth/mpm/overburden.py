# SPDX-License-Identifier: BSD-3-Clause
"""The weight of the declared soil, and of free water, vertically above points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.arrays import Floats
from tilth.bodies.discretise import requested
from tilth.bodies.forms import form_of
from tilth.bodies.request import Request
from tilth.bodies.thickness import Crossings, crossings_of
from tilth.errors import BadInput
from tilth.grid.background import background_grid
from tilth.model import Body, BodyForce, Model
from tilth.model.initial import AtRest
from tilth.mpm.water import PhreaticSurface
from tilth.variation.level import elevation
from tilth.variation.tables import place_text


def overburden(
    model: Model,
    key: str,
    entry: AtRest,
    number: int,
    position: Floats,
    water: PhreaticSurface | None,
) -> Floats:
    """Returns the total vertical stress at points at time 0, compression positive [stress], (n,).

    The sum over all layers above a point of unit weight times thickness: in each layer with the
    saturated density below the water level. Where no soil is below this level, there is water.

    Args:
        model: the declared problem.
        key: of the entry in the case file, for messages.
        entry: of the body's stress.
        number: of the body.
        position: of its points [length], shape (n, dim).
        water: its surface; None without water.

    Raises:
        BadInput: a point lies above the ground, or there is no vertical body force.
    """
    low = position[:, -1]
    high = np.full(len(low), np.inf)
    if entry.ground is not None:
        high = elevation(entry.ground, position, f"{key}.ground")
        _require_below(position, high, key, entry)
    level = low if water is None else np.maximum(water.level(position, 0.0), low)
    gravity = _gravity(model, key)
    stress: Floats = np.full(len(low), entry.surcharge)
    filled = np.zeros(len(low))
    for name, total, wet in _strata(model, key, number, position, (low, high, level)):
        material = model.materials[name]
        density = material.density or 0.0
        saturated = density if material.saturated_density is None else material.saturated_density
        stress += gravity * (density * (total - wet) + saturated * wet)
        filled += wet
    if water is not None:
        stress += water.unit_weight(0.0) * np.maximum(level - low - filled, 0.0)
    return stress


def _strata(
    model: Model, key: str, number: int, position: Floats, heights: tuple[Floats, Floats, Floats]
) -> Iterator[tuple[str, Floats, Floats]]:
    """Yields the soil above points: material, thickness, and that below the water, (n,) each.

    heights: of the points, of the ground (or infinite) and of the water, not below the points.
    """
    low, high, level = heights
    has_ground = bool(np.isfinite(high).all())
    bodies = [
        _parts(model, i, position, low, high) if model.present(body.name) else []
        for i, body in enumerate(model.bodies)
    ]
    for i, parts in enumerate(bodies):
        if i == number and has_ground:
            continue
        for name, crossings, bottom, top in parts:
            wet_top = np.clip(level, bottom, top)
            yield name, crossings.thickness(bottom, top), crossings.thickness(bottom, wet_top)
    if not has_ground:
        return
    others = [part for i, parts in enumerate(bodies) if i != number for part in parts]
    own = _horizons(model, key, number, position, low, high)
    for name, bottom, top in own:
        found = []
        for upper in (top, np.clip(level, bottom, top)):
            taken = np.zeros(len(low))
            for _, crossings, least, most in others:
                first = np.clip(bottom, least, most)
                taken += crossings.thickness(first, np.maximum(np.minimum(upper, most), first))
            found.append(np.maximum(upper - bottom - taken, 0.0))
        yield name, found[0], found[1]


_Part = tuple[str, Crossings, Floats, Floats]
"""Material, outline, and the heights between which it counts."""


def _parts(model: Model, number: int, position: Floats, low: Floats, high: Floats) -> list[_Part]:
    """Returns the layers of a body above points."""
    body, place = model.bodies[number], position[:, :-1]
    form = form_of(body.shape, _request(model, body))
    if body.layers and body.layers[0].group is not None:
        found: list[_Part] = []
        for layer in body.layers:
            own = form.of_group(layer.group)
            if own.blocks:
                found.append((layer.material, crossings_of(own, place), low, high))
        return found
    crossings = crossings_of(form, place)
    hit = crossings.hit()
    if len(hit) == 0:
        return []
    bounds = _bounds(model, number, position[hit], low[hit], high[hit])
    parts = []
    for name, bottom, top in bounds:
        ends = low.copy(), low.copy()
        ends[0][hit], ends[1][hit] = bottom, top
        parts.append((name, crossings, *ends))
    return parts


def _horizons(
    model: Model, key: str, number: int, position: Floats, low: Floats, high: Floats
) -> list[tuple[str, Floats, Floats]]:
    """Returns the layers of the points' own body, continued to the ground."""
    body = model.bodies[number]
    densities = {model.materials[name].density for name in body.materials}
    if len(densities) > 1 and body.layers[0].group is not None:
        raise BadInput(
            "layers that are groups of a mesh have no horizons that continue to the ground",
            "leave it out: the weight is then that of the mesh",
            key=f"{key}.ground",
        )
    return _bounds(model, number, position, low, high)


def _bounds(
    model: Model, number: int, position: Floats, low: Floats, high: Floats
) -> list[tuple[str, Floats, Floats]]:
    """Returns material, lower and upper end of each layer of a body between two heights, (n,)."""
    body, top, found = model.bodies[number], high, []
    for i, name in enumerate(body.materials):
        bottom = low
        if body.layers and (declared := body.layers[i].bottom) is not None:
            horizon = elevation(declared, position, f"bodies[{number}].layers[{i}].bottom")
            bottom = np.minimum(np.maximum(horizon, low), top)
        found.append((name, bottom, np.maximum(top, bottom)))
        top = bottom
    return found


def _request(model: Model, body: Body) -> Request:
    return requested(body, model.analysis.kind, background_grid(model))


def _require_below(position: Floats, ground: Floats, key: str, entry: AtRest) -> None:
    above = position[:, -1] - ground
    if (above > 0.0).any():
        worst = int(above.argmax())
        raise BadInput(
            f"the point at {place_text(position[worst])} lies above the ground, which is at "
            f"{ground[worst]:.6g} there",
            "give the height of the ground's surface, or leave it out",
            key=f"{key}.ground",
            value=entry.ground,
        )


def _gravity(model: Model, key: str) -> float:
    """Returns the downward acceleration at time 0 [length / time^2]."""
    total = np.zeros(model.dimension)
    for _, load in model.acting_loads():
        if isinstance(load, BodyForce):
            total += model.load_curve(load).factor(0.0) * np.asarray(load.acceleration)
    if np.any(total[:-1]) or total[-1] > 0.0:
        raise BadInput(
            f"the body force at time 0, {place_text(total)}, does not act downwards only",
            'give the stress as type = "gravity" or "given", or a vertical body force',
            key=f"{key}.type",
            value="k0",
        )
    if total[-1] == 0.0:
        raise BadInput(
            "no body force acts at time 0, so the stress would not be in equilibrium",
            "add a load of the type body_force, with its whole factor from the start: "
            "factor = [[0, 1], [1, 1]]",
            key=f"{key}.type",
            value="k0",
        )
    return float(-total[-1])
