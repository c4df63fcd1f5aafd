# SPDX-License-Identifier: BSD-3-Clause
"""Mass and stresses of material points in water."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.errors import BadInput
from tilth.model import BodyForce, Model
from tilth.model.laws import EXCESS_PORE_PRESSURE
from tilth.model.problems import dotted
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import PRESSURE, VELOCITY
from tilth.mpm.water import PhreaticSurface, half_extents, wet_share
from tilth.variation.tables import place_text


def pore_mass(points: MaterialPoints) -> Floats:
    """Returns the mass that points have in addition below the water [mass], shape (n,).

    Of the initial volume, as `MaterialPoints.mass`; 0 where no density below the water is declared.
    """
    mass = np.zeros(len(points))
    for range_ in points.ranges:
        if range_.wet_density is not None:
            added = range_.wet_density - range_.density
            mass[range_.points] = added * points.initial_volume[range_.points]
    return mass


def total_mass(points: MaterialPoints, water: PhreaticSurface | None, time: float) -> Floats:
    """Returns the mass of points at a time, with that of the water in them [mass], shape (n,)."""
    if water is None:
        return points.mass
    planes = water.planes(points.position, time)
    share, _ = wet_share(planes.depth, half_extents(points, planes.direction))
    return np.asarray(points.mass + share * pore_mass(points))


def without_wet_density(points: MaterialPoints, wet: Flags) -> int | None:
    """Returns a point of those chosen whose material has no density below the water, or None.

    wet: which points are below the water, shape (n,).
    """
    for range_ in points.ranges:
        if range_.wet_density is None and (found := np.flatnonzero(wet[range_.points])).size:
            return range_.start + int(found[0])
    return None


def require_wet_densities(model: Model, points: MaterialPoints) -> None:
    """Checks that soil below the water has a density there, if a body force or inertia acts.

    With the water as it is at the start and at the end of the model's schedule, on points as they
    are.

    Raises:
        BadInput: a material below the water has neither a `saturated_density` nor is `watertight`,
            or a point lies beside the polyline or the grid of a level.
    """
    surface = PhreaticSurface.of(model)
    if surface is None:
        return
    surface.require_covers(points.position)
    has_weight = any(isinstance(load, BodyForce) for _, load in model.acting_loads())
    if not has_weight and not model.analysis.has_mass:
        return
    acts = "a body force acts" if has_weight else "it has inertia"
    for time in (0.0, model.schedule.end):
        planes = surface.planes(points.position, time)
        share, _ = wet_share(planes.depth, half_extents(points, planes.direction))
        if (dry := without_wet_density(points, share > 0.0)) is not None:
            body = next(each for each in points.ranges if each.start <= dry < each.stop)
            name = model.bodies[body.body].materials[body.layer]
            raise BadInput(
                f"missing, but at time {time:g} the body {body.name!r} of this material is below "
                f"the water at {place_text(points.position[dry])}, where {acts}",
                "give the mass per volume with full pores, or watertight = true for a material "
                "that water does not enter",
                key=dotted(("materials", name, "saturated_density")),
            )


def pore_pressure(points: MaterialPoints, water: PhreaticSurface | None, time: float) -> Floats:
    """Returns the pressure of the water at rest and, where it flows, its excess [stress], (n,).

    Compression positive; 0 without water. The pressure of an undrained law's own pore fluid is not
    in it.
    """
    pressure = np.zeros(len(points))
    if water is not None:
        pressure = water.pore_pressure(points.position, time)
    if points.has_flow:
        pressure = pressure + points.water[:, PRESSURE]
    return pressure


def excess_pore_pressure(points: MaterialPoints) -> Floats:
    """Returns the excess pore pressure of points [stress], compression positive, shape (n,).

    Where water flows that over the water at rest; elsewhere the state variable of undrained laws,
    "not a number" for other ones.
    """
    excess = points.state_variable(EXCESS_PORE_PRESSURE)
    if points.has_flow:
        excess = np.where(points.conducts, points.water[:, PRESSURE], excess)
    return excess


def darcy_velocity(points: MaterialPoints) -> Floats:
    """Returns the water's velocity relative to the soil, per area of soil [length/time], (n, dim).

    That at the end of the last step; "not a number" where no water enters.
    """
    velocity = points.water[:, VELOCITY : VELOCITY + points.position.shape[1]]
    return np.where(points.conducts[:, None], velocity, np.nan)


def effective_stress(points: MaterialPoints) -> Floats:
    """Returns the effective Cauchy stress of points [stress], tension positive, shape (n, 6).

    That of the laws; of undrained laws without the pressure of their pore fluid.
    """
    stress = points.stress.copy()
    if EXCESS_PORE_PRESSURE in points.state_variables():
        excess = np.nan_to_num(points.state_variable(EXCESS_PORE_PRESSURE))
        stress[:, :3] += (excess / points.stress_jacobian)[:, None]
    return stress


def total_stress(points: MaterialPoints, water: PhreaticSurface | None, time: float) -> Floats:
    """Returns the total Cauchy stress of points [stress], tension positive, shape (n, 6).

    That of the laws less the pore pressure of the water at rest and of that which flows.
    """
    if water is None and not points.has_flow:
        return points.stress
    stress = points.stress.copy()
    stress[:, :3] -= pore_pressure(points, water, time)[:, None]
    return stress
