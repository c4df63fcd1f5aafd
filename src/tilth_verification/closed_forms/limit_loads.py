# SPDX-License-Identifier: BSD-3-Clause
"""Limit loads of rigid bodies in weightless clay, over its undrained shear strength s_u.

Bounds were computed by `benchmarks/limit_loads.py` with finite elements and linear programs: the
exact load lies between them, up to the chords of a pipe's circle (0.1 %).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

CIRCULAR_FOOTING: Mapping[str, float] = MappingProxyType({"smooth": 5.69, "rough": 6.05})
"""Mean pressure under a circular footing over s_u, Tresca clay.

Smooth: R.T. Shield, Q. Appl. Math. 13, 1955; A.D. Cox, G. Eason, H.G. Hopkins, Phil. Trans. R. Soc.
A 254, 1961. Rough: G. Eason, R.T. Shield, Z. Angew. Math. Phys. 11, 1960.
"""

DEEP_STRIP_ANCHOR = 3.0 * math.pi + 2.0
"""Force over s_u B of a thin rough plate deep in clay that does not separate from it, 11.42."""

SEABED_PIPE_BOUNDS: Mapping[tuple[float, str], tuple[float, float]] = MappingProxyType(
    {
        (0.1, "smooth"): (2.685, 2.738),
        (0.1, "rough"): (3.045, 3.119),
        (0.25, "smooth"): (3.620, 3.685),
        (0.25, "rough"): (4.412, 4.506),
        (0.5, "smooth"): (4.273, 4.358),
        (0.5, "rough"): (5.510, 5.673),
    }
)
"""(embedment w / D, face) -> bounds of V / (D s_u) of a pipe wished in place, the soil level.

The soil is in contact up to its level surface and may separate.
"""

DEEP_PIPE_BOUNDS: Mapping[float, tuple[float, float]] = MappingProxyType(
    {
        0.0: (9.193, 9.246),
        0.25: (10.079, 10.128),
        0.5: (10.777, 10.878),
        0.75: (11.364, 11.502),
        1.0: (11.782, 11.999),
    }
)
"""Adhesion over s_u -> bounds of F / (D s_u) of a pipe in deep clay that does not separate."""

LIFTED_PIPE_BOUNDS: Mapping[tuple[float, str], tuple[float, float]] = MappingProxyType(
    {(2.0, "smooth"): (3.163, 3.238), (2.0, "rough"): (4.659, 4.776)}
)
"""(depth of the centre over D, face) -> bounds of F / (D s_u) of a pipe that is lifted.

The soil separates from the pipe without tension. Limit analysis needs associated flow, in which a
rough face has its full shear strength at zero pressure, and dissipates where it slides as it opens.
A contact has no shear where it is open, so that its rough load is below these bounds.
"""


def shallow_sphere(ratio: float, face: str) -> float:
    """Returns the mean pressure under a shallow rigid sphere in fully plastic clay over s_u.

    5.69 - 1.50 a/R smooth, 6.05 - 0.45 a/R rough: fits within 0.003 to `benchmarks/slip_lines.py`,
    with the clay beside the contact as high as it is displaced. For a / R = 0 they are those of
    the footings; P is over pi a^2.

    Args:
        ratio: radius a of the contact over that of the sphere, at most 0.28 [-].
        face: "smooth" or "rough".
    """
    return CIRCULAR_FOOTING[face] - {"smooth": 1.50, "rough": 0.45}[face] * ratio


def strip_anchor_bound(thickness: float) -> float:
    """Returns an upper bound of F / (s_u B) of a rough plate deep in clay that stays closed.

    3 pi + 2 + 2 (1 + sqrt 2) t / B. The mechanism of the thin plate has a rigid wedge on either
    face, whose sides are at 45 degrees, and about each edge a fan of three quarters of a circle,
    radius B / sqrt 2, in which the clay flows with 1 / sqrt 2 of the velocity of the plate. It is
    parted at the level of the plate by a layer of the thickness t, in which the clay beside the
    plate sinks with that velocity: it slides along the side of the plate, and along the clay at
    rest.

    Args:
        thickness: t / B [-].
    """
    return DEEP_STRIP_ANCHOR + 2.0 * (1.0 + math.sqrt(2.0)) * thickness


def seabed_pipe(embedment: float, face: str) -> float:
    """Returns V / (D s_u) of a pipe wished in place, by fits to finite element results.

    5.3 (w/D)^0.25 smooth, 7.1 (w/D)^0.33 rough. Quoted from memory; the likely source is C.P.
    Aubeny, H. Shi, J.D. Murff, Int. J. Geomech. 5, 2005. By `SEABED_PIPE_BOUNDS` they are 2 % off
    at most from 0.25 D on, and 9 % above the upper bound at 0.1 D.

    Args:
        embedment: w / D [-].
        face: "smooth" or "rough".
    """
    factor, power = {"smooth": (5.3, 0.25), "rough": (7.1, 0.33)}[face]
    return float(factor * embedment**power)


def sphere_limit_pressure(rigidity: float) -> float:
    """Returns the limit pressure of a spherical cavity over s_u, 4/3 (1 + ln(G / s_u)).

    R. Hill, The Mathematical Theory of Plasticity, chapter V.2; see `CavityInClay`.

    Args:
        rigidity: G / s_u [-].
    """
    return 4.0 / 3.0 * (1.0 + math.log(rigidity))


def cone_factor(rigidity: float, anisotropy: float = 0.0, roughness: float = 0.0) -> float:
    """Returns N_kt of a cone of 60 degrees in Tresca clay.

    3.4 + 1.6 ln I_r - 1.9 Delta + 1.3 alpha.

    Q. Lu, M.F. Randolph, Y. Hu, I.C. Bugarski, A numerical study of cone penetration in clay,
    Geotechnique 54, 2004: a correlation to large-displacement finite elements. Quoted from memory:
    only the abstract was at hand, which has no numbers. Ir 100: 10.77, Ir 300: 12.53.

    Args:
        rigidity: I_r = G / s_u [-].
        anisotropy: Delta, the initial sigma_v - sigma_h over 2 s_u [-].
        roughness: alpha, shear stress on the cone over s_u, 0 to 1 [-].
    """
    return 3.4 + 1.6 * math.log(rigidity) - 1.9 * anisotropy + 1.3 * roughness
