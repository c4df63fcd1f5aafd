# SPDX-License-Identifier: BSD-3-Clause
"""What all materials declare, and how their entries become the parameters of a law."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, model_validator

from tilth.arrays import Floats
from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.davis import DavisForm
from tilth.model.fields import Flag, NotNegative, Positive, Real, Tensor
from tilth.model.laws import EXCESS_PORE_PRESSURE, Law, laws
from tilth.model.parameter_kinds import Kind, Values, is_reducible, reduced, stiffened
from tilth.model.problems import reject, rejection
from tilth.model.variation import VaryingModulus, VaryingPositive, VaryingShare, or_varying

Columns = Mapping[str, Values]
"""Parameters of a law by their names in the core."""

LARGEST_CONDUCTIVITY_RATIO = 1e4
"""Greatest principal conductivity of a soil over its least one, at most."""

LARGEST_PRESSURE_RATIO = 1e6
"""Bulk modulus of the pore fluid, at most, as a multiple of Young's modulus."""


_PERMEABILITIES = {"taylor": "permeability_change_index", "power": "permeability_exponent"}
"""Laws of the permeability with a number -> its key."""


@dataclass(frozen=True)
class ParametersAt:
    """The entries of a material at the points that it fills.

    Attributes:
        value: returns an entry by its key, one number or one for each point.
        cell_length: cube root of the volume of the grid cell around a point at the start, square
            root of its area in 2D [length]; one for each point where the grid is graded.
    """

    value: Callable[[str], Values]
    cell_length: Values


def _poisson_ratio(value: float) -> float:
    if not -1.0 < value < 0.5:
        raise reject(
            "must be greater than -1 and smaller than 0.5",
            "for a nearly incompressible material choose a value such as 0.49",
        )
    return value


if TYPE_CHECKING:
    PoissonRatio = Real
else:
    PoissonRatio = or_varying(Annotated[Real, AfterValidator(_poisson_ratio)])


def _ratio_problems(ratios: Sequence[Sequence[float]] | None) -> Iterator[Problem]:
    """Yields why ratios of conductivities, rows of a matrix, are no tensor that water flows by."""
    what = ""
    if ratios is None:
        return
    if any(len(row) != len(ratios) for row in ratios):
        what = "is no square matrix"
    elif (matrix := np.array(ratios)).shape and (matrix != matrix.T).any():
        what = "is not symmetric"
    elif (ends := np.linalg.eigvalsh(matrix)[[0, -1]])[0] <= 0.0:
        what = f"has the principal value {ends[0]:.3g}, which must be greater than zero"
    elif ends[1] > LARGEST_CONDUCTIVITY_RATIO * ends[0]:
        what = f"has principal values that differ more than {LARGEST_CONDUCTIVITY_RATIO:g} times"
    if what:
        remedy = "give one number > 0 per axis, such as [3.0, 1.0], or a symmetric matrix"
        yield Problem("conductivity_ratios", what, remedy, ratios)


