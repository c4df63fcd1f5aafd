# SPDX-License-Identifier: BSD-3-Clause
"""Materials whose law is code of the user: a Python class, a compiled function, a UMAT."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, PlainValidator, model_validator

from tilth.arrays import Floats
from tilth.errors import BadInput, Problem
from tilth.model.abaqus_utilities import load_umat
from tilth.model.base import Declared
from tilth.model.davis import DavisForm
from tilth.model.fields import FileName, Name, PythonFunction, Real, as_list, real
from tilth.model.isotropic import AnyMaterial, Isotropic, ParametersAt
from tilth.model.laws import Law
from tilth.model.parameter_kinds import CHOICES, KINDS, Kind, Values, fits_unit, has_friction
from tilth.model.problems import reject, rejection
from tilth.model.python_law import PythonLaw
from tilth.model.state_names import name_problem
from tilth.model.user_function import load_name

MOST_NUMBERS = 1_000
"""Parameters or state variables of a user's law, at most."""

UMAT_STRAINS = tuple(f"elastic_strain_{number}" for number in (1, 2, 3))
"""State variables of every UMAT: principal elastic strains, largest first."""

UMAT_NAME = 80
"""Characters of CMNAME."""


@dataclass(frozen=True, eq=False)
class CompiledLaw:
    """A compiled function as the core calls it (cpp/tilth/material/user_law.hpp).

    Attributes:
        title: the law in messages.
        key: of the material in the case file.
        address: of the function in memory.
        initial: state variables at the start, shape (k,).
        owner: keeps the function in memory.
    """

    kind: ClassVar[str] = "compiled"
    hencky: ClassVar[bool] = True

    title: str
    key: str
    address: int
    initial: Floats
    owner: Any

    @property
    def label(self) -> str:
        """The law and its material, for the message if it ends the process."""
        return f"{self.title} ({self.key})"


@dataclass(frozen=True, eq=False)
class Umat(CompiledLaw):
    """A routine with the arguments of UMAT (cpp/tilth/material/umat.hpp).

    Attributes:
        name: CMNAME.
    """

    kind: ClassVar[str] = "umat"

    name: str


class StateVariable(Declared):
    """A quantity that the user's law stores at each point."""

    name: Name
    """Name in results, `colour_by` and `[[track]]`."""
    unit: Literal["stress", "-"]
    """Unit, "stress" or "-"."""
    initial: Real
    """Value at the start."""
    kind: Kind | None = None
    """What it is, see [kinds](#kinds-of-parameters); strength reduction needs it."""

    @model_validator(mode="after")
    def _kind_fits_unit(self) -> Any:
        if self.kind is not None and not fits_unit(self.kind, self.unit):
            what = f'is [{KINDS[self.kind].unit}], but `unit` is "{self.unit}"'
            raise rejection([Problem("kind", what, "correct one of the two", self.kind)])
        return self


def _numbers(value: Any) -> tuple[float, ...]:
    entries = as_list(value)
    if entries is None:
        raise reject("must be a list of numbers", "such as [2e4, 0.0]")
    if len(entries) > MOST_NUMBERS:
        raise reject(f"has {len(entries):,} entries", f"give at most {MOST_NUMBERS:,}")
    return tuple(real(entry) for entry in entries)


def _by_name(value: Mapping[str, float]) -> Mapping[str, float]:
    for name in value:
        if not name.isidentifier():
            raise reject(f"{name!r} is not a name of a Python argument", "use letters and _")
    return value


def _counted(value: Any) -> Any:
    """Returns the entries that a number of state variables stands for."""
    if isinstance(value, bool) or not isinstance(value, int):
        return value
    if not 0 <= value <= MOST_NUMBERS:
        raise reject(f"must be 0 to {MOST_NUMBERS:,}")
    return [{"name": f"state_{i + 1}", "unit": "-", "initial": 0.0} for i in range(value)]


def _different(value: Sequence[StateVariable]) -> tuple[StateVariable, ...]:
    seen: set[str] = set()
    for i, variable in enumerate(value):
        problem = name_problem(variable.name)
        if variable.name in seen:
            problem = "is already the name of another one", "give each a different name"
        if problem:
            raise rejection([Problem(f"[{i}].name", *problem, variable.name)])
        seen.add(variable.name)
    if len(value) > MOST_NUMBERS:
        raise reject(f"has {len(value):,} entries", f"give at most {MOST_NUMBERS:,}")
    return tuple(value)


