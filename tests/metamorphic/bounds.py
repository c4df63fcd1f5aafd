# SPDX-License-Identifier: BSD-3-Clause
"""How much the results of two copies of a model may differ."""

from __future__ import annotations

from metamorphic.models import Tree

DIFFERENCE = 1e-6
"""Largest relative difference of two copies that differ by round-off."""

OF_PATCHES = 0.25

AT_REST, DIES_OUT = 0.2, 0.5

HALVED, LEAST_OF_HALVED = 1.0, 1e-3

UNLOADED = 0.2


def patched(entries: Tree) -> float:
    """Largest relative difference of copies on grids that are turned or mirrored."""
    implicit = any(each["type"] == "implicit" for each in entries["boundaries"])
    if implicit or "rigid_bodies" in entries or "contact_pairs" in entries:
        return OF_PATCHES
    return DIFFERENCE
