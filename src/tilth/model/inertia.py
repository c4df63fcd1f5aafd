# SPDX-License-Identifier: BSD-3-Clause
"""Inertia: how an analysis integrates over time, and its damping."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import PlainValidator, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import NotNegative, Positive, real
from tilth.model.problems import reject, rejection


def _spectral_radius(value: Any) -> float:
    if 0.0 <= (number := real(value)) <= 1.0:
        return number
    raise reject("must be from 0 to 1")


SpectralRadius = Annotated[float, PlainValidator(_spectral_radius)]


class RayleighDamping(Declared):
    """Viscous damping that increases with mass and stiffness: C = mass M + stiffness K.

    Its share of critical damping at the circular frequency omega is mass / (2 omega) + stiffness
    omega / 2.
    """

    mass: NotNegative = 0.0
    """Factor of the mass [1/time]. It also slows down free fall and sliding blocks."""
    stiffness: NotNegative = 0.0
    """Factor of the elastic stiffness of the soil [time]: a viscosity of its volume and shear
    strain rates."""

    @model_validator(mode="after")
    def _damps(self) -> Any:
        if self.mass == 0.0 and self.stiffness == 0.0:
            what, remedy = "damps nothing", "give `mass` or `stiffness`, or leave `damping` out"
            raise rejection([Problem("", what, remedy)])
        return self


class Inertia(Declared):
    """Implicit integration of the equations of motion over the time of the schedule."""

    scheme: Literal["newmark", "generalised_alpha"]
    """"newmark" (the trapezoidal rule, which damps nothing) or "generalised_alpha" (Chung and
    Hulbert 1993), which damps vibrations that the time steps cannot follow, as those after an
    impact; both of order 2."""
    spectral_radius: SpectralRadius | None = None
    """For "generalised_alpha": what is left of the highest frequencies after each step [-], from 1
    (no damping) to 0 (all are gone after one step); at most 0.1 where soil strikes surfaces."""
    damping: RayleighDamping | None = None
    """Rayleigh damping; none if not given."""
    largest_error: Positive | None = None
    """Largest local error of the displacement in a step [cells]; a step with more is shortened, and
    shortened steps grow again up to those of the schedule. The run fails if `minimum_step` of the
    schedule is still too long. 0.001 is a common value; no limit if not given."""
    largest_motion: Positive | None = None
    """Largest displacement of a material point in a step [cells], as `largest_error`."""

    velocity_update: Literal["flip", "pic"] | None = None
    """Velocities of the points after a step: "flip" adds the change of the grid's one, and what
    the grid cannot represent is kept for ever; "pic" takes the grid's velocity, and it is lost. As
    the grid's velocities are projected with the consistent mass, both keep momentum and angular
    momentum. "pic" is for flow and impact, after which "flip" leaves points that rattle; "flip" if
    not given.
    """

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        needs = self.scheme == "generalised_alpha"
        if needs and self.spectral_radius is None:
            what, remedy = "missing", "give a number from 0 to 1; 0.8 damps little where it matters"
            raise rejection([Problem("spectral_radius", what, remedy)])
        if not needs and self.spectral_radius is not None:
            what = f'has no meaning with scheme = "{self.scheme}"'
            remedy = 'leave it out, or choose scheme = "generalised_alpha"'
            raise rejection([Problem("spectral_radius", what, remedy, self.spectral_radius)])
        return self