Numbers = Annotated[Sequence[float], PlainValidator(_numbers)]
NumbersByName = Annotated[Mapping[str, Real], AfterValidator(_by_name)]
KindsInOrder = Annotated[Sequence[Kind], AfterValidator(tuple)]
StateVariables = Annotated[
    Sequence[StateVariable],
    BeforeValidator(_counted, int | Sequence[StateVariable]),
    AfterValidator(_different),
]


class UserPython(AnyMaterial):
    """A law that you write as a Python class, with NumPy, for all points at a time.

    The protocol of the class, with an example, is in
    [write your own material](../howto/write_your_own_material.md). The key `class` is `class_` in
    Python.
    """

    is_plastic: ClassVar[bool] = True

    model: Literal["user_python"] = "user_python"
    class_: PythonFunction = Field(alias="class")
    """The class. It declares the state variables."""
    parameters: NumbersByName
    """Parameters by name, with which the class is called. Without methods of its own for elasticity
    it is Hencky's, with `young_modulus` and `poisson_ratio`."""

    @property
    def code(self) -> str:
        """What is run, as "file.py:name"."""
        return self.class_

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """None: the object of the class has them."""
        return ()

    def declared_variables(self) -> None:
        """Returns None: only the class knows its state variables."""

    def law_at(self, key: str) -> Law:
        """Returns the law; runs the user's file. Raises BadInput as `PythonLaw`."""
        law = PythonLaw(self.class_, self.parameters, key)
        return Law(self.model, (), law.state_variables, False, law)

    def law_parameters(self, at: ParametersAt) -> dict[str, Values]:
        """Returns no parameters: the object of the class has them."""
        return {}

    def parameter_kinds_of(self, law: Law) -> Mapping[str, Kind]:
        """Returns what the arguments of the class are, as far as it says it."""
        kinds: Mapping[str, Kind] = law.source.parameter_kinds
        return kinds

    def state_kinds_of(self, law: Law) -> Mapping[str, Kind]:
        """Returns what the state variables of the class are, as far as it says it."""
        kinds: Mapping[str, Kind] = law.source.state_kinds
        return kinds

    def irreducible(self, key: str, law: Law, davis: DavisForm | None) -> Iterator[Problem]:
        """Yields why the strength cannot be reduced; see `AnyMaterial`."""
        for attribute, what, names, known in (
            ("parameter_kinds", "parameter", law.source.parameters, law.source.parameter_kinds),
            ("state_kinds", "state variable", law.state_variables, law.source.state_kinds),
        ):
            if missing := [name for name in names if name not in known]:
                listed = ", ".join(f"`{name}`" for name in missing)
                yield Problem(
                    f"{key}.class",
                    f"{law.source.title} does not say what its {what}{'s' * (len(missing) > 1)} "
                    f"{listed} {'are' if len(missing) > 1 else 'is'}, so that its strength cannot "
                    "be reduced",
                    f'give the class `{attribute} = {{"{missing[0]}": ..., }}` with the kind of '
                    f"each: {CHOICES}",
                    self.class_,
                )
                return
        yield from super().irreducible(key, law, davis)
        yield from _without_equivalent(self, key, law, davis)

    def stiffened_law(self, law: Law, factor: float) -> Law:
        """Returns the law with stiffer parameters; see `AnyMaterial`."""
        return replace(law, source=law.source.stiffened(factor))

    def reduced_law(self, law: Law, factor: float) -> Law:
        """Returns the law with a reduced strength; see `AnyMaterial`."""
        return replace(law, source=law.source.reduced(factor))


def _without_equivalent(
    material: AnyMaterial, key: str, law: Law, davis: DavisForm | None
) -> Iterator[Problem]:
    """Yields that Davis' equivalent of friction in a law of the user is not known."""
    both = (material.parameter_kinds_of(law), material.state_kinds_of(law))
    if davis is not None and any(has_friction(kinds) for kinds in both):
        what = "is a law of yours with friction, of which Davis' equivalent is not known"
        remedy = "leave out `davis`, or use mohr_coulomb or drucker_prager"
        yield Problem(f"{key}.model", what, remedy, material.model)


