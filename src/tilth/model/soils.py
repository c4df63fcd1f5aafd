# SPDX-License-Identifier: BSD-3-Clause
"""Soils with Tresca's, Mohr and Coulomb's and Drucker and Prager's strength."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, model_validator

from tilth.arrays import Floats
from tilth.errors import Problem
from tilth.model.davis import DavisForm, davis_share
from tilth.model.fields import Flag, Real
from tilth.model.isotropic import Columns, Isotropic, ParametersAt, WithPoreFluid
from tilth.model.laws import Law, laws
from tilth.model.parameter_kinds import Kind, Values, reduced_angle
from tilth.model.problems import reject, rejection
from tilth.model.variation import VaryingNotNegative, VaryingPositive, or_varying

STEEPEST = 60.0
"""Greatest friction angle [degrees]."""

FLATTEST = 1e-3
"""Least friction angle that is not zero [degrees]: the apex of a flatter cone is lost in round-off.
"""

LEAST_DILATION = 1.0
"""Dilation angle from which on flow does not keep the volume nearly [degrees]."""

NO_CUT_OFF = sys.float_info.max
"""Tension cut-off of the core's laws without one [stress]."""


def _steepness(value: float) -> float:
    if value != 0.0 and not FLATTEST <= value <= STEEPEST:
        raise reject(
            f"must be 0 or between {FLATTEST:g} and {STEEPEST:g} degrees",
            "give the angle in degrees, not in radians",
        )
    return value


if TYPE_CHECKING:
    SoilAngle = Real
else:
    SoilAngle = or_varying(Annotated[Real, AfterValidator(_steepness)])
    """Angle of friction or dilation [degrees]."""


class Tresca(Isotropic):
    """Hencky elasticity with Tresca's yield condition: undrained clay in terms of total stress."""

    is_plastic: ClassVar[bool] = True
    has_shear_strength: ClassVar[bool] = True

    model: Literal["tresca"] = "tresca"
    undrained_shear_strength: VaryingPositive
    """Strength s_u [stress], > 0: half the difference of the largest and the smallest principal
    stress, 2 s_u = tau_1 - tau_3, in plane strain as in triaxial tests."""

    kinds: ClassVar[Mapping[str, Kind]] = {
        **Isotropic.kinds,
        "undrained_shear_strength": "strength",
    }

    def shear_strength(self, parameters: Columns, plastic_strain: Floats) -> tuple[Values, Values]:
        """Returns s_u and 0; see `AnyMaterial`."""
        return parameters["undrained_shear_strength"], 0.0


class _Frictional(WithPoreFluid):
    is_plastic: ClassVar[bool] = True
    has_shear_strength: ClassVar[bool] = True

    cohesion: VaryingNotNegative
    """Cohesion c [stress], >= 0."""
    friction_angle: SoilAngle
    """Friction angle phi [degrees], 0 to 60."""
    dilation_angle: SoilAngle
    """Dilation angle psi [degrees], 0 to phi; psi = phi is associated flow."""
    separates: Flag | None = None
    """Whether the soil remembers the volume that it gains at the apex, where it is pulled apart:
    the state variable `void_strain` is the logarithm of it, and the soil bears no more pressure
    until it is closed. For free flight and run-out; the volume is forgotten if not given.
    """

    kinds: ClassVar[Mapping[str, Kind]] = {
        **WithPoreFluid.kinds,
        "cohesion": "strength",
        "friction_angle": "friction angle",
        "dilation_angle": "dilation angle",
        "tension_cut_off": "strength",
    }
    state_kinds: ClassVar[Mapping[str, Kind]] = {
        **WithPoreFluid.state_kinds,
        "void_strain": "strain",
    }

    @property
    def law(self) -> Law:
        """The law of the core; see `PoreFluid`."""
        return laws()[f"separating_{self.model}"] if self.separates else super().law

    @property
    def dilates(self) -> bool:
        """Whether the volume changes in plastic flow: by the dilation angle, if water can enter."""
        psi = self.dilation_angle
        return not self.keeps_water and not (isinstance(psi, float) and psi < LEAST_DILATION)

    def equivalent(self, davis: DavisForm | None) -> DavisForm | None:
        """Returns the form of Davis' equivalent; None where the pores stay full.

        Soil that cannot change its volume has none: it flows like a Tresca material, and with psi =
        phi its pore pressure would fall, and its strength grow, without end.
        """
        return davis if self.pore_fluid_bulk_modulus is None else None

    def separation_problems(self, cut_off: object) -> Iterator[Problem]:
        """Yields what does not go with `separates`.

        cut_off: the declared tension cut-off.
        """
        if not self.separates:
            return
        if self.friction_angle == 0.0:
            what = "needs an apex, which soil without friction does not have"
            yield Problem("separates", what, "give a friction angle, or leave it out", True)
        others = {
            "tension_cut_off": (cut_off, "soil that separates does so at its apex"),
            "pore_fluid_bulk_modulus": (
                self.pore_fluid_bulk_modulus, "soil whose pores stay full does not separate"
            ),
        }  # fmt: skip
        for key, (value, why) in others.items():
            if value is not None:
                remedy = f"leave out one of the two: {why}"
                yield Problem(key, "is given together with `separates`", remedy, value)

    def angle_problems(self) -> Iterator[Problem]:
        """Yields the problems between the angles and the cohesion."""
        phi, psi, c = self.friction_angle, self.dilation_angle, self.cohesion
        if not all(isinstance(each, float) for each in (phi, psi, c)):
            return
        if psi > phi:
            what = f"is greater than the friction angle ({phi:g}): flow would produce energy"
            yield Problem("dilation_angle", what, "give 0 to the friction angle", psi)
        if phi == 0.0 and c == 0.0:
            what = "is zero together with the friction angle: the soil has no strength"
            yield Problem("cohesion", what, "give one of them a positive value", c)


