# SPDX-License-Identifier: BSD-3-Clause
"""Tracked quantities: one column of history.csv each."""

from __future__ import annotations

from typing import Any, Final, Literal

from pydantic import Field, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import Axis, CellName, Label, Name, Real, Share, Vector
from tilth.model.problems import rejection, suggestion

Quantity = Literal[
    "reaction",
    "moment",
    "rigid_displacement",
    "rigid_rotation",
    "contact_area",
    "embedment",
    "penetration",
    "displacement",
    "velocity",
    "acceleration",
    "stress",
    "effective_stress",
    "pore_pressure",
    "excess_pore_pressure",
    "top_height",
    "run_out",
    "enclosed",
    "energy",
    "discharge",
    "drained_volume",
    "stored_water",
    "state",
]

EnergyKind = Literal[
    "elastic",
    "external_work",
    "plastic_dissipation",
    "friction_dissipation",
    "kinetic",
    "damping_dissipation",
    "radiation",
    "numerical_dissipation",
    "time_integration",
    "stabilisation",
    "contact_gaps",
    "seepage",
]

_AXES = ("x", "y", "z")
_TENSOR = ("xx", "yy", "zz", "xy", "yz", "xz", "mean", "von_mises")
_COMPONENTS: Final[dict[str, tuple[str, ...]]] = {
    "reaction": _AXES,
    "moment": _AXES,
    "rigid_displacement": (*_AXES, "magnitude"),
    "rigid_rotation": _AXES,
    "displacement": (*_AXES, "magnitude"),
    "velocity": (*_AXES, "magnitude"),
    "acceleration": (*_AXES, "magnitude"),
    "stress": _TENSOR,
    "effective_stress": _TENSOR,
}
_REQUIRED: Final[dict[str, tuple[str, ...]]] = {
    "reaction": ("boundary", "component"),
    "moment": ("boundary", "component"),
    "rigid_displacement": ("boundary", "component"),
    "rigid_rotation": ("boundary", "component"),
    "contact_area": ("boundary",),
    "embedment": ("boundary", "from"),
    "penetration": ("boundary",),
    "displacement": ("at", "component"),
    "velocity": ("at", "component"),
    "acceleration": ("at", "component"),
    "stress": ("at", "component"),
    "effective_stress": ("at", "component"),
    "pore_pressure": ("at",),
    "excess_pore_pressure": ("at",),
    "top_height": ("of",),
    "run_out": ("axis", "of"),
    "enclosed": ("body",),
    "energy": ("kind",),
    "discharge": ("boundary",),
    "drained_volume": ("boundary",),
    "stored_water": (),
    "state": ("variable", "at"),
}
_OPTIONAL: Final[dict[str, tuple[str, ...]]] = {
    "moment": ("about",),
    "displacement": ("body",),
    "velocity": ("body",),
    "acceleration": ("body",),
    "stress": ("body",),
    "effective_stress": ("body",),
    "pore_pressure": ("body",),
    "excess_pore_pressure": ("body",),
    "top_height": ("body",),
    "run_out": ("body", "share"),
    "stored_water": ("body",),
    "state": ("body",),
}
_KEYS = (
    "boundary",
    "about",
    "at",
    "body",
    "component",
    "axis",
    "of",
    "from",
    "kind",
    "variable",
    "share",
)
OF_FLOW_BOUNDARIES = ("discharge", "drained_volume")
"""Quantities of a flow boundary."""

OF_FLOW = (*OF_FLOW_BOUNDARIES, "stored_water")
"""Quantities that only flowing water has."""

_FIRST_COLUMNS = ("step", "time", "iterations")

OF_RELAXATION = ("relaxation", "kinetic energy in relaxation", "work in relaxation")
"""Last columns of an analysis that goes beyond limit loads: number of the relaxation that a step
belongs to, kinetic energy after it, and work of loads and boundaries since the relaxation began;
all 0 in other steps."""


