# SPDX-License-Identifier: BSD-3-Clause
"""The list of reference problems: the examples by name, and what each is compared with."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from tilth.verification import (
    buried_pipe,
    collapse,
    cone_penetration,
    cooks_membrane,
    cube_on_inclined_plane,
    element_tests,
    end_loaded_cantilever,
    footing_on_spline,
    generalized_shear,
    hollow_sphere_limit,
    inclined_column,
    layered_footing,
    oedometer,
    plane_strain_block,
    pressure_cantilever,
    pressurised_ring,
    pressurised_sphere,
    random_field_slope,
    rigid_footing_elastic,
    rigid_sphere,
    self_weight_column,
    slope,
    square_footing,
    strip_footing,
    strip_footing_friction,
    submerged_block,
    thick_cylinder,
    upsetting,
)
from tilth.verification.comparison import Comparison

PROBLEMS: dict[str, Callable[[bool], Iterator[Comparison]]] = {
    "self_weight_column": self_weight_column.comparisons,
    "end_loaded_cantilever": end_loaded_cantilever.comparisons,
    "collapse": collapse.comparisons,
    "plane_strain_block": plane_strain_block.comparisons,
    "generalized_shear": generalized_shear.comparisons,
    "oedometer": oedometer.comparisons,
    "thick_cylinder": thick_cylinder.comparisons,
    "cube_on_inclined_plane": cube_on_inclined_plane.comparisons,
    "pressurised_sphere": pressurised_sphere.comparisons,
    "rigid_footing_elastic": rigid_footing_elastic.comparisons,
    "inclined_column": inclined_column.comparisons,
    "slope": slope.comparisons,
    "strip_footing": strip_footing.comparisons,
    "strip_footing_friction": strip_footing_friction.comparisons,
    "square_footing": square_footing.comparisons,
    "layered_footing": layered_footing.comparisons,
    "random_field_slope": random_field_slope.comparisons,
    "upsetting": upsetting.comparisons,
    "pressure_cantilever": pressure_cantilever.comparisons,
    "cooks_membrane": cooks_membrane.comparisons,
    "submerged_block": submerged_block.comparisons,
    "pressurised_ring": pressurised_ring.comparisons,
    "footing_on_spline": footing_on_spline.comparisons,
    "buried_pipe": buried_pipe.comparisons,
    "hollow_sphere_limit": hollow_sphere_limit.comparisons,
    "rigid_sphere": rigid_sphere.comparisons,
    "cone_penetration": cone_penetration.comparisons,
    "element_tests": element_tests.comparisons,
}
"""Problem (the name of its folder in `examples`) -> its comparisons, given whether to run long."""