class MohrCoulomb(_Frictional):
    """Hencky elasticity with the Mohr-Coulomb yield condition, non-associated flow and softening.

    The principal stresses end at a tension cut-off; the apex c cot(phi) is the largest one and the
    default.
    """

    model: Literal["mohr_coulomb"] = "mohr_coulomb"
    tension_cut_off: VaryingNotNegative | None = None
    """Greatest tensile principal stress [stress], >= 0; the apex c cot(phi) if not given or
    greater."""
    residual_cohesion: VaryingNotNegative | None = None
    """Cohesion after softening [stress], >= 0; that at the start if not given."""
    residual_friction_angle: SoilAngle | None = None
    """Friction angle after softening [degrees]; that at the start if not given."""
    softening_strain: VaryingPositive | None = None
    """Equivalent plastic strain at which the residual strength is reached in a shear band of the
    width `softening_length` [-], > 0; cohesion and angle decrease linearly up to it."""
    softening_length: VaryingPositive | None = None
    """Width of the shear band to which `softening_strain` belongs [length], > 0: in cells of the
    size h the strain is softening_strain * softening_length / h, so that the work in a band of one
    cell does not depend on the grid."""

    kinds: ClassVar[Mapping[str, Kind]] = {
        **_Frictional.kinds,
        "residual_cohesion": "strength",
        "residual_friction_angle": "friction angle",
        "softening_strain": "strain",
        "softening_length": "length",
    }

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        problems = [
            *self.angle_problems(),
            *self._softening_problems(),
            *self.separation_problems(self.tension_cut_off),
        ]
        if problems:
            raise rejection(problems)
        return self

    @property
    def softens(self) -> bool:
        """Whether the strength decreases with plastic strain."""
        return self.residual_cohesion is not None or self.residual_friction_angle is not None

    def _softening_problems(self) -> Iterator[Problem]:
        for key in ("softening_strain", "softening_length"):
            value = getattr(self, key)
            if self.softens and value is None:
                remedy = "strength that falls with plastic strain needs the strain and the length"
                yield Problem(key, "missing", remedy)
            elif not self.softens and value is not None:
                what = "is of no use without a residual strength"
                remedy = "give `residual_cohesion` or `residual_friction_angle`, or leave it out"
                yield Problem(key, what, remedy, value)
        for key in ("cohesion", "friction_angle"):
            start, end = getattr(self, key), getattr(self, f"residual_{key}")
            if isinstance(start, float) and isinstance(end, float) and end > start:
                what = f"is greater than `{key}` ({start:g}): that would be hardening"
                yield Problem(f"residual_{key}", what, f"give 0 to {start:g}", end)
        residual, psi = self.residual_friction_angle, self.dilation_angle
        if isinstance(residual, float) and isinstance(psi, float) and psi > residual:
            what = f"is smaller than the dilation angle ({psi:g}): flow would produce energy"
            remedy = "give at least the dilation angle, or a smaller `dilation_angle`"
            yield Problem("residual_friction_angle", what, remedy, residual)

    def law_parameters(self, at: ParametersAt) -> dict[str, Values]:
        """Returns the parameters of the law; see `Isotropic`."""
        entries = {name: at.value(name) for name in ("cohesion", "friction_angle")}
        strain: Values = 1.0
        if self.softens:
            strain = at.value("softening_strain") * at.value("softening_length") / at.cell_length
        residual = {
            f"residual_{name}": value
            if getattr(self, f"residual_{name}") is None
            else at.value(f"residual_{name}")
            for name, value in entries.items()
        }
        parameters = {
            **self.elastic_parameters(at),
            **entries,
            "dilation_angle": at.value("dilation_angle"),
            "tension_cut_off": _cut_off(self.tension_cut_off, at),
            **residual,
            "softening_strain": strain,
        }
        return self.with_fluid(parameters, at)

    def reduced_strength(
        self, parameters: Columns, factor: float, davis: DavisForm | None = None
    ) -> Columns:
        """Divides c, tan(phi), also after softening, and the cut-off; see `AnyMaterial`.

        The dilation angle is kept, but not above the reduced friction angles; in Davis' equivalent
        it is the smaller one of these.
        """
        form, psi = self.equivalent(davis), parameters["dilation_angle"]
        divided: dict[str, Values] = {}
        for when in ("", "residual_"):
            cohesion, phi = f"{when}cohesion", f"{when}friction_angle"
            angles = np.radians(parameters[phi]), np.radians(psi)
            divisor = factor / davis_share(*angles, factor, form)
            divided[cohesion] = parameters[cohesion] / divisor
            divided[phi] = reduced_angle(parameters[phi], divisor)
        least = np.minimum(divided["friction_angle"], divided["residual_friction_angle"])
        return {
            **parameters,
            **divided,
            "dilation_angle": np.minimum(psi, least) if form is None else least,
            "tension_cut_off": _reduced_cut_off(parameters["tension_cut_off"], factor),
        }

    def shear_strength(self, parameters: Columns, plastic_strain: Floats) -> tuple[Values, Values]:
        """Returns the present, perhaps softened c and tan(phi); see `AnyMaterial`.

        The plane is one on which the soil fails, so that its strength is c + p tan(phi) (Coulomb).
        """
        softened = np.minimum(plastic_strain / parameters["softening_strain"], 1.0)
        cohesion, angle = (
            parameters[name] + softened * (parameters[f"residual_{name}"] - parameters[name])
            for name in ("cohesion", "friction_angle")
        )
        return cohesion, np.tan(np.radians(angle))


