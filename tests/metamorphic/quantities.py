# SPDX-License-Identifier: BSD-3-Clause
"""The keys of a case file by what their values are: places, vectors, numbers with units."""

from __future__ import annotations

Units = tuple[float, float, float]
"""Powers of the units of length, stress and time."""

LENGTH, STRESS, TIME, PURE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)
RATE, VELOCITY, ACCELERATION = (0, 0, -1), (1, 0, -1), (1, 0, -2)

PLACES = frozenset({"origin", "place", "point", "centre", "at", "start", "end"})

VECTORS: dict[str, Units] = {
    "acceleration": ACCELERATION, "normal": PURE, "direction": PURE, "along": PURE,
    "traction": STRESS, "coefficient": PURE,
}  # fmt: skip

NUMBERS: dict[str, Units] = {
    **dict.fromkeys(
        ("young_modulus", "yield_stress", "hardening_modulus", "undrained_shear_strength",
         "cohesion", "residual_cohesion", "shear_modulus", "shear_limit", "tensile_strength",
         "preconsolidation_pressure", "pore_fluid_bulk_modulus", "pressure", "vertical_pressure"),
        STRESS,
    ),
    **dict.fromkeys(("radius", "spacing", "softening_length"), LENGTH),
    **dict.fromkeys(("density", "saturated_density"), (-2, 1, 2)),
    "unit_weight": (-1, 1, 0),
}  # fmt: skip

OF_TABLES: dict[tuple[str, str], Units] = {
    ("schedule", "end"): TIME, ("damping", "mass"): RATE, ("damping", "stiffness"): TIME,
    ("contact", "normal"): PURE, ("contact", "shear_limit"): STRESS,
}  # fmt: skip
"""Numbers and words whose keys mean something else in other tables, by table and key."""

ELEVATIONS = frozenset({"level", "initial_level", "bottom", "surface"})
FACTORS = frozenset({"factor", "force_factor", "release"})
"""Rows (time, factor)."""

PLAIN = frozenset({
    "K0", "activate", "anti_locking", "basis", "bodies", "body", "boundary", "compression_index",
    "condition", "critical_state_slope", "deactivate", "dilation_angle", "fit", "friction",
    "friction_angle", "kind", "material", "materials", "maximum_iterations", "minimum_step",
    "model", "name", "overconsolidation_ratio", "poisson_ratio", "report",
    "residual_friction_angle",
    "scheme", "separates", "soil", "softening_strain", "solver", "spectral_radius", "steps",
    "swelling_index", "tangential", "time", "title", "tolerance", "type", "velocity_update",
    "wished_in_place", "format", "reset",
})  # fmt: skip
"""Keys whose values mean the same in every frame."""
