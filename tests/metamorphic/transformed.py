# SPDX-License-Identifier: BSD-3-Clause
"""The entries of a model in another frame: each key of a case file by what it means."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import numpy as np

from metamorphic.frames import AXES, Frame

Tree = dict[str, Any]
Units = tuple[float, float, float]
"""Powers of the units of length, stress and time."""

LENGTH, STRESS, TIME, PURE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)
DENSITY, ACCELERATION, VELOCITY = (-2, 1, 2), (1, 0, -2), (1, 0, -1)

PLACES = {"origin", "place", "point", "centre", "at", "start", "end", "tip"}
VECTORS: dict[str, Units] = {
    "acceleration": ACCELERATION, "normal": PURE, "direction": PURE, "along": PURE,
    "traction": STRESS, "coefficient": PURE, "velocity": VELOCITY,
}  # fmt: skip
NUMBERS: dict[str, Units] = {
    **dict.fromkeys(
        ("young_modulus", "yield_stress", "hardening_modulus", "undrained_shear_strength",
         "cohesion", "residual_cohesion", "tension_cut_off", "shear_modulus", "shear_limit",
         "preconsolidation_pressure", "pore_fluid_bulk_modulus", "pressure", "tensile_strength",
         "surcharge", "vertical_pressure", "horizontal_pressure"),
        STRESS,
    ),
    **dict.fromkeys(("radius", "delta", "spacing", "radius_change", "softening_length"), LENGTH),
    **dict.fromkeys(("thickness", "inner_radius", "height", "length"), LENGTH),
    **dict.fromkeys(("density", "saturated_density"), DENSITY),
    **dict.fromkeys(("p_wave_speed", "s_wave_speed"), VELOCITY),
    "unit_weight": (-1, 1, 0), "step_size": TIME,
}  # fmt: skip
HEIGHTS = {"level", "initial_level", "ground", "bottom", "surface", "base"}
"""Elevations: a number, or in 2D rows (x, elevation)."""
TIMED = {"factor", "force_factor", "release"}
"""Rows (time, factor)."""
PLAIN = {
    "kind", "solver", "tolerance", "scheme", "spectral_radius", "model", "poisson_ratio", "type",
    "friction_angle", "dilation_angle", "residual_friction_angle", "softening_strain", "fit",
    "separates", "compression_index", "swelling_index", "critical_state_slope", "K0", "body",
    "overconsolidation_ratio", "name", "material", "basis", "anti_locking", "domain_update",
    "condition", "normal_of_contact", "tangential", "friction", "adhesion_factor", "bodies",
    "wished_in_place", "follower", "steps", "adaptive", "activate", "deactivate", "title",
    "materials_of_stage", "reset", "boundary", "follower", "equilibrium", "predictor", "format",
    "ghost_stabilisation", "velocity_update", "watertight", "form", "report", "checkpoint_every",
    "tensile", "solid_side_of", "minimum_step", "outputs", "maximum_iterations", "closed",
    "angle_of_cone", "time_label", "stress_label", "quantity", "line_search", "beyond_limit",
    "relaxation_steps", "reset_plastic_strain", "colour_by", "inertia_of_stage",
}  # fmt: skip
"""Keys whose values mean the same in every frame."""


def transformed(entries: Tree, frame: Frame, kind: str) -> Tree:
    """Returns the entries of the same model in another frame; kind: of analysis."""
    return _Transformation(frame, kind).table(copy.deepcopy(entries), "")


class _Transformation:
    def __init__(self, frame: Frame, kind: str) -> None:
        self.frame, self.kind = frame, kind
        self.dim = frame.dim
        self.own: dict[str, Callable[[Any], Any]] = {
            "cell_size": self._cell_size, "points_per_cell": self._extents,
            "points": self._extents, "axes": self._axes, "range": self._range, "part": self._side,
            "stress": self._tensor, "vertices": self._vertices, "width": self._widths,
            "output_times": lambda times: [self._number(t, TIME) for t in times],
            "shear": lambda shear: self._number(-shear if self._flips else shear, STRESS),
            "factors": lambda table: {k: self._timed(rows) for k, rows in table.items()},
            "force_factors": lambda table: {k: self._timed(rows) for k, rows in table.items()},
        }  # fmt: skip

    @property
    def _flips(self) -> bool:
        return self.frame.handedness < 0.0

    def _number(self, value: float, units: Units) -> float:
        return value * self.frame.unit(*units)

    @property
    def _force(self) -> Units:
        return (1 if self.kind == "plane_strain" else 2, 1, 0)

    @property
    def _moment(self) -> Units:
        return (self._force[0] + 1, 1, 0)

    @property
    def _mass(self) -> Units:
        return (self._force[0] - 1, 1, 2)

    def table(self, table: Tree, of: str) -> Tree:
        """A table of entries; of: the key that it belongs to."""
        special = {
            "box": self._box, "plane": self._plane, "node": self._node,
        }.get(table.get("type", ""))  # fmt: skip
        if special is not None:
            table = special(table, of)
        if table.get("type") == "surface" and self._flips and "start" in table:
            table["start"], table["end"] = table["end"], table["start"]
        return {key: self._entry(key, value, of, table) for key, value in table.items()}

    def _entry(self, key: str, value: Any, of: str, table: Tree) -> Any:
        frame = self.frame
        if isinstance(value, _Done):
            return value.value
        if of == "schedule" and key == "end":
            return self._number(value, TIME)
        if of == "damping":
            return self._number(value, (0, 0, -1) if key == "mass" else TIME)
        if key == "normal" and isinstance(value, str):
            return value
        if key == "materials" and of == "stages":
            return value
        if key in ("damping", "inertia") and isinstance(value, bool):
            return value
        if key in self.own and not (key == "stress" and isinstance(value, list | dict) and (
            value and isinstance(value[0] if isinstance(value, list) else value, dict)
        )):  # fmt: skip
            return self.own[key](value)
        if key in HEIGHTS and not isinstance(value, dict):
            return self._elevation(value)
        if key in PLACES:
            return frame.place(value).tolist()
        if key in ("lower", "upper") and of != "materials":
            raise KeyError(f"{key} of {of}")
        if key == "force":
            return self._force_of(value, table)
        if key == "displacement":
            return self._by_axis(value, LENGTH)
        if key == "rotation":
            return self._rotation(value)
        if key == "springs":
            return self._springs(value)
        if key == "moment":
            return self._axial(value, self._moment)
        if key == "mass":
            return self._number(value, self._mass)
        if key == "moments_of_inertia":
            units = (self._mass[0] + 2, self._mass[1], self._mass[2])
            numbers = self._extents(value) if isinstance(value, list) else value
            return (np.array(numbers) * frame.unit(*units)).tolist()
        if key in TIMED:
            return self._timed(value)
        if key in VECTORS:
            return (frame.vector(value) * frame.unit(*VECTORS[key])).tolist()
        if key in NUMBERS:
            return self._maybe_varying(value, NUMBERS[key])
        if key == "angle":
            return value
        if isinstance(value, dict):
            return self.table(value, key)
        if isinstance(value, list) and value and isinstance(value[0], dict):
            return [self.table(each, key) for each in value]
        if key == "soil" and self._flips and value in ("left", "right"):
            return {"left": "right", "right": "left"}[value]
        if key in PLAIN or key == "soil" or of in ("units", "output") or value == []:
            return value
        raise KeyError(f"the meaning of {key!r} of {of!r} is not known")

    def _maybe_varying(self, value: Any, units: Units) -> Any:
        if not isinstance(value, dict):
            return self._number(value, units)
        if "depth" in value:
            rows = [[self._number(d, LENGTH), self._number(v, units)] for d, v in value["depth"]]
            return {"depth": rows, "surface": self._elevation(value["surface"])}
        axis = AXES.index(value["axis"])
        new, sign = self.frame.axis(axis)
        rows = [
            [sign * self._number(at, LENGTH) + self.frame.shift[new], self._number(v, units)]
            for at, v in value["values"]
        ]
        return {"axis": AXES[new], "values": sorted(rows)}

    def _elevation(self, value: Any) -> Any:
        up, frame = self.dim - 1, self.frame
        if isinstance(value, list):
            return sorted(frame.place(row).tolist() for row in value)
        return float(value * frame.length + frame.shift[up])

    def _timed(self, rows: list[list[float]]) -> list[list[float]]:
        return [[self._number(time, TIME), factor] for time, factor in rows]

    def _valued(self, value: Any, factor: float) -> Any:
        """A number, or rows (time, value)."""
        if isinstance(value, list):
            return [[self._number(time, TIME), factor * each] for time, each in value]
        return factor * value

    def _by_axis(self, table: dict[str, Any], units: Units) -> dict[str, Any]:
        found = {}
        for axis, value in table.items():
            new, sign = self.frame.axis(AXES.index(axis))
            found[AXES[new]] = self._valued(value, sign * self.frame.unit(*units))
        return dict(sorted(found.items()))

    def _force_of(self, value: Any, table: Tree) -> Any:
        units = self._force
        if table.get("type") == "line_force":
            units = (units[0] - 1, 1, 0)
        if isinstance(value, dict):
            return self._by_axis(value, units)
        return (self.frame.vector(value) * self.frame.unit(*units)).tolist()

    def _rotation(self, value: Any) -> Any:
        if isinstance(value, dict) and "angle" in value:
            turned = {"centre": self.frame.place(value["centre"]).tolist()}
            if "axis" not in value:
                return {**turned, "angle": self.frame.handedness * value["angle"]}
            new, sign = self.frame.axis(AXES.index(value["axis"]))
            angle = self.frame.handedness * sign * value["angle"]
            return {**turned, "angle": angle, "axis": AXES[new]}
        return self._axial(value, PURE)

    def _axial(self, value: Any, units: Units) -> Any:
        scale = self.frame.handedness * self.frame.unit(*units)
        if not isinstance(value, dict):
            return self._valued(value, scale)
        found = {}
        for axis, each in value.items():
            new, sign = self.frame.axis(AXES.index(axis))
            found[AXES[new]] = self._valued(each, sign * scale)
        return dict(sorted(found.items()))

    def _springs(self, springs: dict[str, float]) -> dict[str, float]:
        found = {}
        for name, value in springs.items():
            kind, _, axis = name.rpartition("_")
            units = self._moment if name.startswith("rotation") else self._force
            units = units if name.startswith("rotation") else (units[0] - 1, 1, 0)
            if axis in AXES and (kind or len(name) == 1):
                axis = AXES[self.frame.axis(AXES.index(axis))[0]]
            found[f"{kind}_{axis}" if kind else axis] = self._number(value, units)
        return found

    def _extents(self, value: Any) -> Any:
        if not isinstance(value, list):
            return value
        return [value[self.frame.source(k)] for k in range(self.dim)]

    def _widths(self, value: Any) -> Any:
        if isinstance(value, list):
            return [self._number(each, LENGTH) for each in value]
        return self._number(value, LENGTH)

    def _axes(self, axes: list[str]) -> list[str]:
        return sorted(AXES[self.frame.axis(AXES.index(axis))[0]] for axis in axes)

    def _vertices(self, rows: list[list[float]]) -> list[list[float]]:
        return self.frame.place(np.array(rows)).tolist()

    def _tensor(self, stress: Any) -> Any:
        three, scale = [*stress, 0.0, 0.0][:6], self.frame.unit(*STRESS)
        return (scale * self.frame.tensor(three)).tolist()[: len(stress)]

    def _range(self, table: dict[str, list[float]]) -> dict[str, list[float]]:
        found = {}
        for axis, ends in table.items():
            new, sign = self.frame.axis(AXES.index(axis))
            moved = [sign * self._number(end, LENGTH) + self.frame.shift[new] for end in ends]
            found[AXES[new]] = sorted(float(end) for end in moved)
        return found

    def _cell_size(self, size: Any) -> Any:
        if not isinstance(size, dict):
            sizes = size if isinstance(size, list) else [size] * self.dim
            return [self._number(each, LENGTH) for each in self._extents(sizes)]
        found = {}
        for axis, rows in size.items():
            new, sign = self.frame.axis(AXES.index(axis))
            if isinstance(rows, list):
                shift = 0.0 if self._followed(axis) else float(self.frame.shift[new])
                moved = [
                    [sign * self._number(at, LENGTH) + shift, self._number(each, LENGTH)]
                    for at, each in rows
                ]
                found[AXES[new]] = sorted(moved)
            else:
                found[AXES[new]] = self._number(rows, LENGTH)
        return dict(sorted(found.items()))

    def _followed(self, axis: str) -> bool:
        return False

    def _box(self, table: Tree, of: str) -> Tree:
        """The box in its own axes, which are turned with `angle`, is turned as a whole."""
        lower, upper = np.array(table["lower"]), np.array(table["upper"])
        size, frame = upper - lower, self.frame
        angle, axis = table.get("angle", 0.0), table.get("axis")
        plane = _plane_of(axis, self.dim)
        sides = frame.length * frame.vector(size)  # from the transformed `lower` corner
        shift = _rotated(np.minimum(sides, 0.0), self._turned_angle(angle, axis), plane, frame)
        corner = frame.place(lower) + shift
        found: Tree = {**table, "lower": _Done(corner.tolist())}
        found["upper"] = _Done((corner + np.abs(sides)).tolist())
        if "angle" in table:
            found["angle"] = _Done(self._turned_angle(angle, axis))
        if axis is not None:
            found["axis"] = _Done(AXES[frame.axis(AXES.index(axis))[0]])
        if "faces" in table:
            found["faces"] = _Done([self._side(side) for side in table["faces"]])
        return found

    def _turned_angle(self, angle: float, axis: str | None) -> float:
        if axis is None:
            return self.frame.handedness * angle
        return self.frame.handedness * self.frame.axis(AXES.index(axis))[1] * angle

    def _side(self, side: str) -> str:
        new, sign = self.frame.axis(AXES.index(side[0]))
        positive = (side[1] == "+") == (sign > 0.0)
        return f"{AXES[new]}{'+' if positive else '-'}"

    def _plane(self, table: Tree, of: str) -> Tree:
        if "point" in table:  # a geometry
            return table
        new, sign = self.frame.axis(AXES.index(table["axis"]))
        at = sign * self._number(table["at"], LENGTH) + float(self.frame.shift[new])
        found = {**table, "axis": _Done(AXES[new]), "at": _Done(at)}
        if "components" in table:
            found["components"] = _Done(self._axes(table["components"]))
        if "solid_side" in table and sign < 0.0:
            other = {"lower": "upper", "upper": "lower"}
            found["solid_side"] = _Done(other[table["solid_side"]])
        return found

    def _node(self, table: Tree, of: str) -> Tree:
        if "components" in table:
            return {**table, "components": _Done(self._axes(table["components"]))}
        return table


class _Done:
    """A value that is transformed already."""

    def __init__(self, value: Any) -> None:
        self.value = value


def _plane_of(axis: str | None, dim: int) -> tuple[int, int] | None:
    if dim == 2:
        return (0, 1)
    return None if axis is None else {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]


def _rotated(
    vector: np.ndarray, angle: float, plane: tuple[int, int] | None, frame: Frame
) -> np.ndarray:
    """A vector turned by an angle [degrees] in the plane that the old one has become."""
    if plane is None or angle == 0.0:
        return vector
    new = [frame.axis(k)[0] for k in plane]
    if frame.dim == 3:
        third = ({0, 1, 2} - set(new)).pop()
        new = list(_plane_of(AXES[third], 3) or ())
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    i, j = new if frame.dim == 3 else (0, 1)
    found = vector.copy()
    found[i], found[j] = (
        cosine * vector[i] - sine * vector[j],
        sine * vector[i] + cosine * vector[j],
    )
    return found
