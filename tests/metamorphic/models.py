# SPDX-License-Identifier: BSD-3-Clause
"""The entries of a small model for a choice of values: a block of soil and what acts on it."""

from __future__ import annotations

from random import Random
from typing import Any

from small_problems import AXES, ENTRIES, PORE_FLUID

from metamorphic.choices import Choice

Tree = dict[str, Any]

GRAVITY, DENSITY, YOUNG = 5.0, 2.0, 1000.0
CELL = 0.5
TOLERANCE = 1e-11

CONTACTS: dict[str, Tree] = {
    "smooth": {"normal": "unilateral", "tangential": "smooth"},
    "friction": {"normal": "unilateral", "tangential": "friction", "friction": 0.4},
    "adhesion": {"normal": "unilateral", "tangential": "adhesion", "shear_limit": 4.0},
    "rough": {"normal": "unilateral", "tangential": "rough"},
    "bonded": {"normal": "unilateral", "tangential": "bonded"},
    "bilateral": {"normal": "bilateral", "tangential": "friction", "friction": 0.4},
    "tensile": {
        "normal": "unilateral", "tensile_strength": 3.0, "tangential": "friction", "friction": 0.3,
    },
}  # fmt: skip

_STRENGTH = {"cohesion": 8.0, "friction_angle": 30.0, "dilation_angle": 10.0}
LAWS: dict[str, Tree] = {
    "hencky_elastic": {},
    "von_mises": {"yield_stress": 40.0, "hardening_modulus": 80.0},
    "tresca": {"undrained_shear_strength": 25.0},
    "mohr_coulomb": _STRENGTH,
    "drucker_prager": _STRENGTH,
    "modified_cam_clay": {"preconsolidation_pressure": 80.0},
    "undrained_mohr_coulomb": {"model": "mohr_coulomb", **_STRENGTH, **PORE_FLUID},
    "separating_mohr_coulomb": {"model": "mohr_coulomb", **_STRENGTH, "separates": True},
    "softening_mohr_coulomb": {
        "model": "mohr_coulomb", **_STRENGTH, "residual_cohesion": 4.0,
        "residual_friction_angle": 25.0, "softening_strain": 1.0, "softening_length": 0.5,
    },
}  # fmt: skip
"""What the laws have beside the entries of `small_problems`."""


def material(law: str) -> Tree:
    """The entries of a law."""
    own = LAWS[law]
    model = own.get("model", law)
    return {"model": model, "density": DENSITY, **ENTRIES[model], **own}


class Ground:
    """A block of soil from the origin to `width` and `height`, and the model that it is in."""

    def __init__(self, choice: Choice, random: Random) -> None:
        self.choice, self.random = choice, random
        self.kind = choice["kind"]
        self.dim = 3 if self.kind == "3d" else 2
        self.up = AXES[self.dim - 1]
        self.width = CELL * (3 if self.dim == 3 else 4)
        self.height = CELL * (1 if self.dim == 3 else random.choice((1, 2)))
        self.depth = CELL if self.dim == 3 else 0.0
        self.steps = random.choice((1, 2))
        self.dynamic = not self.has("inertia", "none")
        self.end = 0.2 if self.dynamic else 1.0
        self.constant = [[0.0, 1.0], [self.end, 1.0]]
        self.growing = [[0.0, 0.0], [self.end, 1.0]]
        self.contact = CONTACTS.get(choice["contact"])
        self.axes = AXES[: self.dim]
        off_line = self.has("driver", "prescribed_plane") or random.random() < 0.5
        self.top = self.height + (0.0 if off_line else 0.3 * CELL)
        self.start = random.choice((0.0, 0.25 * CELL))
        self.right = self.start + 1.6 * CELL
        self.upper = "ground" if self.has("second_body", "none") else "above"
        self.crest = self.top + (0.0 if self.upper == "ground" else CELL)
        self.confined = random.random() < 0.5
        self.at_once = not self.has("initial", "none")

    def has(self, dimension: str, *beginnings: str) -> bool:
        """Whether the value of a dimension begins with one of some words."""
        return self.choice[dimension].startswith(beginnings)

    def vector(self, x: float, y: float, across: float = 0.0) -> list[float]:
        """A vector along x and upwards, in 3D also across the plane of the two."""
        return [x, across, y] if self.dim == 3 else [x, y]

    def place(self, x: float, y: float) -> list[float]:
        """A place in the plane, in 3D in the middle of the depth."""
        return self.vector(x, y, 0.5 * self.depth)

    def box(self, x: float, y: float, right: float, top: float) -> Tree:
        """The shape of a part of the block over its whole depth."""
        lower, upper = self.vector(x, y), self.vector(right, top, self.depth)
        return {"type": "box", "lower": lower, "upper": upper}

    def body(self, name: str, shape: Tree, **more: Any) -> Tree:
        return {
            "name": name, "material": "soil", "basis": self.choice["basis"], "shape": shape,
            "anti_locking": self.choice["anti_locking"], "points_per_cell": 2, **more,
        }  # fmt: skip

    def amount(self, least: float, most: float) -> float:
        return round(self.random.uniform(least, most), 3)
