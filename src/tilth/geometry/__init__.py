# SPDX-License-Identifier: BSD-3-Clause
"""Geometry of implicit boundaries: signed distance, facets and quadrature; one file per kind."""