class _UserBinary(Isotropic):
    is_plastic: ClassVar[bool] = True
    numbers: ClassVar[str]
    """Key of the numbers that are given to the code."""
    kinds_key: ClassVar[str]
    """Key of their kinds."""

    state_variables: StateVariables
    """State variables: a list of tables `name`, `unit` ("stress" or "-"), `initial` and, for a
    factor of safety, `kind` (see [kinds](#kinds-of-parameters)); or a number of them, which are
    named `state_1`, `state_2`, ..., have no unit and begin with 0."""

    def declared_variables(self) -> dict[str, str]:
        """Returns the units of the state variables by name."""
        return {variable.name: variable.unit for variable in self.state_variables}

    @property
    def initial(self) -> Floats:
        """State variables at the start, shape (k,)."""
        return np.array([variable.initial for variable in self.state_variables])

    @model_validator(mode="after")
    def _one_kind_each(self) -> Any:
        numbers, kinds = getattr(self, self.numbers), getattr(self, self.kinds_key)
        if kinds is not None and len(kinds) != len(numbers):
            what = f"has {len(kinds)} entries, but `{self.numbers}` has {len(numbers)}"
            remedy = f"give the kind of each of `{self.numbers}`, in their order"
            raise rejection([Problem(self.kinds_key, what, remedy, list(kinds))])
        return self

    @property
    def kinds_of_parameters(self) -> Mapping[str, Kind]:
        """What the constants and the further numbers are, by name, as far as declared."""
        fixed = {name: self.kinds[name] for name in self.parameter_names if name in self.kinds}
        return {**fixed, **_numbered(getattr(self, self.kinds_key) or ())}

    def state_kinds_of(self, law: Law) -> Mapping[str, Kind]:
        """Returns what the state variables are, as far as declared."""
        declared = {each.name: each.kind for each in self.state_variables if each.kind is not None}
        return {**declared, **self.state_kinds}

    def irreducible(self, key: str, law: Law, davis: DavisForm | None) -> Iterator[Problem]:
        """Yields why the strength cannot be reduced; see `AnyMaterial`."""
        problems = []
        if getattr(self, self.numbers) and getattr(self, self.kinds_key) is None:
            what = f"missing: strength reduction needs to know what each of `{self.numbers}` is"
            remedy = f"give a list with the kind of each: {CHOICES}"
            problems.append(Problem(f"{key}.{self.kinds_key}", what, remedy))
        for i, variable in enumerate(self.state_variables):
            if variable.kind is None:
                what = f"missing: strength reduction needs to know what `{variable.name}` is"
                remedy = f"give its entry in `state_variables` a `kind`: {CHOICES}"
                problems.append(Problem(f"{key}.state_variables[{i}].kind", what, remedy))
        if problems:
            yield from problems
            return
        yield from super().irreducible(key, law, davis)
        yield from _without_equivalent(self, key, law, davis)


