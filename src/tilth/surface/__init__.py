# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surfaces in the plane: chains of boundary points and the cubic spline through them."""

from tilth.surface.chain import BadSurface, Chain
from tilth.surface.spline import LocalCubicSpline

__all__ = ["BadSurface", "Chain", "LocalCubicSpline"]
