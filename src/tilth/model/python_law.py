# SPDX-License-Identifier: BSD-3-Clause
"""A constitutive law that the user writes as a Python class, for all points of a body at a time."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from copy import copy
from pathlib import Path
from typing import Any, ClassVar, NoReturn

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model.parameter_kinds import (
    CHOICES,
    KINDS,
    Kind,
    Values,
    fits_unit,
    reduced,
    stiffened,
)
from tilth.model.state_names import name_problem
from tilth.model.user_function import FAILURES, described, load_name, real_numbers

ELASTIC = ("moduli", "energy", "elastic_strain")
"""Methods of the elastic part; Hencky elasticity stands for those that a class does not have."""

UNITS = ("stress", "-")
"""Units that a state variable can have."""


class PythonLaw:
    """An object of the user's class, whose results are checked at every call.

    The protocol of the class is in docs/howto/write_your_own_material.md. The core calls `update`,
    `initial_state`, `elastic_strain`, `energy` and `moduli` (cpp/tilth/bind/python_law.hpp).

    Args:
        reference: `file.py:Name`.
        parameters: keyword arguments of the class.
        key: of the material in the case file, for messages.

    Attributes:
        title: the law in messages.
        parameters: numbers with which the class was called, and those that its defaults gave.
        parameter_kinds, state_kinds: what these and the state variables are, by name, as far as the
            class says it.
        state_variables: units ("stress" or "-") by name.
        hencky: whether the elastic part is Hencky elasticity with the parameters `young_modulus`
            and `poisson_ratio`.

    Raises:
        BadInput: as `load_name`, for a class that fails with these parameters, and for one that
            lacks a method or has wrong state variables.
    """

    kind: ClassVar[str] = "python"

    def __init__(self, reference: str, parameters: Mapping[str, float], key: str) -> None:
        file, _, name = reference.rpartition(":")
        self._file, self._name = file, name
        self._reference, self._key = reference, key
        self.title = f"the law `{name}` in `{Path(file).name}`"
        self._label = f"{self.title} ({key})"
        found = load_name(reference, "", key=f"{key}.class", what="class")
        if not isinstance(found, type):
            self._refuse(
                f"`{name}` in `{Path(file).name}` is a {type(found).__name__}, not a class",
                f"define it as a class: `class {name}: ...`",
            )
        self._class = found
        self._begin(parameters)

    def _begin(self, parameters: Mapping[str, float]) -> None:
        """Makes the object of the class with parameters, and checks it."""
        try:
            with _core.UserCode(self._label):
                self._law = self._class(**parameters)
        except FAILURES as error:
            self._refuse(
                f"{self.title} cannot be made of its parameters: {described(error, self._file)}",
                "it is called with the entries of `parameters` as keyword arguments: "
                + (", ".join(parameters) or "none"),
                error,
            )
        self._given = dict(parameters)
        self.parameters = {**parameters}
        for name, value in _number_defaults(self._class).items():
            self.parameters.setdefault(name, value)
        self.state_variables = self._declared_variables()
        self.parameter_kinds = self._declared_kinds("parameter_kinds", self.parameters)
        self.state_kinds = self._declared_kinds("state_kinds", self.state_variables)
        for variable, kind in self.state_kinds.items():
            if not fits_unit(kind, unit := self.state_variables[variable]):
                self._refuse(
                    f"the state variable {variable!r} of {self.title} has the unit {unit!r}, but "
                    f"in `state_kinds` the kind {kind!r} [{KINDS[kind].unit}]",
                    "correct one of the two",
                )
        lacking = [method for method in ELASTIC if not hasattr(self._law, method)]
        self.hencky = bool(lacking)
        self._bulk, self._shear = self._moduli_of(parameters) if lacking else (0.0, 0.0)
        needed = ("update", "initial_state") if self.state_variables else ("update",)
        for method in needed:
            if not callable(getattr(self._law, method, None)):
                self._refuse(f"{self.title} has no method `{method}`", f"define `{method}`")

    @property
    def state_count(self) -> int:
        """Number of state variables."""
        return len(self.state_variables)

    def stiffened(self, factor: float) -> PythonLaw:
        """Returns the law with all moduli multiplied, and all strains divided, by a factor [-]."""
        kinds, numbers = self.parameter_kinds, self.parameters
        return self._with({name: stiffened(kinds[name], numbers[name], factor) for name in numbers})

    def reduced(self, factor: float) -> PythonLaw:
        """Returns the law with its strength over a factor [-]."""
        return self._with(reduced(self.parameter_kinds, self.parameters, factor))

    def _with(self, values: Mapping[str, Values]) -> PythonLaw:
        """Returns the law with other values of its parameters; those that stay are not touched."""
        changed = {
            name: float(value)
            for name, value in values.items()
            if value is not self.parameters[name]
        }
        other = copy(self)
        other._begin({**self._given, **changed})
        return other

    def update(
        self, trial: Floats, plastic_strain: Floats, state: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Returns the principal Kirchhoff stress [stress], elastic strain [-], tangent and state.

        Args:
            trial: principal elastic logarithmic strain [-], tension positive, shape (n, 3).
            plastic_strain: equivalent plastic strain at the start of the step [-], shape (n, 1).
            state: state variables at the start of the step, shape (n, k).

        The shapes are (n, 3), (n, 3), (n, 3, 3) with d stress[a] / d trial[b], and (n, k).

        Raises:
            BadInput: the method fails, or returns other than four arrays of these shapes.
        """
        n, k = len(trial), self.state_count
        found = self._call(self._law.update, trial, plastic_strain[:, 0], state)
        names = ("stress", "elastic", "tangent", "state")
        if not isinstance(found, tuple | list) or len(found) != len(names):
            self._refuse(
                f"`update` of {self.title} returned a {type(found).__name__}, not four arrays",
                f"return {', '.join(names)}",
            )
        shapes = ((n, 3), (n, 3), (n, 3, 3), (n, k))
        stress, elastic, tangent, after = (
            self._array("update", name, array, shape)
            for name, array, shape in zip(names, found, shapes, strict=True)
        )
        return stress, elastic, tangent, after

    def initial_state(self, stress: Floats) -> Floats:
        """Returns the state variables (n, k) at the start of points with a Kirchhoff stress (n, 3).

        Raises:
            BadInput: the method fails, or returns another shape.
        """
        shape = (len(stress), self.state_count)
        if not self.state_variables:
            return np.zeros(shape)
        found = self._call(self._law.initial_state, stress)
        return self._array("initial_state", "state", found, shape)

    def elastic_strain(self, stress: Floats, state: Floats) -> Floats:
        """Returns the principal elastic strain (n, 3) [-] of a principal Kirchhoff stress (n, 3).

        Raises:
            BadInput: the method fails, or returns another shape.
        """
        if hasattr(self._law, "elastic_strain"):
            found = self._call(self._law.elastic_strain, stress, state)
            return self._array("elastic_strain", "strain", found, stress.shape)
        mean = stress.mean(axis=1, keepdims=True)
        return np.asarray(mean / (3.0 * self._bulk) + (stress - mean) / (2.0 * self._shear))

    def energy(self, strain: Floats, state: Floats) -> Floats:
        """Returns the stored energy per initial volume [stress], (n,), of an elastic strain (n, 3).

        Raises:
            BadInput: the method fails, or returns another shape or values that are not finite.
        """
        if hasattr(self._law, "energy"):
            found = self._call(self._law.energy, strain, state)
            energy = self._array("energy", "energy", found, (len(strain),))
            if not np.isfinite(energy).all():
                self._refuse(
                    f"`energy` of {self.title} returned a value that is not finite",
                    "it must be finite for every elastic strain",
                )
            return energy
        volumetric = strain.sum(axis=1)
        deviator = strain - volumetric[:, None] / 3.0
        return np.asarray(
            0.5 * self._bulk * volumetric**2 + self._shear * (deviator**2).sum(axis=1)
        )

    def moduli(self, strain: Floats, state: Floats) -> Floats:
        """Returns the bulk and shear modulus [stress], (n, 2), at an elastic strain (n, 3).

        Raises:
            BadInput: the method fails, or returns another shape or moduli that are not positive.
        """
        n = len(strain)
        if not hasattr(self._law, "moduli"):
            return np.tile([self._bulk, self._shear], (n, 1))
        found = self._call(self._law.moduli, strain, state)
        if not isinstance(found, tuple | list) or len(found) != 2:
            self._refuse(
                f"`moduli` of {self.title} returned a {type(found).__name__}, not two arrays",
                "return the bulk and the shear modulus, each one number or shape (n,)",
            )
        both = [
            self._array(
                "moduli", name, np.broadcast_to(each, n) if np.ndim(each) == 0 else each, (n,)
            )
            for name, each in zip(("bulk", "shear"), found, strict=True)
        ]
        moduli = np.stack(both, axis=1)
        if not ((moduli > 0.0) & np.isfinite(moduli)).all():
            self._refuse(
                f"`moduli` of {self.title} returned a modulus that is not positive and finite",
                "both moduli must be greater than zero, and finite, in every state",
            )
        return moduli

    def _declared_variables(self) -> dict[str, str]:
        declared = getattr(self._law, "state_variables", {})
        example = '`state_variables = {"strength": "stress"}`'
        if not isinstance(declared, Mapping):
            what = f"`state_variables` of {self.title} is not a dictionary"
            self._refuse(what, f"give the unit of each by its name, such as {example}")
        for name, unit in declared.items():
            if problem := name_problem(name):
                self._refuse(
                    f"the state variable {name!r} of {self.title} {problem[0]}", problem[1]
                )
            if unit not in UNITS:
                self._refuse(
                    f"the state variable {name!r} of {self.title} has the unit {unit!r}",
                    'choose from "stress" and "-"',
                )
        return dict(declared)

    def _declared_kinds(self, attribute: str, names: Mapping[str, Any]) -> dict[str, Kind]:
        """Returns what the class says its parameters or state variables are."""
        declared = getattr(self._law, attribute, {})
        if not isinstance(declared, Mapping):
            self._refuse(
                f"`{attribute}` of {self.title} is not a dictionary",
                f'give the kind of each by its name, such as `{attribute} = {{"cohesion": '
                '"strength"}`',
            )
        for name, kind in declared.items():
            if name not in names:
                known = ", ".join(names) or "none"
                self._refuse(
                    f"`{attribute}` of {self.title} names {name!r}, which the law does not have",
                    f"known names: {known}",
                )
            if not isinstance(kind, str) or kind not in KINDS:
                self._refuse(
                    f"`{attribute}` of {self.title} gives {name!r} the kind {kind!r}",
                    f"choose from {CHOICES}",
                )
        return dict(declared)

    def _moduli_of(self, parameters: Mapping[str, float]) -> tuple[float, float]:
        young, nu = parameters.get("young_modulus"), parameters.get("poisson_ratio")
        if young is None or nu is None or not young > 0.0 or not -1.0 < nu < 0.5:
            raise BadInput(
                f"{self.title} has not all of the methods {', '.join(ELASTIC)}, so its elasticity "
                "is Hencky's, but its constants are missing or out of range",
                "give young_modulus > 0 and -1 < poisson_ratio < 0.5, or write the methods",
                key=f"{self._key}.parameters",
                value=dict(parameters),
            )
        return young / (3.0 * (1.0 - 2.0 * nu)), young / (2.0 * (1.0 + nu))

    def _call(self, method: Callable[..., Any], *arguments: Floats) -> Any:
        try:
            # points without a solution are found by their NaN
            with _core.UserCode(self._label), np.errstate(all="ignore"):
                return method(*arguments)
        except FAILURES as error:
            self._refuse(
                f"`{method.__name__}` of {self.title} failed: {described(error, self._file)}",
                f"it must accept any number of points, here {len(arguments[0])}",
                error,
            )

    def _array(self, method: str, name: str, value: Any, shape: tuple[int, ...]) -> Floats:
        wanted = f"an array of shape (n{''.join(f', {x}' for x in shape[1:])}) for n points"
        try:
            array = real_numbers(value)
        except (TypeError, ValueError) as error:
            self._refuse(
                f"`{method}` of {self.title} returned {error} as {name}, not an array of real "
                "numbers",
                f"return {wanted}, of real numbers",
                error,
            )
        if array.shape != shape:
            self._refuse(
                f"`{method}` of {self.title} returned {name} of shape {array.shape} for "
                f"{shape[0]} points, not {shape}",
                f"return {wanted}",
            )
        return array

    def _refuse(self, problem: str, remedy: str, cause: BaseException | None = None) -> NoReturn:
        raise BadInput(problem, remedy, key=f"{self._key}.class", value=self._reference) from cause


def _number_defaults(law: type) -> dict[str, float]:
    """Returns the arguments of a class that are numbers and have a default, by name."""
    try:
        arguments = inspect.signature(law).parameters
    except (TypeError, ValueError):  # one that Python does not know
        return {}
    return {
        name: argument.default
        for name, argument in arguments.items()
        if isinstance(argument.default, int | float) and not isinstance(argument.default, bool)
    }
