# SPDX-License-Identifier: BSD-3-Clause
"""Element tests: one material point along the paths of a laboratory.

In these declarations, unlike in those of an analysis, compression is positive, for normal stresses
and normal strains. Stresses are effective Cauchy stresses, normal strains logarithmic. y is the
vertical (axial) direction, x and z are the horizontal (lateral) ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared, chosen_by
from tilth.model.fields import (
    LEAST,
    AsTuple,
    CellName,
    Count,
    Name,
    NotNegative,
    Positive,
    Table,
    Vector,
    as_list,
)
from tilth.model.problems import reject, rejection

Drainage = Literal["drained", "undrained"]
Component = Literal["xx", "yy", "zz", "xy", "yz", "xz"]
COMPONENTS: tuple[Component, ...] = get_args(Component)

MOST_STEPS = 100_000
"""Steps of a stage of an element test, at most."""

GREATEST_STRAIN = 5.0
"""Greatest magnitude of a logarithmic or shear strain of an element test."""

_SAME = 1e-9
"""Relative difference up to which a path's first stress is the stress at the start."""


def _steps(value: int) -> int:
    if value > MOST_STEPS:
        raise reject(f"must be at most {MOST_STEPS:,}")
    return value


def _strain(value: float) -> float:
    if abs(value) > GREATEST_STRAIN:
        what = f"is greater than {GREATEST_STRAIN:g} in magnitude"
        raise reject(what, "give strains as numbers, not in percent")
    return value


def _targets(value: Any) -> Any:
    listed = as_list(value)
    if listed == []:
        raise reject("must not be empty", "give at least one value")
    return [value] if listed is None else listed


def _strains(values: Sequence[float]) -> Sequence[float]:
    for value in values:
        _strain(value)
    return values


def _pressures(values: Sequence[float]) -> Sequence[float]:
    if min(values) < LEAST:
        raise reject("must be greater than zero", "compression is positive in element tests")
    return values


