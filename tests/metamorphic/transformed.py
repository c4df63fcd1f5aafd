# SPDX-License-Identifier: BSD-3-Clause
"""The entries of a model in another frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from metamorphic.frames import AXES, Frame
from metamorphic.models import Tree
from metamorphic.quantities import (
    ELEVATIONS,
    FACTORS,
    LENGTH,
    NUMBERS,
    OF_TABLES,
    PLACES,
    PLAIN,
    PURE,
    STRESS,
    TIME,
    VECTORS,
    Units,
)


def transformed(entries: Tree, frame: Frame, kind: str) -> Tree:
    """Returns the entries of the same model in another frame; kind: of analysis."""
    return _Transformation(frame, kind).table(entries, "")


class _Transformation:
    """Goes through the tables of a model.

    Args:
        frame: the other frame.
        kind: of analysis, by which a force is one per length or not.
    """

    def __init__(self, frame: Frame, kind: str) -> None:
        self._frame, self._dim = frame, frame.dim
        length = 1.0 if kind == "plane_strain" else 2.0
        self._force = (length, 1, 0)
        self._moment = (length + 1.0, 1, 0)
        self._mass = (length - 1.0, 1, 2)
        self._by_key: dict[str, Callable[[Any], Any]] = {
            "cell_size": self._cell_size,
            "points_per_cell": self._extents,
            "axes": lambda axes: sorted(map(self._axis, axes)),
            "axis": self._axis,
            "part": self._side,
            "range": self._range,
            "stress": self._tensor,
            "width": lambda width: (np.array(width) * self._unit(LENGTH)).tolist(),
            "displacement": lambda table: self._by_axis(table, LENGTH),
            "rotation": lambda rotation: self._axial(rotation, PURE),
            "springs": self._springs,
            "mass": lambda mass: self._number(mass, self._mass),
            "factors": lambda tables: {name: self._rows(rows) for name, rows in tables.items()},
        }

    def table(self, table: Tree, of: str) -> Tree:
        """The entries of a table; of: the key that it belongs to."""
        kind = table.get("type")
        if kind == "box":
            return {**table, **self._box(table)}
        found = {key: self._entry(key, value, of) for key, value in table.items()}
        if kind == "plane" and "axis" in table:
            new, sign = self._frame.axis(AXES.index(table["axis"]))
            found["at"] = self._coordinate(table["at"], new, sign)
        if of == "grid" and "origin" in table and isinstance(found["cell_size"], dict):
            found["origin"] = self._origin(found)
        if kind in ("point_force", "line_force"):
            length = self._force[0] - (kind == "line_force")
            found["force"] = self._vector(table["force"], (length, 1, 0))
        if kind == "surface" and self._frame.handedness < 0.0 and "start" in table:
            found |= {"start": found["end"], "end": found["start"]}  # the soil stays on the left
        return found

    def _entry(self, key: str, value: Any, of: str) -> Any:
        """A value by its key; of: the key of the table that it is in."""
        if (of, key) in OF_TABLES:
            return value if isinstance(value, str) else self._number(value, OF_TABLES[of, key])
        if isinstance(value, list) and value and isinstance(value[0], dict):
            return [self.table(each, key) for each in value]
        if key in NUMBERS:
            return self._varying(value, NUMBERS[key])
        if key in ELEVATIONS and not isinstance(value, dict):
            return self._coordinate(value, self._dim - 1, 1.0)
        if key == "force":
            return self._by_axis(value, self._force) if isinstance(value, dict) else value
        if key == "at" and not isinstance(value, list):
            return value  # of a plane, see `table`
        if key in PLACES:
            return self._frame.place(value).tolist()
        if key in VECTORS:
            return self._vector(value, VECTORS[key])
        if key in FACTORS:
            return self._rows(value)
        if key in self._by_key:
            return self._by_key[key](value)
        if isinstance(value, dict) and (key, of) != ("materials", "stages"):
            return self.table(value, key)
        if key not in PLAIN:
            raise KeyError(f"the meaning of {key!r} in {of!r} is not known")
        return value

    def _unit(self, units: Units) -> float:
        return self._frame.unit(*units)

    def _number(self, value: float, units: Units) -> float:
        return value * self._unit(units)

    def _varying(self, value: Any, units: Units) -> Any:
        """A number, or values by depth."""
        if not isinstance(value, dict):
            return self._number(value, units)
        rows = [[self._number(at, LENGTH), self._number(v, units)] for at, v in value["depth"]]
        return {"depth": rows, "surface": self._entry("surface", value["surface"], "depth")}

    def _coordinate(self, value: float, new: int, sign: float) -> float:
        return float(sign * self._number(value, LENGTH) + self._frame.shift[new])

    def _vector(self, value: list[float], units: Units) -> list[float]:
        return (self._frame.vector(np.array(value)) * self._unit(units)).tolist()

    def _rows(self, rows: list[list[float]]) -> list[list[float]]:
        """Rows (time, factor)."""
        return [[self._number(time, TIME), factor] for time, factor in rows]

    def _axis(self, axis: str) -> str:
        return AXES[self._frame.axis(AXES.index(axis))[0]]

    def _side(self, side: str) -> str:
        new, sign = self._frame.axis(AXES.index(side[0]))
        return f"{AXES[new]}{side[1] if sign > 0.0 else '+-'[side[1] == '+']}"

    def _by_axis(self, table: dict[str, float], units: Units) -> dict[str, float]:
        found = {}
        for axis, value in table.items():
            new, sign = self._frame.axis(AXES.index(axis))
            found[AXES[new]] = sign * self._number(value, units)
        return found

    def _axial(self, value: Any, units: Units) -> Any:
        """A rotation: a number in the plane, a table in space."""
        if isinstance(value, dict):
            turned = self._by_axis(value, units)
            return {axis: self._frame.handedness * each for axis, each in turned.items()}
        return self._frame.handedness * self._number(value, units)

    def _springs(self, springs: dict[str, float]) -> dict[str, float]:
        units = (self._force[0] - 1.0, 1, 0)
        return {self._axis(axis): self._number(each, units) for axis, each in springs.items()}

    def _extents(self, value: Any) -> Any:
        """A number for all axes, or one for each."""
        if not isinstance(value, list):
            return value
        return [value[self._frame.source(k)] for k in range(self._dim)]

    def _tensor(self, stress: list[float]) -> list[float]:
        all_six = np.array([*stress, 0.0, 0.0][:6]) * self._unit(STRESS)
        return self._frame.tensor(all_six).tolist()[: len(stress)]

    def _range(self, table: dict[str, list[float]]) -> dict[str, list[float]]:
        found = {}
        for axis, ends in table.items():
            new, sign = self._frame.axis(AXES.index(axis))
            found[AXES[new]] = sorted(self._coordinate(end, new, sign) for end in ends)
        return found

    def _cell_size(self, size: Any) -> Any:
        if not isinstance(size, dict):
            return self._number(size, LENGTH)
        found: dict[str, Any] = {}
        for axis, rows in size.items():
            new, sign = self._frame.axis(AXES.index(axis))
            found[AXES[new]] = self._number(rows, LENGTH) if isinstance(rows, float) else sorted(
                [self._coordinate(at, new, sign), self._number(each, LENGTH)] for at, each in rows
            )  # fmt: skip
        return found

    def _origin(self, grid: Tree) -> list[float]:
        """The origin of a grid in the new frame: along a graded axis the first place."""
        sizes = [grid["cell_size"][axis] for axis in AXES[: self._dim]]
        return [
            rows[0][0] if isinstance(rows, list) else at
            for rows, at in zip(sizes, grid["origin"], strict=True)
        ]

    def _box(self, table: Tree) -> Tree:
        corners = self._frame.place(np.array([table["lower"], table["upper"]]))
        return {"lower": corners.min(axis=0).tolist(), "upper": corners.max(axis=0).tolist()}
