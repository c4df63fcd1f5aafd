# SPDX-License-Identifier: BSD-3-Clause
"""Values of material parameters at the points' initial positions."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model.base import Declared
from tilth.model.fields import AXES
from tilth.model.user_function import UserFunction
from tilth.model.variation import (
    AlongAxis,
    ByDepth,
    ByStress,
    GridFile,
    OfPosition,
    Random,
    Variation,
    variations,
)
from tilth.variation.grid_file import read_grid
from tilth.variation.level import elevation
from tilth.variation.random_field import random_values
from tilth.variation.tables import interpolate, place_text


def parameter_values(
    declared: Declared, position: Floats, key: str, stress: Floats | None = None
) -> dict[str, Floats]:
    """Returns the values of the parameters that vary, by key, shape (n,) each.

    Args:
        declared: a material.
        position: initial positions of its points [length], shape (n, dim).
        key: of the material in the case file, for messages.
        stress: initial Cauchy stress of the points, tension positive, shape (n, 6); None if the
            case gives none.

    Raises:
        BadInput: a place outside a table or a grid, a function that fails, or a value that the
            parameter must not have, with the point's place.
    """
    found = {
        name: values_at(variation, position, f"{key}.{name}", stress)
        for name, variation in variations(declared).items()
    }
    if found:
        _require_admissible(declared, found, position, key)
    return found


def values_at(
    variation: Variation, position: Floats, key: str, stress: Floats | None = None
) -> Floats:
    """Returns the values of one parameter, shape (n,); arguments as of `parameter_values`."""
    if isinstance(variation, ByDepth):
        depth = elevation(variation.surface, position, f"{key}.surface") - position[:, -1]
        return interpolate(variation.depth, depth, position, "depth", f"{key}.depth")
    if isinstance(variation, AlongAxis):
        at = position[:, AXES.index(variation.axis)]
        return interpolate(variation.values, at, position, variation.axis, f"{key}.values")
    if isinstance(variation, GridFile):
        grid = read_grid(variation.file, position.shape[1], f"{key}.file")
        return grid.at(position, f"{key}.file", variation.file)
    if isinstance(variation, Random):
        return random_values(variation.random, position, f"{key}.random")
    if isinstance(variation, OfPosition):
        function = UserFunction(
            variation.function, key=f"{key}.function", where="where there is soil"
        )
        return function(position)
    return _by_stress(variation, stress, key)


def _by_stress(variation: ByStress, stress: Floats | None, key: str) -> Floats:
    if stress is None:
        raise BadInput(
            "depends on the initial stress, but the case gives none",
            "add an entry [[initial.stress]] for the body, or give another modulus",
            key=key,
        )
    pressure = -(stress[:, :3].mean(axis=1) if variation.stress == "mean" else _greatest(stress))
    ratio = np.maximum(pressure, 0.0) / variation.reference_pressure
    return np.asarray(variation.reference * ratio**variation.exponent)


def _greatest(stress: Floats) -> Floats:
    """Returns the greatest principal stress, tension positive, shape (n,)."""
    place = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
    return np.asarray(np.linalg.eigvalsh(stress[:, place])[:, -1])


def _require_admissible(
    declared: Declared, values: dict[str, Floats], position: Floats, key: str
) -> None:
    """Checks the material with its values at the points where an entry could be wrong.

    The checks of a material are limits of single entries, and relations of two: these are tested
    where an entry, the difference, the sum and the ratio of two are greatest and least.
    """
    for point in sorted(_critical_points(declared, values, len(position))):
        numbers = {name: float(array[point]) for name, array in values.items()}
        try:
            declared.model_copy(update=numbers)
        except BadInput as error:
            name = error.key.rpartition(".")[2]
            remedy = error.remedy
            variation = getattr(declared, name, None)
            if isinstance(variation, Random) and variation.random.distribution == "normal":
                remedy = 'a normal distribution has values of either sign: choose "lognormal"'
            raise BadInput(
                f"{error.problem}, at the material point at {place_text(position[point])}",
                remedy or "change what it is given by",
                key=f"{key}.{name}",
                value=error.problems[0].value,
            ) from None


def _critical_points(declared: Declared, values: dict[str, Floats], points: int) -> set[int]:
    """Returns where an entry, or a relation of two, of which one varies, is greatest and least."""
    fixed = {key: getattr(declared, key) for key in type(declared).model_fields}
    numbers = {key: np.full(points, v) for key, v in fixed.items() if isinstance(v, float)}
    tested = [*values.values()]
    for one, other in combinations({**numbers, **values}.items(), 2):
        if one[0] in values or other[0] in values:
            first, second = one[1], other[1]
            tested += [first - second, first + second]
            if second.all():
                tested.append(first / second)
    above = [np.where(array > 0.0, array, np.inf) for array in values.values()]
    found = {int(array.argmin()) for array in (*tested, *above)}
    return found | {int(array.argmax()) for array in tested}