class Track(Declared):
    """A quantity that is recorded after every step; its keys depend on `quantity`.

    | quantity | keys |
    | --- | --- |
    | reaction | `boundary`, `component` x, y, z: force on the soil, of a pair on its second body |
    | moment | `boundary`, `about`, `component` z, in 3D x, y, z: moment of that force |
    | rigid_displacement | `boundary`, `component` x, y, z, magnitude: of a rigid body's centre |
    | rigid_rotation | `boundary`, `component` z, in 3D x, y, z: of a rigid body [degrees] |
    | contact_area | `boundary`, implicit, rigid body or contact pair: area that touches soil |
    | embedment | `boundary`, `from`: depth of its lowest point below the surface of the soil |
    | penetration | `boundary`: greatest depth of a material point behind an implicit boundary |
    | displacement | `at`, `component` x, y, z, magnitude; optional `body` |
    | velocity, acceleration | the same, with inertia |
    | stress | `at`, `component` xx yy zz xy yz xz mean von_mises (Cauchy, total); optional `body` |
    | effective_stress | the same of the effective stress: without water and pore fluid the total |
    | pore_pressure | `at`: pressure of the water of `[water]` at a point, with `[flow]` and its \
 excess; optional `body` |
    | excess_pore_pressure | the same of the excess alone, with `[flow]` |
    | top_height | `of` "points" or "domains": greatest vertical coordinate; optional `body` |
    | run_out | `axis`, `of`: greatest coordinate along the axis; optional `body`, `share` |
    | enclosed | `body`: area, in 3D volume, enclosed by its closed tracked surface |
    | discharge | `boundary`, of the flow: water per time that leaves the soil through it \
 [length^3 / time] |
    | drained_volume | `boundary`, of the flow: water that has left through it since the start \
 [length^3] |
    | stored_water | water in the pores of the soil that is there [length^3]; optional `body` |
    | state | `variable`: a state variable of the material, by name; `at`; optional `body` |
    | energy | `kind` "elastic", "external_work", "plastic_dissipation", "friction_dissipation", \
 "stabilisation", "contact_gaps", with `[flow]` "seepage", \
 with inertia or relaxation "kinetic", "damping_dissipation", "radiation", \
 "numerical_dissipation", "time_integration" |

    Forces, energies and volumes of water are per unit length in plane strain, per full circle in
    axisymmetry.
    """

    name: CellName
    """Name of the column in history.csv, unique."""
    quantity: Quantity
    """Recorded quantity."""
    boundary: Name | None = None
    """Boundary, rigid body, contact pair or flow boundary of the quantity."""
    about: Vector | None = None
    """Fixed reference point of the moment [length], shape (dimension,); of a rigid body its centre
    where it is, if not given.
    """
    from_: Literal["original", "current"] | None = Field(None, alias="from")
    """Surface above the embedment: "original", the top of the soil of the start where the lowest
    point is, or "current", the highest soil now over the body and beside it, up to half its width
    away. Negative above it; not a number where there is no soil.
    """
    at: Vector | None = None
    """Position [length], shape (dimension,), of the nearest material point at the start."""
    body: Name | None = None
    """Body of the points or the surface; any if not given."""
    component: Name | None = None
    """Component; tension positive."""
    axis: Axis | None = None
    """Axis along which the run-out is measured."""
    of: Literal["points", "domains"] | None = None
    """Whether the points' centres or the outer edges of their domains are used."""
    share: Share | None = None
    """Share of the soil's initial volume up to the recorded coordinate, such as 0.99, so that a few
    points that fly ahead do not count; all if not given."""
    kind: EnergyKind | None = None
    """Kind of energy [force length]. "numerical_dissipation", with inertia or relaxation, is what
    of the work and of the energy at the start is in none of the others; "time_integration",
    "stabilisation" and "contact_gaps" are what of it the time integration, ghost stabilisation and
    contact that closes or opens take, by their own formulas. "seepage" is what flowing water
    dissipates; the work of water that is pressed in or out is in none of them."""
    variable: Name | None = None
    """State variable: `plastic_strain`, or one of the material's own."""
    scale: Real = 1.0
    """Factor on the recorded value."""
    unit: Label | None = None
    """Label of the unit after scaling; that of `[units]` if not given."""

    @model_validator(mode="after")
    def _entries_fit_the_quantity(self) -> Any:
        required = _REQUIRED[self.quantity]
        allowed = (*required, *_OPTIONAL.get(self.quantity, ()))
        problems = [
            Problem(key, "missing", f'quantity = "{self.quantity}" needs {_listed(required)}')
            for key in required
            if self._given(key) is None
        ]
        for key in _KEYS:
            value = self._given(key)
            if value is not None and key not in allowed:
                what = f'has no meaning with quantity = "{self.quantity}"'
                problems.append(Problem(key, what, f"it takes {_listed(allowed)}", value))
        choices = _COMPONENTS.get(self.quantity, ())
        if choices and self.component is not None and self.component not in choices:
            likely = suggestion(self.component, choices)
            remedy = f'did you mean "{likely}"? ' if likely else ""
            remedy += "choose from " + ", ".join(f'"{choice}"' for choice in choices)
            problems.append(Problem("component", "not one of the choices", remedy, self.component))
        if self.name in _FIRST_COLUMNS:
            what = "is the name of a column that history.csv always has"
            problems.append(Problem("name", what, "choose another name", self.name))
        if self.name.endswith("]") and " [" in self.name:
            what = "reads as a name with its unit, which the heading of the column gets anyway"
            remedy = "give the name alone, and `unit` if it is not that of [units]"
            problems.append(Problem("name", what, remedy, self.name))
        if problems:
            raise rejection(problems)
        return self

    def _given(self, key: str) -> Any:
        """Returns the entry of a key of the case file."""
        return getattr(self, "from_" if key == "from" else key)


def _listed(keys: tuple[str, ...]) -> str:
    return " and ".join(f"`{key}`" for key in keys)
