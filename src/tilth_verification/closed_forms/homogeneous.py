# SPDX-License-Identifier: BSD-3-Clause
"""Homogeneous states: elastic for any F, von Mises for a log strain of constant direction."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.model import HenckyElastic, VonMises
from tilth_verification.closed_forms.moduli import Moduli


def full_deformation_gradient(deformation_gradient: npt.ArrayLike, kind: str) -> Floats:
    """Returns the 3x3 deformation gradients, shape (..., 3, 3), of an analysis of the given kind.

    Plane strain adds F_zz = 1; axisymmetry the hoop stretch of x = F X, which is F_rr. In three
    dimensions they are 3x3 already.
    """
    given = np.asarray(deformation_gradient, dtype=float)
    if kind == "3d":
        return given
    full = np.zeros((*given.shape[:-2], 3, 3))
    full[..., :2, :2] = given
    full[..., 2, 2] = given[..., 0, 0] if kind == "axisymmetric" else 1.0
    return full


def components(tensor: npt.ArrayLike) -> Floats:
    """Returns xx yy zz xy yz xz, shape (..., 6), of symmetric tensors (..., 3, 3)."""
    return np.asarray(tensor)[..., (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)]


def hencky_strain(deformation_gradient: npt.ArrayLike) -> Floats:
    """Returns the strain 1/2 ln(F F^T) of deformation gradients F, shape (..., 3, 3) both."""
    gradient = np.asarray(deformation_gradient, dtype=float)
    stretch, direction = np.linalg.eigh(gradient @ np.swapaxes(gradient, -1, -2))
    scaled = direction * (0.5 * np.log(stretch))[..., None, :]
    return np.asarray(scaled @ np.swapaxes(direction, -1, -2))


def hencky_cauchy_stress(
    deformation_gradient: npt.ArrayLike, material: HenckyElastic | VonMises
) -> Floats:
    """Returns the Cauchy stress [stress] of the elastic material at F, shape (..., 3, 3) both.

    sigma = (lambda tr(eps) I + 2 mu eps) / J with eps = 1/2 ln(F F^T): the Kirchhoff stress is
    linear in the logarithmic strain.
    """
    strain, moduli = hencky_strain(deformation_gradient), Moduli.of(material)
    trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None]
    kirchhoff = moduli.lame * trace * np.eye(3) + 2.0 * moduli.shear * strain
    return np.asarray(kirchhoff * np.exp(-trace))


def proportional_von_mises(log_strain: npt.ArrayLike, material: VonMises) -> tuple[Floats, Floats]:
    """Returns Kirchhoff stress (..., 3, 3), plastic strain (...) under proportional strain.

    log_strain: shape (..., 3, 3), the logarithmic strain eps = t E reached along
    F(t) = exp(t E) with a fixed symmetric E and t growing from zero, so that total, elastic and
    plastic strain all keep the principal axes and the deviatoric direction of E. Then the rate
    equations integrate to the radial law: with q_e = 2 mu sqrt(3/2) |dev eps| the plastic strain is
    p = <q_e - Y0> / (3 mu + H), and tau = K tr(eps) I + (1 - 3 mu p / q_e) 2 mu dev eps.
    The Cauchy stress is tau exp(-tr eps).
    """
    strain, moduli = np.asarray(log_strain, dtype=float), Moduli.of(material)
    volumetric = np.trace(strain, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    deviator = 2.0 * moduli.shear * (strain - volumetric / 3.0)
    mises = math.sqrt(1.5) * np.linalg.norm(deviator, axis=(-2, -1))
    excess = np.maximum(mises - material.initial_yield_stress, 0.0)
    plastic_strain = excess / (3.0 * moduli.shear + material.hardening_modulus)
    elastic_part = 1.0 - 3.0 * moduli.shear * plastic_strain / np.where(excess > 0.0, mises, 1.0)
    return moduli.bulk * volumetric + elastic_part[..., None, None] * deviator, plastic_strain
