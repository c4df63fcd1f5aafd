# SPDX-License-Identifier: BSD-3-Clause
"""Materials: parameters with unit and range; none has a default."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Field, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared, chosen_by
from tilth.model.fields import NotNegative, Positive, Real
from tilth.model.problems import reject, rejection


def _poisson_ratio(value: float) -> float:
    if not -1.0 < value < 0.5:
        raise reject(
            "must be greater than -1 and smaller than 0.5",
            "for a nearly incompressible material choose a value such as 0.49",
        )
    return value


PoissonRatio = Annotated[Real, AfterValidator(_poisson_ratio)]


class _Isotropic(Declared):
    is_plastic: ClassVar[bool] = False
    """Whether the law yields; the stresses then depend on the path of loading."""
    young_modulus: Positive
    """Young's modulus of the law for Kirchhoff stress and logarithmic strain [stress], > 0."""
    poisson_ratio: PoissonRatio
    """Poisson's ratio [-], -1 < nu < 0.5."""
    density: NotNegative | None = None
    """Mass per initial volume [mass / length^3], >= 0; required if a body force acts."""

    def parameter(self, name: str) -> float:
        """Returns the value of a parameter by its name in the core's material of this model."""
        return float(getattr(self, name))


class HenckyElastic(_Isotropic):
    """Linear relation of Kirchhoff stress and logarithmic (Hencky) elastic strain."""

    model: Literal["hencky_elastic"] = "hencky_elastic"


class VonMises(_Isotropic):
    """Hencky elasticity with the von Mises yield condition and linear isotropic hardening.

    Exactly one of `yield_stress` and `deviatoric_radius` gives the size of the yield cylinder.
    """

    is_plastic: ClassVar[bool] = True

    model: Literal["von_mises"] = "von_mises"
    yield_stress: Positive | None = None
    """Initial uniaxial yield stress [stress], > 0."""
    deviatoric_radius: Positive | None = None
    """Radius |s| of the initial yield cylinder [stress], > 0: sqrt(2/3) of the yield stress."""
    hardening_modulus: NotNegative
    """d(yield stress) / d(equivalent plastic strain) [stress], >= 0; 0 is perfectly plastic."""

    @model_validator(mode="after")
    def _one_strength(self) -> Any:
        given = (self.yield_stress is not None) + (self.deviatoric_radius is not None)
        if given != 1:
            raise rejection(
                [
                    Problem(
                        "yield_stress",
                        "missing" if given == 0 else "given together with `deviatoric_radius`",
                        "give exactly one of `yield_stress` (uniaxial) and `deviatoric_radius` "
                        "(radius of the yield cylinder, sqrt(2/3) of the yield stress)",
                    )
                ]
            )
        return self

    @property
    def initial_yield_stress(self) -> float:
        """Initial uniaxial yield stress [stress], whichever of the two parameters was given."""
        if self.yield_stress is not None:
            return self.yield_stress
        assert self.deviatoric_radius is not None
        return math.sqrt(1.5) * self.deviatoric_radius

    def parameter(self, name: str) -> float:
        """Returns a parameter by its name in the core; the yield stress is the uniaxial one."""
        return self.initial_yield_stress if name == "yield_stress" else super().parameter(name)


Material = Annotated[
    HenckyElastic | VonMises,
    Field(discriminator="model"),
    chosen_by("model", HenckyElastic, VonMises),
]
