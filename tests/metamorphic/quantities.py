# SPDX-License-Identifier: BSD-3-Clause
"""The keys of a case file by what their values are: places, vectors, numbers with units."""

from __future__ import annotations

from typing import get_args

from tilth.model.materials import Material
from tilth.model.parameter_kinds import KINDS

Units = tuple[float, float, float]
"""Powers of the units of length, stress and time."""

LENGTH, STRESS, TIME, PURE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)
RATE, VELOCITY, ACCELERATION = (0, 0, -1), (1, 0, -1), (1, 0, -2)

PLACES = frozenset({"origin", "place", "point", "centre", "at", "start", "end"})

VECTORS: dict[str, Units] = {
    "acceleration": ACCELERATION, "normal": PURE, "direction": PURE, "along": PURE,
    "traction": STRESS, "coefficient": PURE,
}  # fmt: skip

OF_KINDS: dict[str, Units] = {
    "stress": STRESS, "length": LENGTH, "mass / length^3": (-2, 1, 2), "-": PURE, "degrees": PURE,
    "length / time": VELOCITY,
}  # fmt: skip

OF_MATERIALS: dict[str, Units] = {
    key: OF_KINDS[KINDS[kind].unit]
    for cls in get_args(get_args(Material)[0])
    for key, kind in cls.kinds.items()
    if key in cls.model_fields
}
"""Entries of materials, by the kinds that their laws declare."""

NUMBERS: dict[str, Units] = {
    **OF_MATERIALS,
    **dict.fromkeys(("shear_limit", "tensile_strength", "pressure", "vertical_pressure"), STRESS),
    **dict.fromkeys(("radius", "spacing"), LENGTH),
    "unit_weight": (-1, 1, 0),
}

OF_TABLES: dict[tuple[str, str], Units] = {
    ("schedule", "end"): TIME, ("damping", "mass"): RATE, ("damping", "stiffness"): TIME,
    ("contact", "normal"): PURE, ("contact", "shear_limit"): STRESS,
}  # fmt: skip
"""Numbers and words whose keys mean something else in other tables, by table and key."""

ELEVATIONS = frozenset({"level", "initial_level", "bottom", "surface"})
FACTORS = frozenset({"factor", "force_factor", "release"})
"""Rows (time, factor)."""

PLAIN = frozenset({
    "K0", "activate", "anti_locking", "basis", "bodies", "body", "boundary", "condition",
    "deactivate", "fit", "friction", "kind", "material", "materials", "maximum_iterations",
    "minimum_step", "model", "name", "report", "scheme", "separates", "soil", "solver",
    "spectral_radius", "steps", "tangential", "time", "title", "tolerance", "type",
    "velocity_update", "wished_in_place", "format", "reset",
})  # fmt: skip
"""Keys whose values mean the same in every frame."""
