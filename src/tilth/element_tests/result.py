# SPDX-License-Identifier: BSD-3-Clause
"""The table of an element test. Compression is positive in it, as in a laboratory's reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.element_tests.point import ElementPoint
from tilth.model import Biaxial, ElementTest, SimpleShear, StressStrainPath, Units
from tilth.model.element_tests import COMPONENTS
from tilth.model.laws import EXCESS_PORE_PRESSURE

_SIGNED = frozenset({
    "axial_strain", "volumetric_strain", "p", EXCESS_PORE_PRESSURE, "p_total",
    *(f"{tensor}_{each}" for tensor in ("stress", "strain") for each in COMPONENTS[:3]),
})  # fmt: skip
_NORMAL = np.array([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0])


@dataclass(frozen=True)
class Row:
    """The state after a step.

    Attributes:
        stage: number of its stage from 1 on; 0 at the start.
        point: the point.
        strain: components that the stage controls, tension positive [-], shape (6,).
        iterations: Newton iterations of the step.
        pore_pressure: excess pore pressure [stress], compression positive; None if drained.
    """

    stage: int
    point: ElementPoint
    strain: Floats
    iterations: int
    pore_pressure: float | None


@dataclass(frozen=True)
class ElementResult:
    """The table of one test with one material.

    Attributes:
        test, material: their names.
        columns: by name, shape (steps + 1,) each; normal stresses and strains compression positive,
            shear xy yz xz with the sign of mechanics. Stresses are Cauchy stresses, p, q and
            stress_xx to stress_xz effective ones; normal strains are logarithmic.
        units: label of each column's unit, "-" if it has none, "" for numbers of steps.
        signed: columns in which compression is positive.
        stopped: where and why the test ended early; "" if it did not.
    """

    test: str
    material: str
    columns: dict[str, Floats]
    units: dict[str, str]
    signed: frozenset[str]
    stopped: str = ""

    def __getitem__(self, column: str) -> Floats:
        return self.columns[column]

    def headings(self) -> list[str]:
        """Returns the headings of the columns, with sign convention and unit."""
        return [self.heading(name) for name in self.columns]

    def heading(self, name: str) -> str:
        """Returns the heading of a column, such as `p (compression positive) [kPa]`."""
        sign = " (compression positive)" if name in self.signed else ""
        return f"{name}{sign} [{self.units[name]}]" if self.units[name] else name


def result_of(
    test: ElementTest, material: str, units: Units, rows: Sequence[Row], stopped: str
) -> ElementResult:
    """Returns the table of the rows of a test; `stopped` as in `ElementResult`."""
    points = [row.point for row in rows]
    strain = np.array([row.strain for row in rows]) * _NORMAL
    pore = np.array([0.0 if row.pore_pressure is None else row.pore_pressure for row in rows])
    own = np.array([point.excess_pore_pressure for point in points])
    stress = np.array([point.stress for point in points]) * _NORMAL
    stress[:, :3] -= own[:, None]
    jacobian = np.array([point.jacobian for point in points])
    mean = stress[:, :3].mean(axis=1)
    table: dict[str, tuple[Floats, str]] = {
        "step": (np.arange(float(len(rows))), ""),
        "stage": (np.array([float(row.stage) for row in rows]), ""),
        "axial_strain": (strain[:, 1], "-"),
        "volumetric_strain": (-np.log(jacobian), "-"),
    }
    if isinstance(test, SimpleShear):
        table["shear_strain"] = (strain[:, 3], "-")
    if test.void_ratio is not None:
        table["void_ratio"] = ((1.0 + test.void_ratio) * jacobian - 1.0, "-")
    table["p"] = (mean, units.stress)
    table["q"] = (_deviator(test, stress), units.stress)
    if any(row.pore_pressure is not None for row in rows):
        table[EXCESS_PORE_PRESSURE] = (pore, units.stress)
        table["p_total"] = (mean + pore, units.stress)
    for k, component in enumerate(COMPONENTS):
        table[f"stress_{component}"] = (stress[:, k], units.stress)
    for k, component in enumerate(COMPONENTS):
        table[f"strain_{component}"] = (strain[:, k], "-")
    plastic = np.array([point.plastic for point in points])
    table["plastic_strain"] = (plastic[:, 0], "-")
    table["plastic_dissipation"] = (plastic[:, 1], units.stress)
    for k, (name, unit) in enumerate(points[0].law.state_variables.items()):
        if name != EXCESS_PORE_PRESSURE:
            label = units.stress if unit == "stress" else unit
            table[name] = (np.array([point.state[k] for point in points]), label)
    table["iterations"] = (np.array([float(row.iterations) for row in rows]), "")
    columns = {name: column + 0.0 for name, (column, _) in table.items()}  # no -0.0
    labels = {name: unit for name, (_, unit) in table.items()}
    signed = _SIGNED | {"q"} if _has_axis(test) else _SIGNED
    return ElementResult(test.name, material, columns, labels, signed, stopped)


def _has_axis(test: ElementTest) -> bool:
    """Whether the state of stress is symmetric about the vertical axis."""
    return not isinstance(test, Biaxial | SimpleShear | StressStrainPath)


def _deviator(test: ElementTest, stress: Floats) -> Floats:
    """Returns q [stress]: axial less radial stress where the test has an axis, else sqrt(3 J2)."""
    if _has_axis(test):
        return np.asarray(stress[:, 1] - 0.5 * (stress[:, 0] + stress[:, 2]))
    deviator = stress[:, :3] - stress[:, :3].mean(axis=1, keepdims=True)
    shear = 2.0 * (stress[:, 3:] ** 2).sum(axis=1)
    return np.asarray(np.sqrt(1.5 * ((deviator**2).sum(axis=1) + shear)))
