# SPDX-License-Identifier: BSD-3-Clause
"""Implicit boundaries: essential conditions on geometries that need not follow grid lines."""
