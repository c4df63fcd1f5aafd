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
        self.axes = AXES[: self.dim]
        self.up = AXES[self.dim - 1]
        self.contact = CONTACTS.get(choice["contact"])
        self.steps = 1 if self.dim == 3 else random.choice((1, 2))
        self.dynamic = not self.has("inertia", "none")
        self.end = 0.2 if self.dynamic else 1.0
        self.constant = [[0.0, 1.0], [self.end, 1.0]]
        self.growing = [[0.0, 0.0], [self.end, 1.0]]
        self.at_once = not self.has("initial", "none")
        self._set_places()

    def _set_places(self) -> None:
        """Where the soil ends: on grid lines, or at no line that no condition needs."""
        random, regular = self.random, self.has("places", "regular")
        base_on_line = self.has("base", "rollers", "fixed") or self.choice["base"] == "absorbing"
        crest_on_line = self.has("driver", "prescribed_plane")
        self.regular = regular
        self.confined = random.random() < 0.5
        self.width = CELL * (3 if self.dim == 3 else 4)
        if not regular and not self.confined:
            self.width -= self.amount(0.06, 0.18)
        self.depth = 0.0 if self.dim == 2 else CELL if regular else self.amount(0.4, 0.46)
        self.height = CELL * (1 if self.dim == 3 else random.choice((1, 2)))
        above = 0.0 if self.has("second_body", "none") else CELL
        if not regular and not (base_on_line and crest_on_line):
            self.height += self.amount(0.07, 0.21)
            above = 0.93 * above
        self.top = self.height
        self.crest = self.top + above
        self.upper = "above" if above else "ground"
        self.start = random.choice((0.0, 0.25 * CELL if regular else self.amount(0.06, 0.18)))
        self.right = self.start + (1.6 * CELL if regular else self.amount(0.71, 0.89))
        self.origin_up = 0.0
        if not base_on_line and not regular:
            self.origin_up = self.crest if crest_on_line else -self.amount(0.05, 0.2)

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
            "anti_locking": self.choice["anti_locking"], **self._division, **more,
        }  # fmt: skip

    @property
    def _division(self) -> Tree:
        """Two points along each edge of a cell, also of the finer grid of a stage."""
        finer = 2 if self.has("stages", "grid") else 1
        return {"points_per_cell": 2 * finer} if self.regular else {"spacing": 0.47 * CELL / finer}

    def amount(self, least: float, most: float) -> float:
        return round(self.random.uniform(least, most), 3)
