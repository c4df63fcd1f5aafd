# SPDX-License-Identifier: BSD-3-Clause
"""Closed forms that the analyses are compared with, each with its derivation."""

from tilth_verification.closed_forms.ball import ConstrainedBall, PressurisedShell
from tilth_verification.closed_forms.cavity import CavityInClay, CylinderInSoil
from tilth_verification.closed_forms.column import SelfWeightColumn
from tilth_verification.closed_forms.cylinder import ThickCylinder
from tilth_verification.closed_forms.heave import Heave
from tilth_verification.closed_forms.homogeneous import (
    components,
    full_deformation_gradient,
    hencky_cauchy_stress,
    hencky_strain,
    proportional_von_mises,
)
from tilth_verification.closed_forms.moduli import Moduli
from tilth_verification.closed_forms.plastic_ring import PlasticRing
from tilth_verification.closed_forms.wet_column import WetColumn
from tilth_verification.closed_forms.widened_cylinder import WidenedCylinder

__all__ = [
    "CavityInClay",
    "ConstrainedBall",
    "CylinderInSoil",
    "Heave",
    "Moduli",
    "PlasticRing",
    "PressurisedShell",
    "SelfWeightColumn",
    "ThickCylinder",
    "WetColumn",
    "WidenedCylinder",
    "components",
    "full_deformation_gradient",
    "hencky_cauchy_stress",
    "hencky_strain",
    "proportional_von_mises",
]
