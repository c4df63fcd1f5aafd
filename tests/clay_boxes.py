# SPDX-License-Identifier: BSD-3-Clause
"""A box of clay for rigid bodies on its middle, in the plane and in space."""

from __future__ import annotations

from typing import Any

from small_problems import plane


def clay_box(kind: str, poisson_ratio: float, top: float = 0.0) -> dict[str, Any]:
    """Clay from -1 to 1 across and from -1 up, on a fixed base between rollers.

    top: height of its surface.
    """
    across = ["x", "y"] if kind == "3d" else ["x"]
    half = [1.0] * len(across)
    return {
        "format": 1,
        "materials": {
            "clay": {"model": "tresca", "young_modulus": 5e6, "poisson_ratio": poisson_ratio,
                     "undrained_shear_strength": 1e4, "density": 1600.0}
        },
        "bodies": [
            {"name": "ground", "material": "clay", "basis": "gimp", "points_per_cell": 2,
             "anti_locking": "f_bar",
             "shape": {"type": "box", "lower": [-x for x in half] + [-1.0], "upper": [*half, top]}}
        ],
        "boundaries": [
            plane("base", "xyz"[len(across)], -1.0, condition="fixed"),
            *(plane(f"{a} {end}", a, at) for a in across for end, at in (("a", -1), ("b", 1))),
        ],
    }  # fmt: skip
