# SPDX-License-Identifier: BSD-3-Clause
"""What the labels of `[units]` mean, where one knows them; nothing is guessed of others."""

from __future__ import annotations

import re

LENGTHS = {
    "m": 1.0,
    "mm": 1e-3,
    "cm": 1e-2,
    "dm": 0.1,
    "km": 1e3,
    "um": 1e-6,
    "ft": 0.3048,
    "in": 0.0254,
    "yd": 0.9144,
}
"""Lengths [m]."""

MASSES = {
    "kg": 1.0,
    "g": 1e-3,
    "mg": 1e-6,
    "t": 1e3,
    "Mg": 1e3,
    "kt": 1e6,
    "Gg": 1e6,
    "lb": 0.45359237,
    "lbm": 0.45359237,
    "slug": 14.59390294,
    "slugs": 14.59390294,
    "slinch": 175.1268352,
    "blob": 175.1268352,
}
"""Masses [kg]."""

POUND = 4.4482216152605
"""A pound as a force [N]."""

FORCES = {
    "N": 1.0,
    "kN": 1e3,
    "MN": 1e6,
    "GN": 1e9,
    "mN": 1e-3,
    "dyn": 1e-5,
    "kgf": 9.80665,
    "tf": 9806.65,
    "lb": POUND,
    "lbf": POUND,
    "kip": 1e3 * POUND,
    "kips": 1e3 * POUND,
    "pdl": 0.138254954376,
}
"""Forces [N]."""

PSF = POUND / LENGTHS["ft"] ** 2
PSI = POUND / LENGTHS["in"] ** 2

STRESSES = {
    "Pa": 1.0,
    "hPa": 1e2,
    "kPa": 1e3,
    "MPa": 1e6,
    "GPa": 1e9,
    "bar": 1e5,
    "mbar": 1e2,
    "psf": PSF,
    "ksf": 1e3 * PSF,
    "psi": PSI,
    "ksi": 1e3 * PSI,
}
"""Stresses [Pa]."""

TIMES = {
    "s": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "min": 60.0,
    "h": 3600.0,
    "d": 86400.0,
    "day": 86400.0,
    "days": 86400.0,
}
"""Times [s]."""

_FRACTION = re.compile(r"(\w+)\s*/\s*(\w+?)(\^?[23]|[²³])?")

_POWERS = {None: 1, "2": 2, "^2": 2, "²": 2, "3": 3, "^3": 3, "³": 3}


def length_of(label: str) -> float | None:
    """Returns the length with a label [m]; None if one does not know it."""
    return LENGTHS.get(label.strip())


def mass_of(label: str) -> float | None:
    """Returns the mass with a label [kg]; None if one does not know it."""
    return MASSES.get(label.strip())


def time_of(label: str) -> float | None:
    """Returns the time with a label [s]; None if one does not know it."""
    return TIMES.get(label.strip())


def force_of(label: str, length: float) -> float | None:
    """Returns the force with a label [N], also of one per length as kN/m; None if unknown.

    length: unit of length of the case [m], over which such a force acts.
    """
    top, below, power = _parts(label)
    if not below:
        return FORCES.get(top)
    if power == 1 and top in FORCES and below in LENGTHS:
        return FORCES[top] / LENGTHS[below] * length
    return None


def stress_of(label: str) -> float | None:
    """Returns the stress with a label [Pa], also of one as kN/m2; None if one does not know it."""
    top, below, power = _parts(label)
    if not below:
        return STRESSES.get(top)
    if power == 2 and top in FORCES and below in LENGTHS:
        return FORCES[top] / LENGTHS[below] ** 2
    return None


def label_of(value: float, labels: dict[str, float]) -> str:
    """Returns the first of some labels with a value; "" if none has it."""
    return next((label for label, each in labels.items() if same(value, each)), "")


def same(one: float, other: float) -> bool:
    """Returns whether two units are one, up to the rounding of tables."""
    return abs(one - other) <= 1e-4 * abs(other)


def _parts(label: str) -> tuple[str, str, int]:
    """Returns numerator, denominator ("" if there is none) and its power."""
    found = _FRACTION.fullmatch(label.strip())
    if found is None:
        return label.strip(), "", 1
    return found[1], found[2], _POWERS[found[3]]
