# SPDX-License-Identifier: BSD-3-Clause
"""Materials: parameters with unit and range; none has a default."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from tilth.arrays import Floats
from tilth.errors import Problem
from tilth.model.base import chosen_by
from tilth.model.cam_clay import ModifiedCamClay
from tilth.model.isotropic import Columns, Isotropic, ParametersAt, WithPoreFluid
from tilth.model.laws import Law
from tilth.model.parameter_kinds import Kind, Values
from tilth.model.problems import dotted, rejection
from tilth.model.soils import DruckerPrager, MohrCoulomb, Tresca
from tilth.model.user_laws import UserCompiled, UserPython, UserUmat
from tilth.model.variation import VaryingNotNegative, VaryingPositive


class HenckyElastic(WithPoreFluid):
    """Linear relation of Kirchhoff stress and logarithmic (Hencky) elastic strain."""

    model: Literal["hencky_elastic"] = "hencky_elastic"


class VonMises(Isotropic):
    """Hencky elasticity with the von Mises yield condition and linear isotropic hardening.

    Exactly one of `yield_stress`, `deviatoric_radius` and `undrained_shear_strength` gives the size
    of the yield cylinder.
    """

    is_plastic: ClassVar[bool] = True
    has_shear_strength: ClassVar[bool] = True

    model: Literal["von_mises"] = "von_mises"
    yield_stress: VaryingPositive | None = None
    """Initial uniaxial yield stress [stress], > 0."""
    deviatoric_radius: VaryingPositive | None = None
    """Radius |s| of the initial yield cylinder [stress], > 0: sqrt(2/3) of the yield stress."""
    undrained_shear_strength: VaryingPositive | None = None
    """Initial strength s_u in plane strain and simple shear [stress], > 0: the yield stress is
    sqrt(3) s_u. In triaxial compression the strength, half the deviator, is sqrt(3)/2 s_u."""
    hardening_modulus: VaryingNotNegative
    """d(yield stress) / d(equivalent plastic strain) [stress], >= 0; 0 is perfectly plastic."""

    kinds: ClassVar[Mapping[str, Kind]] = {
        **Isotropic.kinds,
        "yield_stress": "strength",
        "deviatoric_radius": "strength",
        "undrained_shear_strength": "strength",
        "hardening_modulus": "hardening",
    }

    @model_validator(mode="after")
    def _one_strength(self) -> Any:
        given = [key for key in _TO_YIELD_STRESS if getattr(self, key) is not None]
        if len(given) != 1:
            what = f"given together with `{given[0]}`" if given else "missing"
            remedy = (
                "give exactly one of `yield_stress` (uniaxial), `deviatoric_radius` (radius of the "
                "yield cylinder, sqrt(2/3) of the yield stress) and `undrained_shear_strength` "
                "(in plane strain, 1/sqrt(3) of the yield stress)"
            )
            raise rejection([Problem(given[-1] if given else "yield_stress", what, remedy)])
        return self

    @property
    def initial_yield_stress(self) -> float:
        """Initial uniaxial yield stress [stress], whichever of the three parameters was given."""
        return self.parameter("yield_stress")

    def law_parameters(self, at: ParametersAt) -> dict[str, Values]:
        """Returns the parameters of the law; see `Isotropic`."""
        key = next(key for key in _TO_YIELD_STRESS if getattr(self, key) is not None)
        return {
            **self.elastic_parameters(at),
            "yield_stress": _TO_YIELD_STRESS[key] * at.value(key),
            "hardening_modulus": at.value("hardening_modulus"),
        }

    def shear_strength(self, parameters: Columns, plastic_strain: Floats) -> tuple[Values, Values]:
        """Returns that in simple shear, the hardened yield stress over sqrt(3); see `AnyMaterial`.

        In simple shear |s|^2 = 2 tau^2, and yielding is at |s| = sqrt(2/3) sigma_y.
        """
        hardened = parameters["yield_stress"] + parameters["hardening_modulus"] * plastic_strain
        return hardened / math.sqrt(3.0), 0.0


_TO_YIELD_STRESS = {
    "yield_stress": 1.0,
    "deviatoric_radius": math.sqrt(1.5),
    "undrained_shear_strength": math.sqrt(3.0),
}


Material = Annotated[
    HenckyElastic
    | VonMises
    | Tresca
    | MohrCoulomb
    | DruckerPrager
    | ModifiedCamClay
    | UserPython
    | UserCompiled
    | UserUmat,
    Field(discriminator="model"),
    chosen_by(
        "model", HenckyElastic, VonMises, Tresca, MohrCoulomb, DruckerPrager, ModifiedCamClay,
        UserPython, UserCompiled, UserUmat,
    ),
]  # fmt: skip


def codes_of(materials: Mapping[str, Material]) -> tuple[str, ...]:
    """Returns the laws of the user that materials name, as "file:name", each once."""
    codes = (material.code for material in materials.values())
    return tuple(dict.fromkeys(code for code in codes if code))


def laws_of(materials: Mapping[str, Material]) -> dict[str, Law]:
    """Returns the laws of materials by their names; runs the code of the user.

    Raises:
        BadInput: a law of the user cannot be loaded.
    """
    return {name: each.law_at(dotted(("materials", name))) for name, each in materials.items()}
