# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of boundaries and bodies: quadrature points, pose, soil near them, multipliers."""
