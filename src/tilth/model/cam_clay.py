# SPDX-License-Identifier: BSD-3-Clause
"""Modified Cam Clay."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, model_validator

from tilth.errors import Problem
from tilth.model.fields import Real
from tilth.model.isotropic import ParametersAt, PoissonRatio, PoreFluid
from tilth.model.parameter_kinds import Kind, Values
from tilth.model.problems import reject, rejection
from tilth.model.variation import VaryingPositive, or_varying

LARGEST_INDEX = 0.9
"""Compression index, at most [-]."""


def _index(value: float) -> float:
    if not 0.0 < value <= LARGEST_INDEX:
        remedy = (
            "it is the slope of ln(volume) over ln(p): lambda / (1 + e) of a line in e and ln(p)"
        )
        raise reject(f"must be greater than 0 and at most {LARGEST_INDEX:g}", remedy)
    return value


def _at_least_one(value: float) -> float:
    if value < 1.0:
        raise reject("must be at least 1: the stress would lie outside the yield surface")
    return value


if TYPE_CHECKING:
    Index = Real
    OverconsolidationRatio = Real
else:
    Index = or_varying(Annotated[Real, AfterValidator(_index)])
    """Slope of ln(volume) over ln(mean effective stress) [-]."""
    OverconsolidationRatio = or_varying(Annotated[Real, AfterValidator(_at_least_one)])


class ModifiedCamClay(PoreFluid):
    """Modified Cam Clay: critical-state plasticity with a stiffness that follows the pressure.

    The material cannot be without stress: give its bodies an initial one.
    """

    is_plastic: ClassVar[bool] = True
    needs_stress: ClassVar[bool] = True

    model: Literal["modified_cam_clay"] = "modified_cam_clay"
    compression_index: Index
    """Slope lambda* of the normal compression line, -d ln(volume) / d ln(p) with the mean effective
    Cauchy stress p [-], > 0: lambda / (1 + e) of a line in the void ratio e and ln(p)."""
    swelling_index: Index
    """Slope kappa* of unloading and reloading lines [-], > 0 and smaller than lambda*."""
    critical_state_slope: VaryingPositive
    """Slope M = q / p of the critical state line [-], > 0: 6 sin(phi) / (3 - sin(phi)) of the
    friction angle in triaxial compression."""
    shear_modulus: VaryingPositive | None = None
    """Constant elastic shear modulus [stress], > 0; this or `poisson_ratio`."""
    poisson_ratio: PoissonRatio | None = None
    """Poisson's ratio of isotropic states [-], -1 < nu < 0.5: the shear modulus follows the
    pressure; this or `shear_modulus`."""
    overconsolidation_ratio: OverconsolidationRatio | None = None
    """Size of the yield surface over that through the initial stress [-], >= 1; this or
    `preconsolidation_pressure`, or neither where [[initial.stress]] gives the overconsolidation."""
    preconsolidation_pressure: VaryingPositive | None = None
    """Mean effective stress at the tip of the initial yield surface [stress], > 0."""

    kinds: ClassVar[Mapping[str, Kind]] = {
        **PoreFluid.kinds,
        "compression_index": "strain",
        "compression_slope": "strain",
        "swelling_index": "strain",
        "swelling_slope": "strain",
        "critical_state_slope": "friction slope",
        "shear_modulus": "stiffness",
        "shear_modulus_ratio": "per strain",
        "poisson_ratio": "dimensionless",
        "overconsolidation_ratio": "overconsolidation",
        "preconsolidation_pressure": "preconsolidation",
        "reference_pressure": "stress",
    }
    state_kinds: ClassVar[Mapping[str, Kind]] = {
        **PoreFluid.state_kinds,
        "preconsolidation_pressure": "preconsolidation",
    }

    @property
    def dilates(self) -> bool:
        """Whether the volume changes in plastic flow, as it does if water can leave."""
        return not self.keeps_water

    @property
    def has_preconsolidation(self) -> bool:
        """Whether the material itself gives its preconsolidation."""
        given = (self.overconsolidation_ratio, self.preconsolidation_pressure)
        return any(each is not None for each in given)

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        problems = []
        for one, other in (
            ("shear_modulus", "poisson_ratio"),
            ("overconsolidation_ratio", "preconsolidation_pressure"),
        ):
            given = [key for key in (one, other) if getattr(self, key) is not None]
            if not given and one == "overconsolidation_ratio":
                continue  # the initial stress may give it: initial_checks.py
            if len(given) != 1:
                what = f"given together with `{one}`" if given else "missing"
                remedy = f"give exactly one of `{one}` and `{other}`"
                problems.append(Problem(given[-1] if given else one, what, remedy))
        swelling, compression = self.swelling_index, self.compression_index
        both = isinstance(swelling, float) and isinstance(compression, float)
        if both and swelling >= compression:
            what = f"must be smaller than `compression_index` ({compression:g})"
            remedy = "a fifth to a tenth of it is usual"
            problems.append(Problem("swelling_index", what, remedy, swelling))
        problems += self._bounded_ratio()
        if problems:
            raise rejection(problems)
        return self

    def _bounded_ratio(self) -> Iterator[Problem]:
        """The elastic energy with a Poisson's ratio is convex up to a ratio q / p only."""
        nu, slope = self.poisson_ratio, self.critical_state_slope
        if not isinstance(nu, float) or not isinstance(slope, float):
            return
        greatest = 1.5 * math.sqrt((1.0 - 2.0 * nu) / (1.0 + nu))
        if slope >= greatest:
            what = (
                f"allows elastic states up to q / p = {greatest:.3g} only, less than "
                f"`critical_state_slope` ({slope:g})"
            )
            remedy = "give a smaller Poisson's ratio, or `shear_modulus` instead"
            yield Problem("poisson_ratio", what, remedy, nu)

    def law_parameters(self, at: ParametersAt) -> dict[str, Values]:
        """Returns the parameters of the law; see `AnyMaterial`.

        With the Kirchhoff stress P = p J a slope of ln(volume) over ln(p) of lambda* is one of
        lambda* / (1 - lambda*) over ln(P).
        """
        compression, swelling = at.value("compression_index"), at.value("swelling_index")
        kappa = swelling / (1.0 - swelling)
        modulus: Values = 0.0
        ratio: Values = 0.0
        if self.poisson_ratio is None:
            modulus = at.value("shear_modulus")
        else:
            nu = at.value("poisson_ratio")
            ratio = 1.5 * (1.0 - 2.0 * nu) / (1.0 + nu) / kappa
        if self.overconsolidation_ratio is not None:
            consolidation = at.value("overconsolidation_ratio")
        else:  # of the material, or of the initial stress
            consolidation = -at.value("preconsolidation_pressure")
        parameters = {
            "compression_slope": compression / (1.0 - compression),
            "swelling_slope": kappa,
            "critical_state_slope": at.value("critical_state_slope"),
            "shear_modulus": modulus,
            "shear_modulus_ratio": ratio,
            "overconsolidation_ratio": consolidation,
            "reference_pressure": 1.0,  # of no influence: it only fixes where strains are zero
        }
        return self.with_fluid(parameters, at)
