# SPDX-License-Identifier: BSD-3-Clause
"""Field types: numbers, vectors and tables; they refuse text for a number, NaN and infinity.

Vectors and tables may be given as list, tuple or NumPy array; they are stored as tuples.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BeforeValidator, PlainValidator
from pydantic_core import PydanticCustomError

from tilth.errors import BadInput, Problem
from tilth.model.problems import reject, rejection
from tilth.model.texts import CellName as CellName
from tilth.model.texts import FileName as FileName
from tilth.model.texts import Label as Label
from tilth.model.texts import Name as Name
from tilth.model.texts import PythonFunction as PythonFunction
from tilth.model.texts import Text as Text

Axis = Literal["x", "y", "z"]
AXES: tuple[Axis, ...] = ("x", "y", "z")
Face = Literal["x-", "x+", "y-", "y+", "z-", "z+"]

_Item = TypeVar("_Item")

GREATEST, LEAST = 1e30, 1e-30
"""Greatest magnitude of a number, and the least one of a number that must be greater than zero.

A force is at most a mass density times an acceleration times a volume, that is five such numbers
multiplied; its square is still a double-precision number."""

ROUND_OFF = 1e-15
"""Least relative tolerance."""

LARGEST_TOLERANCE = 1e-2
"""Largest tolerance of the equilibrium [-]: with more, too much of the forces is not balanced."""

MOST = 1_000_000_000
"""Greatest whole number that counts something."""

FULL_TURNS = 1e6
"""Greatest angle [degrees]: the round-off of a larger one is no longer small."""

MOST_VERTICES = 10_000
"""Vertices of a polygon or a curve, at most."""

MOST_ENTRIES = 1_000
"""Bodies, boundaries, loads or tracked quantities, at most."""

MOST_ROWS = 100_000
"""Rows of a table, at most."""


def real(value: Any) -> float:
    """Returns a finite number of at most `GREATEST` in magnitude; refuses anything else."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise reject("must be a number", _unquoted(value))
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if math.isnan(number) or value in (math.inf, -math.inf):
        raise reject("must be a finite number")
    if abs(number) > GREATEST:
        raise reject(f"is greater than {GREATEST:g} in magnitude", "choose larger units")
    return number


def _unquoted(value: Any) -> str:
    if not isinstance(value, str):
        return ""
    try:
        float(value)
    except ValueError:
        return ""
    return "write it without quotes"


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, numbers.Integral):
        raise reject("must be a whole number", "write it without a decimal point")
    return int(value)


def positive(value: Any) -> float:
    """Returns a number of at least `LEAST`; refuses anything else."""
    if (number := real(value)) >= LEAST:
        return number
    if number > 0.0:
        raise reject(f"is smaller than {LEAST:g}", "choose smaller units")
    raise reject("must be greater than zero")


def _not_negative(value: Any) -> float:
    if (number := real(value)) == 0.0 or number >= LEAST:
        return number
    if number > 0.0:
        raise reject(f"is smaller than {LEAST:g}, but not 0", "choose smaller units, or give 0")
    raise reject("must not be negative")


def _angle(value: Any) -> float:
    if abs(number := real(value)) <= FULL_TURNS:
        return number
    raise reject(f"is greater than {FULL_TURNS:g} degrees in magnitude", "leave out whole turns")


def _tolerance(value: Any) -> float:
    if (number := positive(value)) < ROUND_OFF:
        raise reject(f"is below {ROUND_OFF:g}, the round-off of numbers")
    if number > LARGEST_TOLERANCE:
        what = f"must be at most {LARGEST_TOLERANCE:g}: with more there is no equilibrium"
        raise reject(what, "leave it out for 1e-9")
    return number


def _fraction(value: Any) -> float:
    if 0.0 < (number := real(value)) <= 1.0:
        return number
    raise reject("must be greater than 0 and at most 1")


def _share(value: Any) -> float:
    if 0.0 < (number := real(value)) < 1.0:
        return number
    raise reject("must be between 0 and 1, without these", "0.02 is a share of 2 %")


