# SPDX-License-Identifier: BSD-3-Clause
"""Materials whose law is code of the user: a Python class, a compiled function, a UMAT."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, PlainValidator

from tilth.arrays import Floats
from tilth.errors import BadInput, Problem
from tilth.model.abaqus_utilities import load_umat
from tilth.model.base import Declared
from tilth.model.fields import FileName, Name, PythonFunction, Real, as_list, real
from tilth.model.isotropic import AnyMaterial, Isotropic, ParametersAt, Values
from tilth.model.laws import Law
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


class _UserBinary(Isotropic):
    is_plastic: ClassVar[bool] = True

    state_variables: StateVariables
    """State variables: a list of tables `name`, `unit` ("stress" or "-"), `initial`; or a number of
    them, which are named `state_1`, `state_2`, ..., have no unit and begin with 0."""

    def declared_variables(self) -> dict[str, str]:
        """Returns the units of the state variables by name."""
        return {variable.name: variable.unit for variable in self.state_variables}

    @property
    def initial(self) -> Floats:
        """State variables at the start, shape (k,)."""
        return np.array([variable.initial for variable in self.state_variables])


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


def _numbered(numbers: Any) -> dict[str, float]:
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
