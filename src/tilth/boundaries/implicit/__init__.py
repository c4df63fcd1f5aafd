# SPDX-License-Identifier: BSD-3-Clause
"""Implicit boundaries: essential conditions anywhere, independent of the grid's lines."""
