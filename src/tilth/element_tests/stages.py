# SPDX-License-Identifier: BSD-3-Clause
"""The stages of each element test: which strains and which stresses are given, and how they grow.

Inside this package tension is positive, as in all of tilth but the declarations and the tables of
element tests.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.element_tests.kinematics import Kinematics, along_planes, without_rotation
from tilth.element_tests.point import ElementPoint
from tilth.model.element_tests import (
    COMPONENTS,
    Biaxial,
    ElementTest,
    IsotropicCompression,
    Oedometer,
    SimpleShear,
    StressState,
    StressStrainPath,
    Triaxial,
)
from tilth.mpm.interval import Interval

XX, YY, ZZ, XY = range(4)
NORMAL = [XX, YY, ZZ]


@dataclass
class Specimen:
    """The specimen while it is tested.

    Attributes:
        point: its state.
        strain: components that its stage controls, see `kinematics.py` [-], shape (6,).
        time: since the test began [time].
    """

    point: ElementPoint
    strain: Floats
    time: float = 0.0


@dataclass(frozen=True)
class Stage:
    """Given strains and stresses from the start to the end of a stage, and its steps.

    Attributes:
        kinematics: deformation gradient of the strains.
        stressed: whether the stress of a component is given, not its strain, shape (6,).
        start, end: stress [stress] or strain [-] of each component, shape (6,).
        steps: number of steps.
        tied: whether the strains xx and zz are equal: the mean of their stresses is then given.
        logarithmic: whether stresses that do not begin or end with 0 grow by equal ratios.
        total: a component and its total stress [stress], which remains while the volume is
            constant: less the effective stress it is the pore pressure. None in drained stages, and
            for laws with a pore fluid of their own.
        duration: of the stage [time]; 1 where the test declares no times.
    """

    kinematics: Kinematics
    stressed: Flags
    start: Floats
    end: Floats
    steps: int
    tied: bool = False
    logarithmic: bool = False
    total: tuple[int, float] | None = None
    duration: float = 1.0

    def interval(self, time: float, before: float, after: float) -> Interval:
        """Returns that of a step between fractions of the stage, which begins at a time."""
        return Interval(before * self.duration, time, (after - before) * self.duration)

    def pore_pressure(self, point: ElementPoint) -> float | None:
        """Returns the excess pore pressure [stress], compression positive; None if drained."""
        if point.has_pore_fluid:
            return point.excess_pore_pressure
        if self.total is None:
            return None
        component, total = self.total
        return float(point.stress[component] - total)

    def given(self, fraction: float) -> Floats:
        """Returns stress or strain of each component after a fraction of the stage, (6,)."""
        linear = self.start + fraction * (self.end - self.start)
        by_ratio = self.stressed & (self.start * self.end > 0.0) & self.logarithmic
        start, end = np.where(by_ratio, self.start, 1.0), np.where(by_ratio, self.end, 1.0)
        return np.where(by_ratio, start * (end / start) ** fraction, linear)

    @property
    def unknowns(self) -> Floats:
        """Strains by unknown: strain = given strain + unknowns @ z; shape (6, unknowns)."""
        columns = np.eye(6)[:, self.stressed]
        if self.tied and self.stressed[XX]:
            columns = columns[:, [c for c in range(columns.shape[1]) if not columns[ZZ, c]]]
            columns[ZZ] = columns[XX]
        return columns


def stages_of(test: ElementTest, specimen: Specimen) -> Iterator[Stage]:
    """Yields the stages of a test; the specimen must have gone through each before the next."""
    if isinstance(test, Oedometer):
        yield from _compression(test, specimen, [YY], test.vertical_stress, test.vertical_strain)
    elif isinstance(test, IsotropicCompression):
        volumetric = test.volumetric_strain
        each = None if volumetric is None else [strain / 3.0 for strain in volumetric]
        yield from _compression(test, specimen, NORMAL, test.pressure, each)
    elif isinstance(test, Triaxial):
        yield from _consolidation(test, specimen, test.consolidation)
        yield _axial(test, specimen, lateral=[XX, ZZ])
    elif isinstance(test, Biaxial):
        yield from _consolidation(test, specimen, test.consolidation)
        yield _axial(test, specimen, lateral=[XX])
    elif isinstance(test, SimpleShear):
        yield from _consolidation(test, specimen, test.consolidation)
        yield from _simple_shear(test, specimen)
    elif isinstance(test, StressStrainPath):
        yield from _path(test, specimen)
    else:
        raise TypeError(f"{type(test).__name__} is no kind of element test")


def start_stress(state: StressState) -> Floats:
    """Returns the stress [stress], shape (6,), tension positive, of a declared state."""
    return np.array([*(-value for value in state.normal), 0.0, 0.0, 0.0])


def _compression(
    test: ElementTest,
    specimen: Specimen,
    loaded: list[int],
    stresses: Sequence[float] | None,
    strains: Sequence[float] | None,
) -> Iterator[Stage]:
    """Loads components one after the other to stresses or strains, compression positive."""
    stressed = np.zeros(6, dtype=bool)
    stressed[loaded] = stresses is not None
    for target in (strains if stresses is None else stresses) or ():
        start = np.where(stressed, specimen.point.stress, specimen.strain)
        end = start.copy()
        end[loaded] = -target
        yield Stage(without_rotation, stressed, start, end, test.steps, logarithmic=True)


def _consolidation(
    test: ElementTest, specimen: Specimen, state: StressState | None
) -> Iterator[Stage]:
    """All normal stresses to those of a state, drained."""
    if state is not None:
        stressed = _flags(NORMAL)
        start = np.where(stressed, specimen.point.stress, specimen.strain)
        end = np.where(stressed, start_stress(state), specimen.strain)
        yield Stage(without_rotation, stressed, start, end, test.steps, tied=True)


def _axial(test: Triaxial | Biaxial, specimen: Specimen, lateral: list[int]) -> Stage:
    """Vertical strain with constant lateral stress, or without change of volume."""
    strain = test.axial_strain * (-1.0 if test.direction == "compression" else 1.0)
    isochoric = _isochoric(test.drainage, specimen.point)
    stressed = _flags([] if isochoric else lateral)
    start = np.where(stressed, specimen.point.stress, specimen.strain)
    end = start.copy()
    end[YY] += strain
    if isochoric:
        end[lateral] -= strain / len(lateral)
    return Stage(
        without_rotation, stressed, start, end, test.steps,
        tied=len(lateral) == 2, total=(XX, specimen.point.stress[XX]) if isochoric else None,
    )  # fmt: skip


def _simple_shear(test: SimpleShear, specimen: Specimen) -> Iterator[Stage]:
    """Shear strains one after the other, at constant vertical stress or constant height.

    A pore fluid of the law is sheared at constant total vertical stress.
    """
    isochoric = _isochoric(test.drainage, specimen.point)
    stressed = _flags([] if isochoric else [YY])
    total = (YY, float(specimen.point.stress[YY])) if isochoric else None
    for target in test.shear_strain:
        start = np.where(stressed, specimen.point.stress, specimen.strain)
        end = start.copy()
        end[XY] = target
        yield Stage(along_planes, stressed, start, end, test.steps, total=total)


def _path(test: StressStrainPath, specimen: Specimen) -> Iterator[Stage]:
    """A stage between any two times of the tables."""
    stressed = _flags([COMPONENTS.index(key) for key in test.stress])
    tables = {**test.stress, **test.strain}
    times = sorted({row[0] for table in tables.values() for row in table})

    def given(time: float) -> Floats:
        values = np.zeros(6)
        for key, table in tables.items():
            rows = np.array(table)
            sign = -1.0 if key in COMPONENTS[:3] else 1.0
            values[COMPONENTS.index(key)] = sign * np.interp(time, rows[:, 0], rows[:, 1])
        return values

    for before, after in pairwise(times):
        yield Stage(
            without_rotation, stressed, given(before), given(after), test.steps,
            duration=after - before,
        )  # fmt: skip


def _isochoric(drainage: str, point: ElementPoint) -> bool:
    """Whether a stage keeps the volume: a pore fluid of the law does so by itself."""
    return drainage == "undrained" and not point.has_pore_fluid


def _flags(components: list[int]) -> Flags:
    flags = np.zeros(6, dtype=bool)
    flags[components] = True
    return flags