def _count(value: Any) -> int:
    if (number := _whole(value)) < 1:
        raise reject("must be at least 1")
    return _countable(number)


def _count_or_zero(value: Any) -> int:
    if (number := _whole(value)) < 0:
        raise reject("must not be negative")
    return _countable(number)


def _countable(number: int) -> int:
    if number > MOST:
        raise reject(f"must be at most {MOST:,}")
    return number


def count_of(key: str, given: Any, default: int) -> int:
    """Returns how many threads or processes a function of the user's uses: `default` if None.

    Raises:
        BadInput: the number is no whole number from 1 on.
    """
    try:
        return default if given is None else _count(given)
    except PydanticCustomError as error:
        (problem,) = (error.context or {})["problems"]
        remedy = f"leave it out for {default}, or give 1 for one"
        raise BadInput(problem.problem, remedy, key=key, value=given) from None


def _flag(value: Any) -> bool:
    if isinstance(value, bool):
        return value
    raise reject("must be true or false", "write true or false without quotes")


def as_list(value: Any) -> list[Any] | None:
    """Returns the entries of a list, tuple or NumPy array; None for anything else."""
    if isinstance(value, (list, tuple)):
        return list(value)
    if hasattr(value, "tolist") and isinstance(value.tolist(), list):
        return list(value.tolist())
    return None


def _vector_of(item: Callable[[Any], _Item]) -> Callable[[Any], tuple[_Item, ...]]:
    def vector(value: Any) -> tuple[_Item, ...]:
        entries = as_list(value)
        if not entries:
            raise reject("must be a list of numbers, one per direction", "such as [1, 2]")
        return tuple(item(entry) for entry in entries)

    return vector


def _whole_numbers(value: Any) -> tuple[int, ...]:
    entries = as_list(value)
    if entries is None:
        raise reject("must be a list of whole numbers", "such as [0, 3]")
    return tuple(_count_or_zero(entry) for entry in entries)


def _per_direction_of(item: Callable[[Any], _Item]) -> Callable[[Any], _Item | tuple[_Item, ...]]:
    def per_direction(value: Any) -> _Item | tuple[_Item, ...]:
        return item(value) if as_list(value) is None else _vector_of(item)(value)

    return per_direction


def _matrix(value: Any) -> tuple[tuple[float, ...], ...]:
    rows = as_list(value)
    if not rows or any(as_list(row) is None for row in rows):
        raise reject("must be a list of rows of numbers", "such as [[1, 0], [0, 1]]")
    if len(rows) > MOST_VERTICES:
        raise reject(f"has {len(rows):,} rows", f"give at most {MOST_VERTICES:,}")
    return tuple(_vector_of(real)(row) for row in rows)


def _tensor(value: Any) -> tuple[tuple[float, ...], ...]:
    rows = as_list(value)
    if not rows:
        raise reject("must be a list of numbers or of rows of numbers", "such as [3.0, 1.0]")
    if all(as_list(row) is None for row in rows):
        own = _vector_of(real)(rows)
        return tuple(
            tuple(a if i == j else 0.0 for j, a in enumerate(own)) for i in range(len(own))
        )
    return _matrix(value)


def _table(value: Any) -> tuple[tuple[float, float], ...]:
    example = "give rows of (time, factor) such as [[0, 0], [1, 1]]"
    rows = as_list(value)
    if rows is None or any(len(as_list(row) or ()) != 2 for row in rows):
        raise reject("must be a list of rows of two numbers", example)
    if len(rows) < 2:
        raise reject("needs at least two rows", example)
    _require_rows(rows)
    table = [(real(time), real(factor)) for time, factor in rows]
    if table[0][0] != 0.0:
        raise reject("the first time must be 0", example)
    for (before, _), (after, _) in pairwise(table):
        if after <= before:
            raise reject(
                f"the times must increase from row to row, but {after:g} follows {before:g}",
                "sort the rows by time and keep one row per time",
            )
    return tuple(table)


