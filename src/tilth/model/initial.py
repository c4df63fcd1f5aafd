# SPDX-License-Identifier: BSD-3-Clause
"""The state of the bodies at the start: their stress, velocity and pore pressure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, Field, PlainValidator, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared, chosen_by
from tilth.model.fields import (
    LEAST,
    AngularVelocity,
    AsTuple,
    Count,
    Entries,
    FileName,
    Flag,
    Name,
    NotNegative,
    Real,
    Vector,
    real,
)
from tilth.model.problems import dotted, reject, rejection
from tilth.model.variation import (
    Level,
    VaryingNotNegative,
    VaryingPositive,
    VaryingReal,
    or_varying,
    variations,
)

JAKY = "1-sin_phi"
"""The coefficient of earth pressure at rest that follows from the friction angle."""


def _at_rest(value: Any) -> float | str:
    if isinstance(value, str):
        if value == JAKY:
            return JAKY
        raise reject(f'must be a number or "{JAKY}"')
    if (number := real(value)) < LEAST:
        raise reject("must be greater than zero")
    return number


def _overconsolidated(value: float) -> float:
    if value < 1.0:
        remedy = "it is the greatest past over the present vertical effective stress"
        raise reject("must be at least 1", remedy)
    return value


CoefficientAtRest = Annotated[float | str, PlainValidator(_at_rest)]
if TYPE_CHECKING:  # for type checkers a number: `tilth.variation` evaluates all else
    Overconsolidation = Real
else:
    Overconsolidation = or_varying(Annotated[Real, AfterValidator(_overconsolidated)])

_ALTERNATIVES = (("K0", "K0_nc"), ("overconsolidation_ratio", "pre_overburden_pressure"))


class _WithPast(Declared):
    """Of two entries that say the same in two ways, one is given."""

    @model_validator(mode="after")
    def _one_way(self) -> Any:
        problems = []
        for one, other in _ALTERNATIVES:
            value = getattr(self, other)
            if value is not None and getattr(self, one) is not None:
                what = f"is given together with `{one}`"
                problems.append(Problem(other, what, f"give one of `{one}` and `{other}`", value))
        if problems:
            raise rejection(problems)
        return self


class GivenStress(Declared):
    """The same stress at all points of a body."""

    type: Literal["given"] = "given"
    body: Name
    """Name of the body."""
    stress: Vector
    """Effective Cauchy stress [stress], tension positive: xx, yy, zz, xy in 2D (in axisymmetry xx
    is radial, yy axial, zz hoop), xx, yy, zz, xy, yz, xz in 3D."""


class MaterialAtRest(_WithPast):
    """What one material of a body has of its own; the entry of the body gives the rest."""

    K0: CoefficientAtRest | None = None
    """Coefficient of earth pressure at rest of this material, as in the entry of the body."""
    K0_nc: CoefficientAtRest | None = None
    """That of its first loading, in place of `K0`, as in the entry of the body."""
    overconsolidation_ratio: Overconsolidation | None = None
    """Overconsolidation ratio of this material, as in the entry of the body."""
    pre_overburden_pressure: VaryingNotNegative | None = None
    """Pre-overburden pressure of this material, as in the entry of the body."""


MaterialsAtRest = Mapping[Name, MaterialAtRest]


class AtRest(_WithPast):
    """Stress at rest: the weight above acts vertically, K0 times the effective stress sideways.

    The weight is that of all declared soil vertically above the point, of its own body and of
    others, under the body force that acts at time 0, which must be vertical. The effective normal
    stresses are -sigma_v along the vertical axis and -K0 sigma_v across it. They are in equilibrium
    under level ground; elsewhere the equilibrium that is found before the first step changes them.
    """

    type: Literal["k0"] = "k0"
    body: Name
    """Name of the body."""
    K0: CoefficientAtRest | None = None
    """Coefficient of earth pressure at rest [-], > 0: horizontal over vertical effective stress; or
    "1-sin_phi" for (1 - sin(phi)) OCR^sin(phi) with the friction angle of each material (Jaky 1944;
    Mayne and Kulhawy 1982). With Drucker-Prager and Cam Clay the angle is that in triaxial
    compression. Overconsolidated soil has at most (1 + sin(phi)) / (1 - sin(phi)). This or `K0_nc`
    is required, unless `materials` gives it for each material of the body."""
    K0_nc: CoefficientAtRest | None = None
    """In place of `K0`, the coefficient of first loading [-], > 0, or "1-sin_phi", for soil that
    was then unloaded elastically: K0 = K0_nc OCR - nu / (1 - nu) (OCR - 1) with Poisson's ratio nu
    of each material. It needs one of the two next entries, and has the same greatest value."""
    overconsolidation_ratio: Overconsolidation | None = None
    """OCR [-], >= 1: greatest past over present vertical effective stress, for "1-sin_phi", `K0_nc`
    and the preconsolidation of Cam Clay, whose material then gives none. Its past stress was
    OCR sigma_v, and (1 - sin(phi)) OCR sigma_v sideways, or K0_nc OCR sigma_v. 1 for "1-sin_phi" if
    neither this nor the next entry is given. A number, or varying like a parameter of a material.
    """
    pre_overburden_pressure: VaryingNotNegative | None = None
    """In place of the ratio, POP [stress], >= 0: greatest past less present vertical effective
    stress, so that OCR = (sigma_v + POP) / sigma_v at each point."""
    materials: MaterialsAtRest = Field(default_factory=dict)
    """Values of single materials of the body, by the material's name, such as
    { clay = { K0 = 0.6 } }."""
    ground: Level | None = None
    """Elevation of the ground [length]: a number, in 2D also a polyline of rows (x, elevation), or
    { file = "ground.csv" } with a grid over the horizontal axes. What lies above it has no weight;
    where no body fills the space below it, as in a hole, it counts as soil of the body at that
    height. If not given, what the declared bodies contain is all that has weight."""
    surcharge: NotNegative = 0.0
    """Vertical pressure on the ground [stress], >= 0; a load of the same size must act on it."""

    def parts(self) -> list[tuple[str, Declared]]:
        """Returns the entry and those of single materials, with their keys in it."""
        of_materials = [(dotted(("materials", name)), own) for name, own in self.materials.items()]
        return [("", self), *of_materials]


class GravityStress(Declared):
    """Stress by gravity loading: all loads that act at time 0 grow from zero before the first step.

    The soil follows its law, so that the stress obeys equilibrium and strength; the displacement of
    this loading is then removed. The ratio of horizontal to vertical stress results from the law
    (nu / (1 - nu) under level elastic ground).
    """

    type: Literal["gravity"] = "gravity"
    body: Name
    """Name of the body."""
    steps: Count = 10
    """Equal parts in which the loads are applied; the most of all bodies counts. A part without
    equilibrium is halved."""


class TableStress(Declared):
    """Effective stress by tables over depth or elevation, from a grid file or a function.

    Each entry is a number, or varies as the parameters of a material do, such as
    { depth = [[0, 0], [10, 95e3]], surface = 0.0 }.
    """

    type: Literal["table"] = "table"
    body: Name
    """Name of the body."""
    vertical_pressure: VaryingNotNegative
    """Vertical effective stress, compression positive [stress], >= 0."""
    K0: VaryingPositive | None = None
    """Horizontal over vertical effective stress [-], > 0; this or `horizontal_pressure`."""
    horizontal_pressure: VaryingNotNegative | None = None
    """Horizontal effective stress, compression positive [stress], >= 0."""

    @model_validator(mode="after")
    def _one_horizontal_stress(self) -> Any:
        if (self.K0 is None) == (self.horizontal_pressure is None):
            given = self.K0 is not None
            what = "given together with `horizontal_pressure`" if given else "missing"
            remedy = "give exactly one of `K0` and `horizontal_pressure`"
            raise rejection([Problem("K0", what, remedy)])
        return self


class StressOfRun(Declared):
    """Stress and state variables of the soil of another run, at the same places.

    Points at the place of a point of that run have its state. Elsewhere it is interpolated linearly
    between the points of the other run's body, at its edge it is that of the nearest point.
    Where water flows in that run it is the effective stress; the excess pore pressure begins at 0.
    """

    type: Literal["run"] = "run"
    body: Name
    """Name of the body."""
    folder: FileName
    """Folder of the other run, relative to the case file."""
    source: Name | None = None
    """Name of the body in the other run; the same if not given."""
    time: Real | None = None
    """Time of an output of the other run; its last one if not given."""


InitialStress = Annotated[
    GivenStress | AtRest | GravityStress | TableStress | StressOfRun,
    Field(discriminator="type"),
    chosen_by("type", GivenStress, AtRest, GravityStress, TableStress, StressOfRun),
]


class InitialVelocity(Declared):
    """Velocity of a body at the start: a translation, a rotation about a centre, or both.

    A component is a number, or varies from place to place as the parameters of a material do.
    """

    body: Name
    """Name of the body."""
    x: VaryingReal = 0.0
    """Velocity along x [length/time]; in axisymmetry along the radius."""
    y: VaryingReal = 0.0
    """Velocity along y [length/time]."""
    z: VaryingReal = 0.0
    """Velocity along z [length/time], in 3D."""
    angular_velocity: AngularVelocity | None = None
    """Angular velocity [radians/time], not in axisymmetry: a number in 2D, positive from x to y; a
    vector in 3D."""
    centre: Vector | None = None
    """Centre of this rotation [length], shape (dimension,)."""

    @model_validator(mode="after")
    def _centre_of_rotation(self) -> Any:
        if (self.angular_velocity is None) != (self.centre is None):
            given = self.centre is not None
            key = "angular_velocity" if given else "centre"
            remedy = "give both, or neither"
            raise rejection([Problem(key, "missing: a rotation has both", remedy)])
        if self.angular_velocity is None and not {"x", "y", "z"} & self.model_fields_set:
            what, remedy = "has no velocity", "give `x`, `y`, `z` or a rotation, or leave it out"
            raise rejection([Problem("", what, remedy)])
        return self


class InitialPorePressure(Declared):
    """Excess pore pressure of a body at the start, where water flows."""

    body: Name
    """Name of the body; water flows through at least one of its materials."""
    excess_pore_pressure: VaryingReal
    """Excess over the water at rest [stress], compression positive: a number, or varying from place
    to place as the parameters of a material do. The stress of [[initial.stress]] is the effective
    one; the total one is that less the pore pressure.
    """


InitialPorePressures = Annotated[Sequence[InitialPorePressure], Entries, AsTuple]
InitialVelocities = Annotated[Sequence[InitialVelocity], Entries, AsTuple]
InitialStresses = Annotated[Sequence[InitialStress], Entries, AsTuple]


class Initial(Declared):
    """State at time 0; bodies that are not named start without stress.

    If a stress is declared, the equilibrium with the loads and boundaries at time 0 is found before
    the first step, with the soil at its declared places.
    """

    stress: InitialStresses = ()
    """Stress of bodies, an entry [[initial.stress]] for each."""
    velocity: InitialVelocities = ()
    """Velocity of bodies, an entry [[initial.velocity]] for each; bodies without one are at rest.
    With `analysis.inertia` only."""
    pore_pressure: InitialPorePressures = ()
    """Excess pore pressure of bodies, an entry [[initial.pore_pressure]] for each; bodies without
    one have none. With `[flow]` only."""
    equilibrium: Flag = True
    """Whether equilibrium is found before the first step; without it the first step has to balance
    what the declared stress does not."""
    reset_plastic_strain: Flag = False
    """Whether the equivalent plastic strain begins with zero after this equilibrium."""

    def functions(self) -> list[Any]:
        """Returns the functions of the user, "file.py:name", that give a part of the state."""
        found = [v for _, each in self.entries() for v in variations(each).values()]
        return [getattr(each, "function", None) for each in found]

    def entries(self) -> Iterator[tuple[str, Declared]]:
        """Yields the entries of all bodies, and those of single materials in them, with keys."""
        for i, each in enumerate(self.stress):
            parts = each.parts() if isinstance(each, AtRest) else [("", each)]
            for key, part in parts:
                yield f"initial.stress[{i}]{'.' if key else ''}{key}", part
        for i, velocity in enumerate(self.velocity):
            yield f"initial.velocity[{i}]", velocity
        for i, pressure in enumerate(self.pore_pressure):
            yield f"initial.pore_pressure[{i}]", pressure

    def of(self, body: str) -> tuple[str, InitialStress] | None:
        """Returns the key and the entry of a body's stress; None without one."""
        found = (i for i, each in enumerate(self.stress) if each.body == body)
        i = next(found, None)
        return None if i is None else (f"initial.stress[{i}]", self.stress[i])