class UserCompiled(_UserBinary):
    """A law that you write as a compiled function, called from all threads at a time.

    Its elasticity is Hencky's. The arguments of the function, with an example, are in
    [write your own material](../howto/write_your_own_material.md).
    """

    model: Literal["user_compiled"] = "user_compiled"
    function: PythonFunction
    """The function: a numba `cfunc`, a `ctypes` function, or any object with its `address`."""
    parameters: Numbers
    """Parameters of the function after Young's modulus and Poisson's ratio; may be []."""
    parameter_kinds: KindsInOrder | None = None
    """What each of `parameters` is, see [kinds](#kinds-of-parameters); strength reduction needs it.
    """

    numbers: ClassVar[str] = "parameters"
    kinds_key: ClassVar[str] = "parameter_kinds"

    @property
    def code(self) -> str:
        """What is run, as "file.py:name"."""
        return self.function

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Young's modulus, Poisson's ratio and the further parameters."""
        return ("young_modulus", "poisson_ratio", *_numbered(self.parameters))

    def law_parameters(self, at: ParametersAt) -> dict[str, Values]:
        """Returns the parameters of the law; see `Isotropic`."""
        return {**self.elastic_parameters(at), **_numbered(at.value("parameters"))}

    def law_at(self, key: str) -> Law:
        """Returns the law; runs the user's file.

        Raises:
            BadInput: as `load_name`, and for what is not a compiled function.
        """
        file, _, name = self.function.rpartition(":")
        found = load_name(self.function, "", key=f"{key}.function")
        address = _address(found)
        if address is None:
            raise BadInput(
                f"`{name}` in `{Path(file).name}` is a {type(found).__name__}, not a compiled "
                "function",
                "decorate it with numba's `cfunc`, or take it from a library with `ctypes.CDLL`",
                key=f"{key}.function",
                value=self.function,
            )
        title = f"the law `{name}` in `{Path(file).name}`"
        source = CompiledLaw(title, key, address, self.initial, found)
        return Law(self.model, self.parameter_names, self.declared_variables(), False, source)


class UserUmat(_UserBinary):
    """A law with the arguments of Abaqus' UMAT, in a shared library of Fortran or C code.

    It must be isotropic, with linear elasticity and the moduli that are declared here. It is called
    in the axes of the trial strain. `state_variables` are STATEV; in the results
    `elastic_strain_1`, `_2` and `_3`, the principal elastic strains, follow. What the routine gets,
    and an example, is in
    [write your own material](../howto/write_your_own_material.md).
    """

    model: Literal["user_umat"] = "user_umat"
    library: FileName
    """The shared library (.so)."""
    routine: Name
    """Name of the routine in the library: most Fortran compilers write `umat_`."""
    properties: Numbers
    """PROPS; may be []."""
    property_kinds: KindsInOrder | None = None
    """What each of `properties` is, see [kinds](#kinds-of-parameters); strength reduction needs it.
    """

    kinds: ClassVar[Mapping[str, Kind]] = {**Isotropic.kinds, "cell_length": "length"}
    state_kinds: ClassVar[Mapping[str, Kind]] = dict.fromkeys(UMAT_STRAINS, "strain")
    numbers: ClassVar[str] = "properties"
    kinds_key: ClassVar[str] = "property_kinds"

    @property
    def code(self) -> str:
        """What is run, as "library:routine"."""
        return f"{self.library}:{self.routine}"

    def declared_variables(self) -> dict[str, str]:
        """Returns the units of the state variables by name."""
        return {**super().declared_variables(), **dict.fromkeys(UMAT_STRAINS, "-")}

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Young's modulus, Poisson's ratio, CELENT and PROPS."""
        return ("young_modulus", "poisson_ratio", "cell_length", *_numbered(self.properties))

    def law_parameters(self, at: ParametersAt) -> dict[str, Values]:
        """Returns the parameters of the law; see `Isotropic`."""
        return {
            **self.elastic_parameters(at),
            "cell_length": at.cell_length,
            **_numbered(at.value("properties")),
        }

    def law_at(self, key: str) -> Law:
        """Returns the law; loads the user's library.

        Raises:
            BadInput: the library cannot be loaded (see `load_umat`), or has no such routine.
        """
        file = Path(self.library)
        # what Fortran code prints is then not lost if it ends the process
        os.environ.setdefault("GFORTRAN_UNBUFFERED_PRECONNECTED", "y")
        library = load_umat(file, key, self.library)
        address = _address(getattr(library, self.routine, None))
        if address is None:
            raise BadInput(
                f"`{file.name}` has no routine of this name",
                f"`nm -D {file.name}` lists them; Fortran compilers write small letters and add _",
                key=f"{key}.routine",
                value=self.routine,
            )
        title = f"the law `{self.routine}` in `{file.name}`"
        name = self.routine.upper()[:UMAT_NAME]
        source = Umat(title, key, address, self.initial, library, name)
        return Law(self.model, self.parameter_names, self.declared_variables(), False, source)


def _numbered(numbers: Any) -> dict[str, Any]:
    return {f"parameters[{i}]": number for i, number in enumerate(numbers)}


def _address(function: Any) -> int | None:
    """Returns the address of a compiled function, None for anything else."""
    address = getattr(function, "address", None)
    if address is None and callable(function):
        try:
            address = ctypes.cast(function, ctypes.c_void_p).value
        except ctypes.ArgumentError:  # a function of Python
            return None
    return address if isinstance(address, int) and address > 0 else None