def number_or_table(value: Any) -> float | tuple[tuple[float, float], ...]:
    """Returns a number, or rows (time, value)."""
    return real(value) if as_list(value) is None else _table(value)


def _number_or_table_per_axis(value: Any) -> Any:
    """Returns a number or a table, or such for each axis that a mapping names."""
    if not isinstance(value, Mapping):
        return number_or_table(value)
    found, problems = {}, []
    for axis, each in some(value).items():
        if axis not in AXES:
            remedy = 'choose from "x", "y", "z"'
            problems.append(Problem(str(axis), "names no axis", remedy, each))
            continue
        try:
            found[axis] = number_or_table(each)
        except PydanticCustomError as error:
            refused = (error.context or {})["problems"]
            problems += [Problem(axis, p.problem, p.remedy, each) for p in refused]
    if problems:
        raise rejection(problems)
    return found


def _require_rows(rows: Sequence[Any]) -> None:
    if len(rows) > MOST_ROWS:
        raise reject(f"has {len(rows):,} rows", f"give at most {MOST_ROWS:,}")


def _profile(value: Any) -> tuple[tuple[float, float], ...]:
    example = "give rows of (arc length, value) such as [[0, 0], [2, 1]]"
    rows = as_list(value)
    if rows is None or len(rows) < 2 or any(len(as_list(row) or ()) != 2 for row in rows):
        raise reject("must be a list of at least two rows of two numbers", example)
    _require_rows(rows)
    profile = [(real(place), real(number)) for place, number in rows]
    if any(after <= before for (before, _), (after, _) in pairwise(profile)):
        raise reject("the arc lengths must increase from row to row", example)
    return tuple(profile)


def _times(value: Any) -> tuple[float, ...]:
    times = _vector_of(real)(value)
    if times[0] <= 0.0:
        raise reject("the times must be greater than 0", "the initial state is always written")
    if any(after <= before for before, after in pairwise(times)):
        raise reject("the times must increase from entry to entry")
    return times


def some(value: Any) -> Any:
    """Refuses an empty table or list."""
    if not value:
        raise reject("must not be empty", "leave it out, or name at least one axis")
    return value


def _distinct(value: tuple[Axis, ...]) -> tuple[Axis, ...]:
    if len(set(value)) != len(value):
        raise reject("names an axis twice")
    return value


def _axes(value: Any) -> Any:
    if isinstance(value, str):
        raise reject("must be a list of axes", f'such as ["{value}"]')
    return value


def _faces(value: Any) -> Any:
    if isinstance(value, str):
        raise reject("must be a list of faces", f'such as ["{value}"]')
    return value


def _distinct_faces(value: tuple[Face, ...]) -> tuple[Face, ...]:
    if not value:
        raise reject("must not be empty", "leave it out for all faces, or name at least one")
    if len(set(value)) != len(value):
        raise reject("names a face twice", "name each face once")
    return value


def _not_zero(value: Sequence[float]) -> Sequence[float]:
    if any(abs(component) >= LEAST for component in value):
        return value
    if any(value):
        raise reject(f"is shorter than {LEAST:g}", "give a direction of any greater length")
    raise reject("must not be the zero vector", "give a direction of any length, such as [0, 1]")


def _axis_or_direction(value: Any) -> str | Sequence[float]:
    if not isinstance(value, str):
        return _not_zero(_vector_of(real)(value))
    if value in AXES:
        return value
    remedy = 'choose from "x", "y", "z", or give a direction such as [1, 0, 1]'
    raise reject("names no axis", remedy)


def _angular_velocity(value: Any) -> float | tuple[float, ...]:
    if (numbers := as_list(value)) is None:
        return real(value)
    if len(numbers) != 3:
        raise reject("must be a number in 2D, or a vector of three numbers in 3D")
    return tuple(real(each) for each in numbers)