def _names(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


def _distinct_and_some(value: tuple[str, ...]) -> tuple[str, ...]:
    if not value:
        raise reject("must not be empty", "give at least one name")
    if len(set(value)) != len(value):
        raise reject("has a name twice", "give each name once")
    return value


Steps = Annotated[Count, AfterValidator(_steps)]
Strains = Annotated[Vector, BeforeValidator(_targets, float | Vector), AfterValidator(_strains)]
Pressures = Annotated[Vector, BeforeValidator(_targets, float | Vector), AfterValidator(_pressures)]
AxialStrain = Annotated[Positive, AfterValidator(_strain)]
Names = Annotated[
    Sequence[Name],
    BeforeValidator(_names, str | Sequence[str]),
    AsTuple,
    AfterValidator(_distinct_and_some),
]
Tables = Mapping[Component, Table]


class StressState(Declared):
    """A state of effective stress without shear: `isotropic`, or `vertical` and `K0`."""

    isotropic: NotNegative | None = None
    """Equal stress in all directions [stress], >= 0, compression positive."""
    vertical: Positive | None = None
    """Vertical stress [stress], > 0, compression positive."""
    K0: NotNegative | None = None
    """Horizontal over vertical effective stress [-], >= 0."""

    @model_validator(mode="after")
    def _one_way(self) -> Any:
        remedy = "give `isotropic`, or `vertical` and `K0`"
        if self.isotropic is not None:
            problems = [
                Problem(key, "given together with `isotropic`", remedy, getattr(self, key))
                for key in ("vertical", "K0")
                if getattr(self, key) is not None
            ]
        else:
            problems = [
                Problem(key, "missing", remedy)
                for key in ("vertical", "K0")
                if getattr(self, key) is None
            ]
        if problems:
            raise rejection(problems)
        return self

    @property
    def normal(self) -> tuple[float, float, float]:
        """Stresses xx, yy (vertical) and zz [stress], compression positive."""
        if self.isotropic is not None:
            return (self.isotropic,) * 3
        assert self.vertical is not None
        assert self.K0 is not None
        return (self.K0 * self.vertical, self.vertical, self.K0 * self.vertical)


class ElementTest(Declared):
    """What all element tests have. Use one of its kinds."""

    name: CellName
    """Name of the test, unique; its table has this name."""
    material: Names
    """Name of the material, or a list of names: the test is made with each of them."""
    start: StressState
    """Effective stress at the start of the test, where all strains are 0."""
    steps: Steps
    """Number of steps of each stage of the test."""
    void_ratio: Positive | None = None
    """Void ratio e at the start [-], > 0; if given, the table has it: 1 + e is in proportion to the
    volume, as the grains keep theirs.
    """


class Oedometer(ElementTest):
    """Vertical loading without lateral strain; give one of `vertical_stress`, `vertical_strain`."""

    type: Literal["oedometer"] = "oedometer"
    vertical_stress: Pressures | None = None
    """Vertical effective stress to which the specimen is loaded or unloaded [stress], > 0; a list
    is followed in order. From one stress to the next the steps are equal on a logarithmic scale, if
    neither is 0.
    """
    vertical_strain: Strains | None = None
    """Vertical logarithmic strain at the end [-]; a list is followed in order."""

    @model_validator(mode="after")
    def _one_target(self) -> Any:
        return _with_one_of(self, "vertical_stress", "vertical_strain")


class IsotropicCompression(ElementTest):
    """Equal strain or equal stress in all directions, from an isotropic stress."""

    type: Literal["isotropic"] = "isotropic"
    pressure: Pressures | None = None
    """Mean effective stress to which the specimen is loaded or unloaded [stress], > 0; a list is
    followed in order. From one to the next the steps are equal on a logarithmic scale, if neither
    is 0.
    """
    volumetric_strain: Strains | None = None
    """Logarithmic volumetric strain at the end [-]; a list is followed in order."""

    @model_validator(mode="after")
    def _one_target(self) -> Any:
        if self.start.isotropic is None:
            what = "an isotropic test starts from an isotropic stress"
            raise rejection([Problem("start.vertical", what, "give `isotropic`")])
        return _with_one_of(self, "pressure", "volumetric_strain")


class _Sheared(ElementTest):
    """Tests with a stage of shearing, after a consolidation if one is given."""

    drainage: Drainage
    """"drained", or "undrained": with constant volume while it is sheared."""
    consolidation: StressState | None = None
    """Effective stress to which the specimen is consolidated, drained, before it is sheared; that
    at the start if not given.
    """


class Triaxial(_Sheared):
    """Axial strain at constant lateral stress (total stress, if undrained)."""

    type: Literal["triaxial"] = "triaxial"
    direction: Literal["compression", "extension"]
    """Whether the specimen is shortened or lengthened."""
    axial_strain: AxialStrain
    """Magnitude of the logarithmic axial strain at the end of shearing [-], > 0."""


class Biaxial(_Sheared):
    """Plane strain: vertical strain at constant stress along x (total, if undrained), none along z.

    A consolidation is that of a triaxial test; the strain along z remains as it is after it.
    """

    type: Literal["biaxial"] = "biaxial"
    direction: Literal["compression", "extension"]
    """Whether the specimen is shortened or lengthened."""
    axial_strain: AxialStrain
    """Magnitude of the logarithmic vertical strain at the end of shearing [-], > 0."""


class SimpleShear(_Sheared):
    """Shear along x of planes normal to y, without lateral strain.

    Drained the vertical stress is constant, undrained the height.
    """

    type: Literal["simple_shear"] = "simple_shear"
    shear_strain: Strains
    """Displacement along x over the initial height [-]; a list is followed in order."""


class StressStrainPath(ElementTest):
    """A path of the user: each component of stress or of strain over time.

    Each of xx, yy and zz is in exactly one of `stress` and `strain`; so is xy, yz or xz, which has
    no strain if it is in neither. The deformation has no rotation: F is the exponential of the
    strain. Shear components have their sign in mechanics (xy along +x on the face with normal +y).
    """

    type: Literal["path"] = "path"
    stress: Tables = Field(default_factory=dict)
    """Effective Cauchy stress [stress] by component, rows (time, stress), linear between them;
    normal components compression positive. The first row is the stress at the start.
    """
    strain: Tables = Field(default_factory=dict)
    """Logarithmic strain [-] by component, rows (time, strain), linear between them; normal
    components compression positive. The first strain is 0.
    """

    @model_validator(mode="after")
    def _each_component_once(self) -> Any:
        if problems := [*self._control(), *self._first_rows()]:
            raise rejection(problems)
        return self

    def _control(self) -> list[Problem]:
        problems = [
            Problem(f"strain.{key}", "is in `stress`, too", "control it by one of the two")
            for key in self.strain
            if key in self.stress
        ]
        for key in COMPONENTS[:3]:
            if key not in self.strain and key not in self.stress:
                remedy = f"give rows (time, value) for `{key}` in `stress` or `strain`"
                problems.append(Problem(f"strain.{key}", "missing, and so in `stress`", remedy))
        return problems

    def _first_rows(self) -> list[Problem]:
        start = dict(zip(COMPONENTS, (*self.start.normal, 0.0, 0.0, 0.0), strict=True))
        problems = []
        for key, table in self.strain.items():
            if table[0][1] != 0.0:
                what, remedy = "does not begin with 0", "the specimen is not deformed at time 0"
                problems.append(Problem(f"strain.{key}", what, remedy, table))
            if any(abs(row[1]) > GREATEST_STRAIN for row in table):
                what = f"has a strain greater than {GREATEST_STRAIN:g} in magnitude"
                remedy = "give strains as numbers, not in percent"
                problems.append(Problem(f"strain.{key}", what, remedy, table))
        for key, table in self.stress.items():
            if abs(table[0][1] - start[key]) > _SAME * max(self.start.normal):
                what = f"does not begin with {start[key]:g}, the stress at the start"
                problems.append(Problem(f"stress.{key}", what, "change one of the two", table))
        return problems


def _with_one_of(test: ElementTest, first: str, second: str) -> Any:
    """Returns the test; refuses one with both or none of two keys."""
    given = [key for key in (first, second) if getattr(test, key) is not None]
    if len(given) != 1:
        what = "missing" if not given else f"given together with `{second}`"
        raise rejection([Problem(first, what, f"give exactly one of `{first}` and `{second}`")])
    return test


TESTS = (Oedometer, IsotropicCompression, Triaxial, SimpleShear, Biaxial, StressStrainPath)

AnyElementTest = Annotated[
    Oedometer | IsotropicCompression | Triaxial | SimpleShear | Biaxial | StressStrainPath,
    Field(discriminator="type"),
    chosen_by("type", *TESTS),
]