class DruckerPrager(_Frictional):
    """Hencky elasticity with a circular cone as yield surface, and non-associated flow.

    The cone is fitted to the Mohr-Coulomb pyramid; the mean stress ends at a tension cut-off, of
    which the apex is the largest and the default.
    """

    model: Literal["drucker_prager"] = "drucker_prager"
    fit: Literal["compression", "extension", "plane_strain"]
    """Where cone and Mohr-Coulomb pyramid have the same strength: in triaxial "compression" (outer
    cone), triaxial "extension" (inner edges), or collapse in "plane_strain"."""
    tension_cut_off: VaryingNotNegative | None = None
    """Greatest tensile mean stress [stress], >= 0; the apex if not given or greater."""

    kinds: ClassVar[Mapping[str, Kind]] = {
        **_Frictional.kinds,
        "friction_slope": "friction slope",
        "dilation_slope": "dilation slope",
        "cone_strength": "strength",
    }

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        cut_off = self.tension_cut_off
        if problems := [*self.angle_problems(), *self.separation_problems(cut_off)]:
            raise rejection(problems)
        return self

    def law_parameters(self, at: ParametersAt) -> dict[str, Values]:
        """Returns the parameters of the law; see `Isotropic`."""
        sine, cosine = _sine_and_cosine(at.value("friction_angle"))
        flow, _ = _sine_and_cosine(at.value("dilation_angle"))
        parameters = {
            **self.elastic_parameters(at),
            **self._cone(sine, cosine, flow, at.value("cohesion")),
            "tension_cut_off": _cut_off(self.tension_cut_off, at),
        }
        return self.with_fluid(parameters, at)

    def _cone(self, sine: Values, cosine: Values, flow: Values, c: Values) -> dict[str, Values]:
        """Returns the cone of the declared fit.

        Args:
            sine, cosine: of the friction angle.
            flow: sine of the dilation angle.
            c: cohesion [stress].
        """
        if self.fit == "plane_strain":
            dilation = 3.0 * flow / np.sqrt(9.0 + 3.0 * flow**2)  # tan^2 = s^2 / (1 - s^2)
            divisor = np.sqrt(1.0 - dilation**2 / 3.0) + sine * dilation / 3.0
            slope, strength = sine / divisor, cosine / divisor
        else:
            divisor = np.sqrt(3.0) * (3.0 + self._sign * sine)
            slope, strength = 6.0 * sine / divisor, 6.0 * cosine / divisor
            dilation = 6.0 * flow / (np.sqrt(3.0) * (3.0 + self._sign * flow))
        return {
            "friction_slope": slope,
            "dilation_slope": dilation,
            "cone_strength": strength * c,
        }

    @property
    def _sign(self) -> float:
        """Sign of the sine in the fit to triaxial tests."""
        return -1.0 if self.fit == "compression" else 1.0

    def reduced_strength(
        self, parameters: Columns, factor: float, davis: DavisForm | None = None
    ) -> Columns:
        """Divides c and tan(phi) of the fitted pyramid and the cut-off; see `AnyMaterial`.

        The dilation angle is kept, but not above the reduced friction angle, which it is in Davis'
        equivalent.
        """
        form = self.equivalent(davis)
        c, sine, flow = self._pyramid(parameters)
        divisor = factor / davis_share(np.arcsin(sine), np.arcsin(flow), factor, form)
        tangent = sine / np.sqrt(1.0 - sine**2) / divisor
        cosine = 1.0 / np.sqrt(1.0 + tangent**2)
        sine = tangent * cosine
        flow = np.minimum(flow, sine) if form is None else sine
        return {
            **parameters,
            **self._cone(sine, cosine, flow, c / divisor),
            "tension_cut_off": _reduced_cut_off(parameters["tension_cut_off"], factor),
        }

    def shear_strength(self, parameters: Columns, plastic_strain: Floats) -> tuple[Values, Values]:
        """Returns c and tan(phi) of the pyramid to which the cone is fitted; see `AnyMaterial`."""
        c, sine, _ = self._pyramid(parameters)
        return c, sine / np.sqrt(1.0 - sine**2)

    def _pyramid(self, parameters: Columns) -> tuple[Values, Values, Values]:
        """Returns c [stress] and the sines of phi and psi of the declared fit's pyramid."""
        slope, dilation = parameters["friction_slope"], parameters["dilation_slope"]
        if self.fit == "plane_strain":
            flow = 3.0 * dilation / np.sqrt(9.0 - 3.0 * dilation**2)
            sine = slope * np.sqrt(1.0 - dilation**2 / 3.0) / (1.0 - slope * dilation / 3.0)
        else:
            flow, sine = (
                3.0 * each / (2.0 * np.sqrt(3.0) - self._sign * each) for each in (dilation, slope)
            )
        cosine = np.sqrt(1.0 - sine**2)
        c = parameters["cone_strength"] / self._cone(sine, cosine, flow, 1.0)["cone_strength"]
        return c, sine, flow


def _cut_off(given: object, at: ParametersAt) -> Values:
    return NO_CUT_OFF if given is None else at.value("tension_cut_off")


def _sine_and_cosine(degrees: Values) -> tuple[Values, Values]:
    angle = np.radians(degrees)
    return np.sin(angle), np.cos(angle)


def _reduced_cut_off(cut_off: Values, factor: float) -> Values:
    given = np.not_equal(cut_off, NO_CUT_OFF)
    return np.divide(cut_off, factor, out=np.array(cut_off, dtype=np.float64), where=given)