class AnyMaterial(Declared):
    """What every material declares: density, and the parameters of its law."""

    is_plastic: ClassVar[bool] = False
    """Whether the law yields; the stresses then depend on the path of loading."""
    needs_stress: ClassVar[bool] = False
    """Whether the law has no state without stress."""
    has_shear_strength: ClassVar[bool] = False
    """Whether the law has the shear strength c + p tan(phi) that `shear_strength` returns."""
    kinds: ClassVar[Mapping[str, Kind]] = {
        "density": "density",
        "saturated_density": "density",
        "porosity": "dimensionless",
        "hydraulic_conductivity": "conductivity",
        "conductivity_ratios": "dimensionless",
        "permeability_change_index": "dimensionless",
        "permeability_exponent": "dimensionless",
    }
    """What each entry with a number, and each parameter of the law in the core, is."""
    state_kinds: ClassVar[Mapping[str, Kind]] = {}
    """What each state variable of the law in the core is."""
    model: str
    density: NotNegative | None = None
    """Mass per initial volume [mass / length^3], >= 0; required if a body force acts."""
    saturated_density: NotNegative | None = None
    """Mass per initial volume [mass / length^3] where the soil is below the water of `[water]`, not
    less than `density`. The pores stay full: water that leaves them when the volume shrinks takes
    its weight with it. Required there if a body force acts and the material is not `watertight`.
    """
    watertight: Flag | None = None
    """Whether water does not enter it, such as concrete: its density below the water is `density`,
    and it displaces water with its current volume; not if not given.
    """
    porosity: VaryingShare | None = None
    """Volume of the pores over the whole volume at the start [-], in (0, 1); with
    `hydraulic_conductivity`.
    """
    hydraulic_conductivity: VaryingPositive | None = None
    """Hydraulic conductivity k [length / time], > 0: with it water flows through the material by
    Darcy's law, in a model with `[flow]`; if not given no water enters or leaves its pores there.
    """
    conductivity_ratios: Tensor | None = None
    """Conductivities along the axes over `hydraulic_conductivity` [-], > 0, shape (dim,), such as
    [3.0, 1.0] where k is the vertical one; or a symmetric positive definite tensor, shape
    (dim, dim). It turns with the soil, R k R^T; all 1 if not given.
    """
    permeability: Literal["constant", "kozeny_carman", "taylor", "power"] | None = None
    """How the hydraulic conductivity k changes with the void ratio e = n / (1 - n), n the porosity:
    "constant"; "kozeny_carman", k in proportion to n^3 / (1 - n)^2; "taylor",
    log10(k / k0) = (e - e0) / C_k; or "power", k / k0 = (e / e0)^m. Constant if not given.
    """
    permeability_change_index: Positive | None = None
    """C_k of permeability = "taylor" [-], > 0: change of the void ratio over which the conductivity
    changes tenfold; about e0 / 2 for many soft clays.
    """
    permeability_exponent: Positive | None = None
    """Exponent m of permeability = "power" [-], > 0."""

    @property
    def conducts_water(self) -> bool:
        """Whether water flows through it, in a model with `[flow]`."""
        return self.hydraulic_conductivity is not None

    @property
    def principal_ratios(self) -> tuple[float, float]:
        """The least and the greatest principal value of `conductivity_ratios`; 1 without."""
        if self.conductivity_ratios is None:
            return 1.0, 1.0
        values = np.linalg.eigvalsh(np.array(self.conductivity_ratios))
        return float(values[0]), float(values[-1])

    @property
    def permeability_parameter(self) -> float:
        """The number of the law of the permeability; 0 of laws without one."""
        return self.permeability_change_index or self.permeability_exponent or 0.0

    @property
    def keeps_water(self) -> bool:
        """Whether no water leaves or enters the pores when the volume changes."""
        return bool(self.watertight)

    @property
    def dilates(self) -> bool:
        """Whether the volume is known to change in plastic flow."""
        return False

    @model_validator(mode="after")
    def _densities_fit_together(self) -> Any:
        saturated, what = self.saturated_density, ""
        if saturated is not None and self.watertight:
            what, remedy = "is given for a watertight material", "leave out one of the two"
        elif saturated is not None and self.density is not None and saturated < self.density:
            what = f"is less than the density {self.density:g}"
            remedy = "water in the pores adds to the mass"
        if what:
            raise rejection([Problem("saturated_density", what, remedy, saturated)])
        return self

    @model_validator(mode="after")
    def _pores_fit_together(self) -> Any:
        problems = []
        for key in ("porosity", "conductivity_ratios", "permeability", *_PERMEABILITIES.values()):
            value = getattr(self, key)
            if value is not None and not self.conducts_water:
                what = "has no meaning without `hydraulic_conductivity`"
                problems.append(Problem(key, what, "give it, or leave this out", value))
        if self.conducts_water and self.porosity is None:
            remedy = "give the volume of the pores over the whole volume, such as porosity = 0.4"
            problems.append(Problem("porosity", "missing: water flows through the pores", remedy))
        if self.conducts_water:
            problems += self._permeability_problems()
            problems += _ratio_problems(self.conductivity_ratios)
        if self.conducts_water and self.watertight:
            what, remedy = "is given for a watertight material", "leave out one of the two"
            value = self.hydraulic_conductivity
            problems.append(Problem("hydraulic_conductivity", what, remedy, value))
        if problems:
            raise rejection(problems)
        return self

    def _permeability_problems(self) -> Iterator[Problem]:
        """Yields what the law of the permeability lacks, and what another one would need."""
        chosen = self.permeability or "constant"
        for law, key in _PERMEABILITIES.items():
            value = getattr(self, key)
            if value is None and law == chosen:
                remedy = "give the number > 0 that was measured, or choose another law"
                yield Problem(key, f'missing: permeability = "{law}" needs it', remedy)
            elif value is not None and law != chosen:
                what = f'has no meaning with permeability = "{chosen}"'
                yield Problem(key, what, f'choose permeability = "{law}", or leave it out', value)

    @property
    def law(self) -> Law:
        """The law of the core that computes the stress; not of materials with code of the user."""
        return laws()[self.model]

    @property
    def code(self) -> str | None:
        """Code of the user that computes the stress, as "file:name"; None for a law of the core."""
        return None

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters of the law, in the order in which the core takes them."""
        return self.law.parameters

    def declared_variables(self) -> dict[str, str] | None:
        """Returns the units of the state variables by name; None if only the code knows them."""
        return self.law.state_variables

    def law_at(self, key: str) -> Law:
        """Returns the law that computes the stress; runs the code of the user, if there is one.

        key: of the material in the case file, for messages.
        """
        return self.law

    @property
    def kinds_of_parameters(self) -> Mapping[str, Kind]:
        """What the parameters that the core takes are, by name, as far as declared."""
        return {name: self.kinds[name] for name in self.parameter_names}

    def parameter_kinds_of(self, law: Law) -> Mapping[str, Kind]:
        """Returns what the parameters of the material's law are, by name, as far as declared."""
        return self.kinds_of_parameters

    def state_kinds_of(self, law: Law) -> Mapping[str, Kind]:
        """Returns what the state variables of the material's law are, as far as declared."""
        return {name: self.state_kinds[name] for name in law.state_variables}

    def irreducible(self, key: str, law: Law, davis: DavisForm | None) -> Iterator[Problem]:
        """Yields why strength reduction cannot divide the strength of the material.

        Args:
            key: of the material in the case file.
            law: of the material.
            davis: form of Davis' equivalent that is asked for.
        """
        both = (self.parameter_kinds_of(law), self.state_kinds_of(law))
        if not all(is_reducible(kinds) for kinds in both):
            what = "the strength of this law cannot be reduced"
            remedy = "choose a law with c and phi or s_u, such as mohr_coulomb or tresca"
            yield Problem(f"{key}.model", what, remedy, self.model)

    def law_parameters(self, at: ParametersAt) -> dict[str, Values]:
        """Returns the parameters of the law by their names in the core."""
        return {name: at.value(name) for name in self.parameter_names}

    def parameter(self, name: str, cell_length: float = 1.0) -> float:
        """Returns a parameter of the law, the same at all points, by its name in the core."""
        value = self.law_parameters(ParametersAt(lambda key: getattr(self, key), cell_length))[name]
        return float(value)

    def parameter_array(self, at: ParametersAt, points: int) -> Floats:
        """Returns the parameters as the core takes them: (m,), or (points, m) if one varies."""
        values = self.law_parameters(at)
        columns = [values[name] for name in self.parameter_names]
        if all(np.ndim(column) == 0 for column in columns):
            return np.array(columns, dtype=np.float64)
        return np.stack([np.broadcast_to(column, points) for column in columns], axis=1)

    def reduced_strength(
        self, parameters: Columns, factor: float, davis: DavisForm | None = None
    ) -> Columns:
        """Returns the parameters of a reducible law with its strength divided by a factor, by name.

        What is divided follows from the kinds of the parameters (`tilth.model.parameter_kinds`).

        Args:
            parameters: of the law by their names in the core, one number or shape (n,) each.
            factor: of safety [-], > 0; below 1 it raises the strength.
            davis: form of Davis' associated equivalent that takes the place of soil with friction.
        """
        return reduced(self.kinds_of_parameters, parameters, factor)

    def shear_strength(self, parameters: Columns, plastic_strain: Floats) -> tuple[Values, Values]:
        """Returns the cohesion c [stress] and tan(phi) [-] of a law with a shear strength.

        A plane under the pressure p bears the shear stress c + p tan(phi): c and phi are those of
        the Mohr-Coulomb law to which the material is equivalent.

        Args:
            parameters: of the law by their names in the core, one number or shape (n,) each.
            plastic_strain: equivalent plastic strain of the points [-], shape (n,).
        """
        raise NotImplementedError

    def reduced_parameters(
        self, parameters: Floats, factor: float, davis: DavisForm | None = None
    ) -> Floats:
        """Returns the parameters of a reducible law with its strength divided by a factor.

        Args:
            parameters: as the core takes them, shape (m,) or (n, m).
            factor, davis: as in `reduced_strength`.
        """
        if not self.parameter_names:  # the object of a class has them
            return parameters
        columns = dict(zip(self.parameter_names, np.moveaxis(parameters, -1, 0), strict=True))
        weaker = self.reduced_strength(columns, factor, davis)
        return np.stack([weaker[name] for name in self.parameter_names], axis=-1)

    def stiffened_parameters(self, parameters: Floats, factor: float) -> Floats:
        """Returns the parameters of the law with all moduli multiplied by a factor.

        Strains of the law are divided by it, so that strains over the factor cause the same stress.

        parameters: as the core takes them, shape (m,) or (n, m).
        """
        stiffer, kinds = parameters.copy(), self.kinds_of_parameters
        for column, name in enumerate(self.parameter_names):
            stiffer[..., column] = stiffened(kinds[name], parameters[..., column], factor)
        return stiffer

    def stiffened_law(self, law: Law, factor: float) -> Law:
        """Returns the law for `stiffened_parameters`: the same, unless it has parameters itself."""
        return law

    def reduced_law(self, law: Law, factor: float) -> Law:
        """Returns the law for `reduced_parameters`: the same, unless it has parameters itself."""
        return law