Real = Annotated[float, PlainValidator(real)]
Positive = Annotated[float, PlainValidator(positive)]
NotNegative = Annotated[float, PlainValidator(_not_negative)]
Angle = Annotated[float, PlainValidator(_angle)]
Tolerance = Annotated[float, PlainValidator(_tolerance)]
Fraction = Annotated[float, PlainValidator(_fraction)]
Share = Annotated[float, PlainValidator(_share)]
Count = Annotated[int, PlainValidator(_count)]
CountOrZero = Annotated[int, PlainValidator(_count_or_zero)]
Flag = Annotated[bool, PlainValidator(_flag)]
Vector = Annotated[Sequence[float], PlainValidator(_vector_of(real))]
CountVector = Annotated[Sequence[int], PlainValidator(_vector_of(_count))]
WholeNumbers = Annotated[Sequence[int], PlainValidator(_whole_numbers)]
positive_per_direction = _per_direction_of(positive)
PositivePerDirection = Annotated[float | Sequence[float], PlainValidator(positive_per_direction)]
CountPerDirection = Annotated[int | Sequence[int], PlainValidator(_per_direction_of(_count))]
Direction = Annotated[Vector, AfterValidator(_not_zero)]
AxisOrDirection = Annotated[str | Sequence[float], PlainValidator(_axis_or_direction)]
AngularVelocity = Annotated[float | Sequence[float], PlainValidator(_angular_velocity)]
Displacement = Annotated[Mapping[Axis, Real], AfterValidator(some)]
Matrix = Annotated[Sequence[Sequence[float]], PlainValidator(_matrix)]
Tensor = Annotated[Sequence[Sequence[float]], PlainValidator(_tensor)]
Table = Annotated[Sequence[Sequence[float]], PlainValidator(_table)]
NumberOrTable = Annotated[float | Sequence[Sequence[float]], PlainValidator(number_or_table)]
NumberOrTablePerAxis = Annotated[
    float | Sequence[Sequence[float]] | Mapping[Axis, float | Sequence[Sequence[float]]],
    PlainValidator(_number_or_table_per_axis),
]
Profile = Annotated[Sequence[Sequence[float]], PlainValidator(_profile)]
Times = Annotated[Sequence[float], PlainValidator(_times)]


def _entries(value: Any) -> Any:
    if isinstance(value, Sequence) and len(value) > MOST_ENTRIES:
        raise reject(f"has {len(value):,} entries", f"give at most {MOST_ENTRIES:,}")
    return value


Entries = BeforeValidator(_entries)
"""Refuses too long a list of declarations before any of them is read."""

AsTuple = AfterValidator(tuple)
"""Stores a sequence of declarations as a tuple, so that a model is immutable."""

Components = Annotated[
    Sequence[Axis],
    BeforeValidator(_axes),
    AsTuple,
    AfterValidator(some),
    AfterValidator(_distinct),
]
Faces = Annotated[Sequence[Face], BeforeValidator(_faces), AsTuple, AfterValidator(_distinct_faces)]


def per_direction(value: float | Sequence[float], dimension: int) -> tuple[float, ...]:
    """Returns `value` for each direction, shape (dimension,): a single number is repeated."""
    if isinstance(value, Sequence):
        return tuple(value)
    return (value,) * dimension


def extent_problems(lower: Sequence[float], upper: Sequence[float]) -> list[Problem]:
    """Returns the problems of two opposite corners given as `lower` and `upper`."""
    if len(lower) != len(upper):
        what = f"has {len(lower)} components, but `upper` has {len(upper)}"
        return [Problem("lower", what, "give one per direction", lower)]
    if any(high <= low for low, high in zip(lower, upper, strict=True)):
        return [Problem("upper", "must exceed `lower` in every direction", value=upper)]
    return []


def starts_from_zero(table: Sequence[Sequence[float]] | None) -> list[Problem]:
    """Returns a problem if a motion would start with a jump at time 0."""
    if table is None or table[0][1] == 0.0:
        return []
    what = "a displacement starts from the undeformed state, so its first factor must be 0"
    return [Problem("factor", what, "start the table with [0, 0]", table)]
