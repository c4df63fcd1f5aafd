# SPDX-License-Identifier: BSD-3-Clause
"""Curves in the plane: chains of points, and cubic splines with quadrature on a grid."""

from tilth.curves.chain import BadSurface, Chain
from tilth.curves.spline import LocalCubicSpline

__all__ = ["BadSurface", "Chain", "LocalCubicSpline"]