class Isotropic(AnyMaterial):
    """Materials with Hencky's elasticity, which two constants describe."""

    young_modulus: VaryingModulus
    """Young's modulus of the law for Kirchhoff stress and logarithmic strain [stress], > 0."""
    poisson_ratio: PoissonRatio
    """Poisson's ratio [-], -1 < nu < 0.5."""

    kinds: ClassVar[Mapping[str, Kind]] = {
        **AnyMaterial.kinds,
        "young_modulus": "stiffness",
        "poisson_ratio": "dimensionless",
    }

    def elastic_parameters(self, at: ParametersAt) -> dict[str, Values]:
        """Returns Young's modulus and Poisson's ratio."""
        return {name: at.value(name) for name in ("young_modulus", "poisson_ratio")}


class PoreFluid(AnyMaterial):
    """Materials for effective stress: a pore fluid that cannot drain may be added."""

    pore_fluid_bulk_modulus: VaryingPositive | None = None
    """Bulk modulus of the pore fluid over the porosity, K_w / n [stress], > 0; the soil is drained
    if not given. With it strength and stiffness are effective ones, the stress of results is the
    total one, and the state variable `excess_pore_pressure` (compression positive) is the pressure
    of the fluid since the start.
    """

    kinds: ClassVar[Mapping[str, Kind]] = {
        **AnyMaterial.kinds,
        "pore_fluid_bulk_modulus": "stiffness",
    }
    state_kinds: ClassVar[Mapping[str, Kind]] = {
        EXCESS_PORE_PRESSURE: "stress",
        "elastic_volumetric_strain": "strain",
    }

    @model_validator(mode="after")
    def _one_way_of_water(self) -> Any:
        if self.pore_fluid_bulk_modulus is not None and self.conducts_water:
            what = "is for soil whose water cannot flow, but `hydraulic_conductivity` is given, too"
            remedy = "leave out one of the two; flow.bulk_modulus is that of water that flows"
            value = self.pore_fluid_bulk_modulus
            raise rejection([Problem("pore_fluid_bulk_modulus", what, remedy, value)])
        return self

    @property
    def keeps_water(self) -> bool:
        """Whether no water leaves or enters the pores when the volume changes."""
        return bool(self.watertight) or self.pore_fluid_bulk_modulus is not None

    @property
    def law(self) -> Law:
        """The law of the core: that of the effective stress, or the undrained one made of it."""
        return laws()[self.model if self.pore_fluid_bulk_modulus is None else self.undrained_model]

    @property
    def undrained_model(self) -> str:
        """Name of the undrained law in the core."""
        return f"undrained_{self.model}"

    def with_fluid(self, parameters: dict[str, Values], at: ParametersAt) -> dict[str, Values]:
        """Returns the parameters of the effective law with that of the fluid, if there is one."""
        if self.pore_fluid_bulk_modulus is None:
            return parameters
        return {**parameters, "pore_fluid_bulk_modulus": at.value("pore_fluid_bulk_modulus")}


class WithPoreFluid(Isotropic, PoreFluid):
    """Materials with Hencky's elasticity for the effective stress."""

    kinds: ClassVar[Mapping[str, Kind]] = {**Isotropic.kinds, **PoreFluid.kinds}

    @model_validator(mode="after")
    def _fluid_is_not_rigid(self) -> Any:
        fluid = self.pore_fluid_bulk_modulus
        if isinstance(fluid, float) and isinstance(self.young_modulus, float):
            greatest = LARGEST_PRESSURE_RATIO * self.young_modulus
            if fluid > greatest:
                what = f"is more than {LARGEST_PRESSURE_RATIO:g} times Young's modulus"
                remedy = "one hundred times the bulk modulus of the soil is nearly incompressible"
                raise rejection([Problem("pore_fluid_bulk_modulus", what, remedy, fluid)])
        return self
