# SPDX-License-Identifier: BSD-3-Clause
"""The list of reference problems: the examples by name, and what each is held to."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from tilth.verification import (
    collapse,
    cube_on_inclined_plane,
    end_loaded_cantilever,
    footing_on_spline,
    inclined_column,
    oedometer,
    plane_strain_block,
    pressurised_ring,
    rigid_footing_elastic,
    self_weight_column,
    slope,
    strip_footing,
    thick_cylinder,
    upsetting,
)
from tilth.verification.comparison import Comparison

PROBLEMS: dict[str, Callable[[bool], Iterator[Comparison]]] = {
    "self_weight_column": self_weight_column.comparisons,
    "end_loaded_cantilever": end_loaded_cantilever.comparisons,
    "collapse": collapse.comparisons,
    "plane_strain_block": plane_strain_block.comparisons,
    "oedometer": oedometer.comparisons,
    "thick_cylinder": thick_cylinder.comparisons,
    "cube_on_inclined_plane": cube_on_inclined_plane.comparisons,
    "rigid_footing_elastic": rigid_footing_elastic.comparisons,
    "inclined_column": inclined_column.comparisons,
    "slope": slope.comparisons,
    "strip_footing": strip_footing.comparisons,
    "upsetting": upsetting.comparisons,
    "pressurised_ring": pressurised_ring.comparisons,
    "footing_on_spline": footing_on_spline.comparisons,
}
"""Problem (the name of its folder in `examples`) -> its comparisons, given whether to run long."""
